/*
  Steps along the gradient of the objective, of a fixed rate: for comparison with methods that know more.
*/
#include "inverse/analysis.h"

#define MOST_HALVES 30

/* The step of this rate; half of it as long as runs fail. */
static PetscErrorCode TakeStep(MpmInverse *inverse, MpmEvaluation *at, PetscReal *change)
{
  const PetscInt count = inverse->problem.count;
  PetscReal      rate  = inverse->settings->rate, *t;
  MpmEvaluation  trial = {0}, other;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &t));
  for (PetscInt n = 0; n < MOST_HALVES && !inverse->interrupted; n++, rate *= 0.5) {
    *change = 0.;
    for (PetscInt k = 0; k < count; k++) t[k] = at->t[k] - rate * at->gradient[k];
    MpmInverseClip(inverse, t);
    for (PetscInt k = 0; k < count; k++)
      *change = PetscMax(*change, PetscAbsReal(t[k] - at->t[k]) / MpmInverseSize(inverse, at->t, k));
    PetscCall(MpmInverseEvaluate(&inverse->problem, t, MPM_GRADIENT_ONLY, PETSC_INFINITY, &trial));
    inverse->interrupted = trial.interrupted;
    if (!trial.failed) break;
  }
  if (!trial.failed) {
    other = *at;
    *at   = trial;
    trial = other;
  } else *change = 0.;
  PetscCall(MpmEvaluationDestroy(&trial));
  PetscCall(PetscFree(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDescentRun(MpmInverse *inverse, MpmEvaluation *at)
{
  PetscReal change    = PETSC_INFINITY;
  PetscInt  iteration = MpmInverseFirst(inverse);
  PetscBool stop;

  PetscFunctionBeginUser;
  PetscCall(MpmInverseReport(inverse, iteration, at, &stop));
  while (!stop && !inverse->converged) {
    PetscCall(TakeStep(inverse, at, &change));
    inverse->converged = (PetscBool)(change < inverse->settings->tolerance);
    PetscCall(MpmInverseReport(inverse, ++iteration, at, &stop));
  }
  inverse->reason = inverse->converged ? "the parameters stay within the tolerance" : "the iterations are used up";
  PetscFunctionReturn(PETSC_SUCCESS);
}
