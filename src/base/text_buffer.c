/*
  Texts that become files on rank 0, and how all ranks learn that one could not be written.
*/
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "base/base.h"

PetscErrorCode MpmTextFileReserve(MpmTextFile *text, size_t more)
{
  PetscFunctionBeginUser;
  if (text->length + more + 1 > text->capacity) {
    size_t capacity = PetscMax(2 * text->capacity, text->length + more + 1);
    PetscCall(PetscRealloc(capacity, &text->data));
    text->capacity = capacity;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTextFileAppend(MpmTextFile *text, const char *format, ...)
{
  const size_t room = text->capacity - text->length;
  va_list      arguments;
  int          length;

  PetscFunctionBeginUser;
  va_start(arguments, format);
  length = vsnprintf(room ? text->data + text->length : NULL, room, format, arguments);
  va_end(arguments);
  PetscCheck(length >= 0, PETSC_COMM_SELF, PETSC_ERR_LIB, "cannot format '%s'", format);
  if ((size_t)length >= room) { /* the room was too small: once more */
    PetscCall(MpmTextFileReserve(text, (size_t)length));
    va_start(arguments, format);
    (void)vsnprintf(text->data + text->length, (size_t)length + 1, format, arguments);
    va_end(arguments);
  }
  text->length += (size_t)length;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTextFileDestroy(MpmTextFile *text)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(text->data));
  *text = MPM_TEXT_FILE_EMPTY;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFileCheck(MPI_Comm comm, const char *path, int failure)
{
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&failure, 1, MPI_INT, 0, comm));
  PetscCheck(failure == 0, comm, PETSC_ERR_FILE_WRITE, "cannot write %s: %s", path, strerror(failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A library call that failed without a word in errno is still a failure. */
static int FailureNow(void)
{
  return errno ? errno : EIO;
}

/* Writes and closes the file; returns 0 or errno. */
static int WriteTexts(const char *path, PetscInt count, const MpmTextFile *const texts[])
{
  int   failure = 0;
  FILE *file;

  errno = 0;
  file  = fopen(path, "w");
  if (!file) return FailureNow();
  for (PetscInt i = 0; i < count && !failure; ++i) {
    if (texts[i]->length && fwrite(texts[i]->data, 1, texts[i]->length, file) != texts[i]->length)
      failure = FailureNow();
  }
  if (fclose(file) && !failure) failure = FailureNow();
  if (failure) (void)remove(path);
  return failure;
}

PetscErrorCode MpmTextFileWrite(MPI_Comm comm, const char *path, PetscInt count, const MpmTextFile *const texts[])
{
  PetscMPIInt rank;
  int         failure = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    MpmTextFile temporary = MPM_TEXT_FILE_EMPTY;
    PetscCall(MpmTextFileAppend(&temporary, "%s.tmp", path));
    failure = WriteTexts(temporary.data, count, texts);
    errno   = 0;
    if (!failure && rename(temporary.data, path)) {
      failure = FailureNow();
      (void)remove(temporary.data);
    }
    PetscCall(MpmTextFileDestroy(&temporary));
  }
  PetscCall(MpmFileCheck(comm, path, failure));
  PetscFunctionReturn(PETSC_SUCCESS);
}
