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

/* A number of the scene, or a direction of a field's values: its derivative, by what its relative change is times. */
typedef struct {
  PetscInt  number, direction; /* -1: none */
  PetscReal value, scale;      /* of the number; 1 of a direction, which has the size of the values */
  PetscReal found, tangent, error;
  PetscBool closed;
  char      name[128];
} Subject;

static PetscErrorCode NumberSubject(const MpmModel model, PetscInt k, Subject *subject)
{
  const MpmDerivatives *found = &model->results->derivatives;

  PetscFunctionBeginUser;
  *subject         = (Subject){.number = k, .direction = -1, .found = found->gradient[k], .error = found->errors[k]};
  subject->value   = model->gradient->parameters.at[k].value;
  subject->scale   = subject->value;
  subject->closed  = MpmGradientIsClosed(model->gradient, k);
  subject->tangent = subject->closed ? found->tangent[k] : 0.;
  PetscCall(PetscStrncpy(subject->name, found->names[k], sizeof(subject->name)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The adjoint run's derivatives by the values along the direction, and that of the tangent run. */
static PetscErrorCode DirectionSubject(const MpmModel model, PetscInt d, Subject *subject)
{
  const MpmDerivatives     *found     = &model->results->derivatives;
  const MpmFieldParameters *grounds   = &model->gradient->grounds;
  const MpmGroundDirection *direction = &grounds->direction[d];
  const MpmFieldParameter  *field     = &grounds->at[direction->index];
  const PetscReal          *by        = &found->gradient[model->gradient->parameters.count + field->first];

  PetscFunctionBeginUser;
  *subject = (Subject){.number = -1, .direction = d, .value = 1., .scale = 1., .closed = PETSC_TRUE};
  for (PetscInt k = 0; k < field->ground->count; k++) subject->found += by[k] * direction->change[k];
  subject->tangent = found->tangent[model->gradient->parameters.count + d];
  PetscCall(PetscSNPrintf(subject->name, sizeof(subject->name), "field %.80s along random signs %d",
                          field->ground->name, 1 + (int)(d % MPM_GROUND_CHECKS)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The objective of a run with a relative change. */
static PetscErrorCode Evaluate(MpmModel model, const Subject *subject, PetscReal change, PetscReal *objective)
{
  MpmTwin twin;

  PetscFunctionBeginUser;
  if (subject->number >= 0) PetscCall(MpmTwinRun(model, subject->number, (1. + change) * subject->value, &twin));
  else PetscCall(MpmTwinRunField(model, subject->direction, change, &twin));
  *objective = twin.objective;
  PetscCall(MpmTwinDestroy(&twin));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Central differences: the best, its noise, and the largest change with as good a one. */
typedef struct {
  PetscReal value, noise, window;
} Difference;

static PetscErrorCode FindDifference(MpmModel model, const Subject *subject, Difference *best)
{
  PetscReal central[CHANGES], change = LARGEST;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < CHANGES; i++, change *= 0.1) {
    PetscReal above, below;

    PetscCall(Evaluate(model, subject, change, &above));
    PetscCall(Evaluate(model, subject, -change, &below));
    central[i] = (above - below) / (2. * change * subject->scale);
  }
  *best = (Difference){NAN, PETSC_INFINITY, 0.};
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
static PetscErrorCode Compare(MpmModel model, const Subject *subject, const Difference *difference)
{
  const PetscReal value = subject->found, apart = subject->closed ? PetscAbsReal(subject->tangent - value) : 0.;
  const PetscReal wrong = PetscAbsReal(difference->value - value);
  const PetscReal scale =
    subject->scale == 0. ? 0. : PetscAbsReal(model->results->derivatives.objective / subject->scale);
  const char *method = subject->closed ? "adjoint" : "twins";
  char        other[96];

  PetscFunctionBeginUser;
  if (subject->closed) PetscCall(PetscSNPrintf(other, sizeof(other), "tangent %.1e apart", (double)apart));
  else PetscCall(PetscSNPrintf(other, sizeof(other), "error about %.1e", (double)subject->error));
  PetscCall(MpmMonitorNote(&model->monitor,
                           "%s: %s %.10g, %s; differences %.10g, %.1e apart, noise %.1e, up to a change by %.0e",
                           subject->name, method, (double)value, other, (double)difference->value, (double)wrong,
                           (double)difference->noise, (double)difference->window));
  if (apart <= AGREEMENT * PetscAbsReal(value) + ROUNDING_EXACT * scale &&
      wrong <= 10. * difference->noise + ERROR * PetscAbsReal(value) + ROUNDING_DIFFERENCE * scale)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOutcomeFail(&model->caller.outcome, MPM_OUTCOME_REFUSED,
                           "derivative by %s: %s %.10g, %s, differences %.10g", subject->name, method, (double)value,
                           other, (double)difference->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientCheck(MpmModel model)
{
  const MpmGradient    *gradient = model->gradient;
  const MpmDerivatives *found    = &model->results->derivatives;
  const PetscInt        count    = gradient ? found->count + gradient->grounds.direction_count : 0;

  PetscFunctionBeginUser;
  if (!gradient || !gradient->checks || !found->gradient) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < count; k++) {
    Difference difference = {0};
    Subject    subject;

    if (k < found->count) PetscCall(NumberSubject(model, k, &subject));
    else PetscCall(DirectionSubject(model, k - found->count, &subject));
    PetscCall(FindDifference(model, &subject, &difference));
    PetscCall(Compare(model, &subject, &difference));
  }
  PetscCall(MpmTaylorCheck(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}
