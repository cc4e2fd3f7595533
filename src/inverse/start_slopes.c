/*
  Derivatives of the state from which a gradient's steps start: of bodies with initial stress or from files, and of the
  geostatic stage that comes first, whose iterations end at a state of equilibrium s_0(p).

  Twins, models with one parameter p changed, take that stage alone. With D(c) the central difference of their states
  over a change c p,

    ds_0/dp = (4 D(c/2) - D(c))/3 ,    c = 1e-3 ,

  is exact to c^4, about as much as rounding and Newton's tolerance 1e-13 over c. Where a point reaches its yield
  surface between the twins the two differences disagree, and a tenth of the change is tried.

  Source: Richardson's extrapolation; Nocedal and Wright (2006), Numerical Optimization, doi:10.1007/978-0-387-40065-5,
  section 8.1.
*/
#include "options/database.h"
#include "options/record.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/sum.h"
#include "observe/history.h"
#include "observe/results.h"
#include "sensitivity/replayed_step.h"
#include "inverse/inverse.h"

#define LARGEST   1e-3
#define CHANGES   4    /* each a tenth of the one before */
#define AGREEMENT 1e-5 /* of the two differences, relative to a field's largest value: no smaller change is tried */

/* The state, and the objectives' values up to it. */
typedef struct {
  MpmPointVector at;
  PetscReal     *curves;
} Start;

static PetscErrorCode StartDestroy(Start *start)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPointVectorDestroy(&start->at));
  PetscCall(PetscFree(start->curves));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The twin's state and values become `start`. */
static PetscErrorCode Take(const MpmModel model, MpmModel twin, Start *start)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(twin->state.particles, twin->disc.points));
  PetscCall(MpmParticlesGetArrays(twin->state.particles, &points));
  PetscCall(MpmStateVectorCreate(model->disc.sum, &points, MpmGradientConstants(model), &start->at));
  MpmPointVectorTake(&points, &start->at);
  PetscCall(MpmParticlesRestoreArrays(twin->state.particles, &points));
  start->curves          = twin->gradient->curves;
  twin->gradient->curves = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of twins beside the parameter's: errors of a solution count as often as the change goes into the value. */
static const char *const tolerances[][2] = {{"-snes_rtol", "1e-13"}, {"-snes_stol", "0"}};
#define TOLERANCES 2

