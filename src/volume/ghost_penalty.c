/*
  Ghost penalty: a stabilization of small-cut nodes, those that only a sliver of the material touches.

  The grid's field is a spline of degree p, linear basis functions (p = 1) under GIMP too, and a polynomial on each knot
  span: the grid's cells, or for even p the cells around nodes. Spans that a point's domain touches are material; one
  with an empty neighbour in the grid is an edge span. On every face F between two material spans, one of them at least
  an edge span or made of a material with sparse points, the step's increment u gets the energy

    (gamma/2) E_s h_n^{2p-1} Int_F |[d^p u/dn^p]|^2 dA ,    h_n^p [d^p u/dn^p] = the (p + 1)-th difference of u along n

  over the p + 2 nodes that the two spans share out along the normal n; along the face the spline's mass matrix of one
  span integrates. E_s is Young's modulus of the stiffest material beside the face. The badly supported node is tied to
  the polynomial extension of its neighbours, whatever sliver touches it, and the energy vanishes for any polynomial of
  degree p. Acting on increments, it puts no lasting force on the material. Where a spline ends, at the grid's edge or a
  wall, nodes beyond have the coefficients of the shape functions there.

  Beside the displacement, where a physics has a factor for it, the one other component gets such an energy on its
  total, with that factor in place of E_s. For a pore pressure it is dt m + h^2/(2 mu), with m the mobility, the second
  fading with the first, so that the pressure is tied to its neighbours whether water has time to flow or not. The
  penalty's rows sum to zero: no water comes of it.

  Sparse points, one a cell on some axis from the start or by stretch, do not resolve the grid's field: nodal
  displacements that alternate from cell to cell strain no point, and a body folds up in them as it bends. These modes
  have the largest jumps of all, so that the penalty on every face, with gamma of at least MPM_GHOST_SPARSE, restores
  their stiffness. For a smooth field the jump is of order h^p and the penalty of the order of the discretisation error
  (Burman and Hansbo 2004, doi:10.1016/j.cma.2003.12.032, stabilise convection in this way).

  Flow whose dilation is less than its friction loses ellipticity long before a peak: increments that alternate from one
  row of cells to the next cost nothing, or less. An interior penalty, of the displacement alone, is this energy on
  every face with a factor of its own (MpmRules): the shorter a band, the stronger its effect, and it fades with h as
  the above does.

  A face is a group of nodes without points: numbering and sparsity treat it like one.

  Sources: Burman (2010), doi:10.1016/j.crma.2010.10.006; for the material point method Coombs (2023),
  doi:10.1002/nme.7332.
*/
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "volume/volume.h"

/* Cells between points from which on they are sparse; those with less at the start are not looked at. */
#define SPARSE_SPACING 0.6
#define SPARSE_LEAST   0.3

/* Most nodes of a face of the ghost penalty on an axis, and in all: cubic splines. */
#define FACE_WIDTH 5
#define FACE_NODES 80
/* A face of the ghost penalty; its box leaves out the nodes beyond an edge, where first does not. */
struct MpmFace {
  PetscInt    axis, degree;
  PetscInt    first[MPM_MAX_DIM], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* edges: nodes at which splines end */
  MpmEdgeType edge[MPM_MAX_DIM];
  PetscReal   stiffness;   /* gamma E_s, Pa */
  PetscReal   gamma;       /* of components other than displacement: 0 where the face has only the interior penalty */
  PetscInt    material[2]; /* on its two sides */
  PetscReal   along[MPM_MAX_DIM][FACE_WIDTH * FACE_WIDTH]; /* the matrix is their Kronecker product */
};

/*
  The material spans around this rank's nodes: 0 where there is none, or a mark. Layers across the last axis, along
  which bodies' parts lie apart, are empty until a span in them is marked.
*/
typedef struct {
  const MpmSpace *space;
  PetscInt        dim, degree, lower[MPM_MAX_DIM], size[MPM_MAX_DIM];
  PetscInt       *mark;
  PetscBool      *used; /* layers; marks of others are not set */
} CellMap;

static PetscInt LayerSize(const CellMap *map)
{
  return map->dim == 3 ? map->size[0] * map->size[1] : map->size[0];
}

