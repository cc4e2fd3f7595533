/*
  Facets of round bodies at rigid surfaces: discs, spheres, cylinders.

  The surface of such a body's region cuts its lattice of points into steps, on which it would roll. The true surface is
  known, and the material carries it along: a place of a face, y0 at the start, belongs to the place z0 of the surface
  along the surface's normal N there; now

    z = x + F (z0 - x0) ,   n = F^-T N/|F^-T N| ,   dA = a . n ,

  x the point, a the area that the face has there. The sum of dA over the steps is the area of the surface. Each face
  has SITES such places on each axis, where a boundary is near, each a facet and a patch by itself: where a round
  surface meets another one, only little of a cell's touches, and its mean distance there would go up and down as the
  body rolls over the cells.

  The pressure of a rolling contact moves over the material by R dW a step, dW the angle of rotation. In a step that
  balances forces at a fraction theta of it, as the generalised-alpha method does, a body would be pushed at places that
  are (1 - theta) R dW ahead. The contribution of rotation alone to a facet's distance between then and the step's end,
  with the spin W of the step's start,

    dg = (1 - theta) dt n . W (r + (1 + theta)/2 dt W r) ,   r = R N ,

  does therefore not count. All other motion does, so that the contact is as stiff at the step's end as it is elsewhere.

  A face belongs to the surface where that took the next point of the lattice; later openings are as they were cut.
*/
#include "geometry/geometry.h"
#include "particles/body.h"
#include "facets/outer_faces.h"
#include "particles/points.h"
#include "space/sum.h"
#include "transfer/motion.h"
#include "facets/facets.h"

#define SITES 4    /* places of a face on each axis: a disc rolls on fewer like a polygon; with 8 nothing changes */
#define SLACK 1.01 /* of the distance between points: domains may have been stretched */
#define SAME  1e-6 /* of a domain: depths below one surface */

/* The round region whose surface took the next point of the lattice beyond a face, or NULL. */
static MpmRegion RegionBeyond(const MpmFacets *facets, const MpmPoints *points, PetscInt dim, PetscInt p, PetscInt face)
{
  const PetscReal *half   = &points->domain.drawn[p * dim];
  const PetscReal  size   = half[face / 2];
  const MpmBody    body   = MpmBodyOfPoint(facets->shaped, points->id[p]);
  const MpmRegion  region = body ? MpmBodyRound(body) : NULL;
  PetscReal        at[MPM_MAX_DIM], normal[MPM_MAX_DIM], N[MPM_MAX_DIM], depth, along;

  if (!region || !MpmRegionCut(region, &points->origin[p * dim], half, normal, &depth)) return NULL;
  for (PetscInt a = 0; a < dim; a++) at[a] = points->origin[p * dim + a];
  if (PetscAbsReal(MpmRegionToRound(region, at, N) - depth) > SAME * size) return NULL; /* a cylinder's end is nearer */
  along = (face % 2 ? 1. : -1.) * N[face / 2];
  if (MpmRegionClips(region, &points->origin[p * dim], face / 2, face % 2)) return NULL;
  return along > 0. && depth < 2. * SLACK * along * size ? region : NULL;
}

PetscBool MpmFacetsSeeRound(const MpmFacets *facets, const MpmPoints *points, PetscInt b, PetscInt p, PetscInt face)
{
  const MpmBoundary *boundary = &facets->boundaries[b];

  return (PetscBool)(!boundary->bilateral && !boundary->augmented &&
                     RegionBeyond(facets, points, boundary->dim, p, face));
}

/* A place of a face, `of` of them on each axis, put onto the surface; `at` was it at the start. */
typedef struct {
  PetscInt  k, of;
  PetscReal at[MPM_MAX_DIM], outward[MPM_MAX_DIM]; /* outward: the normal now, times the area seen along it */
} Site;

