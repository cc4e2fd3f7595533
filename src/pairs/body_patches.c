/*
  Facets and patches of bodies in contact with one another: candidates of contact in a step.

  Facets of the first body in one cell make a patch; each facet of the second body goes to the patch of the facet of the
  first that lies across from it: the nearest one of opposite normal and before which its middle stands. The patch
  belongs to the rank of the first body's points, which appends the nodes of both sides to its own.

    n = (sum A_1 n_1 - sum A_2 n_2)/|...| ,   gap = n . (y_2 - y_1) ,

  with y the means of the facets' places, by their areas along n, the sums over facets near the patch, n_i their
  normals, and A_i the areas along them (body_facets.c). Bodies that overlap when the run starts touch from there on, as
  at rigid surfaces. Small gaps touch, too, where an unknown surface cut a lattice at an angle: of points from a file.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "pairs/body_facets.h"

#define TOUCH  1e-12 /* of a cell: rounding */
#define SMOOTH 2.5   /* cells: facets so near make the normal of a patch */
#define LOOKS  0.2   /* cosine: facets of the first body that look farther away are not part of a patch */
#define FACING 0.5   /* cosine: facets that look at one another less do not lie across */
#define SOFT   10.   /* penalty on bodies that flow, unless one is given */

/* ---- who lies across from whom ---- */

/* Distance of a second body's facet's middle from a facet of the first; infinite where it does not lie before it. */
static PetscReal Across(PetscInt dim, const MpmPairFacet *one, const MpmPairFacet *other, PetscReal reach)
{
  PetscReal dot = 0., along = 0., square = 0.;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal d = other->place[a] - one->place[a];

    dot += one->look[a] * other->look[a];
    along += d * one->look[a];
    square += d * d;
  }
  if (dot > -FACING || square > reach * reach) return PETSC_INFINITY;
  if (PetscSqrtReal(PetscMax(square - along * along, 0.)) >
      (one->size + other->size) * PetscSqrtReal((PetscReal)dim - 1.))
    return PETSC_INFINITY;
  return square;
}

/* The facet of the first body that lies across from facet k of the second, or -1. */
static PetscInt Opposite(const MpmPairContacts *contacts, const MpmGrid *grid, const MpmPair *pair, PetscInt k)
{
  const MpmPairFacet *other = &contacts->facets.at[k];
  PetscInt            lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], cell[MPM_MAX_DIM], found = -1;
  PetscReal           best = PETSC_INFINITY;

  MpmPairFacetCells(grid, other, MPM_PAIR_SEARCH, lower, upper);
  for (cell[2] = lower[2]; cell[2] <= upper[2]; cell[2]++) {
    for (cell[1] = lower[1]; cell[1] <= upper[1]; cell[1]++) {
      for (cell[0] = lower[0]; cell[0] <= upper[0]; cell[0]++) {
        PetscInt begin, end;

        MpmPairFacetsOfCell(contacts, cell, &begin, &end);
        for (PetscInt f = begin; f < end; f++) {
          const MpmPairFacet *one = &contacts->facets.at[f];
          PetscReal           distance;

          if (one->part != pair->part[0]) continue;
          distance = Across(grid->dim, one, other, MPM_PAIR_SEARCH * contacts->cell);
          if (distance < best * (1. - 1e-9) || (distance < PETSC_INFINITY && found < 0)) {
            best  = distance;
            found = f;
          }
        }
      }
    }
  }
  return found;
}

/* ---- patches ---- */

/* True where the facet's normal is along the direction, of length 1, rather than across it. */
static PetscBool Looks(PetscInt dim, const MpmPairFacet *facet, const PetscReal direction[])
{
  PetscReal dot = 0.;

  for (PetscInt a = 0; a < dim; a++) dot += facet->look[a] * direction[a];
  return (PetscBool)(dot > LOOKS);
}

