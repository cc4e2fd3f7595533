#pragma once
/*
  Directions at right angles.
*/
#include "base/base.h"

/*
  Makes axis[0] of length one and the others from it, right-handed: axis[1] is the grid's axis behind the one along
  which axis[0] is longest, less its component along axis[0]. PETSC_FALSE where axis[0] has no direction.
*/
PetscBool MpmAxesComplete(PetscInt dim, PetscReal (*axis)[MPM_MAX_DIM]);
