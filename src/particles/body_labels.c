/*
  Bodies whose points have materials of their own: by labels of voxels, or by a column of a file of points.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "voxels/voxels.h"
#include "point/material.h"
#include "particles/body.h"
#include "particles/body_data.h"

PetscErrorCode MpmBodyNameLabels(const MpmOptions *block, const MpmMaterials *materials, MpmBody body)
{
  MpmLabels *labels = &MpmRegionVoxels(body->region)->labels;

  PetscFunctionBeginUser;
  PetscCall(MpmLabelsNumber(block, materials->count, (const char *const *)materials->names, labels));
  PetscCall(PetscCalloc1(materials->count + 1, &body->material.has));
  for (PetscInt r = 0; r < labels->count; r++)
    if (labels->range[r].met && labels->range[r].value >= 0) body->material.has[labels->range[r].value] = PETSC_TRUE;
  PetscCall(MpmBodySetMaterials(block, materials->count, "labels: no voxel has a material", body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodySetMaterials(const MpmOptions *block, PetscInt material_count, const char none[], MpmBody body)
{
  PetscFunctionBeginUser;
  body->material.first = body->material.last = -1;
  for (PetscInt m = 0; m < material_count; m++) {
    if (!body->material.has[m]) continue;
    if (body->material.first < 0) body->material.first = m;
    body->material.last = m;
  }
  MpmCheckInput(body->material.last >= 0, "-%s%s", block->prefix, none);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmBodyHasMaterial(MpmBody body, PetscInt material)
{
  return body->material.has ? body->material.has[material] : (PetscBool)(body->material.first == material);
}

PetscBool MpmBodyIsMixed(MpmBody body)
{
  return (PetscBool)(body->material.has != NULL);
}
