/*
  Start of Newton in a step, and the points by its solution: parts that the integrators share.
*/
#include "point/layout.h"
#include "grid/grid.h"
#include "maps/bed.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/body_motion.h"
#include "assembly/terms.h"
#include "loads/body_surface.h"
#include "problem/section.h"
#include "solve/iterate.h"
#include "query/model.h"
#include "query/query.h"
#include "entrainment/entrainment.h"
#include "step/energy.h"
#include "step/moving_grid.h"
#include "step/step.h"

/* The deviations that go with the nodal values made by the points. */
static PetscErrorCode KeepDeviations(MpmModel model, const PetscReal u[])
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  bs = model->disc.block, count = model->disc.points->count * model->disc.layout->deviation.count;
  PetscReal      *local, *deviation;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((space->local * bs), &local));
  PetscCall(PetscArraycpy(local, u, space->owned * bs));
  PetscCall(MpmSpaceToGhosts(space, bs, local));
  PetscCall(PetscMalloc1(count, &deviation));
  PetscCall(MpmDeviationsAtPoints(model->disc.sum, local, deviation));
  PetscCall(MpmDiscretizationSetDeviations(&model->disc, deviation));
  PetscCall(PetscFree(local));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values of fields with a rate at the nodes, from the points: the start of Newton and of the step. */
