/*
  Places of parameters: sizes, bounds, and starts that fill the bounds.

  Starts are points of Halton's sequence, Numerische Mathematik 2, 84-90 (1960), doi:10.1007/BF01386213: coordinate k
  is the number of the point with its digits to the base of the k-th prime mirrored at the point.
*/
#include "inverse/analysis.h"

PetscReal MpmInverseSize(const MpmInverse *inverse, const PetscReal t[], PetscInt k)
{
  if (inverse->problem.ranges->at[k].transform != MPM_TRANSFORM_NONE || t[k] == 0.) return 1.;
  return PetscAbsReal(t[k]);
}

void MpmInverseClip(const MpmInverse *inverse, PetscReal t[])
{
  for (PetscInt k = 0; k < inverse->problem.count; k++) {
    PetscReal lower, upper;

    MpmRangeBounds(&inverse->problem.ranges->at[k], &lower, &upper);
    t[k] = PetscClipInterval(t[k], lower, upper);
  }
}

static PetscReal Mirror(PetscInt number, PetscInt base)
{
  PetscReal value = 0., digit = 1.;

  for (; number; number /= base) {
    digit /= (PetscReal)base;
    value += digit * (PetscReal)(number % base);
  }
  return value;
}

static PetscInt NextPrime(PetscInt number)
{
  for (number++;; number++) {
    PetscInt d = 2;

    while (d * d <= number && number % d) d++;
    if (d * d > number) return number;
  }
}

void MpmInverseStart(const MpmInverse *inverse, PetscInt k, PetscReal t[])
{
  PetscInt prime = 1;

  for (PetscInt p = 0; p < inverse->problem.count; p++) {
    const MpmParameterRange *range = &inverse->problem.ranges->at[p];
    const PetscBool          even  = (PetscBool)(range->transform == MPM_TRANSFORM_LOG && range->lower > 0.);
    PetscReal                part;

    prime = NextPrime(prime);
    part  = Mirror(k, prime);
    if (even) t[p] = (1. - part) * PetscLogReal(range->lower) + part * PetscLogReal(range->upper);
    else t[p] = MpmRangeTransform(range, (1. - part) * range->lower + part * range->upper);
  }
}
