#pragma once
/*
  Materials by labels: whole numbers of voxels, or of the column `material` of a file of points (labels.c).
*/
#include "base/base.h"
#include "base/types.h"

/* Labels from `first` to `last` stand for a name; `value` is the owner's number for it, -1: nothing is there. */
typedef struct {
  PetscInt  first, last, value;
  char     *name;
  PetscBool met; /* a voxel or a point has such a label */
} MpmLabelRange;

typedef struct {
  PetscInt       count;
  MpmLabelRange *range;
} MpmLabels;

/* Reads the option `labels`, "0:none,1:binder,2-900:grain"; without it, where it is not required, count is 0. */
PetscErrorCode MpmLabelsRead(const MpmOptions *options, const char *help, PetscBool required, MpmLabels *labels);
PetscErrorCode MpmLabelsDestroy(MpmLabels *labels);
/* Place of the first range with this label; -1: none. */
PetscInt MpmLabelsFind(const MpmLabels *labels, PetscInt label);
/* Numbers the names by their places among `names`; fails with MPM_ERR_INPUT for one that is not there, nor `none`. */
PetscErrorCode MpmLabelsNumber(const MpmOptions *options, PetscInt count, const char *const names[], MpmLabels *labels);
