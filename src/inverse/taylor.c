/*
  Taylor's test of a gradient, a part of the task check_gradient: along random directions of all numbers of a scene,

    R(h) = |y(p + h p s) - y(p) - h g . (p s)| ,    s_k between -1 and 1,

  falls like h^2 where g is the derivative and no decision of the run changes. With a wrong g it falls like h. Changes
  are tenths of each other, so that log10 R(h)/R(h/10) is the rate. Rounding ends the series.

  Source: Farrell, Ham, Funke and Rognes (2013), doi:10.1137/120873558, section 5.
*/
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "inverse/inverse.h"
#include "inverse/twin.h"

#define DIRECTIONS 2
#define LARGEST    5e-3
#define CHANGES    5
#define ROUNDING   1e-13 /* of results: smaller remainders have no rate */
#define RATE       2.
#define NEAR       0.05

/* Numbers between -1 and 1, half of that at least: signs and sizes of a linear congruential generator. */
static void Draw(PetscInt direction, PetscInt count, PetscReal s[])
{
  unsigned seed = 12345u + 7919u * (unsigned)direction;

  for (PetscInt k = 0; k < count; k++) {
    seed = 1664525u * seed + 1013904223u;
    s[k] = ((seed >> 16) & 1u ? 1. : -1.) * (0.5 + 0.5 * (PetscReal)(seed >> 17) / 32768.);
  }
}

/* The objective with all numbers changed, and whether the run takes its decisions. */
static PetscErrorCode Evaluate(MpmModel model, const PetscReal s[], PetscReal change, PetscReal *objective,
                               PetscBool *same)
{
  const MpmSceneParameters *parameters = &model->gradient->parameters;
  PetscReal                *value;
  MpmTwin                   twin;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(parameters->count, &value));
  for (PetscInt k = 0; k < parameters->count; k++) value[k] = parameters->at[k].value * (1. + change * s[k]);
  PetscCall(MpmTwinRunAll(model, value, &twin));
  *objective = twin.objective;
  *same      = (PetscBool)!twin.apart;
  PetscCall(MpmTwinDestroy(&twin));
  PetscCall(PetscFree(value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One line: the remainders above rounding, their rates, and over how many decades in a row these are near 2. */
static PetscErrorCode Tell(MpmModel model, PetscInt direction, PetscReal slope, PetscReal rounding, PetscReal window,
                           const PetscReal remainder[])
{
  char      rates[96] = "";
  PetscInt  decades = 0, best = 0, used = 0;
  PetscReal last = 0.;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < CHANGES; i++) {
    PetscReal rate;
    char      text[16];

    if (!(remainder[i] > rounding)) break;
    last = remainder[i];
    if (!used++) continue;
    rate    = PetscLog10Real(remainder[i - 1] / remainder[i]);
    decades = PetscAbsReal(rate - RATE) <= NEAR ? decades + 1 : 0;
    best    = PetscMax(best, decades);
    PetscCall(PetscSNPrintf(text, sizeof(text), "%s%.3f", used > 2 ? ", " : "", (double)rate));
    PetscCall(PetscStrlcat(rates, text, sizeof(rates)));
  }
  if (used < 2)
    PetscCall(MpmMonitorNote(&model->monitor,
                             "random direction %d: derivative %.10g; remainders are those of rounding, %.0e",
                             1 + (int)direction, (double)slope, (double)rounding));
  else
    PetscCall(MpmMonitorNote(&model->monitor,
                             "random direction %d: derivative %.10g; remainders from %.1e at a change by %.0e to %.1e, "
                             "rates by decade %s: near 2 over %d; the run's decisions up to a change by %.0e",
                             1 + (int)direction, (double)slope, (double)remainder[0], LARGEST, (double)last, rates,
                             (int)best, (double)window));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTaylorCheck(MpmModel model)
{
  const MpmGradient *gradient = model->gradient;
  const PetscInt     count    = gradient->parameters.count;
  PetscReal         *s, here, remainder[CHANGES];
  PetscBool          same;

  PetscFunctionBeginUser;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(count, &s));
  PetscCall(Evaluate(model, s, 0., &here, &same));
  for (PetscInt d = 0; d < (count > 1 ? DIRECTIONS : 1); d++) {
    PetscReal slope = 0., change = LARGEST, window = 0.;

    Draw(d, count, s);
    for (PetscInt k = 0; k < count; k++)
      slope += model->results->derivatives.gradient[k] * gradient->parameters.at[k].value * s[k];
    for (PetscInt i = 0; i < CHANGES; i++, change *= 0.1) {
      PetscReal there;

      PetscCall(Evaluate(model, s, change, &there, &same));
      remainder[i] = PetscAbsReal(there - here - change * slope);
      window       = same ? PetscMax(window, change) : 0.;
    }
    PetscCall(Tell(model, d, slope, ROUNDING * PetscAbsReal(here), window, remainder));
  }
  PetscCall(PetscFree(s));
  PetscFunctionReturn(PETSC_SUCCESS);
}
