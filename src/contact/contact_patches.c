/*
  Facets and patches: candidates of contact with rigid surfaces in a step.

  A facet is a face of a point's domain that bounds the material (outer_faces.c). Its place is y = x + F l_a e_a, with
  the outward area a = cof(F) A_a e_a; its area towards a surface of normal n is A = -a . n. Summed over the steps of a
  lattice that was cut at an angle, A is the area of the cut.

  The facets of one cell form a patch, those at different sides of a boundary with flat faces one each. Those on round
  surfaces (round_facets.c) and those near an edge of a boundary (edge_facets.c) are one each. A patch has one mean gap
  and one mean slip, as in a mortar method with one multiplier a cell. With a condition at every facet the surface would
  have more conditions than the cells have unknowns, and material near it would move with it as one.

  Where a surface cut the lattice, facets stand up to half a point's spacing off it, on either side. Facets keep that
  distance from then on, stretched as the material is across the surface: contact is at the initial distance. A body
  that is put on a surface therefore sits on it.

  Material in contact with a bilateral boundary may flow along it. When faces there have been drawn out or crowded,
  facets are pieces of the boundary's own surface (surface_shares.c), in patches about nodes where material slides there
  (surface_pieces.c).
*/
#include "geometry/geometry.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/outer_faces.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "contact/contact.h"
#include "contact/contact_search.h"
#include "contact/rigid_body.h"

#define TOUCH  1e-12 /* of a cell: rounding of a face that stands on the boundary */
#define TILT   0.25  /* of a cell */
#define SOFT   10.   /* penalty on materials that flow, unless one is given */
#define ROUND  20.   /* and on round bodies: the way of a disc that rolls is the same to 0.2 % from 5 to 100 */
#define CUT    0.05  /* of a half-length: so deep a facet starts where a surface cut the lattice */
#define DRAWN  1.25  /* by this factor has a face's area changed that is drawn out or crowded */
#define FACING 0.2   /* cosine between the normals of a surface and of a face that meets it with an edge */
#define ASKEW  0.1   /* cosine at which a face that looks past the surface counts by half */
#define HAIR   2e-3  /* of a half-length: so far from a surface a face rests on it all the same */
#define NUDGE  1e-3  /* of a cell: so far before a surface lies the cell beside it */

