/*
  Depth-averaged flow at one point: a column of material, whose base deforms with the horizontal velocity.

  The kernel is the solid's, with the deformation dF of the base; a point's volume V_0 = A_0 h_0 is that of its column,
  of constant density. Columns have no stress of their own: the law keeps their depth. The pressure of the depth, the
  bed's slope and its resistance are a term of the nodes, src/terrain/bed_flow.h, which has the equations.
*/
#include "talus/point/basal.h"
#include "solid.h"

static int DepthAveragedKernel(const KernelPoint *point, const Scalar input[], Scalar flux[])
{
  const Tensor dF = TensorFromGradient(input);
  Sym          tau;

  if (SolidStress(point, &dF, &tau)) return 1;
  for (int k = 0; k < MPM_TENSOR; k++) flux[k] = ScalarConstant(0.);
  if (point->end.F) {
    const Tensor F = TensorMulArray(&dF, point->F_n);

    TensorStore(point->end.F, &F);
    SymStore(point->end.stress, &tau);
  }
  return 0;
}

MPM_KERNEL(depth_averaged, MPM_TENSOR, DepthAveragedKernel)

#ifdef MPM_PHYSICS
MPM_PHYSICS(depth_averaged, .summary = "flow over terrain by its depth and horizontal velocity (explicit steps, dim 2)",
            .field_count = MPM_ROWS(solid_fields), .fields = solid_fields,
            .traits = MPM_PHYSICS_SYMMETRIC | MPM_PHYSICS_STRESS | MPM_PHYSICS_COLUMNS)
#endif
