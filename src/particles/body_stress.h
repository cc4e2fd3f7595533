#pragma once
/*
  Uniform stress of a body at the start.
*/
#include "base/base.h"
#include "base/types.h"

/*
  Gives points [range[0], range[1]) of a body, which are there without stress, the Cauchy stress, xx, yy, zz, xy (, yz,
  xz), Pa. `worst` becomes 1 where a yield surface excludes it, 2 where the law has no such state.
*/
PetscErrorCode MpmBodyStressFill(const MpmMaterial *material, PetscInt dim, const PetscReal stress[],
                                 PetscInt state_size, const PetscInt range[2], MpmPoints *points, int *worst);
