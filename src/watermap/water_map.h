#pragma once
/*
  Parts of a step's derivatives that scenes with water have beside their points.
*/
#include "stepmap/step_map.h"

/*
  The change of the deviations at the step's start with the state there; and the transposed operation,
  added to `start`. Collective.
*/
PetscErrorCode MpmDeviationsAlong(const MpmStepMap *map, const MpmPointVector *start, PetscReal deviation[]);
PetscErrorCode MpmDeviationsPull(const MpmStepMap *map, const PetscReal deviation[], MpmPointVector *start);
/* Loads on surfaces and water that passes them (surfaces.c), likewise; along several directions. */
PetscErrorCode MpmSurfacesAlong(const MpmStepMap *map, const MpmStepDirections *directions);
PetscErrorCode MpmSurfacesPullSolution(const MpmStepMap *map, const PetscReal lam[], PetscReal u[]);
PetscErrorCode MpmSurfacesPullStart(const MpmStepMap *map, const PetscReal lam[], MpmPointVector *start,
                                    PetscReal gradient[]);
/* The weight of the water that points have taken up (weight.c), as loads (stepmap/step_map.h). */
PetscErrorCode MpmWaterWeightAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[]);
PetscErrorCode MpmWaterWeightPullSolution(const MpmStepMap *map, const PetscReal lam[], PetscReal u[]);
PetscErrorCode MpmWaterWeightPullStart(const MpmStepMap *map, const PetscReal lam[], MpmPointVector *start,
                                       PetscReal gradient[]);
