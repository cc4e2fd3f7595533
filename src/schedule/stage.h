#pragma once
/*
  Stages (stage.c): bodies that come and go, materials that change.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

PetscErrorCode MpmStagesDestroy(MpmModel model);
/* The column of the stage's number, where the scene has stages. */
PetscErrorCode MpmStagesAddColumns(MpmModel model, MpmColumns *columns);
/* Once the points are there: finds those that carry loads, and puts those aside that later stages add. */
PetscErrorCode MpmStagesSelect(MpmModel model);
/*
  Bodies that go by a ramp (removal.c): Begin starts it for one, false where it goes at once; Set applies the parts at a
  time, and fails where points are lost; Commit after a step that was accepted; Resume for a run
  that goes on.
*/
PetscBool      MpmRemovalBegin(MpmModel model, const MpmStage *stage, PetscInt body);
PetscErrorCode MpmRemovalSet(MpmModel model, PetscReal time, MpmOutcome *outcome);
PetscErrorCode MpmRemovalCommit(MpmModel model);
void           MpmRemovalResume(MpmModel model);
/* Points of columns that come in later (inflow.c): true where the scene has any; their number in the state, once bodies
   have been read; aside once all points are there; in at the start of a step, when their time has come. */
PetscBool      MpmInflowHas(const MpmModel model);
PetscErrorCode MpmInflowRead(MpmModel model);
PetscErrorCode MpmInflowPark(MpmModel model);
PetscErrorCode MpmInflowEnter(MpmModel model, MpmOutcome *outcome);
PetscErrorCode MpmInflowDestroy(MpmModel model);
/* Closes the gap beneath a body that joins, or refuses the body (fill_gap.c). Its points are there. Collective. */
PetscErrorCode MpmGapClose(MpmModel model, PetscInt body, const char stage[]);
/* Materials of a stage's bodies from here on: stress, mass and shape stay (change_material.c). */
PetscErrorCode MpmMaterialsChange(MpmModel model, const MpmStage *stage);
/* Makes a stage the one under way: bodies, materials, conditions, loads, time. */
PetscErrorCode MpmStageBegin(MpmModel model, PetscInt stage);
/*
  Tasks of the integrator at the end of a stage, before the next one begins or the run ends (step_control.c). Not in a
  run's checkpoints: should the stage end later than planned, it goes on without them.
*/
PetscErrorCode MpmStageFinish(MpmModel model, MpmOutcome *outcome);
PetscBool      MpmStageHasFinish(const MpmModel model);
/* For a run that goes on in the stage of its state: time control, active conditions; the points are as they were. */
PetscErrorCode MpmStageResume(MpmModel model);
