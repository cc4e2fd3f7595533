#pragma once
/*
  Runs over the steps of a tape, forward and backward.
*/
#include "sensitivity/gradient.h"
#include "stepmap/step_map.h"

/*
  The gradient from the tape and the objectives' weights (tangent_run.c, adjoint_run.c): one run forward a parameter,
  or one backward for all.
*/
PetscErrorCode MpmTangentRun(MpmModel model, PetscReal values[]);
PetscErrorCode MpmAdjointRun(MpmModel model, PetscReal values[]);

/*
  Changes between the end of step n - 1 and the start of step n, where a stage begins: Along for the
  change of the state, Pull for derivatives by it. The vectors are over the points at the step's start.
*/
void MpmStageAlong(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscInt parameter, MpmPointVector *vector);
void MpmStagePull(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscReal gradient[],
                  MpmPointVector *vector);
/* The run's start in the gradient: slopes of the rows before the first step, and derivatives by the adjoint there, this
   rank's part. */
void           MpmStartSlopes(const MpmGradient *gradient, PetscReal slopes[]);
PetscErrorCode MpmStartPull(MpmModel model, const MpmPointVector *vector, PetscReal values[]);

/* Of all states of the run. */
MpmStepConstants MpmGradientConstants(const MpmModel model);

/* The stage that is replayed, as the sums of its derivatives take it (replayed_step.c). */
typedef struct {
  MpmStepMap map;
  PetscReal *u, *factors;
  KSP        ksp; /* of solves with the Jacobian J at the solution */
  Vec        right, solution;
} MpmReplayedStep;
/* The model stands at the solution of a step, or of its first stage. Linearise: J is made anew, for the solves. */
PetscErrorCode MpmReplayedStepCreate(MpmModel model, MpmReplayedStep *step);
PetscErrorCode MpmReplayedStepLinearise(MpmModel model, MpmReplayedStep *step);
PetscErrorCode MpmReplayedStepDestroy(MpmReplayedStep *step);
/*
  J y = b, or J^T y = b. Arrays at the local nodes, along the axes: b a rank's part, of which constrained unknowns do
  not count, y with ghosts and nodes that follow others.
*/
PetscErrorCode MpmReplayedSolve(MpmModel model, const MpmReplayedStep *step, PetscBool transposed, PetscReal b[],
                                PetscReal y[]);
/* Adds the part of the first of two stages in the step's flow, of residuals or their bars at the local nodes. */
void MpmReplayedAddFlow(const MpmModel model, const PetscReal from[], PetscReal to[]);
/* Weight of objective o's column after step n. */
static inline PetscReal MpmGradientWeight(const MpmGradient *gradient, PetscInt o, PetscInt n)
{
  return gradient->weights[o * gradient->rows + gradient->tape.step[n].row];
}
