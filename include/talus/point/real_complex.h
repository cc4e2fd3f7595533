#pragma once
/*
  Real with a derivative in one direction, in C: a complex number whose imaginary part is the derivative times
  REAL_STEP, the complex step (Squire and Trapp 1998, doi:10.1137/S003614459631241X), so small that its square vanishes
  against any value and the derivative is exact to rounding. Included by real.h.
*/
#include <complex.h>
#undef I      /* an identity here */
#ifndef CMPLX /* of C11; the C library has it for GCC alone */
#define CMPLX(re, im) __builtin_complex((double)(re), (double)(im))
#endif

#define REAL_DIRECTIONS 1
#define REAL_STEP       0x1p-500

typedef double _Complex Real;

MPM_FN double RealValue(Real a)
{
  return creal(a);
}

/* The derivative in direction k. */
MPM_FN double RealDirection(Real a, int k)
{
  (void)k;
  return cimag(a) * (1. / REAL_STEP);
}

/* A value with its derivatives in the first `width` directions. */
MPM_FN Real RealLoad(double value, const double *direction, int width)
{
  (void)width;
  return CMPLX(value, direction[0] * REAL_STEP);
}

/* The derivatives of a, into the first `width` numbers. */
MPM_FN void RealStore(Real a, double *direction, int width)
{
  (void)width;
  direction[0] = RealDirection(a, 0);
}

/* f(a), given f and its derivative fa at the value of a. */
MPM_FN Real RealChain(Real a, double f, double fa)
{
  return CMPLX(f, fa * cimag(a));
}

/* f(a, b), given f and its derivatives fa, fb at the values of a and b. */
MPM_FN Real RealChain2(Real a, Real b, double f, double fa, double fb)
{
  return CMPLX(f, fa * cimag(a) + fb * cimag(b));
}

/* Whether a is 0, with its derivative: only then may it be left out. */
MPM_FN int RealVanishes(Real a)
{
  return creal(a) == 0. && cimag(a) == 0.;
}
