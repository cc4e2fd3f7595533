#pragma once
/*
  Shared by isotropic elastic laws: parameters, Lame's constants, Hencky's stress. Included by files in materials/.
*/
#include "law.h"

/* The first parameters of every isotropic elastic law, in this order. */
enum { ELASTIC_DENSITY, ELASTIC_E, ELASTIC_NU, ELASTIC_COUNT };

/* clang-format off */
#define ELASTIC_PARAMETERS \
  {MPM_NUMBER, "density", "kg/m3", 0., 0, 0., HUGE_VAL, 0, "mass per initial volume", NULL, 2000., NULL}, \
  {MPM_NUMBER, "E", "Pa", 0., 1, 0., HUGE_VAL, 1, "Young's modulus", NULL, 30e6, NULL}, \
  {MPM_NUMBER, "nu", "-", 0., 1, -1., 0.5, 1, "Poisson's ratio", NULL, 0.3, NULL}
/* clang-format on */

/* Pa */
typedef struct {
  Real lambda, mu;
} Lame;

MPM_FN Lame LameFromParameters(const Real *parameter)
{
  const Real E = parameter[ELASTIC_E], nu = parameter[ELASTIC_NU];
  Lame       lame;

  lame.mu     = 0.5 * E / (1. + nu);
  lame.lambda = E * nu / ((1. + nu) * (1. - 2. * nu));
  return lame;
}

/* Lame's constants from plain numbers, which functions beside the kernel have */
MPM_FN Lame LameFromValues(const double *parameter)
{
  const Real elastic[ELASTIC_COUNT] = {parameter[ELASTIC_DENSITY], parameter[ELASTIC_E], parameter[ELASTIC_NU]};

  return LameFromParameters(elastic);
}

/*
  Stiffness of a law whose elasticity is Hooke's or Hencky's: lambda + 2 mu at any state, for Hencky's that of the
  Kirchhoff stress by the logarithmic strain. Unloading from a plastic state is as stiff.
*/
MPM_FN double ElasticStiffness(const double *parameter, const MpmLawTable *table, const double *state, const double *F)
{
  const Lame lame = LameFromValues(parameter);

  (void)table, (void)state, (void)F;
  return RealValue(lame.lambda + 2. * lame.mu);
}

/* Shear modulus of such a law: mu at any state */
MPM_FN double ElasticShearModulus(const double *parameter, const MpmLawTable *table, const double *state,
                                  const double *F)
{
  (void)table, (void)state, (void)F;
  return RealValue(LameFromValues(parameter).mu);
}

/* Both, at any state (MPM_LAW_MODULI()) */
MPM_FN void ElasticModuli(const Real *parameter, const Real *state, const Real *F, Real moduli[3])
{
  const Lame lame = LameFromParameters(parameter);

  (void)state, (void)F;
  moduli[0] = moduli[1] = lame.mu;
  moduli[2]             = lame.lambda + 2. * lame.mu;
}

/* s:s/(4 mu), the energy of elastic shear at a Kirchhoff stress with the deviator s; `pressure` becomes -tr(tau)/3 */
MPM_FN double ElasticShearEnergy(const double *tau, double mu, double *pressure)
{
  const double mean = (tau[0] + tau[1] + tau[2]) / 3.;
  double       sum  = 0.;

  for (int i = 0; i < MPM_SYM; ++i) {
    const double s = tau[i] - (i < 3 ? mean : 0.);

    sum += (i < 3 ? 1. : 2.) * s * s;
  }
  *pressure = -mean;
  return sum / (4. * mu);
}

/* lambda tr(e) I + 2 mu e: Hooke's law, or Hencky's where e is the logarithmic strain */
MPM_FN Sym ElasticStress(Lame lame, const Sym *e)
{
  const Sym deviatoric = SymScaleBy(2. * lame.mu, e);

  return SymShift(&deviatoric, ScalarScale(lame.lambda, SymTrace(e)));
}

/* Excess over a yield surface, in strain, that rounding alone explains: a point at rest on the surface is treated as
   elastic. */
#define ELASTIC_STRAIN_NOISE (64. * DBL_EPSILON)

/* Logarithmic strain (1/2) ln b; non-zero when b is not positive definite or not finite */
MPM_FN int ElasticLogStrain(const Sym *b, Sym *e)
{
  Sym twice;

  if (SymLog(b, &twice)) return 1;
  *e = SymScaleBy(0.5, &twice);
  return 0;
}

/* b = exp(2 e), the inverse of ElasticLogStrain(); non-zero when b is not finite */
MPM_FN int ElasticLeftCauchyGreen(const Sym *e, Sym *b)
{
  const Sym twice = SymScaleBy(2., e);

  return SymExp(&twice, b);
}

/* Growth of the equivalent plastic strain: sqrt(2/3) |dev e_p|, where flow takes e_p from the trial elastic strain */
MPM_FN Real ElasticPlasticGrowth(const Sym *trial, const Sym *end)
{
  const Sym taken = SymSub(trial, end), dev = SymDev(&taken);

  if (!(SymNormValue(&dev) > ELASTIC_STRAIN_NOISE)) return 0.;
  return sqrt(2. / 3.) * ScalarReal(SymNorm(&dev));
}

/*
  History that begins with the elastic left Cauchy-Green tensor b, from a given Kirchhoff stress of Hencky's elasticity:
  b = exp(2 e), e = (tau - lambda/(3 lambda + 2 mu) tr(tau) I)/(2 mu). Other variables stay.
*/
MPM_FN int ElasticHistory(const double *parameter, const MpmLawTable *table, const double *stress, double *state)
{
  const Lame   lame   = LameFromValues(parameter);
  const double lambda = RealValue(lame.lambda), mu = RealValue(lame.mu);
  const double mean = lambda / (3. * lambda + 2. * mu) * (stress[0] + stress[1] + stress[2]);
  Sym          e, b;

  (void)table;
  for (int i = 0; i < MPM_SYM; ++i) e.a[i] = ScalarConstant((stress[i] - (i < 3 ? mean : 0.)) / (2. * mu));
  if (ElasticLeftCauchyGreen(&e, &b)) return 1;
  SymValues(state, &b);
  return 0;
}

/* Whether det F, F = dF F_n, is a positive finite number: no law has an answer otherwise. False for NaN. */
MPM_FN int ElasticIsRegular(const MpmLawPoint *point, const Tensor *dF)
{
  const double J = TensorDetValue(dF) * ArrayDetValue(point->F_n);

  return J > 0. && J <= DBL_MAX;
}
