/*
  Projection: CEED's problems BP1, of one component, and BP2, of one an axis (projection_vector.c). Points stay in
  place.

    sum_p V_0 (u - f) v = 0   for all v

  f is the model's body force, whose part of the residual the engine adds; u at the points is kept as a result.

  Source of the problems: Fischer and others (2020), Scalability of high-performance PDE solvers,
  doi:10.1177/1094342020915762; at points: libCEED, examples/petsc/bpsswarm.c.
*/
#include "talus/point/law.h"

#if defined(BP_VECTOR)
#define BP_NAME       projection_vector
#define BP_COMPONENTS MPM_DIM
#define BP_PER_NODE   0 /* one an axis */
#define BP_KIND       MPM_STATE_VECTOR
#else
#define BP_NAME       projection
#define BP_COMPONENTS 1
#define BP_PER_NODE   1
#define BP_KIND       MPM_STATE_SCALAR
#endif

static int Kernel(const MpmKernelPoint *point, const Scalar input[], Scalar flux[])
{
  for (int c = 0; c < BP_COMPONENTS; c++) {
    flux[c] = ScalarScale(point->volume0, input[c]);
    if (point->end.F) point->end.own[c] = ScalarValue(input[c]);
  }
  for (int k = 0; point->end.F && k < MPM_TENSOR; k++) point->end.F[k] = point->F_n[k];
  return 0;
}

#if MPM_DIRECTIONS >= 2
static int Tangent(const MpmKernelPoint *point, const double input[], double flux[], double tangent[])
{
  for (int c = 0; c < BP_COMPONENTS; c++) {
    flux[c] = point->volume0 * input[c];
    for (int d = 0; d < BP_COMPONENTS; d++) tangent[c * BP_COMPONENTS + d] = c == d ? point->volume0 : 0.;
  }
  return 0;
}
#endif

#define BP_DEFINE(name_) MPM_KERNEL_TANGENT(name_, BP_COMPONENTS, Kernel, Tangent)
BP_DEFINE(BP_NAME)

#ifdef MPM_PHYSICS
static const MpmField fields[] = {
  {.name = "u", .components = BP_PER_NODE, .value = 1, .unit = "-", .near_null = MPM_NEAR_NULL_CONSTANT}};
static const MpmStateVariable states[] = {{"u", BP_KIND, 0., "-"}};

#define BP_DESCRIBE(name_) \
  MPM_PHYSICS(name_, .summary = "projection of a field from the points, CEED's BP1 and BP2", \
              .field_count = MPM_ROWS(fields), .fields = fields, .state_count = MPM_ROWS(states), .states = states, \
              .traits = MPM_PHYSICS_SYMMETRIC)
BP_DESCRIBE(BP_NAME)
#endif
