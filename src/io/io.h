#pragma once
/*
  Results of a run: points in HDF5 with an XDMF index and a VTKHDF file, the history as CSV, the summary as JSON. These
  objects are independent of the model: their arguments are names and arrays.
*/
#include "base/base.h"
#include "base/types.h"

typedef struct _p_MpmOutput  *MpmOutput;
typedef struct _p_MpmHistory *MpmHistory;

/*
  One dataset: `count` rows on this rank (passed to MpmOutputWrite) of `components` numbers each, in `real` or
  `integer`, or made by `fill` when they are written, so that not all datasets need memory at once. On a rank without
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

/* A number at a group; exactly one of the pointers is set. */
typedef struct {
  const char       *name;
  const PetscReal  *real;
  const PetscInt64 *integer;
} MpmAttribute;

/* A dataset of bytes; the size is known to all ranks, the data are rank 0's. */
typedef struct {
  const char *name;
  size_t      size;
  const void *data;
} MpmBytes;

/* File of a state, and datasets beside the rows of its points. */
typedef struct {
  const char         *path, *group;
  PetscBool           append;     /* to the file, which exists; otherwise a new one is made */
  PetscInt64          head;       /* bytes before HDF5's own in a new file: 0 or a power of two from 512 */
  PetscInt64          collective; /* bytes from which on all ranks write together */
  PetscInt            attribute_count;
  const MpmAttribute *attributes;
  PetscInt            bytes_count;
  const MpmBytes     *bytes;
  PetscBool           single;   /* reals in single precision */
  PetscBool           vertices; /* an index shows the rows as cells: their numbers are written, too */
  PetscInt64          slab;     /* most bytes a rank hands to HDF5 at once; 0: MPM_STATE_SLAB */
} MpmStateFile;
#define MPM_STATE_SLAB (1 << 30)

/* Rows of one kind. */
typedef struct {
  PetscInt          count; /* on this rank, may be 0 */
  const PetscInt   *id;    /* >= 0 and no two alike over all ranks; the rows of each dataset go by ascending id */
  PetscInt          dataset_count;
  const MpmDataset *datasets; /* datasets besides id */
} MpmTable;

/* A state as an index describes it. */
#define MPM_STATE_PATH 128
typedef struct {
  PetscInt64 rows;                    /* over all ranks */
  size_t     real_size;               /* bytes of a real */
  PetscBool *integer;                 /* of each dataset: true for integers, false for reals; to be freed */
  char       numbers[MPM_STATE_PATH]; /* of vertices: path of a column of the numbers of the rows, 0, 1, ... */
} MpmStateView;

/*
  MpmStateWrite - write one state as a group of an HDF5 file, rows ordered by id

  Output Parameter:
. view - or NULL, for a file that is not viewed

  Collective. A write that fails ends with PETSC_ERR_FILE_WRITE and one line naming the file.

  Viewers get symmetric tensors with all nine components, by virtual datasets in the group /tensors, which take no room:
  they refer to the columns of the real ones. A point is a cell whose corner is its row. Where ids are not 0, 1, ...
  (bodies have been removed) the numbers of the rows stand in /rows/<number of rows>, once for all states with as many.
*/
PetscErrorCode MpmStateWrite(MPI_Comm comm, const MpmStateFile *state, const MpmTable *table, MpmStateView *view);

/*
  Rows go by ascending id: row[i] becomes the number of ids below id[i], over all ranks; `largest` is the largest of
  all, 0 where there is none. Collective.
*/
PetscErrorCode MpmNumberRows(MPI_Comm comm, PetscInt count, const PetscInt id[], PetscInt row[], PetscInt *largest);

/*
  MpmOutputCreate - the writer of <prefix>.h5, <prefix>.xdmf and <prefix>.vtkhdf; creates no file yet

  MpmOutputWrite - append the group /points/<step, six digits> with attributes time and step

  Input Parameters:
+ count    - local points, may be 0 on any rank
. id       - their ids, >= 0 and no two alike over all ranks; the rows of each dataset go by ascending id
. datasets - what is written besides id; a dataset called position must be among them (XDMF geometry, 2 or 3 components)
- dataset_count

  MpmOutputWriteGrid - append the groups /grid/<step, six digits>/nodes and /cells, likewise

  Input Parameters:
+ nodes - with a dataset called position
- cells - with a dataset of integers called nodes: the ids of each cell's 4 or 8 nodes, in XDMF's order

  The index then holds the grid as a second collection, and <prefix>_grid.xdmf holds it alone, for programs that read
  one mesh a file.

  MpmOutputFinish - write <prefix>.vtkhdf, all states of the points for VTK, by reference into <prefix>.h5

  Collective. The first write truncates the files, and removes a <prefix>.vtkhdf of an earlier run. A write that fails
  ends with PETSC_ERR_FILE_WRITE and one line naming the file.
*/
PetscErrorCode MpmOutputCreate(MPI_Comm comm, const char *prefix, MpmOutput *output);
PetscErrorCode MpmOutputWrite(MpmOutput output, PetscInt step, PetscReal time, PetscInt count, const PetscInt id[],
                              PetscInt dataset_count, const MpmDataset datasets[]);
