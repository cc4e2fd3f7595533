/*
  The law of contact. With k the stiffness across the surface and k' that along it, slip s and pressure p:

    t = k' s  while  |k' s| <= L ,  t = L s/|s|  else ,   L = mu max(p, 0) + adhesion, at most the material's strength

  Sticking to a material whose strength has no bound has L = 10 p where the contact may open. On opening the traction
  has to vanish with the pressure, or there may be no state in balance.

  After sliding s = t/k' is kept. k' = k where nothing can slide and where bodies roll, and a small fraction of k
  elsewhere. A change of pressure moves the bound L, and with equal stiffness the slip that follows would throw Newton's
  method from sticking to sliding and back.

  Sliding has no stiffness along the slip. A body supported by friction alone, such as a strip between two rollers, is
  then free to move while all of it slides; Newton's method throws it from sliding one way to sliding the other. With
  the secant t/s in place of dt/ds it comes to a state where some of it sticks; the solver takes secants until nothing
  changes any more between two iterates (contact_states.c). Where a body slides to both sides as its weight spreads it,
  any place within the slips is in equilibrium. A least stiffness, negligible beside any other, then keeps it in place
  against rounding errors.

  The barrier is p = -k d0 b'(x), b = -(x - 1)^2 ln x, x = g/d0 up to 1. Source: Li, Fang, Li and Jiang (2022), BFEMP,
  doi:10.1016/j.cma.2021.114350.
*/
#include "facets/contact_law.h"

#define ROUGH 10. /* of the pressure: bound of the sticking traction of contact that may open */

PetscBool MpmContactSlide(const MpmContactLaw *law, PetscInt dim, PetscReal pressure, PetscReal slip[],
                          MpmContactFriction *friction)
{
  const PetscBool slides = (PetscBool)!MpmContactSticks(law->stick, law->strength);
  const PetscReal k      = law->along * law->stiffness; /* along the surface */
  PetscReal       size = 0., limit = law->friction * PetscMax(pressure, 0.) + law->adhesion, growth = 0.;

  *friction = (MpmContactFriction){0};
  for (PetscInt a = 0; a < dim; a++) size += PetscSqr(slip[a]);
  size = PetscSqrtReal(size);
  if (law->stick && law->parts && !slides) {
    limit  = ROUGH * PetscMax(pressure, 0.);
    growth = pressure > 0. ? ROUGH : 0.;
  } else if (law->stick || limit > law->strength) limit = law->strength;
  else growth = pressure > 0. ? law->friction : 0.; /* of the limit with the pressure */
  if (k * size <= limit) {
    for (PetscInt a = 0; a < dim; a++) {
      friction->traction[a]   = k * slip[a];
      friction->by_slip[a][a] = k;
    }
    return PETSC_FALSE;
  }
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal along = slip[a] / size;

    friction->traction[a]    = limit * along;
    friction->by_pressure[a] = growth * along;
    for (PetscInt c = 0; c < dim; c++)
      friction->by_slip[a][c] = limit / size * ((a == c ? 1. : 0.) - (law->secant ? 0. : along * slip[c] / size)) +
                                law->least * law->stiffness * along * slip[c] / size;
  }
  for (PetscInt a = 0; a < dim; a++) slip[a] = friction->traction[a] / k;
  return PETSC_TRUE;
}

PetscBool MpmContactBarrier(const MpmContactLaw *law, PetscReal reach, PetscReal gap, PetscReal *pressure,
                            PetscReal *rate)
{
  const PetscReal x = gap / reach;

  *pressure = *rate = 0.;
  if (gap <= 0.) return PETSC_FALSE;
  if (x >= 1.) return PETSC_TRUE;
  *pressure = law->stiffness * reach * (2. * (x - 1.) * PetscLogReal(x) + (x - 1.) * (x - 1.) / x);
  *rate     = law->stiffness * (-2. * PetscLogReal(x) - 4. * (x - 1.) / x + (x - 1.) * (x - 1.) / (x * x));
  return PETSC_TRUE;
}
