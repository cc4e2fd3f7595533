/*
  GDAL's shared library.
*/
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>
#include "maps/gdal.h"

/* Its name by version: Debian 12 has 32, and so on. */
static const char *const libraries[] = {"libgdal.so",
                                        "libgdal.so.38",
                                        "libgdal.so.37",
                                        "libgdal.so.36",
                                        "libgdal.so.35",
                                        "libgdal.so.34",
                                        "libgdal.so.33",
                                        "libgdal.so.32",
                                        "libgdal.so.31",
                                        "libgdal.so.30",
                                        NULL};

/* The library stays open: dlopen() counts. Its symbols are its own, so that its HDF5 is not the program's. */
static void *Library(void)
{
  const char *given = getenv("TALUS_GDAL");
  void       *handle;

  if (given && *given) return strcmp(given, "none") ? dlopen(given, RTLD_LAZY | RTLD_LOCAL) : NULL;
  for (PetscInt k = 0; libraries[k]; k++) {
    handle = dlopen(libraries[k], RTLD_LAZY | RTLD_LOCAL);
    if (handle) return handle;
  }
  return NULL;
}

PetscBool MpmGdalOpen(MpmGdal *gdal)
{
  void *library = Library(), *symbol;

  if (!library) return PETSC_FALSE;
#define FIND(type, name, arguments) \
  symbol = dlsym(library, #name); \
  if (!symbol) return PETSC_FALSE; \
  memcpy(&gdal->name, &symbol, sizeof(symbol));
  MPM_GDAL_FUNCTIONS(FIND)
#undef FIND
  gdal->GDALAllRegister();
  gdal->CPLErrorReset();
  return PETSC_TRUE;
}

void MpmGdalReason(const MpmGdal *gdal, size_t size, char reason[])
{
  const char *text = gdal->CPLGetLastErrorMsg();

  (void)snprintf(reason, size, "%s", text && *text ? text : "GDAL cannot read it");
  for (char *c = reason; *c; c++)
    if (*c == '\n' || *c == '\r') *c = ' ';
}

void *MpmGdalSystem(const MpmGdal *gdal, const char text[])
{
  void *system = gdal->OSRNewSpatialReference(NULL);

  if (!system) return NULL;
  if (gdal->OSRSetFromUserInput(system, text)) {
    gdal->OSRDestroySpatialReference(system);
    return NULL;
  }
  gdal->OSRSetAxisMappingStrategy(system, MPM_GDAL_XY);
  return system;
}

const char *MpmGdalSystemFault(const MpmGdal *gdal, void *system)
{
  const PetscReal metres = gdal->OSRGetLinearUnits(system, NULL);

  if (gdal->OSRIsGeographic(system)) return "is in degrees: project must be a system in metres, as EPSG:32632";
  if (PetscAbsReal(metres - 1.) > 1e-12) return "is not in metres: project must be a system that is, as EPSG:32632";
  return NULL;
}
