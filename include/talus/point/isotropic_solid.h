#pragma once
/*
  Isotropic functions in 3D. Included by isotropic.h.

  Logarithm and exponential of a tensor whose principal values are close to each other are series
  (isotropic_series.h). Otherwise A = sum_a w_a n_a n_a by cyclic Jacobi rotations of the values. The derivative in a
  direction H is, by the theorem of Daleckii and Krein (Bhatia 1997, Matrix Analysis, section V.3,
  doi:10.1007/978-1-4612-0653-8),

    sum_ab gamma_ab (n_a . H n_b) n_a n_b,   gamma_aa = f'(w_a),   gamma_ab = (f(w_a) - f(w_b))/(w_a - w_b),

  with divided differences written so that they do not cancel:
    ln   2/(w_a + w_b) g(t^2),  t = (w_a - w_b)/(w_a + w_b);    exp  e^{(w_a + w_b)/2} sinh(d)/d,  d = (w_a - w_b)/2;
    sqrt 1/(sqrt w_a + sqrt w_b).
  The sum is applied as one 6 x 6 matrix to all directions.
*/
#include "isotropic_series.h"

/* A = sum_a w[a] n_a n_a with n_a in column a of Q (row-major); `rotated` is 0 where A is diagonal, Q the identity. */
typedef struct {
  double w[3], Q[9];
  int    rotated;
} IsotropicFrame;

/* One Jacobi rotation that makes component k of A, which couples p and q, vanish; kp and kq couple p and q to the
   third axis. */
MPM_FN void IsotropicRotate(double A[6], double Q[9], int p, int q, int k, int kp, int kq)
{
  const double off = A[k], gap = A[q] - A[p], root = sqrt(gap * gap + 4. * off * off);
  const double t = 2. * off / (gap >= 0. ? gap + root : gap - root), c = 1. / sqrt(1. + t * t), s = t * c;
  const double ap = A[kp], aq = A[kq];

  A[p] -= t * off;
  A[q] += t * off;
  A[k]  = 0.;
  A[kp] = c * ap - s * aq;
  A[kq] = s * ap + c * aq;
  for (int i = 0; i < 3; ++i) {
    const double Qp = Q[3 * i + p], Qq = Q[3 * i + q];

    Q[3 * i + p] = c * Qp - s * Qq;
    Q[3 * i + q] = s * Qp + c * Qq;
  }
}

/* An off-diagonal entry this small changes neither its two principal values nor, beyond rounding, their directions'
   contribution. */
MPM_FN int IsotropicNegligible(double off, double ap, double aq)
{
  return off * off <= 1e-33 * fabs(ap * aq);
}

/* Non-zero when A is not finite. */
MPM_FN int IsotropicFrameCreate(const double values[6], IsotropicFrame *frame)
{
  double A[6], sum = 0.;
  int    clean = 0;

  for (int i = 0; i < 6; ++i) sum += fabs(A[i] = values[i]);
  if (!(sum <= DBL_MAX)) return 1;
  for (int i = 0; i < 9; ++i) frame->Q[i] = i % 4 == 0 ? 1. : 0.;
  frame->rotated = 0;
  /* Three negligible entries in a row end it; convergence is cubic, so 30 sweeps are never used up. */
  for (int sweep = 0; sweep < 30 && clean < 3; ++sweep) {
    for (int axis = 0; axis < 3 && clean < 3; ++axis) {
      const int p = axis, q = (axis + 1) % 3, k = 3 + axis, kp = 3 + (axis + 2) % 3, kq = 3 + (axis + 1) % 3;

      if (IsotropicNegligible(A[k], A[p], A[q])) {
        ++clean;
      } else {
        IsotropicRotate(A, frame->Q, p, q, k, kp, kq);
        frame->rotated = 1;
        clean          = 0;
      }
    }
  }
  for (int a = 0; a < 3; ++a) frame->w[a] = A[a];
  return 0;
}

/* basis[ab]: the symmetric part of n_a n_b, in the order of a Sym */
MPM_FN void IsotropicBasis(const double Q[9], double basis[6][6])
{
  for (int i = 0; i < 3; ++i) {
    const int r = i, s = (i + 1) % 3;

    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3;

      basis[a][i]         = Q[3 * i + a] * Q[3 * i + a];
      basis[a][3 + i]     = Q[3 * r + a] * Q[3 * s + a];
      basis[3 + a][i]     = Q[3 * i + a] * Q[3 * i + b];
      basis[3 + a][3 + i] = 0.5 * (Q[3 * r + a] * Q[3 * s + b] + Q[3 * s + a] * Q[3 * r + b]);
    }
  }
}

