#pragma once
/*
  What a run leaves behind: points in HDF5 with an XDMF index, the history as CSV, the account of the run as JSON. These
  objects know nothing of the model: they are handed names and arrays.
*/
#include <petscsys.h>
#include "mpmcompat.h"

typedef struct _p_MpmOutput  *MpmOutput;
typedef struct _p_MpmHistory *MpmHistory;

/*
  One dataset: `count` rows on this rank (given to MpmOutputWrite) of `components` numbers each. They stand in `real` or
  `integer`, or `fill` makes them when they are written, so that not all datasets need memory at once. On a rank without
  rows the arrays may be NULL. Six reals are a symmetric tensor: xx, yy, zz, xy, yz, xz.
*/
typedef struct {
  const char      *name;
  PetscInt         components;
  const PetscReal *real;
  const PetscInt  *integer;
  PetscErrorCode (*fill)(const void *ctx, PetscReal values[]);
  const void *ctx;
} MpmDataset;

/* Rows of one kind, as MpmOutputWrite takes them. */
typedef struct {
  PetscInt          count;
  const PetscInt   *id;
  PetscInt          dataset_count;
  const MpmDataset *datasets;
} MpmTable;

/*
  MpmOutputCreate - the writer of <prefix>.h5 and <prefix>.xdmf; creates no file yet

  MpmOutputWrite - append the group /points/<step, six digits> with attributes time and step

  Input Parameters:
+ count    - local points, may be 0 on any rank
. id       - their ids; over all ranks each of 0 .. N-1 exactly once; row i of each dataset belongs to id i
. datasets - what is written besides id; a dataset called position must be among them (XDMF geometry, 2 or 3 components)
- dataset_count

  MpmOutputWriteGrid - append the groups /grid/<step, six digits>/nodes and /cells, likewise

  Input Parameters:
+ nodes - with a dataset called position
- cells - with a dataset of integers called nodes: the ids of each cell's 4 or 8 nodes, in XDMF's order

  The index then holds the grid as a second collection, and <prefix>_grid.xdmf holds it alone, for programs that read
  one mesh a file.

  Collective. The first write truncates the files. A write that fails ends with PETSC_ERR_FILE_WRITE and one line naming
  the file.

  XDMF wants symmetric tensors in another order, xx, xy, xz, yy, yz, zz. It is given virtual datasets of that order, in
  the group /tensors, which take no room: they refer to the columns of the real ones.
*/
PetscErrorCode MpmOutputCreate(MPI_Comm comm, const char *prefix, MpmOutput *output);
PetscErrorCode MpmOutputWrite(MpmOutput output, PetscInt step, PetscReal time, PetscInt count, const PetscInt id[],
                              PetscInt dataset_count, const MpmDataset datasets[]);
PetscErrorCode MpmOutputWriteGrid(MpmOutput output, PetscInt step, PetscReal time, const MpmTable *nodes,
                                  const MpmTable *cells);
/* Reals in single precision. */
PetscErrorCode MpmOutputSetSingle(MpmOutput output, PetscBool single);
/* States of at least so many bytes (64 MiB unless told) are written by all ranks together, smaller ones by rank 0. */
PetscErrorCode MpmOutputSetCollective(MpmOutput output, PetscInt64 bytes);
/* No rank hands more bytes than this (1 GiB unless told) to HDF5 at once: MPI-IO fails at 2 GiB. */
PetscErrorCode MpmOutputSetSlab(MpmOutput output, PetscInt64 bytes);
PetscErrorCode MpmOutputDestroy(MpmOutput *output);

/* The CSV writer: header at once, then one row a call, flushed; rank 0 writes. All values with 17 significant digits,
   integers plain. */
PetscErrorCode MpmHistoryCreate(MPI_Comm comm, const char *path, PetscInt columns, const char *const names[],
                                MpmHistory *history);
PetscErrorCode MpmHistoryAppend(MpmHistory history, const PetscReal values[]);
PetscErrorCode MpmHistoryDestroy(MpmHistory *history);

/* Where wall time went, s (maximum over ranks). */
typedef enum {
  MPM_TIME_SETUP,
  MPM_TIME_TRANSFER,
  MPM_TIME_RESIDUAL,
  MPM_TIME_JACOBIAN,
  MPM_TIME_SOLVE,
  MPM_TIME_MIGRATE,
  MPM_TIME_OUTPUT,
  MPM_TIME_COUNT
} MpmTimer;
extern const char *const MpmTimers[];

/* The account of a run; written as <prefix>_summary.json. */
typedef struct {
  const char *status; /* "completed" or the reason */
  PetscInt    dim;
  const char *title, *physics, *shape, *jacobian, *solver;
  PetscInt64  points, cells, active_dofs_max;
  PetscInt    steps, step_cuts;
  PetscInt64  newton_iterations, linear_iterations;
  PetscReal   time_total, time[MPM_TIME_COUNT];
  PetscReal   imbalance;  /* points on the fullest rank over their mean, the most of any step */
  PetscInt    rebalances; /* how often the partition has moved */
  PetscReal   memory_max; /* bytes, sum over ranks of each rank's maximum resident size */
} MpmSummary;

/* Makes one account of the ranks' own: times become the maximum over ranks, memory_max the sum of the processes'
   resident maxima as the
   system has them now. Collective. */
PetscErrorCode MpmSummaryReduce(MPI_Comm comm, MpmSummary *summary);
/* Rank 0 writes; keys: status, version, title, ranks, dim, physics, shape, jacobian, solver, points, cells,
   active_dofs_max, steps,
   step_cuts, newton_iterations, linear_iterations, imbalance, rebalances, time_total_s, time {setup, ...},
   memory_max_bytes. */
PetscErrorCode MpmSummaryWrite(MPI_Comm comm, const char *path, const char *version, const MpmSummary *summary);
/* The table of where the time went, and the sizes, for the terminal. */
PetscErrorCode MpmSummaryPrint(MPI_Comm comm, const MpmSummary *summary);
