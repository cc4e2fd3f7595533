#pragma once
/*
  F-bar at one point, shared by the kernels of physics whose volume change is a mean over the cell. Equations in
  solid_fbar.c.
*/
#include "solid.h"

#define GRADIENTS MPM_TENSOR

/* Shear strain below which its direction is not told, so that g is smooth where there is none */
#define LEAST_SHEAR 1e-8

#if MPM_NORMALS == 2
/*
  g and its derivatives, from b_n in the plane, dF and J = det dF with its derivatives. With r the radius of Mohr's
  circle of b = dF b_n dF^T, sinh(gamma) = r/sqrt(det b), cosh(gamma) = tr b/(2 sqrt(det b)), and

    d gamma = coth(gamma) (2 dF b_n/tr b - cof dF/J)
*/
MPM_FN Scalar ShearGrowth(const Real b[3], const Tensor *dF, const Tensor *cofactor, Scalar J, Tensor *dg)
{
  const Real   mean = 0.5 * (b[0] + b[1]), half = 0.5 * (b[0] - b[1]), square = half * half + b[2] * b[2];
  const double least = LEAST_SHEAR * LEAST_SHEAR;
  const Real   det = mean * mean - square, sinh_n = RealSqrt(square / det + least);
  Scalar       xx = ScalarConstant(0.), yy = xx, xy = xx, sinh2, sine, cosine, slope;
  Tensor       Fb = *dF;

  for (int i = 0; i < 4; i += 2) {
    Fb.a[i]     = ScalarAdd(ScalarScale(b[0], dF->a[i]), ScalarScale(b[2], dF->a[i + 1]));
    Fb.a[i + 1] = ScalarAdd(ScalarScale(b[2], dF->a[i]), ScalarScale(b[1], dF->a[i + 1]));
  }
  for (int k = 0; k < 2; k++) {
    xx = ScalarAdd(xx, ScalarMul(Fb.a[k], dF->a[k]));
    yy = ScalarAdd(yy, ScalarMul(Fb.a[2 + k], dF->a[2 + k]));
    xy = ScalarAdd(xy, ScalarMul(Fb.a[k], dF->a[2 + k]));
  }
  sinh2  = ScalarAdd(ScalarSquare(ScalarScale(0.5, ScalarSub(xx, yy))), ScalarSquare(xy));
  sinh2  = ScalarShift(ScalarDiv(sinh2, ScalarScale(det, ScalarSquare(J))), least);
  sine   = ScalarSqrt(sinh2);
  cosine = ScalarSqrt(ScalarShift(sinh2, 1.));
  slope  = ScalarDiv(cosine, sine);
  for (int k = 0; k < GRADIENTS; k++)
    dg->a[k] =
      ScalarMul(slope, ScalarSub(ScalarScale(2., ScalarDiv(Fb.a[k], ScalarAdd(xx, yy))), ScalarDiv(cofactor->a[k], J)));
  return ScalarShift(ScalarLog(ScalarAdd(sine, cosine)), -RealLog(sinh_n + RealSqrt(1. + sinh_n * sinh_n)));
}
#endif

/* The law's dilatancy at the step's start, with the elastic b in the plane. */
#if MPM_NORMALS == 2 && defined(MPM_SENSITIVITY)
MPM_FN Real DilatancyAtStart(const KernelPoint *point, Real b[3])
{
  const MpmKernelPoint *values = point->values;
  const MpmLawInput     input  = {
         .parameter = values->material.parameter, .table = values->material.table, .state_n = values->state_n};
  const RealColumns columns = point->columns, own = {0, columns.count, columns.stride};
  const MpmLawInput direction = {.parameter = LawShift(point->direction->parameter, columns),
                                 .state_n   = LawShift(point->direction->state_n, columns),
                                 .count     = columns.count,
                                 .stride    = columns.stride};
  double            value[4], derivative[4 * MPM_PACK];
  Real              beta;

  values->material.info->dilatancy_sensitivity(&input, &direction, value, derivative);
  LawJoin(1, value, derivative, own, &beta);
  LawJoin(3, &value[1], &derivative[columns.stride], own, b);
  return beta;
}
#elif MPM_NORMALS == 2
MPM_FN double DilatancyAtStart(const KernelPoint *point, double b[3])
{
  return point->material.dilatancy(point->material.parameter, point->material.table, point->state_n, b);
}
#endif

/* beta, with g and its derivatives where it is not 0; J = det dF and its derivatives */
MPM_FN Real Dilatancy(const KernelPoint *point, const Tensor *dF, const Tensor *cofactor, Scalar J, Scalar *g,
                      Tensor *dg)
{
#if MPM_NORMALS == 2
  Real b[3], beta;

  if (!point->material.dilatancy) return 0.;
  beta = DilatancyAtStart(point, b);
  if (RealValue(beta) > 0.) *g = ShearGrowth(b, dF, cofactor, J, dg);
  return beta;
#else
  (void)point, (void)dF, (void)cofactor, (void)J, (void)g, (void)dg;
  return 0.;
#endif
}

