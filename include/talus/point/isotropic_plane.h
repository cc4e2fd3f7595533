#pragma once
/*
  Isotropic functions in plane strain, without principal directions. Included by isotropic.h.

  With m half the in-plane trace, D the in-plane deviator, r = |D| (a principal value is m +- r) and s = (r/m)^2, in
  the plane

    ln A  = (1/2) ln(m^2 - r^2) I + (g(s)/m) D,     g(s) = artanh(sqrt s)/sqrt s
    exp A = e^m (cosh r I + (sinh r / r) D)
    A^1/2 = (A + sqrt(det A) I)/sqrt(tr A + 2 sqrt(det A))

  and g, cosh, sinh r / r are smooth functions of s or r^2, summed as series where r is small.
*/

/* Half the in-plane trace, the in-plane deviator (d, xy) and its squared norm r^2. */
typedef struct {
  Scalar m, d, q;
} IsotropicPlane;

MPM_FN IsotropicPlane IsotropicPlaneSplit(const Sym *A)
{
  IsotropicPlane plane;

  plane.m = ScalarScale(0.5, ScalarAdd(A->a[0], A->a[1]));
  plane.d = ScalarScale(0.5, ScalarSub(A->a[0], A->a[1]));
  plane.q = ScalarSquare(plane.d);
  ScalarAddProduct(&plane.q, &A->a[3], &A->a[3]);
  return plane;
}

MPM_FN Scalar IsotropicPlaneDet(const Sym *A)
{
  return ScalarSub(ScalarMul(A->a[0], A->a[1]), ScalarSquare(A->a[3]));
}

/* The tensor with in-plane block mean I + factor D and the given zz component */
MPM_FN Sym IsotropicPlaneJoin(const Sym *A, const IsotropicPlane *plane, Scalar mean, Scalar factor, Scalar zz)
{
  const Scalar d = ScalarMul(factor, plane->d);
  Sym          c;

  c.a[0] = ScalarAdd(mean, d);
  c.a[1] = ScalarSub(mean, d);
  c.a[2] = zz;
  c.a[3] = ScalarMul(factor, A->a[3]);
  return c;
}

/* Also false for NaN and infinite components. */
MPM_FN int IsotropicPositiveDefinite(const Sym *A, const IsotropicPlane *plane, Scalar det)
{
  const double m = ScalarValue(plane->m), zz = ScalarValue(A->a[2]), D = ScalarValue(det);

  return m > 0. && D > 0. && D <= DBL_MAX && zz > 0. && zz <= DBL_MAX && D > DBL_MIN * m;
}

/* ln A; non-zero when A is not positive definite or not finite */
MPM_FN int SymLog(const Sym *A, Sym *result)
{
  const IsotropicPlane plane = IsotropicPlaneSplit(A);
  const Scalar         det   = IsotropicPlaneDet(A);
  Scalar               square, s, factor;
  double               g, dg;

  if (!IsotropicPositiveDefinite(A, &plane, det)) return 1;
  square = ScalarSquare(plane.m);
  s      = ScalarDiv(plane.q, square);
  IsotropicArtanh(ScalarValue(s), ScalarValue(det) / ScalarValue(square), &g, &dg);
  factor  = ScalarDiv(ScalarChain(s, g, dg), plane.m);
  *result = IsotropicPlaneJoin(A, &plane, ScalarScale(0.5, ScalarLog(det)), factor, ScalarLog(A->a[2]));
  return 0;
}

/* exp A; non-zero when it is not finite */
MPM_FN int SymExp(const Sym *A, Sym *result)
{
  const IsotropicPlane plane = IsotropicPlaneSplit(A);
  const Scalar         em    = ScalarExp(plane.m);
  double               c, h, dh, largest;
  Scalar               mean, factor;

  IsotropicHyperbolic(ScalarValue(plane.q), &c, &h, &dh);
  mean    = ScalarMul(em, ScalarChain(plane.q, c, 0.5 * h));
  factor  = ScalarMul(em, ScalarChain(plane.q, h, dh));
  *result = IsotropicPlaneJoin(A, &plane, mean, factor, ScalarExp(A->a[2]));
  largest = ScalarValue(mean) + ScalarValue(result->a[2]);
  return !(largest <= DBL_MAX);
}

