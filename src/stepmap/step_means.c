/*
  Means over cells in a step's derivatives.
*/
#include "grid/grid.h"
#include "stepmap/step_means.h"

/* ---- batches ---- */

static PetscBool ByCell(const MpmStepMap *map)
{
  return (PetscBool)(map->sum->layout->means && !map->sum->space->cells.spread);
}

PetscInt MpmBatchCount(const MpmStepMap *map)
{
  return ByCell(map) ? map->sum->space->cells.count : 1;
}

MpmBatch MpmBatchAt(const MpmStepMap *map, PetscInt b)
{
  const MpmSpace *space = map->sum->space;
  const MpmCell  *cell  = &space->cells.at[b];

  if (!ByCell(map)) return (MpmBatch){0, space->group_count, 0};
  return (MpmBatch){cell->group_begin, cell->group_end, MpmCellBegin(map->sum, cell)};
}

PetscInt MpmBatchMost(const MpmStepMap *map)
{
  const MpmSpace *space = map->sum->space;
  PetscInt        most  = 0;

  if (!ByCell(map)) return space->point_count;
  for (PetscInt c = 0; c < space->cells.count; c++)
    most = PetscMax(most, MpmCellEnd(map->sum, &space->cells.at[c]) - MpmCellBegin(map->sum, &space->cells.at[c]));
  return most;
}

/* ---- sums ---- */

