#pragma once
/*
  Parts of a step that its integrators share (quasistatic.c), beside MpmStepPrepare().
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  Space, conditions and loads of a step, as MpmStepPrepare() has them: without a solver and a start for it. Where the integrator
  is explicit it adds gravity's own force, by the masses of the nodes.
*/
PetscErrorCode MpmStepBegin(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why);
/* Would the displacement model->disc.u carry a point out of the grid? `why` then names the first one of the lowest rank. */
PetscErrorCode MpmStepFindLost(MpmModel model, const char **why);
/* Points that rounding has taken over the grid's edges are put onto them. */
void MpmStepClip(MpmModel model);
/* The trial and the residual, along the axes, of what Newton has found. */
PetscErrorCode MpmStepFindTrial(MpmModel model);
/*
  Adds the part of the loads that makes those of a step to `time`, which count `part` times as they were at its start, their mean
  over the step.
*/
PetscErrorCode MpmStepMeanLoads(MpmModel model, PetscReal time, PetscReal part, PetscReal force[]);
/* What prescribed unknowns have at a time: of the first or second derivative by time, at the local unknowns, 0 at others. */
PetscErrorCode MpmStepPrescribedRate(MpmModel model, PetscReal time, PetscInt rate, PetscReal values[]);
/* From that residual, what conditions and motions exert: model->disc.reaction. */
PetscErrorCode MpmStepFindReactions(MpmModel model);
/* The residual at the step's start, before any prediction: what Newton's tolerance refers to. */
PetscErrorCode MpmStepFindReference(MpmModel model);
/* May points leave the grid in the stage under way? Then those that have are taken away after a step. */
PetscBool      MpmStepMayLeave(const MpmModel model);
PetscErrorCode MpmStepRemoveGone(MpmModel model);