static PetscErrorCode Tighten(char *kept[])
{
  PetscFunctionBeginUser;
  for (int t = 0; t < TOLERANCES; t++) {
    const char *present;
    PetscBool   given;

    kept[t] = NULL;
    PetscCall(MpmDatabaseFind(tolerances[t][0] + 1, &present, &given));
    if (given) PetscCall(PetscStrallocpy(present ? present : "", &kept[t]));
    PetscCall(PetscOptionsSetValue(NULL, tolerances[t][0], tolerances[t][1]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Loosen(char *kept[])
{
  PetscFunctionBeginUser;
  for (int t = 0; t < TOLERANCES; t++) {
    if (kept[t]) PetscCall(PetscOptionsSetValue(NULL, tolerances[t][0], kept[t]));
    else PetscCall(PetscOptionsClearValue(NULL, tolerances[t][0]));
    PetscCall(PetscFree(kept[t]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The start of the scene with parameter k at a value. */
static PetscErrorCode Evaluate(MpmModel model, PetscInt k, PetscReal value, Start *start)
{
  const MpmSceneParameter *parameter = &model->gradient->parameters.at[k];
  MpmModel                 twin;
  MpmStatus                status = MPM_RUNNING;
  char                    *kept[TOLERANCES];

  PetscFunctionBeginUser;
  PetscCall(Tighten(kept));
  PetscCall(MpmSceneParameterSet(parameter, value));
  PetscCall(MpmModelCreate(model->comm, &twin));
  twin->record->sources = model->record->sources;
  PetscCall(MpmModelSetBodyForce(twin, model->scene.body_force.function, model->scene.body_force.ctx));
  PetscCall(MpmModelSetFromOptions(twin));
  PetscCall(MpmModelSetUp(twin));
  PetscCall(MpmHistoryAddColumns(twin, &twin->results->columns));
  PetscCall(MpmGradientCollect(twin));
  if (model->gradient->start.rows > 1) {
    PetscCall(MpmModelStep(twin, &status));
    PetscCall(MpmGradientCollect(twin));
  }
  if (status == MPM_GAVE_UP)
    PetscCall(MpmOutcomeFail(&model->caller.outcome, MPM_OUTCOME_REFUSED,
                             "derivative by %s: the first stage with %.10g gives up: %s",
                             model->gradient->parameters.at[k].name, (double)value, twin->caller.outcome.text));
  PetscCall(Take(model, twin, start));
  PetscCall(MpmModelDestroy(&twin));
  PetscCall(MpmSceneParameterReset(parameter));
  PetscCall(Loosen(kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Places of the parameter and their factors in a difference of second order: central or, where one side is out of the
   option's range, on the other side. */
typedef struct {
  PetscInt  count;
  PetscReal at[3], factor[3];
} Stencil;

static Stencil StencilOf(const MpmSceneParameter *parameter, PetscReal change)
{
  const PetscReal value = parameter->value, c = change * (value != 0. ? value : 1.);
  const PetscBool above = MpmRangeHolds(parameter->range, value + c);
  const PetscReal s     = above ? c : -c;

  if (above == MpmRangeHolds(parameter->range, value - c))
    return (Stencil){2, {value + c, value - c}, {0.5 / c, -0.5 / c}};
  return (Stencil){3, {value + s, value + 2. * s, value}, {2. / s, -0.5 / s, -1.5 / s}};
}

/* Adds a factor times the start with parameter k at a value to `sum`, in the order of its points; sets an empty one. */
static PetscErrorCode AddStart(MpmModel model, PetscInt k, PetscReal value, PetscReal factor, Start *sum)
{
  const MpmGradient *gradient = model->gradient;
  const PetscBool    first    = (PetscBool)!sum->curves;
  Start              other = {0}, here = {0};
  PetscReal          before = 1.;

  PetscFunctionBeginUser;
  PetscCall(Evaluate(model, k, value, first ? sum : &other));
  if (first) {
    before = 0.;
    other  = *sum;
  }
  PetscCall(MpmPointVectorCopy(&sum->at, PETSC_FALSE, &here.at));
  PetscCall(MpmPointVectorMove(model->comm, &other.at, &here.at));
  for (PetscInt f = 0; f < MPM_VECTOR_FIELDS; f++)
    for (PetscInt i = 0; i < here.at.count * here.at.size[f]; i++)
      sum->at.at[f][i] = before * sum->at.at[f][i] + factor * here.at.at[f][i];
  for (PetscInt i = 0; i < gradient->start.rows * gradient->objectives.count; i++)
    sum->curves[i] = before * sum->curves[i] + factor * other.curves[i];
  if (!first) PetscCall(StartDestroy(&other));
  PetscCall(StartDestroy(&here));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* D over a change into `start`. */
static PetscErrorCode FindDifference(MpmModel model, PetscInt k, PetscReal change, Start *start)
{
  const Stencil stencil = StencilOf(&model->gradient->parameters.at[k], change);

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < stencil.count; i++) PetscCall(AddStart(model, k, stencil.at[i], stencil.factor[i], start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* D(c) and D(c/2) to the limit, in `coarse`; their distance over the largest value of a field. */
static PetscErrorCode Extrapolate(MpmModel model, Start *coarse, Start *fine, PetscReal *distance)
{
  const MpmGradient *gradient = model->gradient;
  Start              here     = {0};

  PetscFunctionBeginUser;
  *distance = 0.;
  PetscCall(MpmPointVectorCopy(&coarse->at, PETSC_FALSE, &here.at));
  PetscCall(MpmPointVectorMove(model->comm, &fine->at, &here.at));
  for (PetscInt f = 0; f < MPM_VECTOR_FIELDS; f++) {
    PetscReal largest[2] = {0., 0.}; /* of the values, and of their distance */

    for (PetscInt i = 0; i < here.at.count * here.at.size[f]; i++) {
      PetscReal *value = &coarse->at.at[f][i], other = here.at.at[f][i];

      largest[0] = PetscMax(largest[0], PetscAbsReal(other));
      largest[1] = PetscMax(largest[1], PetscAbsReal(other - *value));
      *value     = (4. * other - *value) / 3.;
    }
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, largest, 2, MPIU_REAL, MPIU_MAX, model->comm));
    if (largest[0] > 0.) *distance = PetscMax(*distance, largest[1] / largest[0]);
  }
  for (PetscInt i = 0; i < gradient->start.rows * gradient->objectives.count; i++)
    coarse->curves[i] = (4. * fine->curves[i] - coarse->curves[i]) / 3.;
  PetscCall(StartDestroy(&here));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The derivative by parameter k. */
static PetscErrorCode FindOne(MpmModel model, PetscInt k, Start *best)
{
  PetscReal least = PETSC_INFINITY, change = LARGEST;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < CHANGES && least > AGREEMENT; i++, change *= 0.1) {
    Start     coarse = {0}, fine = {0};
    PetscReal distance;

    PetscCall(FindDifference(model, k, change, &coarse));
    PetscCall(FindDifference(model, k, 0.5 * change, &fine));
    PetscCall(Extrapolate(model, &coarse, &fine, &distance));
    PetscCall(StartDestroy(&fine));
    if (distance < least) {
      PetscCall(StartDestroy(best));
      *best = coarse;
      least = distance;
    } else PetscCall(StartDestroy(&coarse));
    if (model->caller.outcome.code) break;
  }
  PetscCall(PetscInfo(model->solver.snes, "start by %s: differences over 2 changes are %g apart\n",
                      model->gradient->parameters.at[k].name, (double)least));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientFindStart(MpmModel model)
{
  MpmGradient   *gradient = model->gradient;
  const PetscInt count    = gradient ? gradient->parameters.count : 0;
  PetscInt       size;

  PetscFunctionBeginUser;
  if (!gradient || !gradient->start.differs || !MpmGradientAnyClosed(gradient) || gradient->rows < 2)
    PetscFunctionReturn(PETSC_SUCCESS);
  size = gradient->start.rows * gradient->objectives.count;
  PetscCall(PetscCalloc1(count, &gradient->start.at));
  PetscCall(PetscCalloc1((count * size), &gradient->start.slopes));
  for (PetscInt k = 0; k < count && !model->caller.outcome.code; k++) {
    Start start = {0};

    if (!MpmGradientIsClosed(gradient, k)) continue;
    PetscCall(FindOne(model, k, &start));
    gradient->start.at[k] = start.at;
    PetscCall(PetscArraycpy(&gradient->start.slopes[k * size], start.curves, size));
    PetscCall(PetscFree(start.curves));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
