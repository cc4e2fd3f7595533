/*
  The register of the points' fields.
*/
#include <string.h>
#include "observe/point_columns.h"

PetscBool MpmPointColumnsHave(const MpmPointColumns *columns, const char name[])
{
  for (PetscInt k = 0; k < columns->count; k++)
    if (!strcmp(columns->at[k].name, name)) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmPointColumnsAdd(MpmPointColumns *columns, const MpmPointColumn *row)
{
  PetscFunctionBeginUser;
  if (MpmPointColumnsHave(columns, row->name)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscRealloc((size_t)(columns->count + 1) * sizeof(*columns->at), &columns->at));
  columns->at[columns->count++] = *row;
  PetscFunctionReturn(PETSC_SUCCESS);
}