/* A^1/2; non-zero when A is not positive definite or not finite */
MPM_FN int SymSqrt(const Sym *A, Sym *result)
{
  const IsotropicPlane plane = IsotropicPlaneSplit(A);
  const Scalar         det   = IsotropicPlaneDet(A);
  Scalar               root, factor;

  if (!IsotropicPositiveDefinite(A, &plane, det)) return 1;
  root    = ScalarSqrt(det);
  factor  = ScalarDiv(ScalarConstant(1.), ScalarSqrt(ScalarScale(2., ScalarAdd(plane.m, root))));
  *result = IsotropicPlaneJoin(A, &plane, ScalarMul(factor, ScalarAdd(plane.m, root)), factor, ScalarSqrt(A->a[2]));
  return 0;
}

/* Invariants behind principal values and axes: half the in-plane trace, the in-plane deviator (d, xy), its norm r, and
   zz */
typedef struct {
  double m, d, xy, r, zz;
} SymSplit;

MPM_FN SymSplit SymSplitCreate(const Sym *A)
{
  SymSplit split;

  split.m  = 0.5 * (ScalarValue(A->a[0]) + ScalarValue(A->a[1]));
  split.d  = 0.5 * (ScalarValue(A->a[0]) - ScalarValue(A->a[1]));
  split.xy = ScalarValue(A->a[3]);
  split.r  = sqrt(split.d * split.d + split.xy * split.xy);
  split.zz = ScalarValue(A->a[2]);
  return split;
}

/* Principal values, largest first, without axes: to rounding */
MPM_FN void SymSplitValues(const SymSplit *split, double w[3])
{
  const double m = split->m, r = split->r, zz = split->zz;

  w[0] = fmax(m + r, zz);
  w[1] = fmax(fmin(m + r, zz), m - r);
  w[2] = fmin(m - r, zz);
}

/* Non-zero when A is not finite */
MPM_FN int SymSplitPrincipal(const SymSplit *split, SymPrincipal *principal)
{
  const double m = split->m, d = split->d, xy = split->xy, r = split->r, zz = split->zz;
  const double c = r > 0. ? d / r : 1., s = r > 0. ? xy / r : 0.; /* of twice the angle from x to the larger one */
  const int    out = zz > m + r ? 0 : zz > m - r ? 1 : 2, large = out == 0 ? 1 : 0, small = out == 2 ? 1 : 2;
  const double large_basis[4] = {0.5 + 0.5 * c, 0.5 - 0.5 * c, 0., 0.5 * s};

  for (int i = 0; i < 4; ++i) {
    principal->basis[large][i] = large_basis[i];
    principal->basis[small][i] = (i < 2 ? 1. : 0.) - large_basis[i];
    principal->basis[out][i]   = i == 2 ? 1. : 0.;
    principal->basis[3][i]     = i == 3 ? 0.5 * c : i == 0 ? -0.5 * s : i == 1 ? 0.5 * s : 0.;
  }
  principal->value[large] = m + r;
  principal->value[small] = m - r;
  principal->value[out]   = zz;
  principal->pair[0][0]   = large;
  principal->pair[0][1]   = small;
  principal->gap[0]       = 2. * r;
  return !(r <= DBL_MAX && fabs(m) <= DBL_MAX && fabs(zz) <= DBL_MAX);
}

/*
  TensorStretchDiagonal - diagonal of the right stretch U = (F^T F)^1/2 of a plain F, row-major, for the update of
  particle domains

  Source: Charlton, Coombs and Augarde (2017), doi:10.1016/j.compstruc.2017.05.004. Non-zero when det F is 0 or F is
  not finite.
*/
MPM_FN int TensorStretchDiagonal(const double *F, double *diagonal)
{
  const double C[2]  = {F[0] * F[0] + F[2] * F[2], F[1] * F[1] + F[3] * F[3]};
  const double root  = fabs(MpmDeterminant(4, F));
  const double scale = sqrt(C[0] + C[1] + 2. * root);

  for (int i = 0; i < 2; ++i) diagonal[i] = (C[i] + root) / scale;
  return !(root > 0. && scale <= DBL_MAX);
}

/* TensorStretchDiagonal() again: it needs no principal axes. */
MPM_FN int TensorStretchDiagonalQuick(const double *F, double *diagonal)
{
  return TensorStretchDiagonal(F, diagonal);
}
