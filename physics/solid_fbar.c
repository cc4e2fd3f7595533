/*
  The quasi-static solid at one point with F-bar: the volume change is the mean over the points of the cell, which keeps
  low-order shapes from locking when the material hardly changes its volume.

  With d dimensions, dF = I + du (x) G and m = det dF of the point, the law sees

    dF_bar = (m_bar/m)^{1/d} dF ,    m_bar = sum_q w_q m_q ,   w_q the point's share of the cell's volume

  (in plane strain the part in the plane is scaled). What is assembled is the variation of the same work, so the
  Jacobian of a law with a potential is symmetric: with tau the law's stress at dF_bar F_n and tr over d components,

    tau : delta(dF_bar) dF_bar^{-1} = (tau - (tr tau/d) I) : grad delta u + (tr tau/d) delta m_bar/m_bar

  The flux of m_bar is V_0 tr tau/(d m_bar); the engine adds the part of delta m_bar = sum_q w_q delta m_q, with delta m =
  cof(dF) : delta(dF). F of the converged step is that of dF_bar, so that volume and stress belong together.

  At small strain m = 1 + tr h with h the increment of the displacement gradient by X, and h_bar = h + ((m_bar - m)/d) I.

  Dilation. Where plastic flow dilates, its volume strain is beta times its shear strain, and the points of a cell, whose shear
  differs, cannot all have the same volume change: pressures at them drift apart, and a limit load never comes. With
  `point->dilatancy` (plane strain) the mean is that of what shear leaves over,

    m = det dF exp(-beta g) ,   g = gamma(dF b_n dF^T) - gamma(b_n)

  with b the elastic left Cauchy-Green tensor, gamma half the difference of the logarithms of its principal values in the
  plane, thus g the plastic shear of a step that goes on flowing, and beta 0 at points that did not yield at the step's start.
  One condition a cell is left, as without dilation. g does not change when dF is scaled, so all that follows stays as it is;
  the point's own flux of m is now (tr tau/d) dm/m = (tr tau/d) (dF^{-T} - beta dg).

  Sources: de Souza Neto, Peric, Dutko and Owen (1996), doi:10.1016/0020-7683(95)00259-6; for the material point method
  Coombs, Charlton, Cortis and Augarde (2018), doi:10.1016/j.cma.2018.01.010; the variational form is the mean dilatation
  of Simo, Taylor and Pister (1985), doi:10.1016/0045-7825(85)90033-7.
*/
#include "solid.h"

#define GRADIENTS (MPM_DIM * MPM_DIM)
#define INPUTS    (GRADIENTS + 1)

/* Shear strain below which its direction is not told, so that g is smooth where there is none */
#define LEAST_SHEAR 1e-8

#if MPM_DIM == 2
/*
  g and its derivatives, from b_n in the plane, dF and J = det dF with its derivatives. With r the radius of Mohr's circle
  of b = dF b_n dF^T, sinh(gamma) = r/sqrt(det b), cosh(gamma) = tr b/(2 sqrt(det b)), and

    d gamma = coth(gamma) (2 dF b_n/tr b - cof dF/J)
*/
MPM_FN Scalar ShearGrowth(const double b[3], const Tensor *dF, const Tensor *cofactor, Scalar J, Tensor *dg)
{
  const double mean = 0.5 * (b[0] + b[1]), half = 0.5 * (b[0] - b[1]), square = half * half + b[2] * b[2];
  const double det = mean * mean - square, least = LEAST_SHEAR * LEAST_SHEAR, sinh_n = sqrt(square / det + least);
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
  return ScalarShift(ScalarLog(ScalarAdd(sine, cosine)), -log(sinh_n + sqrt(1. + sinh_n * sinh_n)));
}
#endif

/* beta, with g and its derivatives where it is not 0; J = det dF and its derivatives */
MPM_FN double Dilatancy(const MpmKernelPoint *point, const Tensor *dF, const Tensor *cofactor, Scalar J, Scalar *g,
                        Tensor *dg)
{
#if MPM_DIM == 2
  double b[3], beta;

  if (!point->dilatancy) return 0.;
  beta = point->dilatancy(point->parameter, point->table, point->state_n, b);
  if (beta > 0.) *g = ShearGrowth(b, dF, cofactor, J, dg);
  return beta;
#else
  (void)point, (void)dF, (void)cofactor, (void)J, (void)g, (void)dg;
  return 0.;
#endif
}

