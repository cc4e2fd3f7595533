/*
  The pieces between a spline's knots, and how far the material fills them.

  The fill of piece c is sum_p V_p s_pc / V_c over the points, with s_pc the part of the domain of p that lies in c;
  for shapes without domains that is a cube of the point's volume. V_p is the volume at the step's start. Sums are
  kept as integers: the same points give the same fill on any number of ranks.
*/
#include "grid/grid.h"
#include "particles/points.h"
#include "extension/pieces.h"
#include "space/rules.h"
#include "space/space.h"

#define MARGIN_OF_RANKS 2 /* nodes around a piece by which owners are looked up beyond the margin */

/* Edges about a place, in the lattice of a part. */
static void EdgesAt(const MpmSpace *space, const MpmRules *rules, PetscInt part, const PetscReal x[], PetscInt lower[],
                    PetscInt upper[])
{
  const PetscInt last = space->dim - 1, shift = space->parts.spans * part;

  MpmSpaceEdges(rules, x, lower, upper);
  lower[last] += shift;
  upper[last] += shift;
}

/* The middle of a piece, on the grid. */
static void Middle(const MpmSpace *space, const MpmGrid *grid, MpmKnots knots, const PetscInt piece[], PetscReal x[])
{
  PetscInt at[MPM_MAX_DIM];

  MpmSpaceSpanAt(space, piece, at);
  for (PetscInt a = 0; a < grid->dim; a++)
    x[a] = grid->lower[a] + grid->h[a] * ((PetscReal)at[a] + (MpmKnotsBetween(knots) ? 0. : 0.5));
}

void MpmPieceEdges(const MpmSpace *space, const MpmRules *rules, MpmKnots knots, const PetscInt piece[],
                   PetscInt lower[], PetscInt upper[])
{
  PetscReal x[MPM_MAX_DIM];

  Middle(space, rules->grid, knots, piece, x);
  EdgesAt(space, rules, MpmSpaceSpanPart(space, piece), x, lower, upper);
}

/* As MpmPieceEdges(), but a piece around a node on a wall with two sides is that on the side with more material. */
static void FilledEdges(const MpmSpace *space, const MpmRules *rules, const MpmPieces *pieces, const PetscInt piece[],
                        PetscInt lower[], PetscInt upper[])
{
  const MpmGrid *grid = rules->grid;
  const PetscInt part = MpmSpaceSpanPart(space, piece);
  PetscReal      x[MPM_MAX_DIM];

  Middle(space, grid, pieces->knots, piece, x);
  EdgesAt(space, rules, part, x, lower, upper);
  for (PetscInt a = 0; a < grid->dim; a++) {
    PetscInt above[MPM_MAX_DIM] = {piece[0], piece[1], piece[2]}, below[MPM_MAX_DIM] = {piece[0], piece[1], piece[2]};

    if (upper[a] > lower[a]) continue;
    above[a]++;
    below[a]--;
    x[a] += MpmPiecesFill(pieces, above) >= MpmPiecesFill(pieces, below) ? 0.25 * grid->h[a] : -0.25 * grid->h[a];
    EdgesAt(space, rules, part, x, lower, upper);
  }
}

