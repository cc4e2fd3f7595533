/*
  The background grid: a regular lattice, shared out to the ranks by planes between its nodes.

  Splits nest: the first divides the lattice among two halves of the ranks, the next ones divide each part again, across
  whichever axis balances its points best (Berger and Bokhari 1987, doi:10.1109/TC.1987.1676942). The parts are
  therefore boxes, of any number of ranks. Unlike a product of splits per axis they also follow points along a slope,
  for instance. Where a layer of cells holds too much for that, the split passes through it with a step.
*/
#include "options/options.h"
#include "grid/extent.h"
#include "grid/grid.h"
#include "grid/partition.h"

/* Points on the fullest rank over their mean from which on to look for other splits: one look costs some hundredth of a
   step's work on the points (scripts/bench.py balance). */
#define BALANCE 1.05
/* cost of a point beside a split, in points; excess of the fuller side from which a split has a step */
#define BESIDE_CUT 0.25
#define STEP_FROM  1.02

PetscErrorCode MpmGridSetFromOptions(MpmGrid *grid, const MpmOptions *options, PetscInt dim)
{
  const MpmOptions block  = {options->comm, "mpm_grid_", options->record};
  PetscInt         refine = 1;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(grid, sizeof(*grid)));
  grid->comm = options->comm;
  grid->dim  = dim;
  PetscCallMPI(MPI_Comm_rank(grid->comm, &grid->rank));
  PetscCallMPI(MPI_Comm_size(grid->comm, &grid->size));
  grid->order = 1;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    grid->cells[a] = grid->nodes[a] = 1;
    grid->h[a]                      = 1.;
  }
  PetscCall(MpmOptionsHeading(&block, "Grid"));
  PetscCall(MpmGridReadExtent(&block, options, grid));
  PetscCall(MpmOptionsInt(&block, "refine", "multiplies the cells per axis", 1, 1000000, MPM_OPTIONAL, &refine, NULL));
  grid->balance = BALANCE;
  PetscCall(MpmOptionsReal(&block, "balance", "-",
                           "the points are redistributed when the fullest rank holds so many times their mean",
                           ((MpmRange){1., PETSC_INFINITY, PETSC_FALSE}), MPM_OPTIONAL, &grid->balance, NULL));
  PetscCall(MpmOptionsBool(&block, "outflow",
                           "in dynamics, points that leave the grid are gone; otherwise they end the run",
                           &grid->outflow, NULL));
  for (PetscInt a = 0; a < dim && !MpmOptionsHelp(); a++) {
    MpmCheckInput(grid->upper[a] > grid->lower[a],
                  "-mpm_grid_upper: axis %c ends at %g, must lie above -mpm_grid_lower, %g", "xyz"[a],
                  (double)(grid->upper[a]), (double)(grid->lower[a]));
    MpmCheckInput((PetscInt64)grid->cells[a] * refine < 1000000000,
                  "-mpm_grid_refine %" PetscInt_FMT ": too many cells on axis %c", refine, "xyz"[a]);
    grid->cells[a] *= refine;
    grid->nodes[a] = grid->cells[a] + 1;
    grid->h[a]     = (grid->upper[a] - grid->lower[a]) / (PetscReal)grid->cells[a];
    MpmCheckInput(
      grid->h[a] > 1e-300 && grid->h[a] > 1e-12 * PetscMax(PetscAbsReal(grid->lower[a]), PetscAbsReal(grid->upper[a])),
      "-mpm_grid_cells: a cell of %g on axis %c is too small for its coordinates", (double)(grid->h[a]), "xyz"[a]);
  }
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    grid->start_lower[a] = grid->lower[a];
    grid->start_upper[a] = grid->upper[a];
    grid->start_h[a]     = grid->h[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridDestroy(MpmGrid *grid)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(grid->splits));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmGridPlace(MpmGrid *grid, const PetscReal lower[], const PetscReal upper[])
{
  grid->moved = PETSC_TRUE;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscBool scaled = (PetscBool)(upper[a] - lower[a] != grid->start_upper[a] - grid->start_lower[a]);

    grid->lower[a] = lower[a];
    grid->upper[a] = upper[a];
    grid->h[a]     = scaled ? (upper[a] - lower[a]) / (PetscReal)grid->cells[a] : grid->start_h[a];
  }
}

void MpmGridAtStart(const MpmGrid *grid, const PetscReal x[], PetscReal start[])
{
  for (PetscInt a = 0; a < grid->dim; a++)
    start[a] = grid->moved ? grid->start_lower[a] + (x[a] - grid->lower[a]) * (grid->start_h[a] / grid->h[a]) : x[a];
}

