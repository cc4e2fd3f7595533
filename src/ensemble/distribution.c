/*
  Quantiles of distributions.
*/
#include "base/random.h"
#include "ensemble/distribution.h"

/* A normal distribution between bounds. */
static PetscReal Normal(PetscReal mean, PetscReal deviation, PetscReal lower, PetscReal upper, PetscReal share)
{
  const PetscReal a = MpmNormalShare((lower - mean) / deviation), b = MpmNormalShare((upper - mean) / deviation);
  const PetscReal z = MpmNormalQuantile(PetscClipInterval(a + share * (b - a), PETSC_SMALL * PETSC_SMALL, 1. - 1e-16));

  return PetscClipInterval(mean + deviation * z, lower, upper);
}

/* Its logarithm is normal, with the variance ln(1 + s^2/m^2) about ln m less half of it. */
static PetscReal Lognormal(const MpmDistribution *at, PetscReal share)
{
  const PetscReal variance = PetscLogReal(1. + PetscSqr(at->deviation / at->mean));
  const PetscReal lower    = at->lower > 0. ? PetscLogReal(at->lower) : PETSC_NINFINITY;
  const PetscReal upper    = at->upper < PETSC_INFINITY ? PetscLogReal(at->upper) : PETSC_INFINITY;

  return PetscExpReal(Normal(PetscLogReal(at->mean) - 0.5 * variance, PetscSqrtReal(variance), lower, upper, share));
}

static PetscReal Triangular(const MpmDistribution *at, PetscReal share)
{
  const PetscReal width = at->upper - at->lower, left = at->mode - at->lower;

  if (share * width < left) return at->lower + PetscSqrtReal(share * width * left);
  return at->upper - PetscSqrtReal((1. - share) * width * (width - left));
}

PetscReal MpmDistributionQuantile(const MpmDistribution *at, PetscReal share)
{
  if (at->type == MPM_NORMAL) return Normal(at->mean, at->deviation, at->lower, at->upper, share);
  if (at->type == MPM_LOGNORMAL) return Lognormal(at, share);
  if (at->type == MPM_TRIANGULAR) return Triangular(at, share);
  return at->lower + share * (at->upper - at->lower);
}
