/*
  Outlines by GDAL, and their coordinate systems.
*/
#include <string.h>
#include "maps/map.h"
#include "maps/outline_build.h"

/* Types of the Simple Features standard, without z and m. */
enum { POINT = 1, LINE, POLYGON, POINTS, LINES, POLYGONS };

static int Type(const MpmGdal *gdal, void *geometry)
{
  return (gdal->OGR_G_GetGeometryType(geometry) & 0x7fffffff) % 1000;
}

/* A path of the last feature. */
static PetscErrorCode ReadPath(const MpmGdal *gdal, void *geometry, MpmOutline *outline)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOutlineAddPath(outline));
  for (int k = 0; k < gdal->OGR_G_GetPointCount(geometry); k++)
    PetscCall(MpmOutlineAddVertex(outline, gdal->OGR_G_GetX(geometry, k), gdal->OGR_G_GetY(geometry, k)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadPart(const MpmGdal *gdal, void *geometry, MpmOutline *outline, char message[])
{
  const int rings = Type(gdal, geometry) == POLYGON ? gdal->OGR_G_GetGeometryCount(geometry) : 0;

  PetscFunctionBeginUser;
  if (!rings) PetscCall(ReadPath(gdal, geometry, outline));
  for (int k = 0; k < rings && !message[0]; k++) {
    PetscCall(ReadPath(gdal, gdal->OGR_G_GetGeometryRef(geometry, k), outline));
    PetscCall(MpmOutlineEndRing(outline, (PetscBool)!k, message));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadFeature(const MpmGdal *gdal, void *feature, MpmOutline *outline, char message[])
{
  void     *geometry = gdal->OGR_F_GetGeometryRef(feature);
  const int type     = geometry ? Type(gdal, geometry) : 0;

  PetscFunctionBeginUser;
  if (!geometry) PetscFunctionReturn(PETSC_SUCCESS);
  if (type < POINT || type > POLYGONS) {
    (void)snprintf(message, MPM_MAP_MESSAGE, "has a geometry that is no point, line or polygon");
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmOutlineAddFeature(outline, (MpmOutlineType)((type - 1) % 3)));
  for (int k = 0; k < gdal->OGR_F_GetFieldCount(feature); k++) {
    const char *name = gdal->OGR_Fld_GetNameRef(gdal->OGR_F_GetFieldDefnRef(feature, k));

    if (!gdal->OGR_F_IsFieldSetAndNotNull(feature, k)) continue;
    PetscCall(MpmOutlineAddAttribute(outline, name, gdal->OGR_F_GetFieldAsString(feature, k)));
  }
  if (type <= POLYGON) PetscCall(ReadPart(gdal, geometry, outline, message));
  for (int k = 0; type > POLYGON && k < gdal->OGR_G_GetGeometryCount(geometry) && !message[0]; k++)
    PetscCall(ReadPart(gdal, gdal->OGR_G_GetGeometryRef(geometry, k), outline, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The system of a layer, as text. */
static PetscErrorCode ReadSystem(const MpmGdal *gdal, void *layer, MpmOutline *outline)
{
  void *system = gdal->OGR_L_GetSpatialRef(layer);
  char *text   = NULL;

  PetscFunctionBeginUser;
  if (!system || outline->system || gdal->OSRExportToWkt(system, &text)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscStrallocpy(text, &outline->system));
  gdal->VSIFree(text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutlineReadByGdal(const MpmGdal *gdal, const char *path, MpmOutline *outline, char message[])
{
  void *file = gdal->GDALOpenEx(path, MPM_GDAL_VECTOR, NULL, NULL, NULL);

  PetscFunctionBeginUser;
  if (!file) {
    MpmGdalReason(gdal, MPM_MAP_MESSAGE, message);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (int l = 0; l < gdal->GDALDatasetGetLayerCount(file) && !message[0]; l++) {
    void *layer = gdal->GDALDatasetGetLayer(file, l), *feature;

    PetscCall(ReadSystem(gdal, layer, outline));
    gdal->OGR_L_ResetReading(layer);
    while (!message[0] && (feature = gdal->OGR_L_GetNextFeature(layer))) {
      PetscCall(ReadFeature(gdal, feature, outline, message));
      gdal->OGR_F_Destroy(feature);
    }
  }
  gdal->GDALClose(file);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- coordinate systems ---- */

#define ALIKE 1e-3 /* m: systems whose places differ by less are one */

/* GeoJSON without a system is in degrees by its standard; here only where all of its places can be. */
static PetscBool CanBeDegrees(const MpmOutline *outline)
{
  PetscReal lower[2], upper[2];

  MpmOutlineBounds(outline, lower, upper);
  return (PetscBool)(lower[0] >= -180. && upper[0] <= 180. && lower[1] >= -90. && upper[1] <= 90.);
}

/* Vertices in another system; `moved` is how far they went. */
static PetscErrorCode Transform(const MpmGdal *gdal, void *from, void *to, MpmOutline *outline, PetscReal *moved,
                                char message[])
{
  const PetscInt count = outline->start[outline->paths];
  void          *map   = gdal->OCTNewCoordinateTransformation(from, to);
  double        *x, *y;
  int            good = 0;

  PetscFunctionBeginUser;
  *moved = 0.;
  PetscCall(PetscMalloc2(count, &x, count, &y));
  for (PetscInt v = 0; v < count; v++) {
    x[v] = outline->at[2 * v];
    y[v] = outline->at[2 * v + 1];
  }
  if (map) {
    good = gdal->OCTTransform(map, (int)count, x, y, NULL);
    gdal->OCTDestroyCoordinateTransformation(map);
  }
  if (!good) MpmGdalReason(gdal, MPM_MAP_MESSAGE, message);
  for (PetscInt v = 0; v < count && good; v++) {
    *moved =
      PetscMax(*moved, PetscMax(PetscAbsReal(x[v] - outline->at[2 * v]), PetscAbsReal(y[v] - outline->at[2 * v + 1])));
    outline->at[2 * v]     = x[v];
    outline->at[2 * v + 1] = y[v];
  }
  PetscCall(PetscFree2(x, y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* From the outline's system to the one asked for, both known. */
static PetscErrorCode Bring(const MpmGdal *gdal, const MpmOutlineAsk *ask, MpmOutline *outline, char message[])
{
  const char *target = ask->project ? ask->project : ask->system, *fault = NULL;
  void       *from = MpmGdalSystem(gdal, outline->system), *to = target ? MpmGdalSystem(gdal, target) : NULL;
  PetscReal   moved = 0.;

  PetscFunctionBeginUser;
  if (!from)
    (void)snprintf(message, MPM_MAP_MESSAGE, "has the coordinate system %s, which GDAL does not know", outline->system);
  else if (to && !gdal->OSRIsSame(from, to)) PetscCall(Transform(gdal, from, to, outline, &moved, message));
  if (from && !target) fault = MpmGdalSystemFault(gdal, from);
  if (!ask->project && moved > ALIKE)
    fault = "is in another coordinate system than the map of the terrain: project brings both to one";
  if (fault) (void)snprintf(message, MPM_MAP_MESSAGE, "%s", fault);
  if (from) gdal->OSRDestroySpatialReference(from);
  if (to) gdal->OSRDestroySpatialReference(to);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOutlineProject(const MpmOutlineAsk *ask, MpmOutline *outline, char message[])
{
  MpmGdal gdal;

  PetscFunctionBeginUser;
  if (!outline->system && ask->project && CanBeDegrees(outline))
    PetscCall(PetscStrallocpy("OGC:CRS84", &outline->system));
  if (outline->system && (ask->project || ask->system)) {
    if (!MpmGdalOpen(&gdal)) {
      if (ask->project)
        (void)snprintf(message, MPM_MAP_MESSAGE, "GDAL, by which project works, is not there (TALUS_GDAL may name it)");
    } else {
      gdal.CPLPushErrorHandler(gdal.CPLQuietErrorHandler);
      PetscCall(Bring(&gdal, ask, outline, message));
      gdal.CPLPopErrorHandler();
    }
  }
  for (PetscInt v = 0; v < outline->start[outline->paths]; v++)
    for (PetscInt a = 0; a < 2; a++) outline->at[2 * v + a] -= ask->origin[a];
  PetscFunctionReturn(PETSC_SUCCESS);
}
