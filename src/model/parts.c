/*
  Columns of the history, fields of the points and numbers of the checkpoints that the library's caller adds.
*/
#include <string.h>
#include "base/columns.h"
#include "base/rows.h"
#include "query/model.h"
#include "observe/results.h"
#include "model/build.h"

#define HEAD "user_" /* head of the names in checkpoints: no row of the engine has it */

/* Fails once the scene has been read. */
static PetscErrorCode CheckTime(const MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCheck(!MpmModelHasScene(model), model->comm, PETSC_ERR_ARG_WRONGSTATE, "the scene has been read");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelAddColumn(MpmModel model, const MpmColumn *column)
{
  PetscFunctionBeginUser;
  PetscCall(CheckTime(model));
  PetscCheck(column->fill && column->unit && (column->name || column->count), model->comm, PETSC_ERR_ARG_WRONG,
             "a column of the history needs a name, a unit and a function");
  PetscCall(MpmColumnsAdd(&model->results->added.columns, NULL, column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelAddPointColumn(MpmModel model, const MpmPointColumn *column)
{
  MpmPointColumns *fields = &model->results->added.fields;

  PetscFunctionBeginUser;
  PetscCall(CheckTime(model));
  PetscCheck(column->fill && column->name && column->components > 0, model->comm, PETSC_ERR_ARG_WRONG,
             "a field of the points needs a name, components and a function");
  PetscCheck(!MpmPointColumnsHave(fields, column->name), model->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "the field %s has been added", column->name);
  PetscCall(MpmPointColumnsAdd(fields, column));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelAddRow(MpmModel model, const MpmRow *row)
{
  const MpmRows *rows = model->state.rows;
  const size_t   head = strlen(HEAD);

  PetscFunctionBeginUser;
  PetscCall(CheckTime(model));
  PetscCheck(row->name && row->address, model->comm, PETSC_ERR_ARG_WRONG,
             "a number of the checkpoints needs a name and an address");
  for (PetscInt k = 0; k < rows->count; k++)
    PetscCheck(strncmp(rows->at[k].name, HEAD, head) || strcmp(rows->at[k].name + head, row->name), model->comm,
               PETSC_ERR_ARG_OUTOFRANGE, "the number %s has been added", row->name);
  PetscCall(MpmRowsAdd(model->state.rows, HEAD, 1, row));
  PetscFunctionReturn(PETSC_SUCCESS);
}
