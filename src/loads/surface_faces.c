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
#include "loads/surface_cut.h"

PetscErrorCode MpmSurfaceFacesCreate(const MpmBodySurfaces *surfaces, MpmLoadActing *acting, MpmSurfaceFaces *faces)
{
  PetscFunctionBeginUser;
  *faces = (MpmSurfaceFaces){.surfaces = surfaces, .acting = acting, .component = -1};
  PetscCall(PetscCalloc4(surfaces->count, &faces->factor, surfaces->count, &faces->pressure, surfaces->count,
                         &faces->outflow, surfaces->count, &faces->first));
  PetscCall(PetscCalloc2(surfaces->count, &faces->drawn.pieces, surfaces->count, &faces->mean));
  for (PetscInt k = 0; k < surfaces->count; k++) faces->any_held = (PetscBool)(faces->any_held || surfaces->at[k].held);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfaceFacesDestroy(MpmSurfaceFaces *faces)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(faces->factor, faces->pressure, faces->outflow, faces->first));
  for (PetscInt k = 0; faces->drawn.pieces && k < faces->surfaces->count; k++)
    PetscCall(MpmEdgePiecesDestroy(&faces->drawn.pieces[k]));
  PetscCall(PetscFree2(faces->drawn.pieces, faces->mean));
  PetscCall(PetscFree(faces->drawn.present));
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

/* The part of a face that lies in the surface's region, by its place in the initial state. Water passes all of a face,
   or none. */
static PetscReal PartInRegion(const MpmBodySurface *surface, PetscInt dim, const MpmPoints *points, PetscInt p,
                              PetscInt face)
{
  const PetscInt axis = face / 2, u = (axis + 1) % dim, v = (axis + 2) % dim;
  PetscReal      x[MPM_MAX_DIM] = {0., 0., 0.}, along[2][MPM_MAX_DIM] = {{0.}}, part;

  if (!surface->region) return 1.;
  for (PetscInt a = 0; a < dim; a++) x[a] = points->origin[p * dim + a];
  x[axis] += (face % 2 ? 1. : -1.) * points->domain.half_length[p * dim + axis];
  along[0][u] = points->domain.half_length[p * dim + u];
  along[1][v] = points->domain.half_length[p * dim + v];
  part        = MpmFlatPart(surface->region, dim, along[0], along[1], x);
  return !surface->held ? part : part < 0.5 ? 0. : 1.;
}

PetscBool MpmBodySurfaceIsAll(const MpmBodySurface *surface, PetscInt dim)
{
  return (PetscBool)(surface->boundary < 0 && surface->faces == (1 << (2 * dim)) - 1);
}

#define SKEW 0.5 /* of a face's area along the axis: more across it is another face */
#define NEAR 0.5 /* of a point's distance: a face so near a plane of nodes lies on it */

