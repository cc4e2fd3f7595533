/*
  Saturated ground at one point (poro.c) with F-bar (solid_fbar.c): the volume change of the total stress is the mean
  over the points of the cell, and so is that of the water in the pores.

  With dF_bar, m and m_bar as in solid_fbar.c, J_bar = det(dF_bar F_n), tau' the law's stress at dF_bar F_n, tau = tau'
  - J_bar p I and tr over d components,

    momentum   (tau - (tr tau/d) I) : grad delta u + (tr tau/d) delta m_bar/m_bar
    water      zeta(J_bar, p), and the porosity of J_bar in the permeability

  Without dilation J_bar = m_bar J_n, so that all points of a cell have one relative change of the water's volume. The
  couplings of pressure and m_bar are then transposed, and the Jacobian is symmetric where that of poro is. The water
  flows through the ground as it lies, along gradients by dF.

  Sources: those of poro.c and solid_fbar.c.
*/
#include "fbar.h"
#include "poro.h"

#define INPUTS (PORO_INPUTS + 1)

/* The fluxes, and J_bar. */
MPM_FN int PoroFbarFluxes(const KernelPoint *point, const Scalar input[], Scalar *J, Scalar flux[])
{
  const Tensor dF = TensorFromGradient(input);
  Tensor       dm;
  const Scalar m = PointMean(point, &dF, &dm), mean = input[PORO_INPUTS];
  Sym          tau, total;

  if (!(ScalarValue(m) > 0. && ScalarValue(mean) > 0.)) return 1;
  const Scalar ratio  = point->material.traits & MPM_LAW_SMALL_STRAIN ? ScalarSub(mean, m) : ScalarDiv(mean, m);
  const Tensor dF_bar = MeanIncrement(point, &dF, ratio);

  *J = SolidNewVolume(point, &dF_bar);
  if (SolidStress(point, &dF_bar, &tau)) return 1;
  total = PoroTotalStress(point, &tau, *J, input[PORO_P]);
  FbarFlux(point, &total, &dF, mean, flux, &flux[PORO_INPUTS]);
  if (PoroMass(point, &dF, *J, input, flux)) return 1;
  SolidKeep(point, &tau, &dF_bar);
  return 0;
}

#if MPM_DIRECTIONS < 2
static int PoroFbarKernel(const KernelPoint *point, const Scalar input[], Scalar flux[])
{
  Scalar J;

  return PoroFbarFluxes(point, input, &J, flux);
}
#endif

#if defined(MPM_SENSITIVITY)
static int PoroFbarMean(const KernelPoint *point, const Scalar input[], Scalar *m, Scalar dm[])
{
  for (int k = GRADIENTS; k < PORO_INPUTS; k++) dm[k] = ScalarConstant(0.);
  return FbarMeanAlong(point, input, m, dm);
}
#elif MPM_DIRECTIONS != 1
static int PoroFbarMean(const KernelPoint *point, const double input[], double *m, double dm[], double ddm[])
{
  return FbarMean(point, input, PORO_INPUTS, m, dm, ddm);
}
#endif

#if MPM_DIRECTIONS > 1
/* With directions for dF, p and the mean. */
static int PoroFbarTangent(const KernelPoint *point, const double input[], double flux[], double tangent[])
{
  enum { COUNT = PORO_GRADIENTS + 1 };
  double *by_mean = tangent + PORO_INPUTS * PORO_INPUTS, *of_mean = by_mean + PORO_INPUTS;
  Scalar  in[INPUTS], out[INPUTS], J;

  for (int k = 0; k < INPUTS; k++) in[k] = k < COUNT ? ScalarSeed(input[k], k) : ScalarConstant(input[k]);
  in[PORO_INPUTS] = ScalarSeed(input[PORO_INPUTS], COUNT);
  if (PoroFbarFluxes(point, in, &J, out)) return 1;
  PoroTangent(point, in, J, COUNT, out, tangent);
  for (int k = 0; k < PORO_INPUTS; k++) {
    by_mean[k] = ScalarDirection(out[k], COUNT);
    of_mean[k] = k < COUNT ? ScalarDirection(out[PORO_INPUTS], k) : 0.;
  }
  of_mean[PORO_INPUTS] = ScalarDirection(out[PORO_INPUTS], COUNT);
  for (int k = 0; k < INPUTS; k++) flux[k] = ScalarValue(out[k]);
  return 0;
}
#endif

MPM_KERNEL_MEAN(poro_fbar, INPUTS, PoroFbarKernel, PoroFbarMean, PoroFbarTangent)

#ifdef MPM_PHYSICS
MPM_PHYSICS(poro_fbar, .summary = "saturated ground with the volume change averaged over cells", PORO_PHYSICS,
            .traits = PORO_TRAITS | MPM_PHYSICS_INTERNAL)
#endif