static void PlaceSite(MpmRegion region, const MpmPoints *points, PetscInt dim, PetscInt face, MpmFacet *facet,
                      Site *site)
{
  const PetscInt   p = facet->point;
  const PetscReal *F = MpmPointF(points, p), *drawn = &points->domain.drawn[p * dim];
  PetscReal        arm[MPM_MAX_DIM], area[MPM_MAX_DIM], N[MPM_MAX_DIM], seen = 0., share = 1.;

  MpmOuterFace(dim, F, &points->domain.half_length[p * dim], face / 2, face % 2, arm, area);
  for (PetscInt a = 0, k = site->k; a < dim; a++) {
    site->at[a] = points->origin[p * dim + a];
    if (a == face / 2) site->at[a] += (face % 2 ? 1. : -1.) * drawn[a];
    else {
      site->at[a] += drawn[a] * ((PetscReal)(2 * (k % site->of) + 1) / (PetscReal)site->of - 1.);
      share /= (PetscReal)site->of;
      k /= site->of;
    }
  }
  (void)MpmRegionToRound(region, site->at, N);
  (void)MpmOuterNormal(dim, F, N, site->outward);
  for (PetscInt a = 0; a < dim; a++) {
    facet->place[a] = points->x[p * dim + a];
    for (PetscInt c = 0; c < dim; c++)
      facet->place[a] +=
        F[a * dim + c] * (site->at[c] - points->origin[p * dim + c]) * MpmPointReference(points, dim, p, c);
    seen += share * area[a] * site->outward[a];
    facet->arm[a] = MpmRegionRadius(region) * site->outward[a];
  }
  for (PetscInt a = 0; a < dim; a++) site->outward[a] *= PetscMax(seen, 0.);
}

PetscErrorCode MpmFacetsAddRound(MpmFacets *facets, PetscReal margin, const MpmPoints *points, PetscInt face,
                                 const MpmFacet *start)
{
  const MpmBoundary *boundary = &facets->boundaries[start->boundary];
  const MpmPose      still    = {.growth = 0.};
  const PetscInt     dim      = boundary->dim;
  const MpmRegion    region   = RegionBeyond(facets, points, dim, start->point, face);
  MpmFacet           facet    = *start;
  Site               site     = {.of = 1};
  MpmSurface         surface;

  PetscFunctionBeginUser;
  PlaceSite(region, points, dim, face, &facet, &site);
  MpmFacetsDistance(facets, facet.boundary, facet.place, &surface);
  if (surface.distance > margin) PetscFunctionReturn(PETSC_SUCCESS);
  if (surface.distance < facets->cell) site.of = SITES;
  for (; site.k < PetscPowInt(site.of, dim - 1); site.k++) {
    facet           = *start;
    facet.key.round = 1;
    PlaceSite(region, points, dim, face, &facet, &site);
    MpmFacetStartDistance(facets, site.outward, &facet, &surface);
    for (PetscInt a = 0; a < dim; a++) {
      facet.normal[a] = surface.normal[a];
      facet.area -= site.outward[a] * surface.normal[a];
    }
    if (!(facet.area > 0.)) continue;
    MpmBoundaryDistance(boundary, &still, site.at, &surface);
    facet.touches = PetscMin(surface.distance, 0.);
    PetscCall(MpmFacetsAdd(facets, &facet));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFacetsTurn(MpmFacets *facets, const MpmSum *sum, const PetscReal v[], PetscReal part)
{
  PetscFunctionBeginUser;
  if (!facets->shaped || part == 1.) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt f = 0; f < facets->count; f++) {
    MpmFacet      *facet = &facets->at[f];
    const PetscInt dim   = facets->boundaries[facet->boundary].dim;
    PetscReal      W[MPM_MAX_DIM * MPM_MAX_DIM], way[MPM_MAX_DIM];

    if (!facet->key.round || MpmFacetsBody(facets, facet->boundary)) continue;
    PetscCall(MpmSpinAtPoint(sum, facet->group, facet->point, v, W));
    for (PetscInt a = 0; a < dim; a++) {
      way[a] = 0.;
      for (PetscInt c = 0; c < dim; c++) way[a] += W[a * dim + c] * facet->arm[c];
    }
    facet->turn = 0.;
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal again = 0.;

      for (PetscInt c = 0; c < dim; c++) again += W[a * dim + c] * way[c];
      facet->turn +=
        (1. - part) * sum->step.dt * facet->normal[a] * (way[a] + 0.5 * (1. + part) * sum->step.dt * again);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
