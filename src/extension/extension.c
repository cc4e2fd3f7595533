/*
  Aggregation of small-cut nodes.

  A node that only slivers of the material touch makes the matrix arbitrarily ill-conditioned, and lets its sliver
  strain as nothing holds it. The pieces between the spline's knots (pieces.h) are well filled where they hold at
  least a share f of the fullest piece beside them, or of a whole one if that is less. A node of no well filled piece
  follows: its coefficient is extended from the nearest well filled piece that material connects it with, the mean
  where several are as near,

    u_s = sum_k e_sk u_k ,    e_sk = prod_a L_k(s_a) ,

  with L the node itself where the piece has it on axis a, else linear through the two nodes of the piece that are
  nearest on that axis; beyond elements of order 2 and more the parabola through vertices and middle. Trial and test
  functions are extended alike: the matrix is E^T K E and the forces E^T r. No energy is added, nothing is remembered
  from step to step, and linear fields are kept. Extension by the spline's own
  degree is no more accurate (docs/stabilization.md), and its weights grow as powers of the distance.

  Sources: Hoellig, Reif and Wipper (2001), doi:10.1137/S0036142900373208 (extended splines); Badia, Verdugo and
  Martin (2018), doi:10.1016/j.cma.2018.03.022 (aggregated elements); Yamaguchi, Moriguchi and Terada (2021),
  doi:10.1002/nme.6673, for the implicit material point method.
*/
#include "grid/grid.h"
#include "extension/extension.h"
#include "extension/pieces.h"
#include "space/rules.h"
#include "space/space.h"

#define SEARCH    4                /* pieces from a node within which a well filled one is looked for */
#define SPAN      (2 * SEARCH + 2) /* pieces a side of that search */
#define SAME_PATH 1e-6             /* of two squared distances, cells */

/* Marks of lattice nodes around this rank's pieces. */
typedef struct {
  PetscInt dim, lower[MPM_MAX_DIM], size[MPM_MAX_DIM];
  char    *mark;
} Marks;
enum { SUPPORTED = 1, LISTED = 2 };

static char *MarkAt(const Marks *marks, const PetscInt node[])
{
  PetscInt i = 0;

  for (PetscInt a = marks->dim - 1; a >= 0; a--) {
    const PetscInt k = node[a] - marks->lower[a];

    if (k < 0 || k >= marks->size[a]) return NULL;
    i = i * marks->size[a] + k;
  }
  return &marks->mark[i];
}

/* All that the search for followers works with. */
typedef struct {
  const MpmRules *rules;
  MpmSpace       *space;
  MpmPieces       pieces;
  char           *well; /* per span: well filled */
  PetscInt       *box;  /* per piece: the appended box of its nodes, or -1 */
  Marks           marks;
} Search;

#define FOR_BLOCK(dim, radius, d) \
  for (d[2] = (dim) > 2 ? -(radius) : 0; d[2] <= ((dim) > 2 ? (radius) : 0); d[2]++) \
    for (d[1] = -(radius); d[1] <= (radius); d[1]++) \
      for (d[0] = -(radius); d[0] <= (radius); d[0]++)

/* A piece is well filled against the fullest around it, itself included. */
static PetscBool IsWellFilled(const Search *search, const PetscInt piece[])
{
  const PetscInt fill = MpmPiecesFill(&search->pieces, piece);
  PetscInt       most = fill, d[MPM_MAX_DIM];
  MpmPieceLine   lines[MPM_MAX_DIM];

  if (fill <= 1 || !MpmPieceLines(search->space, search->rules, &search->pieces, piece, lines)) return PETSC_FALSE;
  FOR_BLOCK(search->space->dim, 1, d)
  {
    const PetscInt beside[MPM_MAX_DIM] = {piece[0] + d[0], piece[1] + d[1], piece[2] + d[2]};

    most = PetscMax(most, MpmPiecesFill(&search->pieces, beside));
  }
  return (PetscBool)((PetscReal)fill >= search->rules->filled * (PetscReal)PetscMin(most, MPM_PIECE_FULL));
}

#define FOR_LINES(dim, lines, node) \
  for (node[2] = (dim) > 2 ? (lines)[2].low : 0; node[2] <= ((dim) > 2 ? (lines)[2].high : 0); node[2]++) \
    for (node[1] = (lines)[1].low; node[1] <= (lines)[1].high; node[1]++) \
      for (node[0] = (lines)[0].low; node[0] <= (lines)[0].high; node[0]++)

