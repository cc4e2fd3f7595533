/*
  The register of a run's numbers. A checkpoint of an earlier version without one of them leaves its value as it is.
*/
#include <string.h>
#include "base/rows.h"

PetscErrorCode MpmRowsAdd(MpmRows *rows, const char head[], PetscInt count, const MpmRow row[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(rows->count + count) * sizeof(*rows->at), &rows->at));
  for (PetscInt k = 0; k < count; k++) {
    char *name = NULL;

    PetscCall(MpmTextAppend(&name, "%s%s", head ? head : "", row[k].name));
    rows->at[rows->count]        = row[k];
    rows->at[rows->count++].name = name;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRowsDestroy(MpmRows **rows)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; *rows && k < (*rows)->count; k++) {
    char *name = (char *)(uintptr_t)(*rows)->at[k].name;

    PetscCall(PetscFree(name));
  }
  if (*rows) PetscCall(PetscFree((*rows)->at));
  PetscCall(PetscFree(*rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers of a row. */
static PetscInt Length(const MpmRow *row)
{
  return row->count ? row->count : 1;
}

PetscErrorCode MpmRowsSave(const MpmRows *rows, MpmRowValues *values)
{
  PetscInt count = 0, at = 0;

  PetscFunctionBeginUser;
  for (PetscInt r = 0; r < rows->count; r++) count += Length(&rows->at[r]);
  values->count = count;
  PetscCall(PetscCalloc5(count, &values->name, count, &values->real, count, &values->there, count, &values->value,
                         count, &values->number));
  for (PetscInt r = 0; r < rows->count; r++) {
    const MpmRow *row = &rows->at[r];

    for (PetscInt k = 0; k < Length(row); k++, at++) {
      if (row->count) PetscCall(MpmTextAppend(&values->name[at], "%s_%" PetscInt_FMT, row->name, row->first + k));
      else PetscCall(MpmTextAppend(&values->name[at], "%s", row->name));
      values->real[at]  = (PetscBool)(row->kind == MPM_ROW_REAL);
      values->there[at] = PETSC_TRUE;
      if (row->kind == MPM_ROW_REAL) values->value[at] = ((const PetscReal *)row->address)[k];
      if (row->kind == MPM_ROW_INT) values->number[at] = ((const PetscInt *)row->address)[k];
      if (row->kind == MPM_ROW_INT64) values->number[at] = ((const PetscInt64 *)row->address)[k];
      if (row->kind == MPM_ROW_BOOL) values->number[at] = ((const PetscBool *)row->address)[k];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRowsLoad(const MpmRows *rows, const MpmRowValues *values, const char begin[], PetscBool state)
{
  PetscInt at = 0;

  PetscFunctionBeginUser;
  for (PetscInt r = 0; r < rows->count; r++) {
    const MpmRow *row = &rows->at[r];

    for (PetscInt k = 0; k < Length(row); k++, at++) {
      if (!values->there[at] || strncmp(values->name[at], begin, strlen(begin))) continue;
      if (state && row->use != MPM_ROW_STATE) continue;
      if (row->kind == MPM_ROW_REAL) ((PetscReal *)row->address)[k] = values->value[at];
      if (row->kind == MPM_ROW_INT) ((PetscInt *)row->address)[k] = (PetscInt)values->number[at];
      if (row->kind == MPM_ROW_INT64) ((PetscInt64 *)row->address)[k] = values->number[at];
      if (row->kind == MPM_ROW_BOOL) ((PetscBool *)row->address)[k] = (PetscBool)values->number[at];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRowValuesDestroy(MpmRowValues *values)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < values->count; k++) PetscCall(PetscFree(values->name[k]));
  PetscCall(PetscFree5(values->name, values->real, values->there, values->value, values->number));
  values->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
