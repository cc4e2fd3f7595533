/*
  The parameters of a law, as the scene has them: numbers, words, tables and data.

  A table is text, "0:5e3,10:8e3", or a file of rows x, y. Data are numbers in a file, any number of them a line. In
  files commas and blanks separate. In lines with semicolons, or tabs between numbers, these separate, and commas are
  decimal ones. A # begins a remark. Rank 0 reads files and sends their contents to the others.
*/
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include "options/options.h"
#include "files/csv_table.h"
#include "point/parameter.h"

#define MESSAGE_LENGTH MPM_CSV_MESSAGE

/* Numbers as they come, and their fault; empty for none. */
typedef struct {
  PetscInt count, capacity;
  double  *value;
  char     message[MESSAGE_LENGTH];
} Numbers;

static PetscErrorCode Append(Numbers *numbers, PetscReal value)
{
  PetscFunctionBeginUser;
  if (numbers->count == numbers->capacity) {
    numbers->capacity = 2 * numbers->capacity + 64;
    PetscCall(PetscRealloc((size_t)numbers->capacity * sizeof(double), &numbers->value));
  }
  numbers->value[numbers->count++] = value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Separators of the numbers of a line: where semicolons or tabs separate, a comma is a decimal one. */
static const char *Separators(const char text[])
{
  if (strchr(text, ';')) return "; \t\r";
  for (const char *tab = strchr(text, '\t'); tab; tab = strchr(tab + 1, '\t'))
    if (tab > text && isdigit((unsigned char)tab[-1]) && tab[1] && !strchr(" \t\r,", tab[1])) return " \t\r";
  return ", \t\r";
}

/* A number, out of its quotes; PETSC_FALSE where it is none. */
static PetscBool ParseWord(char *word, PetscBool decimal_comma, PetscReal *value)
{
  const size_t length = strlen(word);
  char        *comma  = decimal_comma ? strchr(word, ',') : NULL;

  if (length > 1 && word[0] == '"' && word[length - 1] == '"') {
    word[length - 1] = '\0';
    word++;
  }
  if (comma && !strchr(word, '.')) *comma = '.';
  return MpmParseReal(word, value);
}

/* One line of a file, its remark cut off; a row of a table has two numbers. */
static PetscErrorCode TakeLine(PetscBool table, long long line, char *text, Numbers *numbers)
{
  const char *separators;
  PetscInt    before = numbers->count;
  char       *rest;

  PetscFunctionBeginUser;
  text[strcspn(text, "#")] = '\0';
  separators               = Separators(text);
  for (char *word = strtok_r(text, separators, &rest); word && !numbers->message[0];
       word       = strtok_r(NULL, separators, &rest)) {
    PetscReal value;

    if (ParseWord(word, (PetscBool)(separators[0] != ','), &value)) PetscCall(Append(numbers, value));
    else snprintf(numbers->message, MESSAGE_LENGTH, "line %lld: '%.40s' is not a number", line, word);
  }
  before = numbers->count - before;
  if (table && before && before != 2 && !numbers->message[0])
    snprintf(numbers->message, MESSAGE_LENGTH, "line %lld: a row has two numbers, x and y; this one has %lld", line,
             (long long)before);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TakeFile(PetscBool table, const char path[], Numbers *numbers)
{
  char      message[MPM_CSV_MESSAGE] = "", *text, *next;
  long long number                   = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmTextRead(path, &text, message));
  snprintf(numbers->message, MESSAGE_LENGTH, "%s", message);
  for (char *line = text; line && !numbers->message[0]; line = next) {
    next = strchr(line, '\n');
    if (next) *next++ = '\0';
    PetscCall(TakeLine(table, ++number, line, numbers));
  }
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "x:y,x:y" */
static PetscErrorCode TakeText(const char text[], Numbers *numbers)
{
  PetscInt count;
  char   **pairs;

  PetscFunctionBeginUser;
  PetscCall(MpmTextSplit(text, &count, &pairs));
  for (PetscInt i = 0; i < count && !numbers->message[0]; i++) {
    char     *colon = strchr(pairs[i], ':');
    PetscReal x, y;

    if (colon) *colon = '\0';
    if (colon && MpmParseReal(pairs[i], &x) && MpmParseReal(colon + 1, &y)) {
      PetscCall(Append(numbers, x));
      PetscCall(Append(numbers, y));
    } else
      snprintf(numbers->message, MESSAGE_LENGTH,
               "must be x:y pairs of numbers, separated by commas, or a file of them");
  }
  PetscCall(MpmNamesDestroy(count, &pairs));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ShareNumbers(MPI_Comm comm, Numbers *numbers)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Bcast(numbers->message, MESSAGE_LENGTH, MPI_CHAR, 0, comm));
  PetscCallMPI(MPI_Bcast(&numbers->count, 1, MPIU_INT, 0, comm));
  if (rank) PetscCall(PetscMalloc1(numbers->count, &numbers->value));
  PetscCallMPI(MPI_Bcast(numbers->value, (PetscMPIInt)numbers->count, MPI_DOUBLE, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmRange Range(const MpmParameter *parameter)
{
  return (MpmRange){parameter->lower, parameter->upper, parameter->open ? PETSC_TRUE : PETSC_FALSE};
}

/* Writes faults of the numbers of a parameter into their message. */
static void CheckNumbers(const MpmParameter *parameter, Numbers *numbers)
{
  const PetscInt columns = parameter->kind == MPM_TABLE ? 2 : 1;
  char           range[MPM_RANGE_TEXT];

  MpmRangeText(Range(parameter), range);
  if (!numbers->count && !numbers->message[0]) snprintf(numbers->message, MESSAGE_LENGTH, "holds no numbers");
  for (PetscInt k = 0; k < numbers->count && !numbers->message[0]; k += columns) {
    const double   *row = &numbers->value[k], y = row[columns - 1];
    const long long number = k / columns + 1;

    if (columns == 2 && k && !(row[0] > row[-2]))
      snprintf(numbers->message, MESSAGE_LENGTH, "row %lld: x must grow from row to row, %g follows %g", number, row[0],
               row[-2]);
    else if (!MpmRangeHolds(Range(parameter), y))
      snprintf(numbers->message, MESSAGE_LENGTH, "%s %lld: %g must %s %s", columns == 2 ? "row" : "number", number, y,
               strncmp(range, "in ", 3) ? "be" : "lie", range);
  }
}

/* Text with a colon is a table; anything else names a file. */
static PetscErrorCode ReadNumbers(const MpmOptions *block, const MpmParameter *parameter, MpmLawTable *table)
{
  const PetscBool is_table = (PetscBool)(parameter->kind == MPM_TABLE);
  Numbers         numbers  = {0};
  char           *text, *help = NULL, *quoted;
  PetscMPIInt     rank;

  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(&help, "%s (%s), %s", parameter->help, parameter->unit,
                          is_table ? "x:y pairs or the name of a file" : "the name of a file"));
  PetscCall(MpmOptionsPath(block, parameter->name, help, parameter->required ? MPM_REQUIRED : MPM_OPTIONAL, &text));
  PetscCall(PetscFree(help));
  if (!text) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Comm_rank(block->comm, &rank));
  if (is_table && strchr(text, ':')) PetscCall(TakeText(text, &numbers));
  else {
    if (!rank) PetscCall(TakeFile(is_table, text, &numbers));
    PetscCall(ShareNumbers(block->comm, &numbers));
  }
  CheckNumbers(parameter, &numbers);
  if (numbers.message[0]) {
    PetscCall(PetscFree(numbers.value));
    PetscCall(MpmTextQuote(text, &quoted));
    MpmCheckInput(PETSC_FALSE, "-%s%s %s: %s", block->prefix, parameter->name, quoted, numbers.message);
  }
  table->count = (long)(is_table ? numbers.count / 2 : numbers.count);
  table->value = numbers.value;
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A word's value is its index. */
static PetscErrorCode ReadWord(const MpmOptions *block, const MpmParameter *parameter, double *value)
{
  char   **words;
  int      count;
  PetscInt index = (PetscInt)parameter->fallback;

  PetscFunctionBeginUser;
  PetscCall(PetscStrToArray(parameter->choices, '|', &count, &words));
  PetscCall(MpmOptionsWord(block, parameter->name, parameter->help, (const char *const *)words,
                           parameter->required ? MPM_REQUIRED : MPM_OPTIONAL, &index, NULL));
  PetscCall(PetscStrToArrayDestroy(count, words));
  *value = (double)index;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParameterRead(const MpmOptions *block, const MpmParameter *parameter, double *value,
                                MpmLawTable *table)
{
  PetscFunctionBeginUser;
  *value = parameter->kind <= MPM_WORD ? parameter->fallback : 0.;
  *table = (MpmLawTable){0, NULL};
  if (parameter->kind == MPM_WORD) PetscCall(ReadWord(block, parameter, value));
  else if (parameter->kind < MPM_WORD)
    PetscCall(MpmOptionsReal(block, parameter->name, parameter->unit, parameter->help, Range(parameter),
                             parameter->required ? MPM_REQUIRED : MPM_OPTIONAL, value, NULL));
  else PetscCall(ReadNumbers(block, parameter, table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParametersRead(const MpmOptions *block, PetscInt count, const MpmParameter parameters[],
                                 double **values, MpmLawTable **tables)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((count + 1), values));
  PetscCall(PetscCalloc1((count + 1), tables));
  for (PetscInt k = 0; k < count; k++) PetscCall(MpmParameterRead(block, &parameters[k], &(*values)[k], &(*tables)[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParametersPrint(const MpmOptions *block, PetscInt count, const MpmParameter parameters[])
{
  const MpmOptions unrecorded = {block->comm, block->prefix, NULL};

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) {
    MpmLawTable table;
    double      unused;

    PetscCall(MpmParameterRead(&unrecorded, &parameters[k], &unused, &table));
    PetscCall(PetscFree(table.value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTablesDestroy(size_t count, MpmLawTable **table)
{
  PetscFunctionBeginUser;
  for (size_t k = 0; *table && k < count; k++) PetscCall(PetscFree((*table)[k].value));
  PetscCall(PetscFree(*table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStateReadInitial(const MpmOptions *block, const MpmStateVariable *variable, char **text)
{
  char name[128], help[256];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(name, sizeof(name), "initial_%s", variable->name));
  PetscCall(PetscSNPrintf(help, sizeof(help),
                          "%s (%s) to start with: a number, or height:value pairs (m) up gravity's axis",
                          variable->name, variable->unit));
  PetscCall(MpmOptionsText(block, name, help, NULL, MPM_OPTIONAL, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}
