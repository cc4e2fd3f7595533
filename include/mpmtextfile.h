#pragma once
/*
  MpmTextFile - a text that grows and then becomes a file in one go. The file appears under its name complete or not
  at all: it is written under a temporary name beside it and renamed.
*/
#include <petscsys.h>
#include "mpmcompat.h"

/* Start from MPM_TEXT_FILE_EMPTY. `data` ends with a zero byte once anything has been appended. */
typedef struct {
  char  *data;
  size_t length, capacity;
} MpmTextFile;
#define MPM_TEXT_FILE_EMPTY ((MpmTextFile){NULL, 0, 0})

/* Not collective. The format is C's printf's. */
PetscErrorCode MpmTextFileAppend(MpmTextFile *text, const char *format, ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
/* Makes room for `more` bytes and the closing zero. */
PetscErrorCode MpmTextFileReserve(MpmTextFile *text, size_t more);
PetscErrorCode MpmTextFileDestroy(MpmTextFile *text);

/*@
  MpmTextFileWrite - write texts, one after the other, as the file `path`, replacing what was there

  Collective; the texts of rank 0 count

  Input Parameters:
+ comm  - the ranks that wait for the file
. path  - its name
. count - number of texts
- texts - pointers to them

  Notes:
  Fails on all ranks with PETSC_ERR_FILE_WRITE and one line with the name and the system's reason.
@*/
PetscErrorCode MpmTextFileWrite(MPI_Comm comm, const char *path, PetscInt count, const MpmTextFile *const texts[]);

/* Collective: when `failure`, the value of errno on rank 0, is not 0, all ranks fail with PETSC_ERR_FILE_WRITE and
   one line. */
PetscErrorCode MpmFileCheck(MPI_Comm comm, const char *path, int failure);
