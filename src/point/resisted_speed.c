/*
  The speed under a resistance that does not fall with it.
*/
#include "point/resisted_speed.h"

#define MOST 100 /* iterations: a bisection would have ended */

/* The root where the resistance is F(0) and a part that goes with the speed squared: all of it, of most laws. */
static PetscReal SquareRoot(PetscReal mass, PetscReal time, PetscReal speed, PetscReal at_rest, PetscReal at_speed)
{
  const PetscReal square = time * (at_speed - at_rest) / (speed * speed), rest = mass * speed - time * at_rest;
  const PetscReal root = mass * mass + 4. * square * rest;

  return root > 0. ? PetscClipInterval(2. * rest / (mass + PetscSqrtReal(root)), 0., speed) : 0.5 * speed;
}

PetscReal MpmResistedSpeed(PetscReal mass, PetscReal time, PetscReal speed, MpmResistanceAt resistance, const void *of)
{
  const PetscReal at_rest = resistance(of, 0.), at_speed = resistance(of, speed), zero = 4. * PETSC_MACHINE_EPSILON;
  PetscReal       lower = 0., upper = speed, below = time * at_rest - mass * speed, above = time * at_speed;
  int             side = 0;

  if (!(below < 0.)) return 0.;
  for (PetscInt k = 0; k < MOST && above > 0. && upper - lower > zero * upper; k++) {
    const PetscReal middle =
      k ? (lower * above - upper * below) / (above - below) : SquareRoot(mass, time, speed, at_rest, at_speed);
    const PetscReal value = mass * (middle - speed) + time * resistance(of, middle);

    if (PetscAbsReal(value) <= zero * mass * speed) return middle;
    if (value > 0.) {
      upper = middle;
      above = value;
      if (side > 0) below *= 0.5;
      side = 1;
    } else {
      lower = middle;
      below = value;
      if (side < 0) above *= 0.5;
      side = -1;
    }
  }
  return above > 0. ? 0.5 * (lower + upper) : upper;
}
