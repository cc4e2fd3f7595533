#pragma once
/*
  Tasks that follow a run's steps, with runs of changed scenes beside it.
*/
#include "talus/talus.h"

/* Derivatives of a run whose steps have been recorded, by whatever methods its scene has (differentiate.c); fails the
   run's outcome where there is none. Collective. */
PetscErrorCode MpmDifferentiate(MpmModel model);
/* Derivatives of the state from which steps start, where it depends on parameters (start_slopes.c). */
PetscErrorCode MpmGradientFindStart(MpmModel model);
/* Those that have no closed form, by twins (twins.c). */
PetscErrorCode MpmTwinsFind(MpmModel model);
/* Of the task check_gradient: derivatives against those of changed runs (gradient_check.c); fails the run's outcome. */
PetscErrorCode MpmGradientCheck(MpmModel model);
/* Its second part: rates of Taylor's remainders along random directions of all numbers (taylor.c). Collective. */
PetscErrorCode MpmTaylorCheck(MpmModel model);
/* The task inverse (run.c): the scene itself is not run, but others of it; `status` of the program. */
PetscErrorCode MpmInverseRun(MpmModel model, int *status);
/* Derivatives by fields, into files of their own and the summary; nothing where there are none. Collective. */
PetscErrorCode MpmGroundResultsWrite(MpmModel model);
