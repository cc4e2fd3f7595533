#pragma once
/*
  Materials of the points of a file (row_labels.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "files/point_table.h"

/* Materials that a body from a file may take. */
typedef struct MpmRowChoice {
  PetscInt           count;
  const char *const *names;
  PetscInt           own; /* of all its points; -1: each has that of its row */
  PetscBool         *has; /* by material, where each has that of its row: some point is of it */
} MpmRowChoice;

/*
  MpmRowLabelsRead - scene's material of each row of a file of points

  Collective

  Output Parameter:
. row - by row of this rank, -1: the row makes no point; to be freed. NULL: all rows are of the body's own material

  Fails with MPM_ERR_INPUT and one line for a row without a material, and where the file and the block contradict.
  `file` is NULL for -help.
*/
PetscErrorCode MpmRowLabelsRead(const MpmOptions *block, const char path[], MpmPointFile file,
                                const MpmRowChoice *materials, PetscInt **row);
