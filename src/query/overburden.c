/*
  The weight of the column above every point, under a free surface of any shape and through any materials.

  Each point represents its domain, a box with the weight m g spread evenly. The pressure at point p is the mean over
  the domain's width of

    integral over y > y_p of (weight density) dy ,

  so that steps of the surface and neighbours with other domains count by the width that they share with p.

  The horizontal plane is divided into the grid's columns of cells and each column goes to one rank, whatever the ranks
  of its points. There, boxes of one width stand in piles, sorted from above with running sums: a point searches each
  pile once, by bisection.
*/
#include "grid/grid.h"
#include "query/overburden.h"
#include "particles/points.h"

/* A domain, or the part of it in one column: horizontal extent, centre's height and half height, weight per volume. */
typedef struct {
  PetscInt64 column;
  PetscInt64 place[4]; /* lower and upper, rounded to 1e-6 of a cell: piles are made by them */
  PetscReal  lower[2], upper[2], y, half, density;
  PetscReal  share;    /* of the point's own width that lies in this column */
  PetscReal  pressure; /* the answer: this column's part */
  PetscInt   index;    /* where the record stood when it came */
} Slab;

/* Boxes on top of each other: sorted by their lower ends from above; above[k] is the weight per area of boxes < k. */
typedef struct {
  const Slab *slab;
  PetscInt    count;
  PetscReal  *above, tallest;
} Pile;

static int ComparePlaces(const Slab *p, const Slab *q)
{
  if (p->column != q->column) return p->column < q->column ? -1 : 1;
  for (PetscInt k = 0; k < 4; k++)
    if (p->place[k] != q->place[k]) return p->place[k] < q->place[k] ? -1 : 1;
  return 0;
}

static int CompareSlabs(const void *a, const void *b)
{
  const Slab     *p = (const Slab *)a, *q = (const Slab *)b;
  const PetscReal low_p = p->y - p->half, low_q = q->y - q->half;
  const int       place = ComparePlaces(p, q);

  if (place) return place;
  return low_p > low_q ? -1 : low_p < low_q;
}

/* Weight per area that a pile has above the height y. */
static PetscReal PileAbove(const Pile *pile, PetscReal y)
{
  PetscInt  low = 0, high = pile->count;
  PetscReal weight;

  while (low < high) { /* the first box whose lower end is below y */
    const PetscInt middle = (low + high) / 2;

    if (pile->slab[middle].y - pile->slab[middle].half >= y) low = middle + 1;
    else high = middle;
  }
  weight = pile->above[low];
  for (; low < pile->count; low++) {
    const Slab     *slab = &pile->slab[low];
    const PetscReal top  = slab->y + slab->half;

    if (slab->y - slab->half < y - pile->tallest) break; /* no box further down reaches y */
    if (top > y) weight += slab->density * (top - y);
  }
  return weight;
}

/* The part of slab p's width that slab q covers. */
static PetscReal Overlap(const Slab *p, const Slab *q, PetscInt axes)
{
  PetscReal part = 1.;

  for (PetscInt a = 0; a < axes; a++) {
    const PetscReal both = PetscMin(p->upper[a], q->upper[a]) - PetscMax(p->lower[a], q->lower[a]);

    part *= PetscMax(both, 0.) / (p->upper[a] - p->lower[a]);
  }
  return part;
}

/* All slabs of one column, sorted. */
static PetscErrorCode SolveColumn(Slab slabs[], PetscInt count, PetscInt axes)
{
  PetscInt   piles = 0;
  Pile      *pile;
  PetscReal *above;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(count, &pile, (2 * count), &above));
  for (PetscInt k = 0, used = 0; k < count; k++) {
    if (!k || ComparePlaces(&slabs[k - 1], &slabs[k])) {
      pile[piles++] = (Pile){.slab = &slabs[k], .above = &above[used]};
      above[used++] = 0.;
    }
    above[used] = above[used - 1] + 2. * slabs[k].half * slabs[k].density;
    used++;
    pile[piles - 1].count++;
    pile[piles - 1].tallest = PetscMax(pile[piles - 1].tallest, 2. * slabs[k].half);
  }
  for (PetscInt k = 0; k < count; k++) {
    slabs[k].pressure = 0.;
    for (PetscInt i = 0; i < piles; i++) {
      const PetscReal part = Overlap(&slabs[k], pile[i].slab, axes);

      if (part > 0.) slabs[k].pressure += slabs[k].share * part * PileAbove(&pile[i], slabs[k].y);
    }
  }
  PetscCall(PetscFree2(pile, above));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The horizontal axes. */
