#pragma once
/*
  Numbers that a program adds to a model, each from a file of its own: columns of the history, fields of the points in
  the results, and numbers that checkpoints hold. The engine's own are registered as the same rows.

  All are added between MpmModelCreate() and MpmModelSetFromOptions(). Names, and the rows' other pointers, are borrowed
  until MpmModelDestroy().
*/
#include "talus/talus.h"

/* One column of the history, or several that one function evaluates. */
typedef struct MpmColumn MpmColumn;
struct MpmColumn {
  const char *name; /* of the column; of several, head of the names <name>_<part>; NULL: the names are the parts */
  const char *unit;
  PetscInt    count; /* of columns with parts; 0: one column, without */
  const char *const *parts;
  /* Values after a step, equal on all ranks. Collective. */
  PetscErrorCode (*fill)(MpmModel model, const MpmColumn *column, PetscReal values[]);
  void    *ctx;
  PetscInt index; /* for fill, beside ctx */
};

/* A field of the points in <prefix>.h5 and <prefix>.xdmf, or a choice of -mpm_output_fields. */
typedef struct MpmPointColumn MpmPointColumn;
struct MpmPointColumn {
  const char *name, *unit;
  PetscInt    components; /* 6: a symmetric tensor, xx, yy, zz, xy, yz, xz */
  /* Components of this rank's points, in their present order, when a state is written. Collective. */
  PetscErrorCode (*fill)(MpmModel model, const MpmPointColumn *column, PetscReal values[]);
  void    *ctx;
  PetscInt index; /* for fill, beside ctx */
};

typedef enum { MPM_ROW_REAL, MPM_ROW_INT, MPM_ROW_INT64, MPM_ROW_BOOL } MpmRowKind;

typedef enum {
  MPM_ROW_RUN,  /* account or setting of the run, which goes on where steps are taken back */
  MPM_ROW_STATE /* state at a time, which returns with the points */
} MpmRowUse;

/* A number of a checkpoint, or an array of one kind: PetscReal, PetscInt, PetscInt64 or PetscBool. */
typedef struct {
  const char *name; /* in checkpoints, unchanged from version to version */
  MpmRowKind  kind;
  MpmRowUse   use;
  void       *address; /* fixed while the rows live; equal on all ranks when a checkpoint is written */
  PetscInt    count; /* length of an array, whose numbers are <name>_<first>, <name>_<first + 1>, ...; 0: one number */
  PetscInt    first;
} MpmRow;

#pragma GCC visibility push(default)

/*@
  MpmModelAddColumn - adds a column, or several, to the history

  Not collective, but all ranks must add the same

  Input Parameter:
. column - the row, which is copied. Its columns follow those of the scene, in the order of the calls

  Notes:
  `fill` is called once a step, after hooks, and may ask for points, reactions and time. A restart needs the columns of
  the run that it continues. Fails with PETSC_ERR_ARG_OUTOFRANGE, when the history is created, where there is another
  column of the name.
@*/
PetscErrorCode MpmModelAddColumn(MpmModel model, const MpmColumn *column);

/*@
  MpmModelAddPointColumn - adds a field of the points to the results

  Not collective, but all ranks must add the same

  Input Parameter:
. column - the row, which is copied

  Notes:
  Points are lent to `fill` by MpmModelGetPoints(). Fails with PETSC_ERR_ARG_OUTOFRANGE, in MpmModelSetFromOptions(),
  where there is another field of the name.
@*/
PetscErrorCode MpmModelAddPointColumn(MpmModel model, const MpmPointColumn *column);

/*@
  MpmModelAddRow - adds a number, or an array of numbers, to the checkpoints

  Not collective, but all ranks must add the same

  Input Parameter:
. row - the row, which is copied

  Notes:
  Checkpoints hold it as user_<name>. A restart, on any number of ranks, sets it on all of them in MpmModelSetUp(); a
  checkpoint without it leaves the value as it is. Fails with PETSC_ERR_ARG_OUTOFRANGE where another row of the program
  has the name.
@*/
PetscErrorCode MpmModelAddRow(MpmModel model, const MpmRow *row);

#pragma GCC visibility pop
