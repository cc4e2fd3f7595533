#pragma once
/*
  Checkpoints: times and contents (checkpoint.c), and runs that go on from one (restart.c).
*/
#include "base/types.h"
#include "options/database.h"
#include "io/io.h"
#include "query/model.h"
#include "observe/results.h"

PetscErrorCode MpmCheckpointSetFromOptions(MpmModel model, const MpmOptions *options);
/* Text of all options that define the scene and must not change when a run goes on, a line each; or of given ones. */
PetscErrorCode MpmCheckpointScene(MpmModel model, PetscBool given, MpmTextFile *scene);
/* Keeps the options that continue the run, before presets have added theirs. */
PetscErrorCode MpmCheckpointKeepOptions(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmCheckpointWrite(MpmModel model);
/* To be called after each step: writes due files; `stop`: a signal requests the end of the run. */
PetscErrorCode MpmCheckpointStep(MpmModel model, PetscBool *stop);
PetscErrorCode MpmCheckpointDestroy(MpmCheckpoint *checkpoint);

/*
  Restarting, in this order: Open finds the checkpoint and checks it against the scene, ReadPoints fills the particles
  in place of the bodies, Apply sets the model's numbers once the solver is chosen, Results takes up the result files.
*/
PetscErrorCode MpmRestartOpen(MpmModel model);
PetscErrorCode MpmRestartReadPoints(MpmModel model);
PetscErrorCode MpmRestartApply(MpmModel model);
/* Without `apply` it only looks whether the file can be continued. */
PetscErrorCode MpmRestartOutput(MpmModel model, PetscBool apply);
PetscErrorCode MpmRestartDestroy(MpmRestart *restart);
