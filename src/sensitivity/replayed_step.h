#pragma once
/*
  Runs over the steps of a tape, forward and backward.
*/
#include "sensitivity/gradient.h"
#include "sensitivity/step_map.h"

/*
  The gradient from the tape and the objectives' weights (tangent_run.c, adjoint_run.c): one run forward a parameter,
  or one backward for all.
*/
PetscErrorCode MpmTangentRun(MpmModel model, PetscReal values[]);
PetscErrorCode MpmAdjointRun(MpmModel model, PetscReal values[]);

/* The step that is replayed, as the sums of its derivatives take it (replayed_step.c). */
typedef struct {
  MpmStepMap map;
  PetscReal *u, *factors;
} MpmReplayedStep;
PetscErrorCode MpmReplayedStepCreate(MpmModel model, PetscInt n, MpmReplayedStep *step);
PetscErrorCode MpmReplayedStepDestroy(MpmReplayedStep *step);
/*
  J y = b, or J^T y = b, with the Jacobian J at the step's solution, made anew by SetUp. Arrays at the local nodes,
  along the axes: b a rank's part, of which constrained unknowns do not count, y with ghosts and nodes that follow
  others.
*/
PetscErrorCode MpmReplayedSolveSetUp(MpmModel model);
PetscErrorCode MpmReplayedSolve(MpmModel model, PetscBool transposed, PetscReal b[], PetscReal y[]);
/* Weight of objective o's column after step n. */
static inline PetscReal MpmGradientWeight(const MpmGradient *gradient, PetscInt o, PetscInt n)
{
  return gradient->weights[o * gradient->rows + n + 1];
}