PetscErrorCode MpmContactsCreate(PetscInt count, const MpmBoundary boundaries[], MpmContacts *contacts)
{
  PetscFunctionBeginUser;
  contacts->boundary_count = count;
  contacts->boundaries     = boundaries;
  contacts->newton.give    = 1.; /* bodies settle before the first step is prepared */
  PetscCall(PetscCalloc1(count, &contacts->before));
  PetscCall(PetscCalloc1(count, &contacts->after));
  PetscCall(PetscCalloc1(count, &contacts->reaction));
  PetscCall(PetscCalloc1(count, &contacts->depth));
  PetscCall(PetscCalloc1(count, &contacts->moment));
  PetscCall(PetscCalloc1(count, &contacts->drawn));
  if (count) PetscCall(MpmFaceBoxesCreate(&contacts->boxes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsDestroy(MpmContacts *contacts)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(contacts->before));
  PetscCall(PetscFree(contacts->after));
  PetscCall(PetscFree(contacts->reaction));
  PetscCall(PetscFree(contacts->depth));
  PetscCall(PetscFree(contacts->cut));
  PetscCall(PetscFree(contacts->drawn));
  PetscCall(PetscFree(contacts->moment));
  PetscCall(PetscFree(contacts->bodies));
  PetscCall(PetscFree(contacts->facet));
  PetscCall(PetscFree(contacts->patch));
  PetscCall(PetscFree(contacts->piece));
  PetscCall(PetscFree(contacts->weight));
  PetscCall(MpmFaceBoxesDestroy(&contacts->boxes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the scene ---- */

/* How far a box of these half-lengths reaches along n. */
static PetscReal Reach(PetscInt dim, const PetscReal half[], const PetscReal n[])
{
  PetscReal reach = PETSC_INFINITY;

  for (PetscInt a = 0; a < dim; a++)
    if (n[a] != 0.) reach = PetscMin(reach, half[a] / PetscAbsReal(n[a]));
  return reach;
}

/* Fraction of its reach at which the point stands at the start: 1 for all but nearer ones. Also its distance. */
static PetscReal InitialShare(const MpmBoundary *boundary, const MpmPoints *points, PetscInt p, PetscReal *distance,
                              PetscReal *reach)
{
  const MpmPose still = {.growth = 0.};
  MpmSurface    surface;

  MpmBoundaryDistance(boundary, &still, &points->origin[p * boundary->dim], &surface);
  *distance = surface.distance;
  *reach    = Reach(boundary->dim, &points->half_length[p * boundary->dim], surface.normal);
  return PetscMin(1., PetscMax(0., *distance / *reach));
}

PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmGrid *grid, MpmParticles *particles)
{
  PetscInt  count[3] = {0, 0, 0}; /* contact candidates, behind the boundary, at it */
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    PetscReal distance, reach;

    if (!MpmRegionContains(boundary->region, &points.origin[p * grid->dim])) continue;
    (void)InitialShare(boundary, &points, p, &distance, &reach);
    count[0]++;
    count[1] += distance < -MPM_TOLERANCE * reach;
    count[2] += distance <= (1. + MPM_TOLERANCE) * reach;
  }
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, count, 3, MPIU_INT, MPI_SUM, grid->comm));
  MpmCheckInput(count[0], "-mpm_boundary_%s_points_region: there is no point in it", boundary->name);
  MpmCheckInput(!count[1],
                "-mpm_boundary_%s_type: %" PetscInt_FMT
                " points lie behind it at the start; turn its normal or side, or "
                "choose the contact candidates with its points_region",
                boundary->name, count[1]);
  MpmCheckInput(!boundary->bilateral || count[2],
                "-mpm_boundary_%s_contact bilateral: no point lies at it at the start", boundary->name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- facets ---- */

/* Where the middle of a face was at the start. */
static void InitialPlace(PetscInt dim, const MpmPoints *points, PetscInt p, PetscInt face, PetscReal at[])
{
  for (PetscInt a = 0; a < dim; a++) at[a] = points->origin[p * dim + a];
  at[face / 2] += (face % 2 ? 1. : -1.) * points->half_length[p * dim + face / 2];
}

/* True where a face of the lattice is parallel to a surface: then it is no step where the surface cut the lattice. */
static PetscBool Aligned(const PetscReal normal[], PetscInt face)
{
  return (PetscBool)((face % 2 ? -1. : 1.) * normal[face / 2] > 1. - MPM_ALIGNED);
}

/* Which boundaries cut the lattice of points: some of the faces start well behind them. */
static PetscErrorCode FindCuts(MpmContacts *contacts, const MpmGrid *grid, const MpmPoints *points)
{
  const MpmPose  still = {.growth = 0.};
  const PetscInt dim   = grid->dim;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(contacts->boundary_count, &contacts->cut));
  for (PetscInt k = 0; k < contacts->boundary_count * points->count; k++) {
    const MpmBoundary *boundary = &contacts->boundaries[k / points->count];
    const PetscInt     p        = k % points->count;

    if (!points->faces[p] || !MpmRegionContains(boundary->region, &points->origin[p * dim])) continue;
    for (PetscInt face = 0; face < 2 * dim && !contacts->cut[k / points->count]; face++) {
      PetscReal  at[MPM_MAX_DIM];
      MpmSurface surface;

      if (!(points->faces[p] & MpmFaceBit(face / 2, face % 2))) continue;
      if (MpmContactsSeesRound(contacts, points, k / points->count, p, face)) continue;
      InitialPlace(dim, points, p, face, at);
      MpmBoundaryDistance(boundary, &still, at, &surface);
      if (Aligned(surface.normal, face)) continue;
      if (surface.distance < -CUT * points->half_length[p * dim + face / 2])
        contacts->cut[k / points->count] = PETSC_TRUE;
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contacts->cut, (PetscMPIInt)contacts->boundary_count, MPM_MPI_BOOL, MPI_LOR,
                           grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  True where the face touched the boundary at the start, with the distance: where the boundary is the reason for which
  the lattice has no point beyond the face. A face along the surface is no step of a cut lattice: its gap is intended,
  unless the region of its body was drawn as far as to the surface. A touching face keeps its distance.
*/
static PetscBool TouchedAtStart(const MpmContacts *contacts, PetscInt b, const MpmPoints *points, PetscInt p,
                                PetscInt face, PetscReal *touches)
{
  const MpmBoundary *boundary = &contacts->boundaries[b];
  const MpmPose      still    = {.growth = 0.};
  const PetscInt     dim = boundary->dim, axis = face / 2;
  const PetscReal    sign = face % 2 ? 1. : -1., half = points->half_length[p * dim + axis];
  PetscReal          at[MPM_MAX_DIM], unused[MPM_MAX_DIM];
  MpmSurface         surface, beyond;
  PetscBool          aligned;

  InitialPlace(dim, points, p, face, at);
  MpmBoundaryDistance(boundary, &still, at, &surface);
  aligned  = Aligned(surface.normal, face);
  *touches = surface.distance;
  if (!aligned) *touches *= MpmOuterNormal(dim, MpmPointF(points, p), surface.normal, unused);
  if (surface.distance <= 0.) return PETSC_TRUE;
  if (aligned) {
    const MpmBody body = surface.distance > HAIR * half && surface.distance < 2. * half
                           ? MpmBodyOfPoint(contacts->shaped, points->id[p])
                           : NULL;

    at[axis] += sign * surface.distance;
    if (body && MpmBodyReaches(body, at)) return PETSC_TRUE;
  }
  if (aligned || !contacts->cut[b]) {
    *touches = 0.;
    return (PetscBool)(surface.distance <= MPM_TOLERANCE * half);
  }
  at[axis] += sign * half;
  MpmBoundaryDistance(boundary, &still, at, &beyond);
  return (PetscBool)(beyond.distance <= 0.);
}

PetscInt64 MpmContactsCell(const MpmGrid *grid, const PetscReal x[], PetscInt part)
{
  PetscInt64 number = part;
  PetscInt   cell[MPM_MAX_DIM];

  MpmGridFindCell(grid, x, cell);
  for (PetscInt a = grid->dim - 1; a >= 0; a--) number = number * grid->cells[a] + cell[a];
  return number;
}

/* Faces of a point that meet a boundary from two sides or more: its edge or corner stands out. */
typedef struct {
  PetscInt  count;
  PetscReal arm[MPM_MAX_DIM], initial[MPM_MAX_DIM], outward[MPM_MAX_DIM], area;
} Corner;

/*
  The edge or corner in which the faces towards the boundary meet, a facet with a patch of its own: where it stands out
  towards the surface it touches long before the faces' middles do. Where the surface cut the lattice there are none:
  each step of the lattice would be one.
*/
static PetscErrorCode CornerFacet(MpmContacts *contacts, PetscInt b, PetscReal margin, const MpmPoints *points,
                                  const MpmFacet *start, const Corner *corner)
{
  const MpmPose  still = {.growth = 0.};
  const PetscInt dim = contacts->boundaries[b].dim, p = start->point;
  MpmFacet       facet = *start;
  MpmSurface     surface;
  PetscReal      at[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  if (contacts->cut[b] || corner->count < 2) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < dim; a++) {
    facet.place[a] = points->x[p * dim + a] + corner->arm[a];
    at[a]          = points->origin[p * dim + a] + corner->initial[a];
  }
  MpmBoundaryDistance(&contacts->boundaries[b], &still, at, &surface);
  facet.touches = PetscMin(surface.distance, 0.);
  if (contacts->boundaries[b].bilateral && surface.distance > MPM_TOLERANCE * contacts->cell)
    PetscFunctionReturn(PETSC_SUCCESS);
  MpmContactsStartDistance(contacts, corner->outward, &facet, &surface);
  if (!contacts->boundaries[b].bilateral && surface.distance > margin) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < dim; a++) facet.normal[a] = surface.normal[a];
  facet.area   = 0.5 * corner->area;
  facet.corner = points->id[p] + 1;
  PetscCall(MpmContactsAddFacet(contacts, &facet));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The cell whose patch a facet joins: its point's own or, where the point's middle is beyond the surface, that before
  the surface. A patch of its own would push it out in one step, unlike its equally deep neighbours: then it would be
  back in their cell, and so on.
*/
static PetscInt64 PatchCell(const MpmContacts *contacts, const MpmGrid *grid, const MpmPoints *points,
                            const MpmFacet *facet, const PetscReal arm[], const MpmSurface *surface)
{
  const PetscReal *x     = &points->x[facet->point * grid->dim];
  PetscReal        depth = -surface->distance, foot[MPM_MAX_DIM];

  for (PetscInt a = 0; a < grid->dim; a++) depth += arm[a] * surface->normal[a];
  if (depth <= 0.) return facet->cell;
  for (PetscInt a = 0; a < grid->dim; a++) foot[a] = x[a] + (depth + NUDGE * contacts->cell) * surface->normal[a];
  return MpmContactsCell(grid, foot, points->part ? points->part[facet->point] : 0);
}

/*
  Weight of a face nearly perpendicular to the boundary, from 0 to 1. A side that shear has turned slightly has a small
  area towards the surface, but is half a domain away from it: in the mean gap that is more than the depth of a stiff
  contact. The weight grows smoothly with the angle, or forces would jump. The steps of a cut lattice count.
*/
static void RegardFacet(const MpmContacts *contacts, PetscReal square, MpmFacet *facet)
{
  const PetscReal t = PetscSqr(facet->area) / (square * PetscSqr(ASKEW));

  if (contacts->cut[facet->boundary]) return;
  facet->area *= t / (1. + t);
  facet->askew = (PetscBool)(t < 1.);
}

/* Half of the sides of a face. */
static void FaceSides(PetscInt dim, const MpmPoints *points, PetscInt p, PetscInt face, PetscReal (*sides)[MPM_MAX_DIM])
{
  for (PetscInt b = 0, k = 0; b < dim; b++) {
    if (b == face / 2) continue;
    for (PetscInt a = 0; a < dim; a++)
      sides[k][a] = points->half_length[p * dim + b] * MpmPointF(points, p)[a * dim + b];
    k++;
  }
}

/* A face that meets an edge of the boundary, in slices of this area; they touch where the face does. */
static PetscErrorCode SlicesOfFace(MpmContacts *contacts, PetscReal margin, PetscReal (*sides)[MPM_MAX_DIM],
                                   PetscInt count, const PetscReal area[], const MpmFacet *whole)
{
  const PetscInt dim = contacts->boundaries[whole->boundary].dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) {
    MpmFacet   slice  = *whole;
    PetscReal  square = 0.;
    MpmSurface surface;

    slice.slice = 1 + k;
    slice.area  = 0.;
    MpmContactsSlicePlace(dim, sides, &slice);
    MpmContactsStartDistance(contacts, area, &slice, &surface);
    for (PetscInt a = 0; a < dim; a++) {
      slice.normal[a] = surface.normal[a];
      slice.area -= area[a] * surface.normal[a];
      square += PetscSqr(area[a]);
    }
    if (!(slice.area > 0.) || surface.distance > margin) continue;
    RegardFacet(contacts, square, &slice);
    PetscCall(MpmContactsAddFacet(contacts, &slice));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void AddToCorner(PetscInt dim, const PetscReal arm[], const PetscReal outward[], PetscReal area, Corner *corner)
{
  corner->count++;
  corner->area += area;
  for (PetscInt a = 0; a < dim; a++) {
    corner->arm[a] += arm[a];
    corner->outward[a] += outward[a];
  }
}

/* The facets of a point that may touch the boundary in this step. */
static PetscErrorCode FacetsOfPoint(MpmContacts *contacts, PetscInt b, PetscReal margin, const MpmGrid *grid,
                                    const MpmPoints *points, const MpmFacet *start)
{
  const MpmBoundary *boundary = &contacts->boundaries[b];
  const PetscInt     dim = boundary->dim, p = start->point;
  Corner             corner = {0};
  PetscInt           count  = 0, slices;
  PetscReal          kept[2 * MPM_MAX_DIM];
  PetscBool          cut = PETSC_FALSE;
  MpmSurface         surface;

  PetscFunctionBeginUser;
  for (PetscInt face = 0; face < 2 * dim; face++) {
    MpmFacet  facet = *start;
    PetscReal arm[MPM_MAX_DIM], area[MPM_MAX_DIM], sides[MPM_MAX_DIM - 1][MPM_MAX_DIM], size = 0.;
    PetscBool touched;

    if (!(points->faces[p] & MpmFaceBit(face / 2, face % 2))) continue;
    if (MpmContactsSeesRound(contacts, points, b, p, face)) {
      PetscCall(MpmContactsAddRound(contacts, margin, points, face, start));
      continue;
    }
    MpmOuterFace(dim, MpmPointF(points, p), &points->half_length[p * dim], face / 2, face % 2, arm, area);
    for (PetscInt a = 0; a < dim; a++) facet.place[a] = points->x[p * dim + a] + arm[a];
    MpmContactsStartDistance(contacts, area, &facet, &surface);
    for (PetscInt a = 0; a < dim; a++) {
      facet.normal[a] = surface.normal[a];
      facet.area -= area[a] * surface.normal[a];
      size += PetscSqr(area[a]);
    }
    FaceSides(dim, points, p, face, sides);
    slices = surface.distance > margin ? 0 : MpmContactsAtEdge(contacts, grid->h, sides, &surface, &facet);
    if (!(facet.area > 0.) && !slices) continue;
    if (facet.area > FACING * PetscSqrtReal(size)) {
      AddToCorner(dim, arm, area, facet.area, &corner);
      corner.initial[face / 2] = (face % 2 ? 1. : -1.) * points->half_length[p * dim + face / 2];
    }
    if (!boundary->bilateral && surface.distance > margin) continue;
    touched = TouchedAtStart(contacts, b, points, p, face, &kept[count]);
    if (touched) facet.touches = kept[count];
    else if (boundary->bilateral) continue;
    if (slices) {
      for (PetscInt a = 0; a < dim; a++) area[a] /= (PetscReal)slices;
      PetscCall(SlicesOfFace(contacts, margin, sides, slices, area, &facet));
      continue;
    }
    if (!touched) RegardFacet(contacts, size, &facet);
    if (!(facet.area > 0.)) continue;
    facet.cell = PatchCell(contacts, grid, points, &facet, arm, &surface);
    PetscCall(MpmContactsAddFacet(contacts, &facet));
    cut = (PetscBool)(cut || (touched && contacts->cut[b]));
    count++;
  }
  /* cut domains do not fill the space: some of their faces bound nothing, and keep their distance, too */

  for (PetscInt k = 0; k < count && cut; k++) contacts->facet[contacts->facet_count - count + k].touches = kept[k];
  PetscCall(CornerFacet(contacts, b, margin, points, start, &corner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where faces in contact with a bilateral boundary, and that do not follow it, have been drawn out or crowded. */
static PetscErrorCode FindDrawn(MpmContacts *contacts, PetscInt b, const MpmGrid *grid, const MpmPoints *points)
{
  const PetscInt dim   = grid->dim;
  PetscBool      drawn = PETSC_FALSE;

  PetscFunctionBeginUser;
  contacts->drawn[b] = PETSC_FALSE;
  if (!contacts->cut[b] || !contacts->boundaries[b].bilateral) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2 * dim * points->count && !drawn; k++) {
    const PetscInt p = k / (2 * dim), face = k % (2 * dim);
    PetscReal      arm[MPM_MAX_DIM], area[MPM_MAX_DIM], square = 0., start = 1.;

    if (!(points->faces[p] & MpmFaceBit(face / 2, face % 2)) ||
        !MpmRegionContains(contacts->boundaries[b].region, &points->origin[p * dim]) ||
        !TouchedAtStart(contacts, b, points, p, face, &arm[0]))
      continue;
    MpmOuterFace(dim, MpmPointF(points, p), &points->half_length[p * dim], face / 2, face % 2, arm, area);
    for (PetscInt a = 0; a < dim; a++) square += PetscSqr(area[a]);
    for (PetscInt a = 0; a < dim; a++) start *= a == face / 2 ? 1. : 2. * points->half_length[p * dim + a];
    drawn = (PetscBool)(PetscSqrtReal(square) > DRAWN * start || PetscSqrtReal(square) < start / DRAWN);
  }
  PetscCall(MPIU_Allreduce(&drawn, &contacts->drawn[b], 1, MPM_MPI_BOOL, MPI_LOR, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FacetsOfBoundary(MpmContacts *contacts, PetscInt b, const MpmGrid *grid, const MpmSpace *space,
                                       const MpmPoints *points)
{
  const PetscInt dim = grid->dim;
  PetscBool      far;

  PetscFunctionBeginUser;
  PetscCall(FindDrawn(contacts, b, grid, points));
  if (contacts->drawn[b]) {
    PetscCall(MpmSurfaceShares(contacts, b, grid, space, points));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmFaceBoxesFind(contacts, b, grid, points, &far));
  if (far) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(contacts->boxes->search, 0, 0, 0, 0));
  for (PetscInt g = 0; g < space->group_count; g++) {
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      const PetscInt p     = space->order[s];
      MpmFacet       facet = {.boundary = b, .point = p, .group = g};
      PetscReal      margin;

      if (!points->faces[p] || MpmFaceBoxIsFar(contacts, b, p) ||
          !MpmRegionContains(contacts->boundaries[b].region, &points->origin[p * dim]))
        continue;
      margin = MpmContactsMargin(contacts, grid, b, &points->x[p * dim]);
      if (!contacts->boundaries[b].bilateral && MpmContactsIsFar(contacts, b, margin, points, p)) continue;
      facet.cell = MpmContactsCell(grid, &points->x[p * dim], points->part ? points->part[p] : 0);
      PetscCall(FacetsOfPoint(contacts, b, margin, grid, points, &facet));
    }
  }
  PetscCall(PetscLogEventEnd(contacts->boxes->search, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- patches ---- */

static int CompareFacets(const void *a, const void *b)
{
  const MpmFacet *f = (const MpmFacet *)a, *g = (const MpmFacet *)b;

  if (f->boundary != g->boundary) return f->boundary < g->boundary ? -1 : 1;
  if (f->cell != g->cell) return f->cell < g->cell ? -1 : 1;
  if (f->corner != g->corner) return f->corner < g->corner ? -1 : 1;
  if (f->side != g->side) return f->side < g->side ? -1 : 1;
  if (f->round != g->round) return f->round < g->round ? -1 : 1;
  if (f->single != g->single) return f->single < g->single ? -1 : 1;
  if (f->point != g->point) return f->point < g->point ? -1 : 1;
  return f->slice < g->slice ? -1 : f->slice > g->slice;
}

/* Widens a box of nodes to hold a group's; an empty box has no nodes. */
static void IncludeGroup(MpmGroup *box, const MpmGroup *group)
{
  const PetscBool empty = (PetscBool)!box->node_count;

  box->node_count = 1;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const PetscInt first = empty ? group->first[a] : PetscMin(box->first[a], group->first[a]);
    const PetscInt end   = PetscMax(empty ? 0 : box->first[a] + box->count[a], group->first[a] + group->count[a]);

    box->first[a] = first;
    box->count[a] = end - first;
    box->node_count *= box->count[a];
  }
  box->holes = PETSC_TRUE;
}

/*
  Pressure by depth, times the cell size. Plastic material carries pressures that are small beside its modulus: a soft
  penalty is deep enough, and Newton's method converges better as the material slides along a curved surface. Round
  bodies are soft where they touch, by more than their penalty, and need fewer iterations the softer it is.
*/
static PetscReal Penalty(const MpmBoundary *boundary, const MpmMaterial *material, PetscReal modulus, PetscBool round)
{
  PetscReal penalty = boundary->penalty;

  if (!boundary->firm && round) penalty = ROUND;
  if (!boundary->firm && material->info.traits & MPM_LAW_PLASTIC) penalty = SOFT;
  return penalty * modulus;
}

static PetscErrorCode MakePatches(MpmContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                                  const MpmSpace *space)
{
  const PetscInt box_begin = space->box_count;
  PetscReal      unit      = 1. / rules->grid->h[0];

  PetscFunctionBeginUser;
  for (PetscInt a = 1; a < space->dim; a++) unit = PetscMax(unit, 1. / rules->grid->h[a]);
  for (PetscInt k = 0; k < contacts->facet_count; k++)
    contacts->facet[k].area *= MpmTurn(points->F_size, contacts->facet[k].place[0]);
  qsort(contacts->facet, (size_t)contacts->facet_count, sizeof(MpmFacet), CompareFacets);
  PetscCall(PetscRealloc((size_t)contacts->facet_count * sizeof(MpmPatch), &contacts->patch));
  for (PetscInt k = 0; k < contacts->facet_count; k++) {
    const MpmFacet    *facet = &contacts->facet[k];
    const MpmMaterial *material;
    MpmPatch          *patch;

    if (!k || facet->boundary != facet[-1].boundary || facet->cell != facet[-1].cell ||
        facet->corner != facet[-1].corner || facet->side != facet[-1].side || facet->round || facet->single) {
      contacts->patch[contacts->patch_count] = (MpmPatch){.boundary = facet->boundary,
                                                          .begin    = k,
                                                          .box      = box_begin + contacts->patch_count,
                                                          .round    = (PetscBool)facet->round,
                                                          .strength = PETSC_INFINITY};
      contacts->patch_count++;
    }
    patch      = &contacts->patch[contacts->patch_count - 1];
    patch->end = k + 1;
    patch->area += facet->area;
    patch->foreign = (PetscBool)(patch->foreign || facet->point < 0);
    material =
      &rules->materials[facet->piece ? contacts->piece[facet->piece - 1].material : points->material[facet->point]];
    patch->stiffness +=
      facet->area * unit *
      Penalty(&contacts->boundaries[facet->boundary], material,
              facet->piece ? contacts->piece[facet->piece - 1].modulus
                           : MpmMaterialPenalty(material, MpmPointOwn(points, material, facet->point)),
              patch->round);
    contacts->most = PetscMax(contacts->most, patch->end - patch->begin);
  }
  for (PetscInt k = 0; k < contacts->patch_count; k++) contacts->patch[k].stiffness /= contacts->patch[k].area;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The boxes of the patches' nodes. */
static PetscErrorCode AppendBoxes(MpmContacts *contacts, MpmSpace *space)
{
  MpmGroup *boxes;

  PetscFunctionBeginUser;
  PetscCall(MpmSpaceAppendBoxes(space, contacts->patch_count, &boxes));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPatch *patch = &contacts->patch[k];

    for (PetscInt f = patch->begin; f < patch->end; f++) {
      const MpmGroup box = MpmFacetBox(contacts, space, &contacts->facet[f]);

      IncludeGroup(&boxes[k], &box);
    }
  }
  PetscCall(MpmPiecesAppendBoxes(contacts, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void SetPoses(MpmContacts *contacts, PetscReal time_n, PetscReal time)
{
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    contacts->before[b] = (MpmPose){.growth = 0.};
    if (time_n > 0.) contacts->before[b] = MpmBoundaryPose(&contacts->boundaries[b], time_n);
    contacts->after[b] = MpmBoundaryPose(&contacts->boundaries[b], time);
  }
}

/* Facets and patches about where free bodies are expected to go. */
static PetscErrorCode FindPatches(MpmContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                                  const MpmSpace *space)
{
  PetscFunctionBeginUser;
  contacts->facet_count = contacts->patch_count = contacts->most = 0;
  for (PetscInt b = 0; b < contacts->boundary_count; b++)
    PetscCall(FacetsOfBoundary(contacts, b, rules->grid, space, points));
  PetscCall(MpmPiecesSpread(contacts, rules, points, space));
  if (contacts->facet_count) PetscCall(MakePatches(contacts, rules, points, space));
  for (PetscInt f = 0; contacts->bodies && f < contacts->facet_count; f++)
    if (MpmContactsBody(contacts, contacts->facet[f].boundary))
      MpmRigidPull(MpmContactsBody(contacts, contacts->facet[f].boundary), &contacts->facet[f]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmContacts *contacts = (MpmContacts *)ctx;
  PetscBool    moved    = PETSC_FALSE;

  PetscFunctionBeginUser;
  contacts->facet_count = contacts->patch_count = contacts->most = 0;
  contacts->newton.raised                                        = 1.; /* on all ranks */
  if (!contacts->boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  contacts->cell = PETSC_INFINITY;
  for (PetscInt a = 0; a < space->dim; a++) contacts->cell = PetscMin(contacts->cell, rules->grid->h[a]);
  contacts->touch   = TOUCH * contacts->cell;
  contacts->tilt    = TILT / TOUCH * contacts->touch;
  contacts->weighed = PETSC_FALSE;
  if (!contacts->cut) PetscCall(FindCuts(contacts, rules->grid, points));
  SetPoses(contacts, rules->time_n, rules->time);
  MpmRigidBegin(contacts, rules->time, rules->dynamic ? rules->time - rules->time_n : 0., rules->gravity);
  PetscCall(MpmFaceBoxesBegin(contacts, points));
  do {
    PetscCall(FindPatches(contacts, rules, points, space));
    if (contacts->bodies) PetscCall(MpmRigidSettle(contacts, rules->grid, &moved));
  } while (moved);
  if (contacts->facet_count) PetscCall(AppendBoxes(contacts, space));
  contacts->newton.near = (PetscBool)(contacts->patch_count > 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- weights ---- */

static void Weights(const MpmContacts *contacts, const MpmRules *rules, const MpmSpace *space, const MpmPoints *points,
                    const MpmFacet *facet, const MpmGroup *box, PetscReal weight[])
{
  const MpmGroup  group = MpmFacetBox(contacts, space, facet);
  const MpmPiece *piece = facet->piece ? &contacts->piece[facet->piece - 1] : NULL;
  PetscReal       line[MPM_MAX_DIM][MPM_MAX_WIDTH];
  const PetscReal(*lines)[MPM_MAX_WIDTH] = (const PetscReal(*)[MPM_MAX_WIDTH])(piece ? piece->line : line);

  if (!piece) MpmFacetLines(rules, space, points, facet, line);
  for (PetscInt i = 0; i < box->node_count; i++) {
    const PetscInt row             = i / box->count[0];
    const PetscInt at[MPM_MAX_DIM] = {i % box->count[0], row % box->count[1], row / box->count[1]};

    weight[i] = 1.;
    for (PetscInt a = 0; a < space->dim; a++) {
      const PetscInt k = at[a] + box->first[a] - group.first[a];

      weight[i] *= k >= 0 && k < group.count[a] ? lines[a][k] : 0.;
    }
  }
}

/* Strength of the material along the surface: mean over the facets, infinite where one of their laws has no limit. */
static void Strengths(MpmContacts *contacts, const MpmSum *sum)
{
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch *patch = &contacts->patch[k];

    patch->strength = 0.;
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      const MpmFacet    *facet    = &contacts->facet[f];
      const MpmMaterial *material = facet->piece ? NULL : &sum->materials[sum->points->material[facet->point]];

      patch->strength +=
        facet->area / patch->area *
        (facet->piece ? contacts->piece[facet->piece - 1].kept[MPM_PIECE_STRENGTH]
                      : MpmMaterialShearStrength(material, MpmPointOwn(sum->points, material, facet->point),
                                                 sum->points->state + facet->point * sum->state_size));
    }
  }
}

/* The weights of all facets; they stay while the points do. */
static PetscErrorCode WeighFacets(MpmContacts *contacts, const MpmTermStep *step)
{
  const MpmSpace *space = step->sum->space;
  PetscInt        size  = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    for (PetscInt f = contacts->patch[k].begin; f < contacts->patch[k].end; f++) {
      contacts->facet[f].weight = size;
      size += space->groups[contacts->patch[k].box].node_count;
    }
  }
  PetscCall(PetscFree(contacts->weight));
  PetscCall(PetscMalloc1(size, &contacts->weight));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    for (PetscInt f = contacts->patch[k].begin; f < contacts->patch[k].end; f++) {
      MpmFacet            facet = contacts->facet[f];
      const MpmRigidBody *body  = MpmContactsBody(contacts, facet.boundary);

      if (body) MpmRigidPush(body, &contacts->facet[f], facet.place);
      Weights(contacts, step->rules, space, step->sum->points, &facet, &space->groups[contacts->patch[k].box],
              &contacts->weight[facet.weight]);
    }
  }
  contacts->weighed = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsPrepare(void *ctx, const MpmTermStep *step)
{
  MpmContacts    *contacts = (MpmContacts *)ctx;
  const PetscBool again    = contacts->weighed; /* another length of the step */
  PetscBool       moved    = PETSC_TRUE;

  PetscFunctionBeginUser;
  if (!contacts->boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  SetPoses(contacts, step->rules->time_n, step->rules->time);
  if (!again) PetscCall(WeighFacets(contacts, step));
  PetscCall(MpmPiecesLoad(contacts, step));
  Strengths(contacts, step->sum);
  PetscCall(MpmContactsLoad(contacts, step));
  if (!again || !contacts->bodies) PetscFunctionReturn(PETSC_SUCCESS);
  MpmRigidBegin(contacts, step->rules->time, step->rules->dynamic ? step->rules->time - step->rules->time_n : 0.,
                step->rules->gravity);
  while (moved) PetscCall(MpmRigidSettle(contacts, step->rules->grid, &moved));
  PetscFunctionReturn(PETSC_SUCCESS);
}