static PetscErrorCode ProjectRates(MpmModel model, PetscReal u[])
{
  const MpmLayout *layout = model->disc.layout;
  const PetscInt   rates = layout->rate.count, bs = layout->block, owned = model->disc.space->owned;
  PetscReal       *nodal;

  PetscFunctionBeginUser;
  if (!rates) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((owned * rates), &nodal));
  for (PetscInt s = 0; s < layout->shape_count; s++) {
    const MpmPointValues values = {s,
                                   rates,
                                   rates,
                                   model->disc.points->physics.value,
                                   model->disc.points->physics.value_gradient,
                                   rates * model->disc.dim};

    PetscCall(MpmProjectToNodes(model->disc.sum, &values, nodal));
    for (PetscInt k = 0; k < owned * rates; k++) {
      const PetscInt c = layout->rate.component[k % rates];

      if (layout->component[c].shape == s) u[k / rates * bs + c] = nodal[k];
    }
  }
  PetscCall(PetscFree(nodal));
  if (layout->deviation.count) PetscCall(KeepDeviations(model, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Damping of the second-order predictor; 1 amplifies errors. No second order with contact, whose facets come into other
  patches.
*/
#define PREDICTED_CHANGE 0.9

/*
  The increment extrapolated from the last steps, at the nodes: loads and motions change little from step to step, and
  Newton's method needs an iteration less. The increment is kept at the points, for the material moves over the grid.
*/
static PetscErrorCode Predict(MpmModel model, PetscReal u[])
{
  const PetscInt  dim = model->disc.dim, bs = model->disc.block, size = dim * (dim + 1);
  const PetscBool smooth = (PetscBool)(model->state.dt.before > 0. && !MpmSolverHasContact(&model->solver));
  const PetscReal change = smooth ? PREDICTED_CHANGE * model->disc.sum->step.span / model->state.dt.last : 0.;
  const PetscReal last   = (1. + change) * model->disc.sum->step.span / model->state.dt.last;
  const PetscReal before = change > 0. ? change * model->disc.sum->step.span / model->state.dt.before : 0.;
  PetscReal      *nodal, *expected;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((model->disc.space->owned * dim), &nodal, (model->disc.points->count * size), &expected));
  for (PetscInt p = 0; p < model->disc.points->count; p++) {
    const PetscReal *increment = &model->disc.points->motion.increment[p * MPM_INCREMENT(dim)];

    for (PetscInt k = 0; k < size; k++) expected[p * size + k] = last * increment[k] - before * increment[size + k];
  }
  PetscCall(MpmProjectToNodes(model->disc.sum, &(MpmPointValues){0, dim, size, expected, expected + dim, size}, nodal));
  for (PetscInt k = 0; k < model->disc.space->owned * dim; k++) u[k / dim * bs + k % dim] = nodal[k];
  PetscCall(PetscFree2(nodal, expected));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepStart(MpmModel model, PetscBool predict)
{
  const PetscInt n = model->disc.space->owned * model->disc.block;
  PetscScalar   *x;

  PetscFunctionBeginUser;
  PetscCall(VecZeroEntries(model->solver.x));
  PetscCall(VecGetArray(model->solver.x, &x));
  PetscCall(ProjectRates(model, x));
  if (predict) PetscCall(Predict(model, x));
  MpmTermsGuess(model->disc.terms, model->disc.sum, predict ? model->disc.sum->step.span / model->state.dt.last : 0.,
                x);
  MpmFramesToUnknowns(model->disc.constraints, model->disc.block, model->disc.space->owned, x);
  MpmUnitsOver(model->disc.constraints, n, x);
  MpmConstraintsPrescribe(model->disc.constraints, n, x);
  PetscCall(VecRestoreArray(model->solver.x, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The solver and the start of Newton's method; couplings of terms' own nodes are included in the sparsity. */
static PetscErrorCode PrepareSolver(MpmModel model, PetscBool again, MpmOutcome *outcome)
{
  PetscBool links;

  PetscFunctionBeginUser;
  PetscCall(MpmTermsLink(model->disc.terms, model->disc.space, &links));
  if (!again || links) PetscCall(MpmSolverSetUp(&model->solver));
  PetscCall(MpmStepStart(model, PETSC_FALSE));
  PetscCall(MpmTermsRefuse(model->disc.terms, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepPrepare(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmStepBegin(model, time, dt, again, outcome));
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_TRANSFER, &since));
  if (!outcome->code) PetscCall(PrepareSolver(model, again, outcome));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_TRANSFER, since));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSolverSetNearNullSpace(&model->solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where points may leave the grid in the stage under way. */
static PetscBool MayLeave(const MpmModel model)
{
  return (PetscBool)(model->disc.grid->outflow && MpmModelMotion(model)->type != MPM_QUASISTATIC);
}

/* The first point where the bed has no data; -1: there is none. */
static PetscInt FindDry(const MpmModel model)
{
  const MpmBed *bed = model->scene.deformation.bed;

  for (PetscInt p = 0; bed && bed->missing && p < model->disc.points->count; p++)
    if (MpmBedIsMissing(bed, &model->disc.points->x[p * model->disc.dim])) return p;
  return -1;
}

PetscErrorCode MpmStepFindLost(MpmModel model, MpmOutcome *outcome)
{
  const PetscBool follows        = (PetscBool)(model->scene.follow.what != MPM_FOLLOW_NOTHING);
  PetscMPIInt     rank           = model->size;
  PetscReal       x[MPM_MAX_DIM] = {0.};
  MpmGrid         next;
  PetscInt        point;

  PetscFunctionBeginUser;
  if (MayLeave(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMovingGridNext(model, &next));
  PetscCall(MpmFindOutside(model->disc.sum, follows ? &next : model->disc.grid, model->disc.nodal.u, &point, x));
  if (point >= 0) {
    rank = model->rank;
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_OUTSIDE,
                             model->disc.dim > 2 ? "point %" PetscInt_FMT " left the grid at (%g, %g, %g)"
                                                 : "point %" PetscInt_FMT " left the grid at (%g, %g)",
                             model->disc.points->id[point], (double)x[0], (double)x[1], (double)x[2]));
  }
  point = FindDry(model);
  if (point >= 0) {
    rank = model->rank;
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_OUTSIDE,
                             "point %" PetscInt_FMT " is at (%.10g, %.10g), where the terrain has no data",
                             model->disc.points->id[point], (double)model->disc.points->x[2 * point],
                             (double)model->disc.points->x[2 * point + 1]));
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rank, 1, MPI_INT, MPI_MIN, model->comm));
  if (rank == model->size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOutcomeBroadcast(model->comm, rank, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Those of the last evaluation, where it was made there. */
PetscErrorCode MpmStepFindTrial(MpmModel model)
{
  MpmVersion at;
  PetscBool  same;
  PetscInt   failed;

  PetscFunctionBeginUser;
  PetscCall(MpmVersionGet(model->solver.x, &at));
  same = MpmVersionIsSame(&at, &model->disc.trial->of);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &same, 1, MPM_MPI_BOOL, MPI_LAND, model->comm));
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSumResidual(&model->solver, model->solver.x, MPM_MODE_END, &failed));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_SUM, model->comm));
  PetscCheck(!failed, model->comm, PETSC_ERR_PLIB, "a converged step has %" PetscInt_FMT " points without an answer",
             failed);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The residual at the constrained nodes. */
