#pragma once
/*
  Results and progress of a run, and the numbers that checkpoints need of them.
*/
#include "base/columns.h"
#include "base/types.h"
#include "options/database.h"
#include "io/io.h"
#include "query/model.h"
#include "observe/lines.h"
#include "observe/point_columns.h"
#include "observe/tracks.h"

/* The checkpoint that a run restarts from (restart.c). */
typedef struct _p_MpmRestart *MpmRestart;

/* When checkpoints are written, and the one that the run has started from. */
typedef struct {
  PetscInt    every, keep;
  PetscReal   wall;       /* s between them, 0: not by wall time */
  PetscReal   collective; /* bytes from which all ranks read and write together */
  char       *from;       /* the option -mpm_restart, or NULL */
  PetscInt64  run;        /* a number of its own for each run; it stays the same over restarts */
  PetscInt    step;       /* of the last one, -1: none yet */
  PetscReal   since;      /* wall time of the last one, or of the start */
  MpmTextFile options;    /* rank 0: those that continue the run */
  PetscBool   options_written;
  MpmRestart  restart;          /* NULL: the run starts at the beginning */
  const char *path, *histories; /* of that, borrowed: its file, and where tables stood */
} MpmCheckpoint;

/* ---- progress.c ---- */

typedef enum { MPM_STEP_GEOSTATIC, MPM_STEP_EXPLICIT, MPM_STEP_IMPLICIT, MPM_STEP_KINDS } MpmStepKind;

/* Steps of a kind: how many there were, and a mean that forgets as two sums. */
typedef struct {
  PetscInt  count;
  PetscReal seconds, steps;
} MpmStepCost;

/* Costs of steps by kind, and their growth (time_left.c). */
typedef struct {
  MpmStepCost cost[MPM_STEP_KINDS];
  PetscReal   explicit_step; /* s, of the last explicit step; 0: none yet */
  PetscReal   growth;        /* logarithm of the ratio of a step to the one before, in the mean */
  PetscReal   last;          /* s, length of the last step */
  PetscInt    stage;         /* the one that they are of, from 1 on; 0: none yet */
} MpmTimeLeft;

/* Wall time, s, that the run still needs after a step of length dt that took so many seconds. */
PetscReal MpmTimeLeftAfter(const MpmModel model, PetscReal dt, PetscReal seconds);

/* Data of earlier steps for a step's line. */
typedef struct {
  PetscLogDouble since, shown; /* the end of the step before, and that of the last line */
  MpmTimeLeft    left;
  PetscInt       lines;
} MpmTerminal;

/* True where the model shows its progress: not with -mpm_quiet, and only at its caller's request. */
PetscBool MpmTerminalShows(const MpmModel model);
/* A line on stderr, behind the program's name; with -mpm_quiet, too. */
PetscErrorCode MpmTerminalWarn(MpmModel model, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
/* Header, with a line on `what` is run unless that is NULL: a scene on a grid; line of a step, and a line between two
   steps. */
PetscErrorCode MpmTerminalBegin(MpmModel model, const char *what);
PetscErrorCode MpmTerminalStep(MpmModel model, PetscReal dt);
/* The last line of a run that a signal has ended. */
PetscErrorCode MpmTerminalInterrupted(MpmModel model);
/* The table of where the time went, and the sizes, for the terminal. */
PetscErrorCode MpmTerminalSummary(MPI_Comm comm, const MpmSummary *summary);
/* The listener to the model's monitor. */
PetscErrorCode MpmTerminalMessage(void *model, PetscBool line, const char text[]);
/* "0:02:05", "4 d 4 h" */
#define MPM_DURATION_TEXT 32
void MpmTerminalDuration(PetscReal seconds, char text[MPM_DURATION_TEXT]);

/* ---- results ---- */

/* Active nodes and cells into the output (grid_fields.c). */
PetscErrorCode MpmLatticeWrite(MpmModel model);
/* Written states of the points and of the grid. */
typedef struct {
  PetscInt        every; /* steps between them; 0: none */
  PetscInt        step;  /* of the last written state */
  PetscBool       grid, single;
  PetscBool       alone;        /* an index for each state, too */
  PetscInt        chosen_count; /* 0: all fields */
  char          **chosen;
  PetscInt        derived_count; /* fields on request, beside the chosen ones */
  char          **derived;
  MpmPointColumns fields; /* among which the scene chooses */
  MpmOutput       file;
  PetscBool       air; /* points of air are written, too */
} MpmWrittenStates;

/* Rows of the library's caller. */
typedef struct {
  MpmColumns      columns;
  MpmPointColumns fields;
} MpmAdded;

/* Derivatives of a number of the run, for the summary; `count` 0: none were asked for. */
typedef struct {
  PetscInt     count;
  char       **names;             /* of the parameters, borrowed */
  const char **methods;           /* how each was found */
  PetscReal   *gradient, *errors; /* errors: of differences, as estimated; 0 in closed form */
  PetscReal   *tangent;           /* by the other method, where both are compared; or NULL */
  PetscReal    objective;
  char        *fields;  /* of the summary: entries of derivatives by fields, or NULL */
  const char  *inverse; /* results of an inverse analysis as JSON, borrowed, or NULL */
} MpmDerivatives;

struct MpmResults {
  MpmWrittenStates states;
  MpmHistory       history;
  PetscInt         history_every; /* steps between its rows */
  PetscInt         history_step;  /* of its last row */
  MpmColumns       columns;       /* of the history */
  PetscReal       *history_row;
  PetscReal        dt; /* s, of the last step */
  MpmAdded         added;
  PetscReal        start;
  PetscBool        quiet, signature; /* signature: of each step, into the history */
  MpmTracks        tracks;
  MpmLines         lines;
  MpmCheckpoint    checkpoint;
  MpmTerminal      terminal;
  MpmDerivatives   derivatives;
};

/* Results (results.c). Destroy leaves the checkpoint. */
PetscErrorCode MpmResultsDestroy(MpmModel model);
PetscErrorCode MpmOutputSetFromOptions(MpmModel model, const MpmOptions *block);
PetscErrorCode MpmModelWriteState(MpmModel model); /* the points */
PetscErrorCode MpmModelWriteGrid(MpmModel model);  /* where the scene has it */
PetscErrorCode MpmModelWriteSummary(MpmModel model, const char *status);
/* A line of the run's header where bodies share nodes (welds.c). */
PetscErrorCode MpmWeldsPrint(MpmModel model);
