/*
  Derivatives by twins, of whatever a scene has: runs with a parameter a little larger and smaller.

    dy/dp = (y(p + c) - y(p - c))/(2 c) ,    c = 1e-5 p and 1e-6 p

  of every objective's column at every step. Twins take the steps of the run and solve them to rounding, eps, so that a
  difference is wrong by eps/c by rounding and by c^2 through curvature. Two changes that agree show that the run has no
  kink and no other decision between them; where they do not, others are tried, and the two that agree best are taken.

  Source: errors of central differences: Nocedal and Wright (2006), Numerical Optimization, section 8.1,
  doi:10.1007/978-0-387-40065-5.
*/
#include "base/columns.h"
#include "options/options.h"
#include "observe/results.h"
#include "query/model.h"
#include "sensitivity/gradient.h"
#include "inverse/inverse.h"
#include "inverse/twin.h"

#define AGREEMENT 1e-6 /* of two changes, relative: no others are tried */
#define DOUBT     1e-4 /* error that is told */
#define FAILURE   1e-2 /* error with which there is no derivative */
#define NEAR      1e-8 /* change of results, relative, that rounding spoils: where the parameter is 0 its scale grows */
#define GROWTH    100.
#define GROWTHS   6

/* Changes, in parts of the parameter, in the order in which they are tried; neighbours in size are compared. */
static const PetscReal changes[] = {1e-5, 1e-6, 1e-7, 1e-4, 1e-8};
#define CHANGES ((PetscInt)PETSC_STATIC_ARRAY_LENGTH(changes))

/* Differences over one change; NULL: there are none. */
typedef struct {
  PetscReal *slope; /* as the gradient's, of one parameter */
  PetscInt   apart; /* first step with other decisions, or 0 */
  PetscReal  bend;  /* second difference over the first one, about the root of the error by curvature */
} Difference;

/* Differences by one parameter. */
typedef struct {
  MpmModel   model;
  PetscInt   k, size; /* numbers of a curve */
  PetscReal  scale;   /* of changes */
  MpmTwin    centre;  /* the twin without a change, for differences to one side */
  Difference at[PETSC_STATIC_ARRAY_LENGTH(changes)];
  char       why[MPM_TWIN_TEXT]; /* why there is none */
} Twins;

/* ---- differences ---- */

/* Largest value of a curve, of objective o. */
static PetscReal Largest(const Twins *twins, const PetscReal curve[], PetscInt o)
{
  const PetscInt count = twins->model->gradient->objectives.count;
  PetscReal      most  = 0.;

  for (PetscInt n = o; n < twins->size; n += count) most = PetscMax(most, PetscAbsReal(curve[n]));
  return most;
}

/* The twin at a value; false where it does not take all steps. */
static PetscErrorCode Run(Twins *twins, double value, Difference *difference, MpmTwin *twin, PetscBool *good)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTwinRun(twins->model, twins->k, value, twin));
  if (!difference->apart) difference->apart = twin->apart;
  *good = (PetscBool)(twin->curves != NULL);
  if (!*good) PetscCall(PetscSNPrintf(twins->why, MPM_TWIN_TEXT, "with %.10g %.400s", value, twin->why));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Differences to one side of the parameter, by two twins at c and 2 c of it: (-3 y0 + 4 y1 - y2)/(2 c). */
