#pragma once
/*
  Shared by the kernels of solids: the flux of a stress, and the candidate of the next state.
*/
#include "talus/point/law.h"

/* J as mass counts it: det F, or 1 + tr(F - I) at small strain. */
MPM_FN Real SolidVolume(const KernelPoint *point, const Real *F)
{
  Real trace = 1.;

  if (!(point->material.traits & MPM_LAW_SMALL_STRAIN)) {
    const Tensor stretch = TensorFromArray(F);

    return TensorDetReal(&stretch);
  }
  for (int a = 0; a < MPM_NORMALS; a++) trace += F[MPM_NORMAL_AT(a)] - 1.;
  return trace;
}

/* The volume ratio of F_{n+1} = dF F_n, with its derivatives. */
MPM_FN Scalar SolidNewVolume(const KernelPoint *point, const Tensor *dF)
{
  if (!(point->material.traits & MPM_LAW_SMALL_STRAIN))
    return ScalarScale(SolidVolume(point, point->F_n), TensorDetByCofactors(dF));
  return ScalarShift(TensorTraceMulArray(dF, point->F_n), 1. - MPM_NORMALS);
}

/* The law's answer; in a stage without motion, the stress that is there already. */
MPM_FN int SolidStress(const KernelPoint *point, const Tensor *dF, Sym *tau)
{
  if (!point->stress_n) return LawStress(point, dF, tau);
  *tau = SymLoad(point->stress_n);
  if (!(point->material.traits & MPM_LAW_SMALL_STRAIN)) *tau = SymScaleBy(ArrayDetValue(point->F_n), tau);
  return 0;
}

/* The flux conjugate to du_a,b: V_0 (tau dF^{-T})_ab, or V_0 sigma_ac F_n,bc at small strain. */
MPM_FN void SolidFlux(const KernelPoint *point, const Sym *tau, const Tensor *dF, Scalar flux[])
{
  if (point->material.traits & MPM_LAW_SMALL_STRAIN) {
    for (int a = 0; a < MPM_DIM; a++) {
      for (int b = 0; b < MPM_DIM; b++) {
        Scalar sum = ScalarConstant(0.);

        for (int c = 0; c < MPM_DIM; c++) ScalarAddScaled(&sum, point->F_n[b * MPM_DIM + c], &tau->a[SymIndex(a, c)]);
        flux[a * MPM_DIM + b] = ScalarScale(point->volume0, sum);
      }
    }
#if defined(MPM_HOOP)
    flux[MPM_HOOP] = ScalarScale(point->volume0 * point->F_n[MPM_HOOP], tau->a[2]);
#endif
  } else {
    const Tensor P = SymTimesInverseTranspose(tau, dF, point->volume0);

    for (int k = 0; k < MPM_TENSOR; k++) flux[k] = P.a[k];
  }
}

/* F and Cauchy stress of the step's end, where somebody asks: Jacobians do not. */
MPM_FN void SolidKeep(const KernelPoint *point, const Sym *tau, const Tensor *dF)
{
  if (point->end.F) {
    const Tensor F     = TensorMulArray(dF, point->F_n);
    const int    small = point->material.traits & MPM_LAW_SMALL_STRAIN;
    const Sym    sigma = SymScaleBy(small ? 1. : 1. / TensorDetReal(&F), tau);

    TensorStore(point->end.F, &F);
    SymStore(point->end.stress, &sigma);
  }
}

#ifdef MPM_PHYSICS
static const MpmField solid_fields[] = {
  {.name = "displacement", .gradient = 1, .increment = 1, .unit = "m", .near_null = MPM_NEAR_NULL_RIGID}};
#endif
