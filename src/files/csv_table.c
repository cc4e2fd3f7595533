/*
  Tables in CSV files, as spreadsheets of any country write them.

  The line of names tells what separates: semicolons where it has one, else commas, else tabs, else blanks. Where
  commas do not separate, or in quotes, a comma in a number is a decimal one; a file has decimal commas or decimal
  points. Names and numbers may stand in quotes, a doubled quote within them is one. A byte-order mark of UTF-8 is
  passed over, and a separator at the end of all lines makes no column.
*/
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "files/csv_table.h"

/* How the file is written, as far as it has been read. */
typedef struct {
  char      separator;    /* ' ': any number of blanks and tabs */
  char    **word;         /* of the line under way */
  PetscInt  most;         /* room for words */
  PetscInt *order;        /* of the table's words, by the alphabet */
  long long comma, point; /* the first line with a decimal comma, and with a decimal point; 0: none yet */
} Form;

/* ---- words ---- */

#define BLANKS     " \t\r\n"
#define BAD_QUOTES "line %lld: quotes that do not close, or text behind them"

/* Takes a word out of its quotes, in place; returns the remaining line, NULL where the quotes do not close. */
static char *Unquote(char *begin)
{
  char *to = begin, *from = begin + 1;

  for (; *from && (*from != '"' || from[1] == '"'); from++) {
    if (*from == '"') from++;
    *to++ = *from;
  }
  if (!*from) return NULL;
  *to = '\0';
  return from + 1;
}

/*
  Takes a word off the line, blanks around it dropped; NULL for one whose quotes are at fault. Returns the remaining
  line, or NULL.
*/
static char *TakeWord(char *begin, char separator, char **word)
{
  const char  ends[] = {separator, separator == ' ' ? '\t' : '\0', '\0'};
  const char *blanks = separator == '\t' ? " " : BLANKS;
  char       *rest, *end;

  begin += strspn(begin, blanks);
  rest  = *begin == '"' ? Unquote(begin) : begin;
  *word = NULL;
  if (!rest) return NULL;
  end = rest + strcspn(rest, ends);
  if (rest == begin || rest + strspn(rest, BLANKS) >= end) *word = begin;
  rest = *end ? end + 1 : NULL;
  *end = '\0';
  if (rest && separator == ' ' && !rest[strspn(rest, BLANKS)]) rest = NULL;
  begin += strspn(begin, BLANKS);
  if (*word) *word = begin;
  for (end = begin + strlen(begin); end > begin && strchr(BLANKS, end[-1]);) *--end = '\0';
  return rest;
}

/* Cuts a line into words; returns how many there are, -1 for quotes that are at fault. */
static PetscInt CutLine(char *line, Form *form)
{
  PetscInt count = 0;

  for (char *next = line; next; count++) {
    char *word;

    next = TakeWord(next, form->separator, &word);
    if (!word) return -1;
    if (count < form->most) form->word[count] = word;
  }
  return count;
}

