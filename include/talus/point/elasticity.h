#pragma once
/*
  What isotropic elastic laws have in common: parameters, Lame's constants, Hencky's stress. Included by files in
  materials/.
*/
#include "law.h"

/* The first parameters of every isotropic elastic law, in this order. */
enum { ELASTIC_DENSITY, ELASTIC_E, ELASTIC_NU, ELASTIC_COUNT };

/* clang-format off */
#define ELASTIC_PARAMETERS \
  {"density", "kg/m3", 0., 0, 0., HUGE_VAL, 0, "mass per initial volume", NULL}, \
  {"E", "Pa", 0., 1, 0., HUGE_VAL, 1, "Young's modulus", NULL}, \
  {"nu", "-", 0., 1, -1., 0.5, 1, "Poisson's ratio", NULL}
/* clang-format on */

/* Pa */
typedef struct {
  double lambda, mu;
} Lame;

MPM_FN Lame LameFromParameters(const double *parameter)
{
  const double E = parameter[ELASTIC_E], nu = parameter[ELASTIC_NU];
  Lame         lame;

  lame.mu     = 0.5 * E / (1. + nu);
  lame.lambda = E * nu / ((1. + nu) * (1. - 2. * nu));
  return lame;
}

/* Constrained modulus lambda + 2 mu, Pa */
MPM_FN double ElasticStiffness(const double *parameter)
{
  const Lame lame = LameFromParameters(parameter);

  return lame.lambda + 2. * lame.mu;
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

/* Whether det F, F = dF F_n, is a positive finite number: no law has an answer otherwise. False for NaN. */
MPM_FN int ElasticIsRegular(const MpmLawPoint *point, const Tensor *dF)
{
  const double J = TensorDetValue(dF) * MpmDeterminant(MPM_DIM, point->F_n);

  return J > 0. && J <= DBL_MAX;
}
