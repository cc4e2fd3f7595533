/*
  Files of a field's values.

    CSV     columns: the parameter's name or `value`; x, y (, z) of places, or i, j (, k) of cells, from 0 on; id of
            points. Values by body or region have two columns: a name, and the value
    HDF5    datasets of these names; `position` holds the places, a row each
*/
#include "files/csv_table.h"
#include "files/hdf5_rows.h"
#include "ground/ground.h"

static const char *const axes[] = {"x", "y", "z"}, *const numbers[] = {"i", "j", "k"};

/* Columns of a table side by side; NULL where any of them is not there. */
static PetscErrorCode TakeColumns(const MpmCsvTable *table, PetscInt count, const char *const names[],
                                  PetscReal **values)
{
  PetscInt column[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  *values = NULL;
  for (PetscInt a = 0; a < count; a++) {
    column[a] = MpmCsvTableFind(table, names[a]);
    if (column[a] < 0) PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1((size_t)(table->rows * count + 1), values));
  for (PetscInt64 k = 0; k < table->rows; k++)
    for (PetscInt a = 0; a < count; a++) (*values)[k * count + a] = table->value[k * table->columns + column[a]];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadCsv(const char path[], const char parameter[], PetscInt dim, MpmGroundTable *table,
                              char message[MPM_GROUND_MESSAGE])
{
  const char *const value[] = {"value"}, *const id[] = {"id"};
  MpmCsvTable file = {0};

  PetscFunctionBeginUser;
  PetscCall(MpmCsvTableRead(path, &file, message));
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  table->rows = (PetscInt)file.rows;
  PetscCall(TakeColumns(&file, 1, &parameter, &table->value));
  if (!table->value) PetscCall(TakeColumns(&file, 1, value, &table->value));
  PetscCall(TakeColumns(&file, dim, axes, &table->at));
  PetscCall(TakeColumns(&file, dim, numbers, &table->cell));
  PetscCall(TakeColumns(&file, 1, id, &table->id));
  if (!table->value) {
    PetscCall(PetscSNPrintf(message, MPM_GROUND_MESSAGE, "must have a column %s or value", parameter));
    PetscCall(MpmCsvTableNames(&file, message));
  }
  PetscCall(MpmCsvTableDestroy(&file));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All numbers of a dataset, NULL where there is none of that name; *count is how many. */
static PetscErrorCode TakeDataset(hid_t file, const char name[], PetscInt64 *count, PetscReal **values)
{
  PetscInt64 extent[2];

  PetscFunctionBeginUser;
  *values = NULL;
  *count  = 0;
  MpmHdf5Extent(file, name, extent);
  if (extent[0] <= 0 || extent[1] <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  *count = extent[0] * extent[1];
  PetscCall(PetscMalloc1((size_t)*count, values));
  if (!MpmHdf5ReadRows(file, name, MpmHdf5Real(), 0, extent[0], (PetscInt)extent[1], *values)) {
    PetscCall(PetscFree(*values));
    *count = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadHdf5(const char path[], const char parameter[], PetscInt dim, MpmGroundTable *table,
                               char message[MPM_GROUND_MESSAGE])
{
  const hid_t file = MpmHdf5Open(path);
  PetscInt64  rows, places, ids;

  PetscFunctionBeginUser;
  if (file < 0) {
    PetscCall(PetscSNPrintf(message, MPM_GROUND_MESSAGE, "cannot be read as HDF5"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(TakeDataset(file, parameter, &rows, &table->value));
  if (!table->value) PetscCall(TakeDataset(file, "value", &rows, &table->value));
  PetscCall(TakeDataset(file, "position", &places, &table->at));
  PetscCall(TakeDataset(file, "id", &ids, &table->id));
  (void)H5Fclose(file);
  table->rows = (PetscInt)rows;
  if (!table->value)
    PetscCall(PetscSNPrintf(message, MPM_GROUND_MESSAGE, "must have a dataset %s or value", parameter));
  else if (table->at && places != rows * dim)
    PetscCall(PetscSNPrintf(message, MPM_GROUND_MESSAGE,
                            "the dataset position must have %" PetscInt_FMT " numbers for each value", dim));
  else if (table->id && ids != rows) PetscCall(PetscSNPrintf(message, MPM_GROUND_MESSAGE, "must have an id a value"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A line "name,value" behind the first; false where it is none. */
static PetscErrorCode TakeNamed(const char line[], MpmGroundTable *table, PetscBool *good)
{
  PetscInt count;
  char   **words;

  PetscFunctionBeginUser;
  PetscCall(MpmTextSplit(line, &count, &words));
  *good = (PetscBool)(count == 2 && words[0] && MpmParseReal(words[1], &table->value[table->rows]));
  if (*good) PetscCall(PetscStrallocpy(words[0], &table->names[table->rows++]));
  PetscCall(MpmNamesDestroy(count, &words));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadNamed(const char path[], MpmGroundTable *table, char message[MPM_GROUND_MESSAGE])
{
  char     *text  = NULL, *next;
  PetscInt  lines = 0, line = 0, head = 0;
  PetscBool good = PETSC_TRUE;

  PetscFunctionBeginUser;
  PetscCall(MpmTextRead(path, &text, message));
  if (message[0]) PetscFunctionReturn(PETSC_SUCCESS);
  for (const char *c = text; *c; c++) lines += *c == '\n';
  PetscCall(PetscCalloc1((size_t)lines + 1, &table->names));
  PetscCall(PetscCalloc1((size_t)lines + 1, &table->value));
  for (char *begin = text; begin && good; begin = next) {
    next = strchr(begin, '\n');
    if (next) *next++ = '\0';
    line++;
    if (!begin[strspn(begin, " \t\r")] || begin[0] == '#') continue;
    if (head++) PetscCall(TakeNamed(begin, table, &good));
    if (!good) PetscCall(PetscSNPrintf(message, MPM_GROUND_MESSAGE, "line %d: must be a name and a number", (int)line));
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGroundTableRead(const char path[], const char parameter[], PetscInt dim, PetscBool named,
                                  MpmGroundTable *table, char message[MPM_GROUND_MESSAGE])
{
  const char *dot = strrchr(path, '.');

  PetscFunctionBeginUser;
  if (named) PetscCall(ReadNamed(path, table, message));
  else if (dot && (!strcmp(dot, ".h5") || !strcmp(dot, ".hdf5")))
    PetscCall(ReadHdf5(path, parameter, dim, table, message));
  else PetscCall(ReadCsv(path, parameter, dim, table, message));
  if (!message[0] && !table->rows) PetscCall(PetscSNPrintf(message, MPM_GROUND_MESSAGE, "has no values"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGroundTableDestroy(MpmGroundTable *table)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(table->value));
  PetscCall(PetscFree(table->at));
  PetscCall(PetscFree(table->cell));
  PetscCall(PetscFree(table->id));
  PetscCall(MpmNamesDestroy(table->rows, &table->names));
  PetscFunctionReturn(PETSC_SUCCESS);
}
