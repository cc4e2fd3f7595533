/*
  Boxes of a release: which are whole, and what is cut from the others.
*/
#include "release/release_impl.h"

#define WHOLE 1e-12 /* part of a box that is rounding */
#define LEAST 0.25  /* part of a box from which on it has a point of its own */

/* ---- whole boxes ---- */

/* Adds the weights of the pixels, from `first` on, for the integral from a to b; returns the number of pixels. */
static PetscInt AddWeights(const MpmMap *map, PetscInt axis, PetscReal a, PetscReal b, PetscInt *first,
                           PetscReal weight[])
{
  const PetscInt  last = (axis ? map->rows : map->columns) - 1;
  const PetscReal cell = map->cell[axis], start = axis ? map->y0 : map->x0;
  const PetscInt  from = (PetscInt)PetscClipInterval(PetscFloorReal((a - start) / cell), -1., (PetscReal)last);
  const PetscInt  to   = (PetscInt)PetscClipInterval(PetscFloorReal((b - start) / cell), -1., (PetscReal)last);

  *first = PetscMax(from, 0);
  for (PetscInt k = 0; k <= PetscMin(to + 1, last) - *first; k++) weight[k] = 0.;
  for (PetscInt k = from; k <= to; k++) {
    const PetscReal left   = k == from ? a : start + (PetscReal)k * cell;
    const PetscReal right  = k == to ? b : start + (PetscReal)(k + 1) * cell;
    const PetscReal middle = k < 0 ? 1. : k == last ? 0. : (0.5 * (left + right) - start) / cell - (PetscReal)k;

    if (k >= 0) weight[k - *first] += (1. - middle) * (right - left);
    if (k < last) weight[k + 1 - *first] += middle * (right - left);
  }
  return PetscMin(to + 1, last) - *first + 1;
}

/* Most pixels that an interval touches. */
static PetscInt Width(const MpmMap *map, PetscInt axis, PetscReal spacing)
{
  return (PetscInt)PetscCeilReal(spacing / map->cell[axis]) + 3;
}

