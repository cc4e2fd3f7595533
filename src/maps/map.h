#pragma once
/*
  Maps: numbers on pixels, from files and into files.

  ESRI ASCII grids are read and written by this program. All other formats go through GDAL (https://gdal.org), whose
  library is opened by the first map that needs it.
*/
#include "base/base.h"

/*
  Start from zeros. value[j*columns + i] belongs to the pixel whose centre stands at x0 + i cell[0], y0 + j cell[1];
  rows go from south to north.
*/
typedef struct {
  PetscInt   columns, rows;
  PetscReal  x0, y0;    /* m, less the local origin */
  PetscReal  cell[2];   /* m */
  PetscReal  origin[2]; /* local origin, m */
  PetscReal  none;      /* mark of pixels without data in files */
  PetscReal *value;     /* not-a-number: no data */
  char      *system;    /* coordinate system as WKT; NULL: unknown */
} MpmMap;

/* Part of a file that is read, and how. */
typedef struct {
  PetscInt         band;          /* from 1; 0: the first */
  const char      *project;       /* system to which the map is warped, or NULL */
  const PetscReal *lower, *upper; /* only pixels about this rectangle, m; NULL: all */
  PetscInt         margin;        /* pixels beyond the rectangle; at least 1 */
  PetscReal        origin[2];     /* local origin, taken off */
  PetscBool        frame;         /* places of all pixels, without values */
} MpmMapAsk;

#define MPM_MAP_MESSAGE 512
/*
  Reads a map; band, scale and offset of the file are applied. Not collective. A fault of the file goes into `message`,
  which stays as it is where there is none: maps in degrees or feet, rotated ones, and pixels of no size are refused.
*/
PetscErrorCode MpmMapRead(const char *path, const MpmMapAsk *ask, MpmMap *map, char message[MPM_MAP_MESSAGE]);
PetscErrorCode MpmMapDestroy(MpmMap *map);
/* A map on the pixels of another one, with values of its own: not yet set where `value` is NULL. */
PetscErrorCode MpmMapLike(const MpmMap *like, MpmMap *map);
/* Bilinear between the centres of pixels, constant beyond the outer ones; not-a-number beside pixels without data. */
PetscReal MpmMapAt(const MpmMap *map, const PetscReal x[]);
/* Value, slopes and mixed derivative of the bilinear patch at a place; slopes across the outer edges are 0 beyond. */
void MpmMapPatch(const MpmMap *map, const PetscReal x[], PetscReal *value, PetscReal slope[2], PetscReal *twist);

/*
  MpmMapWrite - write values on the pixels of a map

  Collective. Rank 0 writes what it holds.

  Input Parameters:
+ stem   - path without ending
. like   - places of the pixels, system and mark of no data
. count  - number of bands, >= 1
. names  - of the bands
- values - of each band: columns*rows numbers as in MpmMap; not-a-number: no data

  Notes:
  With GDAL <stem>.tif, a GeoTIFF with deflated 64-bit reals; without it <stem>_<name>.asc for each band. A file appears
  whole or not at all. Fails with PETSC_ERR_FILE_WRITE and one line that names the file.
*/
PetscErrorCode MpmMapWrite(MPI_Comm comm, const char *stem, const MpmMap *like, PetscInt count,
                           const char *const names[], const PetscReal *const values[]);
