#pragma once
/*
  Numbers of a run by name: contents of a checkpoint besides the points. The owner of a number registers its row.
*/
#include "base/base.h"
#include "base/types.h"

typedef enum { MPM_ROW_REAL, MPM_ROW_INT, MPM_ROW_INT64, MPM_ROW_BOOL } MpmRowKind;

typedef enum {
  MPM_ROW_RUN,  /* account or setting of the run, which goes on where steps are taken back */
  MPM_ROW_STATE /* state at a time, which returns with the points */
} MpmRowUse;

/* A number or an array of numbers of one kind: PetscReal, PetscInt, PetscInt64 or PetscBool. */
typedef struct {
  const char *name; /* in checkpoints, unchanged from version to version */
  MpmRowKind  kind;
  MpmRowUse   use;
  void       *address; /* fixed while the rows live */
  PetscInt    count; /* length of an array, whose numbers are <name>_<first>, <name>_<first + 1>, ...; 0: one number */
  PetscInt    first;
} MpmRow;

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
