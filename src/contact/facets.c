/*
  Facets: where they stand from their boundary as a step starts, and the list of them.
*/
#include "geometry/geometry.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"

#define ENTRY_STEP  0.02 /* of a cell, at least */
#define ENTRY_STEPS 100

void MpmContactsDistance(const MpmContacts *contacts, PetscInt b, const PetscReal x[], MpmSurface *surface)
{
  const MpmRigidBody *body = MpmContactsBody(contacts, b);

  if (body) MpmRigidDistance(body, &contacts->boundaries[b], &contacts->before[b], x, surface);
  else MpmBoundaryDistance(&contacts->boundaries[b], &contacts->before[b], x, surface);
}

/*
  Distance of a facet inside a boundary with flat faces, from the plane of the face that it came through: the first on
  the way back along its outward normal, which another one may be nearer than; no further than a cell: a face in a plane
  of symmetry under the middle of a footing did not come through the footing's side. The way goes from place to place by
  what is free of the surface.
*/
static void EntryDistance(const MpmContacts *contacts, const PetscReal outward[], const MpmFacet *facet,
                          MpmSurface *surface)
{
  const MpmBoundary *boundary        = &contacts->boundaries[facet->boundary];
  const PetscInt     dim             = boundary->dim;
  PetscReal          at[MPM_MAX_DIM] = {0., 0., 0.}, size = 0., way = 0.;
  MpmSurface         there = *surface;

  for (PetscInt a = 0; a < dim; a++) size += PetscSqr(outward[a]);
  size = PetscSqrtReal(size);
  for (PetscInt a = 0; a < dim; a++) at[a] = facet->place[a];
  for (PetscInt k = 0; there.distance < -contacts->touch; k++) {
    const PetscReal step = PetscMax(-there.distance, ENTRY_STEP * contacts->cell) / size;

    way += step * size;
    if (k == ENTRY_STEPS || !(size > 0.) || way > contacts->cell) return;
    for (PetscInt a = 0; a < dim; a++) at[a] -= step * outward[a];
    MpmBoundaryDistance(boundary, &contacts->before[facet->boundary], at, &there);
  }
  *surface = there;
  for (PetscInt a = 0; a < dim; a++) surface->distance += (facet->place[a] - at[a]) * there.normal[a];
}

void MpmContactsStartDistance(const MpmContacts *contacts, const PetscReal outward[], MpmFacet *facet,
                              MpmSurface *surface)
{
  const MpmBoundary *boundary = &contacts->boundaries[facet->boundary];
  const MpmPose     *before   = &contacts->before[facet->boundary];
  const MpmPose      rest     = {.growth = 0.};
  PetscReal          curved = 0., normal[MPM_MAX_DIM] = {0., 0., 0.};
  PetscInt           axis = 0;

  facet->side = 0;
  MpmContactsDistance(contacts, facet->boundary, facet->place, surface);
  if (MpmContactsBody(contacts, facet->boundary) || !MpmSolidHasFaces(&boundary->solid)) return;
  EntryDistance(contacts, outward, facet, surface);
  for (PetscInt a = 0; a < boundary->dim; a++)
    for (PetscInt c = 0; c < boundary->dim; c++) curved += PetscAbsReal(surface->second[a][c]);
  facet->distance = surface->distance;
  if (curved > 0.) return;
  MpmPoseTurn(boundary->dim, before, &rest, surface->normal, normal);
  for (PetscInt a = 1; a < boundary->dim; a++)
    if (PetscAbsReal(normal[a]) > PetscAbsReal(normal[axis]) * (1. + MPM_ALIGNED)) axis = a;
  facet->side = 2 * axis + (normal[axis] > 0. ? 2 : 1);
}

PetscErrorCode MpmContactsAddFacet(MpmContacts *contacts, const MpmFacet *facet)
{
  PetscFunctionBeginUser;
  if (contacts->facet_count == contacts->capacity) {
    contacts->capacity = 2 * contacts->capacity + 64;
    PetscCall(PetscRealloc((size_t)contacts->capacity * sizeof(MpmFacet), &contacts->facet));
  }
  contacts->facet[contacts->facet_count++] = *facet;
  PetscFunctionReturn(PETSC_SUCCESS);
}
