/*
  The task `gradient`: a run, and the derivatives of its objectives by its parameters.
*/
#include "base/columns.h"
#include "options/options.h"
#include "grid/grid.h"
#include "observe/history.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "sensitivity/replayed_step.h"

#define MEMORY 4e9 /* bytes for the states of the steps, by default */

const char *const MpmGradientMethods[] = {"adjoint", "tangent", "twins", NULL};

static PetscErrorCode ReadBlocks(MpmModel model, const MpmOptions *options, MpmGradient *gradient)
{
  const MpmOptions block  = {options->comm, "mpm_gradient_", options->record};
  PetscInt         method = 0, store = MPM_STORE_MEMORY;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHeading(&block, "Derivatives of a run (-mpm_task gradient)"));
  PetscCall(MpmOptionsWord(&block, "method",
                           "adjoint: one run backward for any number of parameters; tangent: one forward for each; "
                           "twins: runs with each parameter a little larger and smaller, as all parts of a scene take "
                           "that have no derivatives in closed form yet",
                           MpmGradientMethods, MPM_OPTIONAL, &method, NULL));
  gradient->method            = (MpmGradientMethod)method;
  gradient->tape.states.limit = MEMORY;
  PetscCall(MpmOptionsReal(&block, "memory", "bytes",
                           "for the states of the steps, over all ranks; those that it does not take are found again",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &gradient->tape.states.limit, NULL));
  PetscCall(MpmOptionsWord(&block, "store",
                           "where the states of the steps are kept; disk: all, in files beside the "
                           "results, which are gone after the run",
                           MpmTapeStoreKinds, MPM_OPTIONAL, &store, NULL));
  gradient->tape.states.kind = (MpmTapeStoreKind)store;
  PetscCall(MpmSceneParametersRead(options, &model->scene, &gradient->grounds, &gradient->parameters));
  PetscCall(MpmParameterRangesRead(options, &gradient->parameters, &gradient->ranges));
  for (PetscInt k = 0; k < gradient->grounds.count; k++)
    PetscCall(MpmParameterRangesAddField(options, gradient->grounds.at[k].block, k, gradient->grounds.at[k].ground,
                                         gradient->inverse.on, &gradient->ranges));
  PetscCall(MpmObjectivesRead(options, model->state.period.run_end, &gradient->objectives));
  PetscCall(MpmInverseSettingsRead(options, &gradient->inverse));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An inverse analysis by fields. */
