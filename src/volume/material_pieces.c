/*
  Pieces of the spline that hold material. Each rank marks those that its points may touch and exchanges marks with the
  owners of nodes around them.
*/
#include "point/material.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "extension/pieces.h"
#include "space/rules.h"
#include "space/space.h"
#include "volume/material_pieces.h"

#define SPARSE_SPACING 0.6 /* cells between points, from which on they are sparse */

static PetscInt LayerSize(const MpmMaterialPieces *map)
{
  PetscInt size = 1;

  for (PetscInt a = 0; a < map->dim - 1; a++) size *= map->size[a];
  return size;
}

static PetscErrorCode MapCreate(MpmMaterialPieces *map)
{
  const PetscInt layers = map->size[map->dim - 1];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((map->size[0] * map->size[1] * map->size[2]), &map->mark, layers, &map->used));
  PetscCall(PetscArrayzero(map->used, layers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where in the map: -1 outside. */
static inline PetscInt CellIndex(const MpmMaterialPieces *map, const PetscInt cell[])
{
  PetscInt i = 0;

  for (PetscInt a = map->dim - 1; a >= 0; a--) {
    const PetscInt k = cell[a] - map->lower[a];

    if (k < 0 || k >= map->size[a]) return -1;
    i = i * map->size[a] + k;
  }
  return i;
}

PetscInt MpmMaterialPieceMark(const MpmMaterialPieces *map, const PetscInt cell[])
{
  const PetscInt i = CellIndex(map, cell);

  return i >= 0 && map->used[cell[map->dim - 1] - map->lower[map->dim - 1]] ? map->mark[i] : 0;
}

/* Beyond a wall there is as little as beyond the grid's edge: a neighbour there makes no edge of the material. */
PetscBool MpmMaterialPieceIsEdge(const MpmMaterialPieces *map, const MpmRules *rules, const PetscInt cell[])
{
  const PetscInt more              = MpmKnotsBetween(map->knots) ? 1 : 0;
  PetscInt       next[MPM_MAX_DIM] = {cell[0], cell[1], cell[2]}, lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  for (PetscInt a = 0; a < map->dim; a++) {
    for (PetscInt side = -1; side <= 1; side += 2) {
      next[a] = cell[a] + side;
      if (MpmMaterialPieceMark(map, next)) continue;
      MpmPieceEdges(map->space, rules, map->knots, cell, lower, upper);
      if (next[a] >= lower[a] && next[a] < upper[a] + more) return PETSC_TRUE;
    }
    next[a] = cell[a];
  }
  return PETSC_FALSE;
}

/* Adds a mark to a piece's. */
static void Mark(const MpmMaterialPieces *map, const MpmMaterial materials[], const PetscInt cell[], PetscInt added)
{
  const PetscInt at = CellIndex(map, cell), layer = cell[map->dim - 1] - map->lower[map->dim - 1];
  const PetscInt each = LayerSize(map);
  PetscInt      *mark, material = MpmMarkMaterial(added);

  if (at < 0) return;
  mark = &map->mark[at];
  if (!map->used[layer]) (void)memset(&map->mark[layer * each], 0, (size_t)each * sizeof(PetscInt));
  map->used[layer] = PETSC_TRUE;
  if (!*mark) *mark = added;
  if (materials[MpmMarkMaterial(*mark)].moduli.penalty >= materials[material].moduli.penalty)
    material = MpmMarkMaterial(*mark);
  *mark = 1 + 2 * material + (MpmMarkIsSparse(*mark) || MpmMarkIsSparse(added));
}

/*
  True where points stand as far apart as at one a cell, from the start or by stretch. Elements of order 2 and more take
  the lengths of domains as distances, also of a material that flows. With other shapes such a material has none: its
  points have deformed further than its elastic part.
*/
static PetscBool IsSparse(const MpmSpace *space, const MpmRules *rules, const MpmPoints *points, PetscInt p)
{
  const PetscInt     dim      = rules->grid->dim;
  const MpmMaterial *material = &rules->materials[points->material[p]];
  const PetscReal    spacing  = MpmShapeSpacing(rules->shape, material->spacing);
  const PetscInt     order    = MpmShapeOrder(rules->shape);
  PetscReal          U[MPM_MAX_DIM], most = 0.;

  if (spacing >= 1.) return PETSC_TRUE;
  if (spacing < MPM_SPARSE_LEAST) return PETSC_FALSE;
  if (space->shapes.half && order > 1) {
    for (PetscInt a = 0; a < dim; a++) most = PetscMax(most, space->shapes.half[p * dim + a]);
    return (PetscBool)((PetscReal)(order + 1) * most > SPARSE_SPACING);
  }
  if (material->state_size || rules->stretch(MpmPointF(points, p), U)) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) most = PetscMax(most, U[a]);
  return (PetscBool)(spacing * most > SPARSE_SPACING);
}

/* The spans that a group's points may touch: those whose nodes are all in its box, less those removed by an edge. */
static void GroupPieces(const MpmSpace *space, const MpmGroup *group, const MpmRules *rules, const MpmPoints *points,
                        PetscInt lower[], PetscInt count[])
{
  const MpmKnots knots = {MpmShapeDegree(rules->shape), MpmShapeOrder(rules->shape)};
  const PetscInt p = knots.degree, one = space->order[group->point_begin] * space->dim;
  const PetscInt shift             = space->parts.spans * group->part;
  PetscInt       edge[MPM_MAX_DIM] = {0}, far_edge[MPM_MAX_DIM] = {0};

  MpmSpaceEdges(rules, &points->x[one], edge, far_edge);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = 0;
    count[a] = 1;
    if (a >= rules->grid->dim) continue;
    const PetscInt first = space->touched.first[one + a], last = first + space->touched.count[one + a] - 1;
    PetscInt       begin = first + p / 2, end = last - p + p / 2;

    if (first == edge[a]) begin = first;
    if (last == far_edge[a]) end = last - p % 2;
    if (knots.order > 1) {
      begin = MpmPieceOfNode(knots, first);
      end   = MpmPieceOfNode(knots, last) - 1;
    }
    lower[a] = PetscMin(begin, end);
    count[a] = PetscMax(end - lower[a] + 1, 1);
  }
  lower[space->dim - 1] += shift;
}

