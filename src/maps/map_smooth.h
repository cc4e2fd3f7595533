#pragma once
/*
  Maps averaged over pixels.
*/
#include "maps/map.h"

/* Averages by a Gaussian of this standard deviation, in pixels, over those with data within its reach; 0: nothing. */
PetscErrorCode MpmMapSmooth(PetscReal deviation, MpmMap *map);
/* Its reach: three standard deviations, in pixels. */
PetscInt MpmMapSmoothReach(PetscReal deviation);
