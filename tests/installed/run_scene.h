#pragma once
/*
  The run of a scene that the command line gives, with what `add` adds to the model.
*/
#include <talus/parts.h>

static PetscErrorCode RunScene(int argc, char **argv, PetscErrorCode (*add)(MpmModel model), int *status)
{
  MpmModel model;

  PetscFunctionBeginUser;
  PetscCall(MpmModelCreate(PETSC_COMM_WORLD, &model));
  for (int k = 1; k + 1 < argc; k += 2) {
    char option[2 * PETSC_MAX_PATH_LEN];

    PetscCall(PetscSNPrintf(option, sizeof(option), "%s %s", argv[k], argv[k + 1]));
    PetscCall(MpmModelSetOptions(model, option));
  }
  PetscCall((*add)(model));
  PetscCall(MpmModelSetFromOptions(model));
  PetscCall(MpmModelRun(model, status));
  PetscCall(MpmModelDestroy(&model));
  PetscFunctionReturn(PETSC_SUCCESS);
}