static PetscErrorCode FindWeights(MpmRelease release)
{
  const MpmReleaseLattice *lattice = &release->lattice;
  const MpmMap            *map     = &release->depth.map;
  const PetscInt           width   = map->value ? Width(map, 0, lattice->spacing[0]) : 0;
  MpmReleaseWeights       *across  = &release->across;

  PetscFunctionBeginUser;
  if (!map->value) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc4(lattice->count[0] + 1, &across->begin, lattice->count[0], &across->pixel,
                         (size_t)lattice->count[0] * (size_t)width, &across->weight, Width(map, 1, lattice->spacing[1]),
                         &across->row));
  across->begin[0] = 0;
  for (PetscInt i = 0; i < lattice->count[0]; i++) {
    const PetscReal left = lattice->lower[0] + (PetscReal)i * lattice->spacing[0];

    across->begin[i + 1] = across->begin[i] + AddWeights(map, 0, left, left + lattice->spacing[0], &across->pixel[i],
                                                         &across->weight[across->begin[i]]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmReleaseWhole(MpmRelease release, PetscInt feature, PetscInt i, PetscInt j)
{
  const MpmReleaseLattice *lattice = &release->lattice;
  const MpmReleaseWeights *across  = &release->across;
  const MpmMap            *map     = &release->depth.map;
  const PetscReal          low     = lattice->lower[1] + (PetscReal)j * lattice->spacing[1];
  PetscReal               *weight = across->row, volume = 0.;
  PetscInt                 first, rows;

  if (!map->value) return release->depth.number[feature] * lattice->spacing[0] * lattice->spacing[1];
  rows = AddWeights(map, 1, low, low + lattice->spacing[1], &first, weight);
  for (PetscInt b = 0; b < rows; b++) {
    const PetscReal *row = &map->value[(PetscInt64)(first + b) * map->columns + across->pixel[i]];
    PetscReal        sum = 0.;

    for (PetscInt a = across->begin[i]; a < across->begin[i + 1]; a++)
      if (across->weight[a] != 0.) sum += across->weight[a] * row[a - across->begin[i]];
    if (weight[b] != 0.) volume += weight[b] * sum;
  }
  return volume;
}

PetscErrorCode MpmReleaseRectangle(const MpmMap *map, const PetscReal lower[2], const PetscReal upper[2],
                                   PetscReal *volume)
{
  PetscReal *weight[2];
  PetscInt   first[2], count[2];

  PetscFunctionBeginUser;
  *volume = 0.;
  for (PetscInt a = 0; a < 2; a++) {
    PetscCall(PetscMalloc1(Width(map, a, upper[a] - lower[a]), &weight[a]));
    count[a] = AddWeights(map, a, lower[a], upper[a], &first[a], weight[a]);
  }
  for (PetscInt j = 0; j < count[1]; j++) {
    const PetscReal *row = &map->value[(PetscInt64)(first[1] + j) * map->columns + first[0]];
    PetscReal        sum = 0.;

    for (PetscInt i = 0; i < count[0]; i++) sum += weight[0][i] * row[i];
    *volume += weight[1][j] * sum;
  }
  for (PetscInt a = 0; a < 2; a++) PetscCall(PetscFree(weight[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- cut boxes ---- */

static PetscInt *Box(MpmRelease release, PetscInt i, PetscInt j)
{
  return &release->box[(PetscInt64)(j - release->kept[0]) * release->lattice.count[0] + i];
}

static PetscErrorCode AddCut(MpmRelease release, const MpmPart *part, PetscInt *box)
{
  PetscFunctionBeginUser;
  if (release->cuts == release->room) {
    release->room = 2 * release->room + 64;
    PetscCall(PetscRealloc((size_t)release->room * sizeof(*release->cut), &release->cut));
  }
  release->cut[release->cuts] = *part;
  *box                        = ++release->cuts;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A whole box as a part. */
static MpmPart WholePart(MpmRelease release, PetscInt feature, PetscInt i, PetscInt j)
{
  const MpmReleaseLattice *lattice = &release->lattice;
  MpmPart                  part    = {.area = lattice->spacing[0] * lattice->spacing[1]};

  part.moment[0] = part.area * (lattice->lower[0] + ((PetscReal)i + 0.5) * lattice->spacing[0]);
  part.moment[1] = part.area * (lattice->lower[1] + ((PetscReal)j + 0.5) * lattice->spacing[1]);
  part.volume    = MpmReleaseWhole(release, feature, i, j);
  return part;
}

/* Adds to a box the part of a feature in it. */
static PetscErrorCode AddTo(MpmRelease release, const MpmPart *part, PetscInt *box)
{
  const PetscReal full = release->lattice.spacing[0] * release->lattice.spacing[1];

  PetscFunctionBeginUser;
  if (!(part->area > WHOLE * full)) PetscFunctionReturn(PETSC_SUCCESS);
  if (*box < 0) release->overlap = PETSC_TRUE;
  else if (!*box) PetscCall(AddCut(release, part, box));
  else {
    MpmPart *sum = &release->cut[*box - 1];

    sum->area += part->area;
    sum->volume += part->volume;
    for (PetscInt a = 0; a < 2; a++) sum->moment[a] += part->moment[a];
    if (sum->area > (1. + 1e-9) * full) release->overlap = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Column of boxes that holds a place; -1 and the count beside the lattice. */
static PetscInt Column(const MpmReleaseLattice *lattice, PetscReal x)
{
  return (PetscInt)PetscClipInterval(PetscFloorReal((x - lattice->lower[0]) / lattice->spacing[0]), -1.,
                                     (PetscReal)lattice->count[0]);
}

/*
  Columns of a row of boxes that edges of the strip pass through get 1; change[i] turns from outside to inside, or back,
  before column i.
*/
static void MarkEdges(const MpmReleaseLattice *lattice, const MpmRings *strip, const PetscReal ends[2], char mark[],
                      char change[])
{
  const PetscReal middle = 0.5 * (ends[0] + ends[1]);

  for (PetscInt k = 0; k < strip->rings; k++) {
    const PetscInt   count = strip->start[k + 1] - strip->start[k];
    const PetscReal *at    = &strip->at[2 * strip->start[k]];

    for (PetscInt i = 0; i < count; i++) {
      const PetscReal *a = &at[2 * i], *b = &at[2 * (i + 1 < count ? i + 1 : 0)];
      const PetscInt   from = Column(lattice, PetscMin(a[0], b[0])), to = Column(lattice, PetscMax(a[0], b[0]));

      if (a[1] == b[1] && (a[1] == ends[0] || a[1] == ends[1])) continue;
      for (PetscInt c = PetscMax(from, 0); c <= PetscMin(to, lattice->count[0] - 1); c++) mark[c] = 1;
      if ((a[1] > middle) == (b[1] > middle)) continue;
      change[1 + Column(lattice, a[0] + (middle - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))] ^= 1;
    }
  }
}

/* Room of a row. */
typedef struct {
  MpmRings strip, spare[2];
  char    *mark, *change;
} Row;

/* Parts of a feature in a row of boxes. */
static PetscErrorCode SortRow(MpmRelease release, PetscInt feature, PetscInt j, Row *row)
{
  const MpmReleaseLattice *lattice = &release->lattice;
  const PetscReal          low     = lattice->lower[1] + (PetscReal)j * lattice->spacing[1];
  const PetscReal          ends[2] = {low, low + lattice->spacing[1]};
  char                     inside  = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmRingsCut(&release->rings[feature], 1, ends[0], ends[1], &row->strip));
  if (!row->strip.rings) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMemzero(row->mark, (size_t)lattice->count[0]));
  PetscCall(PetscMemzero(row->change, (size_t)lattice->count[0] + 2));
  MarkEdges(lattice, &row->strip, ends, row->mark, row->change);
  for (PetscInt i = 0; i < lattice->count[0]; i++) {
    const PetscReal left     = lattice->lower[0] + (PetscReal)i * lattice->spacing[0];
    const PetscReal lower[2] = {left, ends[0]}, upper[2] = {left + lattice->spacing[0], ends[1]};
    PetscInt       *box  = Box(release, i, j);
    MpmPart         part = {.area = 0.};

    inside ^= row->change[i];
    if (!row->mark[i] && inside && *box) release->overlap = PETSC_TRUE;
    if (!row->mark[i] && inside) *box = -1 - feature;
    if (!row->mark[i]) continue;
    PetscCall(MpmPartAdd(&row->strip, lower, upper, &release->depth.map,
                         release->depth.number ? release->depth.number[feature] : 0., row->spare, &part));
    PetscCall(AddTo(release, &part, box));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- small parts ---- */

/* Part of a box that is filled. */
static PetscReal Filled(MpmRelease release, PetscInt i, PetscInt j)
{
  PetscInt box;

  if (i < 0 || i >= release->lattice.count[0] || j < release->kept[0] || j >= release->kept[1]) return 0.;
  box = *Box(release, i, j);
  if (box < 0) return 1.;
  return box ? release->cut[box - 1].area / (release->lattice.spacing[0] * release->lattice.spacing[1]) : 0.;
}

/* A box that gives its part to another one. */
typedef struct {
  PetscInt from, to[2];
} Gift;

/* The fullest box beside one; false where none has a point. */
static PetscBool FindTaker(MpmRelease release, PetscInt i, PetscInt j, PetscInt to[2])
{
  PetscReal most = 0.;

  for (PetscInt k = 0; k < 9; k++) {
    const PetscInt  a = i + k % 3 - 1, b = j + k / 3 - 1;
    const PetscReal filled = k == 4 ? 0. : Filled(release, a, b);

    if (filled < LEAST || filled <= most * (1. + WHOLE)) continue;
    most  = filled;
    to[0] = a;
    to[1] = b;
  }
  return (PetscBool)(most > 0.);
}

/* Boxes that are hardly filled give what they have; all choices are made before any gift. */
static PetscErrorCode GiveSmall(MpmRelease release)
{
  Gift    *gift;
  PetscInt gifts = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(PetscMax(release->cuts, 1), &gift));
  for (PetscInt j = PetscMax(release->rows[0] - 1, release->kept[0]);
       j < PetscMin(release->rows[1] + 1, release->kept[1]); j++)
    for (PetscInt i = 0; i < release->lattice.count[0]; i++)
      if (*Box(release, i, j) > 0 && Filled(release, i, j) < LEAST && FindTaker(release, i, j, gift[gifts].to)) {
        gift[gifts].from = *Box(release, i, j) - 1;
        gifts++;
      }
  for (PetscInt k = 0; k < gifts; k++) {
    PetscInt *box = Box(release, gift[k].to[0], gift[k].to[1]);
    MpmPart   whole;

    if (*box < 0) {
      whole = WholePart(release, -1 - *box, gift[k].to[0], gift[k].to[1]);
      PetscCall(AddCut(release, &whole, box));
    }
    release->cut[*box - 1].area += release->cut[gift[k].from].area;
    release->cut[*box - 1].volume += release->cut[gift[k].from].volume;
    for (PetscInt a = 0; a < 2; a++) release->cut[*box - 1].moment[a] += release->cut[gift[k].from].moment[a];
    release->cut[gift[k].from] = (MpmPart){.area = 0.};
  }
  PetscCall(PetscFree(gift));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all ---- */

PetscErrorCode MpmReleaseForget(MpmRelease release)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(release->across.begin, release->across.pixel, release->across.weight, release->across.row));
  PetscCall(PetscFree(release->box));
  PetscCall(PetscFree(release->cut));
  release->cuts = release->room = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReleaseSort(MpmRelease release)
{
  const MpmReleaseLattice *lattice = &release->lattice;
  const PetscMPIInt        rank = release->grid->rank, size = release->grid->size;
  Row                      row = {.mark = NULL};

  PetscFunctionBeginUser;
  PetscCall(MpmReleaseForget(release));
  release->rows[0] = (PetscInt)((PetscInt64)lattice->count[1] * rank / size);
  release->rows[1] = (PetscInt)((PetscInt64)lattice->count[1] * (rank + 1) / size);
  release->kept[0] = PetscMax(release->rows[0] - 2, 0);
  release->kept[1] = PetscMin(release->rows[1] + 2, lattice->count[1]);
  PetscCall(PetscCalloc1((size_t)(release->kept[1] - release->kept[0]) * (size_t)lattice->count[0], &release->box));
  PetscCall(PetscMalloc2(lattice->count[0], &row.mark, lattice->count[0] + 2, &row.change));
  PetscCall(FindWeights(release));
  for (PetscInt f = 0; f < release->features; f++)
    for (PetscInt j = release->kept[0]; j < release->kept[1]; j++) PetscCall(SortRow(release, f, j, &row));
  PetscCall(GiveSmall(release));
  PetscCall(PetscFree2(row.mark, row.change));
  PetscCall(MpmRingsDestroy(&row.strip));
  for (PetscInt k = 0; k < 2; k++) PetscCall(MpmRingsDestroy(&row.spare[k]));
  PetscCall(MpmReleaseSum(release));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReleaseSum(MpmRelease release)
{
  PetscInt64      cursor = 0;
  PetscReal       beyond = 0.; /* rounding of the sum */
  MpmReleasePoint point;

  PetscFunctionBeginUser;
  release->count = 0;
  release->sum   = 0.;
  for (; MpmReleaseNext(release, &cursor, &point); release->count++) { /* Kahan (1965), doi:10.1145/363707.363723 */
    const PetscReal volume = point.volume - beyond, sum = release->sum + volume;

    beyond       = (sum - release->sum) - volume;
    release->sum = sum;
  }
  PetscCall(MPIU_Allreduce(&release->count, &release->total, 1, MPIU_INT64, MPI_SUM, release->grid->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &release->sum, 1, MPIU_REAL, MPIU_SUM, release->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
