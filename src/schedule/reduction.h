#pragma once
/*
  Strength reduction (strength_reduction.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* Rows of the state (base/rows.h). */
PetscErrorCode MpmReductionAddRows(MpmModel model);
/* Its column of the history, where a stage reduces. */
PetscErrorCode MpmReductionAddColumns(MpmModel model, MpmColumns *columns);
/* Once the points are there: refuses materials without strength beyond half of the mass of a stage that reduces. */
PetscErrorCode MpmReductionCheck(MpmModel model);
/*
  Strength reduction (strength_reduction.c): Begin notes where the points stand as it
  begins, Apply sets the materials' strengths for a time of the stage under way, Observe looks after a step whether the
  factor of safety is reached.
*/
PetscErrorCode MpmReductionBegin(MpmModel model);
PetscErrorCode MpmReductionApply(MpmModel model, PetscReal time);
/* Own parameters of all points, of materials that vary, at the reduction in force. */
PetscErrorCode MpmModelSetOwn(MpmModel model);
PetscErrorCode MpmReductionObserve(MpmModel model);
/*
  The bracket, in steps without inertia to `next`, which raise the sought factor. Look: a solution beyond the limit is
  refused. After a failed step: a shorter one is tried where possible. Close: the factor is known, and the stage ends in
  the state that stood, or goes on; or the failure of the solver has the lower bound.
*/
PetscBool      MpmReductionBrackets(const MpmModel model, PetscReal next);
PetscErrorCode MpmReductionLook(MpmModel model, PetscReal next, MpmOutcome *outcome);
PetscBool      MpmReductionNarrows(MpmModel model, PetscReal next);
PetscErrorCode MpmReductionClose(MpmModel model, PetscReal next, MpmOutcome *outcome);
/* The points' fields for it, one an axis. */
extern const char *const MpmReductionFields[MPM_MAX_DIM];
