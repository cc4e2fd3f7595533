/*
  The register of a table's columns: names and values come from the same rows.
*/
#include <string.h>
#include "base/columns.h"

const char *const MpmAxisParts[MPM_MAX_DIM] = {"x", "y", "z"};

PetscInt MpmColumnWidth(const MpmColumn *row)
{
  return row->count ? row->count : 1;
}

PetscErrorCode MpmColumnsAdd(MpmColumns *columns, const char of[], const MpmColumn *row)
{
  const PetscInt width = MpmColumnWidth(row);

  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(columns->count + 1) * sizeof(*columns->at), &columns->at));
  PetscCall(PetscRealloc((size_t)(columns->name_count + width) * sizeof(*columns->names), &columns->names));
  PetscCall(PetscRealloc((size_t)(columns->count + 1) * sizeof(*columns->map), &columns->map));
  columns->map[columns->count]  = NULL;
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

void MpmColumnsSetMap(MpmColumns *columns, const MpmColumnMap *map)
{
  columns->map[columns->count - 1] = map;
}

PetscInt MpmColumnsFind(const MpmColumns *columns, const char name[], PetscInt *part)
{
  for (PetscInt r = 0, first = 0; r < columns->count; r++) {
    for (PetscInt k = 0; k < MpmColumnWidth(&columns->at[r]); k++) {
      *part = k;
      if (!strcmp(columns->names[first + k], name)) return r;
    }
    first += MpmColumnWidth(&columns->at[r]);
  }
  return -1;
}

PetscErrorCode MpmColumnsFill(const MpmColumns *columns, MpmModel model, PetscReal values[])
{
  PetscFunctionBeginUser;
  for (PetscInt r = 0; r < columns->count; r++) {
    PetscCall((*columns->at[r].fill)(model, &columns->at[r], values));
    values += MpmColumnWidth(&columns->at[r]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmColumnsDestroy(MpmColumns *columns)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < columns->name_count; k++) PetscCall(PetscFree(columns->names[k]));
  PetscCall(PetscFree(columns->names));
  PetscCall(PetscFree(columns->map));
  PetscCall(PetscFree(columns->at));
  columns->count = columns->name_count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