/*
  gamma in the order of a Sym: aa, bb, cc, ab, bc, ac. The result's values are sum_a f[a] n_a n_a, and its derivatives
  those of A under the operator in the head of this file.
*/
MPM_FN void IsotropicAssemble(const Sym *A, const IsotropicFrame *frame, const double f[3], const double gamma[6],
                              Sym *result)
{
  double basis[6][6], M[6][6], values[6];

  IsotropicBasis(frame->Q, basis);
  for (int i = 0; i < 6; ++i) values[i] = f[0] * basis[0][i] + f[1] * basis[1][i] + f[2] * basis[2][i];
  for (int i = 0; i < 6 && MPM_DIRECTIONS > 0; ++i) {
    for (int j = 0; j < 6; ++j) {
      double sum = 0.;

      for (int a = 0; a < 6; ++a) sum += (a < 3 ? 1. : 2.) * gamma[a] * basis[a][i] * basis[a][j];
      M[i][j] = (j < 3 ? 1. : 2.) * sum;
    }
  }
  *result = IsotropicApply(values, M, A);
}

/* IsotropicAssemble() where A is diagonal: the principal axes are the coordinate axes. */
MPM_FN void IsotropicAssembleDiagonal(const Sym *A, const double f[3], const double gamma[6], Sym *result)
{
  Sym c;

  for (int i = 0; i < 3; ++i) c.a[i] = ScalarChain(A->a[i], f[i], gamma[i]);
  for (int i = 3; i < 6; ++i) c.a[i] = ScalarChain(A->a[i], gamma[i] * ScalarValue(A->a[i]), gamma[i]);
  *result = c;
}

MPM_FN void IsotropicJoin(const Sym *A, const IsotropicFrame *frame, const double f[3], const double gamma[6],
                          Sym *result)
{
  if (frame->rotated) IsotropicAssemble(A, frame, f, gamma, result);
  else IsotropicAssembleDiagonal(A, f, gamma, result);
}

/* ln A; non-zero when A is not positive definite or not finite */
MPM_FN int SymLog(const Sym *A, Sym *result)
{
  IsotropicFrame frame;
  double         values[6], f[3], gamma[6], mean, norm;

  SymValues(values, A);
  IsotropicSplitValues(values, &mean, &norm);
  if (norm <= ISOTROPIC_SERIES_RANGE * mean && mean >= DBL_MIN && mean <= DBL_MAX) {
    IsotropicLogSeries(A, values, mean, norm, result);
    return 0;
  }
  if (IsotropicFrameCreate(values, &frame)) return 1;
  for (int a = 0; a < 3; ++a) {
    if (!(frame.w[a] >= DBL_MIN)) return 1;
    f[a]     = log(frame.w[a]);
    gamma[a] = 1. / frame.w[a];
  }
  for (int a = 0; a < 3; ++a) {
    const double wa = frame.w[a], wb = frame.w[(a + 1) % 3], sum = wa + wb, t = (wa - wb) / sum;
    double       g, dg;

    IsotropicArtanh(t * t, 4. * (wa / sum) * (wb / sum), &g, &dg);
    gamma[3 + a] = 2. * g / sum;
  }
  IsotropicJoin(A, &frame, f, gamma, result);
  return 0;
}

/* exp A; non-zero when it is not finite */
MPM_FN int SymExp(const Sym *A, Sym *result)
{
  IsotropicFrame frame;
  double         values[6], f[3], gamma[6], mean, norm;

  SymValues(values, A);
  IsotropicSplitValues(values, &mean, &norm);
  if (norm <= ISOTROPIC_SERIES_RANGE && fabs(mean) < 700.) {
    IsotropicExpSeries(A, values, mean, norm, result);
    return 0;
  }
  if (IsotropicFrameCreate(values, &frame)) return 1;
  for (int a = 0; a < 3; ++a) gamma[a] = f[a] = exp(frame.w[a]);
  for (int a = 0; a < 3; ++a) {
    const double wa = frame.w[a], wb = frame.w[(a + 1) % 3], d = 0.5 * (wa - wb);
    double       c, h, dh;

    IsotropicHyperbolic(d * d, &c, &h, &dh);
    gamma[3 + a] = exp(0.5 * (wa + wb)) * h;
  }
  IsotropicJoin(A, &frame, f, gamma, result);
  return !(f[0] + f[1] + f[2] <= DBL_MAX);
}

/* A^1/2; non-zero when A is not positive definite or not finite */
MPM_FN int SymSqrt(const Sym *A, Sym *result)
{
  IsotropicFrame frame;
  double         values[6], f[3], gamma[6];

  SymValues(values, A);
  if (IsotropicFrameCreate(values, &frame)) return 1;
  for (int a = 0; a < 3; ++a) {
    if (!(frame.w[a] >= DBL_MIN)) return 1;
    f[a]     = sqrt(frame.w[a]);
    gamma[a] = 0.5 / f[a];
  }
  for (int a = 0; a < 3; ++a) gamma[3 + a] = 1. / (f[a] + f[(a + 1) % 3]);
  IsotropicJoin(A, &frame, f, gamma, result);
  return 0;
}

