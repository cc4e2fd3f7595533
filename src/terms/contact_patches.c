/*
  Facets and patches: where the material may touch rigid surfaces in a step.

  A facet is a face of a point's domain that bounds the material (outer_faces.c). It stands at y = x + F l_a e_a, with the
  outward area a = cof(F) A_a e_a; what of it faces a surface of normal n is A = -a . n. Summed over the steps of a lattice that was
  cut at an angle, A is the area of the cut.

  The facets of one cell form a patch. A patch has one mean gap and one mean slip, as a mortar method with one
  multiplier a cell has them: with a condition at every facet the surface would have more conditions than the cells have
  unknowns, and what lies near it would move with it as one.

  Where a surface cut the lattice, facets stand up to half a point's spacing off it, on either side. That distance is theirs from
  then on: they touch where the distance is what it was at the start. So a body that is put on a surface sits on it.
*/
#include "geometry/geometry.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/outer_faces.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "terms/contact.h"
#include "terms/terms.h"

#define TOUCH   1e-12 /* of a cell: rounding of a face that stands on the boundary */
#define TILT    0.1   /* of a cell */
#define ALIGNED 1e-6  /* off a face's normal: no step of a lattice */

PetscErrorCode MpmContactsCreate(PetscInt count, const MpmBoundary boundaries[], MpmContacts *contacts)
{
  PetscFunctionBeginUser;
  contacts->boundary_count = count;
  contacts->boundaries     = boundaries;
  PetscCall(PetscCalloc1(count, &contacts->before));
  PetscCall(PetscCalloc1(count, &contacts->after));
  PetscCall(PetscCalloc1(count, &contacts->reaction));
  PetscCall(PetscCalloc1(count, &contacts->depth));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsDestroy(MpmContacts *contacts)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(contacts->before));
  PetscCall(PetscFree(contacts->after));
  PetscCall(PetscFree(contacts->reaction));
  PetscCall(PetscFree(contacts->depth));
  PetscCall(PetscFree(contacts->facet));
  PetscCall(PetscFree(contacts->patch));
  PetscCall(PetscFree(contacts->weight));
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