static void Horizontal(PetscInt dim, PetscInt vertical, PetscInt axes[2])
{
  PetscInt n = 0;

  axes[1] = -1;
  for (PetscInt a = 0; a < dim; a++)
    if (a != vertical) axes[n++] = a;
}

/* The columns that point p's domain meets, first and last on each horizontal axis. */
static void Columns(const MpmGrid *grid, const MpmPoints *points, const PetscReal half_length[], PetscInt p,
                    const PetscInt axes[2], PetscInt first[2], PetscInt last[2])
{
  first[1] = last[1] = 0;
  for (PetscInt k = 0; k < grid->dim - 1; k++) {
    const PetscInt  a    = axes[k];
    const PetscReal xi   = (points->x[p * grid->dim + a] - grid->lower[a]) / grid->h[a],
                    half = PetscMin(half_length[p * grid->dim + a] / grid->h[a], (PetscReal)grid->cells[a]);

    first[k] = PetscMax((PetscInt)PetscFloorReal(xi - half + MPM_TOLERANCE), 0);
    last[k]  = PetscMin((PetscInt)PetscCeilReal(xi + half - MPM_TOLERANCE) - 1, grid->cells[a] - 1);
    first[k] = PetscMin(first[k], grid->cells[a] - 1);
    last[k]  = PetscMax(last[k], first[k]);
  }
}

/* The slab of point p in one column. */
static Slab MakeSlab(const MpmGrid *grid, const MpmPoints *points, const MpmVertical *vertical,
                     const PetscReal half_length[], PetscInt p, const PetscInt axes[2], const PetscInt column[2])
{
  const PetscInt   dim = grid->dim;
  const PetscReal *x = &points->x[p * dim], *half = &half_length[p * dim];
  PetscReal        area = MpmGridTurn(grid, x[0]);
  Slab             slab = {.share = 1., .y = (PetscReal)vertical->up * x[vertical->axis], .half = half[vertical->axis]};

  slab.column = column[0] + (PetscInt64)column[1] * grid->cells[axes[0]];
  for (PetscInt k = 0; k < dim - 1; k++) {
    const PetscInt  a    = axes[k];
    const PetscReal edge = grid->lower[a] + grid->h[a] * (PetscReal)column[k];

    slab.lower[k] = x[a] - half[a];
    slab.upper[k] = x[a] + half[a];
    if (column[k] > 0) slab.lower[k] = PetscMax(slab.lower[k], edge);
    if (column[k] < grid->cells[a] - 1) slab.upper[k] = PetscMin(slab.upper[k], edge + grid->h[a]);
    slab.share *= (slab.upper[k] - slab.lower[k]) / (2. * half[a]);
    slab.place[2 * k]     = (PetscInt64)PetscFloorReal((slab.lower[k] - edge) / grid->h[a] / MPM_TOLERANCE + 0.5);
    slab.place[2 * k + 1] = (PetscInt64)PetscFloorReal((slab.upper[k] - edge) / grid->h[a] / MPM_TOLERANCE + 0.5);
    area *= 2. * half[a];
  }
  slab.density = points->mass[p] * vertical->gravity / (area * 2. * slab.half);
  return slab;
}

/* Slabs on their way to the ranks of their columns and back. */
typedef struct {
  MPI_Comm     comm;
  PetscMPIInt  size, *sent, *sent_from, *received, *received_from;
  PetscInt     sent_count, received_count;
  MPI_Datatype type;
} Courier;

