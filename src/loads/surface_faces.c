/*
  The faces of surfaces in a step, with their areas and their weights at the nodes.

  A face is one of a point's domain (outer_faces.c) that bounded the material as the stage began and still does. Its
  place is y = x + F l_a e_a, its outward area a = cof(F) A_a e_a. Its weights (facet_weights.c) are at nodes that the
  point itself touches, and the work of the face's load in a uniform strain is exact.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "facets/outer_faces.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/point_shape.h"
#include "space/space.h"
#include "bc/bc.h"
#include "contact/contact.h"
#include "loads/body_surface.h"
#include "loads/load.h"

PetscErrorCode MpmSurfaceFacesCreate(const MpmBodySurfaces *surfaces, MpmLoadActing *acting, MpmSurfaceFaces *faces)
{
  PetscFunctionBeginUser;
  *faces = (MpmSurfaceFaces){.surfaces = surfaces, .acting = acting, .component = -1};
  PetscCall(PetscCalloc4(surfaces->count, &faces->factor, surfaces->count, &faces->pressure, surfaces->count,
                         &faces->outflow, surfaces->count, &faces->first));
  for (PetscInt k = 0; k < surfaces->count; k++) faces->any_held = (PetscBool)(faces->any_held || surfaces->at[k].held);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfaceFacesDestroy(MpmSurfaceFaces *faces)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(faces->factor, faces->pressure, faces->outflow, faces->first));
  PetscCall(PetscFree(faces->list.at));
  PetscCall(PetscFree(faces->list.weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the point belongs to the surface's body, and the surface acts. */
static PetscBool Has(const MpmSurfaceFaces *faces, PetscInt surface, PetscInt id)
{
  const MpmLoadActing *acting = &faces->acting[surface];

  return (PetscBool)(acting->active && id >= acting->first && id < acting->end);
}

/* The faces that are still outer ones of those that a surface may have. Collective. */
static PetscErrorCode FindOuter(const MpmSurfaceFaces *faces, const MpmRules *rules, const MpmPoints *points,
                                PetscInt outer[])
{
  PetscInt *asked;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(points->count, &asked));
  for (PetscInt k = 0; k < faces->surfaces->count; k++)
    for (PetscInt p = 0; p < points->count; p++)
      if (Has(faces, k, points->id[p])) asked[p] |= points->domain.faces[p] & faces->surfaces->at[k].faces;
  PetscCall(MpmOuterFacesFind(rules->grid, points, rules->materials, points->domain.part, asked, outer));
  PetscCall(PetscFree(asked));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- faces ---- */

static void FaceWeights(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                        PetscReal weight[])
{
  const MpmGroup *group = &space->groups[facet->group];
  PetscReal       line[MPM_MAX_DIM][MPM_MAX_WIDTH];

  MpmFacetLines(rules, space, points, facet, line);
  MpmLinesMultiply(space->dim, group, line, weight);
}

