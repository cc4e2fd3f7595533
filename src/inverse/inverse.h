#pragma once
/*
  Tasks that follow a run's steps, with runs of changed scenes beside it.
*/
#include "talus/talus.h"

/* Of the task check_gradient: derivatives against those of changed runs (gradient_check.c); fails the run's outcome. */
PetscErrorCode MpmGradientCheck(MpmModel model);