static PetscErrorCode CourierCreate(const MpmGrid *grid, const PetscInt count[], Courier *courier)
{
  PetscMPIInt bytes;

  PetscFunctionBeginUser;
  courier->comm = grid->comm;
  courier->size = grid->size;
  PetscCall(PetscMalloc4(grid->size, &courier->sent, (grid->size + 1), &courier->sent_from, grid->size,
                         &courier->received, (grid->size + 1), &courier->received_from));
  for (PetscMPIInt r = 0; r < grid->size; r++) PetscCall(PetscMPIIntCast(count[r], &courier->sent[r]));
  PetscCallMPI(MPI_Alltoall(courier->sent, 1, MPI_INT, courier->received, 1, MPI_INT, grid->comm));
  courier->sent_from[0] = courier->received_from[0] = 0;
  for (PetscMPIInt r = 0; r < grid->size; r++) {
    courier->sent_from[r + 1]     = courier->sent_from[r] + courier->sent[r];
    courier->received_from[r + 1] = courier->received_from[r] + courier->received[r];
  }
  courier->sent_count     = courier->sent_from[grid->size];
  courier->received_count = courier->received_from[grid->size];
  PetscCall(PetscMPIIntCast((PetscInt)sizeof(Slab), &bytes));
  PetscCallMPI(MPI_Type_contiguous(bytes, MPI_BYTE, &courier->type));
  PetscCallMPI(MPI_Type_commit(&courier->type));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CourierDestroy(Courier *courier)
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Type_free(&courier->type));
  PetscCall(PetscFree4(courier->sent, courier->sent_from, courier->received, courier->received_from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The columns of this rank: slabs[k].pressure for all k, in the order in which they came. */
static PetscErrorCode SolveColumns(Slab slabs[], PetscInt count, PetscInt axes)
{
  PetscReal *pressure;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) slabs[k].index = k;
  if (count) qsort(slabs, (size_t)count, sizeof(*slabs), CompareSlabs);
  for (PetscInt k = 0, end; k < count; k = end) {
    for (end = k + 1; end < count && slabs[end].column == slabs[k].column;) end++;
    PetscCall(SolveColumn(&slabs[k], end - k, axes));
  }
  PetscCall(PetscMalloc1(count, &pressure));
  for (PetscInt k = 0; k < count; k++) pressure[slabs[k].index] = slabs[k].pressure;
  for (PetscInt k = 0; k < count; k++) slabs[k].pressure = pressure[k];
  PetscCall(PetscFree(pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Goes through the slabs of this rank's points, ordered by the rank that they go to; counts them, or makes them where
  `slabs` is given, with the point's number in owner[].
*/
static void EachSlab(const MpmGrid *grid, const MpmPoints *points, const MpmVertical *vertical,
                     const PetscReal half_length[], PetscInt next[], Slab slabs[], PetscInt owner[])
{
  PetscInt axes[2], first[2], last[2], column[2];

  Horizontal(grid->dim, vertical->axis, axes);
  for (PetscInt p = 0; p < points->count; p++) {
    Columns(grid, points, half_length, p, axes, first, last);
    for (column[1] = first[1]; column[1] <= last[1]; column[1]++) {
      for (column[0] = first[0]; column[0] <= last[0]; column[0]++) {
        const PetscInt64 key = column[0] + (PetscInt64)column[1] * grid->cells[axes[0]];
        const PetscInt   k   = next[key % grid->size]++;

        if (!slabs) continue;
        slabs[k] = MakeSlab(grid, points, vertical, half_length, p, axes, column);
        owner[k] = p;
      }
    }
  }
}

PetscErrorCode MpmOverburden(const MpmGrid *grid, const MpmPoints *points, const MpmVertical *vertical,
                             const PetscReal half_length[], PetscReal pressure[])
{
  PetscInt *next, *owner;
  Slab     *sent, *received;
  Courier   courier;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->size, &next));
  EachSlab(grid, points, vertical, half_length, next, NULL, NULL);
  PetscCall(CourierCreate(grid, next, &courier));
  PetscCall(PetscMalloc3(courier.sent_count, &sent, courier.received_count, &received, courier.sent_count, &owner));
  for (PetscMPIInt r = 0; r < grid->size; r++) next[r] = courier.sent_from[r];
  EachSlab(grid, points, vertical, half_length, next, sent, owner);
  PetscCallMPI(MPI_Alltoallv(sent, courier.sent, courier.sent_from, courier.type, received, courier.received,
                             courier.received_from, courier.type, grid->comm));
  /* sorting moves the slabs, but their answers stand where they came */
  PetscCall(SolveColumns(received, courier.received_count, grid->dim - 1));
  PetscCallMPI(MPI_Alltoallv(received, courier.received, courier.received_from, courier.type, sent, courier.sent,
                             courier.sent_from, courier.type, grid->comm));
  PetscCall(PetscArrayzero(pressure, points->count));
  for (PetscInt k = 0; k < courier.sent_count; k++) pressure[owner[k]] += sent[k].pressure;
  PetscCall(PetscFree3(sent, received, owner));
  PetscCall(CourierDestroy(&courier));
  PetscCall(PetscFree(next));
  PetscFunctionReturn(PETSC_SUCCESS);
}