/* Invariants behind principal values and axes of a Sym: its mean, the norm of its deviator, the deviator over that, and
   a third of Lode's angle. Principal values are mean + sqrt(2/3) norm cos(angle), .. cos(angle - 2 pi/3), .. cos(angle
   + 2 pi/3). */
typedef struct {
  double mean, norm, angle, X[6];
} SymSplit;

/* The norm is 0 where A is isotropic to rounding. */
MPM_FN SymSplit SymSplitCreate(const Sym *A)
{
  double   square[6], J3 = 0.;
  SymSplit split;

  SymValues(split.X, A);
  IsotropicSplitValues(split.X, &split.mean, &split.norm);
  for (int i = 0; i < 6; ++i) split.X[i] = split.norm > 0. ? (split.X[i] - (i < 3 ? split.mean : 0.)) / split.norm : 0.;
  IsotropicSquare(split.X, square);
  for (int i = 0; i < 6; ++i)
    J3 += (i < 3 ? 1. : 2.) / 3. * square[i] * split.X[i]; /* tr(X^3)/3 is det X where tr X = 0 */
  split.angle = acos(fmax(-1., fmin(1., sqrt(54.) * J3))) / 3.;
  return split;
}

/*
  Principal values, largest first, without axes. Where two of them coincide they are off by up to 1e-7 |dev A|: good for
  a test with a margin.
*/
MPM_FN void SymSplitValues(const SymSplit *split, double w[3])
{
  const double r = sqrt(2. / 3.) * split->norm;

  w[0] = split->mean + r * cos(split->angle);
  w[2] = split->mean + r * cos(split->angle + 2.0943951023931954923); /* 2 pi/3 */
  w[1] = fmax(w[2], fmin(w[0], 3. * split->mean - w[0] - w[2]));
}

/* Unit vectors s, t and n, n along the axis of principal value w of X, which is the one farthest from the others */
MPM_FN void IsotropicDeflate(const double X[6], double w, double s[3], double t[3], double n[3])
{
  const double column[3][3] = {{X[0] - w, X[3], X[5]}, {X[3], X[1] - w, X[4]}, {X[5], X[4], X[2] - w}};
  double       longest      = -1., rest[2][3];
  int          first        = 0;

  for (int k = 0; k < 3; ++k) {
    const double length = column[k][0] * column[k][0] + column[k][1] * column[k][1] + column[k][2] * column[k][2];

    if (!(length > longest)) continue;
    longest = length;
    first   = k;
  }
  for (int i = 0; i < 3; ++i) s[i] = column[first][i] / sqrt(longest);
  longest = -1.;
  for (int k = 0; k < 2; ++k) { /* the longer of the others across s */
    const double *other = column[(first + 1 + k) % 3], along = s[0] * other[0] + s[1] * other[1] + s[2] * other[2];
    double        length = 0.;

    for (int i = 0; i < 3; ++i) {
      rest[k][i] = other[i] - along * s[i];
      length += rest[k][i] * rest[k][i];
    }
    if (!(length > longest)) continue;
    longest = length;
    for (int i = 0; i < 3; ++i) t[i] = rest[k][i];
  }
  for (int i = 0; i < 3; ++i) t[i] /= sqrt(longest);
  for (int i = 0; i < 3; ++i) n[i] = s[(i + 1) % 3] * t[(i + 2) % 3] - s[(i + 2) % 3] * t[(i + 1) % 3];
}

/* a . X b */
MPM_FN double IsotropicBetween(const double X[6], const double a[3], const double b[3])
{
  return a[0] * (X[0] * b[0] + X[3] * b[1] + X[5] * b[2]) + a[1] * (X[3] * b[0] + X[1] * b[1] + X[4] * b[2]) +
         a[2] * (X[5] * b[0] + X[4] * b[1] + X[2] * b[2]);
}

