#pragma once
/*
  How time goes on: steps, stages, the geostatic state.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  Everything before Newton: space, conditions, loads, initial guess, for a step from model->time to `time`, dt later.
  `again`: the points have not moved since the last call, the space stands.
*/
PetscErrorCode MpmStepPrepare(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why);
/*
  One step from model->time to `time`, dt later; `again` as above. `why` is NULL when it converged, otherwise the
  reason (static text); `retryable`: a shorter step may help.
*/
PetscErrorCode MpmStep(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why,
                       PetscBool *retryable);
/* The points' places and their ranks, for a step that begins there. */
PetscErrorCode MpmStepArrange(MpmModel model, const char **why);
/* Stages (stage.c), whose lists have been read (stage_lists.h): when the scene is known, the rest (stage_read.c). */
PetscErrorCode MpmStagesRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmStagesDestroy(MpmModel model);
/* Does any stage change what a point weighs per stress-free volume? */
PetscBool MpmStagesKeepMass(const MpmModel model);
PetscBool MpmStagesAreGeostatic(const MpmModel model);
/* Once the points are there: finds those that carry loads, and puts those aside that later stages add. */
PetscErrorCode MpmStagesSelect(MpmModel model);
/*
  After a failed step (unconstrained.c): where nothing holds the material, or a piece of it, `why` says so; not `retryable` where the
  loads push along such a motion and no boundary may catch it.
*/
PetscErrorCode MpmUnconstrainedExplain(MpmModel model, const char **why, PetscBool *retryable);
/* Do loads push a piece of the material along a motion that nothing resists? In the state that was last tried. */
PetscErrorCode MpmUnconstrainedIsPushed(MpmModel model, PetscBool *pushed);
/*
  The moving grid (moving_grid.c): Read takes the options, Select marks the points of a body that it follows, Follow puts the
  grid where it belongs for the points as they are, at a step's start or where points come and go; `why` is NULL, or the reason
  for which it cannot.
*/
PetscErrorCode MpmMovingGridRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmMovingGridSelect(MpmModel model);
PetscErrorCode MpmMovingGridFollow(MpmModel model, const char **why);
/* After the solution of a step: the grid as the next one will have it; it borrows the model's grid's parts. */
PetscErrorCode MpmMovingGridNext(MpmModel model, MpmGrid *next);
/* The field of the points that a followed body has, NULL where the scene has none. */
const char *MpmMovingGridField(const MpmModel model);
/*
  Bodies that go by a ramp (removal.c): Begin starts it for one, false where it goes at once; does any go on? Set applies the parts at a time, and
  `why` becomes NULL or the reason for which points are lost; Commit after a step that was accepted; Resume for a run that goes on.
*/
PetscErrorCode MpmRemovalRead(MpmModel model, const MpmOptions *block, MpmStage *stage);
PetscBool      MpmRemovalBegin(MpmModel model, const MpmStage *stage, PetscInt body);
PetscBool      MpmRemovalGoesOn(const MpmModel model);
PetscErrorCode MpmRemovalSet(MpmModel model, PetscReal time, const char **why);
PetscErrorCode MpmRemovalCommit(MpmModel model);
void           MpmRemovalResume(MpmModel model);
/* Closes the gap beneath a body that joins, or refuses the body (fill_gap.c). Its points are there. Collective. */
PetscErrorCode MpmGapClose(MpmModel model, PetscInt body, const char stage[]);
/* What a stage's bodies are made of from here on: stress, mass and shape stay (change_material.c). */
PetscErrorCode MpmMaterialsChange(MpmModel model, const MpmStage *stage);
/* Makes a stage the one under way: bodies, materials, conditions, loads, time. */
PetscErrorCode MpmStageBegin(MpmModel model, PetscInt stage);
/*
  What the integrator leaves to the end of a stage, before the next one begins or the run ends (step_control.c). Not in a run's
  checkpoints: should the stage end later than it was thought, then it goes on as if nothing had happened.
*/
PetscErrorCode MpmStageFinish(MpmModel model, const char **why);
PetscBool      MpmStageHasFinish(const MpmModel model);
/* For a run that goes on in model->stage at model->time: time control, and what acts; the points are as they were. */
PetscErrorCode MpmStageResume(MpmModel model);
/* Once the points are there: are materials without strength more than half of the mass of a stage that reduces? */
PetscErrorCode MpmReductionCheck(MpmModel model);
/*
  Strength reduction (strength_reduction.c): Begin notes where the points stand as it
  begins, Apply sets the materials' strengths for a time of the stage under way, Observe looks after a step whether the
  factor of safety is reached. Does any stage reduce, and the factor at a time: 1 where none does. Seeks: does the stage
  under way reduce, without a factor of safety so far?
*/
PetscErrorCode MpmReductionBegin(MpmModel model);
PetscErrorCode MpmReductionApply(MpmModel model, PetscReal time);
/* Own parameters of all points, of materials that vary, at the reduction in force. */
PetscErrorCode MpmModelSetOwn(MpmModel model);
PetscErrorCode MpmReductionObserve(MpmModel model);
PetscBool      MpmStagesReduce(const MpmModel model);
PetscBool      MpmReductionSeeks(const MpmModel model);
PetscReal      MpmReductionFactor(const MpmModel model, PetscReal time);
/*
  The bracket, in steps without inertia to `next`: do they raise the factor that is sought? Look: `why` becomes the reason where a
  solution passes the limit. After a step that failed: is there a shorter one to try? Close: the factor is known, and the stage ends
  in the state that stood, or goes on; or `why` becomes that the solver gave up, with the lower bound.
*/
PetscBool      MpmReductionBrackets(const MpmModel model, PetscReal next);
PetscErrorCode MpmReductionLook(MpmModel model, PetscReal next, const char **why);
PetscBool      MpmReductionNarrows(MpmModel model, PetscReal next);
PetscErrorCode MpmReductionClose(MpmModel model, PetscReal next, const char **why);
/*
  Loss of equilibrium (slide.c): Begin with a stage; Look at a solution to `next`, where `why` becomes the reason for which it is suspected, and
  `retryable` false once shorter steps move as far; Observe after a step that was accepted; Suspects: has one of the last steps been; Explain adds what was suspected to the reason for which a
  run gives up.
*/
void           MpmSlideBegin(MpmModel model);
PetscErrorCode MpmSlideLook(MpmModel model, PetscReal next, const char **why, PetscBool *retryable);
void           MpmSlideObserve(MpmModel model);
PetscBool      MpmSlideSuspects(const MpmModel model);
PetscErrorCode MpmSlideExplain(MpmModel model, const char **why);
/* The stage under way ends at the present time. */
void MpmStageEndHere(MpmModel model);
/* The points' fields for it, one an axis. */
extern const char *const MpmReductionFields[MPM_MAX_DIM];
/* The factor of a load, or of a surface behind them, at a time; 0 where it does not act. */
PetscReal MpmModelLoadFactor(const MpmModel model, PetscInt load, PetscReal time);
/* The water's pressure at a surface, Pa. */
PetscReal MpmModelSurfacePressure(const MpmModel model, PetscInt surface, PetscReal time);

