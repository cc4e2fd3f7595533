#pragma once
/*
  The ways to take a step.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  How a step is taken. Until accept() the state is that of the step's start: roll_back() forgets what was tried.

  begin      space, conditions and loads for a step to `time`, dt later; `again`: the points have not moved since the last
             call, the space stands; `why` is NULL, or the reason for which there is no such step
  predict    where the solution starts
  solve      `why` is NULL, or the reason of the failure; `retryable`: a shorter step may help
  accept     what was found becomes the state
  roll_back
  error      estimate of the step's error in time; NULL where there is none
*/
struct MpmIntegrator {
  const char *name;
  PetscErrorCode (*begin)(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why);
  PetscErrorCode (*predict)(MpmModel model);
  PetscErrorCode (*solve)(MpmModel model, const char **why, PetscBool *retryable);
  PetscErrorCode (*accept)(MpmModel model);
  PetscErrorCode (*roll_back)(MpmModel model);
  PetscErrorCode (*error)(MpmModel model, PetscReal *estimate);
};
extern const MpmIntegrator MpmIntegratorQuasistatic; /* quasistatic.c */
extern const MpmIntegrator MpmIntegratorSdirk;       /* sdirk.c: two stages */
extern const MpmIntegrator MpmIntegratorImplicit;    /* dynamics.c: with inertia */
