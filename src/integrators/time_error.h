#pragma once
/*
  The error in time of a step (time_error.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* Rows of the state (base/rows.h). */
PetscErrorCode MpmTimeErrorAddRows(MpmModel model);
/*
  The error in time that chooses the steps (time_error.c): Begin notes the fields as a stage starts, Factor is the ratio
  of the next step's allowed length to that of the last one tried, by its estimate: infinity without error control.
*/
PetscErrorCode MpmTimeErrorBegin(MpmModel model);
PetscReal      MpmTimeErrorFactor(const MpmModel model);
/* A step's length that was chosen by it, rounded down by a thousandth at most, the same on any number of ranks. */
PetscReal MpmTimeErrorLength(const MpmModel model, PetscReal dt);
/* The points' field for it. */
extern const char *const MpmTimeErrorField;
/* The estimate of the error in time of the step that has been solved for, relative; see time_error.c. */
PetscErrorCode MpmTimeError(MpmModel model, PetscReal *estimate);
