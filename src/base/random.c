/*
  Random numbers by counter, and the normal distribution.
*/
#include <math.h>
#include "base/random.h"

#define GOLDEN UINT64_C(0x9e3779b97f4a7c15)

/* The output function of splitmix64. */
static uint64_t Mix(uint64_t z)
{
  z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
  return z ^ (z >> 31);
}

uint64_t MpmRandomBits(uint64_t seed, uint64_t stream, uint64_t counter)
{
  return Mix(Mix(Mix(seed + GOLDEN) ^ stream) + GOLDEN * (counter + 1));
}

PetscReal MpmRandomUniform(uint64_t seed, uint64_t stream, uint64_t counter)
{
  return ((PetscReal)(MpmRandomBits(seed, stream, counter) >> 12) + 0.5) * 0x1p-52;
}

PetscReal MpmNormalShare(PetscReal z)
{
  return 0.5 * erfc(-z * M_SQRT1_2);
}

/*
  Hastings' approximation of the tail, Abramowitz and Stegun (1964), 26.2.23, to 4.5e-4; then Halley's steps.
*/
PetscReal MpmNormalQuantile(PetscReal share)
{
  const PetscReal tail = PetscMin(share, 1. - share), t = PetscSqrtReal(-2. * PetscLogReal(tail));
  PetscReal       z =
    -(t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1. + t * (1.432788 + t * (0.189269 + t * 0.001308))));

  for (int k = 0; k < 3; k++) {
    const PetscReal step = (MpmNormalShare(z) - tail) * PetscSqrtReal(2. * PETSC_PI) * PetscExpReal(0.5 * z * z);

    z -= step / (1. + 0.5 * z * step);
  }
  return share < 0.5 ? z : -z;
}
