/*
  Volume of ground between maps.
*/
#include "geometry/region_part.h"
#include "release/ground_volume.h"

PetscErrorCode MpmGroundVolume(MpmRegion region, const MpmGrid *grid, const PetscReal base[2], PetscReal *volume)
{
  PetscInt64 columns[2], total = 1;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < 2; a++) {
    columns[a] = (PetscInt64)PetscFloorReal((grid->upper[a] - grid->lower[a]) / base[a] + 0.5);
    total *= columns[a];
  }
  *volume = 0.;
  for (PetscInt64 k = total * grid->rank / grid->size; k < total * (grid->rank + 1) / grid->size; k++) {
    const PetscReal low[]  = {grid->lower[0] + base[0] * (PetscReal)(k % columns[0]),
                              grid->lower[1] + base[1] * (PetscReal)(k / columns[0]), grid->lower[2]};
    const PetscReal high[] = {low[0] + base[0], low[1] + base[1], grid->upper[2]};
    PetscReal       centroid[MPM_MAX_DIM];

    *volume += MpmRegionPart(region, low, high, centroid);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, volume, 1, MPIU_REAL, MPIU_SUM, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
