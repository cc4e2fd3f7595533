#pragma once
/*
  Isotropic functions of nearly isotropic tensors in 3D. Included by isotropic_solid.h.

  Logarithm and exponential of a tensor whose principal values are close to each other, as elastic strains make them,
  are power series of the deviator: no principal directions, and nothing that could be singular.
*/

/* |dev A| up to which (relative to the mean principal value in a logarithm) the series is used, and up to which half
   its terms do. */
#define ISOTROPIC_SERIES_RANGE 0.14
#define ISOTROPIC_SERIES_CLOSE 0.014

/* c0, c1, c2 and their derivatives by J2 and J3 */
typedef struct {
  double c[3], by_J2[3], by_J3[3];
} IsotropicCoefficients;

/*
  sum_k a[k] X^k over k = 1..terms for a deviatoric X with J2 = X:X/2, J3 = det X is c0 I + c1 X + c2 X^2. By the
  theorem of Cayley and Hamilton X^3 = J2 X + J3 I, so X^k = J3 g_{k-1} I + g_{k+1} X + g_k X^2 with g_{k+2} = J2 g_k +
  J3 g_{k-1}, g_1 = 0, g_2 = 1. Of the derivatives of g_k, p_k by J2 and q_k by J3, the latter is p_{k-1}.
*/
MPM_FN IsotropicCoefficients IsotropicSeries(const double *a, int terms, double J2, double J3)
{
  double                g[4] = {0., 0., 0., 1.}, p[4] = {0., 0., 0., 0.}; /* of k - 2, k - 1, k, k + 1 */
  double                G[3] = {0., 0., 0.}, P[4] = {0., 0., 0., 0.};     /* sums of a_k g_{k-1}.. and a_k p_{k-2}.. */
  IsotropicCoefficients of;

  for (int k = 1; k <= terms; ++k) {
    const double next_g = J2 * g[2] + J3 * g[1], next_p = g[2] + J2 * p[2] + J3 * p[1];

    for (int i = 0; i < 3; ++i) G[i] += a[k] * g[i + 1];
    for (int i = 0; i < 4; ++i) P[i] += a[k] * p[i];
    for (int i = 0; i < 3; ++i) g[i] = g[i + 1];
    for (int i = 0; i < 3; ++i) p[i] = p[i + 1];
    g[3] = next_g;
    p[3] = next_p;
  }
  of.c[0]     = J3 * G[0];
  of.c[1]     = G[2];
  of.c[2]     = G[1];
  of.by_J2[0] = J3 * P[1];
  of.by_J2[1] = P[3];
  of.by_J2[2] = P[2];
  of.by_J3[0] = G[0] + J3 * P[0];
  of.by_J3[1] = P[2];
  of.by_J3[2] = P[1];
  return of;
}

/* A A of a plain Sym */
MPM_FN void IsotropicSquare(const double A[6], double square[6])
{
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, ij = 3 + i, jk = 3 + j, ik = 3 + (i + 2) % 3;

    square[i]  = A[i] * A[i] + A[ij] * A[ij] + A[ik] * A[ik];
    square[ij] = A[i] * A[ij] + A[ij] * A[j] + A[ik] * A[jk];
  }
}

/* M += factor (H -> X H + H X), on the stored components of a Sym */
MPM_FN void IsotropicAddAnticommutator(double factor, const double X[6], double M[6][6])
{
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, ij = 3 + i, jk = 3 + j, ik = 3 + (i + 2) % 3;

    M[i][i] += factor * 2. * X[i];
    M[i][ij] += factor * 2. * X[ij];
    M[i][ik] += factor * 2. * X[ik];
    M[ij][i] += factor * X[ij];
    M[ij][j] += factor * X[ij];
    M[ij][ij] += factor * (X[i] + X[j]);
    M[ij][jk] += factor * X[ik];
    M[ij][ik] += factor * X[jk];
  }
}

