#pragma once
/*
  Tasks that follow a run's steps, with runs of changed scenes beside it.
*/
#include "sensitivity/parameters.h"
#include "talus/talus.h"

/* Derivatives of a run whose steps have been recorded, by the method of its gradient (differentiate.c). Collective. */
PetscErrorCode MpmDifferentiate(MpmModel model);
/* Derivatives of the state from which steps start, where it depends on parameters (start_slopes.c). */
PetscErrorCode MpmGradientFindStart(MpmModel model);
/* The option of a parameter becomes so many times its value, from which a model may then be made. */
PetscErrorCode MpmParameterSet(MpmModel model, const MpmSceneParameter *parameter, PetscReal factor);
/* Of the task check_gradient: derivatives against those of changed runs (gradient_check.c); fails the run's outcome. */
PetscErrorCode MpmGradientCheck(MpmModel model);
/* The task inverse (run.c): the scene itself is not run, but others of it; `status` of the program. */
PetscErrorCode MpmInverseRun(MpmModel model, int *status);