/*
  Non-zero when A is not finite.

  The principal value that is farthest from the others, and its axis, are well conditioned; the other two are those of a
  matrix of two rows, which has them to rounding however close they are (Scherzinger and Dohrmann 2008,
  doi:10.1016/j.cma.2008.03.031). Of the deviator, so that differences are exact to rounding of it for any mean.
*/
MPM_FN int SymSplitPrincipal(const SymSplit *split, SymPrincipal *principal)
{
  double        s[3] = {1., 0., 0.}, t[3] = {0., 1., 0.}, n[3] = {0., 0., 1.}, Q[9], value[3];
  const double *X = split->X, norm = split->norm, mean = split->mean, angle = split->angle;
  const int     up = angle < 0.52359877559829887308; /* pi/6: the largest is the one */
  const int     a = up ? 1 : 0, b = a + 1, apart = up ? 0 : 2;

  if (!(norm <= DBL_MAX && fabs(mean) <= DBL_MAX)) return 1;
  if (norm > 0.) IsotropicDeflate(X, sqrt(2. / 3.) * cos(up ? angle : angle + 2.0943951023931954923), s, t, n);
  {
    const double ss = IsotropicBetween(X, s, s), tt = IsotropicBetween(X, t, t), st = IsotropicBetween(X, s, t);
    const double d = 0.5 * (ss - tt), r = sqrt(d * d + st * st);
    /* cosine and sine of the angle from s to the larger one's axis, the larger of the two without cancellation */
    const double near = r > 0. ? sqrt(0.5 + 0.5 * fabs(d) / r) : 1., far = r > 0. ? 0.5 * st / (r * near) : 0.;
    const double c = d >= 0. ? near : far, sine = d >= 0. ? far : near;

    for (int i = 0; i < 3; ++i) {
      Q[3 * i + a]     = c * s[i] + sine * t[i];
      Q[3 * i + b]     = c * t[i] - sine * s[i];
      Q[3 * i + apart] = n[i];
    }
    value[a]     = norm * (0.5 * (ss + tt) + r);
    value[b]     = norm * (0.5 * (ss + tt) - r);
    value[apart] = norm * IsotropicBetween(X, n, n);
    for (int k = 0; k < 3; ++k) {
      principal->value[k]   = mean + value[k];
      principal->pair[k][0] = k;
      principal->pair[k][1] = (k + 1) % 3;
      principal->gap[k]     = value[k] - value[(k + 1) % 3];
    }
    principal->gap[a] = 2. * norm * r;
  }
  IsotropicBasis(Q, principal->basis);
  return 0;
}

/* C = F^T F of a plain F, row-major */
MPM_FN void TensorRightCauchyGreen(const double *F, double C[6])
{
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;

    C[i]     = F[i] * F[i] + F[3 + i] * F[3 + i] + F[6 + i] * F[6 + i];
    C[3 + i] = F[i] * F[j] + F[3 + i] * F[3 + j] + F[6 + i] * F[6 + j];
  }
}

/*
  TensorStretchDiagonal - diagonal of the right stretch U = (F^T F)^1/2 of a plain F, row-major, for the update of
  particle domains

  Source: Charlton, Coombs and Augarde (2017), doi:10.1016/j.compstruc.2017.05.004. Non-zero when det F is 0 or F is
  not finite.
*/
MPM_FN int TensorStretchDiagonal(const double *F, double *diagonal)
{
  IsotropicFrame frame;
  double         C[6];

  TensorRightCauchyGreen(F, C);
  if (MpmDeterminant(9, F) == 0. || IsotropicFrameCreate(C, &frame)) return 1;
  for (int i = 0; i < 3; ++i) {
    diagonal[i] = 0.;
    for (int a = 0; a < 3; ++a) { diagonal[i] += sqrt(fmax(frame.w[a], 0.)) * frame.Q[3 * i + a] * frame.Q[3 * i + a]; }
  }
  return 0;
}

/* TensorStretchDiagonal() to rounding, by a series where principal stretches are close: for cheap steps. */
MPM_FN int TensorStretchDiagonalQuick(const double *F, double *diagonal)
{
  const double a[20] = {0., /* sqrt(1 + x) = 1 + sum_k a[k] x^k */
                        1. / 2.,
                        -1. / 8.,
                        1. / 16.,
                        -5. / 128.,
                        7. / 256.,
                        -21. / 1024.,
                        33. / 2048.,
                        -429. / 32768.,
                        715. / 65536.,
                        -2431. / 262144.,
                        4199. / 524288.,
                        -29393. / 4194304.,
                        52003. / 8388608.,
                        -185725. / 33554432.,
                        334305. / 67108864.,
                        -9694845. / 2147483648.,
                        17678835. / 4294967296.,
                        -64822395. / 17179869184.,
                        119409675. / 34359738368.};
  double       C[6], X[6], value[6], M[6][6], mean, norm;

  TensorRightCauchyGreen(F, C);
  IsotropicSplitValues(C, &mean, &norm);
  if (!(norm <= ISOTROPIC_SERIES_RANGE * mean && mean >= DBL_MIN && mean <= DBL_MAX))
    return TensorStretchDiagonal(F, diagonal);
  for (int i = 0; i < 6; ++i) X[i] = (C[i] - (i < 3 ? mean : 0.)) / mean;
  IsotropicPolynomial(a, X, norm / mean, value, M);
  for (int i = 0; i < 3; ++i) diagonal[i] = sqrt(mean) * (1. + value[i]);
  return 0;
}
