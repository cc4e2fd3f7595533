/*
  Fields at the points, and what they are there less their means over the cell.
*/
#include "space/point_loop.h"

/* `count` components at the points by one of the basis functions of their shapes. */
static PetscErrorCode AtPoints(const MpmSum *sum, const PetscReal u[], PetscInt count, const PetscInt component[],
                               PetscInt basis, PetscReal value[])
{
  const MpmLayout *layout = sum->layout;
  MpmWorkspace     work;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    const MpmKnown  known = KnownGeneral(layout, group);

    MpmSumGather(known, sum, group, u, work.values);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = sum->space->order[s];

      MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work.basis);
      for (PetscInt k = 0; k < count; k++) {
        const PetscInt   c   = component[k];
        const PetscReal *phi = work.basis.basis[layout->shape_of[c] * MPM_BASES + basis];
        PetscReal        d   = 0.;

        for (PetscInt i = 0; i < known.n; i++) d += phi[i] * work.values[c * known.n + i];
        value[p * count + k] = d;
      }
    }
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDeviationsAtPoints(const MpmSum *sum, const PetscReal u[], PetscReal deviation[])
{
  const MpmLayout *layout = sum->layout;

  PetscFunctionBeginUser;
  PetscCall(AtPoints(sum, u, layout->deviations, layout->deviation_component, MPM_DEVIATION(layout->dim), deviation));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRatesAtPoints(const MpmSum *sum, const PetscReal u[], PetscReal value[])
{
  PetscFunctionBeginUser;
  PetscCall(AtPoints(sum, u, sum->layout->rates, sum->layout->rate_component, 0, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
