/*
  Faces of the material that meet an edge of a boundary with flat faces.

  What is under the edge of a footing bears on its base, and what is beside it on its side. As a whole a face would change from one to
  the other when its middle passes the edge, with a jump in force, and the width that bears would be known to half a face only. So it
  is cut into slices, a facet each.

  Not so where a boundary is bilateral, which holds the faces that touched at the start, or cut the lattice of points, whose faces are steps.
*/
#include "geometry/geometry.h"
#include "particles/points.h"
#include "terms/contact.h"

#define BENT 0.1 /* of the way to the face's end: so far from the plane at its middle the surface has an edge */

PetscInt MpmContactsSliceCount(const MpmContacts *contacts, const MpmPoints *points, PetscInt face,
                               const MpmFacet *facet)
{
  const MpmBoundary *boundary = &contacts->boundaries[facet->boundary];
  const PetscInt     dim = boundary->dim, p = facet->point;
  MpmSurface         middle, end;

  if (!MpmSolidHasFaces(&boundary->solid) || boundary->bilateral || contacts->cut[facet->boundary]) return 0;
  MpmContactsDistance(contacts, facet->boundary, facet->place, &middle);
  for (PetscInt k = 0; k < PetscPowInt(2, dim - 1); k++) {
    PetscReal at[MPM_MAX_DIM] = {0., 0., 0.}, flat = middle.distance, square = 0.;

    for (PetscInt b = 0, rest = k; b < dim; b++) {
      const PetscReal off = (rest % 2 ? 1. : -1.) * points->half_length[p * dim + b];

      if (b == face / 2) continue;
      for (PetscInt a = 0; a < dim; a++) at[a] += off * points->F[(p * dim + a) * dim + b];
      rest /= 2;
    }
    for (PetscInt a = 0; a < dim; a++) {
      flat += middle.normal[a] * at[a];
      square += PetscSqr(at[a]);
      at[a] += facet->place[a];
    }
    MpmContactsDistance(contacts, facet->boundary, at, &end);
    if (PetscAbsReal(end.distance - flat) > BENT * PetscSqrtReal(square)) return PetscPowInt(MPM_SLICES, dim - 1);
  }
  return 0;
}

void MpmContactsSlice(PetscInt dim, const MpmPoints *points, PetscInt p, PetscInt face, PetscInt slice, PetscReal x[])
{
  for (PetscInt a = 0; a < dim; a++) x[a] = points->x[p * dim + a];
  for (PetscInt b = 0, k = slice - 1; b < dim; b++) {
    const PetscReal middle = (PetscReal)(2 * (k % MPM_SLICES) + 1) / MPM_SLICES - 1.;

    if (b == face / 2) continue;
    for (PetscInt a = 0; a < dim; a++)
      x[a] += middle * points->half_length[p * dim + b] * points->F[(p * dim + a) * dim + b];
    k /= MPM_SLICES;
  }
}