/* The share of its reach at which the point stands at the start: 1 for all but those that lie nearer. Also its distance. */
static PetscReal InitialShare(const MpmBoundary *boundary, const MpmPoints *points, PetscInt p, PetscReal *distance,
                              PetscReal *reach)
{
  const MpmPose still = {.growth = 0.};
  MpmSurface    surface;

  MpmBoundaryDistance(boundary, &still, &points->x0[p * boundary->dim], &surface);
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

    if (!MpmRegionContains(boundary->region, &points.x0[p * grid->dim])) continue;
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

/*
  Did the face touch the boundary at the start, and at which distance? It did where the boundary is the reason for which the lattice
  has no point beyond the face. A face along the surface is no step of a cut lattice: its gap is meant.
*/
static PetscBool TouchedAtStart(const MpmBoundary *boundary, const MpmPoints *points, PetscInt p, PetscInt face,
                                PetscReal *touches)
{
  const MpmPose    still = {.growth = 0.};
  const PetscInt   dim = boundary->dim, axis = face / 2;
  const PetscReal *x0 = &points->x0[p * dim], sign = face % 2 ? 1. : -1., half = points->half_length[p * dim + axis];
  PetscReal        at[MPM_MAX_DIM];
  MpmSurface       surface, beyond;

  *touches = 0.;
  for (PetscInt a = 0; a < dim; a++) at[a] = x0[a] + (a == axis ? sign * half : 0.);
  MpmBoundaryDistance(boundary, &still, at, &surface);
  if (surface.distance <= 0.) {
    *touches = surface.distance;
    return PETSC_TRUE;
  }
  if (-sign * surface.normal[axis] > 1. - ALIGNED) return (PetscBool)(surface.distance <= MPM_TOLERANCE * half);
  at[axis] += sign * half;
  MpmBoundaryDistance(boundary, &still, at, &beyond);
  if (beyond.distance > 0.) return PETSC_FALSE;
  *touches = surface.distance;
  return PETSC_TRUE;
}

static PetscErrorCode AddFacet(MpmContacts *contacts, const MpmFacet *facet)
{
  PetscFunctionBeginUser;
  if (contacts->facet_count == contacts->capacity) {
    contacts->capacity = 2 * contacts->capacity + 64;
    PetscCall(PetscRealloc((size_t)contacts->capacity * sizeof(MpmFacet), &contacts->facet));
  }
  contacts->facet[contacts->facet_count++] = *facet;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The facets of a point that may touch the boundary in this step. */
static PetscErrorCode FacetsOfPoint(MpmContacts *contacts, PetscInt b, PetscReal margin, const MpmPoints *points,
                                    const MpmFacet *start)
{
  const MpmBoundary *boundary = &contacts->boundaries[b];
  const PetscInt     dim = boundary->dim, p = start->point;
  MpmSurface         surface;

  PetscFunctionBeginUser;
  for (PetscInt face = 0; face < 2 * dim; face++) {
    MpmFacet  facet = *start;
    PetscReal arm[MPM_MAX_DIM], area[MPM_MAX_DIM];
    PetscBool touched;

    if (!((PetscInt)points->faces[p] & MpmFaceBit(face / 2, face % 2))) continue;
    MpmOuterFace(dim, &points->F[p * dim * dim], &points->half_length[p * dim], face / 2, face % 2, arm, area);
    for (PetscInt a = 0; a < dim; a++) facet.place[a] = points->x[p * dim + a] + arm[a];
    MpmBoundaryDistance(boundary, &contacts->before[b], facet.place, &surface);
    if (!boundary->bilateral && surface.distance > margin) continue;
    for (PetscInt a = 0; a < dim; a++) {
      facet.normal[a] = surface.normal[a];
      facet.area -= area[a] * surface.normal[a];
    }
    if (!(facet.area > 0.)) continue;
    touched = TouchedAtStart(boundary, points, p, face, &facet.touches);
    if (boundary->bilateral && !touched) continue;
    PetscCall(AddFacet(contacts, &facet));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* How far from a place a boundary is looked for: what the material and the surface may come nearer in the step. */
static PetscReal Margin(const MpmContacts *contacts, const MpmGrid *grid, PetscInt b, const PetscReal x[])
{
  const MpmPose *before = &contacts->before[b], *after = &contacts->after[b];
  PetscReal      margin = PetscAbsReal(after->growth - before->growth), y[MPM_MAX_DIM];

  MpmPoseCarry(grid->dim, after, before, x, y);
  for (PetscInt a = 0; a < grid->dim; a++) margin += 2. * grid->h[a] + PetscAbsReal(y[a] - x[a]);
  return margin;
}

static PetscErrorCode FacetsOfBoundary(MpmContacts *contacts, PetscInt b, const MpmGrid *grid, const MpmSpace *space,
                                       const MpmPoints *points)
{
  const PetscInt dim = grid->dim;

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < space->group_count; g++) {
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      const PetscInt p     = space->order[s];
      MpmFacet       facet = {.boundary = b, .point = p, .group = g};
      PetscInt       cell[MPM_MAX_DIM];

      if (points->faces[p] == 0. || !MpmRegionContains(contacts->boundaries[b].region, &points->x0[p * dim])) continue;
      MpmGridFindCell(grid, &points->x[p * dim], cell);
      for (PetscInt a = dim - 1; a >= 0; a--) facet.cell = facet.cell * grid->cells[a] + cell[a];
      PetscCall(FacetsOfPoint(contacts, b, Margin(contacts, grid, b, &points->x[p * dim]), points, &facet));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- patches ---- */

static int CompareFacets(const void *a, const void *b)
{
  const MpmFacet *f = (const MpmFacet *)a, *g = (const MpmFacet *)b;

  if (f->boundary != g->boundary) return f->boundary < g->boundary ? -1 : 1;
  if (f->cell != g->cell) return f->cell < g->cell ? -1 : 1;
  return f->point < g->point ? -1 : f->point > g->point;
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

static PetscErrorCode MakePatches(MpmContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                                  MpmSpace *space)
{
  const PetscInt box_begin = space->box_count;
  PetscReal      unit      = 1. / rules->grid->h[0];
  MpmGroup      *boxes;

  PetscFunctionBeginUser;
  for (PetscInt a = 1; a < space->dim; a++) unit = PetscMax(unit, 1. / rules->grid->h[a]);
  qsort(contacts->facet, (size_t)contacts->facet_count, sizeof(MpmFacet), CompareFacets);
  PetscCall(PetscRealloc((size_t)contacts->facet_count * sizeof(MpmPatch), &contacts->patch));
  for (PetscInt k = 0; k < contacts->facet_count; k++) {
    const MpmFacet *facet = &contacts->facet[k];
    MpmPatch       *patch;

    if (!k || facet->boundary != facet[-1].boundary || facet->cell != facet[-1].cell) {
      contacts->patch[contacts->patch_count] =
        (MpmPatch){.boundary = facet->boundary, .begin = k, .box = box_begin + contacts->patch_count};
      contacts->patch_count++;
    }
    patch      = &contacts->patch[contacts->patch_count - 1];
    patch->end = k + 1;
    patch->area += facet->area;
    patch->stiffness += facet->area * contacts->boundaries[facet->boundary].penalty * unit *
                        rules->materials[points->material[facet->point]].penalty;
    contacts->most = PetscMax(contacts->most, patch->end - patch->begin);
  }
  PetscCall(MpmSpaceAppendBoxes(space, contacts->patch_count, &boxes));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch *patch = &contacts->patch[k];

    patch->stiffness /= patch->area;
    for (PetscInt f = patch->begin; f < patch->end; f++)
      IncludeGroup(&boxes[k], &space->groups[contacts->facet[f].group]);
  }
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

PetscErrorCode MpmContactsFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmContacts *contacts = (MpmContacts *)ctx;

  PetscFunctionBeginUser;
  contacts->facet_count = contacts->patch_count = contacts->most = 0;
  if (!contacts->boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  contacts->touch = PETSC_INFINITY;
  for (PetscInt a = 0; a < space->dim; a++) contacts->touch = PetscMin(contacts->touch, TOUCH * rules->grid->h[a]);
  contacts->tilt = TILT / TOUCH * contacts->touch;
  SetPoses(contacts, rules->time_n, rules->time);
  for (PetscInt b = 0; b < contacts->boundary_count; b++)
    PetscCall(FacetsOfBoundary(contacts, b, rules->grid, space, points));
  if (contacts->facet_count) PetscCall(MakePatches(contacts, rules, points, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- weights ---- */

/*
  Weights of a facet on one axis, at the nodes of its patch's box: those of the part of the domain about the facet that is in the
  domain, the face's middle across, the domain's mean along. That makes a uniform pressure on an even face consistent with
  uniform stress, in every node. Shapes without a domain take the point's own weights (half NULL).
*/
static void AxisWeights(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                        PetscInt a, const PetscReal half[], PetscReal line[])
{
  const MpmGrid  *grid  = rules->grid;
  const MpmGroup *group = &space->groups[facet->group];
  const PetscInt  p = facet->point, dim = space->dim, last = group->count[a] - 1;
  PetscInt        lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscReal       weight[MPM_MAX_WIDTH], unused[MPM_MAX_WIDTH];
  MpmShapeLine    face = {.weight = weight, .gradient = unused};

  for (PetscInt i = 0; i <= last; i++) line[i] = half ? 0. : space->shape[0].weight[(p * dim + a) * space->width + i];
  if (!half) return;
  const PetscReal x  = (points->x[p * dim + a] - grid->lower[a]) / grid->h[a];
  const PetscReal at = PetscMin(PetscMax((facet->place[a] - grid->lower[a]) / grid->h[a], x - half[a]), x + half[a]);

  MpmSpaceEdges(rules, &points->x[p * dim], lower, upper);
  MpmShapeEvaluate(rules->shape, rules->edge, at, PetscMax(half[a] - PetscAbsReal(at - x), 0.), lower[a], upper[a],
                   &face);
  for (PetscInt i = 0; i < face.count; i++) /* rounding may touch a node more than the domain does */
    line[PetscMin(PetscMax(face.first + i - group->first[a], 0), last)] += weight[i];
}

static void Weights(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                    const MpmGroup *box, PetscReal weight[])
{
  const MpmGroup *group  = &space->groups[facet->group];
  const PetscBool domain = MpmShapeHasDomain(rules->shape);
  PetscReal       line[MPM_MAX_DIM][MPM_MAX_WIDTH], half[MPM_MAX_DIM];

  line[2][0] = 1.;
  if (domain) (void)MpmSpaceHalfLengths(rules, points, facet->point, half);
  for (PetscInt a = 0; a < space->dim; a++) AxisWeights(rules, space, points, facet, a, domain ? half : NULL, line[a]);
  for (PetscInt i = 0; i < box->node_count; i++) {
    const PetscInt row             = i / box->count[0];
    const PetscInt at[MPM_MAX_DIM] = {i % box->count[0], row % box->count[1], row / box->count[1]};

    weight[i] = 1.;
    for (PetscInt a = 0; a < space->dim; a++) {
      const PetscInt k = at[a] + box->first[a] - group->first[a];

      weight[i] *= k >= 0 && k < group->count[a] ? line[a][k] : 0.;
    }
  }
}

/* Slip at the step's start, put into the tangent plane there. */
static PetscErrorCode LoadSlips(MpmContacts *contacts, MpmParticles *particles, PetscInt dim)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < contacts->boundary_count; b++) {
    for (PetscInt a = 0; contacts->boundaries[b].stick && a < dim; a++) {
      PetscReal *slip;

      PetscCall(DMSwarmGetField(particles->swarm, contacts->boundaries[b].slip_field[a], NULL, NULL, (void **)&slip));
      for (PetscInt k = 0; k < contacts->facet_count; k++)
        if (contacts->facet[k].boundary == b) contacts->facet[k].slip[a] = slip[contacts->facet[k].point];
      PetscCall(
        DMSwarmRestoreField(particles->swarm, contacts->boundaries[b].slip_field[a], NULL, NULL, (void **)&slip));
    }
  }
  for (PetscInt k = 0; k < contacts->facet_count; k++) {
    MpmFacet *facet = &contacts->facet[k];
    PetscReal dot   = 0.;

    for (PetscInt a = 0; a < dim; a++) dot += facet->slip[a] * facet->normal[a];
    for (PetscInt a = 0; a < dim; a++) facet->slip[a] -= dot * facet->normal[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsPrepare(void *ctx, const MpmTermStep *step)
{
  MpmContacts    *contacts = (MpmContacts *)ctx;
  const MpmSpace *space    = step->sum->space;
  PetscInt        size     = 0;

  PetscFunctionBeginUser;
  if (!contacts->boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  SetPoses(contacts, step->rules->time_n, step->rules->time);
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    for (PetscInt f = contacts->patch[k].begin; f < contacts->patch[k].end; f++) {
      contacts->facet[f].weight = size;
      size += space->groups[contacts->patch[k].box].node_count;
    }
  }
  PetscCall(PetscFree(contacts->weight));
  PetscCall(PetscMalloc1(size, &contacts->weight));
  for (PetscInt k = 0; k < contacts->patch_count; k++)
    for (PetscInt f = contacts->patch[k].begin; f < contacts->patch[k].end; f++)
      Weights(step->rules, space, step->sum->points, &contacts->facet[f], &space->groups[contacts->patch[k].box],
              &contacts->weight[contacts->facet[f].weight]);
  PetscCall(LoadSlips(contacts, step->particles, space->dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}
