/*
  Strength reduction: a stage divides every strength of every material by a factor F of its time.

    stage_fail: {reduction: "0:1,1:2", time: {end: 1, step: 0.02}}

  Which parameters are strengths the law's table says (MPM_STRENGTH, MPM_STRENGTH_ANGLE; of angles it is the tangent that
  is divided); all others, elasticity among them, stay. So do F and history of the points: the return of the next step
  brings the stress to the smaller yield surface, and Newton's method the forces into balance again.

  Parameters belong to the time of a step's end. Apply() sets them when a step is tried, and again for the step's start
  when it is rolled back. In stages without a reduction F is 1.

  The factor of safety is F when the first point has moved `reduction_limit` times the slope's height since its stage
  began: between the ends of two steps, in proportion to the longest ways. Where the points stood as the stage began
  travels with them and stands in checkpoints.

  Order of calls: Begin() once its bodies are there, Observe() after each of its steps.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "point/material.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "terms/load.h"
#include "time/model.h"
#include "time/time.h"

const char *const MpmReductionFields[MPM_MAX_DIM] = {"reduction_start_x", "reduction_start_y", "reduction_start_z"};

PetscBool MpmStagesReduce(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stage_count; k++)
    if (model->scene.stages[k].reduction.ramp) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmReductionSeeks(const MpmModel model)
{
  return (PetscBool)(model->scene.stages[model->state.stage].reduction.ramp && !(model->state.safety.factor > 0.));
}

/* ---- the factor ---- */

PetscReal MpmReductionFactor(const MpmModel model, PetscReal time)
{
  const MpmRamp ramp = model->scene.stages[model->state.stage].reduction.ramp;

  return ramp ? MpmRampEvaluate(ramp, time - model->state.time_start) : 1.;
}

