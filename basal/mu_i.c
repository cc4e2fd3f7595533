/*
  Dense granular flow, mu(I):

    tau = (mu_s + (mu_2 - mu_s) I/(I_0 + I)) N ,   I = 5 v d/(2 h sqrt(phi N/rho))

  I is the inertial number of a steady uniform layer of mean speed v, the same over its depth.

  N     pressure normal to the bed, Pa
  d     diameter of the grains, m
  phi   their volume over that of the mixture
  h     depth, m

  Source: Jop, Forterre and Pouliquen (2006), Nature 441, 727-730, doi:10.1038/nature04801; Gray and Edwards (2014), J.
  Fluid Mech. 755, 503-534, doi:10.1017/jfm.2014.450, for the layer.
*/
#include <math.h>
#include "talus/point/basal.h"

enum { MU_S = MPM_BASAL_OWN, MU_2, I_0, DIAMETER, FRACTION };

static const MpmParameter parameters[] = {
  MPM_BASAL_SHARED,
  {MPM_NUMBER, "mu_s", "-", 0., 1, 0., HUGE_VAL, 0, "friction of slow flow", NULL, 0.38, NULL},
  {MPM_NUMBER, "mu_2", "-", 0., 1, 0., HUGE_VAL, 0, "friction of fast flow", NULL, 0.64, NULL},
  {MPM_NUMBER, "I_0", "-", 0.3, 0, 0., HUGE_VAL, 1, "inertial number halfway between", NULL, 0.3, NULL},
  {MPM_NUMBER, "diameter", "m", 0., 1, 0., HUGE_VAL, 1, "of the grains", NULL, 0.01, NULL},
  {MPM_NUMBER, "fraction", "-", 0.6, 0, 0., 1., 1, "volume of grains over that of the mixture", NULL, 0.6, NULL}};

static double Resistance(const double *parameter, const MpmBasalPoint *point)
{
  const double N     = point->pressure;
  const double scale = sqrt(parameter[FRACTION] * N / parameter[MPM_BASAL_DENSITY]);
  const double I     = scale > 0. ? 2.5 * point->speed * parameter[DIAMETER] / (point->depth * scale) : 0.;

  return (parameter[MU_S] + (parameter[MU_2] - parameter[MU_S]) * I / (parameter[I_0] + I)) * N;
}

static int Check(const double *parameter, const MpmLawTable *table, MpmLawFault *fault)
{
  (void)table;
  *fault = (MpmLawFault){MU_2, parameter[MU_S], HUGE_VAL, 0, "friction does not fall with the speed"};
  return parameter[MU_2] >= parameter[MU_S];
}

MPM_BASAL(mu_i, parameters, Check, Resistance, "dense granular flow by its inertial number")
