/*
  The Jacobian, point by point: the kernel on duals that are seeded with the point's inputs gives the point's D, and the
  element block of a group is the sum of B^T D B over its points.
*/
#include "sum.h"

/* element[i][c][d][j] += sum_{k in c, l in d} phi_k(i) D_kl phi_l(j) */
MPM_INLINE void AddElement(const MpmKnown known, const MpmLayout *layout, const MpmBasis *basis, const PetscReal D[],
                           PetscReal element[])
{
  const PetscInt bs = known.block, N = known.inputs, n = known.n;

  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt c = 0; c < bs; c++) {
      const PetscInt first = known.solid ? c * known.dim : layout->component_first[c];
      const PetscInt last  = known.solid ? first + known.dim : layout->component_first[c + 1];
      PetscReal      t[MPM_MAX_INPUTS];

      for (PetscInt l = 0; l < N; l++) t[l] = 0.;
      for (PetscInt k = first; k < last; k++) {
        const PetscReal phi = basis->basis[KnownBasis(known, layout, k)][i];

        for (PetscInt l = 0; l < N; l++) t[l] += phi * D[k * N + l];
      }
      for (PetscInt d = 0; d < bs; d++) {
        const PetscInt l0       = known.solid ? d * known.dim : layout->component_first[d];
        const PetscInt count    = known.solid ? known.dim : layout->component_first[d + 1] - l0;
        PetscReal *restrict row = &element[((i * bs + c) * bs + d) * n];

        for (PetscInt j = 0; j < n; j++) {
          PetscReal s = row[j];

          for (PetscInt l = 0; l < count; l++) s += t[l0 + l] * basis->basis[KnownBasis(known, layout, l0 + l)][j];
          row[j] = s;
        }
      }
    }
  }
}

/* The element block of one group. */
MPM_INLINE PetscErrorCode ElementGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                       PetscBool weights, const PetscReal u[], MpmWorkspace *work, PetscReal element[],
                                       PetscInt *failed)
{
  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt k = 0; k < known.n * known.n * known.block * known.block; k++) element[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s];
    MpmKernelPoint point;
    PetscReal      input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS], tangent[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

    MpmSumBasis(known, sum->space, p, weights, &work->basis);
    MpmSumInputs(known, sum->layout, work->values, &work->basis, input);
    MpmSumPoint(sum, p, &point);
    if (sum->layout->kernel->tangent(&point, input, flux, tangent)) (*failed)++;
    else AddElement(known, sum->layout, &work->basis, tangent, element);
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmJacobianLocal(const MpmSum *sum, const PetscReal u[], MpmPattern *pattern, PetscInt *failed)
{
  const MpmSpace *space   = sum->space;
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);
  const PetscInt  most = PetscPowInt(space->width, space->dim), bs = sum->layout->block;
  PetscReal      *element;
  MpmWorkspace    work;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(PetscArrayzero(pattern->value, pattern->row[pattern->local] * bs * bs));
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(PetscMalloc1((most * most * bs * bs), &element));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MPM_DISPATCH(sum->layout, group, ElementGroup, sum, group, weights, u, &work, element, failed);
    MpmPatternAddBlock(pattern, space, group, sum->constraints, element);
  }
  PetscCall(MpmGhostJacobian(sum, pattern));
  PetscCall(PetscFree(element));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
