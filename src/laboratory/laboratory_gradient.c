/*
  Derivatives of a laboratory run, forward along each parameter (tangent), or backward for all of them (adjoint).

  The states of the steps are kept in rows, test after test, in the order of a change (point/stress_point_slopes.h). All
  ranks do alike.
*/
#include "base/outcome.h"
#include "options/options.h"
#include "point/material.h"
#include "laboratory/stress_point_slopes.h"
#include "query/point_vector.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "laboratory/laboratory_impl.h"

/* ---- parameters ---- */

/* True where a test's material has the parameter. */
static PetscBool Acts(const MpmSceneParameter *parameter, const MpmLaboratoryTest *test)
{
  return (PetscBool)(parameter->index == test->material);
}

static PetscErrorCode Check(MpmModel model)
{
  const MpmSceneParameters *parameters = &model->gradient->parameters;
  const MpmLaboratory      *laboratory = model->laboratory;

  PetscFunctionBeginUser;
  MpmCheckInput(model->gradient->method == MPM_GRADIENT_ADJOINT || model->gradient->method == MPM_GRADIENT_TANGENT,
                "-mpm_gradient_method: of a laboratory test must be adjoint or tangent");
  for (PetscInt k = 0; k < parameters->count; k++) {
    const MpmSceneParameter *parameter = &parameters->at[k];
    PetscBool                acts      = PETSC_FALSE;

    for (PetscInt t = 0; t < laboratory->count && parameter->kind == MPM_OF_LAW; t++)
      if (Acts(parameter, &laboratory->tests[t])) acts = PETSC_TRUE;
    MpmCheckInput(parameter->kind == MPM_OF_LAW,
                  "-mpm_parameters %s: there is no derivative of a laboratory test by it yet", parameter->name);
    MpmCheckInput(acts, "-mpm_parameters %s: no result depends on it: no test is of that material", parameter->name);
    MpmCheckInput(!PetscIsInfOrNanReal(parameter->value),
                  "-mpm_parameters %s: the scene does not give it: there is no derivative by it", parameter->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- states ---- */

static PetscErrorCode Record(MpmModel model)
{
  MpmLaboratory  *laboratory = model->laboratory;
  const PetscInt  size       = laboratory->size;
  const PetscReal limit      = model->gradient->tape.states.limit;
  const PetscReal bytes      = (PetscReal)(laboratory->kept + 1) * (PetscReal)(size * model->size) * sizeof(PetscReal);

  PetscFunctionBeginUser;
  MpmCheckInput(bytes <= limit, "-mpm_gradient_memory %g: is too little: %" PetscInt_FMT " states take %g bytes",
                (double)limit, laboratory->kept + 1, (double)bytes);
  PetscCall(PetscRealloc((size_t)((laboratory->kept + 1) * size) * sizeof(PetscReal), &laboratory->states));
  for (PetscInt t = 0; t < laboratory->count; t++) {
    const MpmLaboratoryTest *test = &laboratory->tests[t];
    const MpmPointState     *now  = &test->point.now;
    PetscReal               *row  = &laboratory->states[size * laboratory->kept + test->first];

    PetscCall(PetscArraycpy(&row[MPM_CHANGE_STRAIN], now->strain, MPM_SPACE_SYM));
    PetscCall(PetscArraycpy(&row[MPM_CHANGE_STRESS], now->stress, MPM_SPACE_SYM));
    PetscCall(PetscArraycpy(&row[MPM_CHANGE_F], now->F, 9));
    PetscCall(PetscArraycpy(&row[MPM_CHANGE_CARRIER], test->point.F_start, 9));
    PetscCall(PetscArraycpy(&row[MPM_CHANGE_HISTORY], now->history, test->point.material->state_size));
  }
  laboratory->kept++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points stand at a state that has been kept. */
static PetscErrorCode Stand(MpmLaboratory *laboratory, PetscInt n)
{
  PetscFunctionBeginUser;
  for (PetscInt t = 0; t < laboratory->count; t++) {
    const MpmLaboratoryTest *test = &laboratory->tests[t];
    const PetscReal         *row  = &laboratory->states[laboratory->size * n + test->first];
    MpmPointState           *now  = &laboratory->tests[t].point.now;

    PetscCall(PetscArraycpy(now->strain, &row[MPM_CHANGE_STRAIN], MPM_SPACE_SYM));
    PetscCall(PetscArraycpy(now->stress, &row[MPM_CHANGE_STRESS], MPM_SPACE_SYM));
    PetscCall(PetscArraycpy(now->F, &row[MPM_CHANGE_F], 9));
    PetscCall(PetscArraycpy(now->history, &row[MPM_CHANGE_HISTORY], test->point.material->state_size));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Of the step from state n - 1 to state n of all tests, whose points then stand at its start. */
static PetscErrorCode CreateSlopes(MpmModel model, PetscInt n, MpmStressPointSlopes slopes[])
{
  MpmLaboratory   *laboratory = model->laboratory;
  const PetscReal *times = model->gradient->times, *next = &laboratory->states[laboratory->size * n];
  MpmPointControl  control;

  PetscFunctionBeginUser;
  PetscCall(Stand(laboratory, n - 1));
  for (PetscInt t = 0; t < laboratory->count; t++) {
    MpmLaboratoryTest *test = &laboratory->tests[t];

    MpmPointPathAt(&test->path, times[n], &control);
    PetscCall(MpmStressPointSlopesCreate(&test->point, &control, times[n] - times[n - 1],
                                         &next[test->first + MPM_CHANGE_STRAIN], &slopes[t]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DestroySlopes(const MpmLaboratory *laboratory, MpmStressPointSlopes slopes[])
{
  PetscFunctionBeginUser;
  for (PetscInt t = 0; t < laboratory->count; t++) PetscCall(MpmStressPointSlopesDestroy(&slopes[t]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The state after the last step, and no others. */
static PetscErrorCode Finish(MpmModel model)
{
  MpmLaboratory *laboratory = model->laboratory;

  PetscFunctionBeginUser;
  PetscCall(Stand(laboratory, laboratory->kept - 1));
  PetscCall(PetscFree(laboratory->states));
  laboratory->kept = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The change of state n of all tests along a parameter, with that of the state before it, or NULL: that does not change.
  `slopes`: of the step to it; NULL: state 0.
*/
static PetscErrorCode Along(MpmModel model, const MpmStressPointSlopes slopes[], PetscInt k, const PetscReal before[],
                            PetscReal change[])
{
  const MpmLaboratory     *laboratory = model->laboratory;
  const MpmSceneParameter *parameter  = &model->gradient->parameters.at[k];
  const MpmMaterial       *material   = &model->scene.materials->at[parameter->index];
  MpmOutcome              *outcome    = &model->caller.outcome;
  PetscReal               *direction;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(change, laboratory->size));
  PetscCall(PetscCalloc1((PetscInt)material->info.parameter_count, &direction));
  MpmMaterialDirection(material, parameter->place, 1., 1, direction);
  for (PetscInt t = 0; t < laboratory->count && !outcome->code; t++) {
    const MpmLaboratoryTest *test = &laboratory->tests[t];

    if (slopes)
      PetscCall(MpmStressPointSlopesAlong(&slopes[t], Acts(parameter, test) ? direction : NULL,
                                          before ? &before[test->first] : NULL, &change[test->first], outcome));
    else if (Acts(parameter, test))
      PetscCall(MpmStressPointStartAlong(&test->point, test->start, direction, &change[test->first], outcome));
  }
  PetscCall(PetscFree(direction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- tangent ---- */

/* Derivatives of the objectives' columns along a change of the state in which the points stand. */
static PetscErrorCode FindSlopes(MpmModel model, PetscReal change[], PetscReal slopes[])
{
  const MpmGradient   *gradient = model->gradient;
  const MpmColumns    *columns  = &model->results->columns;
  const MpmPointVector end      = {.count = 1, .state_size = model->laboratory->size, .state = change};

  PetscFunctionBeginUser;
  for (PetscInt o = 0; o < gradient->objectives.count; o++) {
    const MpmObjective *objective                 = &gradient->objectives.at[o];
    PetscReal           values[MPM_MAX_BLOCK + 1] = {0.};

    PetscCall((*columns->map[objective->row]->along)(model, &columns->at[objective->row], &end, NULL, values));
    slopes[o] = values[objective->part];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* State n along each parameter, side by side in `change`, from the state before. */
static PetscErrorCode StepForward(MpmModel model, PetscInt n, MpmStressPointSlopes slopes[], PetscReal next[],
                                  PetscReal change[])
{
  MpmGradient   *gradient = model->gradient;
  const PetscInt count = gradient->parameters.count, size = model->laboratory->size;
  const PetscInt objectives = gradient->objectives.count;

  PetscFunctionBeginUser;
  if (n) PetscCall(CreateSlopes(model, n, slopes));
  for (PetscInt k = 0; k < count; k++) {
    PetscCall(Along(model, n ? slopes : NULL, k, &change[k * size], next));
    PetscCall(PetscArraycpy(&change[k * size], next, size));
  }
  if (n) PetscCall(DestroySlopes(model->laboratory, slopes));
  PetscCall(Stand(model->laboratory, n));
  for (PetscInt k = 0; k < count; k++)
    PetscCall(FindSlopes(model, &change[k * size], &gradient->slopes[(k * gradient->rows + n) * objectives]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunForward(MpmModel model, PetscReal values[])
{
  MpmGradient          *gradient   = model->gradient;
  MpmLaboratory        *laboratory = model->laboratory;
  const PetscInt        count = gradient->parameters.count, size = laboratory->size, rows = gradient->rows;
  MpmStressPointSlopes *slopes;
  PetscReal            *change, *next;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc3((count * size), &change, size, &next, laboratory->count, &slopes));
  PetscCall(PetscFree(gradient->slopes));
  PetscCall(PetscCalloc1((count * rows * gradient->objectives.count), &gradient->slopes));
  for (PetscInt n = 0; n < rows && !model->caller.outcome.code; n++)
    PetscCall(StepForward(model, n, slopes, next, change));
  MpmGradientSumSlopes(gradient, values);
  PetscCall(PetscFree3(change, next, slopes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- adjoint ---- */

/* Adds the derivatives of the objectives' sum by state n, through its columns. */
static PetscErrorCode PullObjectives(MpmModel model, PetscInt n, PetscReal bar[])
{
  const MpmGradient *gradient = model->gradient;
  const MpmColumns  *columns  = &model->results->columns;
  MpmPointVector     end      = {.count = 1, .state_size = model->laboratory->size, .state = bar};

  PetscFunctionBeginUser;
  PetscCall(Stand(model->laboratory, n));
  for (PetscInt o = 0; o < gradient->objectives.count; o++) {
    const MpmObjective *objective                 = &gradient->objectives.at[o];
    PetscReal           weight[MPM_MAX_BLOCK + 1] = {0.};

    weight[objective->part] = gradient->weights[o * gradient->rows + n];
    PetscCall((*columns->map[objective->row]->pull)(model, &columns->at[objective->row], weight, &end, NULL));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivatives by state n become those by the state before, and what parameters add to state n is summed. */
static PetscErrorCode StepBackward(MpmModel model, PetscInt n, MpmStressPointSlopes slopes[], PetscReal work[],
                                   PetscReal bar[], PetscReal values[])
{
  const MpmLaboratory *laboratory = model->laboratory;
  MpmOutcome          *outcome    = &model->caller.outcome;

  PetscFunctionBeginUser;
  PetscCall(PullObjectives(model, n, bar));
  if (n) PetscCall(CreateSlopes(model, n, slopes));
  for (PetscInt k = 0; k < model->gradient->parameters.count && !outcome->code; k++) {
    PetscCall(Along(model, n ? slopes : NULL, k, NULL, work));
    for (PetscInt i = 0; i < laboratory->size; i++) values[k] += bar[i] * work[i];
  }
  if (!n) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt t = 0; t < laboratory->count; t++) {
    const PetscInt first = laboratory->tests[t].first;

    PetscCall(MpmStressPointSlopesPull(&slopes[t], &bar[first], &work[first]));
  }
  PetscCall(PetscArraycpy(bar, work, laboratory->size));
  PetscCall(DestroySlopes(laboratory, slopes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode RunBackward(MpmModel model, PetscReal values[])
{
  const MpmLaboratory  *laboratory = model->laboratory;
  MpmStressPointSlopes *slopes;
  PetscReal            *bar, *work;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc3(laboratory->size, &bar, laboratory->size, &work, laboratory->count, &slopes));
  for (PetscInt n = model->gradient->rows - 1; n >= 0 && !model->caller.outcome.code; n--)
    PetscCall(StepBackward(model, n, slopes, work, bar, values));
  PetscCall(PetscFree3(bar, work, slopes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- reading ---- */

PetscErrorCode MpmLaboratoryReadGradient(MpmModel model, const MpmOptions *options)
{
  static const MpmGradientKind kind = {.check       = Check,
                                       .add_columns = MpmLaboratoryAddColumns,
                                       .record      = Record,
                                       .find        = {RunBackward, RunForward},
                                       .finish      = Finish};

  PetscFunctionBeginUser;
  PetscCall(MpmGradientRead(model, options, &kind));
  PetscFunctionReturn(PETSC_SUCCESS);
}