void MpmGridFindCell(const MpmGrid *grid, const PetscReal x[], PetscInt cell[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) cell[a] = 0;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal xi = PetscFloorReal((x[a] - grid->lower[a]) / grid->h[a]);

    cell[a] = (PetscInt)PetscMin(PetscMax(xi, 0.), (PetscReal)(grid->cells[a] - 1));
  }
}

static inline PetscBool IsBelow(const MpmSplit *split, const PetscInt node[])
{
  return (PetscBool)(node[split->axis] < split->node ||
                     (node[split->axis] == split->node && node[split->row_axis] < split->row));
}

/*
  The part below a split goes to the lower half of its ranks. Splits stand in preorder: first one, then those of the
  part below, then those above, one less than there are ranks in each.
*/
PetscMPIInt MpmGridCellOwner(const MpmGrid *grid, const PetscInt node[])
{
  const MpmSplit *split = grid->splits;
  PetscMPIInt     first = 0, ranks = grid->size;

  while (ranks > 1) {
    const PetscMPIInt below = ranks / 2;

    if (IsBelow(split, node)) {
      split++;
      ranks = below;
    } else {
      split += below;
      first += below;
      ranks -= below;
    }
  }
  return first;
}

static PetscInt BoxOwners(const MpmSplit *split, PetscMPIInt first, PetscMPIInt ranks, const PetscInt lower[],
                          const PetscInt upper[], PetscMPIInt owner[])
{
  const PetscMPIInt below = ranks / 2;
  PetscInt          count = 0;

  if (ranks == 1) {
    owner[0] = first;
    return 1;
  }
  if (IsBelow(split, lower)) count += BoxOwners(split + 1, first, below, lower, upper, owner);
  if (!IsBelow(split, upper))
    count += BoxOwners(split + below, first + below, ranks - below, lower, upper, owner + count);
  return count;
}

PetscInt MpmGridBoxOwners(const MpmGrid *grid, const PetscInt lower[], const PetscInt upper[], PetscMPIInt owner[])
{
  return BoxOwners(grid->splits, 0, grid->size, lower, upper, owner);
}

/* ---- partition ---- */

/* A part of the lattice still to be split: a box of cells, upper ones excluded, without the cells removed by steps. */
typedef struct {
  PetscMPIInt ranks;
  PetscInt    split; /* into the grid's splits */
  PetscInt    lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscInt    histogram[MPM_MAX_DIM]; /* where its points per layer of cells start, on each axis */
  PetscInt    rows;                   /* where the points per row of the layer at its split start; -1: no step */
  PetscInt64  total, below;           /* points in it; below the split */
} Part;

/* The box of all cells with points. */
static PetscErrorCode FindBox(const MpmGrid *grid, PetscInt count, const PetscReal x[], Part *box)
{
  PetscInt bound[2 * MPM_MAX_DIM]; /* minima and negated maxima */

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    bound[a]               = grid->cells[a] - 1;
    bound[MPM_MAX_DIM + a] = 0;
  }
  for (PetscInt p = 0; p < count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    MpmGridFindCell(grid, &x[p * grid->dim], cell);
    for (PetscInt a = 0; a < grid->dim; a++) {
      bound[a]               = PetscMin(bound[a], cell[a]);
      bound[MPM_MAX_DIM + a] = PetscMin(bound[MPM_MAX_DIM + a], -cell[a]);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, bound, 2 * MPM_MAX_DIM, MPIU_INT, MPI_MIN, grid->comm));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    box->lower[a] = bound[a];
    box->upper[a] = PetscMax(-bound[MPM_MAX_DIM + a], bound[a]) + 1;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points while the lattice is divided. */
typedef struct {
  PetscInt         count;
  const PetscReal *x;
  PetscInt        *part; /* which part each is in; -1: in one that is divided no further */
} Placed;

