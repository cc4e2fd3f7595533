/*
  Spaces beside that of a step, over the same points: splines of degree 2 and 3 on its lattice and, on one rank, on one
  of half as many cells. Each integrates the points' mass and the work of their stress, and evaluates linear fields, to
  rounding; the step's space and residual do not change.

  Ranks: 1 3
*/
#include "assembly/terms.h"
#include "particles/point_mass.h"
#include "problem/evaluation.h"
#include "space/rules.h"
#include "transfer/motion.h"
#include "scene.h"

#define SCENE \
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 4,4 -mpm_grid_cells 8,8 -mpm_bodies b -mpm_body_b_region box " \
  "-mpm_body_b_lower 1.2,1.1 -mpm_body_b_upper 2.9,2.8 -mpm_body_b_material m -mpm_materials m -mpm_shape gimp " \
  "-mpm_material_m_type neo_hookean -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 -mpm_material_m_density 10 " \
  "-mpm_time_step 0.1 -mpm_time_end 1 -mpm_stabilization_fbar false -mpm_solver direct -mpm_quiet "

/* A space with all that belongs to it. */
typedef struct {
  MpmGrid  grid;
  MpmSpace space;
  MpmSum   sum;
} Side;

/* A space of the model's points with another shape, on a lattice of so many cells an axis. */
static PetscErrorCode Create(MpmModel model, MpmShapeType shape, PetscInt cells, Side *side)
{
  MpmRules   rules = {.grid           = &side->grid,
                      .shape          = shape,
                      .layout         = model->disc.layout,
                      .stretch        = model->scene.deformation.stretch,
                      .materials      = model->disc.sum->materials,
                      .material_count = model->disc.material.count};
  MpmOutcome outcome;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(&side->space, sizeof(side->space)));
  side->grid = *model->disc.grid;
  for (PetscInt a = 0; a < 2; a++) {
    side->grid.cells[a] = cells;
    side->grid.nodes[a] = cells + 1;
    side->grid.h[a] = side->grid.start_h[a] = (side->grid.upper[a] - side->grid.lower[a]) / (PetscReal)cells;
  }
  PetscCall(MpmSpaceBegin(&side->space, &rules, model->disc.points, &outcome));
  PetscCheck(!outcome.code, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "%s", outcome.text);
  PetscCall(MpmSpaceEnd(&side->space, &rules));
  side->sum       = *model->disc.sum;
  side->sum.grid  = &side->grid;
  side->sum.cell  = side->grid.h;
  side->sum.space = &side->space;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Total(PetscReal *value)
{
  PetscFunctionBeginUser;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, value, 1, MPIU_REAL, MPIU_SUM, PETSC_COMM_WORLD));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sum of the consistent mass matrix of a space, kg. */
