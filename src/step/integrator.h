#pragma once
/*
  Functions of an integrator.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  A way to take a step. Until accept() the state is that of the step's start: roll_back() forgets the trial.

  begin      space, conditions and loads for a step to `time`, dt later; `again`: the points have not moved since the
             last call, the space stands; `outcome`: whether there is such a step
  predict    start of the solution
  solve      Newton's method, or its substitute; `outcome`: whether there is a solution
  accept     the trial becomes the state
  roll_back
  error      estimate of the step's error in time; NULL where there is none
  length     before `begin`: the longest step allowed, into state.dt.wanted; `outcome`: whether there is such a step.
             NULL: the step control chooses, and cuts failing steps
  second     of two stages: the second one begins, at the first one's solution; NULL: there is one stage
  finish     after a stage's last step, with the points in their places; NULL: nothing is left to do
*/
struct MpmIntegrator {
  const char *name;
  PetscErrorCode (*begin)(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome);
  PetscErrorCode (*predict)(MpmModel model);
  PetscErrorCode (*solve)(MpmModel model, MpmOutcome *outcome);
  PetscErrorCode (*accept)(MpmModel model);
  PetscErrorCode (*roll_back)(MpmModel model);
  PetscErrorCode (*error)(MpmModel model, PetscReal *estimate);
  PetscErrorCode (*length)(MpmModel model, MpmOutcome *outcome);
  PetscErrorCode (*second)(MpmModel model, MpmOutcome *outcome);
  PetscErrorCode (*finish)(MpmModel model);
};
