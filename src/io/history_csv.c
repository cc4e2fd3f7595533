/*
  MpmHistory - the CSV file with one row a step.

  Create writes the header, Append one row, Destroy closes. Each row is flushed: what a killed run had reached can be
  read. Mark tells how much there is, Continue appends there in a later run.
*/
#include <errno.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include "base/outcome.h"
#include "base/base.h"
#include "io/io.h"

struct _p_MpmHistory {
  MPI_Comm comm;
  char    *path;
  FILE    *file; /* rank 0 only */
  PetscInt columns;

  MpmHistoryPlace place; /* rank 0: all that has been written */
};

/* The hash (FNV-1a, 64 bits) of all bytes so far, after these. */
static void PlaceAdvance(MpmHistoryPlace *place, const char *text, size_t length)
{
  uint64_t hash = place->length ? (uint64_t)place->hash : 0xcbf29ce484222325u;

  for (size_t i = 0; i < length; ++i) hash = (hash ^ (unsigned char)text[i]) * 0x100000001b3u;
  place->hash = (PetscInt64)hash;
  place->length += (PetscInt64)length;
}

/* Writes a line and counts it; the stream keeps a failure. */
static PetscErrorCode WriteLine(MpmHistory history, MpmTextFile *line)
{
  PetscFunctionBeginUser;
  (void)fwrite(line->data, 1, line->length, history->file);
  PlaceAdvance(&history->place, line->data, line->length);
  PetscCall(MpmTextFileDestroy(line));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode HeaderText(PetscInt columns, const char *const names[], MpmTextFile *line)
{
  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < columns; ++i)
    PetscCall(MpmTextFileAppend(line, "%s%c", names[i], i + 1 < columns ? ',' : '\n'));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Flushes; returns 0 or errno. A failure of an earlier print is kept by the stream. */
static int HistoryFlush(FILE *file)
{
  errno = 0;
  if (fflush(file) || ferror(file)) return errno ? errno : EIO;
  return 0;
}

static PetscErrorCode HistoryNew(MPI_Comm comm, const char *path, PetscInt columns, MpmHistory *history)
{
  PetscFunctionBeginUser;
  PetscCall(PetscNew(history));
  (*history)->comm    = comm;
  (*history)->columns = columns;
  PetscCall(PetscStrallocpy(path, &(*history)->path));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MpmHistoryCreate - open a CSV file and write its header

  Collective

  Input Parameters:
+ comm    - the ranks of the run; rank 0 writes
. path    - file name; what was there is lost
. columns - number of columns
- names   - their names

  Output Parameter:
. history - the writer; close it with MpmHistoryDestroy()
@*/
PetscErrorCode MpmHistoryCreate(MPI_Comm comm, const char *path, PetscInt columns, const char *const names[],
                                MpmHistory *history)
{
  PetscMPIInt rank;
  int         failure = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(HistoryNew(comm, path, columns, history));
  if (rank == 0) {
    errno            = 0;
    (*history)->file = fopen(path, "w");
    if ((*history)->file) {
      MpmTextFile line = MPM_TEXT_FILE_EMPTY;

      PetscCall(HeaderText(columns, names, &line));
      PetscCall(WriteLine(*history, &line));
      failure = HistoryFlush((*history)->file);
    } else {
      failure = errno ? errno : EIO;
    }
  }
  PetscCall(MpmFileCheck(comm, path, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Checks that the file is unchanged up to the place, with these columns. */
static PetscErrorCode CompareHistory(FILE *file, const MpmHistoryPlace *place, const MpmTextFile *header,
                                     MpmOutcome *outcome)
{
  MpmHistoryPlace now  = {0, 0};
  size_t          size = (size_t)place->length;
  char           *text;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((size + 1), &text));
  size = fread(text, 1, size, file);
  PlaceAdvance(&now, text, size);
  if (now.length != place->length) PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_FILE, "it is shorter than it was"));
  else if (now.hash != place->hash) PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_FILE, "it is not what it was"));
  else if (size < header->length || memcmp(text, header->data, header->length))
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_FILE, "it has other columns"));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHistoryContinue(MPI_Comm comm, const char *path, PetscInt columns, const char *const names[],
                                  const MpmHistoryPlace *place, MpmHistory *history, MpmOutcome *outcome)
{
  PetscMPIInt rank;
  int         answer[2] = {0, 0}; /* the file exists; errno */

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    FILE       *file   = fopen(path, "r+");
    MpmTextFile header = MPM_TEXT_FILE_EMPTY;

    answer[0] = file != NULL;
    PetscCall(HeaderText(columns, names, &header));
    if (file) PetscCall(CompareHistory(file, place, &header, outcome));
    errno = 0;
    if (file && !outcome->code && ftruncate(fileno(file), (off_t)place->length)) answer[1] = errno ? errno : EIO;
    if (file) (void)fclose(file);
    PetscCall(MpmTextFileDestroy(&header));
  }
  PetscCallMPI(MPI_Bcast(answer, 2, MPI_INT, 0, comm));
  PetscCall(MpmOutcomeBroadcast(comm, 0, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmFileCheck(comm, path, answer[1]));
  if (!answer[0]) {
    PetscCall(MpmHistoryCreate(comm, path, columns, names, history));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(HistoryNew(comm, path, columns, history));
  (*history)->place = *place;
  errno             = 0;
  if (rank == 0 && !((*history)->file = fopen(path, "a"))) answer[1] = errno ? errno : EIO;
  PetscCall(MpmFileCheck(comm, path, answer[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHistoryMark(MpmHistory history, MpmHistoryPlace *place)
{
  int failure = 0;

  PetscFunctionBeginUser;
  errno = 0;
  if (history->file && fsync(fileno(history->file))) failure = errno ? errno : EIO;
  PetscCall(MpmFileCheck(history->comm, history->path, failure));
  *place = history->place;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 2^53: from here on doubles are integers that no longer count every one. */
#define LARGEST_COUNT 9007199254740992.
#define COLUMN_WIDTH  25 /* of a number with its separator */

/* Most columns of most rows are 0 or a small count, written without printf. */
static PetscErrorCode AppendValue(MpmTextFile *line, double value, char separator)
{
  const PetscBool count = (PetscBool)(value == floor(value) && fabs(value) < LARGEST_COUNT);

  PetscFunctionBeginUser;
  if (count && value >= 0. && value < 10.) {
    const char text[] = {(char)('0' + (int)value), separator};

    PetscCall(MpmTextFileReserve(line, sizeof(text)));
    (void)memcpy(line->data + line->length, text, sizeof(text));
    line->length += sizeof(text);
    line->data[line->length] = 0;
  } else if (count) PetscCall(MpmTextFileAppend(line, "%lld%c", (long long)value, separator));
  else PetscCall(MpmTextFileAppend(line, "%.17g%c", value, separator));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*@
  MpmHistoryAppend - write one row

  Collective

  Input Parameters:
+ history - the writer
- values  - one number a column; those of rank 0 count
@*/
PetscErrorCode MpmHistoryAppend(MpmHistory history, const PetscReal values[])
{
  int failure = 0;

  PetscFunctionBeginUser;
  if (history->file) {
    MpmTextFile line = MPM_TEXT_FILE_EMPTY;

    PetscCall(MpmTextFileReserve(&line, (size_t)history->columns * COLUMN_WIDTH));
    for (PetscInt i = 0; i < history->columns; ++i)
      PetscCall(AppendValue(&line, (double)values[i], i + 1 < history->columns ? ',' : '\n'));
    PetscCall(WriteLine(history, &line));
    failure = HistoryFlush(history->file);
  }
  PetscCall(MpmFileCheck(history->comm, history->path, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHistoryDestroy(MpmHistory *history)
{
  PetscFunctionBeginUser;
  if (!*history) PetscFunctionReturn(PETSC_SUCCESS);
  if ((*history)->file) (void)fclose((*history)->file); /* nothing is left in its buffer */
  PetscCall(PetscFree((*history)->path));
  PetscCall(PetscFree(*history));
  PetscFunctionReturn(PETSC_SUCCESS);
}
