#pragma once
/*
  The laboratory: a scene of one material point, without grid and bodies (physics: stress_point).

  Order of calls of the model: Read, SetUp, Run, Destroy. A model has a laboratory where the scene has that physics.
*/
#include "base/types.h"
#include "talus/talus.h"

typedef struct MpmLaboratory MpmLaboratory;

/* The options of a stress point, besides those of any scene: dim, title, output. */
PetscErrorCode MpmLaboratoryRead(MpmModel model, const MpmOptions *options, PetscInt dim);
/* Options of the laboratory for a manual that is of no particular scene. */
PetscErrorCode MpmLaboratoryPrintHelp(MpmModel model, const MpmOptions *options);
/* Brings the point to the stress at the start. */
PetscErrorCode MpmLaboratorySetUp(MpmModel model);
/* The whole path, with its files; `status` as MpmModelRun(). */
PetscErrorCode MpmLaboratoryRun(MpmModel model, int *status);
PetscErrorCode MpmLaboratoryDestroy(MpmLaboratory **laboratory);
