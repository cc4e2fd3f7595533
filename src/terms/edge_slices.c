/*
  Faces of the material at the edges of boundaries with flat faces.

  Under the edge of a footing pressure is singular, and contact ends there, or goes on at the footing's side. A mean gap over a cell leaves the
  cell's outer node free: a surface of n cells has n + 1 nodes. And whether the mean is below zero or above, where half of a cell's faces are
  far off, switches all of them. So facets that are no farther than a cell from an edge are patches by themselves; there their pressures, each
  from its own gap, vary as the singular field does.

  As a whole a face would change from the footing's base to its side when its middle passes the edge, with a jump in force, and the width that
  bears would be known to half a face only. So a face that meets an edge is cut into slices, a facet each.

  Not so where a boundary is bilateral, which holds the faces that touched at the start, or cut the lattice of points, whose faces are steps.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "terms/contact.h"

#define SHARP 0.9  /* cosine between the normals on either side of an edge, at most */
#define THERE 1e-6 /* of a cell: what is farther off a plane is beyond its edge */
#define BENT  0.1  /* of the way to the face's end: so far from the plane at its middle the surface has an edge */

/* Does the surface end, or bend, no farther than a cell from a facet, along its plane? */
static PetscBool EdgeIsNear(const MpmContacts *contacts, const MpmGrid *grid, const MpmFacet *facet,
                            const MpmSurface *surface)
{
  for (PetscInt k = 0; k < 2 * grid->dim; k++) {
    const PetscReal way = k % 2 ? grid->h[k / 2] : -grid->h[k / 2];
    PetscReal       at[MPM_MAX_DIM] = {0., 0., 0.}, cosine = 0., curved = 0.;
    MpmSurface      there;

    for (PetscInt a = 0; a < grid->dim; a++)
      at[a] = facet->place[a] - (surface->distance + way * surface->normal[k / 2]) * surface->normal[a];
    at[k / 2] += way;
    MpmContactsDistance(contacts, facet->boundary, at, &there);
    for (PetscInt a = 0; a < grid->dim; a++) {
      cosine += there.normal[a] * surface->normal[a];
      curved += PetscAbsReal(surface->second[a][a]);
    }
    if (curved > 0. || (PetscAbsReal(there.distance) > THERE * contacts->cell && cosine < SHARP)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* Is the distance at the face's corners not that from a plane? */
static PetscBool MeetsEdge(const MpmContacts *contacts, const MpmPoints *points, PetscInt face, const MpmFacet *facet)
{
  const PetscInt dim = contacts->boundaries[facet->boundary].dim, p = facet->point;
  MpmSurface     middle, end;

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
    if (PetscAbsReal(end.distance - flat) > BENT * PetscSqrtReal(square)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscInt MpmContactsSliceCount(const MpmContacts *contacts, const MpmGrid *grid, const MpmPoints *points, PetscInt face,
                               const MpmSurface *surface, MpmFacet *facet)
{
  const MpmBoundary *boundary = &contacts->boundaries[facet->boundary];

  facet->single = 0;
  if (!MpmSolidHasFaces(&boundary->solid) || boundary->bilateral || contacts->cut[facet->boundary]) return 0;
  facet->single = EdgeIsNear(contacts, grid, facet, surface);
  return facet->single && MeetsEdge(contacts, points, face, facet) ? PetscPowInt(MPM_SLICES, grid->dim - 1) : 0;
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