/* m, and its change with the point: dm[k] = d m / d input_k */
MPM_FN Scalar PointMean(const MpmKernelPoint *point, const Tensor *dF, Tensor *dm)
{
  Scalar J, growth;
  Tensor dg;
  double beta;

  if (point->traits & MPM_LAW_SMALL_STRAIN) {
    Scalar m = ScalarConstant(1.);

    for (int a = 0; a < MPM_DIM; a++) {
      for (int b = 0; b < MPM_DIM; b++) {
        const Scalar g = ScalarShift(dF->a[a * MPM_DIM + b], a == b ? -1. : 0.);

        ScalarAddScaled(&m, point->F_n[b * MPM_DIM + a], &g);
        dm->a[a * MPM_DIM + b] = ScalarConstant(point->F_n[b * MPM_DIM + a]);
      }
    }
    return m;
  }
  *dm  = TensorCofactor(dF);
  J    = TensorCofactorDet(dF, dm);
  beta = Dilatancy(point, dF, dm, J, &growth, &dg);
  if (beta > 0.) {
    const Scalar factor = ScalarExp(ScalarScale(-beta, growth));

    for (int k = 0; k < GRADIENTS; k++)
      dm->a[k] = ScalarMul(factor, ScalarSub(dm->a[k], ScalarMul(J, ScalarScale(beta, dg.a[k]))));
    return ScalarMul(factor, J);
  }
  return J;
}

/* A change of dF that is to dF_bar what a change of m_bar is: E = dF, or F_n^{-1} at small strain. */
MPM_FN Tensor Dilation(const MpmKernelPoint *point, const Tensor *dF)
{
  if (point->traits & MPM_LAW_SMALL_STRAIN) {
    const Tensor F_n = TensorFromArray(point->F_n);

    return TensorInverse(&F_n);
  }
  return *dF;
}

/* dF_bar from the ratio m_bar/m or, at small strain, m_bar - m: dF_bar F_n = dF F_n + ((m_bar - m)/d) I */
MPM_FN Tensor MeanIncrement(const MpmKernelPoint *point, const Tensor *dF, Scalar ratio)
{
  if (point->traits & MPM_LAW_SMALL_STRAIN) {
    const Tensor E = Dilation(point, dF), shift = TensorScale(ScalarScale(1. / MPM_DIM, ratio), &E);

    return TensorAdd(dF, &shift);
  }
  return TensorScale(MPM_DIM == 2 ? ScalarSqrt(ratio) : ScalarPow(ratio, 1. / MPM_DIM), dF);
}

/* Adds V_0 (tr tau/d) beta dg to the fluxes. */
MPM_FN void AddShearFlux(const MpmKernelPoint *point, const Tensor *dF, Scalar pressure, Scalar flux[])
{
  const Tensor cofactor = TensorCofactor(dF);
  Scalar       g;
  Tensor       dg;
  const double beta = Dilatancy(point, dF, &cofactor, TensorCofactorDet(dF, &cofactor), &g, &dg);

  if (!(beta > 0.)) return;
  for (int k = 0; k < GRADIENTS; k++)
    flux[k] = ScalarAdd(flux[k], ScalarMul(ScalarScale(beta * point->volume0, pressure), dg.a[k]));
}

/* The fluxes from dF, dF_bar and m_bar. */
MPM_FN int Fluxes(const MpmKernelPoint *point, const Tensor *dF, const Tensor *dF_bar, Scalar mean, Scalar flux[])
{
  Scalar pressure = ScalarConstant(0.); /* tr tau/d */
  Sym    tau, rest;

  if (LawStress(point, dF_bar, &tau)) return 1;
  for (int a = 0; a < MPM_DIM; a++) ScalarAddScaled(&pressure, 1. / MPM_DIM, &tau.a[SymIndex(a, a)]);
  rest = SymShift(&tau, ScalarNeg(pressure));
  SolidFlux(point, &rest, dF, flux);
  if (point->dilatancy) AddShearFlux(point, dF, pressure, flux);
  if (!(point->traits & MPM_LAW_SMALL_STRAIN)) pressure = ScalarDiv(pressure, mean);
  flux[GRADIENTS] = ScalarScale(point->volume0, pressure);
  SolidKeep(point, &tau, dF_bar);
  return 0;
}

#if MPM_DIRECTIONS < 2
static int SolidFbarKernel(const MpmKernelPoint *point, const Scalar input[], Scalar flux[])
{
  const Tensor dF = TensorFromGradient(input);
  Tensor       dm;
  const Scalar m = PointMean(point, &dF, &dm), mean = input[GRADIENTS];

  if (!(ScalarValue(m) > 0. && ScalarValue(mean) > 0.)) return 1;
  const Scalar ratio  = point->traits & MPM_LAW_SMALL_STRAIN ? ScalarSub(mean, m) : ScalarDiv(mean, m);
  const Tensor dF_bar = MeanIncrement(point, &dF, ratio);

  return Fluxes(point, &dF, &dF_bar, mean, flux);
}
#endif