static PetscErrorCode CheckFields(const MpmGradient *gradient)
{
  const MpmInverseSettings *inverse = &gradient->inverse;
  const PetscInt            values  = gradient->grounds.values;

  PetscFunctionBeginUser;
  if (!inverse->on) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(inverse->method != MPM_GAUSS_NEWTON || values <= MPM_MOST_TANGENTS,
                "-mpm_inverse_method gauss_newton: the fields have %" PetscInt_FMT " values; must be blmvm above %d",
                values, MPM_MOST_TANGENTS);
  MpmCheckInput(!values || inverse->starts == 1,
                "-mpm_inverse_starts %d: must be 1 where values of fields are parameters", (int)inverse->starts);
  for (PetscInt k = 0; k < gradient->objectives.regular_count; k++) {
    const MpmRegularization *regular = &gradient->objectives.regular[k];
    PetscInt                 f       = 0;

    while (f < gradient->grounds.count && strcmp(gradient->grounds.at[f].ground->name, regular->field)) f++;
    MpmCheckInput(f < gradient->grounds.count, "-mpm_objective_%s_field %s: is no field among -mpm_parameters",
                  regular->name, regular->field);
    PetscCall(MpmRegularizationCheck(regular, gradient->grounds.at[f].ground));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Blocks that the task needs. */
static PetscErrorCode CheckBlocks(const MpmGradient *gradient, const char task[])
{
  const MpmInverseSettings *inverse = &gradient->inverse;

  PetscFunctionBeginUser;
  MpmCheckInput(gradient->parameters.count + gradient->grounds.count,
                "-mpm_parameters is missing: -mpm_task %s needs parameters", task);
  MpmCheckInput(gradient->objectives.asked, "-mpm_objectives is missing: -mpm_task %s needs objectives", task);
  for (PetscInt k = 0; inverse->on && k < gradient->objectives.asked; k++)
    MpmCheckInput(gradient->objectives.at[k].kind == MPM_OBJECTIVE_MISFIT || inverse->method != MPM_GAUSS_NEWTON,
                  "-mpm_objective_%s_kind value: -mpm_inverse_method gauss_newton fits data, a value is none",
                  gradient->objectives.at[k].name);
  for (PetscInt k = 0; k < gradient->objectives.regular_count; k++)
    MpmCheckInput(inverse->on, "-mpm_objective_%s_kind: -mpm_task %s has no regularization; inverse has",
                  gradient->objectives.regular[k].name, task);
  PetscCall(CheckFields(gradient));
  for (PetscInt k = 0; inverse->on && inverse->starts > 1 && k < gradient->ranges.count; k++)
    MpmCheckInput(gradient->ranges.at[k].upper < PETSC_INFINITY && gradient->ranges.at[k].lower > PETSC_NINFINITY,
                  "-mpm_parameter_%s_bounds is missing: -mpm_inverse_starts %d are made between bounds",
                  gradient->ranges.at[k].name, (int)inverse->starts);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientAddColumns(MpmModel model, MpmColumns *columns)
{
  const MpmGradientKind *kind = model->gradient->kind;

  PetscFunctionBeginUser;
  PetscCall((kind ? kind->add_columns : MpmHistoryAddColumns)(model, columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The objectives' columns among those that the history will have. */
static PetscErrorCode FindColumns(MpmModel model)
{
  MpmGradient *gradient = model->gradient;
  MpmColumns   columns  = {0};

  PetscFunctionBeginUser;
  PetscCall(MpmGradientAddColumns(model, &columns));
  PetscCall(MpmObjectivesFind(&columns, &gradient->objectives));
  for (PetscInt o = 0; o < gradient->objectives.count && !gradient->kind && !gradient->open[0]; o++)
    if (!columns.map[gradient->objectives.at[o].row])
      PetscCall(PetscSNPrintf(gradient->open, MPM_OPEN_TEXT, "the column %s", gradient->objectives.at[o].column));
  PetscCall(MpmColumnsDestroy(&columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientRead(MpmModel model, const MpmOptions *options, const MpmGradientKind *kind)
{
  static const char *const tasks[] = {"run", "gradient", "check_gradient", "inverse", "points", "ensemble", NULL};
  PetscInt                 task    = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsWord(
    options, "task",
    "run: the steps; gradient: also the derivatives of objectives by parameters; check_gradient: also by both "
    "methods and by differences of changed runs; inverse: parameters from data; points: the points are made and "
    "written; ensemble: runs with drawn numbers",
    tasks, MPM_OPTIONAL, &task, NULL));
  model->caller.points = (PetscBool)(task == 4);
  if ((!task || task > 3) && !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(&model->gradient));
  model->gradient->kind       = kind;
  model->gradient->checks     = (PetscBool)(task == 2);
  model->gradient->inverse.on = (PetscBool)(task == 3);
  PetscCall(ReadBlocks(model, options, model->gradient));
  if (MpmOptionsHelp()) PetscFunctionReturn(MpmGradientDestroy(&model->gradient));
  PetscCall(CheckBlocks(model->gradient, tasks[task]));
  if (kind) PetscCall((*kind->check)(model));
  else {
    PetscCall(MpmGradientCheckUse(model));
    PetscCall(MpmGradientFindOpen(model, model->gradient->open));
  }
  PetscCall(MpmFieldParametersCheck(model, &model->gradient->grounds));
  if (model->gradient->checks && model->gradient->grounds.count) model->gradient->method = MPM_GRADIENT_ADJOINT;
  if (!kind) model->disc.grid->balance = PETSC_INFINITY; /* replayed steps have the numbers of their nodes */
  PetscCall(FindColumns(model));
  MpmCheckInput(!model->gradient->grounds.count ||
                  (!model->gradient->open[0] && model->gradient->method != MPM_GRADIENT_TWINS),
                "-mpm_parameters: derivatives by fields have closed forms alone; there are none yet with %s",
                model->gradient->open[0] ? model->gradient->open : "-mpm_gradient_method twins");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientDestroy(MpmGradient **gradient)
{
  PetscFunctionBeginUser;
  if (!*gradient) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParameterRangesDestroy(&(*gradient)->ranges));
  PetscCall(MpmFieldParametersDestroy(&(*gradient)->grounds));
  PetscCall(MpmObjectivesDestroy(&(*gradient)->objectives));
  PetscCall(MpmTapeDestroy(&(*gradient)->tape));
  PetscCall(PetscFree((*gradient)->curves));
  PetscCall(PetscFree((*gradient)->times));
  PetscCall(PetscFree((*gradient)->weights));
  PetscCall(PetscFree((*gradient)->slopes));
  PetscCall(PetscFree((*gradient)->signatures));
  for (PetscInt k = 0; (*gradient)->start.at && k < (*gradient)->parameters.count; k++)
    PetscCall(MpmPointVectorDestroy(&(*gradient)->start.at[k]));
  PetscCall(PetscFree((*gradient)->start.at));
  PetscCall(PetscFree((*gradient)->start.slopes));
  PetscCall(MpmSceneParametersDestroy(&(*gradient)->parameters));
  PetscCall(PetscFree(*gradient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

PetscBool MpmGradientIsClosed(const MpmGradient *gradient, PetscInt k)
{
  return (PetscBool)(!gradient->open[0] && gradient->method != MPM_GRADIENT_TWINS &&
                     (k >= gradient->parameters.count || gradient->parameters.at[k].kind != MPM_OF_OPTION));
}

PetscBool MpmGradientAnyClosed(const MpmGradient *gradient)
{
  for (PetscInt k = 0; k < gradient->parameters.count; k++)
    if (MpmGradientIsClosed(gradient, k)) return PETSC_TRUE;
  return (PetscBool)(gradient->grounds.count && !gradient->open[0]);
}

PetscErrorCode MpmGradientCollect(MpmModel model)
{
  MpmGradient      *gradient = model->gradient;
  const MpmColumns *columns  = &model->results->columns;
  const PetscInt    count    = gradient->objectives.count;

  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)((gradient->rows + 1) * count) * sizeof(PetscReal), &gradient->curves));
  PetscCall(PetscRealloc((size_t)(gradient->rows + 1) * sizeof(PetscReal), &gradient->times));
  for (PetscInt o = 0; o < count; o++) {
    const MpmObjective *objective                 = &gradient->objectives.at[o];
    const MpmColumn    *row                       = &columns->at[objective->row];
    PetscReal           values[MPM_MAX_BLOCK + 1] = {0.};

    PetscCall((*row->fill)(model, row, values));
    gradient->curves[gradient->rows * count + o] = values[objective->part];
  }
  PetscCall(PetscRealloc((size_t)(gradient->rows + 1) * sizeof(PetscReal), &gradient->signatures));
  PetscCall(MpmSignatureFind(model, &gradient->signatures[gradient->rows]));
  gradient->times[gradient->rows++] = model->state.time;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientBegin(MpmModel model)
{
  PetscFunctionBeginUser;
  if (!model->gradient) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!model->results->checkpoint.restart,
                "-mpm_restart: derivatives need all steps of a run, and there are none of those before the checkpoint");
  if (model->gradient->kind) PetscFunctionReturn((*model->gradient->kind->record)(model));
  model->gradient->start.rows    = 1;
  model->gradient->start.differs = MpmGradientStartDiffers(model);
  if (!MpmGradientAnyClosed(model->gradient)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTapeBegin(model, &model->gradient->tape));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientRecord(MpmModel model)
{
  MpmGradient *gradient = model->gradient;

  PetscFunctionBeginUser;
  if (!gradient) PetscFunctionReturn(PETSC_SUCCESS);
  if (!gradient->kind) PetscCall(MpmGradientCheckRun(model, &model->caller.outcome));
  if (model->caller.outcome.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmGradientCollect(model));
  if (gradient->kind) PetscFunctionReturn((*gradient->kind->record)(model));
  if (!MpmGradientAnyClosed(gradient)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmGradientFindOpened(model, gradient->open));
  if (gradient->open[0] && gradient->grounds.count)
    PetscCall(MpmOutcomeFail(&model->caller.outcome, MPM_OUTCOME_INADMISSIBLE,
                             "there are no derivatives yet by fields with %s", gradient->open));
  if (gradient->open[0]) PetscCall(MpmTapeDestroy(&gradient->tape));
  else if (model->scene.stages.at[model->state.stage].geostatic.method == MPM_GEOSTATIC_NONE)
    PetscCall(MpmTapeRecord(model, gradient->rows - 1, &gradient->tape));
  else {
    gradient->start.rows = gradient->rows;
    PetscCall(MpmTapeRestart(model, &gradient->tape));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientStage(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->gradient && MpmGradientAnyClosed(model->gradient))
    PetscCall(MpmTapeRestart(model, &model->gradient->tape));
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmCurves MpmGradientCurves(const MpmGradient *gradient)
{
  return (MpmCurves){gradient->rows, gradient->objectives.count, gradient->times, gradient->curves};
}

/* The objectives' sum, and its derivatives by the columns' values. */
PetscErrorCode MpmGradientEvaluate(MpmModel model, PetscReal *objective)
{
  MpmGradient    *gradient = model->gradient;
  const MpmCurves curves   = MpmGradientCurves(gradient);

  PetscFunctionBeginUser;
  PetscCall(PetscFree(gradient->weights));
  PetscCall(PetscMalloc1((curves.rows * curves.count), &gradient->weights));
  PetscCall(MpmObjectivesEvaluate(&gradient->objectives, &curves, objective, gradient->weights));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmGradientSumSlopes(const MpmGradient *gradient, PetscReal values[])
{
  const PetscInt rows = gradient->rows, count = gradient->objectives.count;

  for (PetscInt k = 0; k < gradient->parameters.count + gradient->grounds.direction_count; k++) {
    values[k] = 0.;
    for (PetscInt o = 0; o < count; o++)
      for (PetscInt n = 0; n < rows; n++)
        values[k] += gradient->weights[o * rows + n] * gradient->slopes[(k * rows + n) * count + o];
  }
}

/* The gradient by the method chosen or, where both are compared, by the other one. The time is the gradient's own,
   whatever tasks of the engine it takes. */
static PetscErrorCode Differentiate(MpmModel model, PetscBool other, PetscReal values[])
{
  PetscErrorCode (*const on_grid[])(MpmModel, PetscReal[]) = {MpmAdjointRun, MpmTangentRun};
  const MpmGradient *gradient                              = model->gradient;
  const PetscInt     method = other ? 1 - (PetscInt)gradient->method : (PetscInt)gradient->method;
  PetscReal          seconds[MPM_TIME_COUNT];
  PetscLogDouble     since;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(seconds, model->monitor.seconds, MPM_TIME_COUNT));
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_GRADIENT, &since));
  PetscCall((gradient->kind ? gradient->kind->find[method] : on_grid[method])(model, values));
  PetscCall(PetscArraycpy(model->monitor.seconds, seconds, MPM_TIME_COUNT));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_GRADIENT, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGradientFind(MpmModel model)
{
  MpmGradient    *gradient = model->gradient;
  MpmDerivatives *found    = &model->results->derivatives;
  const PetscInt  count    = gradient ? gradient->parameters.count : 0;
  PetscInt        numbers;

  PetscFunctionBeginUser;
  if (!gradient || gradient->rows < 2) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmGradientEvaluate(model, &found->objective));
  numbers = count + PetscMax(gradient->grounds.values, gradient->grounds.count * MPM_GROUND_CHECKS);
  PetscCall(PetscMalloc2(count, &found->names, count, &found->methods));
  PetscCall(PetscCalloc2(numbers + 1, &found->gradient, count, &found->errors));
  for (PetscInt k = 0; k < count; k++) {
    found->names[k]   = gradient->parameters.at[k].name;
    found->methods[k] = MpmGradientMethods[MpmGradientIsClosed(gradient, k) ? gradient->method : MPM_GRADIENT_TWINS];
  }
  if (model->caller.outcome.code) PetscFunctionReturn(PETSC_SUCCESS); /* no derivatives */
  found->count = count;
  if (!MpmGradientAnyClosed(gradient)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Differentiate(model, PETSC_FALSE, found->gradient));
  if (gradient->checks) {
    PetscCall(PetscCalloc1(numbers + 1, &found->tangent));
    PetscCall(Differentiate(model, PETSC_TRUE, found->tangent));
  }
  if (gradient->kind) PetscCall((*gradient->kind->finish)(model));
  else PetscCall(MpmTapeFinish(model, &gradient->tape));
  if (model->caller.outcome.code) found->count = 0; /* no derivatives */
  PetscFunctionReturn(PETSC_SUCCESS);
}
