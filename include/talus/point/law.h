#pragma once
/*
  The pointwise engine: what a constitutive law and a physics see of one material point.

  A kernel is written once, in `Scalar`, and compiled for several scalar types. CMake compiles every file of materials/
  and physics/ once for each instance, an instance being a pair of

    MPM_DIM          2 or 3
    MPM_AXISYMMETRIC defined with MPM_DIM 2: axial symmetry, x the radius, y the axis; plane strain without
    MPM_DIRECTIONS   number of derivative directions that a Scalar carries: 0 (plain double), 1 (one direction, for
                     Jacobian actions and colouring), or one for each component of dF (a point's whole tangent). A
                     physics may have as many directions as inputs: LawStress() composes a law's by the chain rule
    MPM_SENSITIVITY  defined in one more instance of every law, and of some physics, with derivatives by anything they
                     are given, history, deformation, parameters and dF. Real is a double in all others

  Every symbol with external linkage carries the instance in its name through MPM_INSTANCE(). Nothing here or in a
  kernel calls PETSc, allocates, does I/O or touches a global, and all of it is in the common subset of C11 and CUDA
  C++.

  Signs: tension positive. Components of symmetric tensors: xx, yy, zz, xy (, yz, xz).
*/
#if !defined(MPM_DIM) || !defined(MPM_DIRECTIONS)
#error "compile this file through the build's list of kernel instances: MPM_DIM and MPM_DIRECTIONS are not set"
#endif
#include "tables.h"
#include "tensor.h"

#define MPM_INSTANCE3(a, b, c) a##_##b##_##c
#define MPM_INSTANCE2(a, b, c) MPM_INSTANCE3(a, b, c)
#if defined(MPM_AXISYMMETRIC)
#define MPM_KIND axial
#elif MPM_DIM == 2
#define MPM_KIND 2d
#else
#define MPM_KIND 3d
#endif
/* MPM_INSTANCE(name) is name_2d_0, name_3d_9, name_axial_5, name_2d_sensitivity, ... */
#if defined(MPM_SENSITIVITY)
#define MPM_INSTANCE(name) MPM_INSTANCE2(name, MPM_KIND, sensitivity)
#else
#define MPM_INSTANCE(name) MPM_INSTANCE2(name, MPM_KIND, MPM_DIRECTIONS)
#endif

/*
  Data of one point for a constitutive law.

  parameter in the order of the law's parameter table; a word's is its index
  state_n   history at the step's start, in the order of the law's state table
  state     destination of history at the step's end, or NULL when the caller does not need it (Jacobians): a law
            must not write it, nor spend time on it, then
  F_n       deformation gradient at the step's start, as a Tensor has it
  dt        the step's time, s
  table     contents of tables and data, by parameter; read through TableCount(), TableEntry(), TableSegmentAt()
  table_direction  their derivatives, or NULL; columns: those of them that the Reals have
*/
typedef struct {
  const Real        *parameter;
  const Real        *state_n;
  Real              *state;
  const Real        *F_n;
  Real               dt;
  const MpmLawTable *table;
#if defined(MPM_SENSITIVITY)
  const MpmLawTable *table_direction;
  RealColumns        columns;
#endif
} MpmLawPoint;

/*
  A constitutive law: dF = F_{n+1} F_n^{-1} in, Kirchhoff stress tau (Pa) out. Returns 0, or non-zero where it has no
  answer (det F <= 0, no real root): the caller then reports a domain error and the step backs off.
*/
typedef int (*MPM_INSTANCE(MpmLaw))(const MpmLawPoint *point, const Tensor *dF, Sym *tau);

/*
  A physics' kernel: inputs (values and gradients of its fields, gradients taken with respect to the position at the
  step's start) to conjugate fluxes, integrated over the point: the residual of node i is the sum over points and inputs
  k of phi_k(i) flux_k, where phi_k is the weight or the derivative of it that made input k.
*/
typedef int (*MPM_INSTANCE(MpmKernel))(const MpmKernelPoint *point, const Scalar input[], Scalar flux[]);

#include "lookup.h"

#include "instance.h"

#if !defined(MPM_SENSITIVITY)
/* A point as a physics' kernel sees it; in the instances that differentiate by the state at the step's start
   another type. */
typedef MpmKernelPoint KernelPoint;
#define KernelAt(point_, array_, k_)      ((point_)->array_[k_])
#define KernelStageAt(point_, array_, k_) ((point_)->stage->array_[k_])
#include "compose.h"
#endif