/* The nodes of a piece between edges; PETSC_FALSE where there is no room for it. */
static PetscBool LinesBetween(const MpmSpace *space, const MpmRules *rules, MpmKnots knots, const PetscInt piece[],
                              const PetscInt lower[], const PetscInt upper[], MpmPieceLine lines[])
{
  const PetscInt degree = knots.degree;

  for (PetscInt a = 0; a < space->dim; a++) {
    MpmPieceLine  *line  = &lines[a];
    const PetscInt first = MpmPieceFirstNode(knots, piece[a]), last = first + degree;

    *line = (MpmPieceLine){.first = first, .lower = lower[a] * knots.order, .upper = upper[a] * knots.order};
    if (knots.order > 1) {
      line->low  = first;
      line->high = last;
      if (piece[a] < lower[a] || piece[a] >= upper[a]) return PETSC_FALSE;
      continue;
    }
    line->edge           = MpmEdgeOf(rules->edge, degree, upper[a] - lower[a]);
    const PetscBool open = (PetscBool)(line->edge == MPM_EDGE_OPEN);

    line->low  = PetscMax(line->first, lower[a]);
    line->high = PetscMin(last, upper[a]);
    if (lower[a] - line->first >= (open ? 0 : 1)) line->high = PetscMax(line->high, lower[a] + (open ? degree : 1));
    if (last - upper[a] >= (open ? 0 : 1)) line->low = PetscMin(line->low, upper[a] - (open ? degree : 1));
    if (line->high < line->low || line->high > upper[a] || line->low < lower[a]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

PetscBool MpmPieceLines(const MpmSpace *space, const MpmRules *rules, const MpmPieces *pieces, const PetscInt piece[],
                        MpmPieceLine lines[])
{
  PetscInt lower[MPM_MAX_DIM] = {0}, upper[MPM_MAX_DIM] = {0};

  FilledEdges(space, rules, pieces, piece, lower, upper);
  return LinesBetween(space, rules, pieces->knots, piece, lower, upper, lines);
}

/* Pieces that a point's domain touches along an axis, and their shares of it. */
typedef struct {
  PetscInt  first, count;
  PetscReal share[MPM_MAX_WIDTH + 1];
} Overlap;

static void FindOverlap(MpmKnots knots, PetscReal xi, PetscReal half, Overlap *overlap)
{
  const PetscReal shift = MpmKnotsBetween(knots) ? 0.5 : 0., low = xi - half + shift, high = xi + half + shift;
  const PetscReal length = high - low;
  PetscInt        last;

  if (!(length > MPM_SHAPE_TOUCH)) {
    *overlap = (Overlap){.first = (PetscInt)PetscFloorReal(xi + shift), .count = 1, .share = {1.}};
    return;
  }
  overlap->first = (PetscInt)PetscFloorReal(low + MPM_SHAPE_TOUCH * length);
  last           = (PetscInt)PetscCeilReal(high - MPM_SHAPE_TOUCH * length) - 1;
  overlap->count = PetscMin(PetscMax(last - overlap->first + 1, 1), MPM_MAX_WIDTH + 1);
  for (PetscInt k = 0; k < overlap->count; k++) {
    const PetscReal begin = (PetscReal)(overlap->first + k);

    overlap->share[k] = PetscMax(PetscMin(high, begin + 1.) - PetscMax(low, begin), 0.) / length;
  }
}

/* A point without a domain touches fewer nodes than the span has where it stands on a knot; edge spans have fewer. */
static PetscBool TouchesAll(const MpmSpace *space, const MpmRules *rules, const MpmPieces *pieces,
                            const MpmPoints *points, PetscInt p, const PetscInt piece[])
{
  const PetscInt *first = &space->touched.first[p * space->dim], *count = &space->touched.count[p * space->dim];
  const PetscInt  part  = MpmSpaceSpanPart(space, piece);
  PetscInt        shift = space->parts.stride * part, least = count[0], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  MpmPieceLine    lines[MPM_MAX_DIM];

  for (PetscInt a = 1; a < space->dim; a++) least = PetscMin(least, count[a]);
  if (least > pieces->knots.degree) return PETSC_TRUE;
  EdgesAt(space, rules, part, &points->x[p * space->dim], lower, upper);
  if (!LinesBetween(space, rules, pieces->knots, piece, lower, upper, lines)) return PETSC_FALSE;
  for (PetscInt a = 0; a < space->dim; a++) {
    const PetscInt from = first[a] + (a == space->dim - 1 ? shift : 0);

    if (lines[a].low < from || lines[a].high >= from + count[a]) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Adds to a piece's fill, in units, and notes how a point touches it. */
static void Add(const MpmPieces *pieces, const PetscInt piece[], PetscInt units, char touch)
{
  const PetscInt i = MpmPiecesIndex(pieces, piece);

  if (i < 0) return;
  pieces->fill[i]  = (PetscInt)PetscMin((PetscInt64)pieces->fill[i] + units, PETSC_INT_MAX);
  pieces->touch[i] = PetscMax(pieces->touch[i], touch);
}

/* Adds one point's domain. */
static void AddPoint(const MpmSpace *space, const MpmRules *rules, const MpmPoints *points, PetscInt p,
                     const MpmPieces *pieces)
{
  const MpmGrid  *grid = rules->grid;
  const PetscInt  dim = space->dim, shift = space->parts.stride ? space->parts.spans * points->domain.part[p] : 0;
  const PetscReal volume = MpmPointExtent(points, dim, p);
  const PetscReal cube   = space->shapes.half ? 0. : 0.5 * PetscPowReal(PetscMax(volume, 0.), 1. / (PetscReal)dim);
  PetscInt        first[MPM_MAX_DIM] = {0, 0, 0}, count[MPM_MAX_DIM] = {1, 1, 1}, piece[MPM_MAX_DIM] = {0, 0, 0};
  Overlap         overlap[MPM_MAX_DIM];
  PetscReal       units = (PetscReal)MPM_PIECE_FULL * volume;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal xi = (points->x[p * dim + a] - grid->lower[a]) / grid->h[a];

    FindOverlap(pieces->knots, xi, space->shapes.half ? space->shapes.half[p * dim + a] : cube / grid->h[a],
                &overlap[a]);
    piece[a] = (PetscInt)PetscFloorReal(xi + (MpmKnotsBetween(pieces->knots) ? 0.5 : 0.));
    first[a] = overlap[a].first;
    count[a] = overlap[a].count;
    units /= grid->h[a];
  }
  piece[dim - 1] += shift;
  if (!space->shapes.half) Add(pieces, piece, 0, TouchesAll(space, rules, pieces, points, p, piece) ? 2 : 1);
  MPM_FOR_BOX(first, count, piece)
  {
    PetscInt  at[MPM_MAX_DIM] = {piece[0], piece[1], piece[2]};
    PetscReal part            = units;

    for (PetscInt a = 0; a < dim; a++) part *= overlap[a].share[piece[a] - first[a]];
    at[dim - 1] += shift;
    Add(pieces, at, (PetscInt)PetscMin(PetscMax(part, 0.), (PetscReal)PETSC_INT_MAX), space->shapes.half ? 2 : 0);
  }
}

/* Pieces that are touched have at least one unit, others none. */
static void Settle(const MpmPieces *pieces)
{
  const PetscInt size = pieces->size[0] * pieces->size[1] * pieces->size[2];

  for (PetscInt i = 0; i < size; i++) {
    if (pieces->touch[i] < 2) pieces->fill[i] = pieces->touch[i];
    else pieces->fill[i] = PetscMax(pieces->fill[i], 1);
  }
}

/* The box of this rank's nodes and of places within a margin. */
static void FindBounds(const MpmSpace *space, PetscInt margin, MpmPieces *pieces)
{
  PetscInt upper[MPM_MAX_DIM] = {0, 0, 0};

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) pieces->lower[a] = a < space->dim ? PETSC_INT_MAX : 0;
  for (PetscInt g = 0; g < space->boxes.count; g++) {
    for (PetscInt a = 0; a < space->dim; a++) {
      const PetscInt first = space->groups[g].first[a], last = first + space->groups[g].count[a] - 1;

      pieces->lower[a] = PetscMin(pieces->lower[a], MpmPieceOfNode(pieces->knots, first) - margin);
      upper[a]         = PetscMax(upper[a], MpmPieceOfNode(pieces->knots, last) + 1 + margin);
    }
  }
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
    pieces->size[a] = a >= space->dim ? 1 : space->boxes.count ? upper[a] - pieces->lower[a] : 0;
  if (!space->boxes.count) pieces->lower[0] = pieces->lower[1] = pieces->lower[2] = 0;
}

static PetscErrorCode Allocate(MpmPieces *pieces)
{
  const PetscInt64 size = (PetscInt64)pieces->size[0] * pieces->size[1] * pieces->size[2];

  PetscFunctionBeginUser;
  PetscCheck(size < PETSC_INT_MAX, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "the points of one rank span %" PetscInt64_FMT " cells", size);
  PetscCall(PetscCalloc2(size, &pieces->fill, size, &pieces->touch));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Widens the map to hold the pieces of received lists: a rank may own nodes that none of its own points is near. */
static PetscErrorCode Widen(const MpmLists *received, MpmPieces *pieces)
{
  const PetscInt stride = pieces->dim + 2, end = received->offset[received->count];
  MpmPieces      wide = *pieces;
  PetscInt       upper[MPM_MAX_DIM], piece[MPM_MAX_DIM];
  const PetscInt old = pieces->size[0] * pieces->size[1] * pieces->size[2];

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    if (!old) wide.lower[a] = a < pieces->dim ? PETSC_INT_MAX : 0;
    upper[a] = old ? pieces->lower[a] + pieces->size[a] : a < pieces->dim ? PETSC_INT_MIN : 1;
  }
  for (PetscInt k = 0; k < end; k++) {
    const PetscInt a = k % stride;

    if (a >= pieces->dim) continue;
    upper[a]      = PetscMax(upper[a], received->data[k] + 1);
    wide.lower[a] = PetscMin(wide.lower[a], received->data[k]);
  }
  if (!end) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) wide.size[a] = upper[a] - wide.lower[a];
  PetscCall(Allocate(&wide));
  for (PetscInt i = 0; i < old; i++) {
    if (!pieces->fill[i] && !pieces->touch[i]) continue;
    MpmPiecesAt(pieces, i, piece);
    Add(&wide, piece, pieces->fill[i], pieces->touch[i]);
  }
  PetscCall(PetscFree2(pieces->fill, pieces->touch));
  *pieces = wide;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Ranks that own a node within a distance of a piece. */
typedef struct {
  const MpmSpace *space;
  const MpmGrid  *grid;
  PetscInt        distance;
  PetscMPIInt    *rank; /* room for grid->size */
} Around;

/* Puts them into around->rank and returns their number. */
static PetscInt FindRanks(const Around *around, const PetscInt piece[])
{
  PetscInt at[MPM_MAX_DIM], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  MpmSpaceSpanAt(around->space, piece, at);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = at[a] - around->distance;
    upper[a] = at[a] + around->distance;
  }
  return MpmGridBoxOwners(around->grid, lower, upper, around->rank);
}

/* Lists this rank's spans for other ranks: `fill` counts the integers for each rank where `sent` has no data. */
static void ListPieces(const Around *around, const MpmPieces *pieces, PetscInt fill[], const PetscInt slot[],
                       MpmLists *sent)
{
  const PetscInt size = pieces->size[0] * pieces->size[1] * pieces->size[2], dim = pieces->dim;
  PetscInt       piece[MPM_MAX_DIM];

  for (PetscInt i = 0; i < size; i++) {
    if (!pieces->fill[i] && !pieces->touch[i]) continue;
    MpmPiecesAt(pieces, i, piece);
    const PetscInt ranks = FindRanks(around, piece);

    for (PetscInt r = 0; r < ranks; r++) {
      const PetscMPIInt rank = around->rank[r];

      if (rank == around->grid->rank) continue;
      if (sent->data) {
        PetscInt *to = &sent->data[fill[slot[rank]]];

        for (PetscInt a = 0; a < dim; a++) to[a] = piece[a];
        to[dim]     = pieces->fill[i];
        to[dim + 1] = pieces->touch[i];
        fill[slot[rank]] += dim + 2;
      } else fill[rank] += dim + 2;
    }
  }
}

/* Adds the filling of the spans within a distance of this rank's nodes by other ranks' points. */
static PetscErrorCode Exchange(const MpmSpace *space, const MpmGrid *grid, PetscInt distance, MpmPieces *pieces)
{
  MpmLists  sent = {0}, received = {0};
  Around    around = {.space = space, .grid = grid, .distance = distance};
  PetscInt *length, *slot, *fill;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(grid->size, &around.rank));
  PetscCall(PetscCalloc3(grid->size, &length, grid->size, &slot, grid->size, &fill));
  ListPieces(&around, pieces, length, NULL, &sent);
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
  PetscCall(PetscMalloc1((sent.offset[sent.count] + 1), &sent.data));
  ListPieces(&around, pieces, fill, slot, &sent);
  PetscCall(MpmListsExchange(grid->comm, &sent, &received));
  PetscCall(Widen(&received, pieces));
  for (PetscInt k = 0; k < received.offset[received.count]; k += grid->dim + 2) {
    PetscInt at[MPM_MAX_DIM] = {0, 0, 0};

    for (PetscInt a = 0; a < grid->dim; a++) at[a] = received.data[k + a];
    Add(pieces, at, received.data[k + grid->dim], (char)received.data[k + grid->dim + 1]);
  }
  PetscCall(MpmListsDestroy(&sent));
  PetscCall(MpmListsDestroy(&received));
  PetscCall(PetscFree(around.rank));
  PetscCall(PetscFree3(length, slot, fill));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An edge halves the pieces of its nodes where these lie around nodes. */
static PetscErrorCode DoubleAtEdges(const MpmSpace *space, const MpmRules *rules, const MpmPieces *pieces)
{
  const PetscInt size = pieces->size[0] * pieces->size[1] * pieces->size[2];
  PetscInt       piece[MPM_MAX_DIM], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], *fill;

  PetscFunctionBeginUser;
  if (!MpmKnotsBetween(pieces->knots)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(size, &fill));
  PetscCall(PetscArraycpy(fill, pieces->fill, size));
  for (PetscInt i = 0; i < size; i++) {
    if (!fill[i]) continue;
    MpmPiecesAt(pieces, i, piece);
    FilledEdges(space, rules, pieces, piece, lower, upper);
    for (PetscInt a = 0; a < space->dim; a++)
      if (piece[a] == lower[a] || piece[a] == upper[a])
        fill[i] = (PetscInt)PetscMin(2 * (PetscInt64)fill[i], PETSC_INT_MAX);
  }
  PetscCall(PetscArraycpy(pieces->fill, fill, size));
  PetscCall(PetscFree(fill));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPiecesCreate(const MpmSpace *space, const MpmRules *rules, const MpmPoints *points, PetscInt margin,
                               MpmPieces *pieces)
{
  PetscInt widest = 0;

  PetscFunctionBeginUser;
  *pieces = (MpmPieces){.knots = {MpmShapeDegree(rules->shape), MpmShapeOrder(rules->shape)}, .dim = space->dim};
  FindBounds(space, margin, pieces);
  PetscCall(Allocate(pieces));
  for (PetscInt p = 0; p < space->point_count; p++) AddPoint(space, rules, points, p, pieces);
  if (rules->grid->size > 1) {
    for (PetscInt g = 0; g < space->boxes.count; g++)
      for (PetscInt a = 0; a < space->dim; a++) widest = PetscMax(widest, space->groups[g].count[a]);
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &widest, 1, MPIU_INT, MPI_MAX, rules->grid->comm));
    PetscCall(Exchange(space, rules->grid, widest + margin + MARGIN_OF_RANKS, pieces));
  }
  Settle(pieces);
  PetscCall(DoubleAtEdges(space, rules, pieces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPiecesDestroy(MpmPieces *pieces)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(pieces->fill, pieces->touch));
  PetscFunctionReturn(PETSC_SUCCESS);
}
