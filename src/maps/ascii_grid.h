#pragma once
/*
  A grid of numbers in an ESRI ASCII file: ncols, nrows, xllcenter or xllcorner, yllcenter or yllcorner, cellsize (or dx
  and dy), NODATA_value, and rows of numbers from north to south.
*/
#include "maps/map.h"

/* True where the file begins with a word of such a grid. */
PetscBool MpmAsciiGridIs(const char *path);
/* As MpmMapRead(), of such a file. */
PetscErrorCode MpmAsciiGridRead(const char *path, const MpmMapAsk *ask, MpmMap *map, char message[MPM_MAP_MESSAGE]);
