/*
  Poisson's equation: CEED's problems BP3, of one component, and BP4, of one an axis (poisson_vector.c). Points stay in
  place.

    sum_p V_0 (grad u - q) . grad v = sum_p V_0 f v   for all v

  f is the model's body force, whose part of the residual the engine adds. q is the load as a flux, a state of the
  points that is 0 at the start. With q = grad u of a solution the errors of the points' quadrature act on the error of
  the gradient alone.

  Source of the problems: as in projection.c.
*/
#include "talus/point/law.h"

#if defined(BP_VECTOR)
#define BP_NAME       poisson_vector
#define BP_COMPONENTS MPM_DIM
#define BP_PER_NODE   0 /* one an axis */
#else
#define BP_NAME       poisson
#define BP_COMPONENTS 1
#define BP_PER_NODE   1
#endif
#define BP_INPUTS (BP_COMPONENTS * MPM_DIM)

static int Kernel(const MpmKernelPoint *point, const Scalar input[], Scalar flux[])
{
  for (int k = 0; k < BP_INPUTS; k++) {
    flux[k] = ScalarScale(point->volume0, ScalarShift(input[k], -point->own_n[k]));
    if (point->end.F) point->end.own[k] = point->own_n[k];
  }
  for (int k = 0; point->end.F && k < MPM_TENSOR; k++) point->end.F[k] = point->F_n[k];
  return 0;
}

#if MPM_DIRECTIONS >= 2
static int Tangent(const MpmKernelPoint *point, const double input[], double flux[], double tangent[])
{
  for (int k = 0; k < BP_INPUTS; k++) {
    flux[k] = point->volume0 * (input[k] - point->own_n[k]);
    for (int l = 0; l < BP_INPUTS; l++) tangent[k * BP_INPUTS + l] = k == l ? point->volume0 : 0.;
  }
  return 0;
}
#endif

#define BP_DEFINE(name_) MPM_KERNEL_TANGENT(name_, BP_INPUTS, Kernel, Tangent)
BP_DEFINE(BP_NAME)

#ifdef MPM_PHYSICS
static const MpmField fields[] = {
  {.name = "u", .components = BP_PER_NODE, .gradient = 1, .unit = "-", .near_null = MPM_NEAR_NULL_CONSTANT}};
/* The flux of each component; in the plane that of the third has no meaning. */
static const MpmStateVariable states[] = {
  {"load", MPM_STATE_VECTOR, 0., "1/m"},
#if defined(BP_VECTOR)
  {"load_second", MPM_STATE_VECTOR, 0., "1/m"},
  {"load_third", MPM_STATE_VECTOR, 0., "1/m"},
#endif
};

#define BP_DESCRIBE(name_) \
  MPM_PHYSICS(name_, .summary = "Poisson's equation, CEED's BP3 and BP4", .field_count = MPM_ROWS(fields), \
              .fields = fields, .state_count = MPM_ROWS(states), .states = states, .traits = MPM_PHYSICS_SYMMETRIC)
BP_DESCRIBE(BP_NAME)
#endif
