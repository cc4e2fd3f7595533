#pragma once
/*
  A velocity under a resistance that does not fall with the speed, implicitly.
*/
#include "base/base.h"

/* The resistance at a speed, of a caller's own data. */
typedef PetscReal (*MpmResistanceAt)(const void *of, PetscReal speed);

/*
  MpmResistedSpeed - the speed u that solves m (u - u*) + t F(u) = 0

  Input Parameters:
+ mass       - m
. time       - t, for which the resistance acts
. speed      - u*, that without resistance, at least 0
- resistance - F, with `of`, its data; it does not fall with the speed

  Returns 0 where t F(0) >= m u*: what the bed can stop is at rest to the last digit.

  The first estimate is exact where F is F(0) and a part that goes with the speed squared; where it is none regula falsi
  with halved ends follows. Source: Dowell and Jarratt (1971), BIT 11, 168-174, doi:10.1007/BF01934364 (Illinois).
*/
PetscReal MpmResistedSpeed(PetscReal mass, PetscReal time, PetscReal speed, MpmResistanceAt resistance, const void *of);
