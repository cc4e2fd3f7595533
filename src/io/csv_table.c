/*
  Tables in CSV files.
*/
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "io/csv_table.h"

/* Cuts a line at its commas, blanks around the words taken off; returns how many words there are. */
static PetscInt CutLine(char *line, PetscInt most, char *word[])
{
  PetscInt count = 0;

  for (char *next = line; next; count++) {
    char *end = strchr(next, ','), *last;

    if (end) *end = '\0';
    while (*next == ' ' || *next == '\t') next++;
    for (last = next + strlen(next); last > next && strchr(" \t\r\n", last[-1]); last--) last[-1] = '\0';
    if (count < most) word[count] = next;
    next = end ? end + 1 : NULL;
  }
  return count;
}

/* One row into the table; a complaint where it is not one. */
static PetscErrorCode TakeRow(MpmCsvTable *table, char *line, long long number, char message[MPM_CSV_MESSAGE])
{
  char   **word;
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(table->columns, &word));
  count = CutLine(line, table->columns, word);
  if (count != table->columns)
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "line %lld has %d numbers, its columns are %d", number,
                            (int)count, (int)table->columns));
  for (PetscInt c = 0; c < table->columns && !message[0]; c++) {
    char *end;

    table->value[table->rows * table->columns + c] = (PetscReal)strtod(word[c], &end);
    if (end == word[c] || *end)
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "line %lld, column %s: '%.40s' is not a number", number,
                              table->name[c], word[c]));
  }
  table->rows++;
  PetscCall(PetscFree(word));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TakeNames(MpmCsvTable *table, char *line)
{
  PetscInt most = 1;
  char   **word;

  PetscFunctionBeginUser;
  for (const char *c = line; *c; c++) most += *c == ',';
  PetscCall(PetscMalloc1(most, &word));
  table->columns = CutLine(line, most, word);
  PetscCall(PetscMalloc1(table->columns, &table->name));
  for (PetscInt c = 0; c < table->columns; c++) PetscCall(PetscStrallocpy(word[c], &table->name[c]));
  PetscCall(PetscFree(word));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The whole file as text, or NULL and a complaint. */
static PetscErrorCode ReadText(const char *path, char **text, char message[MPM_CSV_MESSAGE])
{
  FILE *stream = fopen(path, "rb");
  long  length = -1;

  PetscFunctionBeginUser;
  *text = NULL;
  if (stream && !fseek(stream, 0, SEEK_END)) length = ftell(stream);
  if (length == LONG_MAX) { /* a folder */
    errno  = EISDIR;
    length = -1;
  }
  if (length < 0) PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "cannot be read: %s", strerror(errno)));
  else {
    rewind(stream);
    PetscCall(PetscCalloc1(((size_t)length + 1), text));
    if (fread(*text, 1, (size_t)length, stream) != (size_t)length)
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "cannot be read"));
  }
  if (stream) (void)fclose(stream);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCsvTableRead(const char *path, MpmCsvTable *table, char message[MPM_CSV_MESSAGE])
{
  char     *text, *next;
  PetscInt  lines  = 1;
  long long number = 0;

  PetscFunctionBeginUser;
  PetscCall(ReadText(path, &text, message));
  for (const char *c = text; c && *c; c++) lines += *c == '\n';
  for (char *line = text; line && !message[0]; line = next) {
    number++;
    next = strchr(line, '\n');
    if (next) *next++ = '\0';
    if (line[0] == '#' || !line[strspn(line, " \t\r")]) continue;
    if (!table->columns) {
      PetscCall(TakeNames(table, line));
      PetscCall(PetscMalloc1(((size_t)lines * (size_t)table->columns), &table->value));
    } else PetscCall(TakeRow(table, line, number, message));
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmCsvTableFind(const MpmCsvTable *table, const char *name)
{
  for (PetscInt c = 0; c < table->columns; c++)
    if (!strcmp(table->name[c], name)) return c;
  return -1;
}

PetscErrorCode MpmCsvTableDestroy(MpmCsvTable *table)
{
  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < table->columns; c++) PetscCall(PetscFree(table->name[c]));
  PetscCall(PetscFree(table->name));
  PetscCall(PetscFree(table->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
