#pragma once
/*
  The laboratory: a scene of one material point, without grid and bodies (physics: stress_point).

  Order of calls of the model: Read, SetUp, Step or RunSteps, Destroy. A model has a laboratory where the scene has
  that physics.
*/
#include "base/types.h"
#include "talus/talus.h"

typedef struct MpmLaboratory MpmLaboratory;

/* The options of a stress point, besides those of any scene: dim, title, output. */
PetscErrorCode MpmLaboratoryRead(MpmModel model, const MpmOptions *options, PetscInt dim);
/* Its derivatives: MpmGradientRead() of such a scene. */
PetscErrorCode MpmLaboratoryReadGradient(MpmModel model, const MpmOptions *options);
/* Options of the laboratory for a manual that is of no particular scene. */
PetscErrorCode MpmLaboratoryPrintHelp(MpmModel model, const MpmOptions *options);
/* Brings the point to the stress at the start. */
PetscErrorCode MpmLaboratorySetUp(MpmModel model);
/* A step of the length that the model's caller wants, or to the end of the scene's own; and one that fails is cut. */
PetscErrorCode MpmLaboratoryStep(MpmModel model);
PetscBool      MpmLaboratoryIsAtEnd(const MpmModel model);
/* All steps with their history. */
PetscErrorCode MpmLaboratoryRunSteps(MpmModel model, PetscBool *interrupted);
PetscErrorCode MpmLaboratoryDestroy(MpmLaboratory **laboratory);
