#pragma once
/*
  A grid of numbers in an ESRI ASCII file: ncols, nrows, xllcenter or xllcorner, yllcenter or yllcorner, cellsize,
  NODATA_value, and rows of numbers from north to south.
*/
#include "base/base.h"

/* Start from zeros. value[j*columns + i] is that of the pixel whose centre stands at x0 + i cell, y0 + j cell. */
typedef struct {
  PetscInt   columns, rows;
  PetscReal  x0, y0, cell; /* m */
  PetscReal  none;         /* value of pixels without data */
  PetscReal *value;
} MpmAsciiGrid;

#define MPM_ASCII_MESSAGE 512
/* Not collective. A fault of the file goes into `message`, which stays as it is where there is none. */
PetscErrorCode MpmAsciiGridRead(const char *path, MpmAsciiGrid *grid, char message[MPM_ASCII_MESSAGE]);
PetscErrorCode MpmAsciiGridDestroy(MpmAsciiGrid *grid);
