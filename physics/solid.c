/*
  The quasi-static solid at one point.

  The unknown is the displacement increment du of the step. With G the gradient by the position x_n at the step's start,

    dF = I + du (x) G,   dF_ab = delta_ab + du_a,b ,      F_{n+1} = dF F_n

  the law gives the Kirchhoff stress tau of F_{n+1}, and the flux conjugate to du_a,b is

    P_ab = V_0 (tau dF^{-T})_ab ,     so that   f_int,i = sum_p P G_i = sum_p V sigma g_i ,  g_i = dF^{-T} G_i , V = J
    V_0 .

  A small-strain law leaves the geometry alone and takes gradients by the initial position X: d/dX_c = F_n,bc d/dx_b, so
  P_ab = V_0 sigma_ac F_n,bc.

  Source: Charlton, Coombs and Augarde (2017), Comput.
  Struct. 190, 108-125, doi:10.1016/j.compstruc.2017.05.004, in the form that carries the derivative to the step's
  start.
*/
#include "solid.h"

static int SolidKernel(const KernelPoint *point, const Scalar input[], Scalar flux[])
{
  const Tensor dF = TensorFromGradient(input);
  Sym          tau;

  if (SolidStress(point, &dF, &tau)) return 1;
  SolidFlux(point, &tau, &dF, flux);
  SolidKeep(point, &tau, &dF);
  return 0;
}

MPM_KERNEL(solid, MPM_TENSOR, SolidKernel)

#ifdef MPM_PHYSICS
MPM_PHYSICS(solid, .summary = "quasi-static solid at finite strain", .field_count = MPM_ROWS(solid_fields),
            .fields = solid_fields, .traits = MPM_PHYSICS_SYMMETRIC | MPM_PHYSICS_STRESS, .fbar = "solid_fbar")
#endif