PetscErrorCode MpmMeansCreate(const MpmStepMap *map, PetscInt width, PetscInt first, PetscInt second, MpmMeans *means)
{
  const PetscBool spread = (PetscBool)(map->sum->space->cells.spread != NULL);
  const PetscInt  most   = spread ? MPM_SPREAD_MOST : 1;

  PetscFunctionBeginUser;
  *means = (MpmMeans){.map    = map,
                      .spread = spread,
                      .width  = width,
                      .size   = {(1 + first) * width, second * width},
                      .cells  = spread ? map->sum->space->local : 1};
  PetscCall(PetscCalloc5((means->cells * means->size[0] + 1), &means->sums[0], (means->cells * means->size[1] + 1),
                         &means->sums[1], most, &means->at.node, (most * width), &means->at.share, most,
                         &means->by_share));
  if (spread) PetscCall(PetscNew(&means->found));
  means->at.count    = 1;
  means->at.share[0] = 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMeansDestroy(MpmMeans *means)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree5(means->sums[0], means->sums[1], means->at.node, means->at.share, means->by_share));
  PetscCall(PetscFree(means->found));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMeansBegin(MpmMeans *means)
{
  PetscFunctionBeginUser;
  for (int kind = 0; kind < 2; kind++) PetscCall(PetscArrayzero(means->sums[kind], means->cells * means->size[kind]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds the product of two rows. */
static inline void AddProduct(PetscInt width, const PetscReal a[], const PetscReal b[], PetscReal sum[])
{
  sum[0] += a[0] * b[0];
  for (PetscInt j = 1; j < width; j++) sum[j] += a[j] * b[0] + a[0] * b[j];
}

void MpmMeansAddFirst(MpmMeans *means, const PetscReal volume[], const PetscReal rows[])
{
  const PetscInt width = means->width, size = means->size[0];

  for (PetscInt c = 0; c < means->at.count; c++) {
    PetscReal *sums = &means->sums[0][means->at.node[c] * size], part[1 + MPM_PACK] = {0.};

    AddProduct(width, &means->at.share[c * width], volume, part);
    for (PetscInt j = 0; j < width; j++) sums[j] += part[j];
    for (PetscInt k = width; k < size; k += width) AddProduct(width, part, &rows[k - width], &sums[k]);
  }
}

void MpmMeansAddSecond(MpmMeans *means, const PetscReal rows[])
{
  const PetscInt width = means->width, size = means->size[1];

  for (PetscInt c = 0; c < means->at.count; c++)
    for (PetscInt k = 0; k < size; k += width)
      AddProduct(width, &means->at.share[c * width], &rows[k], &means->sums[1][means->at.node[c] * size + k]);
}

PetscErrorCode MpmMeansClose(MpmMeans *means, int kind)
{
  const PetscInt width = means->width, size = means->size[kind];

  PetscFunctionBeginUser;
  if (means->spread) PetscCall(MpmSpreadSum(means->map->sum->space, size, means->sums[kind]));
  for (PetscInt c = 0; c < means->cells; c++) {
    const PetscReal *volume = &means->sums[0][c * means->size[0]];
    PetscReal       *sums   = &means->sums[kind][c * size];

    if (!(volume[0] > 0.)) continue;
    for (PetscInt k = kind ? 0 : width; k < size; k += width) {
      sums[k] /= volume[0];
      for (PetscInt j = 1; j < width; j++) sums[k + j] = (sums[k + j] - sums[k] * volume[j]) / volume[0];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmMeansAt(const MpmMeans *means, int kind, PetscInt k, PetscReal row[])
{
  const PetscInt width = means->width, at = (kind ? k : k + 1) * width;

  for (PetscInt j = 0; j < width; j++) row[j] = 0.;
  for (PetscInt c = 0; c < means->at.count; c++)
    AddProduct(width, &means->at.share[c * width], &means->sums[kind][means->at.node[c] * means->size[kind] + at], row);
}

/* ---- shares ---- */

/* Parts of a point's domain by axis and cell, and their derivatives by place, 1/m, and half-length, 1/cell. */
typedef struct {
  PetscInt  count[MPM_MAX_DIM];
  PetscReal part[MPM_MAX_DIM][MPM_MAX_WIDTH], slope[MPM_MAX_DIM][MPM_MAX_WIDTH][MPM_BY_COUNT];
} Parts;

static void FindParts(const MpmStepMap *map, PetscInt p, Parts *parts)
{
  const MpmSpread *spread = map->sum->space->cells.spread;
  const MpmGrid   *grid   = map->sum->grid;
  const PetscInt   dim    = map->sum->space->dim;

  parts->count[2]   = 1;
  parts->part[2][0] = 1.;
  for (PetscInt a = 0; a < dim; a++) {
    const PetscInt  k = p * dim + a, low = spread->first[k], high = low + spread->count[k] - 1;
    const PetscReal xi = (map->sum->points->x[k] - grid->lower[a]) / grid->h[a], half = map->sum->space->shapes.half[k];

    parts->count[a] = spread->count[k];
    for (PetscInt c = low; c <= high; c++) {
      parts->part[a][c - low] = MpmShapePart(c, low, high, xi, half, parts->slope[a][c - low]);
      parts->slope[a][c - low][MPM_BY_PLACE] /= grid->h[a];
    }
  }
}

/* The derivative of share k by place or half-length on one axis. */
static PetscReal ShareSlope(const Parts *parts, PetscInt dim, PetscInt k, PetscInt axis, PetscInt kind)
{
  PetscReal product = 1.;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscInt c = k % parts->count[a];

    k /= parts->count[a];
    product *= a == axis ? parts->slope[a][c][kind] : parts->part[a][c];
  }
  return product;
}

void MpmMeansEnter(MpmMeans *means, const MpmGroup *group, PetscInt p, const PetscReal argument[])
{
  const PetscInt dim = means->map->sum->space->dim, width = means->width;
  MpmMeanCells  *at = &means->at;
  Parts          parts;

  if (!means->spread) return;
  MpmSpreadFindCells(means->map->sum->space, group, p, means->found);
  if (argument) FindParts(means->map, p, &parts);
  at->count = means->found->count;
  for (PetscInt c = 0; c < at->count; c++) {
    PetscReal *row = &at->share[c * width];

    at->node[c] = means->found->node[c];
    row[0]      = means->found->share[c];
    for (PetscInt j = 1; j < width; j++) row[j] = 0.;
    for (PetscInt k = 0; argument && k < MPM_BY_COUNT * dim; k++)
      MpmPackAdd(ShareSlope(&parts, dim, c, k % dim, k / dim), &argument[k * MPM_PACK], &row[1]);
  }
}

void MpmMeansPullShares(const MpmMeans *means, PetscInt p, const PetscReal by_share[], PetscReal x[], PetscReal half[])
{
  const PetscInt dim = means->map->sum->space->dim;
  Parts          parts;

  if (!means->spread) return;
  FindParts(means->map, p, &parts);
  for (PetscInt c = 0; c < means->at.count; c++) {
    for (PetscInt a = 0; a < dim; a++) {
      x[a] += by_share[c] * ShareSlope(&parts, dim, c, a, MPM_BY_PLACE);
      half[a] += by_share[c] * ShareSlope(&parts, dim, c, a, MPM_BY_LENGTH);
    }
  }
}