/*
  The outward normal of the first body about a place: the mean of both bodies' normals there by area, the nearest first,
  over the facets that have one of the other body across. Normals of the patch alone would show the steps of the
  lattices, not the surface that cut them, where that is not known. Steps count where there is nothing else (`all`).
*/
static PetscBool SmoothNormal(const MpmPairContacts *contacts, const MpmGrid *grid, const MpmPair *pair,
                              const MpmPairFacet *about, PetscBool all, PetscReal normal[])
{
  const PetscInt dim  = grid->dim;
  PetscReal      size = 0.;
  PetscInt       lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], cell[MPM_MAX_DIM];

  MpmPairFacetCells(grid, about, SMOOTH, lower, upper);
  for (PetscInt a = 0; a < dim; a++) normal[a] = 0.;
  for (cell[2] = lower[2]; cell[2] <= upper[2]; cell[2]++) {
    for (cell[1] = lower[1]; cell[1] <= upper[1]; cell[1]++) {
      for (cell[0] = lower[0]; cell[0] <= upper[0]; cell[0]++) {
        PetscInt begin, end;

        MpmPairFacetsOfCell(contacts, cell, &begin, &end);
        for (PetscInt f = begin; f < end; f++) {
          const MpmPairFacet *facet = &contacts->facets.at[f];
          PetscReal           near = 0., sign = 0.;

          if (!facet->across) continue;
          if (facet->part == pair->part[0]) sign = 1.;
          if (facet->part == pair->part[1]) sign = -1.;
          for (PetscInt a = 0; a < dim; a++) near += PetscSqr(facet->place[a] - about->place[a]);
          near = PetscMax(0., 1. - PetscSqrtReal(near) / (SMOOTH * contacts->cell));
          for (PetscInt a = 0; a < dim; a++)
            normal[a] += sign * near * near * (all ? facet->area[a] : facet->seen * facet->look[a]);
        }
      }
    }
  }
  for (PetscInt a = 0; a < dim; a++) size += PetscSqr(normal[a]);
  for (PetscInt a = 0; size > 0. && a < dim; a++) normal[a] /= PetscSqrtReal(size);
  return (PetscBool)(size > 0.);
}

/* Means and stiffness from the facets. */
static void Describe(const MpmPairContacts *contacts, PetscInt dim, MpmPairPatch *patch)
{
  const MpmPair *pair    = &contacts->pairs->at[patch->pair];
  PetscReal      modulus = PETSC_INFINITY, flows = 0.;

  patch->strength = PETSC_INFINITY;
  MPM_PAIR_SIDES(patch, f, s)
  {
    const MpmPairFacet *facet = &contacts->facets.at[contacts->facets.list[f]];
    PetscReal           area  = 0.;

    for (PetscInt a = 0; a < dim; a++) area += patch->normal[a] * facet->area[a];
    area = PetscAbsReal(area);
    for (PetscInt a = 0; a < dim; a++) patch->side[s].place[a] += area * facet->place[a];
    patch->side[s].area += area;
    modulus         = PetscMin(modulus, facet->material.modulus);
    flows           = PetscMax(flows, facet->material.plastic);
    patch->strength = PetscMin(patch->strength, facet->material.strength);
  }
  patch->gap = 0.;
  for (PetscInt a = 0; a < dim; a++)
    patch->gap += patch->normal[a] *
                  (patch->side[1].place[a] / patch->side[1].area - patch->side[0].place[a] / patch->side[0].area);
  patch->stiffness = (flows > 0. && !pair->firm ? SOFT : pair->penalty) * modulus / contacts->cell;
}

/* Widens a box of nodes to hold a facet's; an empty box has no nodes. */
static void IncludeNodes(MpmGroup *box, const MpmPairFacet *facet)
{
  const PetscBool empty = (PetscBool)!box->node_count;

  box->node_count = 1;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const PetscInt first = empty ? facet->first[a] : PetscMin(box->first[a], facet->first[a]);
    const PetscInt end   = PetscMax(empty ? 0 : box->first[a] + box->count[a], facet->first[a] + facet->count[a]);

    box->first[a] = first;
    box->count[a] = end - first;
    box->node_count *= box->count[a];
  }
  box->holes = PETSC_TRUE;
}

/* The mean's weights at the nodes of a box: those of a facet, times its share of the area. */
static void AddWeights(PetscInt dim, const MpmPairFacet *facet, const MpmGroup *box, PetscReal share,
                       PetscReal weight[])
{
  for (PetscInt i = 0; i < box->node_count; i++) {
    const PetscInt row             = i / box->count[0];
    const PetscInt at[MPM_MAX_DIM] = {i % box->count[0], row % box->count[1], row / box->count[1]};
    PetscReal      w               = share;

    for (PetscInt a = 0; a < dim; a++) {
      const PetscInt k = at[a] + box->first[a] - facet->first[a];

      w *= k >= 0 && k < facet->count[a] ? facet->line[a][k] : 0.;
    }
    weight[i] += w;
  }
}