static PetscErrorCode Mass(const MpmSum *sum, PetscReal *total)
{
  MpmMassMatrix mass = {0};

  PetscFunctionBeginUser;
  PetscCall(MpmMassMatrixSetUp(&mass, sum));
  *total = 0.;
  for (PetscInt k = 0; k < mass.start[mass.nodes]; k++) *total += mass.value[k];
  PetscCall(MpmMassMatrixReset(&mass));
  PetscCall(Total(total));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where local node i stands. */
static PetscReal Place(const MpmSum *sum, PetscInt i, PetscInt axis)
{
  PetscInt at[MPM_MAX_DIM];

  MpmSpaceAt(sum->space, &sum->space->node[i * 2], at);
  return sum->grid->lower[axis] + sum->grid->h[axis] * (PetscReal)at[axis];
}

/* A linear field of displacements at the local nodes. */
static PetscErrorCode Linear(const MpmSum *sum, PetscReal **u)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((sum->space->local * 2 + 1), u));
  for (PetscInt i = 0; i < sum->space->local; i++) {
    const PetscReal x = Place(sum, i, 0), y = Place(sum, i, 1);

    (*u)[i * 2]     = 0.02 * x - 0.01 * y + 0.003;
    (*u)[i * 2 + 1] = 0.005 * x + 0.015 * y - 0.001;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest error of the points' displacements in that field, m, and the work of their stresses in it, J. */
static PetscErrorCode Field(MpmModel model, const MpmSum *sum, PetscReal *error, PetscReal *work)
{
  const MpmPoints *points = model->disc.points;
  PetscInt         failed = 0;
  PetscReal       *u, *moves, *force;

  PetscFunctionBeginUser;
  PetscCall(Linear(sum, &u));
  PetscCall(PetscCalloc2((points->count * 2), &moves, (sum->space->local * 2), &force));
  PetscCall(MpmDisplacementsAtPoints(sum, u, moves));
  *error = *work = 0.;
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal x = points->x[p * 2], y = points->x[p * 2 + 1];

    *error = PetscMax(*error, PetscAbsReal(moves[p * 2] - (0.02 * x - 0.01 * y + 0.003)));
    *error = PetscMax(*error, PetscAbsReal(moves[p * 2 + 1] - (0.005 * x + 0.015 * y - 0.001)));
  }
  PetscCall(MpmTermsResidualPoints(model->disc.terms, sum, u, NULL, force, &failed));
  ck_assert_int_eq(failed, 0);
  for (PetscInt k = 0; k < sum->space->local * 2; k++) *work += force[k] * u[k];
  PetscCall(PetscFree2(moves, force));
  PetscCall(PetscFree(u));
  PetscCall(Total(work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points' mass, kg. */
static PetscErrorCode PointsMass(MpmModel model, PetscReal *total)
{
  PetscFunctionBeginUser;
  *total = 0.;
  for (PetscInt p = 0; p < model->disc.points->count; p++)
    *total += MpmPointMass(model->disc.points, model->disc.sum->materials, p);
  PetscCall(Total(total));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step up to Newton, of points that have moved before, and its residual. */
static PetscErrorCode Begin(MpmModel *model, MpmEvaluated *result)
{
  const PetscReal amplitude[] = {0.02, 0.02};

  PetscFunctionBeginUser;
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, SCENE, model));
  PetscCall(SceneBegin(*model, 0.1));
  PetscCall(SceneFill(*model, 3, amplitude, PETSC_FALSE, (*model)->solver.x));
  PetscCall(SceneCommit(*model, (*model)->solver.x));
  PetscCall(SceneBegin(*model, 0.1));
  PetscCall(SceneFill(*model, 1, amplitude, PETSC_FALSE, (*model)->solver.x));
  PetscCall(VecDuplicate((*model)->solver.x, &result->f));
  PetscCall(MpmEvaluateResidual(&(*model)->disc, MpmEvaluationAt(&(*model)->disc, (*model)->solver.x), result));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Another space against the step's own. */
static PetscErrorCode Look(MpmModel model, MpmShapeType shape, PetscInt cells)
{
  Side      side;
  PetscReal mass[3], error[2], work[2];

  PetscFunctionBeginUser;
  PetscCall(Create(model, shape, cells, &side));
  PetscCall(PointsMass(model, &mass[0]));
  PetscCall(Mass(model->disc.sum, &mass[1]));
  PetscCall(Mass(&side.sum, &mass[2]));
  PetscCall(Field(model, model->disc.sum, &error[0], &work[0]));
  PetscCall(Field(model, &side.sum, &error[1], &work[1]));
  for (PetscInt k = 1; k < 3; k++)
    ck_assert_msg(SceneAll((PetscBool)(PetscAbsReal(mass[k] / mass[0] - 1.) <= 1e-13)), "%d cells: mass %.16g of %.16g",
                  (int)cells, (double)mass[k], (double)mass[0]);
  for (PetscInt k = 0; k < 2; k++)
    ck_assert_msg(SceneAll((PetscBool)(error[k] <= 1e-14)), "%d cells: a linear field is off by %g", (int)cells,
                  (double)error[k]);
  ck_assert_msg(SceneAll((PetscBool)(PetscAbsReal(work[1] / work[0] - 1.) <= 1e-12)), "%d cells: work %.16g of %.16g",
                (int)cells, (double)work[1], (double)work[0]);
  if (cells < model->disc.grid->cells[0]) ck_assert_int_lt(side.space.number.count, MpmNodesTotal(&model->disc));
  PetscCall(MpmSpaceReset(&side.space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(beside)
{
  MpmModel     model;
  MpmEvaluated before = {NULL}, after = {NULL};
  PetscBool    same = PETSC_FALSE;

  SCENE_CALL(Begin(&model, &before));
  SCENE_CALL(Look(model, MPM_SHAPE_BSPLINE2, 8));
  SCENE_CALL(Look(model, MPM_SHAPE_BSPLINE3, 8));
  if (model->size == 1) SCENE_CALL(Look(model, MPM_SHAPE_GIMP, 4)); /* splits of ranks are those of one lattice */
  SCENE_CALL(VecDuplicate(before.f, &after.f));
  SCENE_CALL(MpmEvaluateResidual(&model->disc, MpmEvaluationAt(&model->disc, model->solver.x), &after));
  SCENE_CALL(VecEqual(before.f, after.f, &same));
  ck_assert(same);
  SCENE_CALL(VecDestroy(&before.f));
  SCENE_CALL(VecDestroy(&after.f));
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {beside};

  return UnitRun(&argc, &argv, "spaces", sizeof(tests) / sizeof(tests[0]), tests);
}
