/*
  Faces as they stood at the start: where a surface cut the lattice of points, and which faces touched it.

  Where a surface cut the lattice, faces stand up to half a point's spacing off it, on either side, and well behind it
  in places. Faces that touched keep their distance from then on, stretched as the material is across the surface.
*/
#include "geometry/geometry.h"
#include "particles/body.h"
#include "facets/outer_faces.h"
#include "particles/points.h"
#include "grid/grid.h"
#include "facets/facets.h"

#define CUT   0.05 /* of a half-length: so deep a face starts where a surface cut the lattice */
#define DRAWN 1.25 /* by this factor has a face's area changed that is drawn out or crowded */
#define HAIR  2e-3 /* of a half-length: so far from a surface a face rests on it all the same */

/* Where the middle of a face was at the start. */
static void InitialPlace(PetscInt dim, const MpmPoints *points, PetscInt p, PetscInt face, PetscReal at[])
{
  for (PetscInt a = 0; a < dim; a++) at[a] = points->origin[p * dim + a];
  at[face / 2] += (face % 2 ? 1. : -1.) * points->domain.drawn[p * dim + face / 2];
}

/* True where a face of the lattice is parallel to a surface: then it is no step where the surface cut the lattice. */
static PetscBool Aligned(const PetscReal normal[], PetscInt face)
{
  return (PetscBool)((face % 2 ? -1. : 1.) * normal[face / 2] > 1. - MPM_ALIGNED);
}

PetscErrorCode MpmFacetsFindCuts(MpmFacets *facets, const MpmGrid *grid, const MpmPoints *points)
{
  const MpmPose  still = {.growth = 0.};
  const PetscInt dim   = grid->dim;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(facets->boundary_count, &facets->cut));
  for (PetscInt k = 0; k < facets->boundary_count * points->count; k++) {
    const MpmBoundary *boundary = &facets->boundaries[k / points->count];
    const PetscInt     p        = k % points->count;

    if (!points->domain.faces[p] || !MpmRegionContains(boundary->region, &points->origin[p * dim])) continue;
    for (PetscInt face = 0; face < 2 * dim && !facets->cut[k / points->count]; face++) {
      PetscReal  at[MPM_MAX_DIM];
      MpmSurface surface;

      if (!(points->domain.faces[p] & MpmFaceBit(face / 2, face % 2))) continue;
      if (MpmFacetsSeeRound(facets, points, k / points->count, p, face)) continue;
      InitialPlace(dim, points, p, face, at);
      MpmBoundaryDistance(boundary, &still, at, &surface);
      if (Aligned(surface.normal, face)) continue;
      if (surface.distance < -CUT * points->domain.drawn[p * dim + face / 2])
        facets->cut[k / points->count] = PETSC_TRUE;
    }
  }
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, facets->cut, (PetscMPIInt)facets->boundary_count, MPM_MPI_BOOL, MPI_LOR, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  True where the face touched the boundary at the start, with the distance: where the boundary is the reason for which
  the lattice has no point beyond the face. A face along the surface is no step of a cut lattice: its gap is intended,
  unless the region of its body was drawn as far as to the surface. A touching face keeps its distance.
*/
PetscBool MpmFaceTouchedAtStart(const MpmFacets *facets, PetscInt b, const MpmPoints *points, PetscInt p, PetscInt face,
                                PetscReal *touches)
{
  const MpmBoundary *boundary = &facets->boundaries[b];
  const MpmPose      still    = {.growth = 0.};
  const PetscInt     dim = boundary->dim, axis = face / 2;
  const PetscReal    sign = face % 2 ? 1. : -1., half = points->domain.drawn[p * dim + axis];
  PetscReal          at[MPM_MAX_DIM], unused[MPM_MAX_DIM];
  MpmSurface         surface, beyond;
  PetscBool          aligned;

  InitialPlace(dim, points, p, face, at);
  MpmBoundaryDistance(boundary, &still, at, &surface);
  aligned  = Aligned(surface.normal, face);
  *touches = surface.distance;
  if (!aligned)
    *touches *=
      MpmOuterNormal(dim, MpmPointF(points, p), surface.normal, unused) * MpmPointReference(points, dim, p, axis);
  if (surface.distance <= 0.) return PETSC_TRUE;
  if (aligned) {
    const MpmBody body = surface.distance > HAIR * half && surface.distance < 2. * half
                           ? MpmBodyOfPoint(facets->shaped, points->id[p])
                           : NULL;

    at[axis] += sign * surface.distance;
    if (body && MpmBodyReaches(body, at)) return PETSC_TRUE;
  }
  if (aligned || !facets->cut[b]) {
    *touches = 0.;
    return (PetscBool)(surface.distance <= MPM_TOLERANCE * half);
  }
  at[axis] += sign * half;
  MpmBoundaryDistance(boundary, &still, at, &beyond);
  return (PetscBool)(beyond.distance <= 0.);
}

PetscErrorCode MpmFacetsFindDrawn(MpmFacets *facets, PetscInt b, const MpmGrid *grid, const MpmPoints *points)
{
  const PetscInt dim   = grid->dim;
  PetscBool      drawn = PETSC_FALSE;

  PetscFunctionBeginUser;
  facets->drawn[b] = PETSC_FALSE;
  if (!facets->cut[b] || !facets->boundaries[b].bilateral) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2 * dim * points->count && !drawn; k++) {
    const PetscInt p = k / (2 * dim), face = k % (2 * dim);
    PetscReal      arm[MPM_MAX_DIM], area[MPM_MAX_DIM], square = 0., start = 1.;

    if (!(points->domain.faces[p] & MpmFaceBit(face / 2, face % 2)) ||
        !MpmRegionContains(facets->boundaries[b].region, &points->origin[p * dim]) ||
        !MpmFaceTouchedAtStart(facets, b, points, p, face, &arm[0]))
      continue;
    MpmOuterFace(dim, MpmPointF(points, p), &points->domain.half_length[p * dim], face / 2, face % 2, arm, area);
    for (PetscInt a = 0; a < dim; a++) square += PetscSqr(area[a]);
    for (PetscInt a = 0; a < dim; a++) start *= a == face / 2 ? 1. : 2. * points->domain.drawn[p * dim + a];
    drawn = (PetscBool)(PetscSqrtReal(square) > DRAWN * start || PetscSqrtReal(square) < start / DRAWN);
  }
  PetscCall(MPIU_Allreduce(&drawn, &facets->drawn[b], 1, MPM_MPI_BOOL, MPI_LOR, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