/* Marks the nodes of well filled pieces. */
static PetscErrorCode MarkNodes(Search *search, PetscInt count)
{
  const MpmSpace *space = search->space;
  const PetscInt  dim = space->dim, degree = search->pieces.knots.degree, order = search->pieces.knots.order;
  Marks          *marks = &search->marks;
  PetscInt        piece[MPM_MAX_DIM], node[MPM_MAX_DIM];
  MpmPieceLine    lines[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  marks->dim = dim;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    marks->lower[a] = order * search->pieces.lower[a] - (a < dim ? degree + 1 : 0);
    marks->size[a]  = a < dim ? order * search->pieces.size[a] + 2 * degree + 3 : 1;
  }
  PetscCall(PetscCalloc1((marks->size[0] * marks->size[1] * marks->size[2]), &marks->mark));
  for (PetscInt i = 0; i < count; i++) {
    if (!search->well[i]) continue;
    MpmPiecesAt(&search->pieces, i, piece);
    if (!MpmPieceLines(space, search->rules, &search->pieces, piece, lines)) continue;
    FOR_LINES(dim, lines, node)
    {
      char *mark = MarkAt(marks, node);

      if (mark) *mark |= SUPPORTED;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Pieces around a node that material connects with it, by rings: 0 not reached, else the ring + 1. */
typedef struct {
  PetscInt lower[MPM_MAX_DIM];
  char     ring[SPAN * SPAN * SPAN];
} Rings;

static char *RingAt(PetscInt dim, Rings *rings, const PetscInt piece[])
{
  PetscInt i = 0;

  for (PetscInt a = dim - 1; a >= 0; a--) {
    const PetscInt k = piece[a] - rings->lower[a];

    if (k < 0 || k >= SPAN) return NULL;
    i = i * SPAN + k;
  }
  return &rings->ring[i];
}

/* Square of the distance between a node and a piece's middle, cells. */
static PetscReal Distance(PetscInt dim, MpmKnots knots, const PetscInt node[], const PetscInt piece[])
{
  PetscReal sum = 0.;

  for (PetscInt a = 0; a < dim; a++)
    sum += PetscSqr((PetscReal)(piece[a] - MpmPieceOfNode(knots, node[a])) - MpmPiecePlace(knots, node[a]) +
                    (MpmKnotsBetween(knots) ? 0. : 0.5));
  return sum;
}

/* Pieces on either side of a node among which the ring `now` lies. */
static PetscInt Radius(MpmKnots knots, PetscInt now)
{
  return PetscMin(SEARCH + 1, now + (knots.order > 1 ? 1 : (knots.degree + 1) / 2));
}

/* The piece at a distance from that of a node's index. */
static void PieceBeside(MpmKnots knots, const PetscInt node[], const PetscInt d[], PetscInt piece[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) piece[a] = MpmPieceOfNode(knots, node[a]) + d[a];
}

/* Pieces of the ring `now`, from those of the last one; the first ring are the pieces that have the node. */
static PetscInt GrowRing(const Search *search, const PetscInt node[], PetscInt now, Rings *rings)
{
  const MpmKnots knots = search->pieces.knots;
  const PetscInt dim   = search->space->dim;
  PetscInt       d[MPM_MAX_DIM], piece[MPM_MAX_DIM], e[MPM_MAX_DIM], grown = 0;

  FOR_BLOCK(dim, Radius(knots, now), d)
  {
    PetscBool reached = PETSC_FALSE;
    char     *ring;

    PieceBeside(knots, node, d, piece);
    ring = RingAt(dim, rings, piece);
    if (!ring || *ring || !MpmPiecesFill(&search->pieces, piece)) continue;
    if (!now) {
      reached = PETSC_TRUE;
      for (PetscInt a = 0; a < dim; a++) {
        const PetscInt from = node[a] - MpmPieceFirstNode(knots, piece[a]);

        if (from < 0 || from > knots.degree) reached = PETSC_FALSE;
      }
    } else {
      FOR_BLOCK(dim, 1, e)
      {
        const PetscInt beside[MPM_MAX_DIM] = {piece[0] + e[0], piece[1] + e[1], piece[2] + e[2]};
        const char    *other               = RingAt(dim, rings, beside);

        if (other && *other == now) reached = PETSC_TRUE;
      }
    }
    if (!reached) continue;
    *ring = (char)(now + 1);
    grown++;
  }
  return grown;
}

/* The nearest well filled pieces of the first ring that has any: their number. */
static PetscInt FindNearest(const Search *search, const PetscInt node[], PetscInt found[], PetscInt most)
{
  const MpmKnots knots = search->pieces.knots;
  const PetscInt dim   = search->space->dim;
  Rings          rings;
  PetscInt       count   = 0, d[MPM_MAX_DIM], piece[MPM_MAX_DIM];
  PetscReal      nearest = PETSC_INFINITY;

  (void)memset(&rings, 0, sizeof(rings));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) rings.lower[a] = a < dim ? MpmPieceOfNode(knots, node[a]) - SEARCH - 1 : 0;
  for (PetscInt now = 0; now <= SEARCH && !count; now++) {
    if (!GrowRing(search, node, now, &rings)) return 0;
    FOR_BLOCK(dim, Radius(knots, now), d)
    {
      const char *ring;
      PetscInt    index;

      PieceBeside(knots, node, d, piece);
      ring  = RingAt(dim, &rings, piece);
      index = MpmPiecesIndex(&search->pieces, piece);

      if (!ring || *ring != now + 1 || !search->well[index]) continue;
      const PetscReal away = Distance(dim, knots, node, piece);

      if (away > nearest + SAME_PATH) continue;
      if (away < nearest - SAME_PATH) count = 0;
      nearest = PetscMin(nearest, away);
      if (count < most) found[count++] = index;
    }
  }
  return count;
}

/* Results before the nodes have numbers. */
typedef struct {
  PetscInt count, capacity;      /* followers */
  PetscInt (*node)[MPM_MAX_DIM]; /* their lattice indices */
  PetscInt  *offset;             /* count + 1, into the next three */
  PetscInt   entries, entry_capacity;
  PetscInt  *piece, *place; /* a master by the map's index of its piece, and its place among the piece's nodes */
  PetscReal *weight;
} Found;

static PetscErrorCode Reserve(Found *found, PetscInt entries)
{
  PetscFunctionBeginUser;
  if (found->count + 1 >= found->capacity) {
    found->capacity = 2 * found->capacity + 64;
    PetscCall(PetscRealloc((size_t)found->capacity * sizeof(*found->node), &found->node));
    PetscCall(PetscRealloc((size_t)found->capacity * sizeof(*found->offset), &found->offset));
  }
  if (found->entries + entries > found->entry_capacity) {
    found->entry_capacity = 2 * found->entry_capacity + entries + 256;
    PetscCall(PetscRealloc((size_t)found->entry_capacity * sizeof(*found->piece), &found->piece));
    PetscCall(PetscRealloc((size_t)found->entry_capacity * sizeof(*found->place), &found->place));
    PetscCall(PetscRealloc((size_t)found->entry_capacity * sizeof(*found->weight), &found->weight));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends a follower's masters in one piece, whose extension counts by a share. */
static PetscErrorCode AppendPiece(const Search *search, const PetscInt node[], PetscInt index, PetscReal share,
                                  Found *found)
{
  const PetscInt dim = search->space->dim;
  PetscInt       piece[MPM_MAX_DIM], at[MPM_MAX_DIM], place = 0;
  MpmPieceLine   lines[MPM_MAX_DIM];
  PetscReal      weight[MPM_MAX_DIM][MPM_PIECE_NODES];

  PetscFunctionBeginUser;
  MpmPiecesAt(&search->pieces, index, piece);
  (void)MpmPieceLines(search->space, search->rules, &search->pieces, piece, lines);
  for (PetscInt a = 0; a < dim; a++) MpmPieceWeights(&lines[a], search->pieces.knots, node[a], weight[a]);
  PetscCall(Reserve(found, MPM_PIECE_NODES * MPM_PIECE_NODES * MPM_PIECE_NODES));
  FOR_LINES(dim, lines, at)
  {
    PetscReal value = share;

    for (PetscInt a = 0; a < dim; a++) value *= weight[a][at[a] - lines[a].low];
    if (value != 0.) {
      found->piece[found->entries]    = index;
      found->place[found->entries]    = place;
      found->weight[found->entries++] = value;
    }
    place++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define NEAREST_MOST 8 /* pieces that are as near: those around a node */

/* A node that is not supported; one that no well filled piece is near keeps its unknowns. */
static PetscErrorCode AppendFollower(const Search *search, const PetscInt node[], Found *found)
{
  PetscInt nearest[NEAREST_MOST], count;

  PetscFunctionBeginUser;
  count = FindNearest(search, node, nearest, NEAREST_MOST);
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Reserve(found, 0));
  found->offset[found->count] = found->entries;
  PetscCall(PetscArraycpy(found->node[found->count], node, MPM_MAX_DIM));
  for (PetscInt k = 0; k < count; k++) PetscCall(AppendPiece(search, node, nearest[k], 1. / (PetscReal)count, found));
  found->offset[++found->count] = found->entries;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists a node that is not supported and not listed yet. */
static PetscErrorCode ListNode(const Search *search, const PetscInt node[], Found *found)
{
  char *mark = MarkAt(&search->marks, node);

  PetscFunctionBeginUser;
  if (!mark || *mark) PetscFunctionReturn(PETSC_SUCCESS);
  *mark = LISTED;
  PetscCall(AppendFollower(search, node, found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Where nodes that a piece's points touch may follow: its own ones, none where it is well filled; beside edges those
  around it too, as a point may stand on the other side.
*/
static PetscBool FindCandidates(const Search *search, PetscInt index, PetscInt piece[], PetscInt low[], PetscInt high[])
{
  const MpmKnots knots = search->pieces.knots;
  const PetscInt dim   = search->space->dim;
  MpmPieceLine   lines[MPM_MAX_DIM];
  PetscBool      whole;

  MpmPiecesAt(&search->pieces, index, piece);
  whole = MpmPieceLines(search->space, search->rules, &search->pieces, piece, lines);
  for (PetscInt a = 0; a < dim; a++)
    whole = (PetscBool)(whole && lines[a].low == lines[a].first && lines[a].high == lines[a].first + knots.degree);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    low[a]  = a >= dim ? 0 : whole ? lines[a].low : knots.order * piece[a] - knots.degree - 1;
    high[a] = a >= dim ? 0 : whole ? lines[a].high : knots.order * piece[a] + knots.degree + 1;
  }
  return (PetscBool) !(whole && search->well[index]);
}

static PetscBool Owns(const Search *search, const PetscInt node[])
{
  const MpmGrid *grid = search->rules->grid;
  PetscInt       at[MPM_MAX_DIM];

  MpmSpaceAt(search->space, node, at);
  for (PetscInt a = 0; a < grid->dim; a++)
    if (at[a] < 0 || at[a] >= grid->nodes[a]) return PETSC_FALSE;
  return (PetscBool)(MpmGridNodeOwner(grid, at) == grid->rank);
}

/* The followers among the nodes of this rank's boxes, and those that it owns and other ranks' points touch. */
static PetscErrorCode FindFollowers(Search *search, PetscInt count, Found *found)
{
  const MpmSpace *space = search->space;
  const MpmGrid  *grid  = search->rules->grid;
  PetscInt        piece[MPM_MAX_DIM], node[MPM_MAX_DIM], low[MPM_MAX_DIM], high[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < space->boxes.count; g++) {
    const MpmGroup *box = &space->groups[g];

    for (PetscInt k = 0; k < box->node_count && !box->holes; k++) {
      node[0] = box->first[0] + k % box->count[0];
      node[1] = box->first[1] + k / box->count[0] % box->count[1];
      node[2] = box->first[2] + k / (box->count[0] * box->count[1]);
      PetscCall(ListNode(search, node, found));
    }
  }
  for (PetscInt i = 0; grid->size > 1 && i < count; i++) {
    if (!search->pieces.fill[i] || !FindCandidates(search, i, piece, low, high)) continue;
    for (node[2] = low[2]; node[2] <= high[2]; node[2]++)
      for (node[1] = low[1]; node[1] <= high[1]; node[1]++)
        for (node[0] = low[0]; node[0] <= high[0]; node[0]++)
          if (Owns(search, node)) PetscCall(ListNode(search, node, found));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends the boxes of the masters' pieces, and one for each follower. */
static PetscErrorCode AppendBoxes(Search *search, const Found *found)
{
  MpmSpace      *space = search->space;
  MpmGroup      *boxes;
  const PetscInt dim = space->dim, begin = space->boxes.count;
  PetscInt       count = 0, piece[MPM_MAX_DIM];
  MpmPieceLine   lines[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < found->entries; k++)
    if (search->box[found->piece[k]] < 0) search->box[found->piece[k]] = begin + found->count + count++;
  PetscCall(MpmSpaceAppendBoxes(space, found->count + count, &boxes));
  for (PetscInt f = 0; f < found->count + count; f++) boxes[f] = (MpmGroup){.count = {1, 1, 1}, .node_count = 1};
  for (PetscInt f = 0; f < found->count; f++) {
    PetscCall(PetscArraycpy(boxes[f].first, found->node[f], MPM_MAX_DIM));
    boxes[f].holes = PETSC_TRUE;
  }
  for (PetscInt k = 0; k < found->entries; k++) {
    MpmGroup *box = &boxes[search->box[found->piece[k]] - begin];

    MpmPiecesAt(&search->pieces, found->piece[k], piece);
    (void)MpmPieceLines(space, search->rules, &search->pieces, piece, lines);
    box->node_count = 1;
    for (PetscInt a = 0; a < dim; a++) {
      box->first[a] = lines[a].low;
      box->count[a] = lines[a].high - lines[a].low + 1;
      box->node_count *= box->count[a];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Keeps the result; a master stands as its place in its box until nodes have numbers. */
static PetscErrorCode Keep(const Search *search, PetscInt begin, Found *found)
{
  MpmExtension *extension = &search->space->extension;

  PetscFunctionBeginUser;
  extension->count = found->count;
  PetscCall(PetscMalloc1(found->count, &extension->follower));
  PetscCall(PetscMalloc1((2 * found->entries), &extension->master));
  for (PetscInt f = 0; f < found->count; f++) extension->follower[f] = begin + f;
  for (PetscInt k = 0; k < found->entries; k++) {
    extension->master[2 * k]     = search->box[found->piece[k]];
    extension->master[2 * k + 1] = found->place[k];
  }
  extension->offset = found->offset;
  extension->weight = found->weight;
  found->offset     = NULL;
  found->weight     = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmExtensionBoxes(const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  Search         search = {.rules = rules, .space = space};
  Found          found  = {0};
  const PetscInt begin  = space->boxes.count;
  PetscInt       count, piece[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  if (!(rules->filled > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPiecesCreate(space, rules, points, SEARCH + 2, &search.pieces));
  count = search.pieces.size[0] * search.pieces.size[1] * search.pieces.size[2];
  PetscCall(PetscCalloc1(count, &search.well));
  PetscCall(PetscMalloc1(count, &search.box));
  for (PetscInt i = 0; i < count; i++) {
    search.box[i] = -1;
    if (!search.pieces.fill[i]) continue;
    MpmPiecesAt(&search.pieces, i, piece);
    search.well[i] = (char)IsWellFilled(&search, piece);
  }
  PetscCall(MarkNodes(&search, count));
  PetscCall(FindFollowers(&search, count, &found));
  if (found.count) {
    PetscCall(AppendBoxes(&search, &found));
    PetscCall(Keep(&search, begin, &found));
  }
  PetscCall(PetscFree(found.node));
  PetscCall(PetscFree(found.offset));
  PetscCall(PetscFree(found.piece));
  PetscCall(PetscFree(found.place));
  PetscCall(PetscFree(found.weight));
  PetscCall(PetscFree(search.marks.mark));
  PetscCall(PetscFree(search.well));
  PetscCall(PetscFree(search.box));
  PetscCall(MpmPiecesDestroy(&search.pieces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Local numbers in place of boxes, each master once. */
PetscErrorCode MpmExtensionNumber(MpmSpace *space)
{
  MpmExtension *extension = &space->extension;
  PetscInt      kept = 0, entries = 0;

  PetscFunctionBeginUser;
  if (!extension->count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(space->local, &extension->of));
  for (PetscInt i = 0; i < space->local; i++) extension->of[i] = -1;
  for (PetscInt f = 0, from = 0; f < extension->count; f++) {
    const PetscInt node = space->group_nodes[space->groups[extension->follower[f]].node_offset];
    const PetscInt end = extension->offset[f + 1], begin = entries;

    for (PetscInt k = from; k < end && node >= 0; k++) {
      const MpmGroup *box    = &space->groups[extension->master[2 * k]];
      const PetscInt  master = space->group_nodes[box->node_offset + extension->master[2 * k + 1]];
      PetscInt        at     = begin;

      PetscCheck(master >= 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "a follower's master has no number");
      while (at < entries && extension->master[at] != master) at++;
      if (at == entries) {
        extension->master[at] = master;
        extension->weight[at] = extension->weight[k];
        entries++;
      } else extension->weight[at] += extension->weight[k];
    }
    from = end;
    if (node < 0) continue;
    extension->of[node]       = kept;
    extension->follower[kept] = node;
    extension->offset[kept]   = begin;
    extension->offset[++kept] = entries;
  }
  extension->count = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}
