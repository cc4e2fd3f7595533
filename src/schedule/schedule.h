#pragma once
/*
  How a run goes on from step to step (step_control.c, step_length.c), and whether it slides (slide.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  One step from model->time to `time`, dt later; `again`: the points have not moved since the last call, the space
  stands.
*/
PetscErrorCode MpmStep(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome);
/* Rows of the state (base/rows.h). */
PetscErrorCode MpmStepControlAddRows(MpmModel model);
/* The points' places and their ranks, for a step that begins there. */
PetscErrorCode MpmStepArrange(MpmModel model, MpmOutcome *outcome);
/* F-bar averages dilation, too, or no longer: fallback of a run where steps fail again and again. */
void MpmStepAverageDilation(MpmModel model, PetscBool average);
/* A time without the rounding errors of the sum that it is, where it is a decimal number but for them. */
PetscReal MpmTimeRound(PetscReal time);
/* The end of the step that starts now, and its length. */
PetscReal MpmNextTime(MpmModel model, PetscReal dt, PetscReal *step);
/*
  Length of the next step after one of `dt` where `wanted` was wanted: longer after an easy step; the same after a hard
  one, when adaptive; also where the error in time is small.
*/
PetscReal MpmNextLength(MpmModel model, PetscReal dt, PetscReal wanted);
/* One step, cut as often as needed; `dt` is its length (step_control.c). */
PetscErrorCode MpmAdvance(MpmModel model, PetscReal *dt, MpmOutcome *outcome);
/* Rows of the state (base/rows.h). */
PetscErrorCode MpmSlideAddRows(MpmModel model);
/*
  Loss of equilibrium (slide.c): Begin with a stage; Look at a solution to `next`, refused where it is suspected, and
  not `retryable` once shorter steps move as far; Observe after a step that was accepted; Suspects: true where one of
  the last steps was suspected; Explain adds the suspicion to the reason for which a run gives up.
*/
void           MpmSlideBegin(MpmModel model);
PetscErrorCode MpmSlideLook(MpmModel model, PetscReal next, MpmOutcome *outcome);
void           MpmSlideObserve(MpmModel model);
PetscBool      MpmSlideSuspects(const MpmModel model);
PetscErrorCode MpmSlideExplain(MpmModel model, MpmOutcome *outcome);
