/*
  Ground between maps.
*/
#include "options/options.h"
#include "maps/bed.h"
#include "maps/map_layer.h"

#define SAMPLES 6 /* along each axis of a box */

struct _p_MpmMapLayer {
  MpmBed      top, bottom, depth; /* a map, or a level */
  PetscBool   ends, thick;        /* has a bottom; has a depth in its place */
  MpmMapLayer above;              /* whose lower end is the top; or NULL */
};

/* ---- reading ---- */

/* A level or a map in place of a bed; `given` is false where the option is absent. */
static PetscErrorCode ReadSurface(const MpmOptions *block, const char name[], const char help[], MpmBed *surface,
                                  PetscBool *given)
{
  const MpmOptions terrain                  = {block->comm, "mpm_terrain_", block->record};
  const MpmPlane  *plane                    = MpmRecordPlane(block->record);
  MpmMapAsk        ask                      = {.band = 1};
  char             message[MPM_MAP_MESSAGE] = "", *text, *end;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(block, name, help, NULL, MPM_OPTIONAL, &text));
  *given = (PetscBool)(text != NULL);
  if (!text || MpmOptionsHelp()) PetscFunctionReturn(PetscFree(text));
  surface->plane[0] = strtod(text, &end);
  if (end == text || *end) {
    surface->plane[0] = 0.;
    PetscCall(MpmOptionsText(&terrain, "project", "", NULL, MPM_OPTIONAL, &surface->project));
    MpmRecordWindow(block->record, &ask.lower, &ask.upper);
    ask.project = surface->project;
    for (PetscInt a = 0; plane && a < 2; a++) ask.origin[a] = plane->origin[a];
    PetscCall(MpmOptionsResolve(block, name, &text));
    PetscCall(MpmMapRead(text, &ask, &surface->map, message));
    MpmCheckInput(!message[0], "-%s%s %s: %s", block->prefix, name, text, message);
  }
  MpmCheckInput(!PetscIsInfOrNanReal(surface->plane[0]), "-%s%s %s: must be a number or a map", block->prefix, name,
                text);
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The scene's bed as the top. */
static PetscErrorCode ReadBed(const MpmOptions *block, MpmBed *top)
{
  const MpmOptions scene = {block->comm, "mpm_", block->record};
  const PetscReal *lower, *upper;
  PetscBool        map, plane;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(&scene, "terrain_file", &map));
  PetscCall(MpmOptionsHas(&scene, "bed", &plane));
  MpmCheckInput(map || plane, "-%stop is missing: a level, a map, or the scene's -mpm_terrain_file", block->prefix);
  MpmRecordWindow(block->record, &lower, &upper);
  PetscCheck(lower, block->comm, PETSC_ERR_PLIB, "The window of the grid is not known");
  PetscCall(MpmBedRead(&scene, lower, upper, top));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMapLayerRead(const MpmOptions *block, MpmMapLayer *handle)
{
  MpmMapLayer layer;
  PetscBool   top, below;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(handle));
  layer = *handle;
  PetscCall(ReadSurface(block, "top",
                        "region raster in 3D: upper surface of the ground, m: a level, or a map; default "
                        "the scene's terrain",
                        &layer->top, &top));
  PetscCall(ReadSurface(block, "bottom", "and its lower end: a level, or a map; without it and a depth, none",
                        &layer->bottom, &layer->ends));
  PetscCall(ReadSurface(block, "depth", "instead of the bottom: vertical depth below the top, m: a number, or a map",
                        &layer->depth, &layer->thick));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsHas(block, "below", &below));
  MpmCheckInput(!top || !below, "-%stop: must be absent with -%sbelow, which gives the top", block->prefix,
                block->prefix);
  MpmCheckInput(!layer->ends || !layer->thick, "-%sdepth: the bottom is given, too", block->prefix);
  MpmCheckInput(!layer->thick || layer->depth.map.value || layer->depth.plane[0] > 0., "-%sdepth %g: must be > 0",
                block->prefix, (double)layer->depth.plane[0]);
  for (PetscInt64 k = 0; layer->depth.map.value && k < (PetscInt64)layer->depth.map.columns * layer->depth.map.rows;
       k++)
    MpmCheckInput(!(layer->depth.map.value[k] < 0.), "-%sdepth: is %g in a pixel, must be >= 0", block->prefix,
                  (double)layer->depth.map.value[k]);
  if (!top && !below) PetscCall(ReadBed(block, &layer->top));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMapLayerDestroy(MpmMapLayer *layer)
{
  PetscFunctionBeginUser;
  if (!*layer) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmBedDestroy(&(*layer)->top));
  PetscCall(MpmBedDestroy(&(*layer)->bottom));
  PetscCall(MpmBedDestroy(&(*layer)->depth));
  PetscCall(PetscFree(*layer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmMapLayerSetAbove(MpmMapLayer layer, MpmMapLayer above)
{
  layer->above = above;
}

PetscBool MpmMapLayerIsBoundedBelow(MpmMapLayer layer)
{
  return (PetscBool)(layer->ends || layer->thick);
}

/* ---- heights ---- */

/* Of a surface; not-a-number over pixels without data. */
static PetscReal HeightOf(const MpmBed *surface, const PetscReal x[])
{
  return surface->missing && MpmBedIsMissing(surface, x) ? NAN : MpmBedHeight(surface, x);
}

static PetscReal Lower(MpmMapLayer layer, const PetscReal x[], PetscReal upper);

static PetscReal Upper(MpmMapLayer layer, const PetscReal x[])
{
  return layer->above ? Lower(layer->above, x, Upper(layer->above, x)) : HeightOf(&layer->top, x);
}

/* The lower end, no higher than the upper one; not-a-number where either is. */
static PetscReal Lower(MpmMapLayer layer, const PetscReal x[], PetscReal upper)
{
  const PetscReal lower = layer->ends    ? HeightOf(&layer->bottom, x)
                          : layer->thick ? upper - HeightOf(&layer->depth, x)
                                         : PETSC_NINFINITY;

  return lower > upper || PetscIsNanReal(upper) ? upper : lower;
}

PetscBool MpmMapLayerHolds(MpmMapLayer layer, const PetscReal x[3], PetscReal tolerance)
{
  const PetscReal upper = Upper(layer, x), lower = Lower(layer, x, upper);

  return (PetscBool)(upper - lower > tolerance && x[2] <= upper + tolerance && x[2] >= lower - tolerance);
}

PetscBool MpmMapLayerSurface(MpmMapLayer layer, PetscInt side, const PetscReal x[], PetscReal *height,
                             PetscReal slope[2])
{
  const PetscReal upper = Upper(layer, x), lower = Lower(layer, x, upper);
  MpmBedPatch     patch, depth                   = {.slope = {0., 0.}};

  if (!(upper > lower) || (!side && !MpmMapLayerIsBoundedBelow(layer))) return PETSC_FALSE;
  if (side && layer->above) return MpmMapLayerSurface(layer->above, 0, x, height, slope);
  MpmBedPatchAt(side || layer->thick ? &layer->top : &layer->bottom, x, &patch);
  if (!side && layer->thick) {
    if (layer->above && !MpmMapLayerSurface(layer->above, 0, x, height, patch.slope)) return PETSC_FALSE;
    MpmBedPatchAt(&layer->depth, x, &depth);
  }
  *height = side ? upper : lower;
  for (PetscInt a = 0; a < 2; a++) slope[a] = patch.slope[a] - depth.slope[a];
  return PETSC_TRUE;
}

/* ---- pieces of the plane ---- */

/* Places along an axis, ascending, with the ends of an interval. */
typedef struct {
  PetscInt   count;
  PetscReal *at;
} Breaks;

/* Centres of a map's pixels within an interval; counted only, where `at` is NULL. */
static PetscInt AddCentres(const MpmMap *map, PetscInt axis, const PetscReal ends[2], PetscReal *at)
{
  const PetscReal first = axis ? map->y0 : map->x0, size = map->cell[axis];
  const PetscInt  count = axis ? map->rows : map->columns;
  PetscInt        from, to;

  if (!map->value) return 0;
  from = (PetscInt)PetscClipInterval(PetscFloorReal((ends[0] - first) / size), -1., (PetscReal)count) + 1;
  to   = (PetscInt)PetscClipInterval(PetscCeilReal((ends[1] - first) / size), 0., (PetscReal)count);
  for (PetscInt k = from; at && k < to; k++) at[k - from] = first + (PetscReal)k * size;
  return PetscMax(to - from, 0);
}

/* The ends, and between them the centres of pixels of the layer and of those above. */
static PetscErrorCode FindBreaks(MpmMapLayer layer, PetscInt axis, const PetscReal ends[2], Breaks *breaks)
{
  PetscInt count = 2, kept = 1;

  PetscFunctionBeginUser;
  for (MpmMapLayer l = layer; l; l = l->above) {
    const MpmMap *maps[] = {&l->top.map, &l->bottom.map, &l->depth.map};

    for (PetscInt k = 0; k < 3; k++) count += AddCentres(maps[k], axis, ends, NULL);
  }
  PetscCall(PetscMalloc1(count, &breaks->at));
  breaks->at[0] = ends[0];
  breaks->at[1] = ends[1];
  count         = 2;
  for (MpmMapLayer l = layer; l; l = l->above) {
    const MpmMap *maps[] = {&l->top.map, &l->bottom.map, &l->depth.map};

    for (PetscInt k = 0; k < 3; k++) count += AddCentres(maps[k], axis, ends, &breaks->at[count]);
  }
  PetscCall(PetscSortReal(count, breaks->at));
  for (PetscInt k = 1; k < count; k++)
    if (breaks->at[k] > breaks->at[kept - 1]) breaks->at[kept++] = breaks->at[k];
  breaks->count = kept;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The rectangle that all maps cover, to the edges of their outer pixels. */
static void Cover(MpmMapLayer layer, PetscReal lower[2], PetscReal upper[2])
{
  for (MpmMapLayer l = layer; l; l = l->above) {
    const MpmMap *maps[] = {&l->top.map, &l->bottom.map, &l->depth.map};

    for (PetscInt k = 0; k < 6; k++) {
      const MpmMap   *map   = maps[k / 2];
      const PetscInt  a     = k % 2;
      const PetscReal first = (a ? map->y0 : map->x0) - 0.5 * map->cell[a];

      if (!map->value) continue;
      lower[a] = PetscMax(lower[a], first);
      upper[a] = PetscMin(upper[a], first + (PetscReal)(a ? map->rows : map->columns) * map->cell[a]);
    }
  }
}

/* Least and largest height of the lower and of the upper surface over a rectangle. */
static PetscErrorCode Range(MpmMapLayer layer, const PetscReal lower[2], const PetscReal upper[2], PetscReal least[2],
                            PetscReal most[2])
{
  Breaks x, y;

  PetscFunctionBeginUser;
  PetscCall(FindBreaks(layer, 0, (const PetscReal[]){lower[0], upper[0]}, &x));
  PetscCall(FindBreaks(layer, 1, (const PetscReal[]){lower[1], upper[1]}, &y));
  for (PetscInt s = 0; s < 2; s++) {
    least[s] = PETSC_INFINITY;
    most[s]  = PETSC_NINFINITY;
  }
  for (PetscInt k = 0; k < x.count * y.count; k++) {
    const PetscReal at[] = {x.at[k % x.count], y.at[k / x.count]}, high = Upper(layer, at),
                    ends[2] = {Lower(layer, at, high), high};

    for (PetscInt s = 0; s < 2; s++) {
      if (PetscIsNanReal(ends[s])) continue;
      least[s] = PetscMin(least[s], ends[s]);
      most[s]  = PetscMax(most[s], ends[s]);
    }
  }
  PetscCall(PetscFree(x.at));
  PetscCall(PetscFree(y.at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmMapLayerBound(MpmMapLayer layer, PetscReal lower[3], PetscReal upper[3])
{
  PetscReal least[2], most[2], ends[2][2];

  Cover(layer, lower, upper);
  for (PetscInt a = 0; a < 2; a++) { /* finite, for maps that go on without end are level */
    ends[0][a] = PetscMax(lower[a], -PETSC_MAX_REAL / 4.);
    ends[1][a] = PetscMin(upper[a], PETSC_MAX_REAL / 4.);
  }
  if (!(lower[0] < upper[0] && lower[1] < upper[1]) || Range(layer, ends[0], ends[1], least, most)) return;
  lower[2] = PetscMax(lower[2], least[0]);
  upper[2] = PetscMin(upper[2], most[1]);
}

PetscBool MpmMapLayerIsNear(MpmMapLayer layer, const PetscReal x[3], PetscReal distance)
{
  const PetscReal lower[2] = {x[0] - distance, x[1] - distance}, upper[2] = {x[0] + distance, x[1] + distance};
  PetscReal       least[2], most[2];

  if (Range(layer, lower, upper, least, most)) return PETSC_TRUE;
  for (PetscInt s = 0; s < 2; s++)
    if (x[2] >= least[s] - distance && x[2] <= most[s] + distance) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ---- volumes ---- */

/* Sums over places of the base. */
typedef struct {
  PetscReal base, volume, moment[3];
} Sums;

/* The part above a place of the base that stands for an area, between two heights. */
static void AddColumn(MpmMapLayer layer, const PetscReal at[2], PetscReal area, PetscReal low, PetscReal high,
                      Sums *sums)
{
  const PetscReal surface = Upper(layer, at), top = PetscMin(surface, high),
                  bottom = PetscMax(Lower(layer, at, surface), low);
  const PetscReal volume = area * (top - bottom);

  sums->base += area;
  if (PetscIsNanReal(surface) || !(top > bottom)) return;
  sums->volume += volume;
  for (PetscInt a = 0; a < 2; a++) sums->moment[a] += volume * at[a];
  sums->moment[2] += volume * 0.5 * (top + bottom);
}

static PetscErrorCode AddPieces(MpmMapLayer layer, const MpmOutline *outline, const PetscReal lower[3],
                                const PetscReal upper[3], Sums *sums)
{
  PetscInt n[2];
  Breaks   breaks[2];

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < 2; a++) {
    PetscCall(FindBreaks(layer, a, (const PetscReal[]){lower[a], upper[a]}, &breaks[a]));
    n[a] = (SAMPLES + breaks[a].count - 2) / (breaks[a].count - 1);
  }
  for (PetscInt j = 0; j < n[1] * (breaks[1].count - 1); j++) {
    const PetscReal *y = &breaks[1].at[j / n[1]], dy = (y[1] - y[0]) / (PetscReal)n[1];

    for (PetscInt i = 0; i < n[0] * (breaks[0].count - 1); i++) {
      const PetscReal *x = &breaks[0].at[i / n[0]], dx = (x[1] - x[0]) / (PetscReal)n[0];
      const PetscReal  at[2] = {x[0] + ((PetscReal)(i % n[0]) + 0.5) * dx, y[0] + ((PetscReal)(j % n[1]) + 0.5) * dy};

      if (!outline || MpmOutlineHolds(outline, -1, at)) AddColumn(layer, at, dx * dy, lower[2], upper[2], sums);
    }
  }
  for (PetscInt a = 0; a < 2; a++) PetscCall(PetscFree(breaks[a].at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmMapLayerPart(MpmMapLayer layer, const MpmOutline *outline, PetscReal area, const PetscReal middle[2],
                          const PetscReal lower[3], const PetscReal upper[3], PetscReal centroid[3])
{
  Sums      sums = {.base = 0.};
  PetscReal scale;

  if (outline && !(area > 0.)) return 0.;
  if (AddPieces(layer, outline, lower, upper, &sums)) return 0.;
  if (outline && !(sums.base > 0.)) AddColumn(layer, middle, area, lower[2], upper[2], &sums);
  scale = outline ? area / sums.base : 1.;
  for (PetscInt a = 0; a < 3 && sums.volume > 0.; a++) centroid[a] = sums.moment[a] / sums.volume;
  return scale * sums.volume;
}
