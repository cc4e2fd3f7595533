#pragma once
/*
  The files of checkpoints: <prefix>_checkpoint.h5 is the newest, older ones that are kept carry the number of their step.

  A checkpoint is an HDF5 file behind a head of 512 bytes of text, which says what it is, how long, and the hash of every
  byte: nothing of the file is trusted, and HDF5 does not see it, before that hash has been made anew.
*/
#include <stdint.h>
#include "mpmtextfile.h"

#define MPM_CHECKPOINT_FORMAT 2
#define MPM_CHECKPOINT_HEAD   512

typedef struct {
  long long format, step, size; /* size: bytes in all */
  long long run;                /* a number that tells one run from another; restarts belong to their run */
  uint64_t  hash;
} MpmCheckpointHead;

/*
  Completes a file that MpmStateWrite() has made: writes the head, brings it to the disk and gives it its name; what had
  this name is kept under the number of its step, and those beyond the newest `keep` of this run are removed. All ranks
  read the file where it has at least `collective` bytes. Collective; fails with PETSC_ERR_FILE_WRITE and one line.
*/
PetscErrorCode MpmCheckpointPublish(MPI_Comm comm, const char *prefix, const char *temporary, MpmCheckpointHead *head,
                                    PetscInt keep, PetscInt64 collective);
/* Is it whole and of this format? `why` is NULL, or the reason (in `text`) for which it is not. Collective. */
PetscErrorCode MpmCheckpointVerify(MPI_Comm comm, const char *path, PetscInt64 collective, MpmCheckpointHead *head,
                                   char text[256], const char **why);
/* The checkpoints of a prefix, the newest first. Collective; free with MpmNamesDestroy(). */
PetscErrorCode MpmCheckpointList(MPI_Comm comm, const char *prefix, PetscInt *count, char ***paths);
