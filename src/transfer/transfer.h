#pragma once
/*
  How a scene carries velocities between points and nodes.

  A point has a velocity and, with APIC, an affine velocity. Momentum is kept to rounding both ways; so is angular
  momentum with APIC and splines of degree 2 and more. FLIP returns only the change in a step:

    v_p <- (1 - pic) (v_p + sum_i w_i (v_i^{n+1} - v_i^n)) + pic sum_i w_i v_i^{n+1}

  Source: Jiang, Schroeder, Teran (2017), J. Comput. Phys. 338, 137-164, doi:10.1016/j.jcp.2017.02.050 (APIC);
  Brackbill, Ruppel (1986), J. Comput. Phys. 65, 314-343, doi:10.1016/0021-9991(86)90211-1 (FLIP).
*/
#include "base/base.h"
#include "base/types.h"

/* Transfer of velocities between points and nodes. */
typedef enum { MPM_TRANSFER_APIC, MPM_TRANSFER_FLIP } MpmTransferType;
extern const char *const MpmTransferTypes[];
typedef struct MpmTransfer {
  MpmTransferType type;
  PetscReal       pic;    /* the share of PIC in FLIP, in [0, 1] */
  PetscInt        degree; /* of the shape's spline */
} MpmTransfer;