/* Nodes of other ranks' facets become ghosts here: a box each, beside the sides' own, which have holes. */
static PetscErrorCode AppendForeign(const MpmPairContacts *contacts, MpmSpace *space)
{
  PetscInt  count = 0;
  MpmGroup *boxes;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->facets.list_count; k++)
    count += contacts->facets.at[contacts->facets.list[k]].point < 0;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSpaceAppendBoxes(space, count, &boxes));
  for (PetscInt k = 0, box = 0; k < contacts->facets.list_count; k++) {
    const MpmPairFacet *facet = &contacts->facets.at[contacts->facets.list[k]];

    if (facet->point >= 0) continue;
    IncludeNodes(&boxes[box], facet);
    boxes[box++].holes = PETSC_FALSE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Boxes of both sides of all patches. */
static PetscErrorCode MakeSides(MpmPairContacts *contacts, MpmSpace *space)
{
  const PetscInt begin = space->boxes.count;
  MpmGroup      *boxes;

  PetscFunctionBeginUser;
  PetscCall(MpmSpaceAppendBoxes(space, 2 * contacts->patch_count, &boxes));
  contacts->most = contacts->weights.count = 0;
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    MpmPairPatch *patch = &contacts->patch[k];

    MPM_PAIR_SIDES(patch, f, s) IncludeNodes(&boxes[2 * k + s], &contacts->facets.at[contacts->facets.list[f]]);
    for (PetscInt s = 0; s < 2; s++) {
      patch->side[s].box    = begin + 2 * k + s;
      patch->side[s].weight = contacts->weights.count;
      contacts->weights.count += boxes[2 * k + s].node_count;
    }
    contacts->most = PetscMax(contacts->most, boxes[2 * k].node_count + boxes[2 * k + 1].node_count);
  }
  PetscCall(AppendForeign(contacts, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The weights of the means at the nodes of both sides. */
static PetscErrorCode WeighSides(MpmPairContacts *contacts, const MpmSpace *space)
{
  const PetscInt dim = space->dim;

  PetscFunctionBeginUser;
  PetscCall(PetscFree(contacts->weights.at));
  PetscCall(PetscCalloc1(contacts->weights.count, &contacts->weights.at));
  for (PetscInt k = 0; k < contacts->patch_count; k++) {
    const MpmPairPatch *patch = &contacts->patch[k];

    MPM_PAIR_SIDES(patch, f, s)
    {
      const MpmPairFacet *facet = &contacts->facets.at[contacts->facets.list[f]];
      PetscReal           area  = 0.;

      for (PetscInt a = 0; a < dim; a++) area += patch->normal[a] * facet->area[a];
      AddWeights(dim, facet, &space->groups[patch->side[s].box], PetscAbsReal(area) / patch->side[s].area,
                 &contacts->weights.at[patch->side[s].weight]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where both are in one cell. */
static PetscBool SameCell(const MpmPairFacet *one, const MpmPairFacet *other)
{
  return (PetscBool)(one->cell[0] == other->cell[0] && one->cell[1] == other->cell[1] &&
                     one->cell[2] == other->cell[2]);
}

/* One patch: `count` facets of the second body, across from facets of the first in the cell of facet `seed`. */
static PetscErrorCode AddPatch(MpmPairContacts *contacts, const MpmGrid *grid, PetscInt pair, PetscInt seed,
                               PetscInt count, const PetscInt others[])
{
  const MpmPair *bodies = &contacts->pairs->at[pair];
  MpmPairPatch   patch  = {.pair = pair};
  MpmPairFacet   about  = contacts->facets.at[seed];
  PetscInt       f      = seed;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < grid->dim; a++) {
    about.place[a] = 0.;
    for (PetscInt k = 0; k < count; k++) about.place[a] += contacts->facets.at[others[k]].place[a] / (PetscReal)count;
  }
  if (!SmoothNormal(contacts, grid, bodies, &about, PETSC_FALSE, patch.normal))
    (void)SmoothNormal(contacts, grid, bodies, &about, PETSC_TRUE, patch.normal);
  while (f > 0 && SameCell(&contacts->facets.at[f - 1], &contacts->facets.at[seed])) f--;
  patch.side[0].begin = contacts->facets.list_count;
  for (; f < contacts->facets.count && SameCell(&contacts->facets.at[f], &contacts->facets.at[seed]); f++)
    if (contacts->facets.at[f].part == bodies->part[0] && Looks(grid->dim, &contacts->facets.at[f], patch.normal))
      contacts->facets.list[contacts->facets.list_count++] = f;
  patch.side[0].end = patch.side[1].begin = contacts->facets.list_count;
  for (PetscInt k = 0; k < count; k++) contacts->facets.list[contacts->facets.list_count++] = others[k];
  patch.side[1].end = contacts->facets.list_count;
  if (patch.side[0].begin == patch.side[0].end) PetscFunctionReturn(PETSC_SUCCESS);
  Describe(contacts, grid->dim, &patch);
  if (!(patch.side[0].area > 0. && patch.side[1].area > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscRealloc((size_t)(contacts->patch_count + 1) * sizeof(MpmPairPatch), &contacts->patch));
  contacts->patch[contacts->patch_count++] = patch;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The patches of one pair: facets of the second body that lie across from own ones of the first in one cell. */
static PetscErrorCode PatchesOfPair(MpmPairContacts *contacts, const MpmGrid *grid, PetscInt pair)
{
  const MpmPair *bodies = &contacts->pairs->at[pair];
  PetscInt      *opposite, *other, count = 0, end;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(contacts->facets.count, &opposite, contacts->facets.count, &other));
  for (PetscInt k = 0; k < contacts->facets.count; k++) contacts->facets.at[k].across = 0;
  for (PetscInt k = 0; k < contacts->facets.count; k++) {
    const PetscInt found = contacts->facets.at[k].part == bodies->part[1] ? Opposite(contacts, grid, bodies, k) : -1;

    if (found < 0) continue;
    contacts->facets.at[k].across = contacts->facets.at[found].across = 1;
    if (contacts->facets.at[found].point < 0) continue; /* another rank's */
    opposite[count] = found;
    other[count++]  = k;
  }
  PetscCall(PetscSortIntWithArray(count, opposite, other));
  for (PetscInt begin = 0; begin < count; begin = end) {
    const MpmPairFacet *seed = &contacts->facets.at[opposite[begin]];

    for (end = begin; end < count && SameCell(&contacts->facets.at[opposite[end]], seed); end++) continue;
    PetscCall(PetscSortInt(end - begin, &other[begin]));
    PetscCall(AddPatch(contacts, grid, pair, opposite[begin], end - begin, &other[begin]));
  }
  PetscCall(PetscFree2(opposite, other));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairPatchesFind(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  MpmPairContacts *contacts = (MpmPairContacts *)ctx;

  PetscFunctionBeginUser;
  contacts->patch_count = contacts->facets.list_count = 0;
  contacts->newton.near                               = PETSC_FALSE;
  if (!contacts->pairs->count) PetscFunctionReturn(PETSC_SUCCESS);
  contacts->cell = PETSC_INFINITY;
  for (PetscInt a = 0; a < space->dim; a++) contacts->cell = PetscMin(contacts->cell, rules->grid->h[a]);
  contacts->touch   = TOUCH * contacts->cell;
  contacts->starts  = (PetscBool)(rules->time.start == 0. && !rules->put_back);
  contacts->dynamic = rules->dynamic;
  PetscCall(MpmPairFacetsFind(contacts, rules, points, space));
  if (!contacts->facets.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(contacts->facets.list));
  PetscCall(PetscMalloc1((2 * contacts->facets.count * contacts->pairs->count), &contacts->facets.list));
  for (PetscInt k = 0; k < contacts->pairs->count; k++) PetscCall(PatchesOfPair(contacts, rules->grid, k));
  if (contacts->patch_count) PetscCall(MakeSides(contacts, space));
  if (contacts->patch_count) PetscCall(WeighSides(contacts, space));
  contacts->newton.near = (PetscBool)(contacts->patch_count > 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairPatchesLink(void *ctx, MpmSpace *space)
{
  const MpmPairContacts *contacts = (const MpmPairContacts *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < contacts->patch_count; k++)
    PetscCall(MpmSpaceCouple(space, contacts->patch[k].side[0].box, contacts->patch[k].side[1].box));
  PetscFunctionReturn(PETSC_SUCCESS);
}