/* Marks the cells of this rank's points, in a map that reaches `margin` cells further. */
static PetscErrorCode MarkOwnPoints(const MpmSpace *space, const MpmRules *rules, const MpmPoints *points,
                                    PetscInt margin, MpmMaterialPieces *map)
{
  PetscInt upper[MPM_MAX_DIM] = {0, 0, 0}, lower[MPM_MAX_DIM], count[MPM_MAX_DIM], cell[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  map->space = space;
  map->dim   = space->dim;
  map->knots = (MpmKnots){MpmShapeDegree(rules->shape), MpmShapeOrder(rules->shape)};
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) map->lower[a] = PETSC_INT_MAX;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    GroupPieces(space, group, rules, points, lower, count);
    for (PetscInt a = 0; a < space->dim; a++) {
      map->lower[a] = PetscMin(map->lower[a], lower[a] - margin);
      upper[a]      = PetscMax(upper[a], lower[a] + count[a] + margin);
    }
  }
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    if (a >= space->dim) map->lower[a] = 0;
    map->size[a] = a >= space->dim ? 1 : space->group_count ? upper[a] - map->lower[a] : 0;
  }
  PetscCall(MapCreate(map));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    GroupPieces(space, group, rules, points, lower, count);
    PetscInt last = 0;

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p    = space->order[s],
                     mark = 1 + 2 * points->material[p] + (IsSparse(space, rules, points, p) ? 1 : 0);

      if (mark == last) continue;
      MPM_FOR_BOX(lower, count, cell) Mark(map, rules->materials, cell, mark);
      last = mark;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The ranks that own a cell within two of this one: `rank` has room for grid->size. */
static PetscInt RanksAround(const MpmSpace *space, const MpmGrid *grid, const PetscInt cell[], PetscMPIInt rank[])
{
  PetscInt at[MPM_MAX_DIM], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  MpmSpaceSpanAt(space, cell, at);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = at[a] - 2;
    upper[a] = at[a] + 2;
  }
  return MpmGridBoxOwners(grid, lower, upper, rank);
}

/* Widens the map to hold the cells of received marks: a rank may own cells that none of its own points is near. */
static PetscErrorCode Widen(const MpmLists *received, const MpmMaterial materials[], MpmMaterialPieces *map)
{
  const PetscInt    stride = map->dim + 1, end = received->offset[received->count];
  MpmMaterialPieces wide = *map;
  PetscInt          cell[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscBool         wider = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) upper[a] = map->size[a] ? map->lower[a] + map->size[a] : PETSC_INT_MIN;
  for (PetscInt k = 0; k < end; k++) {
    const PetscInt a = k % stride, at = received->data[k];

    if (a == map->dim) continue;
    if (at >= wide.lower[a] && at < upper[a]) continue;
    upper[a]      = PetscMax(upper[a], at + 1);
    wide.lower[a] = PetscMin(wide.lower[a], at);
    wider         = PETSC_TRUE;
  }
  if (!wider) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) wide.size[a] = upper[a] - wide.lower[a];
  PetscCall(MapCreate(&wide));
  MPM_FOR_BOX(map->lower, map->size, cell)
  {
    const PetscInt mark = MpmMaterialPieceMark(map, cell);

    if (mark) Mark(&wide, materials, cell, mark);
  }
  PetscCall(PetscFree2(map->mark, map->used));
  *map = wide;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists with room for so many numbers to each rank; slot[r]: the list of rank r, fill[k]: where list k begins. */
