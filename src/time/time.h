#pragma once
/*
  How time goes on: steps, stages, the geostatic state; and the parts of the model that they work on.
*/
#include "solve/solve.h"

/* ---- stage.c ---- */

/* How time is cut into steps. */
typedef struct {
  PetscReal end, step, step_min, step_max, growth;
  PetscBool adaptive;
} MpmTimeControl;

typedef enum { MPM_GEOSTATIC_NONE, MPM_GEOSTATIC_GRAVITY, MPM_GEOSTATIC_K0 } MpmGeostaticMethod;

/* The search for a state of stress in which nothing moves. */
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

/* What moves on: points, time, and how steps go. */
typedef struct {
  MpmParticles particles;
  PetscReal    time, time_end, dt_nominal, dt_min, dt_max, growth;
  PetscReal    dt_wanted; /* of the next step */
  PetscReal    dt_last;   /* of the last step, 0 before the first; */
  PetscReal    dt_before; /* of the one before */
  PetscBool    adaptive;
  PetscBool    predict; /* start from the last step's increment */
  PetscInt     step, cuts, cuts_total;
  PetscInt     stage;      /* the one under way */
  MpmParked   *parked;     /* per body: points that a later stage adds */
  PetscReal    time_start; /* of the stage under way; time_end is its end */
  PetscReal    run_end;
  PetscReal    load_scale;               /* what a geostatic stage applies of its loads; otherwise 1 */
  PetscBool    reference_output;         /* position0 goes into the next state that is written */
  PetscBool    ghost_auto, ghost_rescue; /* nobody has set the ghost penalty; raise it before giving up */
  PetscInt64   active_dofs_max;
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

/* Results and progress, which are the run's. */
typedef struct MpmResults MpmResults;

struct _p_MpmModel {
  MPI_Comm          comm;
  PetscMPIInt       rank, size;
  MpmDatabase       database;
  MpmCaller         caller;
  MpmRecord         record;
  MpmMonitor        monitor;
  MpmScene          scene;
  MpmState          state;
  MpmDiscretization disc;
  MpmSolver         solver;
  MpmResults       *results;
};

/* Frees the arrays. */
PetscErrorCode MpmTrialReset(MpmTrial *trial);
/*
  Everything before Newton: space, conditions, loads, initial guess, for a step from model->time to `time`, dt later.
  `again`: the points have not moved since the last call, the space stands.
*/
PetscErrorCode MpmStepPrepare(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why);
/*
  One step from model->time to `time`, dt later; `again` as above. `why` is NULL when it converged, otherwise the
  reason (static text); `hopeless`: a shorter step would not help.
*/
PetscErrorCode MpmStep(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why,
                       PetscBool *hopeless);
/*
  Stages (stage.c): their names, and the conditions and loads that only they name; then, when the scene is known, the
  rest.
*/
PetscErrorCode MpmStagesReadLists(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmStagesRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmStagesDestroy(MpmModel model);
/* Does any stage change what a point weighs per stress-free volume? */
PetscBool MpmStagesKeepMass(const MpmModel model);
PetscBool MpmStagesAreGeostatic(const MpmModel model);
/* Once the points are there: finds those that carry loads, and puts those aside that later stages add. */
PetscErrorCode MpmStagesSelect(MpmModel model);
/*
  After a failed step (held.c): where nothing holds the material, or a piece of it, `why` says so; `hopeless` where the
  loads push along such a motion and no boundary may catch it.
*/
PetscErrorCode MpmHeldExplain(MpmModel model, const char **why, PetscBool *hopeless);
/* What a stage's bodies are made of from here on: stress, mass and shape stay (rematerial.c). */
PetscErrorCode MpmMaterialsChange(MpmModel model, const MpmStage *stage);
/* Makes a stage the one under way: bodies, materials, conditions, loads, time. */
PetscErrorCode MpmStageBegin(MpmModel model, PetscInt stage);
/* For a run that goes on in model->stage at model->time: time control, and what acts; the points are as they were. */
PetscErrorCode MpmStageResume(MpmModel model);
/* The factor of a load at a time, 0 where it does not act. */
PetscReal MpmModelLoadFactor(const MpmModel model, PetscInt load, PetscReal time);

/* The points of a geostatic stage (geostatic.c): what they return to, and what the report needs. */
typedef struct {
  PetscInt   n;
  PetscReal *x, *volume, *domain; /* position, volume, half lengths of the domain */
  PetscReal *F;                   /* before the step under way */
  PetscReal *start;               /* the stress that k0 gave, or NULL */
  PetscReal  height;
  PetscBool *remembers; /* per material */
  PetscReal  moved;     /* largest displacement of the last step */
  PetscReal  correction, largest;
  PetscInt64 outside; /* points that the yield surface moved */
} MpmRest;

/* One step under `scale` times the loads; stress and history stay, and the points go back to where they were. */
PetscErrorCode MpmRestSettle(MpmModel model, MpmRest *rest, PetscReal scale, const char **why, PetscBool *hopeless);
/* Gives all points the stage's stress of k0, and F and history with it (k0.c). */
PetscErrorCode MpmRestSetK0(MpmModel model, MpmRest *rest);
/* The whole of a geostatic stage (geostatic.c); `why` is NULL, or the reason why it was given up. */
PetscErrorCode MpmGeostaticRun(MpmModel model, const char **why);
/* For lists of blocks: with -help, a list that the scene does not give becomes one block called NAME. */
PetscErrorCode MpmModelReadNames(const MpmOptions *options, const char *list, const char *help, MpmNeed need,
                                 PetscInt *count, char ***names);
/* The space of the points where they are now, without a step. */
PetscErrorCode MpmStepSpace(MpmModel model, const char **why);
/* Where a run would give up, once: a firmer ghost penalty from here on. */
PetscErrorCode MpmStepRaiseGhost(MpmModel model, const char *why);
