#pragma once
/*
  Volume of ground between maps (maps/map_layer.h), to compare with that of points.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"

/* Volume that a region has in the grid, m3, by columns with this base along x and y, m. Collective. */
PetscErrorCode MpmGroundVolume(MpmRegion region, const MpmGrid *grid, const PetscReal base[2], PetscReal *volume);
