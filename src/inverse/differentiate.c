/*
  Derivatives of a run, by the methods that its scene has.
*/
#include "query/model.h"
#include "sensitivity/gradient.h"
#include "inverse/inverse.h"

PetscErrorCode MpmDifferentiate(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(MpmGradientFindStart(model));
  if (!model->caller.outcome.code) PetscCall(MpmGradientFind(model));
  if (!model->caller.outcome.code) PetscCall(MpmTwinsFind(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}
