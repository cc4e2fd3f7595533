#pragma once
/*
  Dams on a bed.
*/
#include "maps/bed.h"

/*
  Reads -mpm_terrain_raise, a list of names, and the block -mpm_raise_NAME_ of each: a line with a crest, or a map of
  heights; raises the bed's pixels, and keeps the height of each dam. With -help too.
*/
PetscErrorCode MpmBedRaise(const MpmOptions *options, MpmBed *bed);
PetscErrorCode MpmBedDamsDestroy(MpmBedDams *dams);
