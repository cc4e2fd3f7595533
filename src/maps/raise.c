/*
  Dams on a bed, raised on its pixels before anything flows.

  A line with the height H above the ground, the width c of its crest and the batter n (run over rise) raises the bed to

    z = max(Z, Z_0 + H - max(0, d - c/2)/n) ,

  d the distance from the nearest place of the line and Z_0 the former bed there; `level` gives Z_0 + H instead. A map
  of heights is added to the bed.
*/
#include "options/options.h"
#include "maps/outline.h"
#include "maps/raise.h"

#define ROUNDING 1e-6 /* m: less is no height at a dam's foot */

/* Form of a dam, m, -. */
typedef struct {
  PetscReal height, level, crest, batter;
  PetscBool to_level;
} Dam;

/* The nearest place of all lines and edges; returns its distance. */
static PetscReal Nearest(const MpmOutline *lines, const PetscReal x[], PetscReal place[])
{
  PetscReal least = PETSC_INFINITY;

  for (PetscInt f = 0; f < lines->features; f++) {
    const PetscBool closed = (PetscBool)(lines->feature[f].type == MPM_OUTLINE_POLYGON);

    for (PetscInt k = lines->feature[f].first; k < lines->feature[f].end; k++) {
      const PetscInt   count = lines->start[k + 1] - lines->start[k];
      const PetscReal *at    = &lines->at[2 * lines->start[k]];

      for (PetscInt i = 0; i < (closed ? count : count - 1); i++) {
        const PetscReal *a = &at[2 * i], *b = &at[2 * ((i + 1) % count)], e[2] = {b[0] - a[0], b[1] - a[1]};
        const PetscReal  square = e[0] * e[0] + e[1] * e[1];
        const PetscReal  part   = (x[0] - a[0]) * e[0] + (x[1] - a[1]) * e[1];
        const PetscReal  along  = square > 0. ? PetscClipInterval(part / square, 0., 1.) : 0.;
        const PetscReal  to[2]  = {a[0] + along * e[0], a[1] + along * e[1]};
        const PetscReal  far    = PetscSqrtReal(PetscSqr(x[0] - to[0]) + PetscSqr(x[1] - to[1]));

        if (far >= least) continue;
        least    = far;
        place[0] = to[0];
        place[1] = to[1];
      }
    }
  }
  return least;
}

/* Greatest distance from the lines at which a dam raises any pixel. */
static PetscReal Reach(const MpmMap *map, const Dam *dam)
{
  PetscReal least = PETSC_INFINITY, most = PETSC_NINFINITY;

  for (PetscInt64 k = 0; k < (PetscInt64)map->columns * map->rows; k++) {
    if (PetscIsNanReal(map->value[k])) continue;
    least = PetscMin(least, map->value[k]);
    most  = PetscMax(most, map->value[k]);
  }
  return 0.5 * dam->crest + dam->batter * PetscMax((dam->to_level ? dam->level : most + dam->height) - least, 0.);
}

