#pragma once
/*
  One point of a step's derivatives: room for its numbers, its weights' changes, and the kernel's answers.
*/
#include "space/kernel_point.h"
#include "space/point_loop.h"
#include "space/point_slopes.h"
#include "stepmap/step_map.h"

/* Room for one point's numbers. */
typedef struct {
  MpmKnown       known;
  MpmPointSlopes slopes;
  MpmBasis       basis, slope, part;
  PetscReal     *u, *other, *force; /* at the group's nodes, by component */
  PetscReal      input[MPM_MAX_INPUTS], other_input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS], dflux[MPM_MAX_INPUTS];
  PetscReal      F[2][MPM_F_MAX], stress[2][6], *state[2], *own[2];
  double        *parameter; /* a direction, zeros between calls */
} MpmPointWork;

PetscErrorCode MpmPointWorkCreate(const MpmStepMap *map, MpmPointWork *work);
PetscErrorCode MpmPointWorkDestroy(MpmPointWork *work);
/* A group's points follow: values of u, and of `other` unless it is NULL, at its nodes; forces are 0. */
void MpmPointWorkGather(const MpmStepMap *map, const MpmGroup *group, const PetscReal other[], MpmPointWork *work);
/* The point, its basis functions and inputs; `other` at the nodes has inputs, too. */
void MpmPointEnter(const MpmStepMap *map, PetscInt p, PetscBool other, MpmPointWork *work, MpmKernelPoint *point);
/* The point as its kernel takes it, alone. */
void MpmPointMake(const MpmStepMap *map, PetscInt p, MpmPointWork *work, MpmKernelPoint *point);
/* The kernel's answer at work->input and its derivative in a direction. */
PetscErrorCode MpmPointDifferentiate(const MpmStepMap *map, const MpmKernelPoint *point,
                                     const MpmKernelDirection *direction, MpmPointWork *work);
/* Adds the change of the kernel's fluxes with the point's initial volume, to which they are proportional. */
void MpmPointVolumeAlong(const MpmPointVector *start, PetscInt p, MpmPointWork *work);
/* The change of L with it through the point's own fluxes, added to `start`. */
void MpmPointPullVolume(const PetscReal flux[], PetscInt p, const MpmPointWork *work, MpmPointVector *start);
/* A parameter's direction among those of the law of its points: 1, or 0 again. */
void MpmPointSetDirection(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscReal value,
                          MpmPointWork *work);
/* True where a parameter acts on the law of point p. */
PetscBool MpmPointHasParameter(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscInt p);
/* Likewise of a field along a direction: the change of the law's parameters at point p. */
PetscBool MpmPointGroundEnter(const MpmStepMap *map, const MpmGroundDirection *direction, PetscInt p,
                              MpmPointWork *work);
void      MpmPointGroundForget(const MpmStepMap *map, const MpmGroundDirection *direction, MpmPointWork *work);
/* The change of a point's weights and gradients with its place and F, into work->slope. */
PetscErrorCode MpmPointWeightsAlong(const MpmStepMap *map, const MpmGroup *group, PetscInt p,
                                    const MpmPointVector *start, MpmPointWork *work);
/* ds' of a point, from the kernel's answer. */
void MpmPointEndAlong(const MpmStepMap *map, PetscInt p, const MpmStepDirection *direction, const MpmPointWork *work,
                      MpmPointVector *end);
/* The mean over a point's cell as dL takes it: its share w, dL/dm_bar, and the sums of its flux f and of w dm . K. */
typedef struct {
  PetscReal share, by_mean, flux, along;
} MpmMeanPull;
/* Data of derivatives of L by one point, beside K, which is the work's other input. */
typedef struct {
  const MpmPointVector *end;  /* bars */
  const MpmMeanPull    *mean; /* NULL: the physics has none */
} MpmPointPull;
/* dL/dH; and that by F_n, history and parameters through the kernel, added. */
PetscErrorCode MpmPointPullInputs(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                                  const MpmPointPull *pull, PetscReal by_input[], MpmPointWork *work);
PetscErrorCode MpmPointPullKernel(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                                  const MpmPointPull *pull, MpmPointVector *start, PetscReal gradient[],
                                  MpmPointWork *work);
/* The change of a point's part of L by the kernel's answer, in the direction of the last derivative. */
PetscReal MpmPointContract(const MpmStepMap *map, PetscInt p, const MpmPointVector *end, const MpmPointWork *work);
/*
  dL by a point's place and F through its weights, added to `start`: by_input are dL/dH, and the kernel's fluxes, with
  the mean's contribution, stand in work->flux.
*/
PetscErrorCode MpmPointPullWeights(const MpmStepMap *map, const MpmGroup *group, PetscInt p, const MpmPointVector *end,
                                   const PetscReal by_input[], MpmPointVector *start, MpmPointWork *work);

/* The physics with a mean over the cell (cells_map.c), as MpmPointsAlong() and the others. */
PetscErrorCode MpmCellsAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[],
                             MpmPointVector *end);
PetscErrorCode MpmCellsPullSolution(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                    PetscReal u[]);
PetscErrorCode MpmCellsPullStart(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                 MpmPointVector *start, PetscReal gradient[]);
/* Likewise where means are by shares of the points' domains (spread_map.c). */
PetscErrorCode MpmSpreadAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[],
                              MpmPointVector *end);
PetscErrorCode MpmSpreadPullSolution(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                     PetscReal u[]);
PetscErrorCode MpmSpreadPullStart(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                  MpmPointVector *start, PetscReal gradient[]);
