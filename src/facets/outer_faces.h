#pragma once
/*
  Which faces of the points' domains bound the material.
*/
#include "base/base.h"
#include "base/types.h"

/* The bit of a face: of the lower (side 0) or upper (1) end of a domain's axis. */
static inline PetscInt MpmFaceBit(PetscInt axis, PetscInt side)
{
  return 1 << (2 * axis + side);
}
/*
  Sets the bits of the faces across which no domain of the same part lies. Air covers no face and has none. `part`
  numbers the points' parts, NULL: all of one; with `asked` only bits set in it. The domains are the initial ones
  deformed by F. Collective; points of other ranks count as well.
*/
PetscErrorCode MpmOuterFacesFind(const MpmGrid *grid, const MpmPoints *points, const MpmMaterial *materials,
                                 const PetscInt part[], const PetscInt asked[], PetscInt faces[]);
/* Vector from a point's centre to the middle of a face, and the face's outward area vector, m^(dim-1), both by F. */
void MpmOuterFace(PetscInt dim, const PetscReal F[], const PetscReal half[], PetscInt axis, PetscInt side,
                  PetscReal arm[], PetscReal area[]);
/*
  Unit normal, by F, of planes of the material that had the normal N at the start; returns the ratio of their present to
  their initial distance, 1/|F^-T N|.
*/
PetscReal MpmOuterNormal(PetscInt dim, const PetscReal F[], const PetscReal N[], PetscReal n[]);
/* The points' field of them, for points where they are; of particles that have it. */
PetscErrorCode MpmOuterFacesUpdate(MpmParticles *particles, const MpmMaterials *materials, MpmGrid *grid);
