/*
  Versions of vectors.
*/
#include <petsc/private/petscimpl.h> /* PetscObjectStateGet() */
#include "base/version.h"

PetscErrorCode MpmVersionGet(Vec u, MpmVersion *version)
{
  PetscFunctionBeginUser;
  PetscCall(PetscObjectGetId((PetscObject)u, &version->id));
  PetscCall(PetscObjectStateGet((PetscObject)u, &version->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmVersionIsSame(const MpmVersion *a, const MpmVersion *b)
{
  return (PetscBool)(a->id == b->id && a->state == b->state);
}
