/*
  The quasi-static solid at one point with F-bar: the volume change is the mean over the points of the cell, which keeps
  low-order shapes from locking when the material hardly changes its volume.

  With d dimensions, dF = I + du (x) G and m = det dF of the point, the law sees

    dF_bar = (m_bar/m)^{1/d} dF ,    m_bar = sum_q w_q m_q ,   w_q the point's share of the cell's volume

  (in plane strain the part in the plane is scaled). What is assembled is the variation of the same work, so the
  Jacobian of a law with a potential is symmetric: with tau the law's stress at dF_bar F_n and tr over d components,

    tau : delta(dF_bar) dF_bar^{-1} = (tau - (tr tau/d) I) : grad delta u + (tr tau/d) delta m_bar/m_bar

  The flux of m_bar is V_0 tr tau/(d m_bar); its sum over the cell comes back, times w_p, as mean_flux, the factor of
  delta m = cof(dF) : delta(dF). F of the converged step is that of dF_bar, so that volume and stress belong together.

  At small strain m = 1 + tr h with h the increment of the displacement gradient by X, and h_bar = h + ((m_bar - m)/d) I.

  Sources: de Souza Neto, Peric, Dutko and Owen (1996), doi:10.1016/0020-7683(95)00259-6; for the material point method
  Coombs, Charlton, Cortis and Augarde (2018), doi:10.1016/j.cma.2018.01.010; the variational form is the mean dilatation
  of Simo, Taylor and Pister (1985), doi:10.1016/0045-7825(85)90033-7.
*/
#include "mpmkernel.h"

#define GRADIENTS (MPM_DIM * MPM_DIM)
#define INPUTS    (GRADIENTS + 1)

/* m, and m_bar's change with the point: dm[k] = d m / d input_k */
MPM_FN Scalar PointMean(const MpmKernelPoint *point, const Tensor *dF, Tensor *dm)
{
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
  *dm = TensorCofactor(dF);
  return TensorCofactorDet(dF, dm);
}

/* dF_bar */
MPM_FN Tensor MeanIncrement(const MpmKernelPoint *point, const Tensor *dF, Scalar m, Scalar mean)
{
  if (point->traits & MPM_LAW_SMALL_STRAIN) { /* dF_bar F_n = dF F_n + ((m_bar - m)/d) I */
    const Tensor F_n = TensorFromArray(point->F_n), inverse = TensorInverse(&F_n);
    const Tensor shift = TensorScale(ScalarScale(1. / MPM_DIM, ScalarSub(mean, m)), &inverse);

    return TensorAdd(dF, &shift);
  }
  return TensorScale(ScalarPow(ScalarDiv(mean, m), 1. / MPM_DIM), dF);
}

static int SolidFbarKernel(const MpmKernelPoint *point, const Scalar input[], Scalar flux[])
{
  const MpmLawPoint law_point    = {point->parameter, point->state_n, point->state, point->F_n, point->dt};
  const MPM_INSTANCE(MpmLaw) law = (MPM_INSTANCE(MpmLaw))point->law[MPM_KERNEL_FORM];
  const int    small             = point->traits & MPM_LAW_SMALL_STRAIN;
  const Tensor dF                = TensorFromGradient(input);
  const Scalar mean              = input[GRADIENTS];
  Tensor       dm;
  const Scalar m        = PointMean(point, &dF, &dm);
  Scalar       pressure = ScalarConstant(0.); /* tr tau/d */
  Sym          tau, rest;

  if (!(ScalarValue(m) > 0. && ScalarValue(mean) > 0.)) return 1;
  const Tensor dF_bar = MeanIncrement(point, &dF, m, mean);

  if (law(&law_point, &dF_bar, &tau)) return 1;
  for (int a = 0; a < MPM_DIM; a++) ScalarAddScaled(&pressure, 1. / MPM_DIM, &tau.a[SymIndex(a, a)]);
  rest = SymShift(&tau, ScalarNeg(pressure));
  if (small) {
    for (int a = 0; a < MPM_DIM; a++) {
      for (int b = 0; b < MPM_DIM; b++) {
        Scalar sum = ScalarConstant(0.);

        for (int c = 0; c < MPM_DIM; c++) ScalarAddScaled(&sum, point->F_n[b * MPM_DIM + c], &rest.a[SymIndex(a, c)]);
        flux[a * MPM_DIM + b] = ScalarScale(point->volume0, sum);
      }
    }
    flux[GRADIENTS] = ScalarScale(point->volume0, pressure);
  } else {
    const Tensor P = SymTimesInverseTranspose(&rest, &dF, point->volume0);

    for (int k = 0; k < GRADIENTS; k++) flux[k] = P.a[k];
    flux[GRADIENTS] = ScalarScale(point->volume0, ScalarDiv(pressure, mean));
  }
  for (int k = 0; k < GRADIENTS; k++) ScalarAddScaled(&flux[k], point->mean_flux, &dm.a[k]);
  if (point->F) { /* what may become the state: Jacobians do not ask for it */
    const Tensor F     = TensorMulArray(&dF_bar, point->F_n);
    const Sym    sigma = SymScaleBy(small ? 1. : 1. / TensorDetValue(&F), &tau);

    TensorStore(point->F, &F);
    SymStore(point->stress, &sigma);
  }
  return 0;
}

#if MPM_DIRECTIONS == 0
static int SolidFbarMean(const MpmKernelPoint *point, const double *input, double *m, double *dm)
{
  const Tensor dF = TensorFromGradient(input);
  Tensor       derivative;

  *m = PointMean(point, &dF, &derivative);
  TensorStore(dm, &derivative);
  return !(*m > 0. && *m <= DBL_MAX);
}
#endif

MPM_KERNEL_MEAN(solid_fbar, INPUTS, SolidFbarKernel, SolidFbarMean)
