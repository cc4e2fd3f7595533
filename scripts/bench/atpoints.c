/*
  Nanoseconds a point of the Jacobian's action without a matrix, and of products with the assembled one, on the points of
  a prepared step.

    bench_atpoints -options_file SCENE [-bench_rounds 5] [-bench_assembled true]

  rounds     times that each form is measured; the forms take turns
  assembled  the matrix, too; false where it is too large

  Lines on the terminal, for a program to read: a key and a number. Times are of the processor, s. `triad`, in bytes a
  second, is a = b + 3 c over arrays of 96 MB; `fma`, in operations a second, multiplies and adds in registers, in as many
  lanes as the action has.
*/
#include "particles/particles.h"
#include "particles/points.h"
#include "points/action.h"
#include "query/model.h"
#include "schedule/schedule.h"
#include "solve/solve.h"
#include "space/space.h"
#include "step/step.h"
#include "action/factored_impl.h"

#include <time.h>

#define BENCH_SAMPLE 0.1     /* s: a sample repeats what is shorter */
#define BENCH_TRIAD  4000000 /* numbers of an array */
#define BENCH_FMA    4000000
#define BENCH_CHAINS 10 /* independent ones: an operation takes four cycles, two start in each */

typedef struct {
  MpmModel   model;
  PetscInt   rounds;
  PetscBool  assembled;
  Mat        baij;
  Vec        x, y;
  MpmAction  stored, direct;
  PetscReal *du, *to;
} Bench;

/* Seconds of this process. */
static PetscReal Now(void)
{
  struct timespec time;

  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return (PetscReal)time.tv_sec + 1e-9 * (PetscReal)time.tv_nsec;
}

