#pragma once
/*
  Runs of a scene with one parameter changed, beside the model's own run.
*/
#include "base/base.h"
#include "base/types.h"
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
/* Likewise all parameters at values. */
PetscErrorCode MpmTwinRunAll(MpmModel model, const PetscReal value[], MpmTwin *twin);
/* Likewise a field, changed by a part of the tangent run's direction d (MpmGroundDirectionsCreate). */
PetscErrorCode MpmTwinRunField(MpmModel model, PetscInt d, PetscReal part, MpmTwin *twin);
PetscErrorCode MpmTwinDestroy(MpmTwin *twin);
/* Sets the option of a field's values, in the database in force. */
PetscErrorCode MpmFieldSetValues(const MpmGround *ground, const PetscReal value[]);
