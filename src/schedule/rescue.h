#pragma once
/*
  A relaxation in place of a quasi-static step that gave up (rescue.c).
*/
#include "base/types.h"
#include "talus/talus.h"

/* Rows of the state (base/rows.h). */
PetscErrorCode MpmRescueAddRows(MpmModel model);
/* True where the stage under way has a rescue, and its integrator allows one. */
PetscBool MpmRescueServes(const MpmModel model);
/* Begins one, to the end of a whole step of the stage; `why`: reason of the step's failure. */
PetscErrorCode MpmRescueBegin(MpmModel model, const char *why);
/* The run's time after the next step of the motion, whose length is state.dt.wanted. */
PetscErrorCode MpmRescueNextTime(MpmModel model, PetscReal *time);
/*
  After one of its steps. At rest: the quasi-static step of length `dt` is done, and the next one may begin; no longer
  state.scheme.rescuing.on. Failure: not at rest within the allowed steps.
*/
PetscErrorCode MpmRescueOver(MpmModel model, PetscReal *dt, MpmOutcome *outcome);
/* For a run that goes on within one. */
void MpmRescueResume(MpmModel model);
