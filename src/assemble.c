/*
  Sums over points: the residual, and the commit of a converged step.
*/
#include "sum.h"

PetscBool MpmLayoutUsesValues(const MpmLayout *layout)
{
  for (PetscInt k = 0; k < layout->inputs; k++)
    if (!layout->basis_of[k]) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Residual of one group's points. */
MPM_INLINE PetscErrorCode ResidualGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                        PetscBool weights, const PetscReal u[], MpmWorkspace *work,
                                        PetscReal residual[], PetscInt *failed)
{
  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt k = 0; k < known.n * known.block; k++) work->force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];
    MpmKernelPoint point;
    PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];

    MpmSumBasis(known, sum->space, p, weights, &work->basis);
    MpmSumInputs(known, sum->layout, work->values, &work->basis, input);
    MpmSumPoint(sum, p, &point);
    MpmSumMean(sum, group, p, &point, input);
    if (sum->layout->kernel->residual(&point, input, flux)) (*failed)++;
    else MpmSumAddFlux(known, sum->layout, &work->basis, flux, work->force);
  }
  MpmSumScatter(known, sum, group, work->force, residual);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmResidualLocal(const MpmSum *sum, const PetscReal u[], PetscReal residual[], PetscInt *failed)
{
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);
  MpmWorkspace    work;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(MpmMeanEvaluate(sum, u, failed));
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, ResidualGroup, sum, group, weights, u, &work, residual, failed);
  }
  PetscCall(MpmGhostResidual(sum, u, residual));
  MpmContactsResidual(sum, u, residual);
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the increment's gradient by the new position: with g by the old one, g (I + g)^{-1} = I - (I + g)^{-1}. */
static void KeepGradient(PetscInt dim, const PetscReal g[], PetscReal gradient[])
{
  PetscReal F[9], C[9], det;

  for (PetscInt k = 0; k < dim * dim; k++) F[k] = g[k] + (k % (dim + 1) ? 0. : 1.);
  if (dim == 2) {
    det = F[0] * F[3] - F[1] * F[2];
    for (PetscInt k = 0; k < 4; k++) C[k] = (k % 3 ? -F[k] : F[3 - k]) / det;
  } else {
    for (PetscInt i = 0; i < 3; i++)
      for (PetscInt j = 0; j < 3; j++) {
        const PetscInt i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;

        C[j * 3 + i] = F[i1 * 3 + j1] * F[i2 * 3 + j2] - F[i1 * 3 + j2] * F[i2 * 3 + j1];
      }
    det = F[0] * C[0] + F[1] * C[3] + F[2] * C[6];
    for (PetscInt k = 0; k < 9; k++) C[k] /= det;
  }
  for (PetscInt k = 0; k < dim * dim; k++) gradient[k] = (k % (dim + 1) ? 0. : 1.) - C[k];
}

/* Moves a point by the increment at its nodes and takes over its new values of fields with a rate. */
static void MovePoint(const MpmSum *sum, PetscInt p, PetscInt n, const PetscReal values[], const MpmBasis *basis)
{
  const MpmLayout *layout = sum->layout;
  const PetscInt   dim    = sum->space->dim;

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal du = 0.;

    for (PetscInt i = 0; i < n; i++) du += basis->basis[0][i] * values[a * n + i];
    sum->points->x[p * dim + a] += du;
    if (sum->points->increment) sum->points->increment[p * dim * (dim + 1) + a] = du;
  }
  for (PetscInt r = 0; r < layout->rates; r++) {
    PetscReal value = 0.;

    for (PetscInt i = 0; i < n; i++) value += basis->basis[0][i] * values[layout->rate_component[r] * n + i];
    sum->points->value[p * layout->rates + r] = value;
  }
}

/* One group's part of the commit; `state` and F are room for one point. */
MPM_INLINE PetscErrorCode CommitGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                      const PetscReal u[], MpmWorkspace *work, PetscReal state[], PetscReal residual[],
                                      PetscInt *failed)
{
  PetscReal F[MPM_MAX_DIM * MPM_MAX_DIM];

  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt k = 0; k < known.n * known.block; k++) work->force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s], size = sum->materials[sum->points->material[p]].state_size;
    MpmKernelPoint point;
    PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];

    MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work->basis);
    MpmSumInputs(known, sum->layout, work->values, &work->basis, input);
    MpmSumPoint(sum, p, &point);
    MpmSumMean(sum, group, p, &point, input);
    /* the kernel reads state n while it writes n+1 */
    if (size) point.state = state;
    point.F      = F;
    point.stress = &sum->points->stress[p * (known.dim == 2 ? 4 : 6)];
    if (sum->layout->kernel->residual(&point, input, flux)) {
      (*failed)++;
      continue;
    }
    MpmSumAddFlux(known, sum->layout, &work->basis, flux, work->force);
    MovePoint(sum, p, known.n, work->values, &work->basis);
    if (sum->points->increment)
      KeepGradient(known.dim, input, &sum->points->increment[p * known.dim * (known.dim + 1) + known.dim]);
    for (PetscInt k = 0; k < known.dim * known.dim; k++) sum->points->F[p * known.dim * known.dim + k] = F[k];
    for (PetscInt k = 0; k < size; k++) sum->points->state[p * sum->state_size + k] = state[k];
  }
  MpmSumScatter(known, sum, group, work->force, residual);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmCommitLocal(const MpmSum *sum, const PetscReal u[], PetscReal residual[], PetscInt *failed)
{
  PetscReal   *state;
  MpmWorkspace work;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(MpmMeanEvaluate(sum, u, failed));
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(PetscMalloc1((sum->state_size + 1), &state));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group, CommitGroup, sum, group, u, &work, state, residual, failed);
  }
  PetscCall(MpmGhostResidual(sum, u, residual));
  MpmContactsResidual(sum, u, residual);
  PetscCall(PetscFree(state));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
