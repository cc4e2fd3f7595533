/*
  Points of material that is released on a bed.
*/
#include "options/options.h"
#include "release/release_impl.h"

#define TRIES 4    /* of the spacing of a given number of points */
#define SLACK 1e-9 /* of volumes */
#define NEAR  1e-3 /* part of that number by which it may be missed */

/* ---- outline ---- */

/* The rectangle that both the map of depths and the grid cover. */
static PetscErrorCode TakeRectangle(const MpmOptions *block, MpmRelease release)
{
  const MpmMap   *map      = &release->depth.map;
  const PetscReal at[2]    = {map->x0, map->y0};
  const PetscInt  count[2] = {map->columns, map->rows};
  PetscReal       lower[2], upper[2];
  MpmOutline      outline = {.features = 1, .paths = 1};
  MpmFeature      feature = {MPM_OUTLINE_POLYGON, 0, 1};
  PetscInt        start[] = {0, 4};

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < 2; a++) {
    lower[a] = PetscMax(at[a] - 0.5 * map->cell[a], release->grid->lower[a]);
    upper[a] = PetscMin(at[a] + ((PetscReal)count[a] - 0.5) * map->cell[a], release->grid->upper[a]);
    MpmCheckInput(lower[a] < upper[a], "-%sdepth: the map lies outside the grid", block->prefix);
  }
  outline.at        = (PetscReal[]){lower[0], lower[1], upper[0], lower[1], upper[0], upper[1], lower[0], upper[1]};
  outline.feature   = &feature;
  outline.start     = start;
  release->features = 1;
  PetscCall(PetscCalloc1(1, &release->rings));
  PetscCall(MpmRingsTake(&outline, 0, release->rings));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The polygons of a file, which must lie in the grid and on the map of depths. */
