/*
  Bodies whose points have the materials of labelled voxels.
*/
#include <string.h>
#include "options/options.h"
#include "geometry/geometry.h"
#include "voxels/voxels.h"
#include "point/material.h"
#include "particles/body.h"
#include "particles/body_data.h"

PetscErrorCode MpmBodyNameLabels(const MpmOptions *block, PetscInt material_count, const MpmMaterial materials[],
                                 MpmBody body)
{
  struct MpmVoxels *voxels = MpmRegionVoxels(body->region);

  PetscFunctionBeginUser;
  body->material = -1;
  for (PetscInt r = 0; r < voxels->range_count; r++) {
    MpmVoxelRange *range = &voxels->range[r];

    for (PetscInt m = 0; m < material_count; m++)
      if (!strcmp(range->name, materials[m].name)) range->value = m;
    MpmCheckInput(range->value >= 0 || !strcmp(range->name, "none"),
                  "-%slabels: %s is none of -mpm_materials, nor the word none", block->prefix, range->name);
    if (body->material < 0 && range->met) body->material = range->value;
  }
  MpmCheckInput(body->material >= 0, "-%slabels: no voxel has a material", block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmBodyHasMaterial(MpmBody body, PetscInt material)
{
  const struct MpmVoxels *voxels = MpmRegionVoxels(body->region);

  for (PetscInt r = 0; voxels && r < voxels->range_count; r++)
    if (voxels->range[r].met && voxels->range[r].value == material) return PETSC_TRUE;
  return (PetscBool)(body->material == material);
}
