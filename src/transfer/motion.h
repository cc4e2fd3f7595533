#pragma once
/*
  Transfer from a step to the points, and of an explicit step to the nodes, a pass over the points each (momentum.c).
*/
#include "base/base.h"
#include "base/types.h"

/*
  Mass (kg) and velocity (m/s) at all local nodes, ghosts included. Adds to `force`, of which each rank has its share of
  the loads, the internal forces - sum_p V_p sigma_p grad w_ip in the stress of the step's start, N. Afterwards ghosts
  have their owners' values. dim values a node; nodes without mass are at rest.
*/
PetscErrorCode MpmMotionToNodes(const MpmSum *sum, const MpmTransfer *transfer, PetscReal mass[], PetscReal velocity[],
                                PetscReal force[]);

/* Input of the second pass from the local nodes, dim values each, and its results. */
typedef struct {
  const PetscReal *v_old, *v_new, *a_new; /* at the step's start and end; accelerations, or NULL */
  PetscReal       *moves;                 /* of each point: velocity with which it moves, sum_i w_i v_new; or NULL */
  PetscReal       *again;  /* of each local node: the points' new momentum, of which this rank adds its part; or NULL */
  const PetscReal *affine; /* in place of v_new for the affine part; or NULL */
  PetscBool        thin;   /* of points on edges of the grid alone */
} MpmMotionStep;
/* New velocities and accelerations of the points, before they are moved: the weights are those of the step's start. */
PetscErrorCode MpmMotionToPoints(const MpmSum *sum, const MpmTransfer *transfer, const MpmMotionStep *step);

/* Affine velocities of fluids, once the trial has the step's end and before it is kept (convect_affine.c). */
void MpmMotionConvect(const MpmSum *sum, const MpmTransfer *transfer, const MpmTrial *trial);

/*
  y_i = sum_p m_p w_ip a_p at the owned nodes, kg m/s2: as forces, the accelerations a_p = sum_j w_jp a_j of the points
  from those of the local nodes, dim a node.
*/
PetscErrorCode MpmMotionFeel(const MpmSum *sum, const PetscReal a[], PetscReal y[]);

/*
  The consistent mass M_ij = sum_p m_p w_ip w_jp over this rank's points, kg: one number for a pair of local nodes,
  whatever the component. Rows of ghosts have this rank's contribution. Nodes that no point touches have empty rows.
*/
typedef struct {
  PetscInt   reach;  /* a row's columns lie in a window of (2*reach + 1)^dim nodes around it */
  PetscInt   nodes;  /* local */
  PetscInt  *start;  /* nodes + 1: where each row begins */
  PetscInt  *column; /* local nodes */
  PetscInt  *place;  /* of each column in the window, x fastest */
  PetscReal *value;
} MpmMassMatrix;
/* The mass of the sum's points, in place of the last one: it does not change within a step. */
PetscErrorCode MpmMassMatrixSetUp(MpmMassMatrix *mass, const MpmSum *sum);
PetscErrorCode MpmMassMatrixReset(MpmMassMatrix *mass);

/* The spin at a point of a group of velocities v of the local nodes, 1/s: W_ab = (v_a,b - v_b,a)/2, dim x dim. */
PetscErrorCode MpmSpinAtPoint(const MpmSum *sum, PetscInt group, PetscInt point, const PetscReal v[], PetscReal W[]);
