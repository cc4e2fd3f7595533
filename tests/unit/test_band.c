/*
  The band solver: right answers on any shape and number of ranks, narrow orders where shapes are narrow, and MUMPS for
  other shapes or where the matrix is not positive definite.

  Ranks: 1 2 3 4
*/
#include "precondition/pc_band.h"
#include "scene.h"

#define BS    2
#define REACH 2

/* Nodes of a lattice that belong to the body. Ranks have adjacent columns, and number their nodes out of order. */
typedef struct {
  PetscInt nx, ny;
  PetscBool (*has)(PetscInt i, PetscInt j);
  PetscBool one_rank; /* all nodes on the last rank */
} Body;

static PetscBool Strip(PetscInt i, PetscInt j)
{
  (void)i;
  return (PetscBool)(j < 6);
}
static PetscBool Slanted(PetscInt i, PetscInt j)
{
  return (PetscBool)(PetscAbsInt(i - j) < 7);
}
static PetscBool Ring(PetscInt i, PetscInt j)
{
  const PetscReal r = PetscSqrtReal(PetscSqr((PetscReal)i - 20.) + PetscSqr((PetscReal)j - 20.));

  return (PetscBool)(r > 14. && r < 19.);
}
static PetscBool Two(PetscInt i, PetscInt j)
{
  return (PetscBool)((j < 5 && i > 3) || (j > 12 && j < 17 && i < 44));
}
static PetscBool Square(PetscInt i, PetscInt j)
{
  (void)i;
  (void)j;
  return PETSC_TRUE;
}

static PetscMPIInt my_rank, rank_count;

/* Another number of the same rank: in strides of 37, a prime that divides no rank's count here. */
static PetscInt Shuffle(const Body *body, PetscInt total, PetscInt number)
{
  PetscInt begin = 0, end = total;

  if (number < 0) return number;
  for (PetscMPIInt r = 0; r < rank_count && !body->one_rank; r++) {
    begin = total * r / rank_count;
    end   = total * (r + 1) / rank_count;
    if (number < end) break;
  }
  ck_assert((end - begin) % 37);
  return begin + (number - begin) * 37 % (end - begin);
}

/* The number of each lattice node, or -1; and this rank's part. */
static PetscErrorCode Number(const Body *body, PetscInt number[], PetscInt *begin, PetscInt *end)
{
  PetscInt total = 0;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < body->nx; i++)
    for (PetscInt j = 0; j < body->ny; j++) number[i * body->ny + j] = body->has(i, j) ? total++ : -1;
  if (body->one_rank) {
    *end   = total;
    *begin = my_rank == rank_count - 1 ? 0 : total;
    if (my_rank < rank_count - 1) *begin = *end = 0;
  } else {
    *begin = total * my_rank / rank_count;
    *end   = total * (my_rank + 1) / rank_count;
  }
  for (PetscInt at = 0; at < body->nx * body->ny; at++) number[at] = Shuffle(body, total, number[at]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A symmetric matrix with blocks between nodes up to REACH apart; `excess` of its diagonal over the other entries. */
static PetscErrorCode Assemble(const Body *body, PetscReal excess, Mat *A)
{
  PetscInt *number, begin, end;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((body->nx * body->ny), &number));
  PetscCall(Number(body, number, &begin, &end));
  if (!*A) {
    PetscCall(MatCreate(PETSC_COMM_WORLD, A));
    PetscCall(MatSetSizes(*A, (end - begin) * BS, (end - begin) * BS, PETSC_DETERMINE, PETSC_DETERMINE));
    PetscCall(MatSetBlockSize(*A, BS));
    PetscCall(MatSetType(*A, MATAIJ));
    PetscCall(MatSeqAIJSetPreallocation(*A, 25 * BS, NULL));
    PetscCall(MatMPIAIJSetPreallocation(*A, 25 * BS, NULL, 25 * BS, NULL));
  }
  for (PetscInt at = 0; at < body->nx * body->ny; at++) {
    const PetscInt i = at / body->ny, j = at % body->ny, node = number[at];

    if (node < begin || node >= end) continue;
    for (PetscInt c = 0; c < BS; c++) {
      const PetscInt row = node * BS + c;
      PetscReal      sum = 0.;

      for (PetscInt k = PetscMax(i - REACH, 0); k <= PetscMin(i + REACH, body->nx - 1); k++) {
        for (PetscInt l = PetscMax(j - REACH, 0); l <= PetscMin(j + REACH, body->ny - 1); l++) {
          for (PetscInt d = 0; d < BS && number[k * body->ny + l] >= 0; d++) {
            const PetscInt  column = number[k * body->ny + l] * BS + d;
            const PetscInt  one = at * BS + c, other = (k * body->ny + l) * BS + d; /* whatever the numbers */
            const PetscReal value = SceneRandom(1, PetscMin(one, other), PetscMax(one, other));

            if (column == row) continue;
            sum += PetscAbsReal(value);
            PetscCall(MatSetValue(*A, row, column, value, INSERT_VALUES));
          }
        }
      }
      PetscCall(MatSetValue(*A, row, row, sum * excess, INSERT_VALUES));
    }
  }
  PetscCall(MatAssemblyBegin(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(*A, MAT_FINAL_ASSEMBLY));
  PetscCall(PetscFree(number));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The residual of one application, relative. */
static PetscErrorCode Residual(PC pc, Mat A, PetscReal *residual)
{
  Vec       x, b, r;
  PetscInt  begin, end;
  PetscReal norm;

  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(A, &x, &b));
  PetscCall(VecDuplicate(b, &r));
  PetscCall(VecGetOwnershipRange(b, &begin, &end));
  for (PetscInt i = begin; i < end; i++) PetscCall(VecSetValue(b, i, SceneRandom(2, i, 0), INSERT_VALUES));
  PetscCall(VecAssemblyBegin(b));
  PetscCall(VecAssemblyEnd(b));
  PetscCall(PCSetOperators(pc, A, A));
  PetscCall(PCSetUp(pc));
  PetscCall(PCApply(pc, b, x));
  PetscCall(MatMult(A, x, r));
  PetscCall(VecAXPY(r, -1., b));
  PetscCall(VecNorm(b, NORM_2, &norm));
  PetscCall(VecNorm(r, NORM_2, residual));
  *residual /= norm;
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&b));
  PetscCall(VecDestroy(&r));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves with a positive definite matrix, an indefinite one of the same pattern, and the first one again. */
