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
MPM_INLINE PetscErrorCode ResidualGroup(const PetscInt n, const MpmKnown known, const MpmSum *sum,
                                        const MpmGroup *group, PetscBool weights, const PetscReal u[],
                                        MpmWorkspace *work, PetscReal residual[], PetscInt *failed)
{
  MpmSumGather(n, known, sum, group, u, work->values);
  for (PetscInt k = 0; k < n * known.block; k++) work->force[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];
    MpmKernelPoint point;
    PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];

    MpmSumBasis(known.dim, sum->space, group->count, p, weights, &work->basis);
    MpmSumInputs(n, known, sum->layout, work->values, &work->basis, input);
    MpmSumPoint(sum, p, &point);
    if (sum->layout->kernel->residual(&point, input, flux)) (*failed)++;
    else MpmSumAddFlux(n, known, sum->layout, &work->basis, flux, work->force);
  }
  MpmSumScatter(n, known, sum, group, work->force, residual);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmResidualLocal(const MpmSum *sum, const PetscReal u[], PetscReal residual[], PetscInt *failed)
{
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);
  MpmWorkspace    work;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];

    MPM_DISPATCH(sum->layout, group->node_count, ResidualGroup, sum, group, weights, u, &work, residual, failed);
  }
  PetscCall(MpmGhostResidual(sum, u, residual));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
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
  }
  for (PetscInt r = 0; r < layout->rates; r++) {
    PetscReal value = 0.;

    for (PetscInt i = 0; i < n; i++) value += basis->basis[0][i] * values[layout->rate_component[r] * n + i];
    sum->points->value[p * layout->rates + r] = value;
  }
}

PetscErrorCode MpmCommitLocal(const MpmSum *sum, const PetscReal u[], PetscReal residual[], PetscInt *failed)
{
  const MpmSpace  *space  = sum->space;
  const MpmLayout *layout = sum->layout;
  const MpmKnown   known  = {layout->dim, layout->block, layout->inputs, PETSC_FALSE};
  const PetscInt   dim    = space->dim;
  PetscReal        F[MPM_MAX_DIM * MPM_MAX_DIM], *state;
  MpmWorkspace     work;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(PetscMalloc1((sum->state_size + 1), &state));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const PetscInt  n     = group->node_count;

    MpmSumGather(n, known, sum, group, u, work.values);
    PetscCall(PetscArrayzero(work.force, n * known.block));
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s], size = sum->materials[sum->points->material[p]].state_size;
      MpmKernelPoint point;
      PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS];

      MpmSpaceEvaluate(space, group, p, &work.basis);
      MpmSumInputs(n, known, layout, work.values, &work.basis, input);
      MpmSumPoint(sum, p, &point);
      /* the kernel reads state n while it writes n+1 */
      if (size) point.state = state;
      point.F      = F;
      point.stress = &sum->points->stress[p * (dim == 2 ? 4 : 6)];
      if (layout->kernel->residual(&point, input, flux)) {
        (*failed)++;
        continue;
      }
      MpmSumAddFlux(n, known, layout, &work.basis, flux, work.force);
      MovePoint(sum, p, n, work.values, &work.basis);
      PetscCall(PetscArraycpy(&sum->points->F[p * dim * dim], F, dim * dim));
      if (size) PetscCall(PetscArraycpy(&sum->points->state[p * sum->state_size], state, size));
    }
    MpmSumScatter(n, known, sum, group, work.force, residual);
  }
  PetscCall(MpmGhostResidual(sum, u, residual));
  PetscCall(PetscFree(state));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