static PetscErrorCode MapCreate(CellMap *map)
{
  const PetscInt layers = map->size[map->dim - 1];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((map->size[0] * map->size[1] * map->size[2]), &map->mark, layers, &map->used));
  PetscCall(PetscArrayzero(map->used, layers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where in the map: -1 outside. */
static inline PetscInt CellIndex(const CellMap *map, const PetscInt cell[])
{
  PetscInt i = 0;

  for (PetscInt a = map->dim - 1; a >= 0; a--) {
    const PetscInt k = cell[a] - map->lower[a];

    if (k < 0 || k >= map->size[a]) return -1;
    i = i * map->size[a] + k;
  }
  return i;
}

static inline PetscInt MarkAt(const CellMap *map, const PetscInt cell[])
{
  const PetscInt i = CellIndex(map, cell);

  return i >= 0 && map->used[cell[map->dim - 1] - map->lower[map->dim - 1]] ? map->mark[i] : 0;
}

/* The edges about the middle of a piece, in the indices of its part. */
static void PieceEdges(const MpmSpace *space, const MpmRules *rules, PetscInt degree, const PetscInt piece[],
                       PetscInt lower[], PetscInt upper[])
{
  const MpmGrid *grid  = rules->grid;
  const PetscInt last  = grid->dim - 1;
  const PetscInt shift = space->parts.stride * MpmSpacePart(space, piece);
  PetscInt       at[MPM_MAX_DIM];
  PetscReal      x[MPM_MAX_DIM];

  MpmSpaceAt(space, piece, at);
  for (PetscInt a = 0; a < grid->dim; a++)
    x[a] = grid->lower[a] + grid->h[a] * ((PetscReal)at[a] + (degree % 2 ? 0.5 : 0.));
  MpmSpaceEdges(rules, x, lower, upper);
  lower[last] += shift;
  upper[last] += shift;
}

/* Beyond a wall there is as little as beyond the grid's edge: a neighbour there makes no edge of the material. */
static PetscBool IsEdge(const CellMap *map, const MpmRules *rules, const PetscInt cell[])
{
  const PetscInt more              = map->degree % 2 ? 0 : 1;
  PetscInt       next[MPM_MAX_DIM] = {cell[0], cell[1], cell[2]}, lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  for (PetscInt a = 0; a < map->dim; a++) {
    for (PetscInt side = -1; side <= 1; side += 2) {
      next[a] = cell[a] + side;
      if (MarkAt(map, next)) continue;
      PieceEdges(map->space, rules, map->degree, cell, lower, upper);
      if (next[a] >= lower[a] && next[a] < upper[a] + more) return PETSC_TRUE;
    }
    next[a] = cell[a];
  }
  return PETSC_FALSE;
}

/* A mark: 1 + 2 times the stiffest material, one more where points are sparse. */
static PetscInt MarkMaterial(PetscInt mark)
{
  return (mark - 1) / 2;
}

static PetscBool MarkIsSparse(PetscInt mark)
{
  return (PetscBool)((mark - 1) % 2);
}

/* Adds a mark to a piece's. */
static void Mark(const CellMap *map, const MpmMaterial materials[], const PetscInt cell[], PetscInt added)
{
  const PetscInt at = CellIndex(map, cell), layer = cell[map->dim - 1] - map->lower[map->dim - 1];
  const PetscInt each = LayerSize(map);
  PetscInt      *mark, material = MarkMaterial(added);

  if (at < 0) return;
  mark = &map->mark[at];
  if (!map->used[layer]) (void)memset(&map->mark[layer * each], 0, (size_t)each * sizeof(PetscInt));
  map->used[layer] = PETSC_TRUE;
  if (!*mark) *mark = added;
  if (materials[MarkMaterial(*mark)].penalty >= materials[material].penalty) material = MarkMaterial(*mark);
  *mark = 1 + 2 * material + (MarkIsSparse(*mark) || MarkIsSparse(added));
}

/*
  True where points are as far apart here as they are at one a cell. A material without history may also have been
  stretched so far; where it flows, its points have deformed further than its elastic strain.
*/
static PetscBool IsSparse(const MpmRules *rules, const MpmPoints *points, PetscInt p)
{
  const PetscInt     dim      = rules->grid->dim;
  const MpmMaterial *material = &rules->materials[points->material[p]];
  PetscReal          U[MPM_MAX_DIM], most = 0.;

  if (material->spacing >= 1.) return PETSC_TRUE;
  if (material->spacing < SPARSE_LEAST || material->state_size || rules->stretch(&points->F[p * dim * dim], U))
    return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) most = PetscMax(most, U[a]);
  return (PetscBool)(material->spacing * most > SPARSE_SPACING);
}

#define FOR_BOX(lower, count, at) \
  for (at[2] = (lower)[2]; at[2] < (lower)[2] + (count)[2]; at[2]++) \
    for (at[1] = (lower)[1]; at[1] < (lower)[1] + (count)[1]; at[1]++) \
      for (at[0] = (lower)[0]; at[0] < (lower)[0] + (count)[0]; at[0]++)

/* The first of the p + 1 nodes of a piece, counted from the piece. */
static PetscInt FirstNode(PetscInt degree)
{
  return -(degree / 2);
}

/* The spans that a group's points may touch: those whose nodes are all in its box, less those removed by an edge. */
static void GroupPieces(const MpmSpace *space, const MpmGroup *group, const MpmRules *rules, const MpmPoints *points,
                        PetscInt lower[], PetscInt count[])
{
  const PetscInt p = MpmShapeDegree(rules->shape), one = space->order[group->point_begin] * space->dim;
  const PetscInt shift             = MpmSpaceShift(space, points->part, space->order[group->point_begin]);
  PetscInt       edge[MPM_MAX_DIM] = {0}, far_edge[MPM_MAX_DIM] = {0};

  MpmSpaceEdges(rules, &points->x[one], edge, far_edge);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = 0;
    count[a] = 1;
    if (a >= rules->grid->dim) continue;
    const PetscInt first = space->first[one + a], last = first + space->count[one + a] - 1;
    PetscInt       begin = first - FirstNode(p), end = last - p - FirstNode(p);

    if (first == edge[a]) begin = first;
    if (last == far_edge[a]) end = last - p % 2;
    lower[a] = PetscMin(begin, end);
    count[a] = PetscMax(end - lower[a] + 1, 1);
  }
  lower[space->dim - 1] += shift;
}

