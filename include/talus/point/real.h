#pragma once
/*
  Real: the number type of a law's arguments besides the step's increment: parameters, history, deformation gradient.
  Included by dual.h.

  A double, so that it costs nothing. In the instances with MPM_SENSITIVITY, which differentiate by these, it carries
  derivatives in REAL_DIRECTIONS directions: compiled as C++ in eight, a class (real_pack.h); as C, which has one such
  type, in one, a complex number (real_complex.h). Thus + - * / stay in laws; assigning a Real to a double, which would
  lose the derivative, is a warning or an error, and comparing two Reals an error.
*/
#include <math.h>

/* Derivatives as arrays have them: of each number a row of `stride`, of which Reals take `count` from `first` on. */
typedef struct {
  int first, count, stride;
} RealColumns;

#define RealRow(array_, k_, columns_) (&(array_)[(k_) * (columns_).stride + (columns_).first])

#if defined(MPM_SENSITIVITY) && defined(__cplusplus)
#include "real_pack.h"
#elif defined(MPM_SENSITIVITY)
#include "real_complex.h"
#else

typedef double Real;

MPM_FN double RealValue(Real a)
{
  return a;
}

MPM_FN Real RealChain(Real a, double f, double fa)
{
  (void)a;
  (void)fa;
  return f;
}

MPM_FN int RealVanishes(Real a)
{
  return a == 0.;
}
#endif

/* Has no derivative at 0: test the value first. */
MPM_FN Real RealSqrt(Real a)
{
  const double f = sqrt(RealValue(a));

  return RealChain(a, f, 0.5 / f);
}

MPM_FN Real RealLog(Real a)
{
  return RealChain(a, log(RealValue(a)), 1. / RealValue(a));
}

MPM_FN Real RealExp(Real a)
{
  const double f = exp(RealValue(a));

  return RealChain(a, f, f);
}

MPM_FN Real RealSin(Real a)
{
  return RealChain(a, sin(RealValue(a)), cos(RealValue(a)));
}

MPM_FN Real RealCos(Real a)
{
  return RealChain(a, cos(RealValue(a)), -sin(RealValue(a)));
}

MPM_FN Real RealTan(Real a)
{
  const double f = tan(RealValue(a));

  return RealChain(a, f, 1. + f * f);
}

/* a^b for a > 0 */
MPM_FN Real RealPow(Real a, Real b)
{
#if defined(MPM_SENSITIVITY)
  const double f = pow(RealValue(a), RealValue(b));

  return RealChain2(a, b, f, f * RealValue(b) / RealValue(a), f * log(RealValue(a)));
#else
  return pow(a, b);
#endif
}