/*
  value = sum_k a[k] X^k, k = 1..19, for a deviatoric X of which |X| is known, and, where derivatives are wanted, M:
  its derivative by X in deviatoric directions
*/
MPM_FN void IsotropicPolynomial(const double a[20], const double X[6], double norm, double value[6], double M[6][6])
{
  IsotropicCoefficients of;
  double                square[6], J3 = 0.;

  IsotropicSquare(X, square);
  for (int i = 0; i < 6; ++i) J3 += (i < 3 ? 1. : 2.) / 3. * square[i] * X[i]; /* tr(X^3)/3 is det X where tr X = 0 */
  of = IsotropicSeries(a, norm < ISOTROPIC_SERIES_CLOSE ? 10 : 19, 0.5 * (square[0] + square[1] + square[2]), J3);
  for (int i = 0; i < 6; ++i) value[i] = (i < 3 ? of.c[0] : 0.) + of.c[1] * X[i] + of.c[2] * square[i];
  for (int i = 0; i < 6 && MPM_DIRECTIONS > 0; ++i) {
    const double by_J2 = (i < 3 ? of.by_J2[0] : 0.) + of.by_J2[1] * X[i] + of.by_J2[2] * square[i];
    const double by_J3 = (i < 3 ? of.by_J3[0] : 0.) + of.by_J3[1] * X[i] + of.by_J3[2] * square[i];

    for (int j = 0; j < 6; ++j) M[i][j] = (j < 3 ? 1. : 2.) * (by_J2 * X[j] + by_J3 * square[j]);
    M[i][i] += of.c[1];
  }
  if (MPM_DIRECTIONS > 0) IsotropicAddAnticommutator(of.c[2], X, M);
}

/*
  From derivatives by X = dev A/s in deviatoric directions, times `factor`, to derivatives by A, s being a constant
  (slope 0) or the mean principal value m (slope 1); `mean` is what dm adds to each component
*/
MPM_FN void IsotropicByTensor(const double X[6], double factor, double s, double slope, const double mean[6],
                              double M[6][6])
{
  for (int i = 0; i < 6 && MPM_DIRECTIONS > 0; ++i) {
    double along = 0.;

    for (int j = 0; j < 6; ++j) along += M[i][j] * ((j < 3 ? 1. : 0.) + slope * X[j]);
    for (int j = 0; j < 6; ++j)
      M[i][j] = factor / s * (M[i][j] - (j < 3 ? along / 3. : 0.)) + (j < 3 ? mean[i] / 3. : 0.);
  }
}

/* The given values, with the derivatives M (stored components by stored components) of A's */
MPM_FN Sym IsotropicApply(const double values[6], double M[6][6], const Sym *A)
{
  Sym c;

  for (int i = 0; i < 6; ++i) {
    c.a[i] = ScalarConstant(values[i]);
    for (int j = 0; j < 6 && MPM_DIRECTIONS > 0; ++j) ScalarAddDirections(&c.a[i], M[i][j], &A->a[j]);
  }
  return c;
}

/* ln A = ln m I + ln(I + X), X = dev A/m, m = tr A/3 */
MPM_FN void IsotropicLogSeries(const Sym *A, const double values[6], double m, double norm, Sym *result)
{
  const double a[20]   = {0.,        1.,       -1. / 2.,  1. / 3.,   -1. / 4.,  1. / 5.,   -1. / 6.,
                          1. / 7.,   -1. / 8., 1. / 9.,   -1. / 10., 1. / 11.,  -1. / 12., 1. / 13.,
                          -1. / 14., 1. / 15., -1. / 16., 1. / 17.,  -1. / 18., 1. / 19.};
  const double mean[6] = {1. / m, 1. / m, 1. / m, 0., 0., 0.}, logarithm = log(m);
  double       X[6], value[6], M[6][6];

  for (int i = 0; i < 6; ++i) X[i] = (values[i] - (i < 3 ? m : 0.)) / m;
  IsotropicPolynomial(a, X, norm / m, value, M);
  IsotropicByTensor(X, 1., m, 1., mean, M);
  for (int i = 0; i < 3; ++i) value[i] += logarithm;
  *result = IsotropicApply(value, M, A);
}

/* exp A = e^m exp(X), X = dev A, m = tr A/3 */
MPM_FN void IsotropicExpSeries(const Sym *A, const double values[6], double m, double norm, Sym *result)
{
  const double exponential = exp(m);
  double       a[20], X[6], value[6], M[6][6];

  a[0] = 1.;
  for (int k = 1; k < 20; ++k) a[k] = a[k - 1] / k;
  for (int i = 0; i < 6; ++i) X[i] = values[i] - (i < 3 ? m : 0.);
  IsotropicPolynomial(a, X, norm, value, M);
  for (int i = 0; i < 6; ++i) value[i] = exponential * (value[i] + (i < 3 ? 1. : 0.));
  IsotropicByTensor(X, exponential, 1., 0., value, M);
  *result = IsotropicApply(value, M, A);
}

/* Values of the mean principal value and of |dev A| */
MPM_FN void IsotropicSplitValues(const double A[6], double *mean, double *norm)
{
  const double m      = (A[0] + A[1] + A[2]) / 3.;
  double       square = 2. * (A[3] * A[3] + A[4] * A[4] + A[5] * A[5]);

  for (int i = 0; i < 3; ++i) square += (A[i] - m) * (A[i] - m);
  *mean = m;
  *norm = sqrt(square);
}
