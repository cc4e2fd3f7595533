/*
  The run of a model: its steps, derivatives by the task, and the summary.
*/
#include "base/outcome.h"
#include "io/io.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "model/build.h"
#include "inverse/inverse.h"

/* Derivatives of the steps that have been taken. */
static PetscErrorCode Differentiate(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(MpmGradientFindStart(model));
  if (!model->caller.outcome.code) PetscCall(MpmGradientFind(model));
  PetscCall(MpmGradientCheck(model));
  if (model->caller.outcome.code) PetscCall(MpmTerminalWarn(model, "%s", model->caller.outcome.text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(MpmModel model)
{
  PetscBool interrupted; /* by a signal */

  PetscFunctionBeginUser;
  PetscCall(MpmModelRunSteps(model, &interrupted));
  if (!interrupted && !model->caller.outcome.code) PetscCall(Differentiate(model));
  PetscCall(MpmModelRunEnd(model, interrupted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelRun(MpmModel model, int *status)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelSetUp(model));
  PetscCheck(!model->results->history, model->comm, PETSC_ERR_ARG_WRONGSTATE, "the model has been run");
  PetscCall(MpmFolderMake(model->comm, model->scene.name.prefix));
  MpmModelCall(model, Run(model));
  *status = model->caller.outcome.code ? MPM_EXIT_GAVEUP : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
