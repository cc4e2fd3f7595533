#pragma once
/*
  Functions that are smooth at 0, where their formulas are 0/0.
*/
#include "dual.h"

#define MPM_SERIES 0.05 /* magnitude of the argument below which series are summed */

/* sum_k coefficient[k] x^k, k < count, and its derivative */
MPM_FN void SeriesSum(const double coefficient[], int count, double x, double *f, double *slope)
{
  *f     = coefficient[count - 1];
  *slope = 0.;
  for (int k = count - 2; k >= 0; --k) {
    *slope = *slope * x + *f;
    *f     = *f * x + coefficient[k];
  }
}

/* expm1(u)/u */
MPM_FN Dual DualExpm1Ratio(Dual u)
{
  const double a[] = {1.,        1. / 2.,    1. / 6.,     1. / 24.,     1. / 120.,
                      1. / 720., 1. / 5040., 1. / 40320., 1. / 362880., 1. / 3628800.};
  const double x   = DualValue(u);
  double       f, slope;

  if (fabs(x) < MPM_SERIES) {
    SeriesSum(a, (int)MPM_ROWS(a), x, &f, &slope);
  } else {
    const double growth = expm1(x);

    f     = growth / x;
    slope = (growth + 1. - f) / x;
  }
  return DualChain(u, f, slope);
}

/* log1p(u)/u */
MPM_FN Dual DualLog1pRatio(Dual u)
{
  const double a[] = {1.,       -1. / 2., 1. / 3.,   -1. / 4., 1. / 5.,   -1. / 6., 1. / 7.,
                      -1. / 8., 1. / 9.,  -1. / 10., 1. / 11., -1. / 12., 1. / 13., -1. / 14.};
  const double x   = DualValue(u);
  double       f, slope;

  if (fabs(x) < MPM_SERIES) {
    SeriesSum(a, (int)MPM_ROWS(a), x, &f, &slope);
  } else {
    f     = log1p(x) / x;
    slope = (1. / (1. + x) - f) / x;
  }
  return DualChain(u, f, slope);
}