PetscErrorCode MpmReductionApply(MpmModel model, PetscReal time)
{
  const PetscReal factor = MpmReductionFactor(model, time);

  PetscFunctionBeginUser;
  if (!MpmStagesReduce(model)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    MpmMaterialReduce(&model->scene.materials->at[m], factor);
  PetscCall(MpmModelSetOwn(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetOwn(MpmModel model)
{
  PetscInt  vertical[2];
  MpmPoints points;

  PetscFunctionBeginUser;
  if (!MpmParticlesHaveField(model->state.particles, "parameter")) PetscFunctionReturn(PETSC_SUCCESS);
  MpmLoadsGetVertical(model->scene.loads, model->disc.dim, &vertical[0], &vertical[1]);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  MpmPointsSetOwn(model->scene.materials->at, vertical, model->disc.dim, 0, points.count, &points);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the factor of safety ---- */

/* The highest and the lowest place of the material against gravity, and its highest place in each column of cells. */
static PetscErrorCode FindTops(MpmModel model, const MpmPoints *points, PetscReal reach[2], PetscReal top[])
{
  const PetscInt *cells = model->disc.grid->cells, dim = model->disc.dim;
  PetscReal       U[MPM_MAX_DIM];
  PetscInt        axis, up, cell[MPM_MAX_DIM] = {0, 0, 0};

  PetscFunctionBeginUser;
  MpmLoadsGetVertical(model->scene.loads, dim, &axis, &up);
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal y = points->x[p * dim + axis] * (PetscReal)up;
    PetscReal       half, *highest;

    PetscCheck(!model->scene.stretch(&points->F[p * dim * dim], U), PETSC_COMM_SELF, PETSC_ERR_FP,
               "point %" PetscInt_FMT " has no stretch", points->id[p]);
    half     = points->half_length[p * dim + axis] * U[axis];
    reach[0] = PetscMax(reach[0], y + half);
    reach[1] = PetscMax(reach[1], half - y);
    MpmGridFindCell(model->disc.grid, &points->x[p * dim], cell);
    cell[axis] = 0;
    highest    = &top[(cell[2] * (axis == 1 ? 1 : cells[1]) + cell[1]) * (axis == 0 ? 1 : cells[0]) + cell[0]];
    *highest   = PetscMax(*highest, y + half);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The height of the slope: from the lowest to the highest ground, of all columns of cells that hold material. Where the
  ground is level, to a fifth of the material's height, that height instead.
*/
static PetscErrorCode FindHeight(MpmModel model, const MpmPoints *points, PetscReal *height)
{
  const PetscInt *cells    = model->disc.grid->cells;
  PetscReal       reach[2] = {PETSC_NINFINITY, PETSC_NINFINITY}, lowest = PETSC_INFINITY, *top;
  PetscInt        axis, up, count;

  PetscFunctionBeginUser;
  MpmLoadsGetVertical(model->scene.loads, model->disc.dim, &axis, &up);
  count = cells[0] * cells[1] * cells[2] / cells[axis];
  PetscCall(PetscMalloc1(count, &top));
  for (PetscInt c = 0; c < count; c++) top[c] = PETSC_NINFINITY;
  PetscCall(FindTops(model, points, reach, top));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, 2, MPIU_REAL, MPIU_MAX, model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, top, (PetscMPIInt)count, MPIU_REAL, MPIU_MAX, model->comm));
  for (PetscInt c = 0; c < count; c++)
    if (top[c] > PETSC_NINFINITY) lowest = PetscMin(lowest, top[c]);
  PetscCall(PetscFree(top));
  *height = reach[0] + reach[1];
  if (reach[0] - lowest > 0.2 * *height) *height = reach[0] - lowest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the points stand as the stage begins, into their fields; or with `moved` the square of their way from there. */
static PetscErrorCode EachAxis(MpmModel model, const MpmPoints *points, PetscReal moved[])
{
  const PetscInt dim = model->disc.dim;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal *start;

    PetscCall(MpmParticlesGetField(model->state.particles, MpmReductionFields[a], &start));
    for (PetscInt p = 0; p < points->count; p++) {
      if (moved) moved[p] += PetscSqr(points->x[p * dim + a] - start[p]);
      else start[p] = points->x[p * dim + a];
    }
    PetscCall(MpmParticlesRestoreField(model->state.particles, &start));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReductionBegin(MpmModel model)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  if (!model->scene.stages[model->state.stage].reduction.ramp) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(FindHeight(model, &points, &model->state.safety.height));
  PetscCall(EachAxis(model, &points, NULL));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  model->state.safety.moved   = 0.;
  model->state.safety.reduced = MpmReductionFactor(model, model->state.time_start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The longest way of a point since the stage began. */
static PetscErrorCode FindMoved(MpmModel model, PetscReal *longest)
{
  PetscReal *moved;
  MpmPoints  points;

  PetscFunctionBeginUser;
  *longest = 0.;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscCalloc1(points.count, &moved));
  PetscCall(EachAxis(model, &points, moved));
  for (PetscInt p = 0; p < points.count; p++) *longest = PetscMax(*longest, PetscSqrtReal(moved[p]));
  PetscCall(PetscFree(moved));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, longest, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReductionObserve(MpmModel model)
{
  const MpmReduction *reduction = &model->scene.stages[model->state.stage].reduction;
  const MpmSafety     before    = model->state.safety;
  MpmSafety          *safety    = &model->state.safety;
  const PetscReal     limit     = reduction->limit * before.height;

  PetscFunctionBeginUser;
  if (!reduction->ramp || before.factor > 0.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindMoved(model, &safety->moved));
  safety->reduced = MpmReductionFactor(model, model->state.time);
  if (safety->moved < limit) PetscFunctionReturn(PETSC_SUCCESS);
  safety->factor = safety->reduced;
  if (safety->moved > before.moved)
    safety->factor =
      before.reduced + (safety->reduced - before.reduced) * (limit - before.moved) / (safety->moved - before.moved);
  PetscCall(MpmMonitorNote(&model->monitor, "factor of safety %.4g: a point has moved %.3g m, %g of the height",
                           (double)safety->factor, (double)limit, (double)reduction->limit));
  PetscFunctionReturn(PETSC_SUCCESS);
}
