#pragma once
/*
  What a step of two stages keeps (sdirk.c), and the error in time that follows from them (time_error.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

#define MPM_SDIRK_GAMMA (1. - PETSC_SQRT2 / 2.)

/* The step that is tried, and what its first stage found at the points. */
struct MpmSdirk {
  PetscReal       time, dt; /* of the step's end, and the whole of its length, s */
  PetscReal      *F, *value, *deviation;
  MpmKernelStage *stage;    /* of each point, pointing to those */
  PetscReal      *reaction; /* of the first stage, as MpmDiscretization's */
  PetscReal       change;   /* what errors are relative to, should the step be accepted */
};
/* What the integrator of two stages keeps (sdirk.c). */
PetscErrorCode MpmSdirkDestroy(MpmSdirk **sdirk);
