/*
  What fields are at the points less their means over the cell.
*/
#include "space/point_loop.h"

PetscErrorCode MpmDeviationsAtPoints(const MpmSum *sum, const PetscReal u[], PetscReal deviation[])
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
      for (PetscInt k = 0; k < layout->deviations; k++) {
        const PetscInt   c   = layout->deviation_component[k];
        const PetscReal *phi = work.basis.basis[layout->shape_of[c] * MPM_BASES + MPM_DEVIATION(layout->dim)];
        PetscReal        d   = 0.;

        for (PetscInt i = 0; i < known.n; i++) d += phi[i] * work.values[c * known.n + i];
        deviation[p * layout->deviations + k] = d;
      }
    }
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
