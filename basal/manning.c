/*
  Manning's law:  tau = rho g n^2 v^2/h^(1/3)

  n   roughness, s/m^(1/3)
  h   depth, m

  Source: Chow (1959), Open-Channel Hydraulics, section 5-6.
*/
#include <math.h>
#include "talus/point/basal.h"

enum { ROUGHNESS = MPM_BASAL_OWN };

static const MpmParameter parameters[] = {
  MPM_BASAL_SHARED, {MPM_NUMBER, "n", "s/m^(1/3)", 0., 1, 0., HUGE_VAL, 0, "roughness", NULL, 0.03, NULL}};

static double Resistance(const double *parameter, const MpmBasalPoint *point)
{
  const double nv = parameter[ROUGHNESS] * point->speed;

  return parameter[MPM_BASAL_DENSITY] * parameter[MPM_BASAL_GRAVITY] * nv * nv / cbrt(point->depth);
}

MPM_BASAL(manning, parameters, NULL, Resistance, "Manning's roughness")