static PetscErrorCode TakeOutline(const MpmOptions *block, const MpmOutline *outline, MpmRelease release)
{
  const MpmMap *map = &release->depth.map;
  PetscReal     lower[2], upper[2];

  PetscFunctionBeginUser;
  release->features = outline->features;
  PetscCall(PetscCalloc1(outline->features, &release->rings));
  for (PetscInt f = 0; f < outline->features; f++) {
    MpmCheckInput(outline->feature[f].type == MPM_OUTLINE_POLYGON,
                  "-%soutline: feature %" PetscInt_FMT " is no polygon", block->prefix, f + 1);
    PetscCall(MpmRingsTake(outline, f, &release->rings[f]));
  }
  MpmOutlineBounds(outline, lower, upper);
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal slack = MPM_GRID_SLACK * release->grid->h[a], half = 0.5 * map->cell[a] + slack,
                    first = a ? map->y0 : map->x0;
    const PetscReal last  = first + (PetscReal)((a ? map->rows : map->columns) - 1) * map->cell[a];

    MpmCheckInput(lower[a] >= release->grid->lower[a] - slack && upper[a] <= release->grid->upper[a] + slack,
                  "-%soutline: goes from %.10g to %.10g on axis %c, out of the grid, which goes from %.10g to %.10g",
                  block->prefix, (double)lower[a], (double)upper[a], "xy"[a], (double)release -> grid -> lower[a],
                  (double)release -> grid -> upper[a]);
    MpmCheckInput(
      !map->value || (lower[a] >= first - half && upper[a] <= last + half),
      "-%soutline: goes from %.10g to %.10g on axis %c, out of the map of depths, which covers %.10g to %.10g",
      block->prefix, (double)lower[a], (double)upper[a], "xy"[a], (double)(first - half), (double)(last + half));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmReleaseBounds(MpmRelease release, PetscReal lower[2], PetscReal upper[2])
{
  for (PetscInt a = 0; a < 2; a++) {
    lower[a] = PETSC_INFINITY;
    upper[a] = PETSC_NINFINITY;
    for (PetscInt f = 0; f < release->features; f++) {
      const MpmRings *rings = &release->rings[f];

      for (PetscInt v = 0; v < rings->start[rings->rings]; v++) {
        lower[a] = PetscMin(lower[a], rings->at[2 * v + a]);
        upper[a] = PetscMax(upper[a], rings->at[2 * v + a]);
      }
    }
  }
}

/* Area and volume of all features, directly. */
static PetscErrorCode Measure(MpmRelease release, PetscBool rectangle, PetscReal *area)
{
  PetscReal lower[2], upper[2];
  MpmRings  spare[2] = {{0}};
  MpmPart   part     = {.area = 0.};

  PetscFunctionBeginUser;
  MpmReleaseBounds(release, lower, upper);
  if (rectangle) {
    *area = (upper[0] - lower[0]) * (upper[1] - lower[1]);
    PetscCall(MpmReleaseRectangle(&release->depth.map, lower, upper, &release->exact));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt f = 0; f < release->features; f++)
    PetscCall(MpmPartAdd(&release->rings[f], lower, upper, &release->depth.map,
                         release->depth.number ? release->depth.number[f] : 0., spare, &part));
  release->exact = part.volume;
  *area          = part.area;
  for (PetscInt k = 0; k < 2; k++) PetscCall(MpmRingsDestroy(&spare[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- lattice ---- */

/* Boxes in the grid's cells. */
static void LatticeInCells(MpmRelease release, const PetscInt per_cell[])
{
  const MpmGrid *grid = release->grid;
  PetscReal      lower[2], upper[2];

  MpmReleaseBounds(release, lower, upper);
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal spacing = grid->h[a] / (PetscReal)per_cell[a];
    const PetscReal most    = (PetscReal)grid->cells[a] * (PetscReal)per_cell[a];
    const PetscReal first   = PetscClipInterval(PetscFloorReal((lower[a] - grid->lower[a]) / spacing), 0., most);
    const PetscReal last    = PetscClipInterval(PetscCeilReal((upper[a] - grid->lower[a]) / spacing), first, most);

    release->lattice.spacing[a] = spacing;
    release->lattice.lower[a]   = grid->lower[a] + first * spacing;
    release->lattice.count[a]   = (PetscInt)(last - first);
  }
}

/* Boxes that are about square and fill the rectangle about the outline. */
static void LatticeOf(MpmRelease release, PetscReal spacing)
{
  PetscReal lower[2], upper[2];

  MpmReleaseBounds(release, lower, upper);
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal extent = upper[a] - lower[a];

    release->lattice.count[a]   = (PetscInt)PetscMax(PetscFloorReal(extent / spacing + 0.5), 1.);
    release->lattice.spacing[a] = extent / (PetscReal)release->lattice.count[a];
    release->lattice.lower[a]   = lower[a];
  }
}

/* A number of points, about, by the area that each would have. */
static PetscErrorCode SortByNumber(const MpmOptions *block, PetscInt number, PetscReal area, MpmRelease release)
{
  PetscReal  spacing = PetscSqrtReal(area / (PetscReal)number), best = spacing, least = PETSC_INFINITY;
  PetscInt64 total;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < TRIES; k++) {
    LatticeOf(release, spacing);
    PetscCall(MpmReleaseSort(release));
    total = release->total;
    if (PetscAbsReal((PetscReal)(total - number)) < least) {
      least = PetscAbsReal((PetscReal)(total - number));
      best  = spacing;
    }
    if (least <= PetscMax(NEAR * (PetscReal)number, 0.5) || !total) break;
    spacing *= PetscSqrtReal((PetscReal)total / (PetscReal)number);
  }
  if (best != spacing) {
    LatticeOf(release, best);
    PetscCall(MpmReleaseSort(release));
  }
  for (PetscInt a = 0; a < 2; a++)
    MpmCheckInput(release->lattice.spacing[a] <= release->grid->h[a] * (1. + MPM_GRID_SLACK),
                  "-%spoints %" PetscInt_FMT ": are %.3g m apart, more than a cell of %.3g m", block->prefix, number,
                  (double)release->lattice.spacing[a], (double)release->grid->h[a]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- object ---- */

static PetscErrorCode Check(const MpmOptions *block, const MpmBed *bed, MpmRelease release)
{
  PetscInt64      cursor = 0;
  PetscBool       dry    = PETSC_FALSE;
  MpmReleasePoint point;
  int             wrong[2];

  PetscFunctionBeginUser;
  MpmCheckInput(!PetscIsNanReal(release->exact), "-%soutline: lies over pixels without data", block->prefix);
  while (bed->missing && !dry && MpmReleaseNext(release, &cursor, &point)) dry = MpmBedIsMissing(bed, point.x);
  wrong[0] = dry;
  wrong[1] = release->overlap;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, wrong, 2, MPI_INT, MPI_MAX, release->grid->comm));
  MpmCheckInput(!wrong[0], "-%sregion raster: material lies where the terrain has no data", block->prefix);
  MpmCheckInput(!wrong[1], "-%soutline: its features overlap", block->prefix);
  MpmCheckInput(release->exact <= release->sum * (1. + SLACK) && release->exact >= release->sum * (1. - SLACK),
                "-%sfraction: the bed, and so the depth, is below 0 in part of the outline", block->prefix);
  MpmCheckInput(release->total > 0, "-%sregion raster: there is no depth in it", block->prefix);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReleaseCreate(const MpmOptions *block, const MpmGrid *grid, const MpmBed *bed,
                                const MpmOutline *outline, const PetscInt per_cell[], MpmRelease *handle)
{
  static const char *const spreads[] = {"even", "mass", "bed", "depth", NULL};
  MpmRelease               release;
  PetscInt                 number = 0, spread = MPM_SPREAD_EVEN;
  PetscBool                given, steepens;
  PetscReal                area, steep = 10.;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(handle));
  release       = *handle;
  release->grid = grid;
  PetscCall(MpmOptionsInt(block, "points", "with region raster: number of points, about, instead of points_per_cell", 1,
                          PETSC_MAX_INT / 4, MPM_OPTIONAL, &number, &given));
  PetscCall(MpmOptionsWord(block, "spread",
                           "of a number of points: evenly; as parts of equal mass; or denser where the bed or the "
                           "depth is steep",
                           spreads, MPM_OPTIONAL, &spread, NULL));
  PetscCall(MpmOptionsReal(block, "steep", "-",
                           "with spread bed or depth: points are sqrt(1 + (this times the slope)^2) times as dense",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &steep, &steepens));
  PetscCall(MpmReleaseDepthRead(block, grid, bed, outline, &release->depth));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!spread || given, "-%sspread %s: needs the number of points, -%spoints", block->prefix, spreads[spread],
                block->prefix);
  MpmCheckInput(!steepens || spread >= MPM_SPREAD_BED, "-%ssteep: is for -%sspread bed or depth", block->prefix,
                block->prefix);
  if (outline) PetscCall(TakeOutline(block, outline, release));
  else PetscCall(TakeRectangle(block, release));
  PetscCall(Measure(release, (PetscBool)!outline, &area));
  if (given) PetscCall(SortByNumber(block, number, area, release));
  else {
    LatticeInCells(release, per_cell);
    PetscCall(MpmReleaseSort(release));
  }
  if (spread && release->total) PetscCall(MpmReleaseDivide(release, bed, number, (MpmReleaseSpread)spread, steep));
  PetscCall(Check(block, bed, release));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReleaseDestroy(MpmRelease *handle)
{
  MpmRelease release = *handle;

  PetscFunctionBeginUser;
  if (!release) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmReleaseForget(release));
  PetscCall(PetscFree(release->parts.point));
  for (PetscInt f = 0; f < release->features; f++) PetscCall(MpmRingsDestroy(&release->rings[f]));
  PetscCall(PetscFree(release->rings));
  PetscCall(MpmReleaseDepthDestroy(&release->depth));
  PetscCall(PetscFree(*handle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmReleaseCount(MpmRelease release)
{
  return (PetscInt)release->count;
}

PetscInt64 MpmReleaseTotal(MpmRelease release)
{
  return release->total;
}

PetscReal MpmReleaseSpacing(MpmRelease release)
{
  PetscReal most = 0.;

  for (PetscInt a = 0; a < 2; a++) most = PetscMax(most, release->lattice.spacing[a] / release->grid->h[a]);
  return most;
}

PetscBool MpmReleaseNext(MpmRelease release, PetscInt64 *cursor, MpmReleasePoint *point)
{
  const MpmReleaseLattice *lattice = &release->lattice;
  const PetscInt64         columns = lattice->count[0], end = columns * (release->rows[1] - release->rows[0]);

  if (release->parts.on) {
    if (*cursor >= release->parts.count) return PETSC_FALSE;
    *point = release->parts.point[(*cursor)++];
    return PETSC_TRUE;
  }
  for (; *cursor < end; (*cursor)++) {
    const PetscInt i = (PetscInt)(*cursor % columns), j = release->rows[0] + (PetscInt)(*cursor / columns);
    const PetscInt box   = release->box[(PetscInt64)(j - release->kept[0]) * columns + i];
    const PetscInt at[2] = {i, j};

    if (!box) continue;
    point->area   = box < 0 ? lattice->spacing[0] * lattice->spacing[1] : release->cut[box - 1].area;
    point->volume = box < 0 ? MpmReleaseWhole(release, -1 - box, i, j) : release->cut[box - 1].volume;
    if (!(point->volume > 0.)) continue;
    for (PetscInt a = 0; a < 2; a++) {
      point->half[a] = 0.5 * lattice->spacing[a];
      point->x[a]    = box < 0 ? lattice->lower[a] + ((PetscReal)at[a] + 0.5) * lattice->spacing[a]
                               : release->cut[box - 1].moment[a] / release->cut[box - 1].area;
    }
    (*cursor)++;
    return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

void MpmReleaseVolume(MpmRelease release, PetscReal *exact, PetscReal *points)
{
  *exact  = release->exact;
  *points = release->sum;
}