/* The pixels near the lines; heights of the ground at the lines are those before. */
static PetscErrorCode RaiseByLines(const MpmOutline *lines, const Dam *dam, MpmMap *map)
{
  const PetscReal reach = Reach(map, dam);
  MpmMap          raised;
  PetscReal       lower[2], upper[2];

  PetscFunctionBeginUser;
  MpmOutlineBounds(lines, lower, upper);
  PetscCall(MpmMapLike(map, &raised));
  PetscCall(PetscMalloc1((size_t)map->columns * (size_t)map->rows, &raised.value));
  PetscCall(PetscArraycpy(raised.value, map->value, (size_t)map->columns * (size_t)map->rows));
  for (PetscInt64 k = 0; k < (PetscInt64)map->columns * map->rows; k++) {
    const PetscReal x[] = {map->x0 + (PetscReal)(k % map->columns) * map->cell[0],
                           map->y0 + (PetscReal)(k / map->columns) * map->cell[1]};
    PetscReal       place[2], beyond, top;

    if (x[0] < lower[0] - reach || x[0] > upper[0] + reach || x[1] < lower[1] - reach || x[1] > upper[1] + reach)
      continue;
    beyond = Nearest(lines, x, place) - 0.5 * dam->crest;
    top    = dam->to_level ? dam->level : MpmMapAt(map, place) + dam->height;
    if (beyond > 0.) top = dam->batter > 0. ? top - beyond / dam->batter : PETSC_NINFINITY;
    if (top > raised.value[k]) raised.value[k] = top;
  }
  PetscCall(PetscFree(map->value));
  map->value   = raised.value;
  raised.value = NULL;
  PetscCall(MpmMapDestroy(&raised));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a map of heights, where it has data. */
static PetscErrorCode RaiseByMap(const MpmOptions *block, const char path[], MpmBed *bed)
{
  MpmMap         *map = &bed->map, heights = {0};
  const MpmMapAsk ask                      = {.project = bed->project, .origin = {map->origin[0], map->origin[1]}};
  char            message[MPM_MAP_MESSAGE] = "";

  PetscFunctionBeginUser;
  PetscCall(MpmMapRead(path, &ask, &heights, message));
  MpmCheckInput(!message[0], "-%sfile %s: %s; a line needs a height or a level", block->prefix, path, message);
  for (PetscInt64 k = 0; k < (PetscInt64)map->columns * map->rows; k++) {
    const PetscReal x[] = {map->x0 + (PetscReal)(k % map->columns) * map->cell[0],
                           map->y0 + (PetscReal)(k / map->columns) * map->cell[1]};
    const PetscReal u = (x[0] - heights.x0) / heights.cell[0], v = (x[1] - heights.y0) / heights.cell[1];
    PetscReal       height;

    if (u < -0.5 || v < -0.5 || u > (PetscReal)heights.columns - 0.5 || v > (PetscReal)heights.rows - 0.5) continue;
    height = MpmMapAt(&heights, x);
    if (!PetscIsNanReal(height)) map->value[k] += height;
  }
  PetscCall(MpmMapDestroy(&heights));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadLines(const MpmOptions *block, const char path[], const MpmBed *bed, MpmOutline *lines)
{
  const MpmOutlineAsk ask = {bed->project, bed->map.system, {bed->map.origin[0], bed->map.origin[1]}};
  char                message[MPM_MAP_MESSAGE] = "";

  PetscFunctionBeginUser;
  PetscCall(MpmOutlineRead(path, &ask, lines, message));
  MpmCheckInput(!message[0], "-%sfile %s: %s", block->prefix, path, message);
  for (PetscInt f = 0; f < lines->features; f++)
    MpmCheckInput(lines->feature[f].type != MPM_OUTLINE_POINT, "-%sfile %s: feature %" PetscInt_FMT " is no line",
                  block->prefix, path, f + 1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadDam(const MpmOptions *options, const char name[], MpmBed *bed)
{
  char       prefix[256], *path;
  MpmOptions block = {options->comm, prefix, options->record};
  MpmOutline lines = {0};
  Dam        dam   = {.batter = 1.};
  PetscBool  high;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_raise_%s_", name));
  PetscCall(MpmOptionsPath(&block, "file", "line of a dam's crest: GeoJSON and others; or a map of heights to be added",
                           MPM_REQUIRED, &path));
  PetscCall(MpmOptionsReal(&block, "height", "m", "of the crest above the ground at its line", MPM_RANGE_POSITIVE,
                           MPM_OPTIONAL, &dam.height, &high));
  PetscCall(MpmOptionsReal(&block, "level", "m", "height of the crest, instead", MPM_RANGE_ANY, MPM_OPTIONAL,
                           &dam.level, &dam.to_level));
  PetscCall(
    MpmOptionsReal(&block, "crest", "m", "width of the crest", MPM_RANGE_NON_NEGATIVE, MPM_OPTIONAL, &dam.crest, NULL));
  PetscCall(MpmOptionsReal(&block, "batter", "-", "run over rise of the dam's sides", MPM_RANGE_NON_NEGATIVE,
                           MPM_OPTIONAL, &dam.batter, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(PetscFree(path));
  MpmCheckInput(!high || !dam.to_level, "-%slevel: the height is given, too", prefix);
  if (high || dam.to_level) {
    PetscCall(ReadLines(&block, path, bed, &lines));
    PetscCall(RaiseByLines(&lines, &dam, &bed->map));
    PetscCall(MpmOutlineDestroy(&lines));
  } else PetscCall(RaiseByMap(&block, path, bed));
  PetscCall(PetscFree(path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pixels which a dam has raised, and those beside them, where there are any: [first, end) of columns and rows. */
static void Window(const MpmMap *map, const PetscReal before[], PetscInt first[2], PetscInt end[2])
{
  first[0] = map->columns;
  first[1] = map->rows;
  end[0] = end[1] = 0;
  for (PetscInt64 k = 0; k < (PetscInt64)map->columns * map->rows; k++) {
    const PetscInt at[] = {(PetscInt)(k % map->columns), (PetscInt)(k / map->columns)};

    for (PetscInt a = 0; PetscAbsReal(map->value[k] - before[k]) > ROUNDING && a < 2; a++) {
      first[a] = PetscMin(first[a], PetscMax(at[a] - 1, 0));
      end[a]   = PetscMax(end[a], PetscMin(at[a] + 2, a ? map->rows : map->columns));
    }
  }
}

/* Keeps what a dam has added to the heights before. */
static PetscErrorCode KeepHeight(const char name[], const PetscReal before[], MpmBed *bed)
{
  const MpmMap *map  = &bed->map;
  MpmBedDams   *dams = &bed->dams;
  PetscInt      first[2], end[2];
  MpmMap        height = {.cell = {map->cell[0], map->cell[1]}};

  PetscFunctionBeginUser;
  Window(map, before, first, end);
  if (end[0]) {
    height.columns = end[0] - first[0];
    height.rows    = end[1] - first[1];
    height.x0      = map->x0 + (PetscReal)first[0] * map->cell[0];
    height.y0      = map->y0 + (PetscReal)first[1] * map->cell[1];
    PetscCall(PetscMalloc1((size_t)height.columns * (size_t)height.rows, &height.value));
    for (PetscInt64 k = 0; k < (PetscInt64)height.columns * height.rows; k++) {
      const PetscInt64 at = (first[1] + k / height.columns) * map->columns + first[0] + k % height.columns;

      height.value[k] = map->value[at] - before[at];
      if (PetscAbsReal(height.value[k]) <= ROUNDING) height.value[k] = 0.;
    }
  }
  PetscCall(PetscRealloc(sizeof(*dams->name) * (size_t)(dams->count + 1), &dams->name));
  PetscCall(PetscRealloc(sizeof(*dams->height) * (size_t)(dams->count + 1), &dams->height));
  PetscCall(PetscStrallocpy(name, &dams->name[dams->count]));
  dams->height[dams->count++] = height;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBedDamsDestroy(MpmBedDams *dams)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < dams->count; k++) {
    PetscCall(PetscFree(dams->name[k]));
    PetscCall(MpmMapDestroy(&dams->height[k]));
  }
  PetscCall(PetscFree(dams->name));
  PetscCall(PetscFree(dams->height));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBedRaise(const MpmOptions *options, MpmBed *bed)
{
  const MpmOptions terrain = {options->comm, "mpm_terrain_", options->record};
  PetscInt         count;
  char           **names;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsNames(&terrain, "raise", "names of dams, each with a block raise_NAME", MPM_OPTIONAL, &count, &names));
  if (MpmOptionsHelp()) PetscCall(ReadDam(options, "NAME", bed));
  for (PetscInt k = 0; k < (MpmOptionsHelp() ? 0 : count); k++) {
    const size_t pixels = (size_t)bed->map.columns * (size_t)bed->map.rows;
    PetscReal   *before;

    PetscCall(PetscMalloc1(pixels, &before));
    PetscCall(PetscArraycpy(before, bed->map.value, pixels));
    PetscCall(ReadDam(options, names[k], bed));
    PetscCall(KeepHeight(names[k], before, bed));
    PetscCall(PetscFree(before));
  }
  PetscCall(MpmNamesDestroy(count, &names));
  PetscFunctionReturn(PETSC_SUCCESS);
}