static PetscErrorCode DifferenceAside(Twins *twins, PetscReal c, Difference *difference)
{
  const double value = twins->model->gradient->parameters.at[twins->k].value;
  MpmTwin      near = {0}, far = {0};
  PetscBool    good = PETSC_TRUE;

  PetscFunctionBeginUser;
  difference->bend = 1.;
  if (!twins->centre.curves) PetscCall(Run(twins, value, difference, &twins->centre, &good));
  if (good) PetscCall(Run(twins, value + c, difference, &near, &good));
  if (good) PetscCall(Run(twins, value + 2. * c, difference, &far, &good));
  if (good) {
    PetscCall(PetscMalloc1(twins->size, &difference->slope));
    for (PetscInt i = 0; i < twins->size; i++)
      difference->slope[i] =
        (4. * (near.curves[i] - twins->centre.curves[i]) - (far.curves[i] - twins->centre.curves[i])) / (2. * c);
  }
  PetscCall(MpmTwinDestroy(&near));
  PetscCall(MpmTwinDestroy(&far));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Second differences over the first ones, the largest of all objectives. */
static PetscReal Bend(const Twins *twins, const MpmTwin *high, const MpmTwin *low)
{
  const MpmGradient *gradient = twins->model->gradient;
  const PetscInt     count    = gradient->objectives.count;
  PetscReal          most     = 0.;

  for (PetscInt o = 0; o < count; o++) {
    PetscReal first = 0., second = 0.;

    for (PetscInt n = o; n < twins->size; n += count) {
      first  = PetscMax(first, PetscAbsReal(high->curves[n] - low->curves[n]));
      second = PetscMax(second, PetscAbsReal(high->curves[n] + low->curves[n] - 2. * gradient->curves[n]));
    }
    if (first > 0.) most = PetscMax(most, second / first);
  }
  return most;
}

/* Differences over one change; to one side where the other is out of the option's range. */
static PetscErrorCode FindDifference(Twins *twins, PetscReal change, Difference *difference)
{
  const MpmSceneParameter *parameter = &twins->model->gradient->parameters.at[twins->k];
  const PetscReal          c         = change * twins->scale;
  const double             above = parameter->value + c, below = parameter->value - c;
  const PetscBool rises = MpmRangeHolds(parameter->range, above), falls = MpmRangeHolds(parameter->range, below);
  MpmTwin         high = {0}, low = {0};
  PetscBool       good;

  PetscFunctionBeginUser;
  if (!rises || !falls) {
    PetscCall(DifferenceAside(twins, rises ? c : -c, difference));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(Run(twins, above, difference, &high, &good));
  if (good) PetscCall(Run(twins, below, difference, &low, &good));
  if (good) {
    PetscCall(PetscMalloc1(twins->size, &difference->slope));
    for (PetscInt i = 0; i < twins->size; i++)
      difference->slope[i] = (high.curves[i] - low.curves[i]) / (above - below);
    difference->bend = Bend(twins, &high, &low);
  }
  PetscCall(MpmTwinDestroy(&high));
  PetscCall(MpmTwinDestroy(&low));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- which to take ---- */

/* Distance of two differences, relative: the largest of all objectives. */
static PetscReal Distance(const Twins *twins, const Difference *a, const Difference *b)
{
  const PetscInt count = twins->model->gradient->objectives.count;
  PetscReal      most  = 0.;

  if (!a->slope || !b->slope) return PETSC_INFINITY;
  for (PetscInt o = 0; o < count; o++) {
    const PetscReal size = PetscMax(Largest(twins, a->slope, o), Largest(twins, b->slope, o));
    PetscReal       gap  = 0.;

    for (PetscInt n = o; n < twins->size; n += count) gap = PetscMax(gap, PetscAbsReal(a->slope[n] - b->slope[n]));
    if (size > 0.) most = PetscMax(most, gap / size);
  }
  return most;
}

/*
  The two differences over changes beside each other that agree best. `best` is that of the smaller change, unless the
  error of the larger one by curvature is less than their distance, which is then due to rounding.
*/
static PetscReal Choose(const Twins *twins, PetscInt *best, PetscInt *second)
{
  PetscReal least = PETSC_INFINITY;

  *best = *second = -1;
  for (PetscInt i = 0; i < CHANGES; i++) {
    for (PetscInt j = 0; j < CHANGES; j++) {
      const PetscReal part = changes[j] / changes[i];
      PetscReal       distance;

      if (part > 0.11 || part < 0.09) continue;
      distance = Distance(twins, &twins->at[i], &twins->at[j]);
      if (distance >= least) continue;
      least   = distance;
      *second = i;
      *best   = j;
    }
  }
  if (*best >= 0 && PetscSqr(twins->at[*second].bend) < least) {
    const PetscInt smaller = *best;

    *best   = *second;
    *second = smaller;
  }
  return least;
}

/* A scale for changes of a parameter that is 0: results must change by more than rounding. */
static PetscErrorCode FindScale(Twins *twins)
{
  const MpmGradient *gradient = twins->model->gradient;
  PetscInt           tries    = 0;

  PetscFunctionBeginUser;
  twins->scale = PetscAbsReal((PetscReal)gradient->parameters.at[twins->k].value);
  if (twins->scale > 0.) PetscFunctionReturn(PETSC_SUCCESS);
  for (twins->scale = 1.; tries < GROWTHS; tries++) {
    PetscReal most = 0.;

    PetscCall(PetscFree(twins->at[0].slope));
    PetscCall(FindDifference(twins, changes[0], &twins->at[0]));
    for (PetscInt o = 0; o < gradient->objectives.count && twins->at[0].slope; o++) {
      const PetscReal size = Largest(twins, gradient->curves, o);

      if (size > 0.) most = PetscMax(most, Largest(twins, twins->at[0].slope, o) * changes[0] * twins->scale / size);
    }
    if (!twins->at[0].slope || most >= NEAR) break;
    twins->scale *= GROWTH;
  }
  if (twins->at[0].slope || !tries) PetscFunctionReturn(PETSC_SUCCESS);
  twins->scale /= GROWTH;
  PetscCall(FindDifference(twins, changes[0], &twins->at[0]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsZero(const Twins *twins, const Difference *difference)
{
  for (PetscInt i = 0; i < twins->size; i++)
    if (difference->slope[i] != 0.) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* ---- a parameter's derivative ---- */

/* The gradient, and its estimated error, from the differences that have been chosen. */
static PetscErrorCode Take(Twins *twins, PetscInt best, PetscInt second, PetscReal distance)
{
  MpmGradient    *gradient = twins->model->gradient;
  MpmDerivatives *found    = &twins->model->results->derivatives;
  const PetscInt  count    = gradient->objectives.count;
  const char     *name     = gradient->parameters.at[twins->k].name;
  PetscReal      *slope    = &gradient->slopes[twins->k * twins->size];

  PetscFunctionBeginUser;
  MpmCheckInput(!IsZero(twins, &twins->at[best]), "-mpm_parameters %s: no result depends on it", name);
  PetscCall(PetscArraycpy(slope, twins->at[best].slope, twins->size));
  for (PetscInt n = 0; n < gradient->rows; n++) {
    for (PetscInt o = 0; o < count; o++) {
      const PetscReal weight = gradient->weights[o * gradient->rows + n];
      const PetscInt  i      = n * count + o;

      found->gradient[twins->k] += weight * slope[i];
      found->errors[twins->k] += PetscAbsReal(weight * (slope[i] - twins->at[second].slope[i]));
    }
  }
  if (distance > DOUBT)
    PetscCall(MpmMonitorNote(&twins->model->monitor,
                             "derivative by %s: differences over changes by %.0e and %.0e are %.1e apart", name,
                             (double)changes[second], (double)changes[best], (double)distance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Fail(Twins *twins, PetscInt best, PetscReal distance)
{
  const char *name    = twins->model->gradient->parameters.at[twins->k].name;
  MpmOutcome *outcome = &twins->model->caller.outcome;

  PetscFunctionBeginUser;
  if (best < 0)
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_REFUSED, "derivative by %s: there is no twin: %s", name, twins->why));
  else if (twins->at[best].apart)
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_REFUSED,
                             "derivative by %s: cannot be told: twins take other decisions from step %" PetscInt_FMT
                             " on, and differences are %.1e apart",
                             name, twins->at[best].apart, (double)distance));
  else
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_REFUSED,
                             "derivative by %s: cannot be told: differences of twins are %.1e apart, relative", name,
                             (double)distance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Differentiate(MpmModel model, PetscInt k)
{
  const MpmGradient *gradient = model->gradient;
  Twins              twins    = {.model = model, .k = k, .size = gradient->rows * gradient->objectives.count};
  PetscReal          distance = PETSC_INFINITY;
  PetscInt           best = -1, second = -1;

  PetscFunctionBeginUser;
  PetscCall(FindScale(&twins));
  for (PetscInt i = 0; i < CHANGES && distance > AGREEMENT; i++) {
    if (!twins.at[i].slope) PetscCall(FindDifference(&twins, changes[i], &twins.at[i]));
    distance = Choose(&twins, &best, &second);
  }
  if (best >= 0 && distance <= FAILURE) PetscCall(Take(&twins, best, second, distance));
  else PetscCall(Fail(&twins, best, distance));
  for (PetscInt i = 0; i < CHANGES; i++) PetscCall(PetscFree(twins.at[i].slope));
  PetscCall(MpmTwinDestroy(&twins.centre));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Why parameter k has no derivative in closed form. */
static PetscErrorCode Tell(MpmModel model, PetscInt k)
{
  const MpmGradient *gradient = model->gradient;

  PetscFunctionBeginUser;
  if (gradient->open[0])
    PetscCall(MpmMonitorNote(&model->monitor, "derivatives by twins: there are none in closed form yet with %s",
                             gradient->open));
  else if (gradient->method != MPM_GRADIENT_TWINS)
    PetscCall(MpmMonitorNote(&model->monitor, "derivative by twins: there is none in closed form yet by %s",
                             gradient->parameters.at[k].name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Refuses what a twin would not have. */
static PetscErrorCode CheckCaller(MpmModel model, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  if (model->caller.before || model->caller.after)
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_REFUSED,
                             "there are no derivatives by twins of a run with hooks of its caller"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTwinsFind(MpmModel model)
{
  MpmGradient *gradient = model->gradient;
  PetscBool    told     = PETSC_FALSE;
  PetscInt     size;

  PetscFunctionBeginUser;
  if (!gradient || gradient->rows < 2) PetscFunctionReturn(PETSC_SUCCESS);
  size = gradient->rows * gradient->objectives.count;
  if (!gradient->slopes) PetscCall(PetscCalloc1((gradient->parameters.count * size), &gradient->slopes));
  for (PetscInt k = 0; k < gradient->parameters.count && !model->caller.outcome.code; k++) {
    if (MpmGradientIsClosed(gradient, k)) continue;
    if (!told || !gradient->open[0]) PetscCall(Tell(model, k));
    told = PETSC_TRUE;
    PetscCall(CheckCaller(model, &model->caller.outcome));
    if (!model->caller.outcome.code) PetscCall(Differentiate(model, k));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