/* m, and its change with the point: dm[k] = d m / d input_k */
MPM_FN Scalar PointMean(const KernelPoint *point, const Tensor *dF, Tensor *dm)
{
  Scalar J, growth = ScalarConstant(0.);
  Tensor dg;
  Real   beta;

  if (point->material.traits & MPM_LAW_SMALL_STRAIN) {
    const Tensor F_n = TensorFromArray(point->F_n);
    Tensor       g   = *dF;

    for (int a = 0; a < MPM_NORMALS; a++) g.a[MPM_NORMAL_AT(a)] = ScalarShift(g.a[MPM_NORMAL_AT(a)], -1.);
    *dm = TensorTranspose(&F_n);
    return ScalarShift(TensorTraceMulArray(&g, point->F_n), 1.);
  }
  *dm  = TensorCofactor(dF);
  J    = TensorCofactorDet(dF, dm);
  beta = Dilatancy(point, dF, dm, J, &growth, &dg);
  if (RealValue(beta) > 0.) {
    const Scalar factor = ScalarExp(ScalarScale(-beta, growth));

    for (int k = 0; k < GRADIENTS; k++)
      dm->a[k] = ScalarMul(factor, ScalarSub(dm->a[k], ScalarMul(J, ScalarScale(beta, dg.a[k]))));
    return ScalarMul(factor, J);
  }
  return J;
}

/* A change of dF that is to dF_bar what a change of m_bar is: E = dF, or F_n^{-1} at small strain. */
MPM_FN Tensor Dilation(const KernelPoint *point, const Tensor *dF)
{
  if (point->material.traits & MPM_LAW_SMALL_STRAIN) {
    const Tensor F_n = TensorFromArray(point->F_n);

    return TensorInverse(&F_n);
  }
  return *dF;
}

/* dF_bar from the ratio m_bar/m or, at small strain, m_bar - m: dF_bar F_n = dF F_n + ((m_bar - m)/d) I */
MPM_FN Tensor MeanIncrement(const KernelPoint *point, const Tensor *dF, Scalar ratio)
{
  if (point->material.traits & MPM_LAW_SMALL_STRAIN) {
    const Tensor E = Dilation(point, dF), shift = TensorScale(ScalarScale(1. / MPM_NORMALS, ratio), &E);

    return TensorAdd(dF, &shift);
  }
  return TensorScale(MPM_NORMALS == 2 ? ScalarSqrt(ratio) : ScalarPow(ratio, 1. / MPM_NORMALS), dF);
}

/* Adds V_0 (tr tau/d) beta dg to the fluxes. */
MPM_FN void AddShearFlux(const KernelPoint *point, const Tensor *dF, Scalar pressure, Scalar flux[])
{
  const Tensor cofactor = TensorCofactor(dF);
  Scalar       g;
  Tensor       dg;
  const Real   beta = Dilatancy(point, dF, &cofactor, TensorCofactorDet(dF, &cofactor), &g, &dg);

  if (!(RealValue(beta) > 0.)) return;
  for (int k = 0; k < GRADIENTS; k++)
    flux[k] = ScalarAdd(flux[k], ScalarMul(ScalarScale(beta * point->volume0, pressure), dg.a[k]));
}

#if defined(MPM_SENSITIVITY)
/* m of the point, and its derivatives by the gradients of the displacement. Non-zero where there is no such m. */
MPM_FN int FbarMeanAlong(const KernelPoint *point, const Scalar input[], Scalar *m, Scalar dm[])
{
  const Tensor dF = TensorFromGradient(input);
  Tensor       derivative;

  *m = PointMean(point, &dF, &derivative);
  for (int k = 0; k < GRADIENTS; k++) dm[k] = derivative.a[k];
  return !(ScalarValue(*m) > 0. && ScalarValue(*m) <= DBL_MAX);
}
#else
/*
  m of the point, and its first derivatives by the kernel's `count` inputs but for the mean, the gradients of the
  displacement first; with directions the second ones too, count x count. Non-zero where there is no such m.
*/
MPM_FN int FbarMean(const KernelPoint *point, const double input[], int count, double *m, double dm[], double ddm[])
{
  Scalar in[GRADIENTS];
  Tensor derivative;

  for (int k = 0; k < GRADIENTS; k++) in[k] = MPM_DIRECTIONS > 1 ? ScalarSeed(input[k], k) : ScalarConstant(input[k]);
  const Tensor dF = TensorFromGradient(in);

  *m = ScalarValue(PointMean(point, &dF, &derivative));
  for (int k = GRADIENTS; k < count; k++) dm[k] = 0.;
  TensorStore(dm, &derivative);
  for (int k = 0; MPM_DIRECTIONS > 1 && k < count * count; k++) {
    const int row = k / count, column = k % count;

    ddm[k] = row < GRADIENTS && column < GRADIENTS ? ScalarDirection(derivative.a[row], column) : 0.;
  }
  return !(*m > 0. && *m <= DBL_MAX);
}
#endif

/* The mean part of the total work: fluxes of dF and of m_bar from the Kirchhoff stress `tau` at dF_bar. */
MPM_FN void FbarFlux(const KernelPoint *point, const Sym *tau, const Tensor *dF, Scalar mean, Scalar flux[],
                     Scalar *mean_flux)
{
  Scalar pressure = ScalarConstant(0.); /* tr tau/d */
  Sym    rest;

  for (int a = 0; a < MPM_NORMALS; a++) ScalarAddScaled(&pressure, 1. / MPM_NORMALS, &tau->a[a]);
  rest = SymShift(tau, ScalarNeg(pressure));
  SolidFlux(point, &rest, dF, flux);
  if (point->material.dilatancy) AddShearFlux(point, dF, pressure, flux);
  if (!(point->material.traits & MPM_LAW_SMALL_STRAIN)) pressure = ScalarDiv(pressure, mean);
  *mean_flux = ScalarScale(point->volume0, pressure);
}
