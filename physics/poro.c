/*
  Saturated ground at one point: displacement and pore pressure, quasi-static; grains and (by default) water are
  incompressible.

  With tau' the law's Kirchhoff stress, J = det F, p the pore pressure, positive in compression, G gradients by the
  position at the step's start, and phi~ = phi - mean of phi over the cell, one step from n to n+1 solves

    momentum   sum_p V_0 (tau' - J p I) dF^{-T} G_i = f_i
    water      sum_p V_0 (zeta - zeta_n) phi_i + dt V_0 J (dF^{-T} G_i) . m (dF^{-T} G p - rho_w g)
                   + V_0 c/(2 mu) (p~ - p~_n) phi~_i = 0

  zeta = J - 1 is the water that an initial volume has taken up, with grains of constant volume. Its increment is exact,
  so that the outflow equals the loss of the pores. Water of bulk modulus K_w takes (J - s)(1 + p/K_w) - (1 - s), with
  s = 1 - n_0 the fraction of grains. The last term is the polynomial pressure projection. Without it displacement and
  pressure of equal order have pressures that alternate from cell to cell where nothing drains. The factor c is
  -mpm_stabilization_ppp, and less where water moves (PoroProjection()). The mobility m = k/mu_w is constant in space or

    kozeny_carman   k = k_0 (n/n_0)^3 ((1 - n_0)/(1 - n))^2 ,    n = 1 - s/J
    uzuoka_borja    k = k_0 (lambda + 2 mu) J/M(J) ,   M(J) = mu (1 + 1/J^2) + lambda (1 - ln J)/J^2

  the second of which makes one-dimensional consolidation of the neo-Hookean solid a linear problem. The water's
  equation is taken times -1: its coupling to displacement is then the transpose of the coupling of momentum to
  pressure.

  At small strain J = 1 + tr h, with h the displacement gradient by the initial position, by which gradients are taken.

  Sources: Zhao and Choo (2020), doi:10.1016/j.cma.2020.113048 (formulation, stabilisation); White and Borja (2008),
  doi:10.1016/j.cma.2008.05.015 (1/(2 mu)); Uzuoka and Borja (2012), doi:10.1002/nag.1087.
*/
#include "poro.h"

/* The fluxes, and J. */
MPM_FN int PoroFluxes(const KernelPoint *point, const Scalar input[], Scalar *J, Scalar flux[])
{
  const Tensor dF = TensorFromGradient(input);
  Sym          tau, total;

  *J = SolidNewVolume(point, &dF);
  if (!(ScalarValue(*J) > 0.) || SolidStress(point, &dF, &tau)) return 1;
  total = PoroTotalStress(point, &tau, *J, input[PORO_P]);
  SolidFlux(point, &total, &dF, flux);
  if (PoroMass(point, &dF, *J, input, flux)) return 1;
  SolidKeep(point, &tau, &dF);
  return 0;
}

#if MPM_DIRECTIONS < 2
static int PoroKernel(const KernelPoint *point, const Scalar input[], Scalar flux[])
{
  Scalar J;

  return PoroFluxes(point, input, &J, flux);
}
#else
/* With directions for dF alone, which is what laws are compiled for: what p does to the stress is what dF does to J. */
static int PoroKernelTangent(const KernelPoint *point, const double input[], double flux[], double tangent[])
{
  Scalar in[PORO_INPUTS], out[PORO_INPUTS], J;

  for (int k = 0; k < PORO_INPUTS; k++) in[k] = k < PORO_GRADIENTS ? ScalarSeed(input[k], k) : ScalarConstant(input[k]);
  if (PoroFluxes(point, in, &J, out)) return 1;
  PoroTangent(point, in, J, PORO_GRADIENTS, out, tangent);
  for (int k = 0; k < PORO_GRADIENTS; k++) tangent[k * PORO_INPUTS + PORO_P] = -point->volume0 * ScalarDirection(J, k);
  tangent[PORO_P * PORO_INPUTS + PORO_P] = -point->volume0 * PoroContentByPressure(point, ScalarValue(J));
  for (int k = 0; k < PORO_INPUTS; k++) flux[k] = ScalarValue(out[k]);
  return 0;
}
#endif

MPM_KERNEL_TANGENT(poro, PORO_INPUTS, PoroKernel, PoroKernelTangent)

#ifdef MPM_PHYSICS
MPM_PHYSICS(poro, .summary = "saturated ground: displacement and pore pressure (Biot's consolidation at finite strain)",
            PORO_PHYSICS, .traits = PORO_TRAITS, .fbar = "poro_fbar")
#endif
