/*
  Voellmy's law with cohesion:

    tau = mu N + rho g v^2/xi + (1 - mu) c (1 - exp(-N/c))

  N   pressure normal to the bed, Pa
  mu  coefficient of dry friction
  xi  coefficient of turbulent friction, m/s2
  c   cohesion, Pa; 0: none

  Source: Voellmy (1955), Schweizerische Bauzeitung 73; Bartelt, Valero, Feistl, Christen, Buehler and Buser (2015), J.
  Glaciol. 61, 837-850, doi:10.3189/2015JoG14J168, for the cohesion.
*/
#include <math.h>
#include "talus/point/basal.h"

enum { MU = MPM_BASAL_OWN, XI, COHESION };

static const MpmParameter parameters[] = {
  MPM_BASAL_SHARED,
  {MPM_NUMBER, "mu", "-", 0., 1, 0., 1., 0, "coefficient of dry friction", NULL, 0.155, NULL},
  {MPM_NUMBER, "xi", "m/s2", 0., 1, 0., HUGE_VAL, 1, "coefficient of turbulent friction", NULL, 1750., NULL},
  {MPM_NUMBER, "cohesion", "Pa", 0., 0, 0., HUGE_VAL, 0, "cohesion", NULL, 100., NULL}};

static double Resistance(const double *parameter, const MpmBasalPoint *point)
{
  const double mu = parameter[MU], c = parameter[COHESION], v = point->speed, N = point->pressure;
  const double cohesive = c > 0. ? (1. - mu) * c * (1. - exp(-N / c)) : 0.;

  return mu * N + parameter[MPM_BASAL_DENSITY] * parameter[MPM_BASAL_GRAVITY] * v * v / parameter[XI] + cohesive;
}

MPM_BASAL(voellmy, parameters, NULL, Resistance, "Voellmy's dry and turbulent friction, with cohesion")
