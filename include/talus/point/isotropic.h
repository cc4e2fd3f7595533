#pragma once
/*
  Isotropic functions of symmetric tensors: logarithm, exponential, square root. Included by tensor.h.

  Value and derivative are exact to rounding for any principal values, equal and nearly equal ones included: an
  undeformed or hydrostatic point is the commonest point there is, and formulas that divide by differences of principal
  values fail there.

  Functions that both dimensions use stand here, the rest in isotropic_plane.h and isotropic_solid.h.
*/
#include <float.h>

/* sum_{k <= terms} s^k/(2k + 1) and its derivative, which are artanh(sqrt s)/sqrt s and its derivative for small s */
MPM_FN void IsotropicArtanhSeries(int terms, double s, double *g, double *dg)
{
  double sum = 1. / (2 * terms + 1), derivative = 0.;

  for (int k = terms - 1; k >= 0; --k) {
    derivative = derivative * s + sum;
    sum        = sum * s + 1. / (2 * k + 1);
  }
  *g  = sum;
  *dg = derivative;
}

/*
  g(s) = artanh(sqrt s)/sqrt s and g'(s) for 0 <= s < 1; `complement` is 1 - s, which the caller has without
  cancellation. The derivative's closed form cancels at small s.
*/
MPM_FN void IsotropicArtanh(double s, double complement, double *g, double *dg)
{
  if (s < 1e-3) {
    IsotropicArtanhSeries(6, s, g, dg);
  } else if (s < 0.02) {
    IsotropicArtanhSeries(10, s, g, dg);
  } else {
    const double r = sqrt(s);

    *g  = 0.5 * log((1. + r) * (1. + r) / complement) / r;
    *dg = (1. / complement - *g) / (2. * s);
  }
}

/* c = cosh r, h = sinh r / r and dh = dh/dq as functions of q = r^2; dc/dq is h/2 */
MPM_FN void IsotropicHyperbolic(double q, double *c, double *h, double *dh)
{
  if (q < 1.) {
    double sum = 1., derivative = 0.;

    /* h = 1 + q/6 (1 + q/20 (1 + ... (1 + q/(2k (2k + 1)))), enough terms for q = 1 */
    for (int k = 10; k >= 1; --k) {
      const double factor = 1. / (2 * k * (2 * k + 1));

      derivative = factor * (sum + q * derivative);
      sum        = 1. + factor * q * sum;
    }
    *h  = sum;
    *dh = derivative;
    *c  = sum + 2. * q * derivative;
  } else {
    const double r = sqrt(q);

    *c  = cosh(r);
    *h  = sinh(r) / r;
    *dh = (*c - *h) / (2. * q);
  }
}

#if MPM_DIM == 2
#include "isotropic_plane.h"
#else
#include "isotropic_solid.h"
#endif
