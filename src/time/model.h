#pragma once
/*
  The parts of a model: what was read, what moves on, and what a step works with.
*/
#include "particles/body.h"
#include "solve/solve.h"
#include "terms/discretization.h"
#include "terms/load.h"

typedef struct _p_MpmRecord *MpmRecord;
typedef struct MpmDatabase   MpmDatabase;

/* How time is cut into steps. */
typedef struct {
  PetscReal end, step, step_min, step_max, growth;
  PetscBool adaptive;
} MpmTimeControl;

typedef enum { MPM_GEOSTATIC_NONE, MPM_GEOSTATIC_GRAVITY, MPM_GEOSTATIC_K0 } MpmGeostaticMethod;

/* The search for a geostatic state: stress in equilibrium without displacement. */
typedef struct {
  MpmGeostaticMethod method;
  PetscReal          k0;
  PetscReal          tolerance; /* largest displacement that remains, in heights of the material */
  PetscInt           iterations;
} MpmGeostatic;

/*
  One stage of a scene: which conditions and loads act, how time runs, and what happens to the bodies at its start. A
  scene without stages is one stage without a name.
*/
typedef struct {
  char          *name;
  MpmTimeControl time;
  PetscBool     *bcs, *loads;    /* by the model's lists: does it act? */
  PetscBool     *removed, *adds; /* by the model's bodies */
  PetscInt      *material;       /* by the model's bodies: of its points from here on, or -1 */
  PetscBool      reset;          /* displacements start at zero again */
  MpmGeostatic   geostatic;
} MpmStage;

/* What was read: constant from then on. */
typedef struct {
  char         *title, *prefix;
  MpmPhysics    physics;
  MpmStretch    stretch;
  MpmShapeType  shape;
  MpmEdgeType   edge;
  MpmMaterials  materials;
  MpmBodies     bodies;
  MpmConditions bcs;
  MpmBoundaries boundaries;
  MpmLoads      loads;
  MpmWalls      walls;
  MpmBodyForce  body_force;
  void         *body_force_ctx;
  PetscBool     fbar, fbar_auto;
  const char   *fbar_why; /* what `auto` went by, or NULL */
  PetscInt      stage_count;
  MpmStage     *stages;
} MpmScene;

/*
  How a step is taken. Until accept() the state is that of the step's start: roll_back() forgets what was tried.

  begin      space, conditions and loads for a step to `time`, dt later; `again`: the points have not moved since the last
             call, the space stands; `why` is NULL, or the reason for which there is no such step
  predict    where the solution starts
  solve      `why` is NULL, or the reason of the failure; `retryable`: a shorter step may help
  accept     what was found becomes the state
  roll_back
  error      estimate of the step's error in time; NULL where there is none
*/
typedef struct {
  const char *name;
  PetscErrorCode (*begin)(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why);
  PetscErrorCode (*predict)(MpmModel model);
  PetscErrorCode (*solve)(MpmModel model, const char **why, PetscBool *retryable);
  PetscErrorCode (*accept)(MpmModel model);
  PetscErrorCode (*roll_back)(MpmModel model);
  PetscErrorCode (*error)(MpmModel model, PetscReal *estimate);
} MpmIntegrator;
extern const MpmIntegrator MpmIntegratorQuasistatic; /* quasistatic.c */

/* What moves on: points, time, and how steps go. */
typedef struct {
  const MpmIntegrator *integrator;
  MpmParticles         particles;
  PetscReal            time, time_end, dt_nominal, dt_min, dt_max, growth;
  PetscReal            dt_wanted; /* of the next step */
  PetscReal            dt_last;   /* of the last step, 0 before the first; */
  PetscReal            dt_before; /* of the one before */
  PetscBool            adaptive;
  PetscBool            predict; /* start from the last step's increment */
  PetscInt             step, cuts, cuts_total;
  PetscInt             stage;      /* the one under way */
  MpmParked           *parked;     /* per body: points that a later stage adds */
  PetscReal            time_start; /* of the stage under way; time_end is its end */
  PetscReal            run_end;
  PetscReal            load_scale;               /* what a geostatic stage applies of its loads; otherwise 1 */
  PetscBool            reference_output;         /* position0 goes into the next state that is written */
  PetscBool            ghost_auto, ghost_rescue; /* nobody has set the ghost penalty; raise it before giving up */
  PetscInt64           active_dofs_max;
} MpmState;

/* What the caller of the library has set, and how the run stands. */
typedef struct {
  MpmStepHook before, after;
  void       *before_ctx, *after_ctx;
  char       *prefix; /* of the model's options in the database in force, or NULL */
  PetscBool   own;    /* the options were given as text */
  PetscBool   set_up;
  PetscBool   busy;     /* in a call that must not be entered again */
  PetscBool   stop;     /* the caller asks for the end of the run */
  PetscBool   terminal; /* progress and warnings are shown */
  const char *why;      /* the last step was given up */
} MpmCaller;

/* Results and progress, and the test of a stress point, which are the run's. */
typedef struct MpmResults    MpmResults;
typedef struct MpmLaboratory MpmLaboratory;

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
  MpmLaboratory    *laboratory; /* NULL: the scene has a grid and bodies */
};
