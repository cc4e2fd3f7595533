#pragma once
/*
  Dynamic relaxation: explicit steps that come to rest (relaxation.c).
*/
#include "options/options.h"
#include "query/scene.h"
#include "talus/talus.h"

/* As a stage begins. */
void MpmRelaxationBegin(MpmModel model);
/* Nothing relaxes in the step that comes: its columns are 0. */
void MpmRelaxationForget(MpmModel model);
/* True where a stage of that type could go on instead of the failing quasi-static one. */
PetscBool MpmCouldRelax(const MpmModel model);
/*
  Within an explicit step. Damp: compares the forces at the local nodes, `force`, with the loads, `load` (this rank's
  share, which becomes the whole), and adds damping. Observe: the points have their new velocities; past a peak of their
  energy they are stopped. Finish: the loads' work in the displacements model->disc.nodal.u; where the criteria are met
  the stage ends.
*/
PetscErrorCode MpmRelaxationDamp(MpmModel model, PetscReal load[], PetscReal force[]);
PetscErrorCode MpmRelaxationObserve(MpmModel model, PetscBool *stopped);
PetscErrorCode MpmRelaxationFinish(MpmModel model, const PetscReal load[]);
/* Rows of the state (base/rows.h). */
PetscErrorCode MpmRelaxationAddRows(MpmModel model);
/* Columns of the criteria, where a stage relaxes. */
PetscErrorCode MpmRelaxationAddColumns(MpmModel model, MpmColumns *columns);
/* After a step. Failure: the stage's time is over and nothing is at rest. */
PetscErrorCode MpmRelaxationOver(MpmModel model, MpmOutcome *outcome);