PetscErrorCode MpmOutputWriteGrid(MpmOutput output, PetscInt step, PetscReal time, const MpmTable *nodes,
                                  const MpmTable *cells);
PetscErrorCode MpmOutputFinish(MpmOutput output);
/* Further states get the attribute velocities_behind, s, unless it is 0. */
PetscErrorCode MpmOutputSetBehind(MpmOutput output, PetscReal behind);
/* Reals in single precision. */
PetscErrorCode MpmOutputSetSingle(MpmOutput output, PetscBool single);
/* An index for each further state too, <prefix>_<step, six digits>.xdmf and <prefix>_grid_<step>.xdmf. */
PetscErrorCode MpmOutputSetStateFiles(MpmOutput output, const char *prefix);
/* States of at least so many bytes (default 64 MiB) are written by all ranks together, smaller ones by rank 0. */
PetscErrorCode MpmOutputSetCollective(MpmOutput output, PetscInt64 bytes);
/* True where the results file exists. */
PetscBool MpmOutputStarted(MpmOutput output);
/* Lends the name of the HDF5 file, and the indices of points and grids so far, which rank 0 holds. */
PetscErrorCode MpmOutputGetFiles(MpmOutput output, const char **h5_path, const MpmTextFile **index,
                                 const MpmTextFile **grid_index);
/* Appends further states to an existing results file; the indices (rank 0) are those so far, or NULL. Collective. */
PetscErrorCode MpmOutputContinue(MpmOutput output, const char *index, const char *grid_index);

/* No rank passes more bytes than this (default 1 GiB) to HDF5 at once: MPI-IO fails at 2 GiB. */
PetscErrorCode MpmOutputSetSlab(MpmOutput output, PetscInt64 bytes);
PetscErrorCode MpmOutputDestroy(MpmOutput *output);

/*
  A mark: what a results file was at some time, to which it can be rolled back whatever has been appended since,
  even where a killed run has left it inconsistent (rollback.c). The mark holds every byte of the file but the points'
  numbers, which stand still once they are written. Rank 0 holds it; empty for a file that does not exist.
*/
PetscErrorCode MpmMarkSet(MPI_Comm comm, const char *path, MpmTextFile *mark);
/*
  Without `apply` only the possibility is checked. Failure: the file cannot be rolled back; `there`: the file
  exists.
*/
PetscErrorCode MpmMarkReturn(MPI_Comm comm, const char *path, const MpmTextFile *mark, PetscBool apply,
                             PetscBool *there, MpmOutcome *outcome);

/* The CSV writer: header at once, then one row a call, flushed; rank 0 writes. All values with 17 significant digits,
   integers plain. */
PetscErrorCode MpmHistoryCreate(MPI_Comm comm, const char *path, PetscInt columns, const char *const names[],
                                MpmHistory *history);
/*
  Place in a history: its bytes and their hash, on rank 0. The file is on the disk when MpmHistoryMark() returns.
  MpmHistoryContinue() opens an existing file, drops rows appended since, and continues; without a file it makes one.
  Failure: the file is not what it was at that place.
*/
typedef struct {
  PetscInt64 length, hash;
} MpmHistoryPlace;
PetscErrorCode MpmHistoryMark(MpmHistory history, MpmHistoryPlace *place);
PetscErrorCode MpmHistoryContinue(MPI_Comm comm, const char *path, PetscInt columns, const char *const names[],
                                  const MpmHistoryPlace *place, MpmHistory *history, MpmOutcome *outcome);
PetscErrorCode MpmHistoryAppend(MpmHistory history, const PetscReal values[]);
PetscErrorCode MpmHistoryDestroy(MpmHistory *history);

