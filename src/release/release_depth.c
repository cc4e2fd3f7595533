/*
  Depths of a release.
*/
#include "options/options.h"
#include "release/release_depth.h"

/* Pixels about the grid. */
static PetscErrorCode ReadMap(const MpmOptions *block, const char name[], const char path[], const MpmGrid *grid,
                              const MpmBed *bed, MpmMap *map)
{
  const MpmMapAsk ask                      = {.project = bed->project,
                                              .lower   = grid->lower,
                                              .upper   = grid->upper,
                                              .origin  = {bed->map.origin[0], bed->map.origin[1]}};
  char            message[MPM_MAP_MESSAGE] = "";

  PetscFunctionBeginUser;
  PetscCall(MpmMapRead(path, &ask, map, message));
  MpmCheckInput(!message[0], "-%s%s %s: %s", block->prefix, name, path, message);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A map without negative values; pixels without data are kept, or have no depth. */
static PetscErrorCode CheckMap(const MpmOptions *block, const char name[], PetscBool keep, MpmMap *map)
{
  PetscFunctionBeginUser;
  for (PetscInt64 k = 0; k < (PetscInt64)map->columns * map->rows; k++) {
    if (PetscIsNanReal(map->value[k]) && !keep) map->value[k] = 0.;
    MpmCheckInput(!(map->value[k] < 0.), "-%s%s: is %g at (%.10g, %.10g), must be >= 0", block->prefix, name,
                  (double)map->value[k], (double)(map->x0 + (PetscReal)(k % map->columns) * map->cell[0]),
                  (double)(map->y0 + (PetscReal)(k / map->columns) * map->cell[1]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An attribute of the outline's features; `found` where the first one has it. */
static PetscErrorCode TakeAttribute(const MpmOptions *block, const char name[], const MpmOutline *outline,
                                    MpmReleaseDepth *depth, PetscBool *found)
{
  PetscFunctionBeginUser;
  *found = PETSC_FALSE;
  for (PetscInt f = 0; outline && f < outline->features; f++) {
    const PetscBool number = MpmOutlineNumber(outline, f, name, &depth->number[f]);

    *found = (PetscBool)(*found || MpmOutlineText(outline, f, name) != NULL);
    MpmCheckInput(!*found || (number && depth->number[f] >= 0.),
                  "-%sdepth %s: feature %" PetscInt_FMT " of the outline has %s for it, must be a number >= 0",
                  block->prefix, name, f + 1,
                  MpmOutlineText(outline, f, name) ? MpmOutlineText(outline, f, name) : "nothing");
    if (!*found) break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A number, an attribute, or a map. */
static PetscErrorCode TakeDepth(const MpmOptions *block, const MpmGrid *grid, const MpmBed *bed,
                                const MpmOutline *outline, char text[], MpmReleaseDepth *depth)
{
  const PetscInt features = outline ? outline->features : 1;
  PetscReal      number;
  PetscBool      found;
  char          *end, *path;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(features, &depth->number));
  number = strtod(text, &end);
  if (end != text && !*end) {
    MpmCheckInput(number > 0. && !PetscIsInfOrNanReal(number), "-%sdepth %s: must be > 0", block->prefix, text);
    MpmCheckInput(outline, "-%soutline is missing: a depth that is a number needs one", block->prefix);
    for (PetscInt f = 0; f < features; f++) depth->number[f] = number;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TakeAttribute(block, text, outline, depth, &found));
  if (found) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrallocpy(text, &path));
  PetscCall(MpmOptionsResolve(block, "depth", &path));
  PetscCall(ReadMap(block, "depth", path, grid, bed, &depth->map));
  PetscCall(PetscFree(path));
  PetscCall(CheckMap(block, "depth", (PetscBool)(outline != NULL), &depth->map));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A share of the bed's height; that of a plane is bilinear between the grid's corners. */
static PetscErrorCode TakeShare(const MpmGrid *grid, const MpmBed *bed, PetscReal fraction, MpmReleaseDepth *depth)
{
  MpmMap *map = &depth->map;

  PetscFunctionBeginUser;
  if (bed->map.value) PetscCall(MpmMapLike(&bed->map, map));
  else
    *map = (MpmMap){.columns = 2,
                    .rows    = 2,
                    .x0      = grid->lower[0],
                    .y0      = grid->lower[1],
                    .cell    = {grid->upper[0] - grid->lower[0], grid->upper[1] - grid->lower[1]}};
  PetscCall(PetscMalloc1((size_t)map->columns * (size_t)map->rows, &map->value));
  for (PetscInt64 k = 0; k < (PetscInt64)map->columns * map->rows; k++) {
    const PetscReal x[] = {map->x0 + (PetscReal)(k % map->columns) * map->cell[0],
                           map->y0 + (PetscReal)(k / map->columns) * map->cell[1]};

    map->value[k] = fraction * (bed->map.value ? bed->map.value[k] : MpmBedHeight(bed, x));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The surface before less that after, on the pixels of the first, where it went down. */
static PetscErrorCode TakeDifference(const MpmOptions *block, const MpmGrid *grid, const MpmBed *bed, PetscBool keep,
                                     const char before[], const char after[], MpmReleaseDepth *depth)
{
  MpmMap *map = &depth->map, lower = {0};

  PetscFunctionBeginUser;
  PetscCall(ReadMap(block, "before", before, grid, bed, map));
  PetscCall(ReadMap(block, "after", after, grid, bed, &lower));
  for (PetscInt64 k = 0; k < (PetscInt64)map->columns * map->rows; k++) {
    const PetscReal x[]  = {map->x0 + (PetscReal)(k % map->columns) * map->cell[0],
                            map->y0 + (PetscReal)(k / map->columns) * map->cell[1]};
    const PetscReal lost = map->value[k] - MpmMapAt(&lower, x);

    map->value[k] = PetscIsNanReal(lost) ? lost : PetscMax(lost, 0.);
  }
  PetscCall(MpmMapDestroy(&lower));
  PetscCall(CheckMap(block, "before", keep, map));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReleaseDepthRead(const MpmOptions *block, const MpmGrid *grid, const MpmBed *bed,
                                   const MpmOutline *outline, MpmReleaseDepth *depth)
{
  PetscReal fraction = 0.;
  PetscBool share;
  char     *text = NULL, *before, *after;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsReal(block, "fraction", "-",
                           "instead of the depth, with region raster: share of the bed's height", MPM_RANGE_POSITIVE,
                           MPM_OPTIONAL, &fraction, &share));
  PetscCall(MpmOptionsPath(block, "before",
                           "instead of the depth, with region raster: map of the surface before the release, m",
                           MPM_OPTIONAL, &before));
  PetscCall(MpmOptionsPath(block, "after", "and of that after it, m", MPM_OPTIONAL, &after));
  if (!MpmOptionsHelp()) {
    PetscCall(MpmOptionsText(block, "depth", "vertical depth, m: a number, a map, or an attribute of the outline", NULL,
                             MPM_OPTIONAL, &text));
    MpmCheckInput(!before == !after, "-%s%s is missing: the depth is -%sbefore less -%safter", block->prefix,
                  before ? "after" : "before", block->prefix, block->prefix);
    MpmCheckInput((text != NULL) + share + (before != NULL) == 1,
                  "-%sdepth %s: one of depth, fraction, and before with after must be there", block->prefix,
                  text ? text : "is missing");
    if (text) PetscCall(TakeDepth(block, grid, bed, outline, text, depth));
    else if (share) PetscCall(TakeShare(grid, bed, fraction, depth));
    else PetscCall(TakeDifference(block, grid, bed, (PetscBool)(outline != NULL), before, after, depth));
  }
  PetscCall(PetscFree(text));
  PetscCall(PetscFree(before));
  PetscCall(PetscFree(after));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReleaseDepthDestroy(MpmReleaseDepth *depth)
{
  PetscFunctionBeginUser;
  PetscCall(MpmMapDestroy(&depth->map));
  PetscCall(PetscFree(depth->number));
  PetscFunctionReturn(PETSC_SUCCESS);
}
