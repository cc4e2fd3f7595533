/*
  SamosAT's law for snow avalanches:

    tau = tau_0 + mu (1 + R_0/(R_0 + R)) N + rho v^2/(ln(h/d)/kappa + B)^2 ,   R = rho v^2/N

  N      pressure normal to the bed, Pa
  d      roughness of the bed, m; h/d counts as 1 at least
  R_0, kappa, B  constants of the law

  Friction falls with the speed by its second part until turbulence outweighs that: it is held by that at rest, and goes
  on by the law.

  Source: Sampl and Zwinger (2004), Ann. Glaciol. 38, 393-398, doi:10.3189/172756404781814780.
*/
#include <math.h>
#include "talus/point/basal.h"

enum { MU = MPM_BASAL_OWN, TAU_0, R_0, KAPPA, ROUGHNESS, B };

static const MpmParameter parameters[] = {
  MPM_BASAL_SHARED,
  {MPM_NUMBER, "mu", "-", 0.155, 0, 0., HUGE_VAL, 0, "coefficient of friction", NULL, 0.155, NULL},
  {MPM_NUMBER, "tau_0", "Pa", 0., 0, 0., HUGE_VAL, 0, "yield stress", NULL, 0., NULL},
  {MPM_NUMBER, "R_0", "-", 0.222, 0, 0., HUGE_VAL, 1, "fluidisation at which the added friction has halved", NULL,
   0.222, NULL},
  {MPM_NUMBER, "kappa", "-", 0.43, 0, 0., HUGE_VAL, 1, "von Karman's constant", NULL, 0.43, NULL},
  {MPM_NUMBER, "roughness", "m", 0.05, 0, 0., HUGE_VAL, 1, "of the bed", NULL, 0.05, NULL},
  {MPM_NUMBER, "B", "-", 4.13, 0, 0., HUGE_VAL, 1, "constant of the logarithmic profile", NULL, 4.13, NULL}};

static double Resistance(const double *parameter, const MpmBasalPoint *point)
{
  const double square = parameter[MPM_BASAL_DENSITY] * point->speed * point->speed, N = point->pressure;
  const double profile = log(fmax(point->depth / parameter[ROUGHNESS], 1.)) / parameter[KAPPA] + parameter[B];
  const double R       = N > 0. ? square / N : HUGE_VAL;
  const double added   = R < HUGE_VAL ? parameter[R_0] / (parameter[R_0] + R) : 0.;

  return parameter[TAU_0] + parameter[MU] * (1. + added) * N + square / (profile * profile);
}

MPM_BASAL(samosat, parameters, NULL, Resistance, "SamosAT's law for snow avalanches")
