#pragma once
/*
  Pixels without data.
*/
#include "maps/map.h"

/*
  Gives pixels without data the mean of those beside them, from their edges inward, and marks them; `missing` is NULL
  where there is none, else to be freed with PetscFree(). A map without any data stays as it is.
*/
PetscErrorCode MpmMapFill(MpmMap *map, char **missing);
