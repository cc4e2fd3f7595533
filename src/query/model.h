#pragma once
/*
  A model and its parts: the scene, the state, and the data of a step.
*/
#include "base/base.h"
#include "base/outcome.h"
#include "base/types.h"
#include "problem/discretization.h"
#include "talus/talus.h"
#include "solve/solve.h"
#include "query/scene.h"
#include "query/state.h"

/* Settings of the library's caller, and the status of the run. */
typedef struct {
  MpmStepHook before, after;
  void       *before_ctx, *after_ctx;
  char       *prefix; /* of the model's options in the database in force, or NULL */
  PetscBool   own;    /* the options were given as text */
  PetscBool   set_up;
  PetscBool   busy;     /* in a call that must not be entered again */
  PetscBool   stop;     /* the caller requests the end of the run */
  PetscBool   points;   /* the run ends once points are made */
  PetscBool   terminal; /* progress and warnings are shown */
  MpmOutcome  outcome;  /* of the last step */
} MpmCaller;

/* A problem of the scene: the equations on a grid, materials of the points, and solution. */
typedef struct {
  MpmDiscretization disc;
  MpmSolver         solver;
  MpmMaterials     *materials; /* borrowed */
} MpmProblem;

/*
  The model's problem, which its steps solve, and another one change places. Either is created, worked with and
  destroyed in the model, whose addresses its parts refer to.
*/
void MpmModelExchange(MpmModel model, MpmProblem *problem);

/* Results and progress, and the test of a stress point, which are the run's. */
typedef struct MpmResults    MpmResults;
typedef struct MpmLaboratory MpmLaboratory;
/* Derivatives of a run (sensitivity/gradient.h) */
typedef struct MpmGradient MpmGradient;
/* Runs with drawn numbers (ensemble/ensemble.h) */
typedef struct MpmEnsemble MpmEnsemble;
/* Maps and gauges of flow over terrain (runout/runout.h) */
typedef struct MpmRunout MpmRunout;
/* Its mass from the bed and onto it (entrainment/entrainment.h) */
typedef struct MpmEntrainment MpmEntrainment;

struct _p_MpmModel {
  MPI_Comm          comm;
  PetscMPIInt       rank, size;
  MpmDatabase      *database;
  MpmCaller         caller;
  MpmRecord         record;
  MpmMonitor        monitor;
  MpmScene          scene;
  MpmState          state;
  MpmDiscretization disc;
  MpmSolver         solver;
  MpmResults       *results;
  MpmLaboratory    *laboratory;  /* NULL: the scene has a grid and bodies */
  MpmGradient      *gradient;    /* NULL: no derivatives are asked for */
  MpmEnsemble      *ensemble;    /* NULL: the scene itself is run */
  MpmRunout        *runout;      /* NULL: no such results are asked for */
  MpmEntrainment   *entrainment; /* NULL: points keep their mass */
};