/* Points per layer of cells, for every part and axis. */
static PetscErrorCode Histograms(const MpmGrid *grid, const Placed *points, PetscInt part_count, Part parts[],
                                 PetscInt64 **histogram)
{
  PetscInt size = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < part_count; k++) {
    for (PetscInt a = 0; a < grid->dim; a++) {
      parts[k].histogram[a] = size;
      size += parts[k].upper[a] - parts[k].lower[a];
    }
  }
  PetscCall(PetscCalloc1(size, histogram));
  for (PetscInt p = 0; p < points->count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    if (points->part[p] < 0) continue;
    MpmGridFindCell(grid, &points->x[p * grid->dim], cell);
    for (PetscInt a = 0; a < grid->dim; a++)
      (*histogram)[parts[points->part[p]].histogram[a] + cell[a] - parts[points->part[p]].lower[a]]++;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, *histogram, (PetscMPIInt)size, MPIU_INT64, MPI_SUM, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points for a rank on the fuller side. */
static PetscReal FullerSide(const Part *part, PetscInt64 below)
{
  const PetscMPIInt ranks = part->ranks / 2;

  return PetscMax((PetscReal)below / ranks, (PetscReal)(part->total - below) / (part->ranks - ranks));
}

/*
  Chooses the plane at which the fuller side has fewest points for a rank. Points beside the plane count as well, since
  they are exchanged between ranks.
*/
static void ChoosePlane(PetscInt dim, Part *part, const PetscInt64 histogram[], MpmSplit *split)
{
  PetscReal best = PETSC_MAX_REAL;

  part->total = 0;
  for (PetscInt i = 0; i < part->upper[0] - part->lower[0]; i++) part->total += histogram[part->histogram[0] + i];
  part->below = part->total;
  *split      = (MpmSplit){0, part->upper[0], 0, 0}; /* in a single cell there is nothing to share */
  for (PetscInt a = 0; a < dim; a++) {
    const PetscInt64 *layer = &histogram[part->histogram[a]];
    PetscInt64        sum   = 0;

    for (PetscInt i = 1; i < part->upper[a] - part->lower[a]; i++) {
      PetscReal cost;

      sum += layer[i - 1];
      cost = FullerSide(part, sum) + BESIDE_CUT * (PetscReal)PetscMin(layer[i - 1], layer[i]) / part->ranks;
      if (cost >= best) continue;
      best        = cost;
      part->below = sum;
      *split      = (MpmSplit){a, part->lower[a] + i, a, 0};
    }
  }
}

/*
  Where the plane leaves one side too full: the layer with the middle of the points, on the axis on which it holds
  fewest. Rows are those of the longest other axis. PETSC_FALSE where the plane suffices.
*/
static PetscBool ChooseLayer(PetscInt dim, Part *part, const PetscInt64 histogram[], MpmSplit *split)
{
  const PetscReal target = (PetscReal)part->total * (part->ranks / 2) / part->ranks;
  PetscInt64      fewest = PETSC_INT_MAX;

  if (FullerSide(part, part->below) * part->ranks <= STEP_FROM * (PetscReal)part->total) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) {
    const PetscInt64 *layer = &histogram[part->histogram[a]];
    PetscInt64        sum   = 0;
    PetscInt          i = 0, other = a ? 0 : 1;

    while (i < part->upper[a] - part->lower[a] - 1 && (PetscReal)(sum + layer[i]) <= target) sum += layer[i++];
    if (layer[i] >= fewest) continue;
    fewest      = layer[i];
    part->below = sum;
    for (PetscInt b = 0; b < dim; b++)
      if (b != a && part->upper[b] - part->lower[b] > part->upper[other] - part->lower[other]) other = b;
    *split = (MpmSplit){a, part->lower[a] + i, other, part->lower[other]};
  }
  return PETSC_TRUE;
}