static PetscErrorCode Reserve(MpmSurfaceFaces *faces, PetscInt weights)
{
  PetscFunctionBeginUser;
  if (faces->list.count == faces->list.capacity) {
    faces->list.capacity = 2 * faces->list.capacity + 64;
    PetscCall(PetscRealloc((size_t)faces->list.capacity * sizeof(MpmSurfaceFace), &faces->list.at));
  }
  if (weights > faces->list.weights) {
    faces->list.weights = 2 * weights + 1024;
    PetscCall(PetscRealloc((size_t)faces->list.weights * sizeof(PetscReal), &faces->list.weight));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  True where the face at y touches the surface's boundary: its normal is towards the boundary, and its distance at most
  half a point's spacing, that of faces where the boundary cut a lattice.
*/
static PetscBool Touches(const MpmSurfaceFaces *faces, PetscInt surface, const MpmPoints *points, PetscInt p,
                         const PetscReal y[], const PetscReal area[])
{
  const PetscInt b     = faces->surfaces->at[surface].boundary;
  PetscReal      along = 0., reach = 0.;
  MpmSurface     there;

  if (b < 0) return PETSC_TRUE;
  if (!MpmRegionContains(faces->contacts->facets.boundaries[b].region,
                         &points->origin[p * faces->contacts->facets.boundaries[b].dim]))
    return PETSC_FALSE;
  MpmFacetsDistance(&faces->contacts->facets, b, y, &there);
  for (PetscInt a = 0; a < faces->contacts->facets.boundaries[b].dim; a++) {
    along += area[a] * there.normal[a];
    reach +=
      PetscAbsReal(there.normal[a]) * points->domain.half_length[p * faces->contacts->facets.boundaries[b].dim + a];
  }
  return (PetscBool)(along < 0. && there.distance <= reach);
}

#define SAMPLES 16 /* places across a face, an axis */

/*
  The part of a face that lies in the surface's region, by its place in the initial state, from evenly spread places.
  Water passes all of a face, or none.
*/
static PetscReal PartInRegion(const MpmBodySurface *surface, PetscInt dim, const MpmPoints *points, PetscInt p,
                              PetscInt face)
{
  const PetscInt axis = face / 2, along[2] = {(axis + 1) % dim, (axis + 2) % dim},
                 count     = PetscPowInt(SAMPLES, dim - 1);
  PetscReal x[MPM_MAX_DIM] = {0., 0., 0.};
  PetscInt  inside         = 0;

  if (!surface->region) return 1.;
  for (PetscInt a = 0; a < dim; a++) x[a] = points->origin[p * dim + a];
  x[axis] += (face % 2 ? 1. : -1.) * points->domain.half_length[p * dim + axis];
  for (PetscInt k = 0; k < count; k++) {
    for (PetscInt d = 0; d < dim - 1; d++) {
      const PetscInt a = along[d], q = d ? k / SAMPLES : k % SAMPLES;

      x[a] = points->origin[p * dim + a] +
             points->domain.half_length[p * dim + a] * ((2. * (PetscReal)q + 1.) / (PetscReal)SAMPLES - 1.);
    }
    inside += MpmRegionContains(surface->region, x) ? 1 : 0;
  }
  if (surface->held) return 2 * inside >= count ? 1. : 0.;
  return (PetscReal)inside / (PetscReal)count;
}

PetscBool MpmBodySurfaceIsAll(const MpmBodySurface *surface, PetscInt dim)
{
  return (PetscBool)(surface->boundary < 0 && surface->faces == (1 << (2 * dim)) - 1);
}

#define SKEW 0.5 /* of a face's area along the axis: more across it is another face */
#define NEAR 0.5 /* of a point's distance: a face so near a plane of nodes lies on it */

/*
  The first active condition that constrains the material along the normal of a face of point p, 2 axis + side, at its
  middle, -1: none. Such a face of a surface on all sides lies on a plane of symmetry and is left out.
*/
static PetscInt FaceHeld(const MpmSurfaceFaces *faces, const MpmGrid *grid, const MpmPoints *points, PetscInt p,
                         PetscInt face)
{
  const PetscInt dim = grid->dim;
  PetscReal      arm[MPM_MAX_DIM], area[MPM_MAX_DIM] = {0., 0., 0.}, at[MPM_MAX_DIM], start[MPM_MAX_DIM];
  PetscReal      plane, across                       = 0.;
  PetscInt       axis = 0;

  MpmOuterFace(dim, MpmPointF(points, p), &points->domain.half_length[p * dim], face / 2, face % 2, arm, area);
  for (PetscInt a = 1; a < dim; a++)
    if (PetscAbsReal(area[a]) > PetscAbsReal(area[axis])) axis = a;
  for (PetscInt a = 0; a < dim; a++) {
    at[a] = points->x[p * dim + a] + arm[a];
    if (a != axis) across = PetscMax(across, PetscAbsReal(area[a]));
  }
  if (across > SKEW * PetscAbsReal(area[axis])) return -1;
  plane = grid->lower[axis] + grid->h[axis] * round((at[axis] - grid->lower[axis]) / grid->h[axis]);
  if (PetscAbsReal(at[axis] - plane) <= NEAR * PetscAbsReal(arm[axis])) at[axis] = plane;
  MpmGridAtStart(grid, at, start);
  for (PetscInt b = 0; b < faces->bcs->count; b++)
    if (faces->bcs_acting[b].active && MpmConditionFixes(&faces->bcs->at[b], axis) &&
        MpmRegionContains(faces->bcs->at[b].region, start))
      return b;
  return -1;
}

PetscErrorCode MpmSurfaceFacesFindHeld(const MpmSurfaceFaces *faces, const MpmGrid *grid, MpmParticles *particles,
                                       PetscInt surface, PetscInt held[])
{
  const PetscInt dim = grid->dim;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(held, faces->bcs->count));
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt k = 0; k < 2 * dim * points.count; k++) {
    const PetscInt p = k / (2 * dim), face = k % (2 * dim);
    PetscInt       b;

    if (!Has(faces, surface, points.id[p]) || !(points.domain.faces[p] & MpmFaceBit(face / 2, face % 2))) continue;
    b = FaceHeld(faces, grid, &points, p, face);
    if (b >= 0) held[b] = 1;
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, held, (PetscMPIInt)faces->bcs->count, MPIU_INT, MPI_MAX, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The faces of point p among the bits `outer`; `used`: weights that there are. */
static PetscErrorCode FacesOfPoint(MpmSurfaceFaces *faces, const MpmRules *rules, const MpmPoints *points,
                                   const MpmSpace *space, const MpmFacet *start, PetscInt outer, PetscInt *used)
{
  const PetscInt  dim = space->dim, p = start->point, nodes = space->groups[start->group].node_count;
  const PetscReal volume = points->volume0[p] * MpmPointJ(points, p);
  PetscInt        held   = 0; /* where water passes a surface; it passes once */

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 2 * dim * faces->surfaces->count; k++) {
    const PetscInt surface = k / (2 * dim), face = k % (2 * dim), bit = MpmFaceBit(face / 2, face % 2);
    MpmFacet       facet = *start;
    PetscReal      arm[MPM_MAX_DIM], area[MPM_MAX_DIM] = {0., 0., 0.}, part;

    if (!(outer & faces->surfaces->at[surface].faces & bit) || !Has(faces, surface, points->id[p])) continue;
    if (faces->surfaces->at[surface].boundary >= 0 && (held & bit)) continue;
    part = PartInRegion(&faces->surfaces->at[surface], dim, points, p, face);
    if (!(part > 0.)) continue;
    MpmOuterFace(dim, MpmPointF(points, p), &points->domain.half_length[p * dim], face / 2, face % 2, arm, area);
    for (PetscInt a = 0; a < dim; a++) facet.place[a] = points->x[p * dim + a] + arm[a];
    if (!Touches(faces, surface, points, p, facet.place, area)) continue;
    if (faces->bcs && MpmBodySurfaceIsAll(&faces->surfaces->at[surface], dim) &&
        FaceHeld(faces, rules->grid, points, p, face) >= 0)
      continue;
    if (faces->surfaces->at[surface].held) held |= bit;
    PetscCall(Reserve(faces, *used + nodes));
    FaceWeights(rules, space, points, &facet, &faces->list.weight[*used]);
    faces->list.at[faces->list.count] = (MpmSurfaceFace){
      .surface = surface, .point = p, .group = start->group, .weight = *used, .side = face, .part = part};
    part *= MpmTurn(points->F_size, facet.place[0]);
    for (PetscInt a = 0; a < dim; a++) {
      faces->list.at[faces->list.count].place[a]    = facet.place[a];
      faces->list.at[faces->list.count].area[a]     = part * area[a];
      faces->list.at[faces->list.count].per_area[a] = part * area[a] / volume;
    }
    faces->list.count++;
    *used += nodes;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfaceFacesFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmSurfaceFaces *faces = (MpmSurfaceFaces *)ctx;
  PetscBool        any   = PETSC_FALSE;
  PetscInt        *outer, used = 0;

  PetscFunctionBeginUser;
  faces->list.count = 0;
  for (PetscInt k = 0; k < faces->surfaces->count; k++) any = (PetscBool)(any || faces->acting[k].active);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(points->count, &outer));
  PetscCall(FindOuter(faces, rules, points, outer));
  for (PetscInt g = 0; g < space->group_count; g++) {
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      const MpmFacet facet = {.point = space->order[s], .group = g};

      if (outer[facet.point]) PetscCall(FacesOfPoint(faces, rules, points, space, &facet, outer[facet.point], &used));
    }
  }
  PetscCall(PetscFree(outer));
  PetscCall(MpmSurfaceFacesToBoxes(faces, points, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodySurfacesCheck(const MpmBodySurfaces *surfaces, const MpmLoadActing *acting,
                                    MpmParticles *particles)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  if (!surfaces->count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt k = 0; k < surfaces->count; k++) {
    PetscInt count[2] = {0, 0}; /* points of the body, and those with a face of the surface */

    for (PetscInt p = 0; p < points.count; p++) {
      if (points.id[p] < acting[k].first || points.id[p] >= acting[k].end) continue;
      count[0]++;
      for (PetscInt face = 0; face < 2 * particles->dim; face++) {
        if (!(points.domain.faces[p] & surfaces->at[k].faces & MpmFaceBit(face / 2, face % 2))) continue;
        count[1] += PartInRegion(&surfaces->at[k], particles->dim, &points, p, face) > 0. ? 1 : 0;
      }
    }
    PetscCall(
      MPIU_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT, MPI_SUM, PetscObjectComm((PetscObject)particles->swarm)));
    MpmCheckInput(k >= surfaces->named || !acting[k].active || !count[0] || count[1],
                  "-mpm_surface_%s_%s: the material does not end there: no face of its body%s bounds it",
                  surfaces->names[k], surfaces->at[k].region ? "region" : "side",
                  surfaces->at[k].region ? " in the region" : "");
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}
