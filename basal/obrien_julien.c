/*
  O'Brien and Julien's quadratic law:

    tau = tau_y + K eta v/(8 h) + rho g n^2 v^2/h^(1/3)

  tau_y  yield stress, Pa
  eta    viscosity, Pa s
  K      of laminar flow; 24 of a smooth wide channel
  n      roughness, turbulence and dispersion together, s/m^(1/3)
  h      depth, m

  Source: O'Brien, Julien and Fullerton (1993), J. Hydraul. Eng. 119, 244-261,
  doi:10.1061/(ASCE)0733-9429(1993)119:2(244).
*/
#include <math.h>
#include "talus/point/basal.h"

enum { YIELD_STRESS = MPM_BASAL_OWN, VISCOSITY, LAMINAR, ROUGHNESS };

static const MpmParameter parameters[] = {
  MPM_BASAL_SHARED,
  {MPM_NUMBER, "yield_stress", "Pa", 0., 1, 0., HUGE_VAL, 0, "yield stress", NULL, 500., NULL},
  {MPM_NUMBER, "viscosity", "Pa s", 0., 1, 0., HUGE_VAL, 0, "viscosity", NULL, 10., NULL},
  {MPM_NUMBER, "K", "-", 24., 0, 0., HUGE_VAL, 0, "resistance of laminar flow", NULL, 24., NULL},
  {MPM_NUMBER, "n", "s/m^(1/3)", 0., 1, 0., HUGE_VAL, 0, "roughness", NULL, 0.05, NULL}};

static double Resistance(const double *parameter, const MpmBasalPoint *point)
{
  const double v = point->speed, nv = parameter[ROUGHNESS] * v;

  return parameter[YIELD_STRESS] + parameter[LAMINAR] * parameter[VISCOSITY] * v / (8. * point->depth) +
         parameter[MPM_BASAL_DENSITY] * parameter[MPM_BASAL_GRAVITY] * nv * nv / cbrt(point->depth);
}

MPM_BASAL(obrien_julien, parameters, NULL, Resistance, "yield stress, viscosity and turbulence of O'Brien and Julien")
