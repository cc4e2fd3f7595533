#pragma once
/*
  Dams on a bed.
*/
#include "maps/bed.h"

/*
  Reads -mpm_terrain_raise, a list of names, and the block -mpm_raise_NAME_ of each: a line with a crest, or a map of
  heights; and raises the bed's pixels. With -help too.
*/
PetscErrorCode MpmBedRaise(const MpmOptions *options, MpmBed *bed);
