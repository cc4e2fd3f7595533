/*
  Faces of the material near edges of boundaries with flat faces.

  Under the edge of a footing pressure is singular; contact ends there, or goes on at the footing's side over a fraction
  of a cell. A mean gap over a cell cannot resolve either. Under n cells it leaves one of the n + 1 nodes free, which
  then enters the footing; at the side it touches as a whole or not at all, as half of the cell's faces are far off. A
  facet with an edge no farther than a cell is therefore a patch by itself.

  As a whole a face would go from the base to the side when its middle passes the edge, with a jump in force, and the
  bearing width would be known to half a face only. A face that meets an edge is cut into slices, a facet each. Those of
  a point that face one flat side are one patch, as the whole face would be: alone, the slice that a turned face pushes
  in furthest would carry the load, and contact would change with every step. Slices that come round the edge touch one
  by one.

  Not so where a boundary is bilateral, which fixes the faces that touched at the start, or cut the lattice of points,
  whose faces are steps.
*/
#include "geometry/geometry.h"
#include "facets/facets.h"

#define SHARP 0.9  /* cosine between the normals on both sides of an edge, at most */
#define OFF   1e-6 /* of a cell: so far from the surface, a place on a face's plane is beyond its edge */
#define BENT \
  0.1 /* of the way from a face's middle to its corner: so far off a plane's the distance there shows an edge */

/* True where the surface ends, or bends, no farther than a cell of sizes h from a facet, along its plane. */
static PetscBool EdgeIsNear(const MpmFacets *facets, const PetscReal h[], const MpmFacet *facet,
                            const MpmSurface *surface)
{
  const PetscInt dim = facets->boundaries[facet->boundary].dim;

  for (PetscInt k = 0; k < 2 * dim; k++) {
    const PetscReal way             = k % 2 ? h[k / 2] : -h[k / 2];
    const PetscReal off             = surface->distance + way * surface->normal[k / 2];
    PetscReal       at[MPM_MAX_DIM] = {0., 0., 0.}, cosine = 0.;
    MpmSurface      there;

    for (PetscInt a = 0; a < dim; a++) at[a] = facet->place[a] + (a == k / 2 ? way : 0.) - off * surface->normal[a];
    MpmFacetsDistance(facets, facet->boundary, at, &there);
    for (PetscInt a = 0; a < dim; a++) cosine += there.normal[a] * surface->normal[a];
    if (PetscAbsReal(there.distance) > OFF * facets->cell && cosine < SHARP) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* From the face's middle to its place with coordinates s and t from -1 to 1 along its sides. */
static void AlongFace(PetscInt dim, PetscReal (*sides)[MPM_MAX_DIM], PetscReal s, PetscReal t, PetscReal way[])
{
  for (PetscInt a = 0; a < dim; a++) way[a] = s * sides[0][a] + (dim > 2 ? t * sides[1][a] : 0.);
}

/* True where the distances at the face's corners are not those from a plane. */
static PetscBool MeetsEdge(const MpmFacets *facets, PetscReal (*sides)[MPM_MAX_DIM], const MpmFacet *facet)
{
  const PetscInt dim = facets->boundaries[facet->boundary].dim;
  MpmSurface     middle, corner;

  MpmFacetsDistance(facets, facet->boundary, facet->place, &middle);
  for (PetscInt k = 0; k < PetscPowInt(2, dim - 1); k++) {
    PetscReal at[MPM_MAX_DIM] = {0., 0., 0.}, flat = middle.distance, square = 0.;

    AlongFace(dim, sides, k % 2 ? 1. : -1., k / 2 ? 1. : -1., at);
    for (PetscInt a = 0; a < dim; a++) {
      flat += middle.normal[a] * at[a];
      square += PetscSqr(at[a]);
      at[a] += facet->place[a];
    }
    MpmFacetsDistance(facets, facet->boundary, at, &corner);
    if (PetscAbsReal(corner.distance - flat) > BENT * PetscSqrtReal(square)) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

PetscInt MpmFacetAtEdge(const MpmFacets *facets, const PetscReal h[], PetscReal (*sides)[MPM_MAX_DIM],
                        const MpmSurface *surface, MpmFacet *facet)
{
  const MpmBoundary *boundary = &facets->boundaries[facet->boundary];

  if (!MpmSolidHasFaces(&boundary->solid) || boundary->bilateral || facets->cut[facet->boundary]) return 0;
  facet->key.single = (PetscInt)EdgeIsNear(facets, h, facet, surface);
  return facet->key.single && MeetsEdge(facets, sides, facet) ? PetscPowInt(MPM_SLICES, boundary->dim - 1) : 0;
}

void MpmFacetSlicePlace(PetscInt dim, PetscReal (*sides)[MPM_MAX_DIM], MpmFacet *slice)
{
  const PetscInt k = slice->key.slice - 1;
  PetscReal      way[MPM_MAX_DIM];

  AlongFace(dim, sides, (PetscReal)(2 * (k % MPM_SLICES) + 1) / MPM_SLICES - 1.,
            (PetscReal)(2 * (k / MPM_SLICES) + 1) / MPM_SLICES - 1., way);
  for (PetscInt a = 0; a < dim; a++) slice->place[a] += way[a];
}
