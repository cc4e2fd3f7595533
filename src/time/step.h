#pragma once
/*
  Parts of a step that its integrators share (quasistatic.c), beside MpmStepPrepare().
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* The trial and the residual, along the axes, of what Newton has found. */
PetscErrorCode MpmStepFindTrial(MpmModel model);
/* From that residual, what conditions and motions exert: model->disc.reaction. */
PetscErrorCode MpmStepFindReactions(MpmModel model);
/* The residual at the step's start, before any prediction: what Newton's tolerance refers to. */
PetscErrorCode MpmStepFindReference(MpmModel model);
