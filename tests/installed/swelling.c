/*
  Swelling: a solid of any law that what diffuses through it, c, pushes apart

    tau = tau_law - beta c 1 ,       P = V_0 tau dF^{-T}                                    conjugate to grad du
    V_0 ((c - c_n)/dt + gamma J)                                                           conjugate to c
    V_0 D J grad c                                                                         conjugate to grad c

  beta, gamma and D are the physics' parameters. It has a direction for each input. c is quadratic, whatever the
  displacement is. A point remembers the largest c that it has had.
*/
#include "talus/point/law.h"

enum { PUSH, SOURCE, DIFFUSIVITY };

#define SOLID  (MPM_DIM * MPM_DIM)
#define INPUTS (SOLID + 1 + MPM_DIM)

static int SwellingKernel(const MpmKernelPoint *point, const Scalar input[], Scalar flux[])
{
  const double *physics = point->physics_parameter;
  const Tensor  dF      = TensorFromGradient(input);
  const Tensor  F       = TensorMulArray(&dF, point->F_n);
  const Scalar  J = TensorDet(&F), c = input[SOLID];
  Scalar        rate;
  Tensor        P;
  Sym           tau;

  if (!(ScalarValue(J) > 0.) || LawStress(point, &dF, &tau)) return 1;
  tau = SymShift(&tau, ScalarScale(-physics[PUSH], c));
  P   = SymTimesInverseTranspose(&tau, &dF, point->volume0);
  for (int k = 0; k < SOLID; k++) flux[k] = P.a[k];
  rate        = ScalarScale(1. / point->dt, ScalarShift(c, -point->value_n[0]));
  flux[SOLID] = ScalarScale(point->volume0, ScalarAdd(rate, ScalarScale(physics[SOURCE], J)));
  for (int a = 0; a < MPM_DIM; a++)
    flux[SOLID + 1 + a] = ScalarScale(point->volume0 * physics[DIFFUSIVITY], ScalarMul(J, input[SOLID + 1 + a]));
  if (point->end.F) {
    const Sym sigma = SymScaleBy(1. / ScalarValue(J), &tau);

    TensorStore(point->end.F, &F);
    SymStore(point->end.stress, &sigma);
    point->end.own[0] = fmax(point->own_n[0], ScalarValue(c));
  }
  return 0;
}

MPM_KERNEL(swelling, INPUTS, SwellingKernel)

#ifdef MPM_PHYSICS
static const MpmField fields[] = {
  {.name = "displacement", .gradient = 1, .increment = 1, .unit = "m", .near_null = MPM_NEAR_NULL_RIGID},
  {.name       = "solvent",
   .components = 1,
   .degree     = 2,
   .value      = 1,
   .gradient   = 1,
   .rate       = 1,
   .symbol     = "s",
   .near_null  = MPM_NEAR_NULL_CONSTANT,
   .scale      = MPM_SCALE_ONE},
};
static const MpmParameter parameters[] = {
  {MPM_NUMBER, "push", "Pa", 0.3, 0, -HUGE_VAL, HUGE_VAL, 0, "pressure of the solvent", NULL, 0., NULL},
  {MPM_NUMBER, "source", "1/s", 0.1, 0, -HUGE_VAL, HUGE_VAL, 0, "solvent that comes with the volume", NULL, 0., NULL},
  {MPM_NUMBER, "diffusivity", "m2/s", 0.5, 0, 0., HUGE_VAL, 0, "how fast the solvent spreads", NULL, 0., NULL},
};
static const MpmStateVariable states[] = {{"most_solvent", MPM_STATE_SCALAR, 0., "-"}};
MPM_PHYSICS(swelling, .summary = "a solid that swells with what diffuses through it", .field_count = MPM_ROWS(fields),
            .fields = fields, .parameter_count = MPM_ROWS(parameters), .parameters = parameters,
            .state_count = MPM_ROWS(states), .states = states)
#endif