static PetscErrorCode Print(const char *key, PetscReal value)
{
  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "%s %.6g\n", key, (double)value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the machine ---- */

static PetscErrorCode PrintTriad(void)
{
  PetscReal *a, *b, *c, begin;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(BENCH_TRIAD, &a, BENCH_TRIAD, &b, BENCH_TRIAD, &c));
  for (PetscInt k = 0; k < BENCH_TRIAD; k++) {
    a[k] = 0.;
    b[k] = (PetscReal)k;
    c[k] = 1.;
  }
  begin = Now();
  for (PetscInt k = 0; k < BENCH_TRIAD; k++) a[k] = b[k] + 3. * c[k];
  PetscCall(Print("triad", 24. * BENCH_TRIAD / (Now() - begin)));
  if (a[7] != 10.) PetscCall(PetscPrintf(PETSC_COMM_WORLD, "nothing was computed\n"));
  PetscCall(PetscFree3(a, b, c));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintFma(void)
{
  Lane       sum[BENCH_CHAINS];
  const Lane factor = 0.999999 - (Lane){0.}, term = 1e-7 - (Lane){0.};
  PetscReal  begin = Now(), total = 0.;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < BENCH_CHAINS; k++) sum[k] = 1e-9 * (PetscReal)k - (Lane){0.};
  for (PetscInt i = 0; i < BENCH_FMA; i++)
    for (PetscInt k = 0; k < BENCH_CHAINS; k++) sum[k] = sum[k] * factor + term;
  PetscCall(Print("fma", 2. * BENCH_FMA * BENCH_CHAINS * MPM_LANES / (Now() - begin)));
  for (PetscInt k = 0; k < BENCH_CHAINS; k++) total += sum[k][0];
  if (total == 0.) PetscCall(PetscPrintf(PETSC_COMM_WORLD, "nothing was computed\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- forms of the product ---- */

static PetscErrorCode Stored(Bench *bench)
{
  PetscInt failed = 0;

  return MpmActionApplyPoints(&bench->stored, bench->du, bench->to, &failed);
}

static PetscErrorCode Direct(Bench *bench)
{
  PetscInt failed = 0;

  return MpmActionApplyPoints(&bench->direct, bench->du, bench->to, &failed);
}

static PetscErrorCode Product(Bench *bench)
{
  return MatMult(bench->baij, bench->x, bench->y);
}

static PetscErrorCode SetState(Bench *bench)
{
  PetscInt failed;

  return MpmActionSetState(&bench->stored, bench->du, &failed);
}

static PetscErrorCode SetUp(Bench *bench)
{
  PetscFunctionBeginUser;
  PetscCall(MpmActionDestroy(&bench->stored));
  PetscCall(MpmActionCreate(bench->model->disc.terms, bench->model->disc.sum, PETSC_TRUE, PETSC_FALSE, &bench->stored));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Assemble(Bench *bench)
{
  Mat A = bench->model->solver.jacobian.assembled;

  return SNESComputeJacobian(bench->model->solver.snes, bench->x, A, A);
}

typedef struct {
  const char *key;
  PetscErrorCode (*call)(Bench *bench);
  PetscBool of_matrix;
} Form;
static const Form forms[] = {{"set_up", SetUp, PETSC_FALSE},     {"tangents", SetState, PETSC_FALSE},
                             {"stored", Stored, PETSC_FALSE},    {"direct", Direct, PETSC_FALSE},
                             {"assembly", Assemble, PETSC_TRUE}, {"baij", Product, PETSC_TRUE}};
#define FORM_COUNT ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(forms))

static PetscErrorCode Sample(Bench *bench, const Form *form)
{
  const PetscReal begin = Now();
  PetscReal       end   = begin;
  PetscInt        count = 0;

  PetscFunctionBeginUser;
  for (; count == 0 || end - begin < BENCH_SAMPLE; count++) {
    PetscCall(form->call(bench));
    end = Now();
  }
  PetscCall(Print(form->key, (end - begin) / (PetscReal)count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The difference of both products of a vector, over its largest number. */
static PetscErrorCode PrintDifference(Bench *bench)
{
  const PetscInt count      = bench->model->disc.space->local * bench->model->disc.block;
  PetscReal      difference = 0., largest = 0., *other;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(count, &other));
  PetscCall(PetscArrayzero(bench->to, count));
  PetscCall(Direct(bench));
  PetscCall(PetscArraycpy(other, bench->to, count));
  PetscCall(PetscArrayzero(bench->to, count));
  PetscCall(Stored(bench));
  for (PetscInt k = 0; k < count; k++) {
    difference = PetscMax(difference, PetscAbsReal(other[k] - bench->to[k]));
    largest    = PetscMax(largest, PetscAbsReal(other[k]));
  }
  PetscCall(Print("difference", difference / largest));
  PetscCall(PetscFree(other));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The least that a product takes in 3D with symmetric tangents, of all points by the nodes that each touches: sums along
  three axes and back, the tangent, and the numbers that are read.
*/
static PetscErrorCode PrintCounts(const MpmSpace *space)
{
  PetscReal operations = 0., bytes = 0.;

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group  = &space->groups[g];
    const PetscReal points = (PetscReal)(group->point_end - group->point_begin), x = (PetscReal)group->count[0],
                    y = (PetscReal)group->count[1], z = (PetscReal)group->count[2];

    operations += points * 2. * (2. * (6. * x * y * z + 9. * y * z + 9. * z) + 81.);
    bytes += points * (45. + 2. * (x + y + z)) * sizeof(PetscReal);
  }
  PetscCall(Print("operations", operations));
  PetscCall(Print("bytes", bytes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PrintMemory(Bench *bench)
{
  MatInfo info;

  PetscFunctionBeginUser;
  PetscCall(Print("stored_bytes", bench->stored.factored ? (PetscReal)MpmFactoredBytes(bench->stored.factored) : 0.));
  if (!bench->assembled) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetInfo(bench->model->solver.jacobian.assembled, MAT_LOCAL, &info));
  PetscCall(Print("assembled_bytes", info.nz_used * (sizeof(PetscScalar) + sizeof(PetscInt))));
  PetscCall(MatGetInfo(bench->baij, MAT_LOCAL, &info));
  PetscCall(Print("baij_bytes", info.nz_used * (sizeof(PetscScalar) +
                                                sizeof(PetscInt) / PetscSqr((PetscReal)bench->model->disc.block))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the step ---- */

/* The program's own options, which a scene has not. */
static PetscErrorCode ReadOptions(Bench *bench)
{
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsGetInt(NULL, NULL, "-bench_rounds", &bench->rounds, NULL));
  PetscCall(PetscOptionsGetBool(NULL, NULL, "-bench_assembled", &bench->assembled, NULL));
  PetscCall(PetscOptionsClearValue(NULL, "-bench_rounds"));
  PetscCall(PetscOptionsClearValue(NULL, "-bench_assembled"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateModel(Bench *bench)
{
  MpmOutcome outcome;

  PetscFunctionBeginUser;
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, &bench->model));
  PetscCall(MpmModelUseTerminal(bench->model));
  PetscCall(MpmModelSetFromOptions(bench->model));
  PetscCall(MpmModelSetUp(bench->model));
  PetscCall(MpmParticlesMigrate(bench->model->state.particles, bench->model->disc.grid));
  PetscCall(MpmStepPrepare(bench->model, bench->model->state.dt.nominal, bench->model->state.dt.nominal, PETSC_FALSE,
                           &outcome));
  PetscCheck(!outcome.code, bench->model->comm, PETSC_ERR_PLIB, "%s", outcome.text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A displacement of hundredths of a cell, other at every node. */
static PetscErrorCode CreateVectors(Bench *bench)
{
  const MpmDiscretization *disc  = &bench->model->disc;
  const PetscInt           count = disc->space->local * disc->block;
  PetscScalar             *values;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(bench->model->solver.x, &bench->x));
  PetscCall(VecDuplicate(bench->model->solver.x, &bench->y));
  PetscCall(PetscCalloc2(count, &bench->du, count, &bench->to));
  for (PetscInt k = 0; k < count; k++) bench->du[k] = 0.01 * disc->h[0] * PetscSinReal(1.7 * (PetscReal)k);
  PetscCall(VecGetArrayWrite(bench->x, &values));
  PetscCall(PetscArraycpy(values, bench->du, disc->space->owned * disc->block));
  PetscCall(VecRestoreArrayWrite(bench->x, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Measure(Bench *bench)
{
  MpmDiscretization *disc = &bench->model->disc;
  PetscInt           failed;

  PetscFunctionBeginUser;
  PetscCall(CreateVectors(bench));
  PetscCall(Print("points", (PetscReal)disc->points->count));
  PetscCall(Print("unknowns", (PetscReal)(disc->space->owned * disc->block)));
  PetscCall(PrintCounts(disc->space));
  PetscCall(MpmActionCreate(disc->terms, disc->sum, PETSC_TRUE, PETSC_FALSE, &bench->stored));
  PetscCall(MpmActionSetState(&bench->stored, bench->du, &failed));
  PetscCall(MpmActionCreate(disc->terms, disc->sum, PETSC_FALSE, PETSC_FALSE, &bench->direct));
  PetscCall(MpmActionSetState(&bench->direct, bench->du, &failed));
  PetscCall(PrintDifference(bench));
  if (bench->assembled) {
    PetscCall(Assemble(bench));
    PetscCall(MatConvert(bench->model->solver.jacobian.assembled, MATBAIJ, MAT_INITIAL_MATRIX, &bench->baij));
  }
  for (PetscInt round = 0; round < bench->rounds; round++) {
    PetscCall(PrintTriad());
    PetscCall(PrintFma());
    for (PetscInt k = 0; k < FORM_COUNT; k++)
      if (!forms[k].of_matrix || bench->assembled) PetscCall(Sample(bench, &forms[k]));
  }
  PetscCall(PrintMemory(bench));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv)
{
  Bench bench = {.rounds = 5, .assembled = PETSC_TRUE};

  PetscCall(PetscInitialize(&argc, &argv, NULL, "bench_atpoints -options_file SCENE\n"));
  PetscCall(ReadOptions(&bench));
  PetscCall(CreateModel(&bench));
  PetscCall(Measure(&bench));
  PetscCall(MpmActionDestroy(&bench.stored));
  PetscCall(MpmActionDestroy(&bench.direct));
  PetscCall(MatDestroy(&bench.baij));
  PetscCall(VecDestroy(&bench.x));
  PetscCall(VecDestroy(&bench.y));
  PetscCall(PetscFree2(bench.du, bench.to));
  PetscCall(MpmModelDestroy(&bench.model));
  PetscCall(PetscFinalize());
  return 0;
}