/* Whether the line has this character outside of quotes. */
static PetscBool HasOutside(const char *line, char wanted)
{
  PetscBool quoted = PETSC_FALSE;

  for (const char *c = line; *c; c++) {
    if (*c == '"') quoted = (PetscBool)!quoted;
    else if (*c == wanted && !quoted) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

/* A number, its comma read as a decimal one where the word has no point; PETSC_FALSE where it is none. */
static PetscBool ParseNumber(char *word, long long line, Form *form, PetscReal *value)
{
  char *comma = strchr(word, ','), *end;

  if (strchr(word, '.') && !form->point) form->point = line;
  if (comma) {
    if (!form->comma) form->comma = line;
    if (strchr(word, '.') || strchr(comma + 1, ',')) return PETSC_FALSE;
    *comma = '.';
  }
  *value = (PetscReal)strtod(word, &end);
  if (comma) *comma = ',';
  return (PetscBool)(end != word && !*end);
}

/* The word's place among the column's different ones, which `form->order` sorts. */
static PetscErrorCode TakeText(MpmCsvTable *table, Form *form, const char *word, PetscReal *value)
{
  PetscInt low = 0, high = table->word_count;

  PetscFunctionBeginUser;
  while (low < high) {
    const PetscInt middle = (low + high) / 2;

    if (strcmp(table->word[form->order[middle]], word) < 0) low = middle + 1;
    else high = middle;
  }
  if (low == table->word_count || strcmp(table->word[form->order[low]], word)) {
    const PetscInt count = ++table->word_count;

    PetscCall(PetscRealloc(sizeof(*table->word) * (size_t)count, &table->word));
    PetscCall(PetscRealloc(sizeof(*form->order) * (size_t)count, &form->order));
    PetscCall(PetscArraymove(&form->order[low + 1], &form->order[low], count - 1 - low));
    PetscCall(PetscStrallocpy(word, &table->word[count - 1]));
    form->order[low] = count - 1;
  }
  *value = (PetscReal)form->order[low];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- lines ---- */

static PetscBool HasTexts(const MpmCsvTable *table, PetscInt column)
{
  return (PetscBool)(table->of_words &&
                     (table->of_words[0] == '*' || !strcasecmp(table->name[column], table->of_words)));
}

/* One row into the table; a complaint where it is not one. */
static PetscErrorCode TakeRow(MpmCsvTable *table, Form *form, char *line, long long number,
                              char message[MPM_CSV_MESSAGE])
{
  PetscInt count = CutLine(line, form);

  PetscFunctionBeginUser;
  if (count == table->columns + 1 && !form->word[count - 1][0]) count--; /* a separator at the line's end */
  if (count < 0) PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, BAD_QUOTES, number));
  else if (count != table->columns)
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "line %lld has %d numbers, its columns are %d", number,
                            (int)count, (int)table->columns));
  for (PetscInt c = 0; c < table->columns && !message[0]; c++) {
    PetscReal *value = &table->value[table->rows * table->columns + c];

    if (HasTexts(table, c) && (form->word[c][0] || table->of_words[0] == '*'))
      PetscCall(TakeText(table, form, form->word[c], value));
    else if (!ParseNumber(form->word[c], number, form, value))
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "line %lld, column %s: '%.40s' is not a number", number,
                              table->name[c], form->word[c]));
    else if (form->comma && form->point)
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE,
                              "line %lld has a decimal comma, line %lld a decimal point: must be one of them",
                              form->comma, form->point));
  }
  table->rows++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsNumber(const char *word)
{
  char *end;

  (void)strtod(word, &end);
  return (PetscBool)(end != word && !*end);
}

