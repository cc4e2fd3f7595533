#pragma once
/*
  One point of a step along up to MPM_PACK directions at once.
*/
#include "stepmap/rates_map.h"

#define MPM_ARGUMENTS (MPM_BY_COUNT * MPM_MAX_DIM) /* of a point's weights: places, half-lengths */

/* Room for one point. Rows have MPM_PACK numbers, a column for each direction; arrays at nodes follow by direction. */
typedef struct {
  MpmPointWork point;
  MpmBasis     part[MPM_ARGUMENTS];
  PetscBool    moves[MPM_ARGUMENTS];               /* any direction changes this argument */
  PetscReal    argument[MPM_ARGUMENTS * MPM_PACK]; /* rows */
  PetscReal    place[MPM_ARGUMENTS][MPM_MAX_DIM];  /* change of sum_i w_i u_i by an argument */
  PetscReal    dinput[MPM_MAX_INPUTS * MPM_PACK], dflux[MPM_MAX_INPUTS * MPM_PACK];
  PetscReal    dF[MPM_F_MAX * MPM_PACK], F[MPM_F_MAX * MPM_PACK], stress[6 * MPM_PACK];
  PetscReal   *dstate, *state, *parameter, *own; /* rows */
  PetscReal   *rates;                            /* rows of the numbers of a rate, then of the physics' parameters */
  PetscReal   *du, *force, *by_argument;
} MpmAlongWork;

PetscErrorCode MpmAlongWorkCreate(const MpmStepMap *map, MpmAlongWork *work);
PetscErrorCode MpmAlongWorkDestroy(MpmAlongWork *work);
/* A group's points follow; and the forces of its directions go to the residuals. */
void MpmAlongGather(const MpmStepMap *map, const MpmStepDirections *directions, const MpmGroup *group,
                    MpmAlongWork *work);
void MpmAlongScatter(const MpmStepMap *map, const MpmStepDirections *directions, const MpmGroup *group,
                     const MpmAlongWork *work);
/* The changes of the arguments of the point's weights. */
PetscErrorCode MpmAlongArguments(const MpmStepMap *map, const MpmStepDirections *directions, const MpmGroup *group,
                                 PetscInt p, MpmAlongWork *work);
/* The point, its inputs, and the changes of these and of its state. */
PetscErrorCode MpmAlongEnter(const MpmStepMap *map, const MpmStepDirections *directions, const MpmGroup *group,
                             PetscInt p, MpmAlongWork *work, MpmKernelPoint *point);
/* The changes of all that its kernel takes. */
MpmKernelDirection MpmAlongDirection(const MpmStepMap *map, const MpmStepDirections *directions, PetscInt p,
                                     MpmAlongWork *work);
/* The kernel's answer at the inputs and its changes; F and history of the step's end, where they are wanted. */
PetscErrorCode MpmAlongDifferentiate(const MpmStepMap *map, const MpmStepDirections *directions, PetscInt p,
                                     const MpmKernelPoint *point, MpmAlongWork *work);
/* The place at the step's end, where it is wanted. */
void MpmAlongPlace(const MpmStepMap *map, const MpmStepDirections *directions, PetscInt p, const MpmAlongWork *work);
/* Adds the forces of the fluxes and their changes. */
void MpmAlongForces(const MpmStepMap *map, const MpmStepDirections *directions, const PetscReal flux[],
                    const PetscReal dflux[], MpmAlongWork *work);
