/*
  Maps from files.
*/
#include <string.h>
#include "maps/ascii_grid.h"
#include "maps/gdal.h"
#include "maps/map_read.h"

PetscBool MpmMapRangeFind(PetscReal start, PetscReal cell, PetscInt total, const MpmMapAsk *ask, PetscInt axis,
                          MpmMapRange *range)
{
  PetscReal first = 0., last = (PetscReal)(total - 1);

  if (ask->lower) {
    const PetscReal margin = (PetscReal)PetscMax(ask->margin, 1);

    first = PetscMax(first, PetscFloorReal((ask->lower[axis] - start) / cell) - margin);
    last  = PetscMin(last, PetscCeilReal((ask->upper[axis] - start) / cell) + margin);
  }
  if (!(first <= last)) return PETSC_FALSE;
  range->first = (PetscInt)first;
  range->count = (PetscInt)last - range->first + 1;
  range->start = start + (PetscReal)range->first * cell;
  return PETSC_TRUE;
}

/* ---- by GDAL ---- */

/* A file, and the map warped from it, if any. */
typedef struct {
  MpmGdal *gdal;
  void    *source, *warped;
} File;

static void Close(File *file)
{
  if (file->warped) file->gdal->GDALClose(file->warped);
  if (file->source) file->gdal->GDALClose(file->source);
}

/* A virtual map in another system, computed as it is read. */
static void Warp(File *file, const char *project, char message[])
{
  char of[] = "-of", vrt[] = "VRT", t[] = "-t_srs", r[] = "-r", linear[] = "bilinear", ot[] = "-ot", real[] = "Float64",
       none[] = "-dstnodata", nan[] = "nan", et[] = "-et", zero[] = "0", system[256];
  char *arguments[] = {of, vrt, t, system, r, linear, ot, real, none, nan, et, zero, NULL};
  void *options;
  int   fault = 0;

  (void)snprintf(system, sizeof(system), "%s", project);
  options      = file->gdal->GDALWarpAppOptionsNew(arguments, NULL);
  file->warped = options ? file->gdal->GDALWarp("", NULL, 1, &file->source, options, &fault) : NULL;
  if (options) file->gdal->GDALWarpAppOptionsFree(options);
  if (file->warped) return;
  MpmGdalReason(file->gdal, MPM_MAP_MESSAGE, message);
}

/* The system of the map, which must be one of metres. */
static PetscErrorCode ReadSystem(const MpmGdal *gdal, void *file, MpmMap *map, char message[])
{
  const char *text   = gdal->GDALGetProjectionRef(file), *fault;
  void       *system = text && *text ? MpmGdalSystem(gdal, text) : NULL;

  PetscFunctionBeginUser;
  if (!system) PetscFunctionReturn(PETSC_SUCCESS);
  fault = MpmGdalSystemFault(gdal, system);
  gdal->OSRDestroySpatialReference(system);
  if (fault) (void)snprintf(message, MPM_MAP_MESSAGE, "%s", fault);
  PetscCall(PetscStrallocpy(text, &map->system));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Places of the pixels; GDAL has those of corners, whatever a pixel is in the file. */
static void ReadPlaces(const MpmGdal *gdal, void *file, const MpmMapAsk *ask, MpmMapRange range[2], MpmMap *map,
                       char message[])
{
  const PetscInt total[2] = {gdal->GDALGetRasterXSize(file), gdal->GDALGetRasterYSize(file)};
  double         t[6];

  if (gdal->GDALGetGeoTransform(file, t)) {
    (void)snprintf(message, MPM_MAP_MESSAGE, "has no places of its pixels");
    return;
  }
  if (t[2] != 0. || t[4] != 0. || !(t[1] > 0.) || !(t[5] < 0.)) {
    (void)snprintf(message, MPM_MAP_MESSAGE, "is rotated, sheared or mirrored: rows must go east, from north to south");
    return;
  }
  map->cell[0] = t[1];
  map->cell[1] = -t[5];
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal half  = 0.5 * map->cell[a];
    const PetscReal first = a ? t[3] + (PetscReal)total[1] * t[5] + half : t[0] + half;

    map->origin[a] = ask->origin[a];
    if (!MpmMapRangeFind(first - ask->origin[a], map->cell[a], total[a], ask, a, &range[a]))
      (void)snprintf(message, MPM_MAP_MESSAGE, "lies outside the grid");
  }
  map->columns = range[0].count;
  map->rows    = range[1].count;
  map->x0      = range[0].start;
  map->y0      = range[1].start;
}

