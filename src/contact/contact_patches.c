/*
  Patches of facets (facets/): candidates of contact with rigid surfaces in a step.

  The facets of one cell form a patch, those at different sides of a boundary with flat faces one each. Those on round
  surfaces (round_facets.c) and those near an edge of a boundary (edge_facets.c) are one each. A patch has one mean gap
  and one mean slip, as in a mortar method with one multiplier a cell. With a condition at every facet the surface would
  have more conditions than the cells have unknowns, and material near it would move with it as one. An element of order
  p has a patch for each of the p^dim parts of its cell, or its nodes within would pass the surface.

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
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "contact/contact.h"
#include "contact/rigid_body.h"

#define TILT  0.25 /* of a cell */
#define SOFT  10.  /* penalty on materials that flow, unless one is given */
#define ROUND 20.  /* and on round bodies: the way of a disc that rolls is the same to 0.2 % from 5 to 100 */

PetscErrorCode MpmContactsCreate(PetscInt count, const MpmBoundary boundaries[], MpmContacts *contacts)
{
  PetscFunctionBeginUser;
  contacts->newton.give = 1.; /* bodies settle before the first step is prepared */
  PetscCall(MpmFacetsCreate(count, boundaries, &contacts->facets));
  PetscCall(PetscCalloc1(count, &contacts->reaction));
  PetscCall(PetscCalloc1(count, &contacts->depth));
  PetscCall(PetscCalloc1(count, &contacts->moment));
  for (PetscInt b = 0; b < count; b++)
    if (boundaries[b].fields.face && !contacts->face) PetscCall(PetscCalloc1(count, &contacts->face));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsDestroy(MpmContacts *contacts)
{
  PetscFunctionBeginUser;
  PetscCall(MpmFacetsDestroy(&contacts->facets));
  PetscCall(PetscFree(contacts->reaction));
  PetscCall(PetscFree(contacts->depth));
  PetscCall(PetscFree(contacts->moment));
  PetscCall(PetscFree(contacts->face));
  PetscCall(PetscFree(contacts->patch));
  PetscCall(PetscFree(contacts->weight));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- patches ---- */

static int CompareFacets(const void *a, const void *b)
{
  const MpmFacet *f = (const MpmFacet *)a, *g = (const MpmFacet *)b;

  if (f->boundary != g->boundary) return f->boundary < g->boundary ? -1 : 1;
  if (f->key.cell != g->key.cell) return f->key.cell < g->key.cell ? -1 : 1;
  if (f->key.corner != g->key.corner) return f->key.corner < g->key.corner ? -1 : 1;
  if (f->key.side != g->key.side) return f->key.side < g->key.side ? -1 : 1;
  if (f->key.round != g->key.round) return f->key.round < g->key.round ? -1 : 1;
  if (f->key.flows != g->key.flows) return f->key.flows < g->key.flows ? -1 : 1;
  if (f->key.single != g->key.single) return f->key.single < g->key.single ? -1 : 1;
  if (f->point != g->point) return f->point < g->point ? -1 : 1;
  return f->key.slice < g->key.slice ? -1 : f->key.slice > g->key.slice;
}

/* True where both are slices of a point that face one flat side of the boundary. */
static PetscBool AreOfOnePoint(const MpmFacet *f, const MpmFacet *g)
{
  return (PetscBool)(f->point == g->point && f->facing && g->facing);
}

static PetscBool InOnePatch(const MpmFacet *f, const MpmFacet *g)
{
  return (PetscBool)(f->boundary == g->boundary && f->key.cell == g->key.cell && f->key.corner == g->key.corner &&
                     f->key.side == g->key.side && f->key.flows == g->key.flows && !f->key.round &&
                     (!f->key.single || AreOfOnePoint(f, g)));
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
  const PetscInt box_begin = space->boxes.count;
  PetscReal      unit      = 1. / rules->grid->h[0];

  PetscFunctionBeginUser;
  for (PetscInt a = 1; a < space->dim; a++) unit = PetscMax(unit, 1. / rules->grid->h[a]);
  for (PetscInt k = 0; k < contacts->facets.count; k++)
    contacts->facets.at[k].area *= MpmTurn(points->F_size, contacts->facets.at[k].place[0]);
  qsort(contacts->facets.at, (size_t)contacts->facets.count, sizeof(MpmFacet), CompareFacets);
  PetscCall(PetscRealloc((size_t)contacts->facets.count * sizeof(MpmPatch), &contacts->patch));
  for (PetscInt k = 0; k < contacts->facets.count; k++) {
    const MpmFacet    *facet = &contacts->facets.at[k];
    const MpmMaterial *material;
    MpmPatch          *patch;

    if (!k || !InOnePatch(facet, facet - 1)) {
      contacts->patch[contacts->patch_count] = (MpmPatch){.boundary = facet->boundary,
                                                          .begin    = k,
                                                          .box      = box_begin + contacts->patch_count,
                                                          .round    = (PetscBool)facet->key.round,
                                                          .strength = PETSC_INFINITY};
      contacts->patch_count++;
    }
    patch      = &contacts->patch[contacts->patch_count - 1];
    patch->end = k + 1;
    patch->area += facet->area;
    patch->foreign = (PetscBool)(patch->foreign || facet->point < 0);
    material       = &rules->materials[facet->piece ? contacts->facets.pieces.at[facet->piece - 1].material
                                                    : points->material[facet->point]];
    patch->stiffness +=
      facet->area * unit *
      Penalty(&contacts->facets.boundaries[facet->boundary], material,
              facet->piece ? contacts->facets.pieces.at[facet->piece - 1].modulus
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
      const MpmGroup box = MpmFacetBox(&contacts->facets, space, &contacts->facets.at[f]);

      IncludeGroup(&boxes[k], &box);
    }
  }
  PetscCall(MpmPiecesAppendBoxes(&contacts->facets, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Facets and patches about where free bodies are expected to go. */
static PetscErrorCode FindPatches(MpmContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                                  const MpmSpace *space)
{
  PetscFunctionBeginUser;
  contacts->patch_count = contacts->most = 0;
  PetscCall(MpmFacetsFind(&contacts->facets, rules, points, space));
  if (contacts->facets.count) PetscCall(MakePatches(contacts, rules, points, space));
  for (PetscInt f = 0; contacts->facets.bodies && f < contacts->facets.count; f++)
    if (MpmFacetsBody(&contacts->facets, contacts->facets.at[f].boundary))
      MpmRigidPull(MpmFacetsBody(&contacts->facets, contacts->facets.at[f].boundary), &contacts->facets.at[f]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmContactsFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmContacts *contacts = (MpmContacts *)ctx;
  PetscBool    moved    = PETSC_FALSE;

  PetscFunctionBeginUser;
  contacts->facets.count = contacts->patch_count = contacts->most = 0;
  contacts->newton.raised                                         = 1.; /* on all ranks */
  if (!contacts->facets.boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  contacts->weighed = PETSC_FALSE;
  MpmFacetsSetPoses(&contacts->facets, rules->time.start, rules->time.end);
  PetscCall(MpmFacetsBegin(&contacts->facets, rules->grid, points));
  contacts->tilt = TILT * contacts->facets.cell;
  MpmRigidBegin(contacts, rules);
  do {
    PetscCall(FindPatches(contacts, rules, points, space));
    if (contacts->facets.bodies) PetscCall(MpmRigidSettle(contacts, rules->grid, &moved));
  } while (moved);
  if (contacts->facets.count) PetscCall(AppendBoxes(contacts, space));
  contacts->newton.near = (PetscBool)(contacts->patch_count > 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- weights ---- */

/* Strength of the material along the surface: mean over the facets, infinite where one of their laws has no limit. */
static void Strengths(MpmContacts *contacts, const MpmSum *sum)
{
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPatch *patch = &contacts->patch[k];

    patch->strength = 0.;
    for (PetscInt f = patch->begin; f < patch->end; f++) {
      const MpmFacet    *facet    = &contacts->facets.at[f];
      const MpmMaterial *material = facet->piece ? NULL : &sum->materials[sum->points->material[facet->point]];

      patch->strength +=
        facet->area / patch->area *
        (facet->piece ? contacts->facets.pieces.at[facet->piece - 1].kept[MPM_PIECE_STRENGTH]
                      : MpmMaterialShearStrength(material, MpmPointOwn(sum->points, material, facet->point),
                                                 sum->points->state + facet->point * sum->kept.state));
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
      contacts->facets.at[f].weight = size;
      size += space->groups[contacts->patch[k].box].node_count;
    }
  }
  PetscCall(PetscFree(contacts->weight));
  PetscCall(PetscMalloc1(size, &contacts->weight));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    for (PetscInt f = contacts->patch[k].begin; f < contacts->patch[k].end; f++) {
      MpmFacet            facet = contacts->facets.at[f];
      const MpmRigidBody *body  = MpmFacetsBody(&contacts->facets, facet.boundary);

      if (body) MpmRigidPush(body, &contacts->facets.at[f], facet.place);
      MpmFacetBoxWeights(&contacts->facets, step->rules, space, step->sum->points, &facet,
                         &space->groups[contacts->patch[k].box], &contacts->weight[facet.weight]);
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
  if (!contacts->facets.boundary_count) PetscFunctionReturn(PETSC_SUCCESS);
  MpmFacetsSetPoses(&contacts->facets, step->rules->time.start, step->rules->time.end);
  if (!again) PetscCall(WeighFacets(contacts, step));
  PetscCall(MpmPiecesLoad(&contacts->facets, step));
  Strengths(contacts, step->sum);
  PetscCall(MpmContactsLoad(contacts, step));
  if (!again || !contacts->facets.bodies) PetscFunctionReturn(PETSC_SUCCESS);
  MpmRigidBegin(contacts, step->rules);
  while (moved) PetscCall(MpmRigidSettle(contacts, step->rules->grid, &moved));
  PetscFunctionReturn(PETSC_SUCCESS);
}
