/*
  Materials by the rows of a table, -mpm_materials_file:

    name,type,E,nu,density
    grain1,neo_hookean,4000e6,0.25,2650

  A row is what the block material_<name> would be; a cell without a text is an option that is not given. The table's
  materials stand behind those of -mpm_materials. Options of the scene for them replace cells. PETSc's databases have
  room for 512 options until 3.18, and each search for one takes longer the more there are, so that a row is read from a
  database of its own.
*/
#include <string.h>
#include <strings.h>
#include "options/options.h"
#include "options/record.h"
#include "model/material_table.h"

#define FAULT(...) PetscFunctionReturn(PetscSNPrintf(message, MPM_CSV_MESSAGE, __VA_ARGS__))

static const char *Cell(const MpmMaterialTable *table, PetscInt row, PetscInt column)
{
  return table->csv.word[(PetscInt)table->csv.value[row * table->csv.columns + column]];
}

/* Faults of the table as a whole. */
static PetscErrorCode CheckTable(const MpmCsvTable *csv, PetscInt name, char message[MPM_CSV_MESSAGE])
{
  PetscFunctionBeginUser;
  if (name < 0 || MpmCsvTableFind(csv, "type") < 0) {
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "must have the columns name and type"));
    PetscCall(MpmCsvTableNames(csv, message));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!csv->rows) FAULT("has no rows");
  for (PetscInt c = 0; c < csv->columns; c++) {
    const char *key = csv->name[c];

    if (key[strspn(key, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_")])
      FAULT("column %.60s: must be a name of letters, digits and underscores", key);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names of the rows, behind those of the list: letters, digits and underscores, no two alike. */
static PetscErrorCode AddNames(const MpmOptions *options, const MpmMaterialTable *table, PetscInt *count, char ***names)
{
  const MpmOptions alone = {options->comm, options->prefix, NULL};
  MpmTextFile      text  = MPM_TEXT_FILE_EMPTY;
  PetscOptions     database;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < *count; m++) PetscCall(MpmTextFileAppend(&text, "%s%s", m ? "," : "", (*names)[m]));
  for (PetscInt row = 0; row < table->csv.rows; row++)
    PetscCall(MpmTextFileAppend(&text, "%s%s", row || *count ? "," : "", Cell(table, row, table->name)));
  PetscCall(MpmNamesDestroy(*count, names));
  PetscCall(PetscOptionsCreate(&database));
  PetscCall(PetscOptionsSetValue(database, "-mpm_materials", text.data));
  PetscCall(PetscOptionsPush(database));
  PetscCall(MpmOptionsNames(&alone, "materials", "", MPM_REQUIRED, count, names));
  PetscCall(PetscOptionsPop());
  PetscCall(PetscOptionsDestroy(&database));
  PetscCall(MpmTextFileDestroy(&text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialTableRead(const MpmOptions *options, PetscInt *count, char ***names, MpmMaterialTable *table)
{
  char        message[MPM_CSV_MESSAGE] = "";
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsPath(options, "materials_file",
                           "CSV file of materials, a row each behind those of materials: the columns name, type, and "
                           "the options of material blocks",
                           MPM_OPTIONAL, &table->path));
  PetscCall(MpmOptionsBlocks(options, "materials", "names of the material blocks",
                             table->path ? MPM_OPTIONAL : MPM_REQUIRED, count, names));
  table->first = *count;
  if (!table->path || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(options->comm, &rank));
  table->csv.of_words = "*";
  if (!rank) {
    PetscCall(MpmCsvTableRead(table->path, &table->csv, message));
    if (!message[0]) PetscCall(CheckTable(&table->csv, MpmCsvTableFind(&table->csv, "name"), message));
  }
  PetscCallMPI(MPI_Bcast(message, MPM_CSV_MESSAGE, MPI_CHAR, 0, options->comm));
  MpmCheckInput(!message[0], "-%smaterials_file %s: %s", options->prefix, table->path, message);
  PetscCall(MpmCsvTableShare(options->comm, &table->csv));
  table->name = MpmCsvTableFind(&table->csv, "name");
  PetscCall(AddNames(options, table, count, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True for an option of the scene for a material with this prefix. */
static PetscBool IsFor(const MpmDatabaseOption *given, const char prefix[])
{
  return (PetscBool)!strncasecmp(given->name, prefix, strlen(prefix));
}

static PetscErrorCode SetOption(PetscOptions database, const char prefix[], const char key[], const char value[])
{
  char *name = NULL;

  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(&name, "-%s%s", prefix, key));
  PetscCall(PetscOptionsSetValue(database, name, value));
  PetscCall(PetscFree(name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialTableEnter(const MpmOptions *options, const char name[], PetscInt m, MpmMaterialTable *table,
                                     const MpmOptions **read)
{
  const PetscInt row = m - table->first;
  char           prefix[256];

  PetscFunctionBeginUser;
  *read = options;
  if (row < 0 || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (!table->given_text) PetscCall(MpmDatabaseGet(&table->given_count, &table->given, &table->given_text));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_material_%s_", name));
  table->row     = row;
  table->options = (MpmOptions){options->comm, options->prefix, NULL};
  PetscCall(MpmRecordCreate(&table->options.record));
  if (MpmRecordPlane(options->record)) MpmRecordSetPlane(table->options.record, MpmRecordPlane(options->record));
  table->options.record->window[0] = options->record->window[0];
  table->options.record->window[1] = options->record->window[1];
  PetscCall(PetscOptionsCreate(&table->database));
  for (PetscInt c = 0; c < table->csv.columns; c++)
    if (c != table->name && Cell(table, row, c)[0])
      PetscCall(SetOption(table->database, prefix, table->csv.name[c], Cell(table, row, c)));
  for (PetscInt k = 0; k < table->given_count; k++)
    if (IsFor(&table->given[k], prefix))
      PetscCall(SetOption(table->database, "", table->given[k].name, table->given[k].value));
  PetscCall(PetscOptionsPush(table->database));
  *read = &table->options;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of the scene that have replaced cells are in force there. */
static PetscErrorCode KeepGiven(const MpmMaterialTable *table, const char prefix[], MpmRecord record)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < table->given_count; k++) {
    MpmRecordEntry *here, *there;
    const char     *value;
    PetscBool       given;

    if (!IsFor(&table->given[k], prefix)) continue;
    PetscCall(MpmRecordFind(table->options.record, table->given[k].name, &here));
    if (!here || !here->known) continue;
    PetscCall(MpmRecordGet(record, here->name, &there));
    PetscCall(PetscFree(there->value));
    there->known = there->given = PETSC_TRUE;
    there->numbers              = here->numbers;
    there->range                = here->range;
    PetscCall(PetscStrallocpy(here->value, &there->value));
    PetscCall(MpmDatabaseFind(here->name, &value, &given)); /* marks it as used */
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A cell that nobody has asked for ends the run, with the nearest known name of its block. */
static PetscErrorCode CheckCells(const MpmOptions *options, const MpmMaterialTable *table, const char prefix[])
{
  const MpmRecord record = table->options.record;
  const char     *nearest;
  PetscInt        count = 0;
  char          **known;

  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < table->csv.columns; c++) {
    MpmRecordEntry *entry;
    char           *name = NULL;

    if (c == table->name || !Cell(table, table->row, c)[0]) continue;
    PetscCall(MpmTextAppend(&name, "%s%s", prefix, table->csv.name[c]));
    PetscCall(MpmRecordFind(record, name, &entry));
    PetscCall(PetscFree(name));
    if (entry && entry->known) continue;
    PetscCall(PetscMalloc1(record->count + 1, &known));
    for (PetscInt k = 0; k < record->count; k++)
      if (record->entries[k].known && !strncmp(record->entries[k].name, prefix, strlen(prefix)))
        known[count++] = &record->entries[k].name[strlen(prefix)];
    nearest = MpmTextNearest(table->csv.name[c], count, known, 2);
    MpmCheckInput(PETSC_FALSE, "-%smaterials_file %s: material %s has no %s%s%s; cells of other materials stay empty",
                  options->prefix, table->path, Cell(table, table->row, table->name), table->csv.name[c],
                  nearest ? ", the nearest that is known is " : "", nearest ? nearest : "");
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialTableLeave(const MpmOptions *options, PetscErrorCode failed, MpmMaterialTable *table)
{
  char prefix[256];

  PetscFunctionBeginUser;
  if (!table->database) PetscFunctionReturn(failed);
  PetscCall(PetscOptionsPop());
  PetscCall(PetscOptionsDestroy(&table->database));
  PetscCall(failed);
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_material_%s_", Cell(table, table->row, table->name)));
  PetscCall(CheckCells(options, table, prefix));
  PetscCall(KeepGiven(table, prefix, options->record));
  PetscCall(MpmRecordDestroy(&table->options.record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialTableDestroy(MpmMaterialTable *table)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(table->path));
  PetscCall(PetscFree(table->given));
  PetscCall(PetscFree(table->given_text));
  PetscCall(MpmCsvTableDestroy(&table->csv));
  PetscFunctionReturn(PETSC_SUCCESS);
}
