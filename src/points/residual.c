/*
  The residual of the physics at the points.
*/
#include "space/kernel_point.h"
#include "points/cell_mean.h"
#include "points/point_term.h"
#include "points/point_terms.h"
#include "points/spread_mean.h"

/* Displacements of the nodes, and the destination of the step's end, or NULL. */
typedef struct {
  const MpmSum    *sum;
  const PetscReal *u;
  const MpmTrial  *trial;
} PointsPass;

/* Residual of one group's points; or, where `residual` is NULL, only their candidate of the step's end. */
MPM_INLINE PetscErrorCode ResidualGroup(const MpmKnown known, const PointsPass *pass, const MpmGroup *group,
                                        MpmWorkspace *work, PetscReal *residual, PetscInt *failed)
{
  const PetscBool weights = work->weights;
  const MpmSum   *sum     = pass->sum;

  MpmSumGather(known, sum, group, pass->u, work->values);
  for (PetscInt k = 0; residual && k < known.n * known.block; k++) work->force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];
    MpmKernelPoint point;
    PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];

    MpmSumFetch(known, sum, s);
    MpmSumBasis(known, sum->space, p, weights, &work->basis);
    MpmSumInputs(known, sum->layout, work->values, &work->basis, input);
    MpmSumPoint(sum, p, &point);
    MpmSumTrial(sum, pass->trial, p, &point);
    if (sum->layout->kernel->residual(&point, input, flux)) (*failed)++;
    else if (residual) MpmSumAddFlux(known, sum->layout, &work->basis, flux, work->force);
  }
  if (residual) MpmSumScatter(known, sum, group, work->force, residual);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmCellsTrial(const MpmSum *sum, const PetscReal u[], const MpmTrial *trial, PetscReal residual[],
                             PetscInt *failed)
{
  MpmCellWork   work;
  MpmSpreadWork spread;

  PetscFunctionBeginUser;
  if (sum->space->cells.spread) {
    PetscCall(MpmSpreadWorkCreate(sum, PETSC_FALSE, &spread));
    PetscCall(MpmSpreadEvaluate(&spread, u, trial, failed));
    if (!*failed) PetscCall(MpmSpreadScatter(&spread, residual));
    PetscCall(MpmSpreadWorkDestroy(&spread));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmCellWorkCreate(sum, &work));
  for (PetscInt c = 0; c < sum->space->cells.count; c++) {
    PetscCall(MpmCellResidual(sum, &sum->space->cells.at[c], u, trial, &work, failed));
    if (!*failed) PetscCall(MpmCellScatter(sum, &sum->space->cells.at[c], &work, residual));
  }
  PetscCall(MpmCellWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsTrial(const MpmSum *sum, const PetscReal u[], const MpmTrial *trial, PetscReal residual[],
                              PetscInt *failed)
{
  const PointsPass pass = {sum, u, trial};
  MpmWorkspace     work;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, ResidualGroup, &pass, group, &work, residual, failed);
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsResidual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                 PetscInt *failed)
{
  (void)ctx;
  return MpmPointsTrial(sum, u, NULL, residual, failed);
}

PetscErrorCode MpmCellsResidual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                PetscInt *failed)
{
  (void)ctx;
  return MpmCellsTrial(sum, u, NULL, residual, failed);
}

PetscErrorCode MpmPointsUpdate(const MpmSum *sum, const PetscReal u[], const MpmTrial *trial, PetscInt *failed)
{
  return MpmPointsTrial(sum, u, trial, NULL, failed);
}