PetscErrorCode MpmStepFindReactions(MpmModel model)
{
  const PetscInt bs    = model->disc.block;
  const PetscInt count = (model->scene.bcs->count + model->scene.motions->count) * bs; /* of reactions */

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(model->disc.nodal.reaction, count));
  MpmConstraintsAddReactions(model->disc.constraints, bs, model->disc.space->owned, model->disc.nodal.residual,
                             model->disc.nodal.reaction);
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, model->disc.nodal.reaction, (PetscMPIInt)count, MPIU_REAL, MPIU_SUM, model->comm));
  for (PetscInt k = 0; k < count; k++)
    if (model->disc.layout->component[k % bs].negative) model->disc.nodal.reaction[k] *= -1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

MPM_INLINE void Clip(const PetscInt dim, const MpmGrid *grid, PetscInt count, PetscReal x[])
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  for (PetscInt a = 0; a < dim; a++) {
    lower[a] = grid->lower[a];
    upper[a] = grid->upper[a];
  }
  for (PetscInt k = 0; k < count * dim; k += dim)
    for (PetscInt a = 0; a < dim; a++) x[k + a] = PetscMin(PetscMax(x[k + a], lower[a]), upper[a]);
}

void MpmStepClip(MpmModel model)
{
  const MpmPoints *points = model->disc.points;

  if (model->scene.follow.what != MPM_FOLLOW_NOTHING || MayLeave(model)) return;
  MPM_BY_DIM(model->disc.dim, Clip, model->disc.grid, points->count, points->x);
}

/* Removes points that have become part of the bed. */
static PetscErrorCode RemoveEmpty(MpmModel model)
{
  PetscInt here, *empty, count;

  PetscFunctionBeginUser;
  PetscCall(MpmEntrainmentFindEmpty(model, &here, &empty, &count));
  if (count) {
    PetscCall(MpmParticlesRemoveAt(model->state.particles, here, empty));
    PetscCall(MpmSpaceRemovePoints(model->disc.space, here, empty));
  }
  PetscCall(PetscFree(empty));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepRemoveGone(MpmModel model)
{
  PetscInt here, *outside, gone;

  PetscFunctionBeginUser;
  PetscCall(RemoveEmpty(model));
  if (!MayLeave(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesFindOutside(model->state.particles, model->disc.grid, model->scene.deformation.bed, &here,
                                    &outside, &gone));
  if (gone) {
    PetscCall(MpmEnergyMark(model));
    PetscCall(MpmEnergyAddAffine(model, -1.));
    PetscCall(MpmEntrainmentLeave(model, here, outside));
    PetscCall(MpmParticlesRemoveAt(model->state.particles, here, outside));
    PetscCall(
      MpmSpaceRemovePoints(model->disc.space, here, outside)); /* the step's rows and grid are still summed over it */
    PetscCall(MpmEnergyAddAffine(model, 1.));
    PetscCall(MpmEnergyRebase(model));
    PetscCall(MpmMonitorNote(&model->monitor, "%" PetscInt_FMT " point%s left the grid, %" PetscInt64_FMT " remain%s",
                             gone, gone > 1 ? "s" : "", model->state.particles->total,
                             model->state.particles->total == 1 ? "s" : ""));
  }
  PetscCall(PetscFree(outside));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepFindReference(MpmModel model)
{
  PetscReal motion;

  PetscFunctionBeginUser;
  PetscCall(VecNorm(model->solver.x, NORM_INFINITY, &motion)); /* constrained nodes may move */
  PetscCall(MpmNewtonResidual(&model->solver, model->solver.x,
                              motion == 0. && !model->disc.layout->means ? MPM_MODE_START : MPM_MODE_END,
                              model->solver.f));
  PetscCall(MpmSolverSetReference(&model->solver, model->solver.f));
  PetscFunctionReturn(PETSC_SUCCESS);
}
