/*
  The action of points' tangents by sum factorisation against sums over basis functions: products, transposed products
  and diagonal blocks of tangents of random numbers, on points at random places.

  Ranks: 1 3
*/
#include "scene.h"
#include "block.h"
#include "action/factored.h"
#include "particles/points.h"
#include "space/basis.h"

#define N_MOST (MPM_MAX_DIM * MPM_MAX_DIM)
#define TIMES  3 /* products: D, D^T, diagonal blocks */

static const char *const shapes[] = {"linear",
                                     "element -mpm_order 2",
                                     "element -mpm_order 3",
                                     "element -mpm_order 4",
                                     "gimp",
                                     "gimp_element -mpm_order 2",
                                     "bspline2",
                                     "bspline3",
                                     "gimp_bspline2"};

static PetscReal Random(void)
{
  return 2. * (PetscReal)rand() / (PetscReal)RAND_MAX - 1.;
}

static PetscErrorCode Scatter(MpmModel model)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt k = 0; k < points.count * model->disc.dim; k++) points.x[k] += 0.3 * Random();
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A random tangent, symmetric or not. */
static void FillTangent(PetscInt N, PetscBool symmetric, PetscReal D[])
{
  for (PetscInt k = 0; k < N; k++)
    for (PetscInt l = 0; l < N; l++) D[k * N + l] = symmetric && l < k ? D[l * N + k] : Random();
}

/* One point's part of D x, D^T x and the diagonal blocks, into to[0] to to[2]. */
static void AddPoint(const MpmSpace *space, const MpmGroup *group, const MpmBasis *basis, const PetscReal D[],
                     const PetscReal x[], PetscReal *const to[])
{
  const PetscInt  dim = space->dim, N = dim * dim;
  const PetscInt *nodes            = &space->group_nodes[group->node_offset];
  PetscReal       gradient[N_MOST] = {0.}, flux[2][N_MOST] = {{0.}};

  for (PetscInt k = 0; k < N; k++)
    for (PetscInt i = 0; i < group->node_count; i++)
      gradient[k] += MpmBasisAt(basis, 1 + k % dim, i) * x[nodes[i] * dim + k / dim];
  for (PetscInt k = 0; k < N; k++) {
    for (PetscInt l = 0; l < N; l++) {
      flux[0][k] += D[k * N + l] * gradient[l];
      flux[1][k] += D[l * N + k] * gradient[l];
    }
  }
  for (PetscInt i = 0; i < group->node_count; i++) {
    for (PetscInt k = 0; k < N; k++) {
      const PetscReal g = MpmBasisAt(basis, 1 + k % dim, i);

      for (PetscInt m = 0; m < 2; m++) to[m][nodes[i] * dim + k / dim] += g * flux[m][k];
      for (PetscInt l = 0; l < N; l++)
        to[2][nodes[i] * N + k / dim * dim + l / dim] += g * D[k * N + l] * MpmBasisAt(basis, 1 + l % dim, i);
    }
  }
}

