#pragma once
/*
  Mass and momentum between points and nodes, carried from step to step in dynamics (momentum.c).
*/
#include "base/base.h"
#include "base/types.h"

/*
  Mass (kg), and velocity (m/s) and acceleration (m/s2) weighted by it, at all local nodes, ghosts included; dim values
  a node; `acceleration` may be NULL. Nodes without mass are at rest. Of order 2 and more momentum and mass times
  acceleration themselves: the masses have any sign, and may be 0 where momentum is not.
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
