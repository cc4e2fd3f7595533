#pragma once
/*
  Parts of a step that its integrators share.
*/
#include "base/base.h"
#include "base/types.h"
#include "bc/bc.h"
#include "space/rules.h"
#include "talus/talus.h"

/* ---- step_trial.c ---- */

/*
  All tasks before Newton's method: space, conditions, loads, start, for a step from model->state.time to `time`, dt
  later. `again`: the points have not moved since the last call, the space stands.
*/
PetscErrorCode MpmStepPrepare(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome);

/* ---- step_begin.c ---- */

/* The factor of a load or surface in a step to `time`: that of its end, or with a part of that of its start. */
PetscReal MpmStepLoadFactor(const MpmModel model, PetscInt load, PetscReal time);
/* Rules of the space in a step to `time`. The ghost penalty is for matrices: a step that solves for nothing has
   none. */
MpmRules MpmStepRules(MpmModel model, PetscReal time);

/*
  Space, conditions and loads of a step, as MpmStepPrepare() has them: without a solver and a start for it. For an
  explicit integrator it adds gravity's own force, by the masses of the nodes.
*/
PetscErrorCode MpmStepBegin(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome);
/*
  Completes the loads to their mean over a step to `time`, of which those of its start count `part` times.
*/
PetscErrorCode MpmStepMeanLoads(MpmModel model, PetscReal time, PetscReal part, PetscReal force[]);
/* True where this rank has prescribed unknowns, and on all ranks where any of those moves: then the next function is
   collective. */
PetscBool MpmStepPrescribes(const MpmModel model);
/* Prescribed first or second derivative by time, at the local unknowns, 0 at others. */
PetscErrorCode MpmStepPrescribedRate(MpmModel model, PetscReal time, PetscInt rate, PetscReal values[]);
/* Conditions and motions as a step to `time` takes them. */
MpmPrescription MpmStepPrescription(MpmModel model, PetscReal time);

/* Values prescribed by conditions and motions in a step to `time`; the space stands. Failure: they contradict each
   other. */
PetscErrorCode MpmModelPrescribe(MpmModel model, PetscReal time, MpmOutcome *outcome);
/* The space of the points where they are now, without a step. */
PetscErrorCode MpmStepSpace(MpmModel model, MpmOutcome *outcome);

/* ---- results of Newton's method (step_trial.c) ---- */

/* Fails where the displacement model->disc.nodal.u would carry a point out of the grid; names the first one of the
   lowest rank. */
PetscErrorCode MpmStepFindLost(MpmModel model, MpmOutcome *outcome);
/* Points that rounding has taken over the grid's edges are put onto them. */
void MpmStepClip(MpmModel model);
/* Where points may leave the grid, those that have are taken away; the two above then do nothing. */
PetscErrorCode MpmStepRemoveGone(MpmModel model);
/* The trial and the residual, along the axes, of Newton's solution. */
PetscErrorCode MpmStepFindTrial(MpmModel model);
/* Forces of conditions and motions, from that residual: model->disc.nodal.reaction. */
PetscErrorCode MpmStepFindReactions(MpmModel model);
/* The residual at the step's start, before any prediction: reference of Newton's tolerance. */
PetscErrorCode MpmStepFindReference(MpmModel model);
/*
  The start of Newton's method: zero or, with `predict`, the increment extrapolated from the last steps; totals stay,
  prescribed unknowns take their values.
*/
PetscErrorCode MpmStepStart(MpmModel model, PetscBool predict);

/* ---- step_solve.c ---- */

/* The start of Newton, and the residual that its tolerance refers to. */
PetscErrorCode MpmStepPredict(MpmModel model);
/* Newton's method. */
PetscErrorCode MpmStepSolve(MpmModel model, MpmOutcome *outcome);

/* ---- failure.c ---- */

/* Adds the place of the largest force out of balance, and the share of points that flow, to the reason of a failure. */
PetscErrorCode MpmStepLocate(MpmModel model, MpmOutcome *outcome);

/* ---- unconstrained.c ---- */

/*
  After a failed step (unconstrained.c): adds material, or a piece of it, without support to the reason; not `retryable`
  where the loads push along such a motion and no boundary is in its way.
*/
PetscErrorCode MpmUnconstrainedExplain(MpmModel model, MpmOutcome *outcome);
/* True where loads push a piece of the material along a motion without resistance, in the last trial. */
PetscErrorCode MpmUnconstrainedIsPushed(MpmModel model, PetscBool *pushed);