#if MPM_DIRECTIONS != 1
/* m of the point, and its first derivatives by the gradients; with directions the second ones too. */
static int SolidFbarMean(const MpmKernelPoint *point, const double input[], double *m, double dm[], double ddm[])
{
  Scalar in[GRADIENTS];
  Tensor derivative;

  for (int k = 0; k < GRADIENTS; k++) in[k] = ScalarSeed(input[k], k);
  const Tensor dF = TensorFromGradient(in);

  *m = ScalarValue(PointMean(point, &dF, &derivative));
  TensorStore(dm, &derivative);
  for (int k = 0; MPM_DIRECTIONS && k < GRADIENTS * GRADIENTS; k++)
    ddm[k] = ScalarDirection(derivative.a[k / GRADIENTS], k % GRADIENTS);
  return !(*m > 0. && *m <= DBL_MAX);
}
#endif

#if MPM_DIRECTIONS > 1
/*
  The derivatives of all fluxes by dF and m_bar, with directions for dF alone, which is what laws are compiled for.

  With the ratio m_bar/m held (small strain: m_bar - m) dF_bar goes with dF, and with it the law. Such directions give
  A = D + d (x) dm_bar: D the derivatives by dF, d those by m_bar, dm_bar the change of m_bar that holds the ratio. With
  m_bar held, dF_bar and tau do not change along the dilation E, so D : E = -P by the factor dF^{-T} alone (small strain:
  0; the flux of m_bar: 0). Hence d = (A : E - D : E)/(dm_bar : E), and D.
*/
static int SolidFbarTangent(const MpmKernelPoint *point, const double input[], double flux[], double tangent[])
{
  const int small   = point->traits & MPM_LAW_SMALL_STRAIN;
  double   *by_mean = tangent + GRADIENTS * GRADIENTS, *of_mean = by_mean + GRADIENTS, *second = of_mean + GRADIENTS;
  Scalar    in[GRADIENTS], out[INPUTS];
  Tensor    dm;
  double    E[GRADIENTS], along = 0.;

  for (int k = 0; k < GRADIENTS; k++) in[k] = ScalarSeed(input[k], k);
  const Tensor dF = TensorFromGradient(in), dilation = Dilation(point, &dF);
  const Scalar m = PointMean(point, &dF, &dm);

  if (!(ScalarValue(m) > 0. && input[GRADIENTS] > 0.)) return 1;
  const double ratio  = small ? input[GRADIENTS] - ScalarValue(m) : input[GRADIENTS] / ScalarValue(m);
  const Scalar mean   = small ? ScalarShift(m, ratio) : ScalarScale(ratio, m);
  const Tensor dF_bar = MeanIncrement(point, &dF, ScalarConstant(ratio));

  if (Fluxes(point, &dF, &dF_bar, mean, out)) return 1;
  TensorStore(E, &dilation);
  for (int l = 0; l < GRADIENTS; l++) along += ScalarDirection(mean, l) * E[l];
  along = 1. / along;
  for (int k = 0; k < INPUTS; k++) {
    double *row = k < GRADIENTS ? &tangent[k * GRADIENTS] : of_mean;
    double  d   = k < GRADIENTS && !small ? ScalarValue(out[k]) : 0.;

    for (int l = 0; l < GRADIENTS; l++) d += ScalarDirection(out[k], l) * E[l];
    d *= along;
    ScalarAddDirections(&out[k], -d, &mean);
    for (int l = 0; l < GRADIENTS; l++) row[l] = ScalarDirection(out[k], l);
    *(k < GRADIENTS ? &by_mean[k] : second) = d;
    flux[k]                                 = ScalarValue(out[k]);
  }
  return 0;
}
#endif

MPM_KERNEL_MEAN(solid_fbar, INPUTS, SolidFbarKernel, SolidFbarMean, SolidFbarTangent)

#ifdef MPM_PHYSICS
MPM_PHYSICS(solid_fbar, .summary = "quasi-static solid with the volume change averaged over cells",
            .field_count = MPM_ROWS(solid_fields), .fields = solid_fields,
            .traits = MPM_PHYSICS_SYMMETRIC | MPM_PHYSICS_INTERNAL)
#endif
