#pragma once
/*
  Isotropic functions of symmetric tensors: logarithm, exponential, square root. Included by tensor.h.

  Value and derivative are exact to rounding for any principal values, equal and nearly equal ones included: an
  undeformed or hydrostatic point is the commonest point there is, and formulas that divide by differences of principal
  values fail there.

  Any other isotropic function is given by its principal values as functions of the argument's: SymIsotropic(), below.

  Functions that both dimensions use stand here, the others in isotropic_plane.h and isotropic_solid.h.
*/
#include <float.h>

#define MPM_PAIRS (MPM_DIM == 2 ? 1 : 3)

/* Principal values and axes n of a Sym; in plane strain one of the axes is z, and only the other two make a pair. */
typedef struct {
  double value[3];                      /* largest first */
  double basis[3 + MPM_PAIRS][MPM_SYM]; /* n_a n_a, then, by pair, the symmetric part of n_a n_b */
  int    pair[MPM_PAIRS][2];
  double gap[MPM_PAIRS]; /* value of the first less that of the second, to rounding of itself */
} SymPrincipal;

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

/* Principal values of A, largest first, without axes, as SymSplitValues() has them */
MPM_FN void SymPrincipalValues(const Sym *A, double w[3])
{
  const SymSplit split = SymSplitCreate(A);

  SymSplitValues(&split, w);
}

/* Principal values and axes of A; non-zero when A is not finite */
MPM_FN int SymPrincipalCreate(const Sym *A, SymPrincipal *principal)
{
  const SymSplit split = SymSplitCreate(A);

  return SymSplitPrincipal(&split, principal);
}

/* ---- any isotropic function ---- */

/*
  (y_a - y_b)/(w_a - w_b) of pair k. Where the principal values w nearly coincide, the difference is lost in rounding,
  and its limit replaces it, dy_a/dw_a - dy_a/dw_b, as the mean of both ends; so it does wherever else the difference
  agrees to rounding.
*/
MPM_FN double IsotropicDivided(const SymPrincipal *principal, const Dual y[3], int k)
{
  const int    a = principal->pair[k][0], b = principal->pair[k][1];
  const double gap = principal->gap[k], difference = DualValue(y[a]) - DualValue(y[b]);
  const double slope =
    0.5 * (DualDirection(y[a], a) - DualDirection(y[a], b) + DualDirection(y[b], b) - DualDirection(y[b], a));
  const double largest = fmax(fabs(principal->value[0]), fabs(principal->value[2]));
  const double noise   = 16. * DBL_EPSILON * (fabs(DualValue(y[a])) + fabs(slope) * largest);

  return fabs(gap) <= 1e-8 * largest || fabs(difference - slope * gap) <= noise ? slope : difference / gap;
}

/* A number f that is a function of A's principal values alone, with its derivatives by them in directions 0, 1, 2 */
MPM_FN Scalar SymInvariant(const Sym *A, const SymPrincipal *principal, Dual f)
{
  Scalar c = ScalarConstant(DualReal(f));

  for (int j = 0; j < MPM_SYM && MPM_DIRECTIONS > 0; ++j) {
    double slope = 0.;

    for (int a = 0; a < 3; ++a) slope += DualDirection(f, a) * principal->basis[a][j];
    ScalarAddDirections(&c, (j < 3 ? 1. : 2.) * slope, &A->a[j]);
  }
  return c;
}

/*
  SymIsotropic - the isotropic function of A with principal values y, by principal values w of A in the order of
  SymPrincipalCreate()

  y[a] carries its derivatives by w[0], w[1], w[2] in directions 0, 1, 2: w[a] = DualSeed(principal.value[a], a) and
  Dual arithmetic give them. These derivatives need not be symmetric. The function y of w must not favour an axis:
  exchanging two w exchanges the two y. The result is then exact to rounding for any principal values, equal and nearly
  equal ones included.

  By the theorem of Daleckii and Krein (isotropic_solid.h) the derivative in a direction H is

    sum_ab dy_a/dw_b (n_b . H n_b) n_a n_a + sum_{a != b} (y_a - y_b)/(w_a - w_b) (n_a . H n_b) n_a n_b
*/
MPM_FN Sym SymIsotropic(const Sym *A, const SymPrincipal *principal, const Dual y[3])
{
  double M[MPM_SYM][MPM_SYM] = {{0.}}; /* stored components by stored components, shear of A counted once */
  Sym    c;

  for (int a = 0; a < 3 && MPM_DIRECTIONS > 0; ++a) {
    for (int j = 0; j < MPM_SYM; ++j) {
      double row = 0.;

      for (int b = 0; b < 3; ++b) row += DualDirection(y[a], b) * principal->basis[b][j];
      for (int i = 0; i < MPM_SYM; ++i) M[i][j] += row * principal->basis[a][i];
    }
  }
  for (int k = 0; k < MPM_PAIRS && MPM_DIRECTIONS > 0; ++k) {
    const double *basis = principal->basis[3 + k], twice = 2. * IsotropicDivided(principal, y, k);

    for (int i = 0; i < MPM_SYM; ++i)
      for (int j = 0; j < MPM_SYM; ++j) M[i][j] += twice * basis[i] * basis[j];
  }
  for (int i = 0; i < MPM_SYM; ++i) {
    Real value = 0.;

    for (int a = 0; a < 3; ++a) value += principal->basis[a][i] * DualReal(y[a]);
    c.a[i] = ScalarConstant(value);
    for (int j = 0; j < MPM_SYM && MPM_DIRECTIONS > 0; ++j)
      ScalarAddDirections(&c.a[i], (j < 3 ? 1. : 2.) * M[i][j], &A->a[j]);
  }
  return c;
}
