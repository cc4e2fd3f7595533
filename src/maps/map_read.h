#pragma once
/*
  Shared by the readers of maps.
*/
#include "maps/map.h"

/* Pixels of one axis that are read, and where the first one stands. */
typedef struct {
  PetscInt  first, count;
  PetscReal start; /* of the centre of the first, less the local origin, m */
} MpmMapRange;

/*
  The pixels about a range [lower, upper] of places, less the local origin, of `total` with the first centre at `start`;
  PETSC_FALSE where there is none.
*/
PetscBool MpmMapRangeFind(PetscReal start, PetscReal cell, PetscInt total, const MpmMapAsk *ask, PetscInt axis,
                          MpmMapRange *range);
