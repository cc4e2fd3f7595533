/*
  The task `check_gradient`: derivatives of a run beside those of runs with changed parameters.

  Runs in memory, with the steps of the run, give central differences c(h) over changes of a parameter by the part h of
  it. Where no decision of the run changes they tend to the derivative like h^2, until rounding takes over. The
  difference that agrees best with the next smaller one is taken; its distance from that one is its noise.
*/
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "inverse/inverse.h"
#include "inverse/twin.h"

#define LARGEST   1e-3 /* changes, in parts of the parameter, from here on */
#define CHANGES   6    /* each a tenth of the one before */
#define AGREEMENT 1e-8 /* of adjoint and tangent, relative */
#define ERROR     1e-5 /* of derivatives and differences that is accepted beside their noise, relative */
/* Parts of the objective over the parameter that rounding leaves: of derivatives of zero, and of their differences */
#define ROUNDING_EXACT      1e-12
#define ROUNDING_DIFFERENCE 1e-8

/* The objective of a run with a parameter times a factor. */
static PetscErrorCode Evaluate(MpmModel model, PetscInt k, PetscReal factor, PetscReal *objective)
{
  MpmTwin twin;

  PetscFunctionBeginUser;
  PetscCall(MpmTwinRun(model, k, factor * model->gradient->parameters.at[k].value, &twin));
  *objective = twin.objective;
  PetscCall(MpmTwinDestroy(&twin));
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

/* The line of a derivative, and whether it agrees with the other method and with the difference. */
static PetscErrorCode Compare(MpmModel model, PetscInt k, const Difference *difference)
{
  const MpmDerivatives *found  = &model->results->derivatives;
  const PetscBool       closed = MpmGradientIsClosed(model->gradient, k);
  const PetscReal       value = found->gradient[k], apart = closed ? PetscAbsReal(found->tangent[k] - value) : 0.;
  const PetscReal       wrong = PetscAbsReal(difference->value - value);
  const PetscReal       at    = model->gradient->parameters.at[k].value;
  const PetscReal       scale = at == 0. ? 0. : PetscAbsReal(found->objective / at);
  char                  other[96];

  PetscFunctionBeginUser;
  if (closed) PetscCall(PetscSNPrintf(other, sizeof(other), "tangent %.1e apart", (double)apart));
  else PetscCall(PetscSNPrintf(other, sizeof(other), "error about %.1e", (double)found->errors[k]));
  PetscCall(MpmMonitorNote(
    &model->monitor, "%s: %s %.10g, %s; differences %.10g, %.1e apart, noise %.1e, up to a change by %.0e",
    found->names[k], closed ? "adjoint" : "twins", (double)value, other, (double)difference->value, (double)wrong,
    (double)difference->noise, (double)difference->window));
  if (apart <= AGREEMENT * PetscAbsReal(value) + ROUNDING_EXACT * scale &&
      wrong <= 10. * difference->noise + ERROR * PetscAbsReal(value) + ROUNDING_DIFFERENCE * scale)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOutcomeFail(&model->caller.outcome, MPM_OUTCOME_REFUSED,
                           "derivative by %s: %s %.10g, %s, differences %.10g", found->names[k],
                           closed ? "adjoint" : "twins", (double)value, other, (double)difference->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientCheck(MpmModel model)
{
  const MpmGradient    *gradient = model->gradient;
  const MpmDerivatives *found    = &model->results->derivatives;

  PetscFunctionBeginUser;
  if (!gradient || !gradient->checks || !found->gradient) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < found->count; k++) {
    Difference difference = {0};

    PetscCall(FindDifference(model, k, &difference));
    PetscCall(Compare(model, k, &difference));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
