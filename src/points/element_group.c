/*
  Element blocks of the tangent, the sum over the points of a group, compiled for each dimension (MPM_LOOPS).
*/
#include "space/element_block.h"
#include "points/element_group.h"

/* The element block of one group, and its forces. */
MPM_INLINE PetscErrorCode ElementGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                       const PetscReal u[], MpmWorkspace *work, Target *to, PetscInt *failed)
{
  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt k = 0; k < known.n * known.block; k++) work->force[k] = 0.;
  for (PetscInt k = 0; k < known.n * known.n * known.block * known.block; k++) to->element[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    Point at;

    if (!PointTangent(known, sum, s, work, &to->coupling, &at)) {
      (*failed)++;
      continue;
    }
    if (known.biot) MpmSumAddBlockBiot(known, &at.basis, at.tangent, to->rows, to->element);
    else MpmSumAddBlock(known, sum->layout, &at.basis, at.tangent, to->rows, to->element);
    if (to->residual) MpmSumAddFlux(known, sum->layout, &at.basis, at.flux, work->force);
  }
  if (to->residual) MpmSumScatter(known, sum, group, work->force, to->residual);
  return PETSC_SUCCESS;
}

PetscErrorCode MPM_LOOPS_NAME(MpmElementGroup)(const MpmSum *sum, const MpmGroup *group, const PetscReal u[],
                                               MpmWorkspace *work, Target *to, PetscInt *failed)
{
  MPM_DISPATCH_BIOT(sum->layout, group, ElementGroup, sum, group, u, work, to, failed);
  return PETSC_SUCCESS;
}
