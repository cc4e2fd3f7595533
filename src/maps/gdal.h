#pragma once
/*
  The functions of GDAL's C API that maps and outlines use, from the shared library (https://gdal.org/api, GDAL 3).

  The library is opened when they are asked for, and stays open until the program ends. The environment variable
  TALUS_GDAL names another library file; `none` is none.
*/
#include "base/base.h"

/* Numbers of GDAL's enumerations: gdal.h, ogr_core.h, cpl_error.h. */
enum { MPM_GDAL_READ = 0, MPM_GDAL_WRITE = 1 };
enum { MPM_GDAL_RASTER = 0x02, MPM_GDAL_VECTOR = 0x04 };
enum { MPM_GDAL_FLOAT64 = 7 };
enum { MPM_GDAL_FAILURE = 3 };
enum { MPM_GDAL_XY = 0 }; /* OAMS_TRADITIONAL_GIS_ORDER */

#define MPM_GDAL_FUNCTIONS(X) \
  X(void, GDALAllRegister, (void)) \
  X(void *, GDALOpenEx, (const char *, unsigned, const char *const *, const char *const *, const char *const *)) \
  X(void, GDALClose, (void *)) \
  X(int, GDALGetRasterXSize, (void *)) \
  X(int, GDALGetRasterYSize, (void *)) \
  X(int, GDALGetRasterCount, (void *)) \
  X(int, GDALGetGeoTransform, (void *, double *)) \
  X(int, GDALSetGeoTransform, (void *, double *)) \
  X(const char *, GDALGetProjectionRef, (void *)) \
  X(int, GDALSetProjection, (void *, const char *)) \
  X(void *, GDALGetRasterBand, (void *, int)) \
  X(double, GDALGetRasterNoDataValue, (void *, int *)) \
  X(int, GDALSetRasterNoDataValue, (void *, double)) \
  X(double, GDALGetRasterScale, (void *, int *)) \
  X(double, GDALGetRasterOffset, (void *, int *)) \
  X(const char *, GDALGetRasterUnitType, (void *)) \
  X(void, GDALSetDescription, (void *, const char *)) \
  X(int, GDALRasterIO, (void *, int, int, int, int, int, void *, int, int, int, int, int)) \
  X(void *, GDALGetDriverByName, (const char *)) \
  X(void *, GDALCreate, (void *, const char *, int, int, int, int, char **)) \
  X(void *, GDALWarpAppOptionsNew, (char **, void *)) \
  X(void, GDALWarpAppOptionsFree, (void *)) \
  X(void *, GDALWarp, (const char *, void *, int, void **, void *, int *)) \
  X(void, CPLErrorReset, (void)) \
  X(const char *, CPLGetLastErrorMsg, (void)) \
  X(int, CPLGetLastErrorType, (void)) \
  X(void, CPLPushErrorHandler, (void (*)(int, int, const char *))) \
  X(void, CPLPopErrorHandler, (void)) \
  X(void, CPLQuietErrorHandler, (int, int, const char *)) \
  X(void *, OSRNewSpatialReference, (const char *)) \
  X(void, OSRDestroySpatialReference, (void *)) \
  X(int, OSRSetFromUserInput, (void *, const char *)) \
  X(void, OSRSetAxisMappingStrategy, (void *, int)) \
  X(int, OSRIsGeographic, (void *)) \
  X(int, OSRIsSame, (void *, void *)) \
  X(double, OSRGetLinearUnits, (void *, char **)) \
  X(int, OSRExportToWkt, (void *, char **)) \
  X(void *, OCTNewCoordinateTransformation, (void *, void *)) \
  X(void, OCTDestroyCoordinateTransformation, (void *)) \
  X(int, OCTTransform, (void *, int, double *, double *, double *)) \
  X(void, VSIFree, (void *)) \
  X(int, GDALDatasetGetLayerCount, (void *)) \
  X(void *, GDALDatasetGetLayer, (void *, int)) \
  X(void *, OGR_L_GetSpatialRef, (void *)) \
  X(void, OGR_L_ResetReading, (void *)) \
  X(void *, OGR_L_GetNextFeature, (void *)) \
  X(void, OGR_F_Destroy, (void *)) \
  X(void *, OGR_F_GetGeometryRef, (void *)) \
  X(int, OGR_F_GetFieldCount, (void *)) \
  X(void *, OGR_F_GetFieldDefnRef, (void *, int)) \
  X(const char *, OGR_Fld_GetNameRef, (void *)) \
  X(int, OGR_F_IsFieldSetAndNotNull, (void *, int)) \
  X(const char *, OGR_F_GetFieldAsString, (void *, int)) \
  X(int, OGR_G_GetGeometryType, (void *)) \
  X(int, OGR_G_GetGeometryCount, (void *)) \
  X(void *, OGR_G_GetGeometryRef, (void *, int)) \
  X(int, OGR_G_GetPointCount, (void *)) \
  X(double, OGR_G_GetX, (void *, int)) \
  X(double, OGR_G_GetY, (void *, int))

#define MPM_GDAL_MEMBER(type, name, arguments) type(*name) arguments;
typedef struct {
  MPM_GDAL_FUNCTIONS(MPM_GDAL_MEMBER)
} MpmGdal;
#undef MPM_GDAL_MEMBER

/* Fills the functions; PETSC_FALSE where the library is not there. GDAL then keeps errors for itself. */
PetscBool MpmGdalOpen(MpmGdal *gdal);
/* The reason of GDAL's last failure, without line ends. */
void MpmGdalReason(const MpmGdal *gdal, size_t size, char reason[]);

/*
  A coordinate system as an option or a file has it, "EPSG:32632" or WKT, for use with GDAL: axes go east and north.
  NULL where GDAL does not know it. Free with OSRDestroySpatialReference().
*/
void *MpmGdalSystem(const MpmGdal *gdal, const char text[]);
/* Complaint about a system that is not one of metres in the plane; NULL: none. */
const char *MpmGdalSystemFault(const MpmGdal *gdal, void *system);
