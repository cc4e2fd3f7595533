#pragma once
/*
  Numbers of a run by name: contents of a checkpoint besides the points. The owner of a number registers its row.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/parts.h"

typedef struct MpmRows {
  PetscInt count;
  MpmRow  *at;
} MpmRows;

/* Values of all numbers at some time, or of a checkpoint. */
typedef struct {
  PetscInt    count;
  char      **name;
  PetscBool  *real, *there; /* real or integer; false: not in the checkpoint */
  PetscReal  *value;
  PetscInt64 *number;
} MpmRowValues;

/* Registers rows; their names begin with `head` where it is not NULL. */
PetscErrorCode MpmRowsAdd(MpmRows *rows, const char head[], PetscInt count, const MpmRow row[]);
PetscErrorCode MpmRowsDestroy(MpmRows **rows);
PetscErrorCode MpmRowsSave(const MpmRows *rows, MpmRowValues *values);
/* Loads the saved values whose names begin so; of MPM_ROW_STATE alone or of both uses. Rows of MpmRowsSave(). */
PetscErrorCode MpmRowsLoad(const MpmRows *rows, const MpmRowValues *values, const char begin[], PetscBool state);
PetscErrorCode MpmRowValuesDestroy(MpmRowValues *values);