/* The account of a run; written as <prefix>_summary.json. */
typedef struct MpmSummary {
  const char *status; /* "completed" or the reason */
  PetscInt    dim;
  struct {
    const char *title, *physics, *shape;
  } scene;
  struct {
    const char *jacobian, *solver;
  } solution;
  PetscInt64 points, cells, active_dofs_max;
  struct {
    PetscInt   steps, step_cuts;
    PetscInt64 newton_iterations, linear_iterations;
    PetscInt   levels; /* of multigrid on lattices, 0: another solver */
  } effort;
  PetscReal time_total, time[MPM_TIME_COUNT];
  PetscReal imbalance;        /* points on the fullest rank over their mean, the most of any step */
  PetscInt  rebalances;       /* how often the partition has moved */
  PetscBool reduces;          /* strength */
  PetscReal factor_of_safety; /* 0: not reached */
  PetscBool relaxes;
  PetscReal
    criteria[2]; /* of the last relaxation: times when its criteria were met first, and since when; s, -1: never */
  struct {
    PetscInt         count; /* of parameters; 0: none are asked for */
    char *const     *names;
    const char     **methods;
    const PetscReal *values, *errors; /* derivatives of the objective, and their estimated errors */
    PetscReal        objective;
    const char      *inverse; /* JSON; NULL: the task is no inverse analysis */
    const char      *fields;  /* entries of derivatives by fields, or NULL */
  } derivatives;
  const char *terrain;                   /* lines of flow over terrain, or NULL */
  PetscInt    changes[MPM_CHANGE_COUNT]; /* of settings that the run has made by itself */
  PetscReal   memory_max;                /* bytes, sum over ranks of each rank's maximum resident size */
} MpmSummary;

/* Largest resident size of this process so far, bytes. */
PetscReal MpmProcessMemory(void);
/* Makes one account of the ranks' own: times become the maximum over ranks, memory_max the sum of the processes'
   resident maxima as the
   system has them now. Collective. */
PetscErrorCode MpmSummaryReduce(MPI_Comm comm, MpmSummary *summary);
/* Rank 0 writes; keys: status, version, title, ranks, dim, physics, shape, jacobian, solver, points, cells,
   active_dofs_max, steps, step_cuts, newton_iterations, linear_iterations, imbalance, rebalances, time_total_s,
   time {setup, ...}, memory_max_bytes; with multigrid on lattices iterations_multigrid and levels; where strength is
   reduced factor_of_safety, or null; where a stage relaxes criteria_first and criteria_since, or null. */
PetscErrorCode MpmSummaryWrite(MPI_Comm comm, const char *path, const char *version, const MpmSummary *summary);

/* ---- folder.c ---- */

/* True where the folder of a prefix is there, or can be made, and takes files, as rank 0 sees it. Collective. */
PetscErrorCode MpmFolderCheck(MPI_Comm comm, const char prefix[], PetscBool *there);
/* Makes the folder of a prefix, with those above it, on rank 0; fails with PETSC_ERR_FILE_WRITE. Collective. */
PetscErrorCode MpmFolderMake(MPI_Comm comm, const char prefix[]);

/* ---- checkpoint_file.c ---- */

/*
  The files of checkpoints: <prefix>_checkpoint.h5 is the newest, older ones that are kept carry the number of their
  step.

  A checkpoint is an HDF5 file behind a head of 512 bytes of text: format, length, and the hash of every byte. Nothing
  of the file is trusted, and HDF5 does not see it, before that hash has been computed again.
*/

#define MPM_CHECKPOINT_FORMAT 2
#define MPM_CHECKPOINT_HEAD   512

typedef struct {
  long long format, step, size; /* size: bytes in all */
  long long run;                /* identifies a run; restarts belong to their run */
  uint64_t  hash;
} MpmCheckpointHead;

/*
  Completes a file that MpmStateWrite() has made: writes the head, brings it to the disk and gives it its name; what had
  this name is kept under the number of its step, and those beyond the newest `keep` of this run are removed. All ranks
  read the file where it has at least `collective` bytes. Collective; fails with PETSC_ERR_FILE_WRITE and one line.
*/
PetscErrorCode MpmCheckpointPublish(MPI_Comm comm, const char *prefix, const char *temporary, MpmCheckpointHead *head,
                                    PetscInt keep, PetscInt64 collective);
/* Failure: it is not whole, or not of this format. Collective. */
PetscErrorCode MpmCheckpointVerify(MPI_Comm comm, const char *path, PetscInt64 collective, MpmCheckpointHead *head,
                                   MpmOutcome *outcome);
/* The checkpoints of a prefix, the newest first. Collective; free with MpmNamesDestroy(). */
PetscErrorCode MpmCheckpointList(MPI_Comm comm, const char *prefix, PetscInt *count, char ***paths);