static PetscErrorCode ListsCreate(PetscMPIInt size, const PetscInt length[], MpmLists *sent, PetscInt slot[],
                                  PetscInt fill[])
{
  PetscFunctionBeginUser;
  for (PetscMPIInt r = 0; r < size; r++) sent->count += length[r] > 0;
  PetscCall(PetscMalloc1(sent->count, &sent->rank));
  PetscCall(PetscMalloc1((sent->count + 1), &sent->offset));
  sent->offset[0] = 0;
  for (PetscMPIInt r = 0, k = 0; r < size; r++) {
    if (!length[r]) continue;
    sent->rank[k]       = r;
    slot[r]             = k;
    fill[k]             = sent->offset[k];
    sent->offset[k + 1] = sent->offset[k] + length[r];
    k++;
  }
  PetscCall(PetscMalloc1(sent->offset[sent->count], &sent->data));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The marks of this rank's cells for the ranks that own them or whose own cells lie within two of them. */
static PetscErrorCode ListMarks(const MpmGrid *grid, const MpmMaterialPieces *map, MpmLists *sent)
{
  PetscMPIInt *around;
  PetscInt    *length, *slot, *fill, cell[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(grid->size, &around));
  PetscCall(PetscCalloc1(grid->size, &length));
  PetscCall(PetscMalloc2(grid->size, &slot, grid->size, &fill));
  for (PetscInt pass = 0; pass < 2; pass++) {
    MPM_FOR_BOX(map->lower, map->size, cell)
    {
      const PetscInt mark  = MpmMaterialPieceMark(map, cell),
                     ranks = mark ? RanksAround(map->space, grid, cell, around) : 0;

      for (PetscInt r = 0; r < ranks; r++) {
        if (around[r] == grid->rank) continue;
        if (!pass) length[around[r]] += grid->dim + 1;
        else {
          PetscInt *to = &sent->data[fill[slot[around[r]]]];

          for (PetscInt a = 0; a < grid->dim; a++) to[a] = cell[a];
          to[grid->dim] = mark;
          fill[slot[around[r]]] += grid->dim + 1;
        }
      }
    }
    if (!pass) PetscCall(ListsCreate(grid->size, length, sent, slot, fill));
  }
  PetscCall(PetscFree(around));
  PetscCall(PetscFree(length));
  PetscCall(PetscFree2(slot, fill));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells every rank the marks of cells that it owns or that lie within two cells of its own. */
static PetscErrorCode ExchangeMarks(const MpmGrid *grid, const MpmMaterial materials[], MpmMaterialPieces *map)
{
  MpmLists sent = {0}, received = {0};

  PetscFunctionBeginUser;
  PetscCall(ListMarks(grid, map, &sent));
  PetscCall(MpmListsExchange(grid->comm, &sent, &received));
  PetscCall(Widen(&received, materials, map));
  for (PetscInt k = 0; k < received.offset[received.count]; k += grid->dim + 1) {
    PetscInt at[MPM_MAX_DIM] = {0, 0, 0};

    for (PetscInt a = 0; a < grid->dim; a++) at[a] = received.data[k + a];
    Mark(map, materials, at, received.data[k + grid->dim]);
  }
  PetscCall(MpmListsDestroy(&sent));
  PetscCall(MpmListsDestroy(&received));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialPiecesCreate(const MpmSpace *space, const MpmRules *rules, const MpmPoints *points,
                                       MpmMaterialPieces *map)
{
  PetscFunctionBeginUser;
  PetscCall(MarkOwnPoints(space, rules, points, rules->grid->size > 1 ? 3 : 0, map));
  if (rules->grid->size > 1) PetscCall(ExchangeMarks(rules->grid, rules->materials, map));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialPiecesDestroy(MpmMaterialPieces *map)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(map->mark, map->used));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmMaterialPieceAt(const MpmMaterialPieces *map, PetscInt at, PetscInt cell[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; at /= map->size[a], a++) cell[a] = map->lower[a] + at % map->size[a];
}

PetscInt MpmMaterialPiecesOwned(const MpmMaterialPieces *map, const MpmGrid *grid, PetscInt pieces[])
{
  const PetscInt layers = map->size[map->dim - 1], each = LayerSize(map);
  PetscInt       cell[MPM_MAX_DIM], at[MPM_MAX_DIM], count = 0;

  for (PetscInt layer = 0; layer < layers; layer++) {
    for (PetscInt i = layer * each; map->used[layer] && i < (layer + 1) * each; i++) {
      if (!map->mark[i]) continue;
      MpmMaterialPieceAt(map, i, cell);
      MpmSpaceSpanAt(map->space, cell, at);
      if (MpmGridCellOwner(grid, at) == grid->rank) pieces[count++] = i;
    }
  }
  return count;
}