/* Points per row of the layers that splits pass through; NULL where there are none. */
static PetscErrorCode RowHistograms(const MpmGrid *grid, const Placed *points, PetscInt part_count, Part parts[],
                                    const MpmSplit splits[], PetscInt64 **histogram)
{
  PetscInt size = 0;

  PetscFunctionBeginUser;
  *histogram = NULL;
  for (PetscInt k = 0; k < part_count; k++) {
    const PetscInt a = splits[parts[k].split].row_axis;

    if (parts[k].rows < 0) continue;
    parts[k].rows = size;
    size += parts[k].upper[a] - parts[k].lower[a];
  }
  if (!size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(size, histogram));
  for (PetscInt p = 0; p < points->count; p++) {
    const Part     *part  = points->part[p] < 0 ? NULL : &parts[points->part[p]];
    const MpmSplit *split = part ? &splits[part->split] : NULL;
    PetscInt        cell[MPM_MAX_DIM];

    if (!part || part->rows < 0) continue;
    MpmGridFindCell(grid, &points->x[p * grid->dim], cell);
    if (cell[split->axis] == split->node)
      (*histogram)[part->rows + cell[split->row_axis] - part->lower[split->row_axis]]++;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, *histogram, (PetscMPIInt)size, MPIU_INT64, MPI_SUM, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Chooses the row at which the layer is divided. */
static void ChooseRow(Part *part, const PetscInt64 histogram[], MpmSplit *split)
{
  const PetscInt lower = part->lower[split->row_axis], upper = part->upper[split->row_axis];
  PetscInt64     sum = part->below;

  for (PetscInt i = lower; i < upper; i++) {
    sum += histogram[part->rows + i - lower];
    if (FullerSide(part, sum) >= FullerSide(part, part->below)) continue;
    part->below = sum;
    split->row  = i + 1;
  }
}

/* The two sides of a split that more than one rank shares become parts of the next level; returns their number. */
static PetscInt Divide(const Part *part, const MpmSplit *split, Part next[], PetscInt index[2], PetscInt first)
{
  const PetscMPIInt below = part->ranks / 2, ranks[2] = {below, part->ranks - below};
  PetscInt          made = 0;

  for (PetscInt side = 0; side < 2; side++) {
    index[side] = ranks[side] > 1 ? first + made : -1;
    if (ranks[side] == 1) continue;
    next[made]       = *part;
    next[made].ranks = ranks[side];
    next[made].split = part->split + (side ? below : 1);
    if (side) next[made].lower[split->axis] = PetscMin(split->node, part->upper[split->axis] - 1);
    else next[made].upper[split->axis] = PetscMin(split->node + (part->rows >= 0), part->upper[split->axis]);
    made++;
  }
  return made;
}

/* Points on the fuller of those sides that are one rank's alone. */
static PetscInt64 FullestRank(const Part *part)
{
  const PetscInt64 below = part->ranks / 2 == 1 ? part->below : 0;

  return PetscMax(below, part->ranks - part->ranks / 2 == 1 ? part->total - part->below : 0);
}

/* All splits, level by level; `most` becomes the points on the fullest rank. */
static PetscErrorCode SplitAll(const MpmGrid *grid, PetscInt count, const PetscReal x[], MpmSplit splits[],
                               PetscInt64 *most)
{
  Part    *parts, *next;
  PetscInt part_count = 1, (*index)[2];
  Placed   points     = {.count = count, .x = x};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(grid->size, &parts, grid->size, &next, grid->size, &index));
  PetscCall(PetscCalloc1(count, &points.part));
  parts[0] = (Part){.ranks = grid->size};
  PetscCall(FindBox(grid, count, x, &parts[0]));
  while (part_count) {
    PetscInt64 *histogram, *row_histogram;
    PetscInt    made = 0;

    PetscCall(Histograms(grid, &points, part_count, parts, &histogram));
    for (PetscInt k = 0; k < part_count; k++) {
      MpmSplit *split = &splits[parts[k].split];

      ChoosePlane(grid->dim, &parts[k], histogram, split);
      parts[k].rows = ChooseLayer(grid->dim, &parts[k], histogram, split) ? 0 : -1;
    }
    PetscCall(RowHistograms(grid, &points, part_count, parts, splits, &row_histogram));
    for (PetscInt k = 0; k < part_count; k++) {
      MpmSplit *split = &splits[parts[k].split];

      if (parts[k].rows >= 0) ChooseRow(&parts[k], row_histogram, split);
      *most = PetscMax(*most, FullestRank(&parts[k]));
      made += Divide(&parts[k], split, &next[made], index[k], made);
    }
    PetscCall(PetscFree(histogram));
    PetscCall(PetscFree(row_histogram));
    for (PetscInt p = 0; p < count && made; p++) {
      PetscInt cell[MPM_MAX_DIM];

      if (points.part[p] < 0) continue;
      MpmGridFindCell(grid, &x[p * grid->dim], cell);
      points.part[p] = index[points.part[p]][!IsBelow(&splits[parts[points.part[p]].split], cell)];
    }
    PetscCall(PetscArraycpy(parts, next, made));
    part_count = made;
  }
  PetscCall(PetscFree(points.part));
  PetscCall(PetscFree3(parts, next, index));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridPartition(MpmGrid *grid, PetscInt count, const PetscReal x[], PetscReal worth, PetscBool *taken)
{
  PetscInt64 most = 0;
  MpmSplit  *splits;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->size, &splits));
  if (grid->size > 1) PetscCall(SplitAll(grid, count, x, splits, &most));
  *taken = (PetscBool)(!grid->splits || (PetscReal)most <= worth);
  if (*taken) {
    PetscCall(PetscFree(grid->splits));
    grid->splits = splits;
  } else PetscCall(PetscFree(splits));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the partition as numbers ---- */

PetscErrorCode MpmGridGetPartition(const MpmGrid *grid, PetscInt *count, PetscInt **numbers)
{
  PetscFunctionBeginUser;
  *count = 4 * (grid->size - 1);
  PetscCall(PetscMalloc1(*count, numbers));
  for (PetscInt k = 0; k < grid->size - 1; k++) {
    const MpmSplit *split = &grid->splits[k];

    (*numbers)[4 * k]     = split->axis;
    (*numbers)[4 * k + 1] = split->node;
    (*numbers)[4 * k + 2] = split->row_axis;
    (*numbers)[4 * k + 3] = split->row;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridSetPartition(MpmGrid *grid, PetscInt count, const PetscInt numbers[], PetscBool *set)
{
  PetscFunctionBeginUser;
  *set = (PetscBool)(count == 4 * (grid->size - 1));
  if (!*set) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(grid->splits));
  PetscCall(PetscMalloc1(grid->size, &grid->splits));
  for (PetscInt k = 0; k < grid->size - 1; k++) {
    grid->splits[k] = (MpmSplit){
      .axis = numbers[4 * k], .node = numbers[4 * k + 1], .row_axis = numbers[4 * k + 2], .row = numbers[4 * k + 3]};
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- records that other ranks need too ---- */

/* How many records each rank gets, and the lists' ranks and offsets; `place` is where each rank's first one stands. */
static PetscErrorCode CountShares(const MpmGrid *grid, PetscInt words, PetscInt count, const PetscInt boxes[],
                                  MpmLists *sent, PetscInt place[])
{
  PetscMPIInt *owner;
  PetscInt    *records;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(grid->size, &owner));
  PetscCall(PetscCalloc1(grid->size, &records));
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt *box    = &boxes[2 * MPM_MAX_DIM * k];
    const PetscInt  owners = MpmGridBoxOwners(grid, box, box + MPM_MAX_DIM, owner);

    for (PetscInt i = 0; i < owners; i++) records[owner[i]] += owner[i] != grid->rank;
  }
  PetscCall(PetscMalloc1(grid->size, &sent->rank));
  PetscCall(PetscMalloc1((grid->size + 1), &sent->offset));
  sent->offset[0] = 0;
  for (PetscMPIInt r = 0; r < grid->size; r++) {
    if (!records[r]) continue;
    place[r]                      = sent->offset[sent->count];
    sent->rank[sent->count]       = r;
    sent->offset[sent->count + 1] = sent->offset[sent->count] + words * records[r];
    sent->count++;
  }
  PetscCall(PetscFree(owner));
  PetscCall(PetscFree(records));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridShare(const MpmGrid *grid, size_t size, const PetscInt boxes[], PetscInt *count, void **records)
{
  const PetscInt words = (PetscInt)(size / sizeof(PetscInt));
  MpmLists       sent = {0}, received = {0};
  PetscMPIInt   *owner;
  PetscInt      *place;

  PetscFunctionBeginUser;
  if (grid->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(grid->size, &owner, grid->size, &place));
  PetscCall(CountShares(grid, words, *count, boxes, &sent, place));
  PetscCall(PetscMalloc1(sent.offset[sent.count], &sent.data));
  for (PetscInt k = 0; k < *count; k++) {
    const PetscInt *box    = &boxes[2 * MPM_MAX_DIM * k];
    const PetscInt  owners = MpmGridBoxOwners(grid, box, box + MPM_MAX_DIM, owner);

    for (PetscInt i = 0; i < owners; i++) {
      if (owner[i] == grid->rank) continue;
      PetscCall(PetscMemcpy(&sent.data[place[owner[i]]], (const char *)*records + (size_t)k * size, size));
      place[owner[i]] += words;
    }
  }
  PetscCall(MpmListsExchange(grid->comm, &sent, &received));
  const PetscInt more = received.offset[received.count] / words;

  PetscCall(PetscRealloc((size_t)(*count + more) * size, records));
  PetscCall(PetscMemcpy((char *)*records + (size_t)*count * size, received.data, (size_t)more * size));
  *count += more;
  PetscCall(MpmListsDestroy(&sent));
  PetscCall(MpmListsDestroy(&received));
  PetscCall(PetscFree2(owner, place));
  PetscFunctionReturn(PETSC_SUCCESS);
}
