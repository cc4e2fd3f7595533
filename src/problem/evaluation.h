#pragma once
/*
  Evaluations of a step's equations at given unknowns and state.

  A step is prepared first (MpmStepPrepare() in step/step.h: space, conditions, loads, data of the terms). From then on
  its residual, its energy and sums over its points may be evaluated at any unknowns, as often as wanted; nothing of the
  problem changes. For the derivative see MpmSolverLinearise() in solve/solve.h.

    MpmEvaluation at     = MpmEvaluationAt(&model->disc, model->solver.x);
    MpmEvaluated  result = {.f = f};

    PetscCall(MpmEvaluateResidual(&model->disc, at, &result));
*/
#include <petscvec.h>
#include "base/base.h"
#include "base/types.h"
#include "base/version.h"
#include "space/mode.h"

/* An evaluation, passed by value. */
typedef struct {
  const MpmPoints *points; /* state at the step's start, and numbers of the points */
  Vec              u;      /* the solver's unknowns: displacements of the step and totals, in its units and frames */
  PetscReal        dt;     /* in which something flows, s */
  PetscReal        span;   /* from the step's start to the time that is solved for, s */
  PetscReal        part;   /* of the points' forces in the balance */
  MpmMode          mode;
} MpmEvaluation;

/* Destinations and results of an evaluation; members that are NULL are not evaluated. */
typedef struct {
  Vec        f;      /* residual, in the solver's units and frames; diagonal * (u - value) where u is prescribed */
  MpmTrial  *trial;  /* candidate of the points' state at the step's end: MpmTrialCreate() */
  PetscReal  energy; /* J */
  PetscInt   failed; /* points without an answer, of all ranks: other results are then meaningless */
  MpmVersion of;     /* the unknowns' */
} MpmEvaluated;

/* The evaluation of the prepared step at these unknowns. */
MpmEvaluation MpmEvaluationAt(const MpmDiscretization *disc, Vec u);
/* Data of sums over points for an evaluation; the points' arrays, the space and the layout are borrowed. */
void MpmEvaluationSum(const MpmDiscretization *disc, MpmEvaluation at, MpmSum *sum);
/* Values of all local nodes along the axes, `block` a node, from the unknowns. Collective. */
PetscErrorCode MpmEvaluationNodes(const MpmDiscretization *disc, Vec u, PetscReal local[]);
/*
  MpmEvaluateResidual - residual of the step, internal less external forces

  Collective

  Input Parameters:
+ disc - the problem, prepared for the step
- at   - evaluation

  Output Parameter:
. result - residual f and trial where these are not NULL; failed; version of the unknowns

  Notes:
  Points' arrays stay lent to the problem from the step's preparation until the step is accepted or rolled back.
*/
PetscErrorCode MpmEvaluateResidual(const MpmDiscretization *disc, MpmEvaluation at, MpmEvaluated *result);
/*
  The energy whose derivative the residual is, J, where MpmPotentialExists(); into result->energy, and the trial where
  there is one. Loads count as the energy -f . u. Collective.
*/
PetscErrorCode MpmEvaluateEnergy(const MpmDiscretization *disc, MpmEvaluation at, MpmEvaluated *result);
/* Arrays of a trial for the points of a sum; MpmTrialReset() frees them. */
PetscErrorCode MpmTrialCreate(const MpmSum *sum, MpmTrial *trial);
PetscErrorCode MpmTrialReset(MpmTrial *trial);
/*
  Parts of an evaluation. Forces: internal less external ones at the owned nodes, along the axes, from values u of the
  local nodes, into residual[], which has room for the local nodes; with the points' trial, unless NULL; `failed` counts
  points of this rank. Equations: the residual in the solver's units and frames, from those forces at the unknowns u.
*/
PetscErrorCode MpmEvaluateForces(const MpmDiscretization *disc, const MpmSum *sum, const PetscReal u[],
                                 const MpmTrial *trial, PetscReal residual[], PetscInt *failed);
PetscErrorCode MpmEvaluationEquations(const MpmDiscretization *disc, Vec u, const PetscReal residual[], Vec f);
