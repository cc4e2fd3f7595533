#pragma once
/*
  What a step hands back to the points, and what an explicit one carries to the nodes, a pass over the points each (momentum.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "space/momentum.h"

/* Numbers a node: mass, momentum, and the points' forces, in this order. */
#define MPM_MOTION(dim) (1 + 2 * (dim))

/*
  Adds this rank's part to `nodal`, MPM_MOTION(dim) numbers a local node: kg, kg m/s, and N, sum_p V_p sigma_p grad w_ip in the
  stress of the step's start, taken negative: what it pushes with.
*/
PetscErrorCode MpmMotionToNodes(const MpmSum *sum, const MpmTransfer *transfer, PetscReal nodal[]);

/* What the second pass takes from the local nodes, dim values each, and what it leaves. */
typedef struct {
  const PetscReal *v_old, *v_new, *a_new; /* at the step's start and end; accelerations, or NULL */
  PetscReal       *moves;                 /* of each point: velocity with which it moves, sum_i w_i v_new; or NULL */
  PetscReal       *again; /* of each local node: the points' new momentum, of which this rank adds its part; or NULL */
} MpmMotionStep;
/* The points' new velocities and accelerations. Before the points are moved: the weights are those of the step's start. */
PetscErrorCode MpmMotionToPoints(const MpmSum *sum, const MpmTransfer *transfer, const MpmMotionStep *step);

/* y += M a with the points' consistent mass: values at the local nodes, dim each; the rows of ghosts hold what this rank adds. */
PetscErrorCode MpmMassMultiply(const MpmSum *sum, const PetscReal a[], PetscReal y[]);