/*
  The first active condition that constrains the material along the normal of a face of point p, 2 axis + side, at a
  place, NULL: its middle; -1: none. Such a face of a surface on all sides lies on a plane of symmetry and is left out.
*/
static PetscInt FaceHeld(const MpmSurfaceFaces *faces, const MpmGrid *grid, const MpmPoints *points, PetscInt p,
                         PetscInt face, const PetscReal place[])
{
  const PetscInt dim = grid->dim;
  PetscReal      arm[MPM_MAX_DIM], area[MPM_MAX_DIM] = {0., 0., 0.}, at[MPM_MAX_DIM], start[MPM_MAX_DIM];
  PetscReal      plane, across                       = 0.;
  PetscInt       axis = 0;

  MpmOuterFace(dim, MpmPointF(points, p), &points->domain.half_length[p * dim], face / 2, face % 2, arm, area);
  for (PetscInt a = 1; a < dim; a++)
    if (PetscAbsReal(area[a]) > PetscAbsReal(area[axis])) axis = a;
  for (PetscInt a = 0; a < dim; a++) {
    at[a] = place ? place[a] : points->x[p * dim + a] + arm[a];
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
    b = FaceHeld(faces, grid, &points, p, face, NULL);
    if (b >= 0) held[b] = 1;
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, held, (PetscMPIInt)faces->bcs->count, MPIU_INT, MPI_MAX, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a face of which area and place are known, without axial symmetry; its weights are those of the facet, NULL:
   those of a piece. */
static PetscErrorCode AddFace(MpmSurfaceFaces *faces, const MpmFaceSpace *at, MpmSurfaceFace *face,
                              const MpmFacet *facet)
{
  const MpmPoints *points = at->points;
  const PetscReal  turn   = MpmTurn(points->F_size, face->place[0]),
                  volume  = points->volume0[face->point] * MpmPointJ(points, face->point);
  const PetscInt used     = faces->list.used;

  PetscFunctionBeginUser;
  PetscCall(Reserve(faces, used + at->space->groups[face->group].node_count));
  face->weight = used;
  if (facet) FaceWeights(at->rules, at->space, points, facet, &faces->list.weight[used]);
  else MpmSurfaceCutWeights(at, face, &faces->list.weight[used]);
  for (PetscInt a = 0; a < at->space->dim; a++) {
    face->area[a] *= turn;
    face->per_area[a] = face->area[a] / volume;
  }
  faces->list.at[faces->list.count++] = *face;
  faces->list.used += at->space->groups[face->group].node_count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the face is on a plane of symmetry of a surface on all sides. */
static PetscBool OnSymmetry(const MpmSurfaceFaces *faces, const MpmFaceSpace *at, PetscInt surface, PetscInt p,
                            PetscInt face, const PetscReal place[])
{
  return (PetscBool)(faces->bcs && MpmBodySurfaceIsAll(&faces->surfaces->at[surface], at->space->dim) &&
                     FaceHeld(faces, at->rules->grid, at->points, p, face, place) >= 0);
}

/* The inner areas of a point at a cut edge, to one of its faces. */
static PetscErrorCode AddInner(MpmSurfaceFaces *faces, const MpmFaceSpace *at, const MpmEdgePoint *cut,
                               PetscReal loaded, MpmSurfaceFace *face)
{
  const PetscInt nodes = at->space->groups[face->group].node_count, room = at->space->dim * nodes;

  PetscFunctionBeginUser;
  PetscCall(Reserve(faces, faces->list.used + room + nodes));
  if (!MpmSurfaceCutInner(at, &faces->drawn.pieces[face->surface], cut, loaded, face,
                          &faces->list.weight[faces->list.used]))
    PetscFunctionReturn(PETSC_SUCCESS);
  face->inner = faces->list.used;
  faces->list.used += room;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The faces of a point at a cut edge. */
static PetscErrorCode FacesOfCut(MpmSurfaceFaces *faces, const MpmFaceSpace *at, PetscInt surface,
                                 const MpmFacet *start, PetscInt outer, const MpmEdgePoint *cut)
{
  const PetscInt first  = faces->list.count;
  PetscReal      loaded = 0.;

  PetscFunctionBeginUser;
  for (PetscInt k = cut->first; k < cut->first + cut->count; k++) {
    const MpmEdgePiece *piece = &faces->drawn.pieces[surface].at[k];
    MpmSurfaceFace      face  = {.surface = surface, .point = start->point, .group = start->group, .inner = -1};

    if (!MpmSurfaceCutFace(faces, piece, at->points, at->space->dim, outer, &face)) continue;
    if (piece->side >= 0 && OnSymmetry(faces, at, surface, start->point, piece->side, face.place)) continue;
    loaded += piece->size;
    PetscCall(AddFace(faces, at, &face, NULL));
  }
  if (faces->list.count > first) PetscCall(AddInner(faces, at, cut, loaded, &faces->list.at[first]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The faces of a surface that point p has among the bits `outer`; `held`: those where water passes another. */
static PetscErrorCode FacesOfPoint(MpmSurfaceFaces *faces, const MpmFaceSpace *at, PetscInt surface,
                                   const MpmFacet *start, PetscInt outer, PetscInt *held)
{
  const PetscInt      dim = at->space->dim, p = start->point;
  const MpmEdgePoint *cut;

  PetscFunctionBeginUser;
  if (!(outer & faces->surfaces->at[surface].faces) || !Has(faces, surface, at->points->id[p]))
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSurfaceCutPoint(&faces->surfaces->at[surface], &faces->drawn.pieces[surface], at->rules->grid,
                               at->points, p, &outer, &cut));
  if (cut) PetscFunctionReturn(FacesOfCut(faces, at, surface, start, outer, cut));
  for (PetscInt side = 0; side < 2 * dim; side++) {
    const PetscInt bit   = MpmFaceBit(side / 2, side % 2);
    MpmFacet       facet = *start;
    MpmSurfaceFace face  = {.surface = surface, .point = p, .group = start->group, .inner = -1};
    PetscReal      arm[MPM_MAX_DIM], part;

    if (!(outer & faces->surfaces->at[surface].faces & bit)) continue;
    if (faces->surfaces->at[surface].boundary >= 0 && (*held & bit)) continue;
    part = PartInRegion(&faces->surfaces->at[surface], dim, at->points, p, side);
    if (!(part > 0.)) continue;
    MpmOuterFace(dim, MpmPointF(at->points, p), &at->points->domain.half_length[p * dim], side / 2, side % 2, arm,
                 face.area);
    for (PetscInt a = 0; a < dim; a++) facet.place[a] = face.place[a] = at->points->x[p * dim + a] + arm[a];
    if (!Touches(faces, surface, at->points, p, facet.place, face.area)) continue;
    if (OnSymmetry(faces, at, surface, p, side, NULL)) continue;
    if (faces->surfaces->at[surface].held) *held |= bit;
    for (PetscInt a = 0; a < dim; a++) face.area[a] *= part;
    PetscCall(AddFace(faces, at, &face, &facet));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfaceFacesFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmSurfaceFaces   *faces = (MpmSurfaceFaces *)ctx;
  PetscBool          any   = PETSC_FALSE;
  PetscInt          *outer;
  MpmBasis           basis;
  const MpmFaceSpace at = {rules, space, points, &basis};

  PetscFunctionBeginUser;
  faces->list.count = faces->list.used = 0;
  for (PetscInt k = 0; k < faces->surfaces->count; k++) any = (PetscBool)(any || faces->acting[k].active);
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(points->count, &outer));
  PetscCall(FindOuter(faces, rules, points, outer));
  PetscCall(MpmSurfaceCutPresent(faces, points, rules->grid->comm));
  PetscCall(MpmBasisCreate(space, &basis));
  for (PetscInt g = 0; g < space->group_count; g++) {
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      const MpmFacet facet = {.point = space->order[s], .group = g};
      PetscInt       held  = 0;

      for (PetscInt k = 0; k < faces->surfaces->count && outer[facet.point]; k++)
        PetscCall(FacesOfPoint(faces, &at, k, &facet, outer[facet.point], &held));
    }
  }
  PetscCall(MpmBasisDestroy(&basis));
  PetscCall(PetscFree(outer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the number of faces that a surface has of a point. */
static PetscErrorCode CountFaces(const MpmBodySurface *surface, MpmEdgePieces *pieces, const MpmGrid *grid,
                                 const MpmPoints *points, PetscInt p, PetscInt *count)
{
  PetscInt            bits = points->domain.faces[p] & surface->faces;
  PetscReal           area[MPM_MAX_DIM];
  const MpmEdgePoint *cut;

  PetscFunctionBeginUser;
  if (!bits) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSurfaceCutPoint(surface, pieces, grid, points, p, &bits, &cut));
  for (PetscInt k = 0; cut && k < cut->count; k++)
    *count += MpmSurfacePieceArea(surface, &pieces->at[cut->first + k], grid->dim, bits, area) ? 1 : 0;
  for (PetscInt face = 0; !cut && face < 2 * grid->dim; face++)
    if (bits & MpmFaceBit(face / 2, face % 2)) *count += PartInRegion(surface, grid->dim, points, p, face) > 0. ? 1 : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBodySurfacesCheck(const MpmBodySurfaces *surfaces, const MpmLoadActing *acting, const MpmGrid *grid,
                                    MpmParticles *particles)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  if (!surfaces->count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt k = 0; k < surfaces->count; k++) {
    PetscInt      count[2] = {0, 0}; /* points of the body, and the surface's faces of these */
    MpmEdgePieces pieces   = {0};

    for (PetscInt p = 0; p < points.count; p++) {
      if (points.id[p] < acting[k].first || points.id[p] >= acting[k].end) continue;
      count[0]++;
      PetscCall(CountFaces(&surfaces->at[k], &pieces, grid, &points, p, &count[1]));
    }
    PetscCall(MpmEdgePiecesDestroy(&pieces));
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 2, MPIU_INT, MPI_SUM, grid->comm));
    MpmCheckInput(k >= surfaces->named || !acting[k].active || !count[0] || count[1],
                  "-mpm_surface_%s_%s: the material does not end there: no face of its body%s bounds it",
                  surfaces->names[k], surfaces->at[k].region ? "region" : "side",
                  surfaces->at[k].region ? " in the region" : "");
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}
