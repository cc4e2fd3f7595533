#pragma once
/*
  The run: reading of scenes, results, progress, checkpoints.
*/
#include "base/types.h"
#include "options/database.h"
#include "io/io.h"
#include "query/model.h"
#include "run/lines.h"
#include "run/manual.h"
#include "run/signals.h"
#include "run/tracks.h"

/* ---- checkpoint.c, restart.c, run_state.c ---- */

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
  MpmRestart  restart; /* NULL: the run starts at the beginning */
} MpmCheckpoint;

/* The model's numbers by name, as they stand in a checkpoint (run_state.c). */
typedef struct {
  PetscInt    count;
  char      **name;
  PetscBool  *real, *there; /* a real number or an integer; is it in the checkpoint? */
  PetscReal  *value;
  PetscInt64 *number;
} MpmScalars;
PetscErrorCode MpmScalarsCreate(MpmModel model, MpmScalars *scalars);
/* Those whose names begin so. */
PetscErrorCode MpmScalarsRestore(const MpmScalars *scalars, const char *begin, MpmModel model);
PetscErrorCode MpmScalarsDestroy(MpmScalars *scalars);

PetscErrorCode MpmCheckpointSetFromOptions(MpmModel model, const MpmOptions *options);
/* The text of all options that define the scene and must be the same when a run goes on, a line each; or of those given. */
PetscErrorCode MpmCheckpointScene(MpmModel model, PetscBool given, MpmTextFile *scene);
/* Keeps the options that continue the run, before presets have added theirs. */
PetscErrorCode MpmCheckpointKeepOptions(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmCheckpointWrite(MpmModel model);
/* To be called after each step: writes what is due; `stop`: a signal asks for the end of the run. */
PetscErrorCode MpmCheckpointStep(MpmModel model, PetscBool *stop);
PetscErrorCode MpmCheckpointDestroy(MpmCheckpoint *checkpoint);

/*
  Restarting, in this order: Open finds the checkpoint and checks it against the scene, ReadPoints fills the particles in
  place of the bodies, Apply sets the model's numbers once the solver is chosen, Results takes up the result files.
*/
PetscErrorCode MpmRestartOpen(MpmModel model);
PetscErrorCode MpmRestartReadPoints(MpmModel model);
PetscErrorCode MpmRestartApply(MpmModel model);
/* The history (number 0) or a file of the lines. */
PetscErrorCode MpmRestartTable(MpmModel model, const char *path, PetscInt number, PetscInt columns,
                               const char *const names[], MpmHistory *table);
/* Without `apply` it only looks whether the file can be continued. */
PetscErrorCode MpmRestartOutput(MpmModel model, PetscBool apply);
PetscErrorCode MpmRestartDestroy(MpmRestart *restart);

/* ---- progress.c ---- */

/* What the line of a step needs to know of the steps before. */
typedef struct {
  PetscLogDouble since;             /* the end of the step before */
  PetscReal      seconds, progress; /* wall time and time of the run, fading */
  PetscInt       lines;
} MpmTerminal;

/* Does the model show its progress? Not with -mpm_quiet, and not unless its caller wants it. */
PetscBool MpmTerminalShows(const MpmModel model);
/* A line on stderr, behind the program's name; with -mpm_quiet, too. */
PetscErrorCode MpmTerminalWarn(MpmModel model, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
/* Header, line of a step, and a line between two steps. */
PetscErrorCode MpmTerminalBegin(MpmModel model);
PetscErrorCode MpmTerminalStep(MpmModel model, PetscReal dt);
/* The table of where the time went, and the sizes, for the terminal. */
PetscErrorCode MpmTerminalSummary(MPI_Comm comm, const MpmSummary *summary);
/* The listener to the model's monitor. */
PetscErrorCode MpmTerminalMessage(void *model, PetscBool line, const char text[]);
/* "0:02:05", "4 d 4 h" */
#define MPM_DURATION_TEXT 32
void MpmTerminalDuration(PetscReal seconds, char text[MPM_DURATION_TEXT]);

/* The points' fields that the scene asks for (point_fields.c): do they exist? Into the output. */
PetscErrorCode MpmFieldsCheck(MpmModel model);
PetscErrorCode MpmFieldsWrite(MpmModel model);
/* Active nodes and cells into the output (grid_fields.c). */
PetscErrorCode MpmLatticeWrite(MpmModel model);
struct MpmResults {
  PetscInt      output_every;
  PetscInt      output_step; /* of the last written state */
  PetscBool     output_grid, output_single;
  PetscInt      output_field_count; /* 0: all */
  char        **output_fields;
  MpmOutput     output;
  MpmHistory    history;
  PetscReal    *history_row;
  PetscInt      history_columns;
  PetscReal     start;
  PetscBool     quiet;
  MpmTracks     tracks;
  MpmLines      lines;
  MpmCheckpoint checkpoint;
  MpmTerminal   terminal;
};

/*
  A call that must not be entered again while it is at work, with the model's options in force; both end with it, also
  where it fails.
*/
PetscErrorCode MpmModelEnter(MpmModel model);
PetscErrorCode MpmModelLeave(MpmModel model);
#define MpmModelCall(model, call) \
  do { \
    PetscErrorCode model_error; \
    PetscCall(MpmModelEnter(model)); \
    model_error = (call); \
    PetscCall(MpmModelLeave(model)); \
    PetscCall(model_error); \
  } while (0)

/* Results (results.c). */
PetscErrorCode MpmOutputSetFromOptions(MpmModel model, const MpmOptions *block);
PetscErrorCode MpmModelWriteState(MpmModel model); /* the points */
PetscErrorCode MpmModelWriteGrid(MpmModel model);  /* where it is wanted */
PetscErrorCode MpmModelCreateHistory(MpmModel model);
PetscErrorCode MpmModelWriteHistory(MpmModel model, PetscReal dt);
PetscErrorCode MpmModelWriteSummary(MpmModel model, const char *status);
/*
  Bodies side by side (body_overlap.c): points on edges that two of them share are made once; and a scene in which two
  overlap that are there at the same time is refused, once the points are with their ranks.
*/
PetscErrorCode MpmBodiesShareEdges(MpmModel model);
PetscErrorCode MpmBodiesCheckOverlap(MpmModel model);
/* A line of the run's header where bodies share nodes (welds.c). */
PetscErrorCode MpmWeldsPrint(MpmModel model);
/* Does the pressure bound what acts along a surface that may part? Where it sticks, the strength of a material may do so instead. */
PetscBool MpmPressureBounds(const MpmModel model, PetscReal friction, PetscBool stick);
/* Contacts of bodies with one another, and the parts of the material that they make (contacts_read.c); is there water? */
PetscErrorCode MpmContactsRead(MpmModel model, PetscBool water, const MpmOptions *options);
/* Before points are made: which way is up, and which bodies join a stage. */
PetscErrorCode MpmBodiesPrepare(MpmModel model);
/* What points start with beside what their bodies give: the physics' own states, and parts of the material (point_start.c). */
PetscErrorCode MpmFillOwnStates(MpmModel model);
/* The file of a body, with what the physics keeps of a point; and that into the points, once they have all else. */
PetscErrorCode MpmReadBodyFile(MpmModel model, const MpmOptions *options, PetscInt b);
PetscErrorCode MpmFillFromFiles(MpmModel model);
PetscErrorCode MpmFillParts(MpmModel model);
/* Makes the points, hands them to their ranks, and finds those that carry loads and are tracked. */
PetscErrorCode MpmPointsCreate(MpmModel model);
/* Numbers of the row of parameters that each point has; 0: no material varies. Sets the materials' strides. */
PetscInt MpmOwnParametersSize(MpmModel model);
/* Do points keep their places in the initial state, beside those where displacements began anew? */
PetscBool MpmOriginIsKept(const MpmModel model);
/*
  Surfaces of bodies (surfaces_read.c): their blocks, behind the boundaries'; which points are those of their bodies, once they are there;
  and their part in the discretization, once that is set up.
*/
PetscErrorCode MpmSurfacesRead(MpmModel model, const MpmOptions *options);
void           MpmSurfacesSetBodies(MpmModel model);
PetscErrorCode MpmSurfacesAdd(MpmModel model);
/* Lines on faces of surfaces on all sides that are left out in the stage that begins. Collective. */
PetscErrorCode MpmSurfacesTellHeld(MpmModel model);
/*
  Ghost penalty and F-bar (stabilization.c): Read takes the options, Settle makes the choice of `auto` once materials,
  bodies, conditions and stages are known.
*/
PetscErrorCode MpmStabilizationRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmStabilizationSettle(MpmModel model);
PetscErrorCode MpmStabilizationText(const MpmModel model, size_t length, char text[]);

/* ---- view.c ---- */

/* Views the model where -mpm_view says so. */
PetscErrorCode MpmModelViewFromOptions(MpmModel model);
