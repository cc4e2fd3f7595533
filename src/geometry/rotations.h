#pragma once
/*
  Rotations of a rigid body: in 2D there is one, about z, in 3D one about each axis.
*/
#include "base/base.h"

static inline PetscInt MpmRotationCount(PetscInt dim)
{
  return dim * (dim - 1) / 2;
}

/* The axis of rotation k. */
static inline PetscInt MpmRotationAxis(PetscInt dim, PetscInt k)
{
  return 3 - MpmRotationCount(dim) + k;
}
