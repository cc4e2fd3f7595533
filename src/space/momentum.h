#pragma once
/*
  Mass and momentum between points and nodes, carried from step to step in dynamics (momentum.c).

  A point has a velocity and, with APIC, an affine velocity. Momentum is kept to rounding both ways; so is angular
  momentum with APIC and splines of degree 2 and more. FLIP returns only the change in a step:

    v_p <- (1 - pic) (v_p + sum_i w_i (v_i^{n+1} - v_i^n)) + pic sum_i w_i v_i^{n+1}

  Source: Jiang, Schroeder, Teran (2017), J. Comput. Phys. 338, 137-164, doi:10.1016/j.jcp.2017.02.050 (APIC);
  Brackbill, Ruppel (1986), J. Comput. Phys. 65, 314-343, doi:10.1016/0021-9991(86)90211-1 (FLIP).
*/
#include "base/base.h"
#include "base/types.h"

/* How velocities go between points and nodes. */
typedef enum { MPM_TRANSFER_APIC, MPM_TRANSFER_FLIP } MpmTransferType;
extern const char *const MpmTransferTypes[];
typedef struct {
  MpmTransferType type;
  PetscReal       pic;    /* the share of PIC in FLIP, in [0, 1] */
  PetscInt        degree; /* of the shape's spline */
} MpmTransfer;

/*
  Mass (kg), and velocity (m/s) and acceleration (m/s2) weighted by it, at all local nodes, ghosts included; dim values
  a node; `acceleration` may be NULL. Nodes without mass are at rest.
*/
PetscErrorCode MpmMomentumToNodes(const MpmSum *sum, const MpmTransfer *transfer, PetscReal mass[],
                                  PetscReal velocity[], PetscReal acceleration[]);
/* Sums over this rank's points. */
typedef struct {
  PetscReal mass, kinetic;         /* kg, J: with the affine part */
  PetscReal momentum[MPM_MAX_DIM]; /* kg m/s */
  PetscReal angular[3];            /* about the origin, kg m2/s, with the affine part; 2D: the third */
} MpmMotionSums;
/* The space may be another one than that of the points' places: it is not used but where transfer->degree >= 2. */
PetscErrorCode MpmMotionSum(const MpmSum *sum, const MpmTransfer *transfer, MpmMotionSums *sums);
/*
  A bound on the sums of the rows of the stiffness matrix, N/m, at all local nodes, ghosts included:

    sum_p m_p c_p^2 |grad w_ip| sum_j |grad w_jp| ,  c_p the speed of waves at the point's state.
*/
PetscErrorCode MpmStiffnessRows(const MpmSum *sum, PetscReal rows[]);
