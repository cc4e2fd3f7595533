/*
  Boundaries whose surface is of a type from outside the tree (talus/contact.h): their parameters.
*/
#include "options/options.h"
#include "geometry/solid_types.h"
#include "point/parameter.h"
#include "rigid/added_body.h"

PetscErrorCode MpmAddedBodiesPrint(const MpmOptions *block)
{
  const MpmContactBodyType *type;
  char                      title[256];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; (type = MpmContactBodyTypeAt(k)); k++) {
    PetscCall(PetscSNPrintf(title, sizeof(title), "Boundary of type %s: %s", type->name, type->summary));
    PetscCall(MpmOptionsHeading(block, title));
    PetscCall(MpmParametersPrint(block, type->parameter_count, type->parameters));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAddedBodyRead(const MpmOptions *block, const char name[], MpmSolid *solid)
{
  MpmAddedBody *added = solid->added;

  PetscFunctionBeginUser;
  if (!added) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    MpmParametersRead(block, added->type->parameter_count, added->type->parameters, &added->parameter, &added->table));
  added->body = (MpmContactBody){block->comm, solid->dim, name, added->parameter, added->table, NULL};
  if (added->type->create) PetscCall(added->type->create(&added->body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAddedBodyDestroy(MpmSolid *solid)
{
  MpmAddedBody *added = solid->added;

  PetscFunctionBeginUser;
  if (!added) PetscFunctionReturn(PETSC_SUCCESS);
  if (added->body.ctx && added->type->destroy) PetscCall(added->type->destroy(&added->body));
  PetscCall(MpmTablesDestroy((size_t)added->type->parameter_count, &added->table));
  PetscCall(PetscFree(added->parameter));
  PetscCall(PetscFree(solid->added));
  PetscFunctionReturn(PETSC_SUCCESS);
}