/* Marks the cells of this rank's points, in a map that reaches `margin` cells further. */
static PetscErrorCode MarkOwnPoints(const MpmSpace *space, const MpmRules *rules, const MpmPoints *points,
                                    PetscInt margin, CellMap *map)
{
  PetscInt upper[MPM_MAX_DIM] = {0, 0, 0}, lower[MPM_MAX_DIM], count[MPM_MAX_DIM], cell[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  map->space  = space;
  map->dim    = space->dim;
  map->degree = MpmShapeDegree(rules->shape);
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
      const PetscInt p = space->order[s], mark = 1 + 2 * points->material[p] + (IsSparse(rules, points, p) ? 1 : 0);

      if (mark == last) continue;
      FOR_BOX(lower, count, cell) Mark(map, rules->materials, cell, mark);
      last = mark;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The ranks that own a cell within two of this one: `rank` has room for grid->size. */
static PetscInt RanksAround(const MpmSpace *space, const MpmGrid *grid, const PetscInt cell[], PetscMPIInt rank[])
{
  PetscInt at[MPM_MAX_DIM], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  MpmSpaceAt(space, cell, at);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = at[a] - 2;
    upper[a] = at[a] + 2;
  }
  return MpmGridBoxOwners(grid, lower, upper, rank);
}

/* Widens the map to hold the cells of received marks: a rank may own cells that none of its own points is near. */
static PetscErrorCode Widen(const MpmLists *received, const MpmMaterial materials[], CellMap *map)
{
  const PetscInt stride = map->dim + 1, end = received->offset[received->count];
  CellMap        wide = *map;
  PetscInt       cell[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscBool      wider = PETSC_FALSE;

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
  FOR_BOX(map->lower, map->size, cell)
  {
    const PetscInt mark = MarkAt(map, cell);

    if (mark) Mark(&wide, materials, cell, mark);
  }
  PetscCall(PetscFree2(map->mark, map->used));
  *map = wide;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells every rank the marks of cells that it owns or that lie within two cells of its own. */
static PetscErrorCode ExchangeMarks(const MpmGrid *grid, const MpmMaterial materials[], CellMap *map)
{
  MpmLists     sent = {0}, received = {0};
  PetscMPIInt *around;
  PetscInt    *length, *slot, *fill, cell[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(grid->size, &around));
  PetscCall(PetscCalloc1(grid->size, &length));
  PetscCall(PetscMalloc2(grid->size, &slot, grid->size, &fill));
  for (PetscInt pass = 0; pass < 2; pass++) {
    FOR_BOX(map->lower, map->size, cell)
    {
      const PetscInt mark = MarkAt(map, cell), ranks = mark ? RanksAround(map->space, grid, cell, around) : 0;

      for (PetscInt r = 0; r < ranks; r++) {
        if (around[r] == grid->rank) continue;
        if (!pass) length[around[r]] += grid->dim + 1;
        else {
          PetscInt *to = &sent.data[fill[slot[around[r]]]];

          for (PetscInt a = 0; a < grid->dim; a++) to[a] = cell[a];
          to[grid->dim] = mark;
          fill[slot[around[r]]] += grid->dim + 1;
        }
      }
    }
    if (pass) break;
    for (PetscMPIInt r = 0; r < grid->size; r++) sent.count += length[r] > 0;
    PetscCall(PetscMalloc1(sent.count, &sent.rank));
    PetscCall(PetscMalloc1((sent.count + 1), &sent.offset));
    sent.offset[0] = 0;
    for (PetscMPIInt r = 0, k = 0; r < grid->size; r++) {
      if (!length[r]) continue;
      sent.rank[k]       = r;
      slot[r]            = k;
      fill[k]            = sent.offset[k];
      sent.offset[k + 1] = sent.offset[k] + length[r];
      k++;
    }
    PetscCall(PetscMalloc1(sent.offset[sent.count], &sent.data));
  }
  PetscCall(MpmListsExchange(grid->comm, &sent, &received));
  PetscCall(Widen(&received, materials, map));
  for (PetscInt k = 0; k < received.offset[received.count]; k += grid->dim + 1) {
    PetscInt at[MPM_MAX_DIM] = {0, 0, 0};

    for (PetscInt a = 0; a < grid->dim; a++) at[a] = received.data[k + a];
    Mark(map, materials, at, received.data[k + grid->dim]);
  }
  PetscCall(MpmListsDestroy(&sent));
  PetscCall(MpmListsDestroy(&received));
  PetscCall(PetscFree(around));
  PetscCall(PetscFree(length));
  PetscCall(PetscFree2(slot, fill));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The (p + 1)-th difference, and the mass matrix of p + 1 splines on one piece (times `whole`), h = 1. */
static const PetscReal difference[3][5] = {{1., -2., 1.}, {-1., 3., -3., 1.}, {1., -4., 6., -4., 1.}};
static const PetscReal mass[3][16]      = {
       {2., 1., 1., 2.},
       {6., 13., 1., 13., 54., 13., 1., 13., 6.},
       {20., 129., 60., 1., 129., 1188., 933., 60., 60., 933., 1188., 129., 1., 60., 129., 20.},
};
static const PetscReal whole[3] = {6., 120., 5040.};

/* Adds `value` to the nodes of the box that represent node `node`: itself, or those with its coefficient at or beyond
   an edge. */
static void Fold(const MpmFace *face, const MpmGroup *box, PetscInt a, PetscInt node, PetscReal value, PetscReal to[])
{
  const PetscInt inside = face->edge[a] == MPM_EDGE_OPEN ? 1 : 0; /* the first node that stands for itself */
  const PetscInt step   = node < face->lower[a] + inside ? 1 : node > face->upper[a] - inside ? -1 : 0;
  const PetscInt edge   = (step > 0 ? face->lower[a] : face->upper[a]) - box->first[a];

  if (!step) to[node - box->first[a]] += value;
  for (PetscInt k = 0; step && k <= face->degree; k++) {
    const PetscReal coefficient =
      MpmEdgeCoefficient(face->edge[a], face->degree, PetscAbsInt(edge + box->first[a] - node), k);

    if (coefficient != 0.) to[edge + step * k] += coefficient * value;
  }
}

/* The jump over the face at the nodes of its box along the normal. None where an edge has removed the knot:
   PETSC_FALSE. */
static PetscBool Jump(const MpmFace *face, const MpmGroup *box, PetscReal jump[])
{
  PetscReal most = 0.;

  for (PetscInt k = 0; k < box->count[face->axis]; k++) jump[k] = 0.;
  for (PetscInt k = 0; k < face->degree + 2; k++)
    Fold(face, box, face->axis, face->first[face->axis] + k, difference[face->degree - 1][k], jump);
  for (PetscInt k = 0; k < box->count[face->axis]; k++) most = PetscMax(most, PetscAbsReal(jump[k]));
  return (PetscBool)(most > 1e-12); /* differences are about 1 */
}

/* The face's matrix along one axis, count x count, for its Kronecker product. */
static void AxisMatrix(MpmFace *face, const MpmGroup *box, PetscInt a, PetscReal h)
{
  const PetscInt p = face->degree, n = box->count[a];
  PetscReal     *matrix = face->along[a];
  PetscReal      rows[(FACE_WIDTH - 1) * FACE_WIDTH], jump[FACE_WIDTH];

  for (PetscInt k = 0; k < n * n; k++) matrix[k] = 0.;
  if (a == face->axis) {
    (void)Jump(face, box, jump);
    for (PetscInt k = 0; k < n * n; k++) matrix[k] = jump[k / n] * jump[k % n] / h;
    return;
  }
  for (PetscInt i = 0; i <= p; i++) {
    for (PetscInt k = 0; k < n; k++) rows[i * n + k] = 0.;
    for (PetscInt j = 0; j <= p; j++)
      Fold(face, box, a, face->first[a] + j, mass[p - 1][i * (p + 1) + j] * h / whole[p - 1], &rows[i * n]);
  }
  for (PetscInt k = 0; k < n; k++) {
    PetscReal column[FACE_WIDTH] = {0.};

    for (PetscInt i = 0; i <= p; i++) Fold(face, box, a, face->first[a] + i, rows[i * n + k], column);
    for (PetscInt i = 0; i < n; i++) matrix[i * n + k] = column[i];
  }
}

/* The box of a face's nodes between the edges; PETSC_FALSE where there is no room for it, or nothing can jump. */
static PetscBool FaceBox(const MpmSpace *space, const MpmRules *rules, const PetscInt piece[], MpmFace *face,
                         MpmGroup *box)
{
  const MpmGrid *grid = rules->grid;
  PetscReal      jump[FACE_WIDTH];

  PieceEdges(space, rules, face->degree, piece, face->lower, face->upper);
  box->node_count  = 1;
  box->point_begin = box->point_end = 0;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    PetscInt last, low, high, reach, from;

    face->first[a] = box->first[a] = 0;
    box->count[a]                  = 1;
    if (a >= grid->dim) continue;
    face->edge[a]  = MpmEdgeOf(rules->edge, face->degree, face->upper[a] - face->lower[a]);
    face->first[a] = piece[a] + FirstNode(face->degree);
    last           = face->first[a] + face->degree + (a == face->axis);
    /* the box must contain the nodes that represent those beyond an edge, and at an open one on it */

    reach = face->edge[a] == MPM_EDGE_OPEN ? face->degree : 1;
    from  = face->edge[a] == MPM_EDGE_OPEN ? 0 : 1;
    low   = PetscMax(face->first[a], face->lower[a]);
    high  = PetscMin(last, face->upper[a]);
    if (face->lower[a] - face->first[a] >= from) high = PetscMax(high, face->lower[a] + reach);
    if (last - face->upper[a] >= from) low = PetscMin(low, face->upper[a] - reach);
    if (high <= low || high > face->upper[a] || low < face->lower[a]) return PETSC_FALSE;
    box->first[a] = low;
    box->count[a] = high - low + 1;
    box->node_count *= box->count[a];
  }
  return Jump(face, box, jump);
}

static void PieceCell(const CellMap *map, PetscInt at, PetscInt cell[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; at /= map->size[a], a++) cell[a] = map->lower[a] + at % map->size[a];
}

/* The material pieces that this rank owns, by their places in the map; returns their number. */
static PetscInt OwnPieces(const CellMap *map, const MpmGrid *grid, PetscInt pieces[])
{
  const PetscInt layers = map->size[map->dim - 1], each = LayerSize(map);
  PetscInt       cell[MPM_MAX_DIM], at[MPM_MAX_DIM], count = 0;

  for (PetscInt layer = 0; layer < layers; layer++) {
    for (PetscInt i = layer * each; map->used[layer] && i < (layer + 1) * each; i++) {
      if (!map->mark[i]) continue;
      PieceCell(map, i, cell);
      MpmSpaceAt(map->space, cell, at);
      if (MpmGridNodeOwner(grid, at) == grid->rank) pieces[count++] = i;
    }
  }
  return count;
}

/* Lists the faces whose lower piece is one of these; counts them where `faces` is NULL. */
static PetscInt ListFaces(const CellMap *map, const MpmRules *rules, PetscInt piece_count, const PetscInt pieces[],
                          MpmFace faces[], MpmGroup boxes[])
{
  const MpmGrid     *grid      = rules->grid;
  const MpmMaterial *materials = rules->materials;
  PetscInt           count     = 0;

  for (PetscInt k = 0; k < piece_count; k++) {
    PetscInt cell[MPM_MAX_DIM];

    PieceCell(map, pieces[k], cell);
    for (PetscInt axis = 0; axis < map->dim; axis++) {
      PetscInt next[MPM_MAX_DIM] = {cell[0], cell[1], cell[2]};
      MpmFace  face              = {.axis = axis, .degree = map->degree};
      MpmGroup box               = {0};

      next[axis]++;
      const PetscInt here = map->mark[pieces[k]], there = MarkAt(map, next);

      if (!there) continue;
      if (MarkIsSparse(here) || MarkIsSparse(there)) face.gamma = PetscMax(rules->ghost, rules->sparse);
      else if (IsEdge(map, rules, cell) || IsEdge(map, rules, next)) face.gamma = rules->ghost;
      if (!(face.gamma > 0. || rules->interior > 0.) || !FaceBox(map->space, rules, cell, &face, &box)) continue;
      face.material[0] = MarkMaterial(here);
      face.material[1] = MarkMaterial(there);
      face.stiffness   = PetscMax(face.gamma, rules->interior) *
                       PetscMax(materials[face.material[0]].penalty, materials[face.material[1]].penalty);
      if (faces) {
        for (PetscInt a = 0; a < map->dim; a++) AxisMatrix(&face, &box, a, grid->h[a]);
        faces[count] = face;
        boxes[count] = box;
      }
      count++;
    }
  }
  return count;
}

/* True where points of any material may be sparse. */
static PetscBool AnySparse(const MpmRules *rules)
{
  for (PetscInt m = 0; rules->sparse > 0. && m < rules->material_count; m++)
    if (rules->materials[m].spacing >= SPARSE_LEAST) return PETSC_TRUE;
  return PETSC_FALSE;
}

static PetscErrorCode Boxes(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  CellMap   map;
  MpmGroup *boxes;
  PetscInt *pieces, count;

  PetscFunctionBeginUser;
  (void)ctx;
  if (!(rules->ghost > 0. || rules->interior > 0. || AnySparse(rules))) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MarkOwnPoints(space, rules, points, rules->grid->size > 1 ? 3 : 0, &map));
  if (rules->grid->size > 1) PetscCall(ExchangeMarks(rules->grid, rules->materials, &map));
  PetscCall(PetscMalloc1((map.size[0] * map.size[1] * map.size[2]), &pieces));
  count              = OwnPieces(&map, rules->grid, pieces);
  space->faces.count = ListFaces(&map, rules, count, pieces, NULL, NULL);
  space->faces.begin = space->box_count;
  PetscCall(MpmSpaceAppendBoxes(space, space->faces.count, &boxes));
  PetscCall(PetscMalloc1(space->faces.count, &space->faces.face));
  (void)ListFaces(&map, rules, count, pieces, space->faces.face, boxes);
  PetscCall(PetscFree(pieces));
  PetscCall(PetscFree2(map.mark, map.used));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* out = A in along one axis of a box: `n` nodes of it, `before` and `after` of those that vary faster and slower. */
static void AxisApply(PetscInt before, PetscInt n, PetscInt after, const PetscReal A[], const PetscReal in[],
                      PetscReal out[])
{
  for (PetscInt k = 0; k < after; k++) {
    for (PetscInt i = 0; i < n; i++) {
      for (PetscInt b = 0; b < before; b++) {
        PetscReal s = 0.;

        for (PetscInt j = 0; j < n; j++) s += A[i * n + j] * in[(k * n + j) * before + b];
        out[(k * n + i) * before + b] = s;
      }
    }
  }
}

/* Components with the penalty: those of the displacement, and the one beside it where the physics has a factor. */
static PetscInt Components(const MpmSum *sum)
{
  const MpmLayout *layout = sum->layout;
  const PetscInt   dim    = layout->dim;

  return layout->ghost && layout->block == dim + 1 && !layout->shape_of[dim] ? dim + 1 : dim;
}

/* True where the face's matrix reaches into dry ground, where the slope of the pressure jumps. */
static PetscBool IsDry(const MpmSum *sum, const MpmFace *face)
{
  const MpmGroup *box   = &sum->space->groups[sum->space->faces.begin + (PetscInt)(face - sum->space->faces.face)];
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];

  for (PetscInt i = 0; sum->still.bent && i < box->node_count; i++)
    if (nodes[i] >= 0 && sum->still.bent[nodes[i]]) return PETSC_TRUE;
  return PETSC_FALSE;
}

#define LONG 1e20 /* in which all that is stored flows off */

/* Penalty on the water's pressure: flow and storage, or flow alone. */
static PetscReal Flow(const MpmSum *sum, const MpmPhysicsMaterial *of, const PetscReal parameter[], PetscReal h)
{
  return sum->drained ? sum->layout->ghost(of, parameter, LONG * sum->dt, h) / LONG
                      : sum->layout->ghost(of, parameter, sum->dt, h);
}

/* Factor on a face's matrix, for one of the components. */
static PetscReal Factor(const MpmSum *sum, const MpmFace *face, PetscInt c)
{
  PetscReal factor[2];

  if (c < sum->layout->dim) return face->stiffness;
  if (IsDry(sum, face)) return 0.;
  for (PetscInt k = 0; k < 2; k++) {
    const MpmMaterial       *material = &sum->materials[face->material[k]];
    const MpmPhysicsMaterial of       = MpmMaterialForPhysics(material, NULL, sum->layout->dim);

    factor[k] = Flow(sum, &of, material->physics_parameter, sum->grid->h[face->axis]);
  }
  /* where permeability jumps so does the gradient: the lesser one */
  return face->gamma * (PetscAbsReal(factor[0]) < PetscAbsReal(factor[1]) ? factor[0] : factor[1]);
}

/* Linear: the residual of u is the action on it. */
static PetscErrorCode AddForces(const MpmSum *sum, const PetscReal u[], PetscReal residual[])
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->block, dim = space->dim, components = Components(sum);
  PetscReal       value[2][FACE_NODES];

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < space->faces.count; f++) {
    const MpmFace  *face = &space->faces.face[f];
    const MpmGroup *box  = &space->groups[space->faces.begin + f];
    const PetscInt  n = box->node_count, *nodes = &space->group_nodes[box->node_offset];

    for (PetscInt c = 0; c < components; c++) {
      const PetscReal factor = Factor(sum, face, c);
      PetscInt        before = 1, now = 0;

      for (PetscInt i = 0; i < n; i++) value[0][i] = u[nodes[i] * bs + c];
      for (PetscInt a = 0; a < dim; before *= box->count[a], a++, now = !now)
        AxisApply(before, box->count[a], n / (before * box->count[a]), face->along[a], value[now], value[!now]);
      for (PetscInt i = 0; i < n; i++) residual[nodes[i] * bs + c] += factor * value[now][i];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->block, dim = space->dim, components = Components(sum);

  PetscFunctionBeginUser;
  (void)ctx;
  (void)u;
  (void)failed;
  for (PetscInt f = 0; f < space->faces.count; f++) {
    const MpmFace  *face  = &space->faces.face[f];
    const MpmGroup *box   = &space->groups[space->faces.begin + f];
    const PetscInt *nodes = &space->group_nodes[box->node_offset];
    const PetscReal other = components > dim ? Factor(sum, face, dim) / face->stiffness : 0.;

    for (PetscInt i = 0; i < box->node_count; i++) {
      PetscReal value = face->stiffness;
      PetscInt  k     = i;

      for (PetscInt a = 0; a < dim; k /= box->count[a], a++)
        value *= face->along[a][(k % box->count[a]) * (box->count[a] + 1)];
      for (PetscInt c = 0; c < components; c++) blocks[(nodes[i] * bs + c) * bs + c] += c < dim ? value : other * value;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The face's matrix, the same for every component of the displacement; returns its number of nodes. */
static PetscInt FaceMatrix(const MpmSpace *space, PetscInt f, PetscReal matrix[])
{
  const MpmFace  *face  = &space->faces.face[f];
  const PetscInt *count = space->groups[space->faces.begin + f].count,
                 n      = space->groups[space->faces.begin + f].node_count;

  for (PetscInt p = 0; p < n / count[0]; p++) { /* lines of nodes along the first axis */
    for (PetscInt q = 0; q < n / count[0]; q++) {
      PetscReal value = face->stiffness * face->along[1][(p % count[1]) * count[1] + q % count[1]];

      if (space->dim == 3) value *= face->along[2][(p / count[1]) * count[2] + q / count[1]];
      for (PetscInt i = 0; i < count[0]; i++)
        for (PetscInt j = 0; j < count[0]; j++)
          matrix[(p * count[0] + i) * n + q * count[0] + j] = value * face->along[0][i * count[0] + j];
    }
  }
  return n;
}

static PetscErrorCode AddElements(const MpmSum *sum, MpmPattern *pattern)
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->block, dim = space->dim, components = Components(sum);
  PetscReal      *matrix, *element;

  PetscFunctionBeginUser;
  if (!space->faces.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((FACE_NODES * FACE_NODES), &matrix));
  PetscCall(PetscMalloc1((FACE_NODES * FACE_NODES * bs * bs), &element));
  for (PetscInt f = 0; f < space->faces.count; f++) {
    const PetscInt  n = FaceMatrix(space, f, matrix);
    const PetscReal other =
      components > dim ? Factor(sum, &space->faces.face[f], dim) / space->faces.face[f].stiffness : 0.;

    PetscCall(PetscArrayzero(element, n * n * bs * bs));
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt c = 0; c < dim; c++)
        for (PetscInt j = 0; j < n; j++) element[((i * bs + c) * bs + c) * n + j] = matrix[i * n + j];
    for (PetscInt k = 0; k < n * n && components > dim; k++)
      element[((k / n * bs + dim) * bs + dim) * n + k % n] = other * matrix[k];
    MpmPatternAddBlock(pattern, space, &space->groups[space->faces.begin + f], element);
  }
  PetscCall(PetscFree(matrix));
  PetscCall(PetscFree(element));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)ctx;
  (void)failed;
  PetscCall(AddForces(sum, u, residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  PetscFunctionBeginUser;
  (void)ctx;
  (void)u;
  PetscCall(AddForces(sum, du, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)ctx;
  (void)failed;
  PetscCall(AddElements(sum, pattern));
  if (residual) PetscCall(AddForces(sum, u, residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermGhost = {.name      = "ghost penalty",
                              .boxes     = Boxes,
                              .residual  = Residual,
                              .tangent   = Tangent,
                              .apply     = Apply,
                              .diagonal  = Diagonal,
                              .quadratic = MpmTermIsQuadratic};
