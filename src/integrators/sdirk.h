#pragma once
/*
  Data of a step of two sub-steps (sdirk.c), and the error in time that follows from them (time_error.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

#define MPM_SDIRK_GAMMA (1. - PETSC_SQRT2 / 2.)
#define MPM_SDIRK_THETA ((1. - MPM_SDIRK_GAMMA) / MPM_SDIRK_GAMMA) /* share of the first stage's flow */

/* The step under trial, and the result of its first sub-step at the points. */
struct MpmSdirk {
  PetscReal       time, dt; /* of the step's end, and the whole of its length, s */
  PetscReal      *F, *value, *deviation;
  MpmKernelStage *stage;    /* of each point, pointing to those */
  PetscReal      *reaction; /* of the first stage, as MpmDiscretization's */
  PetscScalar    *first;    /* its solution, of this rank, where runs are differentiated */
  PetscReal       change;   /* reference of errors, if the step is accepted */
};
/* Data of the integrator of two sub-steps (sdirk.c). */
PetscErrorCode MpmSdirkDestroy(MpmSdirk **sdirk);
