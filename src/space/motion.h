#pragma once
/*
  What an explicit step carries between points and nodes, in two passes over the points (momentum.c).
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
  PetscReal       *moves;                 /* of each point: velocity with which it moves, sum_i w_i v_new */
  PetscReal       *again; /* of each local node: the points' new momentum, of which this rank adds its part; or NULL */
} MpmMotionStep;
/* The points' new velocities, as MpmMomentumToPoints() has them; before the points are moved. */
PetscErrorCode MpmMotionToPoints(const MpmSum *sum, const MpmTransfer *transfer, const MpmMotionStep *step);
