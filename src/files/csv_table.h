#pragma once
/*
  A table in a CSV file: a line of names, then a row of numbers each. Lines that start with # are remarks. Separated by
  commas, semicolons, tabs or blanks; names are found whatever their case, and none may be there twice.
*/
#include "base/base.h"

/*
  Start from zeros; `value` holds row by row. A column `of_words`, borrowed and case aside, has texts in place of
  numbers: its values are places among the different `word`s, which stand in the order of their first rows. "*": all
  columns have texts, empty ones too.
*/
typedef struct {
  const char *of_words;
  PetscInt    columns, word_count;
  char      **name, **word;
  PetscInt64  rows;
  PetscReal  *value;
} MpmCsvTable;

#define MPM_CSV_MESSAGE 512
/* Not collective. A fault of the file goes into `message`, which stays as it is where there is none. */
PetscErrorCode MpmCsvTableRead(const char *path, MpmCsvTable *table, char message[MPM_CSV_MESSAGE]);
/* The whole file as text, to be freed: line feeds at ends of lines, no byte-order mark; `message` as above. */
PetscErrorCode MpmTextRead(const char *path, char **text, char message[MPM_CSV_MESSAGE]);
/* The column of that name, case aside, or -1. */
PetscInt MpmCsvTableFind(const MpmCsvTable *table, const char *name);
/* Appends the names that are there to a message of a missing column: "; there are time, load". */
PetscErrorCode MpmCsvTableNames(const MpmCsvTable *table, char message[MPM_CSV_MESSAGE]);
/* Complains of the first number of a column, of any column with -1, that is not finite. */
PetscErrorCode MpmCsvTableFinite(const MpmCsvTable *table, PetscInt column, char message[MPM_CSV_MESSAGE]);
/* Words of rank 0, or all of its table, for all ranks. */
PetscErrorCode MpmCsvTableShareWords(MPI_Comm comm, MpmCsvTable *table);
PetscErrorCode MpmCsvTableShare(MPI_Comm comm, MpmCsvTable *table);
PetscErrorCode MpmCsvTableDestroy(MpmCsvTable *table);
