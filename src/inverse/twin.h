#pragma once
/*
  Runs of a scene with one parameter changed, beside the model's own run.
*/
#include "base/base.h"
#include "talus/talus.h"

#define MPM_TWIN_TEXT 512

/* Results of such a run. */
typedef struct {
  PetscReal *curves;             /* of the objectives, as the gradient's; NULL: it has not taken all steps */
  PetscReal  objective;          /* not a number without curves */
  PetscInt   apart;              /* first step with other decisions than the model's, from 1 on; 0: none */
  char       why[MPM_TWIN_TEXT]; /* reason for which it has not taken all steps */
} MpmTwin;

/*
  The run with parameter k at a value, over the times of the model's run, which leaves nothing but the numbers. The
  model's options are in force, and are those of the scene again in the end. Collective.
*/
PetscErrorCode MpmTwinRun(MpmModel model, PetscInt k, double value, MpmTwin *twin);
PetscErrorCode MpmTwinDestroy(MpmTwin *twin);