static void Check(const char *name, Body body, PetscBool fits, PetscInt widest)
{
  const PetscReal excess[] = {1.1, 0.05, 1.1};
  Mat             A        = NULL;
  PC              pc;
  MpmBandOrder    order;
  PetscBool       is;

  SCENE_CALL(PCCreate(PETSC_COMM_WORLD, &pc));
  SCENE_CALL(PCSetType(pc, "band"));
  SCENE_CALL(MpmBandIs(pc, &is));
  ck_assert(is);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(excess); k++) {
    PetscReal residual;

    SCENE_CALL(Assemble(&body, excess[k], &A));
    SCENE_CALL(Residual(pc, A, &residual));
    ck_assert_msg(residual < 1e-10, "%s, diagonal of %g: residual %g", name, (double)excess[k], (double)residual);
  }
  SCENE_CALL(MpmBandOrderCreate(A, &order));
  ck_assert_msg(order.fits == fits, "%s: fits %d", name, (int)order.fits);
  ck_assert_msg(SceneAll((PetscBool)(!fits || order.width <= widest)), "%s: half bandwidth %d", name, (int)order.width);
  SCENE_CALL(MpmBandOrderDestroy(&order));
  SCENE_CALL(PCDestroy(&pc));
  SCENE_CALL(MatDestroy(&A));
}

/*
  A strip of six nodes across needs a half bandwidth of REACH * 6 * BS and some; a rank between two others is walked
  through from both sides and needs twice that.
*/
START_TEST(shapes)
{
  SCENE_CALL(MpmBandRegister());
  SCENE_CALL(PetscOptionsSetValue(NULL, "-mat_mumps_icntl_14", "100")); /* room for pivots */
  SCENE_CALL(MPI_Comm_rank(PETSC_COMM_WORLD, &my_rank));
  SCENE_CALL(MPI_Comm_size(PETSC_COMM_WORLD, &rank_count));
  Check("strip", (Body){.nx = 120, .ny = 8, .has = Strip}, PETSC_TRUE, rank_count > 2 ? 72 : 36);
  Check("slanted", (Body){.nx = 70, .ny = 70, .has = Slanted}, PETSC_TRUE, rank_count > 2 ? 160 : 80);
  Check("ring", (Body){.nx = 41, .ny = 41, .has = Ring}, PETSC_TRUE, 160);
  Check("two", (Body){.nx = 50, .ny = 18, .has = Two}, PETSC_TRUE, 130);
}
END_TEST

START_TEST(empty_ranks)
{
  Check("one rank", (Body){.nx = 60, .ny = 8, .has = Strip, .one_rank = PETSC_TRUE}, PETSC_TRUE, 36);
}
END_TEST

START_TEST(wide)
{
  Check("square", (Body){.nx = 96, .ny = 96, .has = Square}, PETSC_FALSE, 0);
}
END_TEST

/* A failed factorisation of MUMPS, of a matrix of zeros, and an indefinite matrix of equal pattern afterwards. */
START_TEST(singular)
{
  const Body     body = {.nx = 40, .ny = 8, .has = Strip};
  Mat            A    = NULL;
  PC             pc;
  PCFailedReason reason;
  PetscReal      residual;

  SCENE_CALL(PCCreate(PETSC_COMM_WORLD, &pc));
  SCENE_CALL(PCSetType(pc, "band"));
  SCENE_CALL(PCSetErrorIfFailure(pc, PETSC_FALSE));
  SCENE_CALL(Assemble(&body, 1.1, &A));
  SCENE_CALL(MatZeroEntries(A));
  SCENE_CALL(PCSetOperators(pc, A, A));
  SCENE_CALL(PCSetUp(pc));
  SCENE_CALL(PCGetFailedReason(pc, &reason));
  ck_assert(reason != PC_NOERROR);
  SCENE_CALL(Assemble(&body, 0.05, &A));
  SCENE_CALL(Residual(pc, A, &residual));
  ck_assert_msg(residual < 1e-10, "after a failure: residual %g", (double)residual);
  SCENE_CALL(PCGetFailedReason(pc, &reason));
  ck_assert(reason == PC_NOERROR);
  SCENE_CALL(PCDestroy(&pc));
  SCENE_CALL(MatDestroy(&A));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {shapes, empty_ranks, wide, singular};

  return UnitRun(&argc, &argv, "band", sizeof(tests) / sizeof(tests[0]), tests);
}
