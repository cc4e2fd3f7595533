/*
  Herschel-Bulkley fluid: the stress at the bed under a steady uniform layer of mean speed v,

    v = n/(n + 1) (tau/K)^(1/n) h (1 - r)^(1 + 1/n) (1 - n/(2n + 1) (1 - r)) ,   r = tau_y/tau

  tau_y  yield stress, Pa
  K      consistency, Pa s^n
  n      exponent
  h      depth, m

  Source: Huang and Garcia (1998), J. Fluid Mech. 374, 305-333, doi:10.1017/S0022112098002845.
*/
#include <math.h>
#include "talus/point/basal.h"

enum { YIELD_STRESS = MPM_BASAL_OWN, CONSISTENCY, EXPONENT };

static const MpmParameter parameters[] = {
  MPM_BASAL_SHARED,
  {MPM_NUMBER, "yield_stress", "Pa", 0., 1, 0., HUGE_VAL, 0, "yield stress", NULL, 500., NULL},
  {MPM_NUMBER, "consistency", "Pa s^n", 0., 1, 0., HUGE_VAL, 1, "consistency", NULL, 200., NULL},
  {MPM_NUMBER, "n", "-", 1., 0, 0., 10., 1, "exponent", NULL, 0.4, NULL}};

/* The mean speed under a stress beyond the yield stress. */
static double Speed(const double *parameter, double depth, double tau)
{
  const double n = parameter[EXPONENT], flows = 1. - parameter[YIELD_STRESS] / tau;

  return n / (n + 1.) * pow(tau / parameter[CONSISTENCY] * flows, 1. / n) * depth * flows *
         (1. - n / (2. * n + 1.) * flows);
}

static double Resistance(const double *parameter, const MpmBasalPoint *point)
{
  const double least = parameter[YIELD_STRESS];
  double       lower = least, upper = 2. * least + parameter[CONSISTENCY];

  if (point->speed <= 0.) return least;
  for (int k = 0; k < 1000 && Speed(parameter, point->depth, upper) < point->speed; k++) upper *= 2.;
  for (int k = 0; k < 100 && upper - lower > 4e-16 * upper; k++) {
    const double middle = 0.5 * (lower + upper);

    if (middle > least && Speed(parameter, point->depth, middle) > point->speed) upper = middle;
    else lower = middle;
  }
  return upper;
}

MPM_BASAL(herschel_bulkley, parameters, NULL, Resistance, "Herschel-Bulkley fluid by its uniform flow")