/* Values of a band, with its scale, offset and mark of no data. */
static PetscErrorCode ReadValues(const MpmGdal *gdal, void *file, const MpmMapAsk *ask, const MpmMapRange range[2],
                                 MpmMap *map, char message[])
{
  const int    count = gdal->GDALGetRasterCount(file), number = PetscMax((int)ask->band, 1);
  const int    width = (int)map->columns, height = (int)map->rows;
  const int    north = gdal->GDALGetRasterYSize(file) - (int)range[1].first - height;
  const size_t size = (size_t)width * (size_t)height, last = size - (size_t)width;
  int          has;
  void        *band;
  double       scale, offset, none;
  const char  *unit;

  PetscFunctionBeginUser;
  if (number > count) {
    (void)snprintf(message, MPM_MAP_MESSAGE, "has %d band%s, and not band %d", count, count == 1 ? "" : "s", number);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  band      = gdal->GDALGetRasterBand(file, number);
  none      = gdal->GDALGetRasterNoDataValue(band, &has);
  map->none = has ? none : -9999.;
  unit      = gdal->GDALGetRasterUnitType(band);
  if (unit && (strstr(unit, "ft") || strstr(unit, "foot") || strstr(unit, "feet"))) {
    (void)snprintf(message, MPM_MAP_MESSAGE, "has values in feet: must be in metres");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (ask->frame) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(size, &map->value));
  if (gdal->GDALRasterIO(band, MPM_GDAL_READ, (int)range[0].first, north, width, height, &map->value[last], width,
                         height, MPM_GDAL_FLOAT64, 0, -(int)sizeof(double) * width)) {
    MpmGdalReason(gdal, MPM_MAP_MESSAGE, message);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  scale  = gdal->GDALGetRasterScale(band, NULL);
  offset = gdal->GDALGetRasterOffset(band, NULL);
  for (size_t k = 0; k < size; k++) {
    if ((has && map->value[k] == none) || PetscIsInfReal(map->value[k])) map->value[k] = NAN;
    else if (scale != 1. || offset != 0.) map->value[k] = scale * map->value[k] + offset;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* With GDAL's own messages off. */
static PetscErrorCode ReadByGdal(MpmGdal *gdal, const char *path, const MpmMapAsk *ask, MpmMap *map, char message[])
{
  File        file = {.gdal = gdal};
  MpmMapRange range[2];
  void       *data;

  PetscFunctionBeginUser;
  file.source = gdal->GDALOpenEx(path, MPM_GDAL_RASTER, NULL, NULL, NULL);
  if (!file.source) MpmGdalReason(gdal, MPM_MAP_MESSAGE, message);
  else if (ask->project) Warp(&file, ask->project, message);
  data = file.warped ? file.warped : file.source;
  if (!message[0]) PetscCall(ReadSystem(gdal, data, map, message));
  if (!message[0]) ReadPlaces(gdal, data, ask, range, map, message);
  if (!message[0]) PetscCall(ReadValues(gdal, data, ask, range, map, message));
  Close(&file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- any ---- */

PetscErrorCode MpmMapRead(const char *path, const MpmMapAsk *ask, MpmMap *map, char message[MPM_MAP_MESSAGE])
{
  PetscBool ascii, there;
  MpmGdal   gdal;

  PetscFunctionBeginUser;
  PetscCall(PetscTestFile(path, 'r', &there));
  if (!there) {
    (void)snprintf(message, MPM_MAP_MESSAGE, "cannot be read");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  ascii = MpmAsciiGridIs(path);
  if (ascii && !ask->project) {
    PetscCall(MpmAsciiGridRead(path, ask, map, message));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!MpmGdalOpen(&gdal)) {
    (void)snprintf(message, MPM_MAP_MESSAGE, "%s is not there (TALUS_GDAL may name it)%s",
                   "GDAL, which reads all maps but ASCII grids,", ascii ? ", and project needs it" : "");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  gdal.CPLPushErrorHandler(gdal.CPLQuietErrorHandler);
  PetscCall(ReadByGdal(&gdal, path, ask, map, message));
  gdal.CPLPopErrorHandler();
  PetscFunctionReturn(PETSC_SUCCESS);
}
