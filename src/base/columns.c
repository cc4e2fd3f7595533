/*
  The register of a table's columns: names and values come from the same rows.
*/
#include <string.h>
#include "base/columns.h"

const char *const MpmAxisParts[MPM_MAX_DIM] = {"x", "y", "z"};

/* Columns of a row. */
static PetscInt Width(const MpmColumn *row)
{
  return row->count ? row->count : 1;
}

PetscErrorCode MpmColumnsAdd(MpmColumns *columns, const char of[], const MpmColumn *row)
{
  const PetscInt width = Width(row);

  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(columns->count + 1) * sizeof(*columns->at), &columns->at));
  PetscCall(PetscRealloc((size_t)(columns->name_count + width) * sizeof(*columns->names), &columns->names));
  columns->at[columns->count++] = *row;
  for (PetscInt k = 0; k < width; k++) {
    const char *words[] = {row->name, of, row->count ? row->parts[k] : NULL};
    char       *name    = NULL;

    for (size_t w = 0; w < PETSC_STATIC_ARRAY_LENGTH(words); w++)
      if (words[w]) PetscCall(MpmTextAppend(&name, "%s%s", name ? "_" : "", words[w]));
    columns->names[columns->name_count++] = name;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmColumnsHave(const MpmColumns *columns, const char name[])
{
  for (PetscInt k = 0; k < columns->name_count; k++)
    if (!strcmp(columns->names[k], name)) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscErrorCode MpmColumnsFill(const MpmColumns *columns, MpmModel model, PetscReal values[])
{
  PetscFunctionBeginUser;
  for (PetscInt r = 0; r < columns->count; r++) {
    PetscCall((*columns->at[r].fill)(model, &columns->at[r], values));
    values += Width(&columns->at[r]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmColumnsDestroy(MpmColumns *columns)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < columns->name_count; k++) PetscCall(PetscFree(columns->names[k]));
  PetscCall(PetscFree(columns->names));
  PetscCall(PetscFree(columns->at));
  columns->count = columns->name_count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
