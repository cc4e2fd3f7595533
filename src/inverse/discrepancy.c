/*
  The discrepancy principle as the end of an analysis.
*/
#include "inverse/discrepancy.h"

#define MOST_RUNS 8

PetscReal MpmInverseLevel(const MpmInverse *inverse, const MpmEvaluation *at)
{
  PetscReal factor = inverse->settings->discrepancy;

  if (factor < 0.) factor = inverse->problem.count > at->data.count ? 1. : 0.;
  return factor * (PetscReal)at->data.count;
}

PetscErrorCode MpmDiscrepancyFind(MpmInverse *inverse, const MpmEvaluation *at, PetscBool *met)
{
  const PetscReal level = MpmInverseLevel(inverse, at), squares = MpmInverseSquares(at);

  PetscFunctionBeginUser;
  *met = inverse->met = (PetscBool)(squares <= level && level > 0.);
  if (*met || level == 0.) PetscFunctionReturn(PETSC_SUCCESS);
  if (!inverse->above) PetscCall(PetscMalloc1(inverse->problem.count, &inverse->above));
  PetscCall(PetscArraycpy(inverse->above, at->t, inverse->problem.count));
  inverse->above_squares = squares;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDiscrepancyReturn(MpmInverse *inverse, MpmEvaluation *at)
{
  const PetscReal level = MpmInverseLevel(inverse, at), target = PetscLogReal(level * (1. - 0.5 * MPM_NOISE_BAND));
  const PetscInt  count = inverse->problem.count;
  PetscReal       low = 0., high = 1., above = PetscLogReal(inverse->above_squares), below, *t, *last;
  PetscBool       stop;

  PetscFunctionBeginUser;
  if (!inverse->met || !inverse->above || inverse->interrupted) PetscFunctionReturn(PETSC_SUCCESS);
  if (MpmInverseSquares(at) >= level * (1. - MPM_NOISE_BAND)) PetscFunctionReturn(PETSC_SUCCESS);
  below = PetscLogReal(PetscMax(MpmInverseSquares(at), PETSC_SMALL * level));
  PetscCall(PetscMalloc2(count, &t, count, &last));
  PetscCall(PetscArraycpy(last, at->t, count));
  for (PetscInt n = 0; n < MOST_RUNS && !inverse->interrupted; n++) {
    const PetscReal secant = (above - target) / (above - below),
                    part   = low + (high - low) * PetscClipInterval(secant, 0.05, 0.95);
    PetscReal squares;

    for (PetscInt k = 0; k < count; k++) t[k] = inverse->above[k] + part * (last[k] - inverse->above[k]);
    PetscCall(MpmInverseEvaluate(&inverse->problem, t, MPM_NO_SLOPES, PETSC_INFINITY, at));
    inverse->interrupted = at->interrupted;
    squares              = at->failed ? PETSC_INFINITY : MpmInverseSquares(at);
    if (squares <= level && squares >= level * (1. - MPM_NOISE_BAND)) break;
    if (squares > level) low = part;
    else high = part;
    if (squares > level) above = at->failed ? above : PetscLogReal(squares);
    else below = PetscLogReal(PetscMax(squares, PETSC_SMALL * level));
  }
  if (!at->failed) PetscCall(MpmInverseReport(inverse, inverse->iteration + 1, at, &stop));
  inverse->met = PETSC_TRUE;
  PetscCall(PetscFree2(t, last));
  PetscFunctionReturn(PETSC_SUCCESS);
}
