/*
  The quasi-static solid at one point with F-bar: the volume change is the mean over the points of the cell, which keeps
  low-order shapes from locking when the material hardly changes its volume.

  With d dimensions, dF = I + du (x) G and m = det dF of the point, the law sees

    dF_bar = (m_bar/m)^{1/d} dF ,    m_bar = sum_q w_q m_q ,   w_q the point's share of the cell's volume

  (in plane strain the components in the plane are scaled). The residual is the variation of that work, so the Jacobian
  of a law with a potential is symmetric: with tau the law's stress at dF_bar F_n and tr over d components,

    tau : delta(dF_bar) dF_bar^{-1} = (tau - (tr tau/d) I) : grad delta u + (tr tau/d) delta m_bar/m_bar

  The flux of m_bar is V_0 tr tau/(d m_bar); the engine adds the part of delta m_bar = sum_q w_q delta m_q, with delta m
  = cof(dF) : delta(dF). F of the converged step is that of dF_bar, so that volume and stress belong together.

  At small strain m = 1 + tr h with h the increment of the displacement gradient by X, and h_bar = h + ((m_bar - m)/d)
  I.

  Dilation. Where plastic flow dilates, its volume strain is beta times its shear strain, and the points of a cell,
  whose shear differs, cannot all have the same volume change: pressures at them drift apart, and a limit load is never
  reached. With `point->dilatancy` (plane strain) the mean is that of the remaining volume change,

    m = det dF exp(-beta g) ,   g = gamma(dF b_n dF^T) - gamma(b_n)

  with b the elastic left Cauchy-Green tensor, gamma half the difference of the logarithms of its principal values in
  the plane, thus g the plastic shear of a step that goes on flowing, and beta that of the step's start: 0 well inside
  the yield surface. One condition a cell remains, as without dilation. g does not change when dF is scaled, so all else
  stays as it is; the point's own flux of m is now (tr tau/d) dm/m = (tr tau/d) (dF^{-T} - beta dg).

  Sources: de Souza Neto, Peric, Dutko and Owen (1996), doi:10.1016/0020-7683(95)00259-6; for the material point method
  Coombs, Charlton, Cortis and Augarde (2018), doi:10.1016/j.cma.2018.01.010; the variational form is the mean
  dilatation of Simo, Taylor and Pister (1985), doi:10.1016/0045-7825(85)90033-7.
*/
#include "fbar.h"

#define INPUTS (GRADIENTS + 1)

/* The fluxes from dF, dF_bar and m_bar. */
MPM_FN int Fluxes(const KernelPoint *point, const Tensor *dF, const Tensor *dF_bar, Scalar mean, Scalar flux[])
{
  Sym tau;

  if (SolidStress(point, dF_bar, &tau)) return 1;
  FbarFlux(point, &tau, dF, mean, flux, &flux[GRADIENTS]);
  SolidKeep(point, &tau, dF_bar);
  return 0;
}

#if MPM_DIRECTIONS < 2
static int SolidFbarKernel(const KernelPoint *point, const Scalar input[], Scalar flux[])
{
  const Tensor dF = TensorFromGradient(input);
  Tensor       dm;
  const Scalar m = PointMean(point, &dF, &dm), mean = input[GRADIENTS];

  if (!(ScalarValue(m) > 0. && ScalarValue(mean) > 0.)) return 1;
  const Scalar ratio  = point->material.traits & MPM_LAW_SMALL_STRAIN ? ScalarSub(mean, m) : ScalarDiv(mean, m);
  const Tensor dF_bar = MeanIncrement(point, &dF, ratio);

  return Fluxes(point, &dF, &dF_bar, mean, flux);
}
#endif

#if defined(MPM_SENSITIVITY)
static int SolidFbarMean(const KernelPoint *point, const Scalar input[], Scalar *m, Scalar dm[])
{
  return FbarMeanAlong(point, input, m, dm);
}
#elif MPM_DIRECTIONS != 1
static int SolidFbarMean(const KernelPoint *point, const double input[], double *m, double dm[], double ddm[])
{
  return FbarMean(point, input, GRADIENTS, m, dm, ddm);
}
#endif

#if MPM_DIRECTIONS > 1
/*
  The derivatives of all fluxes by dF and m_bar, with directions for dF alone, as laws are compiled.

  With a constant ratio m_bar/m (small strain: m_bar - m) dF_bar goes with dF, and with it the law. Such directions give
  A = D + d (x) dm_bar: D the derivatives by dF, d those by m_bar, dm_bar the change of m_bar at constant ratio. With
  m_bar constant, dF_bar and tau do not change along the dilation E, so D : E = -P by the factor dF^{-T} alone (small
  strain: 0; the flux of m_bar: 0). Hence d = (A : E - D : E)/(dm_bar : E), and D.
*/
static int SolidFbarTangent(const KernelPoint *point, const double input[], double flux[], double tangent[])
{
  const int small   = point->material.traits & MPM_LAW_SMALL_STRAIN;
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
