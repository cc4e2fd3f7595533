/*
  Bingham fluid: the stress at the bed under a steady uniform layer of mean speed v,

    v = h tau/(3 eta) (1 - (3/2) r + r^3/2) ,   r = tau_y/tau

  that is the largest root of 2 tau^3 - 3 (tau_y + 2 eta v/h) tau^2 + tau_y^3 = 0.

  tau_y  yield stress, Pa
  eta    viscosity, Pa s
  h      depth, m

  Source: Mei and Yuhi (2001), J. Fluid Mech. 431, 135-159, doi:10.1017/S0022112000003013, section 2.
*/
#include <math.h>
#include "talus/point/basal.h"

enum { YIELD_STRESS = MPM_BASAL_OWN, VISCOSITY };

static const MpmParameter parameters[] = {
  MPM_BASAL_SHARED,
  {MPM_NUMBER, "yield_stress", "Pa", 0., 1, 0., HUGE_VAL, 0, "yield stress", NULL, 2000., NULL},
  {MPM_NUMBER, "viscosity", "Pa s", 0., 1, 0., HUGE_VAL, 0, "viscosity beyond the yield stress", NULL, 150., NULL}};

static double Resistance(const double *parameter, const MpmBasalPoint *point)
{
  const double y = parameter[YIELD_STRESS], a = 3. * y + 6. * parameter[VISCOSITY] * point->speed / point->depth;
  double       tau = 0.5 * a; /* an upper bound of the root, from which Newton's method falls towards it */

  if (y <= 0.) return tau;
  if (a <= 3. * y) return y;
  for (int k = 0; k < 60; k++) {
    const double f = (2. * tau - a) * tau * tau + y * y * y, slope = (6. * tau - 2. * a) * tau;
    const double next = slope > 0. ? fmax(tau - f / slope, y) : y;

    if (!(next < tau * (1. - 4e-16))) break;
    tau = next;
  }
  return tau;
}

MPM_BASAL(bingham, parameters, NULL, Resistance, "Bingham fluid by its uniform flow")