/* Faults of the names: an empty or repeated one, or numbers in their place. */
static PetscErrorCode CheckNames(const MpmCsvTable *table, long long number, char message[MPM_CSV_MESSAGE])
{
  PetscInt numbers = 0;

  PetscFunctionBeginUser;
  while (numbers < table->columns && IsNumber(table->name[numbers])) numbers++;
  if (numbers && numbers == table->columns)
    PetscCall(
      PetscSNPrintf(message, MPM_CSV_MESSAGE, "line %lld has numbers, must have the names of the columns", number));
  for (PetscInt c = 0; c < table->columns && !message[0]; c++) {
    const PetscInt first = MpmCsvTableFind(table, table->name[c]);

    if (!table->name[c][0])
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "line %lld: column %d has no name", number, (int)c + 1));
    else if (first != c)
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "line %lld has column %.40s twice, as number %d and %d", number,
                              table->name[c], (int)first + 1, (int)c + 1));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TakeNames(MpmCsvTable *table, Form *form, char *line, long long number,
                                char message[MPM_CSV_MESSAGE])
{
  static const char separators[] = ";,\t";

  PetscFunctionBeginUser;
  form->separator = ' ';
  for (size_t k = 0; separators[k] && form->separator == ' '; k++)
    if (HasOutside(line, separators[k])) form->separator = separators[k];
  form->most = 2;
  for (const char *c = line; *c; c++) form->most += *c == form->separator || *c == '\t';
  PetscCall(PetscCalloc1(form->most, &form->word));
  table->columns = CutLine(line, form);
  if (table->columns < 0) {
    table->columns = 0;
    PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, BAD_QUOTES, number));
  }
  if (table->columns > 1 && !form->word[table->columns - 1][0]) table->columns--;
  PetscCall(PetscMalloc1(table->columns, &table->name));
  for (PetscInt c = 0; c < table->columns; c++) PetscCall(PetscStrallocpy(form->word[c], &table->name[c]));
  if (!message[0]) PetscCall(CheckNames(table, number, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- files ---- */

/* Faults of a text: UTF-16, or a byte of value 0, which would end a string. */
static const char *TextFault(const char *text, size_t length)
{
  if (length > 1 && (!memcmp(text, "\xFF\xFE", 2) || !memcmp(text, "\xFE\xFF", 2)))
    return "is text in UTF-16, must be in UTF-8";
  return memchr(text, '\0', length) ? "holds a byte of value 0: not a text" : NULL;
}

PetscErrorCode MpmTextRead(const char *path, char **text, char message[MPM_CSV_MESSAGE])
{
  FILE       *stream = fopen(path, "rb");
  long        length = -1;
  const char *fault  = NULL;

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
    if (fread(*text, 1, (size_t)length, stream) != (size_t)length) fault = "cannot be read";
    else fault = TextFault(*text, (size_t)length);
    if (fault) PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "%s", fault));
    if (!strncmp(*text, "\xEF\xBB\xBF", 3)) memset(*text, ' ', 3); /* byte-order mark */
    for (char *c = *text; *c; c++)
      if (*c == '\r' && c[1] != '\n') *c = '\n';
  }
  if (stream) (void)fclose(stream);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCsvTableRead(const char *path, MpmCsvTable *table, char message[MPM_CSV_MESSAGE])
{
  char     *text, *next;
  PetscInt  lines  = 1;
  long long number = 0;
  Form      form   = {.separator = ','};

  PetscFunctionBeginUser;
  PetscCall(MpmTextRead(path, &text, message));
  for (const char *c = text; c && *c; c++) lines += *c == '\n';
  for (char *line = text; line && !message[0]; line = next) {
    number++;
    next = strchr(line, '\n');
    if (next) *next++ = '\0';
    line += strspn(line, " ");
    if (line[0] == '#' || !line[strspn(line, " \t\r;,\"")]) continue; /* a remark, or a row of empty cells */
    if (!table->columns) {
      PetscCall(TakeNames(table, &form, line, number, message));
      PetscCall(PetscMalloc1(((size_t)lines * (size_t)table->columns), &table->value));
    } else PetscCall(TakeRow(table, &form, line, number, message));
  }
  PetscCall(PetscFree(form.order));
  PetscCall(PetscFree(form.word));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmCsvTableFind(const MpmCsvTable *table, const char *name)
{
  for (PetscInt c = 0; c < table->columns; c++)
    if (!strcasecmp(table->name[c], name)) return c;
  return -1;
}

PetscErrorCode MpmCsvTableNames(const MpmCsvTable *table, char message[MPM_CSV_MESSAGE])
{
  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < table->columns; c++) {
    PetscCall(PetscStrlcat(message, c ? ", " : table->columns > 1 ? "; there are " : "; there is ", MPM_CSV_MESSAGE));
    PetscCall(PetscStrlcat(message, table->name[c], MPM_CSV_MESSAGE));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCsvTableFinite(const MpmCsvTable *table, PetscInt column, char message[MPM_CSV_MESSAGE])
{
  PetscFunctionBeginUser;
  for (PetscInt64 k = 0; k < table->rows * table->columns && !message[0]; k++)
    if ((column < 0 || k % table->columns == column) && PetscIsInfOrNanReal(table->value[k]))
      PetscCall(PetscSNPrintf(message, MPM_CSV_MESSAGE, "%s of row %d is not a finite number",
                              table->name[k % table->columns], (int)(k / table->columns) + 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Texts of rank 0 for all ranks. */
static PetscErrorCode ShareTexts(MPI_Comm comm, PetscInt *count, char ***texts)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Bcast(count, 1, MPIU_INT, 0, comm));
  if (rank) PetscCall(PetscCalloc1(*count, texts));
  for (PetscInt k = 0; k < *count; k++) {
    int length = rank ? 0 : (int)strlen((*texts)[k]) + 1;

    PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, 0, comm));
    if (rank) PetscCall(PetscMalloc1(length, &(*texts)[k]));
    PetscCallMPI(MPI_Bcast((*texts)[k], length, MPI_CHAR, 0, comm));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCsvTableShareWords(MPI_Comm comm, MpmCsvTable *table)
{
  PetscFunctionBeginUser;
  PetscCall(ShareTexts(comm, &table->word_count, &table->word));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCsvTableShare(MPI_Comm comm, MpmCsvTable *table)
{
  PetscMPIInt rank;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(ShareTexts(comm, &table->columns, &table->name));
  PetscCall(MpmCsvTableShareWords(comm, table));
  PetscCallMPI(MPI_Bcast(&table->rows, 1, MPIU_INT64, 0, comm));
  if (rank) PetscCall(PetscMalloc1((size_t)table->rows * (size_t)table->columns, &table->value));
  PetscCallMPI(MPI_Bcast(table->value, (PetscMPIInt)(table->rows * table->columns), MPIU_REAL, 0, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCsvTableDestroy(MpmCsvTable *table)
{
  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < table->columns; c++) PetscCall(PetscFree(table->name[c]));
  for (PetscInt k = 0; k < table->word_count; k++) PetscCall(PetscFree(table->word[k]));
  PetscCall(PetscFree(table->name));
  PetscCall(PetscFree(table->word));
  PetscCall(PetscFree(table->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
