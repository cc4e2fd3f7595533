#pragma once
/*
  The solid's kernel for Hencky's law in plane strain with its tangent derived by hand: what the one by dual numbers is
  measured against. For the benchmark alone; the engine has no tangent that is not derived automatically.

  With f = dF the step's increment, F = f F_n, b = F F^T with half trace m, deviator D = (d, b_xy), r = |D| and
  t = r/m, the principal values of b are L = m +- r and n_1, n_2 its principal directions. As ln J = tr e,

    tau = p I + mu (g/m) D,   p = (lambda + mu) ln J,   g = artanh(t)/t ,   tau_1, tau_2 = p +- mu g t

  and the flux is P = V_0 tau f^{-T}. Its derivative by f, pushed forward to f = I, is
  a_ijkl = c_ijkl + delta_ik tau_jl; in the principal frame

    c_aaaa = lambda + 2 mu - 2 tau_a,   c_1122 = lambda,
    c_1212 = c_1221 = (tau_1 L_2 - tau_2 L_1)/(L_1 - L_2) = mu g - p ,

  where the last form does not divide by the difference of principal values. Pulled back with N_a = f^{-1} n_a the
  tangent is a sum of eight dyads of M_ab = n_a (x) N_b.

  Source of c and a: Simo (1992), doi:10.1016/0045-7825(92)90123-2; de Souza Neto, Peric and Owen (2008), chapter 14,
  doi:10.1002/9780470694626.
*/
#include <float.h>
#include <math.h>
#include "talus/point/tables.h"

/* artanh(t)/t; `square` is t^2 and `quotient` (1 + t)^2/(1 - t^2), which the caller has without cancellation */
static inline double HenckyArtanhRatio(double square, double quotient)
{
  double sum = 1. / 19.;

  if (square >= 0.02) return 0.5 * log(quotient) / sqrt(square);
  for (int k = 8; k >= 0; k--) sum = sum * square + 1. / (2 * k + 1);
  return sum;
}

/* The first principal direction of a deviator (d, xy) of length r: the half angle, from whichever side is stable. */
static inline void HenckyDirection(double d, double xy, double r, double n[2])
{
  if (r == 0.) {
    n[0] = 1.;
    n[1] = 0.;
  } else if (d >= 0.) {
    n[0] = sqrt(0.5 + 0.5 * d / r);
    n[1] = xy / (2. * r * n[0]);
  } else {
    n[1] = sqrt(0.5 - 0.5 * d / r);
    n[0] = xy / (2. * r * n[1]);
  }
}

/* Non-zero where det F is not a positive finite number. */
static inline int HenckyTangent(const MpmKernelPoint *point, const double *input, double *flux, double *tangent)
{
  const double E = point->material.parameter[1], nu = point->material.parameter[2], V = point->volume0,
               *F_n = point->F_n;
  const double mu = 0.5 * E / (1. + nu), lambda = E * nu / ((1. + nu) * (1. - 2. * nu));
  const double f[4] = {1. + input[0], input[1], input[2], 1. + input[3]};
  const double F[4] = {f[0] * F_n[0] + f[1] * F_n[2], f[0] * F_n[1] + f[1] * F_n[3], f[2] * F_n[0] + f[3] * F_n[2],
                       f[2] * F_n[1] + f[3] * F_n[3]};
  const double J    = F[0] * F[3] - F[1] * F[2];
  if (!(J > 0. && J <= DBL_MAX)) return 1;

  const double inverse = 1. / (f[0] * f[3] - f[1] * f[2]);
  const double fi[4]   = {inverse * f[3], -inverse * f[1], -inverse * f[2], inverse * f[0]};
  const double bxx = F[0] * F[0] + F[1] * F[1], byy = F[2] * F[2] + F[3] * F[3], bxy = F[0] * F[2] + F[1] * F[3];
  const double m = 0.5 * (bxx + byy), d = 0.5 * (bxx - byy), r = sqrt(d * d + bxy * bxy), t = r / m;
  const double g = HenckyArtanhRatio(t * t, (m + r) * (m + r) / (J * J));
  const double p = (lambda + mu) * log(J), s = mu * g * t, k = mu * g / m;
  const double txx = V * (p + k * d), tyy = V * (p - k * d), txy = V * k * bxy;

  flux[0] = txx * fi[0] + txy * fi[1];
  flux[1] = txx * fi[2] + txy * fi[3];
  flux[2] = txy * fi[0] + tyy * fi[1];
  flux[3] = txy * fi[2] + tyy * fi[3];
  {
    const double gamma = V * (mu * g - p), l = V * lambda, a1111 = V * (lambda + 2. * mu - p - s),
                 a2222 = V * (lambda + 2. * mu - p + s), a1212 = gamma + V * (p - s), a2121 = gamma + V * (p + s);
    double n[2];

    HenckyDirection(d, bxy, r, n);
    const double N1[2]  = {fi[0] * n[0] + fi[1] * n[1], fi[2] * n[0] + fi[3] * n[1]};
    const double N2[2]  = {fi[1] * n[0] - fi[0] * n[1], fi[3] * n[0] - fi[2] * n[1]};
    const double M11[4] = {n[0] * N1[0], n[0] * N1[1], n[1] * N1[0], n[1] * N1[1]};
    const double M22[4] = {-n[1] * N2[0], -n[1] * N2[1], n[0] * N2[0], n[0] * N2[1]};
    const double M12[4] = {n[0] * N2[0], n[0] * N2[1], n[1] * N2[0], n[1] * N2[1]};
    const double M21[4] = {-n[1] * N1[0], -n[1] * N1[1], n[0] * N1[0], n[0] * N1[1]};

    for (int i = 0; i < 4; i++) {
      const double u = a1111 * M11[i] + l * M22[i], v = l * M11[i] + a2222 * M22[i];
      const double w = a1212 * M12[i] + gamma * M21[i], z = gamma * M12[i] + a2121 * M21[i];

      for (int j = 0; j < 4; j++) tangent[4 * i + j] = u * M11[j] + v * M22[j] + w * M12[j] + z * M21[j];
    }
  }
  return 0;
}
