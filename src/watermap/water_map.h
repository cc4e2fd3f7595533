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
