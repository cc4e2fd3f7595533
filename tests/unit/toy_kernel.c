/*
  A physics of two fields, made for the tests: a neo-Hookean solid through which a scalar c diffuses.

    tau = mu (b - I) + lambda ln(J) I + beta c I ,       P = V_0 tau dF^{-T}                     conjugate to grad du
    V_0 (c - c_n)/dt                                                                             conjugate to c
    V_0 D J dF^{-1} dF^{-T} grad c                                                               conjugate to grad c

  Gradients are taken with respect to the position at the step's start, so that those by the position at its end are
  dF^{-T} grad; J = det F. The two fields act on each other through beta and through the J in the diffusivity. lambda
  and mu are the material's, D and beta the physics'.
*/
#include "talus/point/elasticity.h"

enum { DIFFUSIVITY, COUPLING };

#define SOLID_INPUTS MPM_TENSOR
#define INPUTS       (SOLID_INPUTS + 1 + MPM_DIM)

/* flux = V_0 D J dF^{-1} dF^{-T} grad c, with dF^{-1} = cof(dF)^T / det dF */
MPM_FN void Diffuse(const MpmKernelPoint *point, const Tensor *dF, Scalar J, const Scalar gradient[], Scalar flux[])
{
  const Tensor cofactor = TensorCofactor(dF);
  const Scalar det      = TensorCofactorDet(dF, &cofactor);
  const Scalar factor =
    ScalarScale(point->volume0 * point->physics_parameter[DIFFUSIVITY], ScalarDiv(J, ScalarSquare(det)));
  Scalar pulled[MPM_DIM];

  for (int a = 0; a < MPM_DIM; a++) {
    pulled[a] = ScalarConstant(0.);
    for (int b = 0; b < MPM_DIM; b++) ScalarAddProduct(&pulled[a], &cofactor.a[a * MPM_DIM + b], &gradient[b]);
  }
  for (int b = 0; b < MPM_DIM; b++) {
    Scalar sum = ScalarConstant(0.);

    for (int a = 0; a < MPM_DIM; a++) ScalarAddProduct(&sum, &cofactor.a[a * MPM_DIM + b], &pulled[a]);
    flux[b] = ScalarMul(factor, sum);
  }
}

static int ToyKernel(const MpmKernelPoint *point, const Scalar input[], Scalar flux[])
{
  const Lame   lame   = LameFromParameters(point->material.parameter);
  const Tensor dF     = TensorFromGradient(input);
  const Tensor F      = TensorMulArray(&dF, point->F_n);
  const Sym    b      = SymLeftCauchyGreen(&F);
  const Sym    strain = SymShift(&b, ScalarConstant(-1.)), isotonic = SymScaleBy(lame.mu, &strain);
  const Scalar J = TensorDet(&F), c = input[SOLID_INPUTS];
  Tensor       P;
  Sym          tau;

  if (!(ScalarValue(J) > 0.)) return 1;
  tau = SymShift(&isotonic,
                 ScalarAdd(ScalarScale(lame.lambda, ScalarLog(J)), ScalarScale(point->physics_parameter[COUPLING], c)));
  P   = SymTimesInverseTranspose(&tau, &dF, point->volume0);
  for (int k = 0; k < SOLID_INPUTS; k++) flux[k] = P.a[k];
  flux[SOLID_INPUTS] = ScalarScale(point->volume0 / point->dt, ScalarShift(c, -point->value_n[0]));
  Diffuse(point, &dF, J, &input[SOLID_INPUTS + 1], &flux[SOLID_INPUTS + 1]);
  if (point->end.F) {
    const Sym sigma = SymScaleBy(1. / ScalarValue(J), &tau);

    TensorStore(point->end.F, &F);
    SymStore(point->end.stress, &sigma);
  }
  return 0;
}

MPM_KERNEL(toy, INPUTS, ToyKernel)
