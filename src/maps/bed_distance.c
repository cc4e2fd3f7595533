/*
  Distances from the bed, as a surface with the material above it.

  A place finds its patch by division, without a search. The distance is that from the plane that touches the patch at
  the place nearest to x, and its gradient that plane's normal n: with q the way to the foot along the bed, q = -d n in
  a few steps, as material in contact is near. The patch goes on beyond its edges; at a pixel's edge, where the slope
  jumps, the normal is that of the patch below.
*/
#include "maps/bed.h"

#define FOOT_STEPS 3 /* of the search of the nearest place: the error falls by depth times curvature in each */

/* Unit normal of a patch at q from its place, upwards; returns the length of (-dZ/dx, -dZ/dy, 1). */
static PetscReal Normal(const MpmBedPatch *patch, const PetscReal q[2], PetscReal normal[3])
{
  const PetscReal zx = patch->slope[0] + patch->twist * q[1], zy = patch->slope[1] + patch->twist * q[0];
  const PetscReal length = PetscSqrtReal(1. + zx * zx + zy * zy);

  normal[0] = -zx / length;
  normal[1] = -zy / length;
  normal[2] = 1. / length;
  return length;
}

/* Of the normal n = g/|g| along the surface: -(I - n n) Z''/|g| (I - n n), where Z'' has the twist alone. */
static void Curvature(const PetscReal n[3], PetscReal twist, PetscReal second[MPM_MAX_DIM][MPM_MAX_DIM])
{
  for (PetscInt a = 0; a < 3; a++) {
    for (PetscInt b = 0; b < 3; b++) {
      const PetscReal ax = (a == 0 ? 1. : 0.) - n[a] * n[0], ay = (a == 1 ? 1. : 0.) - n[a] * n[1];
      const PetscReal bx = (b == 0 ? 1. : 0.) - n[b] * n[0], by = (b == 1 ? 1. : 0.) - n[b] * n[1];

      second[a][b] = -twist * (ax * by + ay * bx);
    }
  }
}

void MpmBedDistance(const MpmBed *bed, const PetscReal x[], PetscReal *distance, PetscReal normal[MPM_MAX_DIM],
                    PetscReal second[MPM_MAX_DIM][MPM_MAX_DIM])
{
  MpmBedPatch patch;
  PetscReal   q[2] = {0., 0.}, length = 1.;

  MpmBedPatchAt(bed, x, &patch);
  if (MpmBedIsMissing(bed, x) || PetscIsInfOrNanReal(patch.z + patch.slope[0] + patch.slope[1] + patch.twist)) {
    *distance = PETSC_MAX_REAL;
    normal[0] = normal[1] = 0.;
    normal[2]             = 1.;
    return;
  }
  for (PetscInt k = 0; k < FOOT_STEPS; k++) {
    const PetscReal height = patch.z + patch.slope[0] * q[0] + patch.slope[1] * q[1] + patch.twist * q[0] * q[1];

    length    = Normal(&patch, q, normal);
    *distance = -q[0] * normal[0] - q[1] * normal[1] + (x[2] - height) * normal[2];
    if (patch.twist == 0.) break;
    for (PetscInt a = 0; a < 2; a++) q[a] = -*distance * normal[a];
  }
  if (patch.twist != 0.) Curvature(normal, patch.twist / length, second);
}
