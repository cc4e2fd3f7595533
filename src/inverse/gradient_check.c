/*
  The task `check_gradient`: derivatives of a run beside those of runs with changed parameters.

  Runs in memory, with the steps of the run, give central differences c(h) over changes of a parameter by the part h of
  it. Where no decision of the run changes they tend to the derivative like h^2, until rounding takes over. The
  difference that agrees best with the next smaller one is taken; its distance from that one is its noise.
*/
#include "base/columns.h"
#include "options/options.h"
#include "options/record.h"
#include "observe/history.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "inverse/inverse.h"
#include "inverse/parameter_option.h"

#define LARGEST   1e-3 /* changes, in parts of the parameter, from here on */
#define CHANGES   6    /* each a tenth of the one before */
#define AGREEMENT 1e-8 /* of adjoint and tangent, relative */
#define ERROR     1e-5 /* of derivatives and differences that is accepted beside their noise, relative */
/* Parts of the objective over the parameter that rounding leaves: of derivatives of zero, and of their differences */
#define ROUNDING_EXACT      1e-12
#define ROUNDING_DIFFERENCE 1e-8

/* All steps of a model, of given lengths; `objective` is not a number where the run gave up. */
static PetscErrorCode RunAlong(MpmModel model, PetscInt rows, const PetscReal times[], PetscReal *objective)
{
  MpmStatus status = MPM_RUNNING;

  PetscFunctionBeginUser;
  PetscCall(MpmModelSetUp(model));
  PetscCall(MpmGradientAddColumns(model, &model->results->columns));
  PetscCall(MpmGradientCollect(model));
  for (PetscInt n = 1; n < rows && status == MPM_RUNNING; n++) {
    PetscCall(MpmModelSetTimeStep(model, times[n] - times[n - 1]));
    PetscCall(MpmModelStep(model, &status));
    PetscCall(MpmGradientCollect(model));
  }
  *objective = NAN;
  if (status == MPM_COMPLETED && model->gradient->rows == rows) PetscCall(MpmGradientEvaluate(model, objective));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The objective of a run with a parameter times a factor. */
static PetscErrorCode Evaluate(MpmModel model, PetscInt k, PetscReal factor, PetscReal *objective)
{
  const MpmSceneParameter *parameter = &model->gradient->parameters.at[k];
  MpmModel                 other;

  PetscFunctionBeginUser;
  PetscCall(MpmParameterSet(model, parameter, factor));
  PetscCall(MpmModelCreate(model->comm, &other));
  other->record->sources = model->record->sources;
  PetscCall(MpmModelSetFromOptions(other));
  PetscCall(RunAlong(other, model->gradient->rows, model->gradient->times, objective));
  PetscCall(MpmModelDestroy(&other));
  PetscCall(MpmParameterSet(model, parameter, 1.));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Central differences by one parameter: the best, its noise, and the largest change with as good a one. */
typedef struct {
  PetscReal value, noise, window;
} Difference;

static PetscErrorCode FindDifference(MpmModel model, PetscInt k, Difference *best)
{
  const PetscReal value = model->gradient->parameters.at[k].value;
  PetscReal       central[CHANGES], change = LARGEST;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < CHANGES; i++, change *= 0.1) {
    PetscReal above, below;

    PetscCall(Evaluate(model, k, 1. + change, &above));
    PetscCall(Evaluate(model, k, 1. - change, &below));
    central[i] = (above - below) / (2. * change * value);
  }
  *best  = (Difference){NAN, PETSC_INFINITY, 0.};
  change = LARGEST;
  for (PetscInt i = 0; i + 1 < CHANGES; i++) {
    const PetscReal gap = PetscAbsReal(central[i] - central[i + 1]);

    if (gap < best->noise) *best = (Difference){central[i + 1], gap, 0.};
  }
  for (PetscInt i = CHANGES - 1; i >= 0; i--)
    if (PetscAbsReal(central[i] - best->value) <= 10. * best->noise + ERROR * PetscAbsReal(best->value))
      best->window = LARGEST * PetscPowReal(10., -(PetscReal)i);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientCheck(MpmModel model)
{
  const MpmGradient    *gradient = model->gradient;
  const MpmDerivatives *found    = &model->results->derivatives;

  PetscFunctionBeginUser;
  if (!gradient || !gradient->checks || !found->count) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < found->count; k++) {
    const PetscReal adjoint = found->gradient[k], tangent = found->tangent[k];
    const PetscReal value = gradient->parameters.at[k].value,
                    scale = value == 0. ? 0. : PetscAbsReal(found->objective / value);
    Difference difference = {0};
    PetscReal  apart, wrong;

    PetscCall(FindDifference(model, k, &difference));
    apart = PetscAbsReal(tangent - adjoint);
    wrong = PetscAbsReal(difference.value - adjoint);
    PetscCall(
      MpmMonitorNote(&model->monitor,
                     "%s: adjoint %.10g, tangent %.1e apart; differences %.10g, %.1e apart, noise %.1e, up to a "
                     "change by %.0e",
                     found->names[k], (double)adjoint, (double)apart, (double)difference.value, (double)wrong,
                     (double)difference.noise, (double)difference.window));
    if (apart <= AGREEMENT * PetscAbsReal(adjoint) + ROUNDING_EXACT * scale &&
        wrong <= 10. * difference.noise + ERROR * PetscAbsReal(adjoint) + ROUNDING_DIFFERENCE * scale)
      continue;
    PetscCall(MpmOutcomeFail(&model->caller.outcome, MPM_OUTCOME_REFUSED,
                             "derivative by %s: adjoint %.10g, tangent %.10g, differences %.10g", found->names[k],
                             (double)adjoint, (double)tangent, (double)difference.value));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
