#pragma once
/*
  Parameters of laws of the bed by maps.
*/
#include "talus/talus.h"
#include "maps/map.h"

/*
  Reads a parameter whose option is the path of a map: its values, all in the parameter's range, with those of pixels
  without data from beside. `is` says whether it is one; otherwise the option is left alone, and the map empty. With
  -help it is empty, too.
*/
PetscErrorCode MpmBasalMapRead(const MpmOptions *block, const MpmParameter *parameter, MpmMap *map, PetscBool *is);
/* Its least value. */
PetscErrorCode MpmBasalMapLeast(const MpmOptions *block, const MpmParameter *parameter, double *least, PetscBool *is);
