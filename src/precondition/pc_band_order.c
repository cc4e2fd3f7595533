/*
  The order for band Cholesky (pc_band.c): fronts that walk through the rank's nodes from those that touch a border, or
  from an end. A node is a block of the matrix.

  The walk is breadth-first, and another one goes back from its last front: the difference of the two distances grows
  evenly along a strip, where one distance alone bends with the grid's axes. Stencils reach over several layers of
  nodes, so that a front is as thick as that. Among equals the nodes are ordered by the number of their neighbours
  behind and ahead, as finer layers would. The reverse is the order.
*/
#include "precondition/pc_band.h"

/* Wider than this, a multifrontal solver is faster. */
#define WIDTH_MOST  400
#define BORDER_MOST 512

/* The nodes of a rank, and the walk through them. */
typedef struct {
  PetscInt        nodes, bs;
  const PetscInt *row[2], *column[2]; /* of the two parts, by unknowns */
  PetscInt       *front;              /* of each node, or UNSEEN, BORDER */
  PetscInt       *back;               /* distance from the other end; or UNSEEN */
  PetscInt       *walk, seen;         /* nodes in the order of the walk, and how many so far */
} Walk;

enum { BORDER = -2, UNSEEN = -1 };

PetscErrorCode MpmBandParts(Mat A, Mat part[2], const PetscInt *columns[])
{
  PetscBool sequential, parallel;

  PetscFunctionBeginUser;
  part[0] = part[1] = NULL;
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATSEQAIJ, &sequential));
  PetscCall(PetscObjectTypeCompare((PetscObject)A, MATMPIAIJ, &parallel));
  if (sequential) part[0] = A;
  if (parallel) PetscCall(MatMPIAIJGetSeqAIJ(A, &part[0], &part[1], columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GetRows(Mat part[2], Walk *walk)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 2; k++) {
    PetscInt  n;
    PetscBool done = PETSC_TRUE;

    walk->row[k] = walk->column[k] = NULL;
    if (part[k])
      PetscCall(MatGetRowIJ(part[k], 0, PETSC_FALSE, PETSC_FALSE, &n, &walk->row[k], &walk->column[k], &done));
    PetscCheck(done, PETSC_COMM_SELF, PETSC_ERR_PLIB, "no rows of an AIJ matrix");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RestoreRows(Mat part[2], Walk *walk)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 2; k++) {
    PetscInt  n;
    PetscBool done;

    if (part[k])
      PetscCall(MatRestoreRowIJ(part[k], 0, PETSC_FALSE, PETSC_FALSE, &n, &walk->row[k], &walk->column[k], &done));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- borders ---- */

/* Nodes with a neighbour on a higher rank; and the global numbers of all ranks' border unknowns, which ascend. */
static PetscErrorCode FindBorders(Mat A, const PetscInt columns[], Walk *walk, PetscInt *count, PetscInt **border)
{
  const MPI_Comm comm = PetscObjectComm((PetscObject)A);
  PetscInt       begin, end, own = 0, *mine;
  PetscMPIInt    size, many, *counts, *offsets;

  PetscFunctionBeginUser;
  PetscCall(MatGetOwnershipRange(A, &begin, &end));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  PetscCall(PetscMalloc3((end - begin), &mine, size, &counts, (size + 1), &offsets));
  for (PetscInt i = 0; i < walk->nodes; i++) {
    walk->front[i] = UNSEEN;
    for (PetscInt e = walk->row[1] ? walk->row[1][i * walk->bs] : 0;
         walk->row[1] && e < walk->row[1][(i + 1) * walk->bs]; e++)
      if (columns[walk->column[1][e]] >= end) walk->front[i] = BORDER;
    for (PetscInt c = 0; c < walk->bs && walk->front[i] == BORDER; c++) mine[own++] = begin + i * walk->bs + c;
  }
  PetscCall(PetscMPIIntCast(own, &many));
  PetscCallMPI(MPI_Allgather(&many, 1, MPI_INT, counts, 1, MPI_INT, comm));
  offsets[0] = 0;
  for (PetscMPIInt r = 0; r < size; r++) offsets[r + 1] = offsets[r] + counts[r];
  *count = offsets[size];
  PetscCall(PetscMalloc1(*count, border));
  PetscCallMPI(MPI_Allgatherv(mine, many, MPIU_INT, *border, counts, offsets, MPIU_INT, comm));
  PetscCall(PetscFree3(mine, counts, offsets));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the walk ---- */

static void Visit(Walk *walk, PetscInt distance[], PetscInt node, PetscInt front)
{
  distance[node]           = front;
  walk->walk[walk->seen++] = node;
}

/* Goes on until nothing new is reached, from the nodes from `begin` on; `distance` is walk->front or walk->back. */
static void Spread(Walk *walk, PetscInt distance[], PetscInt begin)
{
  for (PetscInt k = begin; k < walk->seen; k++) {
    const PetscInt row = walk->walk[k] * walk->bs;

    for (PetscInt e = walk->row[0][row]; e < walk->row[0][row + 1]; e += walk->bs) {
      const PetscInt next = walk->column[0][e] / walk->bs;

      if (distance[next] == UNSEEN && walk->front[next] != BORDER)
        Visit(walk, distance, next, distance[walk->walk[k]] + 1);
    }
  }
}

/* Starts again at the nodes of the last front, with other distances from there. */
static void Return(Walk *walk, PetscInt distance[], PetscInt begin)
{
  const PetscInt last = walk->front[walk->walk[walk->seen - 1]];
  PetscInt       ends = 0;

  for (PetscInt k = begin; k < walk->seen; k++) {
    const PetscInt node = walk->walk[k];

    if (walk->front[node] == last) walk->walk[begin + ends++] = node;
    if (distance == walk->front) distance[node] = UNSEEN;
  }
  walk->seen = begin + ends;
  for (PetscInt k = begin; k < walk->seen; k++) distance[walk->walk[k]] = 0;
  Spread(walk, distance, begin);
}

/* +1 for each neighbour that is further away, -1 for each nearer one. */
static PetscInt CountAhead(const Walk *walk, const PetscInt distance[], PetscInt node)
{
  const PetscInt row   = node * walk->bs;
  PetscInt       ahead = 0;

  for (PetscInt e = walk->row[0][row]; e < walk->row[0][row + 1]; e += walk->bs) {
    const PetscInt next = walk->column[0][e] / walk->bs;

    if (walk->front[next] != BORDER)
      ahead += distance[next] > distance[node] ? 1 : distance[next] < distance[node] ? -1 : 0;
  }
  return ahead;
}

/* Puts the nodes visited since `begin` in order, by both distances. */
static PetscErrorCode Sort(Walk *walk, PetscInt begin)
{
  const PetscInt count = walk->seen - begin;
  PetscInt      *key, *part, most = 1;

  PetscFunctionBeginUser;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(count, &key, count, &part));
  PetscCall(PetscArraycpy(part, &walk->walk[begin], count));
  Return(walk, walk->back, begin);
  PetscCall(PetscArraycpy(&walk->walk[begin], part, count)); /* the way back may not reach all */
  walk->seen = begin + count;
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt row = walk->walk[begin + k] * walk->bs;

    most = PetscMax(most, walk->row[0][row + 1] - walk->row[0][row]);
  }
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt node = walk->walk[begin + k], back = walk->back[node];

    key[k] = (walk->front[node] - (back == UNSEEN ? -walk->front[node] : back)) * (4 * most) +
             CountAhead(walk, walk->front, node) - CountAhead(walk, walk->back, node);
  }
  PetscCall(PetscSortIntWithArray(count, key, &walk->walk[begin]));
  PetscCall(PetscFree2(key, part));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a node touches a border, its own rank's or another's. */
static PetscBool TouchesBorder(const Walk *walk, PetscInt node)
{
  const PetscInt row = node * walk->bs;

  if (walk->row[1] && walk->row[1][row + 1] > walk->row[1][row]) return PETSC_TRUE;
  for (PetscInt e = walk->row[0][row]; e < walk->row[0][row + 1]; e += walk->bs)
    if (walk->front[walk->column[0][e] / walk->bs] == BORDER) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Walks through all nodes: from the border on, then through unconnected ones, each component from its end. */
static PetscErrorCode WalkAll(Walk *walk)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < walk->nodes; i++) walk->back[i] = UNSEEN;
  for (PetscInt i = 0; i < walk->nodes; i++)
    if (walk->front[i] == UNSEEN && TouchesBorder(walk, i)) Visit(walk, walk->front, i, 0);
  Spread(walk, walk->front, 0);
  PetscCall(Sort(walk, 0));
  for (PetscInt i = 0; i < walk->nodes; i++) {
    const PetscInt begin = walk->seen;

    if (walk->front[i] != UNSEEN) continue;
    Visit(walk, walk->front, i, 0);
    Spread(walk, walk->front, begin);
    Return(walk, walk->front, begin);
    PetscCall(Sort(walk, begin));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- places ---- */

/* Places of the owned unknowns. */
static PetscErrorCode FindPlaces(Mat A, const Walk *walk, const PetscInt border[], MpmBandOrder *order)
{
  PetscInt begin;

  PetscFunctionBeginUser;
  PetscCall(MatGetOwnershipRange(A, &begin, NULL));
  order->n = walk->seen * walk->bs;
  PetscCall(PetscMalloc1(order->owned, &order->place));
  for (PetscInt k = 0; k < walk->seen; k++)
    for (PetscInt c = 0; c < walk->bs; c++)
      order->place[walk->walk[k] * walk->bs + c] = (walk->seen - 1 - k) * walk->bs + c;
  for (PetscInt i = 0; i < order->owned; i++) {
    PetscInt at;

    if (walk->front[i / walk->bs] != BORDER) continue;
    PetscCall(PetscFindInt(begin + i, order->count, border, &at));
    order->place[i] = order->n + at;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The places of the other ranks' columns: in the border, or -1. */
static PetscErrorCode PlaceColumns(Mat other, const PetscInt columns[], const PetscInt border[],
                                   const MpmBandOrder *order, PetscInt **place)
{
  PetscInt n = 0;

  PetscFunctionBeginUser;
  if (other) PetscCall(MatGetSize(other, NULL, &n));
  PetscCall(PetscMalloc1(n, place));
  for (PetscInt k = 0; k < n; k++) {
    PetscInt at;

    PetscCall(PetscFindInt(columns[k], order->count, border, &at));
    (*place)[k] = at < 0 ? -1 : order->n + at;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Width of the band, and start of the border's rows; checks that both are narrow enough. */
static PetscErrorCode Measure(Mat A, const Walk *walk, const PetscInt *const place[2], MpmBandOrder *order)
{
  PetscInt wide = 0;

  PetscFunctionBeginUser;
  order->first = order->n;
  for (PetscInt i = 0; i < order->owned; i++) {
    const PetscInt row = order->place[i];

    for (PetscInt k = 0; k < 2 && row < order->n && walk->row[k]; k++) {
      for (PetscInt e = walk->row[k][i]; e < walk->row[k][i + 1]; e++) {
        const PetscInt column = place[k][walk->column[k][e]];

        if (column < 0) wide = PETSC_INT_MAX; /* a pattern without symmetry */
        else if (column < order->n) order->width = PetscMax(order->width, row - column);
        else order->first = PetscMin(order->first, row);
      }
    }
  }
  wide = PetscMax(wide, order->width);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &wide, 1, MPIU_INT, MPI_MAX, PetscObjectComm((PetscObject)A)));
  order->fits = (PetscBool)(wide <= WIDTH_MOST);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where an entry goes, in places. */
static PetscInt Target(const MpmBandOrder *order, PetscInt row, PetscInt column)
{
  const PetscInt n = order->n, rows = n - order->first;

  if (row < n && column < n) return row < column ? -1 : column * (order->width + 1) + row - column;
  if (row < n) return order->border + (column - n) * rows + row - order->first;
  if (column < n || row < column) return -1;
  return order->corner + (column - n) * order->count + row - n;
}

static PetscErrorCode MapEntries(const Walk *walk, const PetscInt *const place[2], MpmBandOrder *order)
{
  PetscFunctionBeginUser;
  order->border = order->n * (order->width + 1);
  order->corner = order->border + (order->n - order->first) * order->count;
  order->size   = order->corner + order->count * order->count;
  for (PetscInt k = 0; k < 2; k++) {
    order->entries[k] = walk->row[k] ? walk->row[k][order->owned] : 0;
    PetscCall(PetscMalloc1(order->entries[k], &order->to[k]));
    for (PetscInt i = 0; i < order->owned && walk->row[k]; i++) {
      for (PetscInt e = walk->row[k][i]; e < walk->row[k][i + 1]; e++) {
        const PetscInt column = place[k][walk->column[k][e]];

        order->to[k][e] = column < 0 ? -1 : Target(order, order->place[i], column);
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where the band can be narrow enough; the longest row excludes it before any walk. */
static PetscErrorCode MayFit(Mat A, const Walk *walk, PetscInt count, PetscBool *may)
{
  PetscInt longest = 0;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < walk->nodes && walk->row[0]; i++)
    longest = PetscMax(longest, walk->row[0][i * walk->bs + 1] - walk->row[0][i * walk->bs]);
  if (!walk->row[0]) longest = PETSC_INT_MAX;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &longest, 1, MPIU_INT, MPI_MAX, PetscObjectComm((PetscObject)A)));
  *may = (PetscBool)(longest / 2 <= WIDTH_MOST && count <= BORDER_MOST);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBandOrderCreate(Mat A, MpmBandOrder *order)
{
  Mat             part[2];
  const PetscInt *columns = NULL, *place[2];
  PetscInt       *border  = NULL, *others;
  PetscBool       may     = PETSC_FALSE;
  Walk            walk    = {.seen = 0};

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(order, sizeof(*order)));
  PetscCall(MpmBandParts(A, part, &columns));
  PetscCall(GetRows(part, &walk));
  PetscCall(MatGetBlockSize(A, &walk.bs));
  PetscCall(MatGetLocalSize(A, &order->owned, NULL));
  walk.nodes = order->owned / walk.bs;
  PetscCall(PetscMalloc3(walk.nodes, &walk.front, walk.nodes, &walk.back, walk.nodes, &walk.walk));
  PetscCall(FindBorders(A, columns, &walk, &order->count, &border));
  PetscCall(MayFit(A, &walk, order->count, &may));
  if (may) {
    PetscCall(WalkAll(&walk));
    PetscCall(FindPlaces(A, &walk, border, order));
    PetscCall(PlaceColumns(part[1], columns, border, order, &others));
    place[0] = order->place;
    place[1] = others;
    PetscCall(Measure(A, &walk, place, order));
    if (order->fits) PetscCall(MapEntries(&walk, place, order));
    PetscCall(PetscFree(others));
  }
  PetscCall(RestoreRows(part, &walk));
  PetscCall(PetscFree(border));
  PetscCall(PetscFree3(walk.front, walk.back, walk.walk));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBandOrderDestroy(MpmBandOrder *order)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(order->place));
  for (PetscInt k = 0; k < 2; k++) PetscCall(PetscFree(order->to[k]));
  PetscCall(PetscMemzero(order, sizeof(*order)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
