/*
  The run of a model: its steps, derivatives by the task, and the summary.
*/
#include "base/outcome.h"
#include "io/io.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "model/build.h"
#include "members/members.h"
#include "inverse/inverse.h"

/* A line for the objective and each derivative. */
static PetscErrorCode Tell(MpmModel model)
{
  const MpmDerivatives *found = &model->results->derivatives;

  PetscFunctionBeginUser;
  if (!found->count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMonitorNote(&model->monitor, "objective %.10g", (double)found->objective));
  for (PetscInt k = 0; k < found->count; k++) {
    char error[64] = "";

    if (found->errors[k] > 0.)
      PetscCall(PetscSNPrintf(error, sizeof(error), ", to about %.1e", (double)found->errors[k]));
    PetscCall(
      MpmMonitorNote(&model->monitor, "derivative by %s: %.10g%s", found->names[k], (double)found->gradient[k], error));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses a number whose derivative in closed form is exactly 0, while the objective depends on its columns. */
static PetscErrorCode CheckDependence(const MpmModel model)
{
  const MpmGradient    *gradient = model->gradient;
  const MpmDerivatives *found    = &model->results->derivatives;
  PetscBool             weighs   = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (!gradient || gradient->kind || !gradient->weights) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < gradient->rows * gradient->objectives.count; i++)
    if (gradient->weights[i] != 0.) weighs = PETSC_TRUE;
  for (PetscInt k = 0; weighs && k < found->count; k++)
    MpmCheckInput(!MpmGradientIsClosed(gradient, k) || found->gradient[k] != 0.,
                  "-mpm_parameters %s: no result depends on it", found->names[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivatives, and what the task compares them with. */
static PetscErrorCode Derive(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(MpmDifferentiate(model));
  if (!model->caller.outcome.code) PetscCall(CheckDependence(model));
  if (!model->caller.outcome.code) PetscCall(Tell(model));
  if (!model->caller.outcome.code) PetscCall(MpmGroundResultsWrite(model));
  if (!model->caller.outcome.code) PetscCall(MpmGradientCheck(model));
  if (model->caller.outcome.code) PetscCall(MpmTerminalWarn(model, "%s", model->caller.outcome.text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(MpmModel model)
{
  PetscBool interrupted; /* by a signal */

  PetscFunctionBeginUser;
  PetscCall(MpmModelRunSteps(model, &interrupted));
  if (!interrupted && !model->caller.outcome.code) PetscCall(Derive(model));
  PetscCall(MpmModelRunEnd(model, interrupted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelRun(MpmModel model, int *status)
{
  PetscFunctionBeginUser;
  if (model->ensemble) {
    MpmModelCall(model, MpmEnsembleRun(model, status));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (model->gradient && model->gradient->inverse.on) PetscFunctionReturn(MpmInverseRun(model, status));
  PetscCall(MpmModelSetUp(model));
  PetscCheck(!model->results->history, model->comm, PETSC_ERR_ARG_WRONGSTATE, "the model has been run");
  PetscCall(MpmFolderMake(model->comm, model->scene.name.prefix));
  MpmModelCall(model, Run(model));
  *status = model->caller.outcome.code ? MPM_EXIT_GAVEUP : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
