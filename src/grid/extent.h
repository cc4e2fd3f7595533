#pragma once
/*
  The rectangle of a grid, and its cells.
*/
#include "grid/grid.h"

/*
  Reads -mpm_grid_lower, upper and cells, or the length of a cell; with -mpm_grid_terrain the rectangle is what lies
  between the centres of the outer pixels of the terrain's map, as far as whole cells go.
*/
PetscErrorCode MpmGridReadExtent(const MpmOptions *block, const MpmOptions *options, MpmGrid *grid);
