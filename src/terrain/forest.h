#pragma once
/*
  Forests on a bed as resistance to flow.
*/
#include "grid/grid.h"
#include "base/types.h"

/*
  MpmForestsRead - reads -mpm_forests and their blocks

  Output Parameter:
. drag - c_d n d/2 at the nodes of the grid, x fastest, 1/m, to be freed; NULL: there is no forest

  Notes:
  n stems on a square metre of the diameter d resist a layer of the depth h and the horizontal velocity u with the force
  c_d rho h u^2 n d/2 on it, where all of the stems stand in the flow. Forests that overlap are added. Fails with
  MPM_ERR_INPUT and one line.
  Source: Nepf (1999), Water Resour. Res. 35, 479-489, doi:10.1029/1998WR900069.
@*/
PetscErrorCode MpmForestsRead(const MpmOptions *options, const MpmGrid *grid, PetscReal **drag);
