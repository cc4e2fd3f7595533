/*
  Where facets stand from their boundary as a step starts, and the list of them.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "rigid/rigid_motion.h"
#include "facets/facets.h"

#define ENTRY_STEP  0.02 /* of a cell, at least */
#define ENTRY_STEPS 100

const MpmRigidBody *MpmFacetsBody(const MpmFacets *facets, PetscInt b)
{
  return facets->bodies && facets->bodies[b].freedom ? &facets->bodies[b] : NULL;
}

void MpmFacetsDistance(const MpmFacets *facets, PetscInt b, const PetscReal x[], MpmSurface *surface)
{
  const MpmRigidBody *body = MpmFacetsBody(facets, b);

  if (body) MpmRigidDistance(body, &facets->boundaries[b], &facets->before[b], x, surface);
  else MpmBoundaryDistance(&facets->boundaries[b], &facets->before[b], x, surface);
}

/*
  Distance of a facet inside a boundary with flat faces, from the plane of the face that it came through: the first on
  the way back along its outward normal, which another one may be nearer than; no further than a cell: a face in a plane
  of symmetry under the middle of a footing did not come through the footing's side. The way goes from place to place by
  what is free of the surface.
*/
static void EntryDistance(const MpmFacets *facets, const PetscReal outward[], const MpmFacet *facet,
                          MpmSurface *surface)
{
  const MpmBoundary *boundary        = &facets->boundaries[facet->boundary];
  const PetscInt     dim             = boundary->dim;
  PetscReal          at[MPM_MAX_DIM] = {0., 0., 0.}, size = 0., way = 0.;
  MpmSurface         there = *surface;

  for (PetscInt a = 0; a < dim; a++) size += PetscSqr(outward[a]);
  size = PetscSqrtReal(size);
  for (PetscInt a = 0; a < dim; a++) at[a] = facet->place[a];
  for (PetscInt k = 0; there.distance < -facets->touch; k++) {
    const PetscReal step = PetscMax(-there.distance, ENTRY_STEP * facets->cell) / size;

    way += step * size;
    if (k == ENTRY_STEPS || !(size > 0.) || way > facets->cell) return;
    for (PetscInt a = 0; a < dim; a++) at[a] -= step * outward[a];
    MpmBoundaryDistance(boundary, &facets->before[facet->boundary], at, &there);
  }
  *surface = there;
  for (PetscInt a = 0; a < dim; a++) surface->distance += (facet->place[a] - at[a]) * there.normal[a];
}

void MpmFacetStartDistance(const MpmFacets *facets, const PetscReal outward[], MpmFacet *facet, MpmSurface *surface)
{
  const MpmBoundary *boundary = &facets->boundaries[facet->boundary];
  const MpmPose     *before   = &facets->before[facet->boundary];
  const MpmPose      rest     = {.growth = 0.};
  PetscReal          curved = 0., normal[MPM_MAX_DIM] = {0., 0., 0.};
  PetscInt           axis = 0;

  facet->key.side = 0;
  MpmFacetsDistance(facets, facet->boundary, facet->place, surface);
  if (MpmFacetsBody(facets, facet->boundary) || !MpmSolidHasFaces(&boundary->solid)) return;
  EntryDistance(facets, outward, facet, surface);
  for (PetscInt a = 0; a < boundary->dim; a++)
    for (PetscInt c = 0; c < boundary->dim; c++) curved += PetscAbsReal(surface->second[a][c]);
  facet->distance = surface->distance;
  if (curved > 0.) return;
  MpmPoseTurn(boundary->dim, before, &rest, surface->normal, normal);
  for (PetscInt a = 1; a < boundary->dim; a++)
    if (PetscAbsReal(normal[a]) > PetscAbsReal(normal[axis]) * (1. + MPM_ALIGNED)) axis = a;
  facet->key.side = 2 * axis + (normal[axis] > 0. ? 2 : 1);
}

PetscErrorCode MpmFacetsAdd(MpmFacets *facets, const MpmFacet *facet)
{
  PetscFunctionBeginUser;
  if (facets->count == facets->capacity) {
    facets->capacity = 2 * facets->capacity + 64;
    PetscCall(PetscRealloc((size_t)facets->capacity * sizeof(MpmFacet), &facets->at));
  }
  facets->at[facets->count++] = *facet;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt64 MpmFacetCell(const MpmGrid *grid, const PetscReal x[], PetscInt part)
{
  PetscInt64 number = part;
  PetscInt   at[MPM_MAX_DIM];

  MpmGridFindPart(grid, x, at);
  for (PetscInt a = grid->dim - 1; a >= 0; a--) number = number * (grid->order * grid->cells[a]) + at[a];
  return number;
}

void MpmFacetsSetPoses(MpmFacets *facets, PetscReal time_n, PetscReal time)
{
  for (PetscInt b = 0; b < facets->boundary_count; b++) {
    facets->before[b] = (MpmPose){.growth = 0.};
    if (time_n > 0.) facets->before[b] = MpmBoundaryPose(&facets->boundaries[b], time_n);
    facets->after[b] = MpmBoundaryPose(&facets->boundaries[b], time);
  }
}
