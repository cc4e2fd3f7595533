/*
  The record of options in force: what is known to the program, what nobody knows, and how to run the same thing again.

  Order of calls: MpmRecordCreate(), the readers of options.h, MpmOptionsCheckUnknown(), MpmOptionsWriteYAML(),
  MpmRecordDestroy().
*/
#include "options/options.h"
#include "options/record.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* PETSc 3.18 dies on its 513th option. Below this many, defaults are written as keys, beyond it as comments. */
#define MPM_YAML_KEYS 480

typedef MpmDatabaseOption Pair;

/* ---- record ---- */

PetscErrorCode MpmRecordCreate(MpmRecord *record)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRecordDestroy(MpmRecord *record)
{
  PetscFunctionBegin;
  if (!*record) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt i = 0; i < (*record)->count; i++) {
    PetscCall(PetscFree((*record)->entries[i].name));
    PetscCall(PetscFree((*record)->entries[i].value));
  }
  PetscCall(PetscFree((*record)->entries));
  PetscCall(MpmNamesDestroy((*record)->block_count, &(*record)->blocks));
  PetscCall(MpmForeignOptionsForget(*record));
  PetscCall(PetscFree(*record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmRecordSetPlane(MpmRecord record, const MpmPlane *plane)
{
  record->plane  = *plane;
  record->on_map = PETSC_TRUE;
}

const MpmPlane *MpmRecordPlane(MpmRecord record)
{
  return record && record->on_map ? &record->plane : NULL;
}

void MpmRecordSetWindow(MpmRecord record, const PetscReal lower[], const PetscReal upper[])
{
  if (!record) return;
  record->window[0] = lower;
  record->window[1] = upper;
}

void MpmRecordWindow(MpmRecord record, const PetscReal **lower, const PetscReal **upper)
{
  *lower = record ? record->window[0] : NULL;
  *upper = record ? record->window[1] : NULL;
}

PetscErrorCode MpmRecordFind(MpmRecord record, const char name[], MpmRecordEntry **entry)
{
  PetscFunctionBegin;
  *entry = NULL;
  for (PetscInt i = 0; record && i < record->count; i++) {
    PetscBool same;

    PetscCall(PetscStrcasecmp(record->entries[i].name, name, &same));
    if (same) {
      *entry = &record->entries[i];
      break;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRecordGet(MpmRecord record, const char name[], MpmRecordEntry **entry)
{
  PetscFunctionBegin;
  PetscCall(MpmRecordFind(record, name, entry));
  if (*entry) PetscFunctionReturn(PETSC_SUCCESS);
  if (record->count == record->capacity) {
    const PetscInt  capacity = record->capacity ? 2 * record->capacity : 64;
    MpmRecordEntry *entries;

    PetscCall(PetscCalloc1(capacity, &entries));
    PetscCall(PetscArraycpy(entries, record->entries, record->count));
    PetscCall(PetscFree(record->entries));
    record->entries  = entries;
    record->capacity = capacity;
  }
  *entry = &record->entries[record->count++];
  PetscCall(PetscStrallocpy(name, &(*entry)->name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- YAML ---- */

/* True where the character may stand in a double-quoted scalar: the YAML reader refuses controls and folds line
   breaks. */
static PetscBool IsPlain(unsigned code)
{
  if (code == '"' || code == '\\' || code == 0x2028 || code == 0x2029 || code == 0xFEFF) return PETSC_FALSE;
  if (code < 0x20 || (code > 0x7E && code < 0xA0) || (code > 0xFFFD && code < 0x10000)) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* A double-quoted scalar, the one YAML form that can hold any text on one line. */
static void WriteQuoted(FILE *file, const char text[])
{
  const unsigned char *s = (const unsigned char *)text;

  fputc('"', file);
  while (*s) {
    unsigned  code;
    const int size = MpmDecodeUTF8(s, &code);

    if (size && IsPlain(code)) fwrite(s, 1, (size_t)size, file);
    else if (*s == '"' || *s == '\\') fprintf(file, "\\%c", *s);
    else if (size) fprintf(file, "\\U%08X", code);
    else fprintf(file, "\\x%02X", *s); /* not UTF-8: YAML has no bytes, so the nearest is the Latin-1 character */
    s += size ? size : 1;
  }
  fputc('"', file);
}

static void WriteLine(FILE *file, const char comment[], const char name[], const char value[])
{
  PetscBool plain = PETSC_TRUE;

  for (const char *c = name; *c; c++)
    plain = (plain && (isalnum((unsigned char)*c) || *c == '_')) ? PETSC_TRUE : PETSC_FALSE;
  fputs(comment, file);
  if (plain) fputs(name, file);
  else WriteQuoted(file, name);
  fputs(": ", file);
  WriteQuoted(file, value ? value : "");
  fputc('\n', file);
}

/* Options that say where options come from, or that end a run early: of no use in the file that they have led to. */
static PetscErrorCode IsTransient(const char name[], PetscBool *transient)
{
  static const char *const names[] = {"options_file",
                                      "options_file_yaml",
                                      "options_string_yaml",
                                      "prefix_push",
                                      "prefix_pop",
                                      "help",
                                      "h",
                                      "version",
                                      "v"};

  PetscFunctionBegin;
  *transient = PETSC_FALSE;
  for (size_t i = 0; i < sizeof(names) / sizeof(names[0]) && !*transient; i++)
    PetscCall(PetscStrcasecmp(name, names[i], transient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A default becomes a key only where reading it back cannot change anything but the defaults' origin. */
static void WriteRecord(FILE *file, MpmRecord record, PetscInt others)
{
  const PetscBool room = (record->count + others <= MPM_YAML_KEYS) ? PETSC_TRUE : PETSC_FALSE;

  for (PetscInt i = 0; i < record->count; i++) {
    const MpmRecordEntry *entry = &record->entries[i];

    if (!entry->known) continue;
    if (entry->given) WriteLine(file, "", entry->name, entry->value);
    else if (!entry->value) fprintf(file, "# %s: not given\n", entry->name);
    else WriteLine(file, room && !entry->presence ? "" : "# ", entry->name, entry->value);
  }
}

static PetscErrorCode WriteAll(FILE *file, MpmRecord record, PetscInt count, const Pair pairs[])
{
  PetscFunctionBegin;
  fputs("# Options in force. Defaults whose mere presence would mean something stand as comments.\n", file);
  if (record) WriteRecord(file, record, count);
  for (PetscInt i = 0; i < count; i++) {
    MpmRecordEntry *entry;
    PetscBool       transient;

    PetscCall(MpmRecordFind(record, pairs[i].name, &entry));
    PetscCall(IsTransient(pairs[i].name, &transient));
    if (!transient && !(entry && (entry->known || entry->aside))) WriteLine(file, "", pairs[i].name, pairs[i].value);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsTextYAML(const MpmOptions *options, MpmTextFile *text)
{
  PetscInt count;
  Pair    *pairs;
  char    *words, *bytes = NULL;
  size_t   length;
  FILE    *file = open_memstream(&bytes, &length);

  PetscFunctionBegin;
  PetscCheck(file, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options in force");
  PetscCall(MpmDatabaseGet(&count, &pairs, &words));
  PetscCall(WriteAll(file, options->record, count, pairs));
  PetscCall(PetscFree(pairs));
  PetscCall(PetscFree(words));
  PetscCheck(!fclose(file), PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for the options in force");
  PetscCall(MpmTextFileAppend(text, "%s", bytes));
  free(bytes);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Under another name first: whoever finds the file finds all of it. */
static PetscErrorCode WriteFile(MpmRecord record, const char path[], PetscBool *written)
{
  PetscInt  count;
  Pair     *pairs;
  char     *text, *temporary = NULL;
  FILE     *file;
  PetscBool good;

  PetscFunctionBegin;
  *written = PETSC_FALSE;
  PetscCall(MpmTextAppend(&temporary, "%s.tmp", path));
  file = fopen(temporary, "w");
  if (file) {
    PetscCall(MpmDatabaseGet(&count, &pairs, &text));
    PetscCall(WriteAll(file, record, count, pairs));
    PetscCall(PetscFree(pairs));
    PetscCall(PetscFree(text));
    good = ferror(file) ? PETSC_FALSE : PETSC_TRUE;
    if (fclose(file) == 0 && good && rename(temporary, path) == 0) *written = PETSC_TRUE;
    else remove(temporary);
  }
  PetscCall(PetscFree(temporary));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsWriteYAML(const MpmOptions *options, const char *path)
{
  PetscMPIInt rank;
  int         written = 0;

  PetscFunctionBegin;
  PetscCallMPI(MPI_Comm_rank(options->comm, &rank));
  if (rank == 0) {
    PetscBool done;

    PetscCall(WriteFile(options->record, path, &done));
    written = (int)done;
  }
  PetscCallMPI(MPI_Bcast(&written, 1, MPI_INT, 0, options->comm));
  PetscCheck(written, options->comm, PETSC_ERR_FILE_WRITE, "Cannot write the options in force to %s", path);
  PetscFunctionReturn(PETSC_SUCCESS);
}