/* All points: their tangents to the action, and what is expected of it. */
static PetscErrorCode Expect(const MpmSpace *space, PetscBool symmetric, const PetscReal x[], MpmFactored *factored,
                             PetscReal *const to[])
{
  const PetscInt N = space->dim * space->dim;
  MpmBasis       basis;

  PetscFunctionBeginUser;
  PetscCall(MpmBasisCreate(space, &basis));
  for (PetscInt g = 0; g < space->group_count; g++) {
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      PetscReal D[N_MOST * N_MOST];

      FillTangent(N, symmetric, D);
      ck_assert(MpmFactoredSetTangent(factored, s, D));
      MpmSpaceEvaluate(space, &space->groups[g], space->order[s], &basis);
      AddPoint(space, &space->groups[g], &basis, D, x, to);
    }
  }
  PetscCall(MpmBasisDestroy(&basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Differences between the action and what is expected, over the largest number. */
static PetscErrorCode Compare(const MpmSum *sum, PetscBool symmetric, PetscBool single, PetscReal difference[TIMES])
{
  const MpmSpace *space = sum->space;
  const PetscInt  dim = space->dim, size[TIMES] = {space->local * dim, space->local * dim, space->local * dim * dim};
  PetscReal      *x, *made[TIMES], *expected[TIMES];
  MpmFactored    *factored;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(size[0], &x));
  for (PetscInt k = 0; k < size[0]; k++) x[k] = Random();
  for (PetscInt m = 0; m < TIMES; m++) PetscCall(PetscCalloc2(size[m], &made[m], size[m], &expected[m]));
  PetscCall(MpmFactoredCreate(sum, symmetric, single, &factored));
  PetscCall(Expect(space, symmetric, x, factored, expected));
  MpmFactoredApply(factored, PETSC_FALSE, x, made[0]);
  MpmFactoredApply(factored, PETSC_TRUE, x, made[1]);
  MpmFactoredDiagonal(factored, made[2]);
  for (PetscInt m = 0; m < TIMES; m++) {
    PetscReal largest = PETSC_SMALL;

    difference[m] = 0.;
    for (PetscInt k = 0; k < size[m]; k++) {
      largest       = PetscMax(largest, PetscAbsReal(expected[m][k]));
      difference[m] = PetscMax(difference[m], PetscAbsReal(expected[m][k] - made[m][k]));
    }
    difference[m] /= largest;
    PetscCall(PetscFree2(made[m], expected[m]));
  }
  PetscCall(MpmFactoredDestroy(&factored));
  PetscCall(PetscFree(x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void CheckShape(PetscInt dim, const char *shape, const char *points)
{
  MpmModel model;

  SCENE_CALL(BlockCreate(dim, shape, BLOCK_DRY, points, &model));
  SCENE_CALL(Scatter(model));
  SCENE_CALL(SceneBegin(model, 0.25));
  ck_assert(MpmFactoredServes(model->disc.sum));
  for (PetscInt symmetric = 0; symmetric < 2; symmetric++) {
    PetscReal difference[TIMES];

    for (PetscInt single = 0; single < 2; single++) {
      SCENE_CALL(Compare(model->disc.sum, (PetscBool)symmetric, (PetscBool)single, difference));
      for (PetscInt m = 0; m < TIMES; m++)
        ck_assert_msg(difference[m] <= (single ? 1e-6 : 1e-13), "%dD %s, symmetric %d, product %d: off by %g", (int)dim,
                      shape, (int)symmetric, (int)m, (double)difference[m]);
    }
  }
  SCENE_CALL(SceneDestroy(&model));
}

/* Few points in a cell, whose lanes have boxes of their own, and so many that lanes share a box. */
START_TEST(all_shapes)
{
  for (PetscInt dim = 2; dim <= 3; dim++)
    for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(shapes); k++)
      CheckShape(dim, shapes[k], "-mpm_stabilization_fbar false -mpm_stabilization_filled 0");
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(shapes); k += 2)
    CheckShape(3, shapes[k],
               "-mpm_stabilization_fbar false -mpm_stabilization_filled 0 -mpm_body_b_points_per_cell 3,3,3 "
               "-mpm_body_b_upper 4,4,3");
}
END_TEST

/* A tangent that is not symmetric is refused where one triangle is kept; means over cells are for others. */
START_TEST(refusals)
{
  PetscReal    D[N_MOST * N_MOST];
  MpmFactored *factored;
  MpmModel     model;

  SCENE_CALL(BlockCreate(2, "gimp", BLOCK_DRY, "-mpm_stabilization_fbar false", &model));
  SCENE_CALL(SceneBegin(model, 0.25));
  SCENE_CALL(MpmFactoredCreate(model->disc.sum, PETSC_TRUE, PETSC_FALSE, &factored));
  FillTangent(4, PETSC_FALSE, D);
  ck_assert(model->disc.points->count == 0 || !MpmFactoredSetTangent(factored, 0, D));
  SCENE_CALL(MpmFactoredDestroy(&factored));
  SCENE_CALL(SceneDestroy(&model));
  SCENE_CALL(BlockCreate(2, "gimp", BLOCK_DRY, "-mpm_stabilization_fbar true", &model));
  SCENE_CALL(SceneBegin(model, 0.25));
  ck_assert(!MpmFactoredServes(model->disc.sum));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {all_shapes, refusals};

  return UnitRun(&argc, &argv, "factored", sizeof(tests) / sizeof(tests[0]), tests);
}
