/*
  Newton's attempts at a step: from a prediction or from rest, careful or plain, and again as contact's pressures are
  corrected.
*/
#include "base/newton_reason.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "assembly/terms.h"
#include "problem/fields.h"
#include "query/model.h"
#include "step/step.h"

/* Newton from the start at hand; from rest once more where the Krylov method had to be changed. */
static PetscErrorCode SolveFrom(MpmModel model, PetscBool rest, SNESConvergedReason *reason)
{
  const PetscBool before = model->solver.definite.lost;

  PetscFunctionBeginUser;
  PetscCall(MpmSolverSolve(&model->solver, reason));
  if (!rest || model->solver.definite.lost == before) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStepStart(model, PETSC_FALSE));
  PetscCall(MpmSolverSolve(&model->solver, reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Newton's method from the prediction and, where that fails or there is none, from rest. With contact each start is
  tried carefully and plainly, unless loads push along a motion without resistance. All but the last attempt stop on
  stagnation. The next step starts with the variant that succeeded.
*/
static PetscErrorCode TryAll(MpmModel model, SNESConvergedReason *reason)
{
  MpmSolver      *solver    = &model->solver;
  const PetscBool predicted = solver->cache.predicted, contact = MpmSolverHasContact(solver);
  PetscBool       turns = contact;
  Vec             start = NULL;

  PetscFunctionBeginUser;
  if (predicted && contact) {
    PetscCall(VecDuplicate(solver->x, &start));
    PetscCall(VecCopy(solver->x, start));
  }
  for (PetscInt k = 0; k < (predicted ? 4 : 2); k++) {
    const PetscBool rest = (PetscBool)(!predicted || k >= 2);

    if (k % 2 && !turns) continue;
    if (k) {
      if (turns) solver->careful = (PetscBool)!solver->careful;
      if (rest) PetscCall(MpmStepStart(model, PETSC_FALSE));
      else PetscCall(VecCopy(start, solver->x));
    }
    solver->cache.stagnation.stops = (PetscBool)(contact && k < (predicted ? 3 : 1));
    PetscCall(SolveFrom(model, rest, reason));
    if (*reason >= 0) break;
    if (!k && contact) {
      PetscCall(MpmUnconstrainedIsPushed(model, &turns));
      turns = (PetscBool)!turns;
    }
  }
  solver->cache.stagnation.stops = PETSC_FALSE;
  PetscCall(VecDestroy(&start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define SMOOTH 0x1p30 /* factor on the elastic slip of sticking patches at which their tractions stay as they are */

/*
  All attempts. Before contact has a pressure it may only stick, and what sticks may carry so much that all the material
  flows; where friction is low sticking is stiff over so small a slip that Newton's method alternates between sliding
  one way and the other. The last attempt therefore starts from a solution with smooth contact, in which tractions along
  it stay those at the step's start.
*/
static PetscErrorCode Solve(MpmModel model, SNESConvergedReason *reason)
{
  const PetscBool slides = (PetscBool)((MpmTermsTraits(model->disc.terms) & MPM_TERM_SLIDES) > 0);

  PetscFunctionBeginUser;
  model->solver.iterations.newton = model->solver.iterations.linear = 0;
  PetscCall(TryAll(model, reason));
  if (*reason >= 0 || !slides) PetscFunctionReturn(PETSC_SUCCESS);
  model->solver.cache.predicted = PETSC_FALSE;
  PetscCall(MpmStepStart(model, PETSC_FALSE));
  MpmTermsSoften(model->disc.terms, SMOOTH);
  PetscCall(MpmSolverSolve(&model->solver, reason));
  MpmTermsSoften(model->disc.terms, 1.);
  if (*reason >= 0) PetscCall(MpmSolverSolve(&model->solver, reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define TRUST 0.1 /* of the residual at rest: where bodies may slide or part, a prediction that leaves more is none */

/*
  True where any body may slide on another that is near: sticking contact may slide in the next step. Also where contact
  may open, and no energy closes it again.
*/
static PetscBool Rubs(const MpmModel model)
{
  const unsigned traits = model->disc.layout->traits.saddle ? MPM_TERM_BETWEEN : MPM_TERM_BETWEEN | MPM_TERM_RUBS;

  return MpmTermsNear(model->disc.terms, traits);
}

PetscErrorCode MpmStepPredict(MpmModel model)
{
  PetscReal norm;

  PetscFunctionBeginUser;
  model->solver.cache.reference = 0.;
  model->solver.cache.predicted = (PetscBool)(model->state.predict && model->state.dt.last > 0.);
  if (!model->solver.cache.predicted && !MpmSolverHasContact(&model->solver)) {
    PetscCall(MpmSolverStartLinear(&model->solver, model->solver.x, &model->solver.cache.predicted));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!model->solver.cache.predicted) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStepFindReference(model));
  PetscCall(MpmStepStart(model, PETSC_TRUE));
  PetscCall(MpmRelaxBodies(&model->solver, NULL, model->solver.x));
  if (!Rubs(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESComputeFunction(model->solver.snes, model->solver.x, model->solver.f));
  PetscCall(VecNorm(model->solver.f, NORM_2, &norm));
  if (norm <= TRUST * model->solver.cache.reference) PetscFunctionReturn(PETSC_SUCCESS);
  model->solver.cache.predicted = PETSC_FALSE;
  PetscCall(MpmStepStart(model, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define AUGMENTATIONS 40  /* of one step */
#define NEARLY        30. /* times the accepted depth: the next correction should be the last */

/*
  The multipliers of augmented terms, corrected between solutions until their constraints are met. Only then need these
  be exact.
*/
static PetscErrorCode Augment(MpmModel model, SNESConvergedReason *reason)
{
  MpmEvaluations *cache = &model->solver.cache;
  PetscReal       excess;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < AUGMENTATIONS && *reason >= 0; k++) {
    PetscCall(MpmTermsAugment(model->disc.terms, model->disc.sum, model->disc.nodal.u, (PetscBool)!k, &excess));
    if (excess <= 1. && !cache->rough) PetscFunctionReturn(PETSC_SUCCESS);
    cache->rough = (PetscBool)(excess > NEARLY);
    PetscCall(MpmSolverSolve(&model->solver, reason));
  }
  if (*reason >= 0) *reason = SNES_DIVERGED_MAX_IT;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepSolve(MpmModel model, MpmOutcome *outcome)
{
  SNESConvergedReason reason;
  PetscReal           most;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  model->solver.cache.rough = (PetscBool)((MpmTermsTraits(model->disc.terms) & MPM_TERM_AUGMENTED) > 0);
  PetscCall(Solve(model, &reason));
  PetscCall(Augment(model, &reason));
  model->solver.cache.rough = PETSC_FALSE;
  if (reason < 0) {
    outcome->retryable = PETSC_TRUE;
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_NO_SOLUTION, "%s", MpmNewtonReason(reason)));
    PetscCall(MpmUnconstrainedExplain(model, outcome));
    if (outcome->code == MPM_OUTCOME_NO_SOLUTION) PetscCall(MpmStabilityExplain(&model->solver, outcome));
    if (outcome->code == MPM_OUTCOME_NO_SOLUTION) PetscCall(MpmStepLocate(model, outcome));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  outcome->retryable = PETSC_FALSE;
  PetscCall(MpmStabilityCheck(&model->solver, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  outcome->retryable = PETSC_TRUE;
  if (MpmTermsStray(model->disc.terms, model->disc.sum, model->disc.nodal.u))
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                             "a free boundary moved by more than its contacts were looked for"));
  else PetscCall(MpmStepFindLost(model, outcome));
  if (!outcome->code || !MpmFieldsDoWork(model->disc.layout)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecNorm(model->solver.x, NORM_INFINITY, &most)); /* further than it could go as it spreads: it flies */
  if (most > model->disc.grid->upper[0] - model->disc.grid->lower[0])
    PetscCall(MpmUnconstrainedExplain(model, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}
