/*
  Coulomb friction:  tau = mu N

  N   pressure normal to the bed, Pa
  mu  coefficient, or tan of the angle `friction`

  Source: Savage and Hutter (1989), J. Fluid Mech. 199, 177-215, doi:10.1017/S0022112089000340.
*/
#include <math.h>
#include "talus/point/basal.h"

enum { MU = MPM_BASAL_OWN, FRICTION };

static const MpmParameter parameters[] = {
  MPM_BASAL_SHARED,
  {MPM_NUMBER, "mu", "-", HUGE_VAL, 0, 0., HUGE_VAL, 0, "coefficient of friction, or friction; 0: none", NULL, 0.2,
   NULL},
  {MPM_NUMBER, "friction", "degrees", HUGE_VAL, 0, 0., 90., 0, "instead of mu: its angle", NULL, 12., NULL}};

static double Resistance(const double *parameter, const MpmBasalPoint *point)
{
  const double mu =
    parameter[MU] < HUGE_VAL ? parameter[MU] : tan(parameter[FRICTION] * (3.14159265358979323846 / 180.));

  return mu * point->pressure;
}

static int Check(const double *parameter, const MpmLawTable *table, MpmLawFault *fault)
{
  const int         mu = parameter[MU] < HUGE_VAL, friction = parameter[FRICTION] < HUGE_VAL;
  const MpmLawFault both = {-1, 0., 0., 0, "mu and friction are given, and one makes the other"};
  const MpmLawFault none = {-1, 0., 0., 0, "mu or friction must be given"};

  (void)table;
  *fault = mu ? both : none;
  return mu != friction;
}

MPM_BASAL(coulomb, parameters, Check, Resistance, "Coulomb friction on the bed")
