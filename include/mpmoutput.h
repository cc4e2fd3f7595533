#pragma once
/*
  What a run leaves behind: points in HDF5 with an XDMF index, the history as CSV, the account of the run as JSON. These
  objects know nothing of the model: they are handed names and arrays.
*/
#include <petscsys.h>
#include "mpmcompat.h"

typedef struct _p_MpmOutput  *MpmOutput;
typedef struct _p_MpmHistory *MpmHistory;

/* One dataset: `count` rows on this rank (given to MpmOutputWrite) of `components` numbers each. Exactly one of the
   pointers is set; on a rank without rows it may be NULL too. */
typedef struct {
  const char      *name;
  PetscInt         components;
  const PetscReal *real;
  const PetscInt  *integer;
} MpmDataset;

/*
  MpmOutputCreate - the writer of <prefix>.h5 and <prefix>.xdmf; creates no file yet

  MpmOutputWrite - append the group /points/<step, six digits> with attributes time and step

  Input Parameters:
+ count    - local points, may be 0 on any rank
. id       - their ids; over all ranks each of 0 .. N-1 exactly once; row i of each dataset belongs to id i
. datasets - what is written besides id; a dataset called position must be among them (XDMF geometry, 2 or 3 components)
- dataset_count

  Collective. The first call truncates the files. A write that fails ends with PETSC_ERR_FILE_WRITE and one line naming
  the file.
*/
PetscErrorCode MpmOutputCreate(MPI_Comm comm, const char *prefix, MpmOutput *output);
PetscErrorCode MpmOutputWrite(MpmOutput output, PetscInt step, PetscReal time, PetscInt count, const PetscInt id[],
                              PetscInt dataset_count, const MpmDataset datasets[]);
/* States of at least so many bytes (64 MiB unless told) are written by all ranks together, smaller ones by rank 0. */
PetscErrorCode MpmOutputSetCollective(MpmOutput output, PetscInt64 bytes);
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
