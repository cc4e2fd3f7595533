#pragma once
/*
  The bound on the speed of elastic waves, for loops over points.
*/
#include "base/base.h"
#include "talus/point/dense.h"

/* A bound on the largest principal compression, by the rows of the stress (Gerschgorin); 0 where there is none */
static inline PetscReal MpmLargestCompression(PetscInt dim, const PetscReal stress[])
{
  const PetscReal xy = PetscAbsReal(stress[3]);
  const PetscReal yz = dim == 2 ? 0. : PetscAbsReal(stress[4]), xz = dim == 2 ? 0. : PetscAbsReal(stress[5]);
  PetscReal       largest = PetscMax(0., xy + xz - stress[0]);

  largest = PetscMax(largest, xy + yz - stress[1]);
  return PetscMax(largest, yz + xz - stress[2]);
}

/*
  Speed of waves, m/s, by present lengths; from a law's stiffness at the state, as MpmLawInfo has it, Pa, the density of
  the initial volume, kg/m3, J and the Cauchy stress.
*/
static inline PetscReal MpmWaveSpeed(PetscInt dim, PetscReal stiffness, PetscReal density, PetscReal J,
                                     const PetscReal stress[])
{
  return PetscSqrtReal((stiffness + J * MpmLargestCompression(dim, stress)) / density);
}
