/*
  The residual of the physics at the points.
*/
#include "space/kernel_point.h"
#include "points/cell_mean.h"
#include "points/point_term.h"
#include "points/point_terms.h"

/* Residual of one group's points; or, where `residual` is NULL, only their candidate of the step's end. */
MPM_INLINE PetscErrorCode ResidualGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                        const PetscReal u[], MpmWorkspace *work, PetscReal *residual, PetscInt *failed)
{
  const PetscBool weights = work->weights;

  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt k = 0; residual && k < known.n * known.block; k++) work->force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];
    MpmKernelPoint point;
    PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];

    MpmSumFetch(known, sum, s);
    MpmSumBasis(known, sum->space, p, weights, &work->basis);
    MpmSumInputs(known, sum->layout, work->values, &work->basis, input);
    MpmSumPoint(sum, p, &point);
    MpmSumTrial(sum, p, &point);
    if (sum->layout->kernel->residual(&point, input, flux)) (*failed)++;
    else if (residual) MpmSumAddFlux(known, sum->layout, &work->basis, flux, work->force);
  }
  if (residual) MpmSumScatter(known, sum, group, work->force, residual);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmCellsResidual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                PetscInt *failed)
{
  MpmCellWork work;

  PetscFunctionBeginUser;
  (void)ctx;
  PetscCall(MpmCellWorkCreate(sum, &work));
  for (PetscInt c = 0; c < sum->space->cells.count; c++) {
    PetscCall(MpmCellResidual(sum, &sum->space->cells.at[c], u, &work, failed));
    if (!*failed) PetscCall(MpmCellScatter(sum, &sum->space->cells.at[c], &work, residual));
  }
  PetscCall(MpmCellWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsResidual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                 PetscInt *failed)
{
  MpmWorkspace work;

  PetscFunctionBeginUser;
  (void)ctx;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, ResidualGroup, sum, group, u, &work, residual, failed);
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsUpdate(const MpmSum *sum, const PetscReal u[], PetscInt *failed)
{
  return MpmPointsResidual(NULL, sum, u, NULL, failed);
}