/*
  The error in time that chooses the steps (time_error.c): does any stage ask for it; Begin notes the fields as a stage starts,
  Factor is how much longer the next step may be than the last one tried, by its estimate: infinity where nobody asks.
*/
PetscBool      MpmStagesControlError(const MpmModel model);
PetscErrorCode MpmTimeErrorBegin(MpmModel model);
PetscReal      MpmTimeErrorFactor(const MpmModel model);
/* A step's length that was chosen by it, rounded down by a thousandth at most, the same on any number of ranks. */
PetscReal MpmTimeErrorLength(const MpmModel model, PetscReal dt);
/* The points' field for it. */
extern const char *const MpmTimeErrorField;
/* What the integrator of two stages keeps (sdirk.c). */
PetscErrorCode MpmSdirkDestroy(MpmSdirk **sdirk);

/* The points of a geostatic stage (geostatic.c): what they return to, and what the report needs. */
typedef struct {
  PetscInt   n;
  PetscReal *x, *volume, *domain;          /* position, volume, half lengths of the domain */
  PetscReal *mass;                         /* with what they have taken up */
  PetscReal *value, *value_gradient, *own; /* of the water, which stays */
  PetscReal *F;                            /* before the step under way */
  PetscReal *start;                        /* the stress that k0 gave, or NULL */
  PetscReal  height;
  PetscBool *stateful; /* per material */
  PetscReal  moved;    /* largest displacement of the last step */
  PetscReal  correction, largest;
  PetscInt64 outside; /* points that the yield surface moved */
} MpmRest;

/* One step under `scale` times the loads; stress and history stay, and the points go back to where they were. */
PetscErrorCode MpmRestSettle(MpmModel model, MpmRest *rest, PetscReal scale, const char **why, PetscBool *retryable);
/* After a change of volume0 and F: the points' masses are what they were. */
PetscErrorCode MpmRestKeepMass(MpmModel model, const MpmRest *rest);
/* Gives all points the stage's stress of k0, and F and history with it (k0_balance.c). */
PetscErrorCode MpmRestSetK0(MpmModel model, MpmRest *rest);
/* The whole of a geostatic stage (geostatic.c); `why` is NULL, or the reason why it was given up. */
PetscErrorCode MpmGeostaticRun(MpmModel model, const char **why);
/* What conditions and motions prescribe in a step to `time`; the space stands. `why` is NULL, or why they cannot. */
PetscErrorCode MpmModelPrescribe(MpmModel model, PetscReal time, const char **why);
/* The space of the points where they are now, without a step. */
PetscErrorCode MpmStepSpace(MpmModel model, const char **why);
/* F-bar averages dilation, too, or no longer: what a run falls back to where steps fail again and again. */
void MpmStepAverageDilation(MpmModel model, PetscBool average);
/* A time without the rounding errors of the sum that it is, where it is a decimal number but for them. */
PetscReal MpmTimeRound(PetscReal time);
/* The end of the step that starts now, and its length. */
PetscReal MpmNextTime(MpmModel model, PetscReal dt, PetscReal *step);
/* One step, cut as often as needed; `dt` is its length, `why` the reason when it was given up (step_control.c). */
PetscErrorCode MpmAdvance(MpmModel model, PetscReal *dt, const char **why);
