#pragma once
/*
  Real: the number type of a law's arguments besides the step's increment: parameters, history, deformation gradient.
  Included by dual.h.

  A double, so that it costs nothing. In the instances with MPM_SENSITIVITY, which differentiate by these, a complex
  number whose imaginary part is the derivative in the one direction of that instance, times REAL_STEP: the complex step
  (Squire and Trapp 1998, doi:10.1137/S003614459631241X), so small that its square vanishes against any value and the
  derivative is exact to rounding. Thus + - * / stay in laws; assigning a Real to a double, which would lose the
  derivative, is a warning, and comparing two Reals an error. A class may serve in C++.
*/
#include <math.h>

#if defined(MPM_SENSITIVITY)
#include <complex.h>
#undef I      /* an identity here */
#ifndef CMPLX /* of C11; the C library has it for GCC alone */
#define CMPLX(re, im) __builtin_complex((double)(re), (double)(im))
#endif

typedef double _Complex Real;

#define REAL_STEP 0x1p-500

MPM_FN double RealValue(Real a)
{
  return creal(a);
}

MPM_FN double RealDirection(Real a)
{
  return cimag(a) * (1. / REAL_STEP);
}

/* A value with its derivative in the instance's direction. */
MPM_FN Real RealAlong(double value, double derivative)
{
  return CMPLX(value, derivative * REAL_STEP);
}

/* f(a), given f and its derivative fa at the value of a. */
MPM_FN Real RealChain(Real a, double f, double fa)
{
  return CMPLX(f, fa * cimag(a));
}

/* Whether a is 0, with its derivative: only then may it be left out. */
MPM_FN int RealVanishes(Real a)
{
  return creal(a) == 0. && cimag(a) == 0.;
}

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

  return RealAlong(f, f * (RealValue(b) / RealValue(a) * RealDirection(a) + log(RealValue(a)) * RealDirection(b)));
#else
  return pow(a, b);
#endif
}
