/*
  MpmHistory - the CSV file with one row a step.

  Create writes the header, Append one row, Destroy closes. Each row is flushed: what a killed run had reached can be
  read.
*/
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include "mpmoutput.h"
#include "mpmtextfile.h"

struct _p_MpmHistory {
  MPI_Comm comm;
  char    *path;
  FILE    *file; /* rank 0 only */
  PetscInt columns;
};

/* Flushes; returns 0 or errno. A failure of an earlier print is remembered by the stream. */
static int HistoryFlush(FILE *file)
{
  errno = 0;
  if (fflush(file) || ferror(file)) return errno ? errno : EIO;
  return 0;
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
  MpmHistory  made;
  int         failure = 0;

  PetscFunctionBeginUser;
  *history = NULL;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(PetscNew(&made));
  made->comm    = comm;
  made->columns = columns;
  PetscCall(PetscStrallocpy(path, &made->path));
  if (rank == 0) {
    errno      = 0;
    made->file = fopen(path, "w");
    if (made->file) {
      for (PetscInt i = 0; i < columns; ++i) (void)fprintf(made->file, "%s%s", i ? "," : "", names[i]);
      (void)fputc('\n', made->file);
      failure = HistoryFlush(made->file);
    } else {
      failure = errno ? errno : EIO;
    }
  }
  *history = made; /* before the check: the caller can then destroy it */
  PetscCall(MpmFileCheck(comm, path, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* 2^53: from here on doubles are integers that no longer count every one. */
#define LARGEST_COUNT 9007199254740992.

static void PrintValue(FILE *file, double value)
{
  if (value == floor(value) && fabs(value) < LARGEST_COUNT) (void)fprintf(file, "%lld", (long long)value);
  else (void)fprintf(file, "%.17g", value);
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
    for (PetscInt i = 0; i < history->columns; ++i) {
      if (i) (void)fputc(',', history->file);
      PrintValue(history->file, (double)values[i]);
    }
    (void)fputc('\n', history->file);
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
