/*
  The discrete problem of a step: what of it stays from step to step, and its end.
*/
#include "terms/discretization.h"
#include "terms/sparsity.h"
#include "terms/terms.h"

PetscErrorCode MpmDiscretizationSetUp(MpmDiscretization *disc, const MpmMaterials *materials,
                                      const MpmBoundaries *boundaries, PetscInt state_size)
{
  PetscFunctionBeginUser;
  disc->material_count = materials->count;
  disc->sum            = (MpmSum){.grid       = &disc->grid,
                                  .space      = &disc->space,
                                  .layout     = &disc->layout,
                                  .materials  = materials->at,
                                  .points     = &disc->points,
                                  .state_size = state_size};
  PetscCall(MpmContactsCreate(boundaries->count, boundaries->at, &disc->contacts));
  PetscCall(MpmTermsAdd(&disc->terms, disc->layout.means ? &MpmTermCellMeans : &MpmTermPoints, NULL));
  PetscCall(MpmTermsAdd(&disc->terms, &MpmTermGhost, NULL));
  PetscCall(MpmTermsAdd(&disc->terms, &MpmTermContact, &disc->contacts));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTrialReset(MpmTrial *trial)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(trial->F, trial->stress, trial->state, trial->u));
  trial->made = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDiscretizationDestroy(MpmDiscretization *disc)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPatternDestroy(&disc->pattern));
  PetscCall(MpmSpaceReset(&disc->space));
  PetscCall(MpmConstraintsReset(&disc->constraints));
  PetscCall(PetscFree3(disc->u, disc->residual, disc->force));
  PetscCall(MpmTrialReset(&disc->trial));
  PetscCall(PetscFree(disc->reaction));
  PetscCall(MpmContactsDestroy(&disc->contacts));
  PetscCall(MpmTermsDestroy(&disc->terms));
  PetscFunctionReturn(PETSC_SUCCESS);
}
