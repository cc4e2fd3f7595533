/*
  The steps of a model: one at a time for who calls the library, and the run of all of them with its results.
*/
#include "options/options.h"
#include "particles/particles.h"
#include "query/model.h"
#include "scene/scene_read.h"
#include "step/water_state.h"
#include "integrators/consolidation.h"
#include "schedule/schedule.h"
#include "schedule/stage.h"
#include "geostatic/geostatic.h"
#include "runout/runout.h"
#include "observe/history.h"
#include "observe/lines.h"
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "checkpoint/checkpoint.h"
#include "model/build.h"
#include "laboratory/laboratory.h"

/* Reason for which the last step was given up, or NULL. */
static const char *Reason(const MpmModel model)
{
  return model->caller.outcome.code ? model->caller.outcome.text : NULL;
}

/* ---- one step ---- */

static PetscBool AtStageEnd(const MpmModel model)
{
  return (PetscBool)(!model->state.scheme.rescuing.on && model->state.time >= model->state.period.end * (1. - 1e-12));
}

/* The end of a stage, and the results that its state has. */
static PetscErrorCode FinishStage(MpmModel model, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  PetscCall(MpmStageFinish(model, outcome));
  if (!outcome->code) PetscCall(MpmRunoutFinish(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True at the end of the last stage. */
static PetscBool AtEnd(const MpmModel model)
{
  if (model->laboratory) return MpmLaboratoryIsAtEnd(model);
  return (PetscBool)(AtStageEnd(model) && model->state.stage + 1 >= model->scene.stages.count);
}

/*
  The next step, in the next stage where this one has ended; a geostatic stage is a single step for the results. Where a
  relaxation replaces a step it is one of that, without a report until it has come to rest.
*/
static PetscErrorCode TakeStep(MpmModel model, PetscReal *dt)
{
  const PetscBool begins  = (PetscBool)!model->state.scheme.rescuing.on;
  MpmOutcome     *outcome = &model->caller.outcome;
  PetscInt        before;
  const MpmStage *stage;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  if (AtStageEnd(model)) {
    PetscCall(FinishStage(model, outcome));
    if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(MpmStageBegin(model, model->state.stage + 1));
    PetscCall(MpmGradientStage(model));
  }
  before = model->state.step;
  stage  = &model->scene.stages.at[model->state.stage];
  if (begins && stage->name && model->state.time == model->state.period.start)
    PetscCall(MpmMonitorNote(&model->monitor, "stage %s", stage->name));
  if (begins && model->state.time == model->state.period.start) {
    PetscCall(MpmWaterTellStage(model));
    PetscCall(MpmSurfacesTellHeld(model));
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  if (begins && model->caller.before) PetscCall((*model->caller.before)(model, model->caller.before_ctx));
  if (stage->geostatic.method != MPM_GEOSTATIC_NONE) {
    PetscCall(MpmGeostaticRun(model, outcome));
    *dt = model->state.time - model->state.period.start;
  } else PetscCall(MpmAdvance(model, dt, outcome));
  if (!outcome->code && model->state.step > before) PetscCall(MpmRunoutObserve(model, *dt));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  if (outcome->code) PetscCall(MpmWaterFindClosed(model, outcome));
  if (!outcome->code && !model->state.scheme.rescuing.on && model->state.step > before && model->caller.after)
    PetscCall((*model->caller.after)(model, model->caller.after_ctx));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode StepOnce(MpmModel model)
{
  PetscReal dt;

  PetscFunctionBeginUser;
  model->caller.stop = PETSC_FALSE;
  do PetscCall(TakeStep(model, &dt));
  while (model->state.scheme.rescuing.on && !model->caller.outcome.code);
  if (!model->caller.outcome.code && AtEnd(model)) PetscCall(FinishStage(model, &model->caller.outcome));
  if (!model->caller.outcome.code) PetscCall(MpmWaterFindHeave(model, &model->caller.outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelStep(MpmModel model, MpmStatus *status)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelSetUp(model));
  *status = MPM_COMPLETED;
  if (AtEnd(model)) PetscFunctionReturn(PETSC_SUCCESS);
  MpmModelCall(model, model->laboratory ? MpmLaboratoryStep(model) : StepOnce(model));
  *status = model->caller.outcome.code ? MPM_GAVE_UP
            : AtEnd(model)             ? MPM_COMPLETED
            : model->caller.stop       ? MPM_STOPPED
                                       : MPM_RUNNING;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* True where results are written for the step's number. */
static PetscBool IsDue(const MpmModel model)
{
  const MpmResults *results = model->results;

  return (PetscBool)(results->states.every && model->state.step % results->states.every == 0);
}

/* True where the state waits until the run's last stage has been finished. */
static PetscBool Waits(const MpmModel model)
{
  return (PetscBool)(AtEnd(model) && MpmStageHasFinish(model));
}

/* Output that needs a step's nodal data, which checkpoints do not hold: forces in cuts, stresses along lines, the
   grid. */
static PetscErrorCode WriteStep(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(MpmLinesWrite(model));
  PetscCall(MpmModelWriteGrid(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Output of a step, and the points. */
static PetscErrorCode WriteDue(MpmModel model)
{
  PetscFunctionBeginUser;
  if (!IsDue(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(WriteStep(model));
  if (!Waits(model)) PetscCall(MpmModelWriteState(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Result files, new or those of the run that goes on; a new one starts with the present state. */
static PetscErrorCode OpenResults(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->results->states.every) {
    PetscCall(MpmOutputCreate(model->comm, model->scene.name.prefix, &model->results->states.file));
    PetscCall(MpmOutputSetSingle(model->results->states.file, model->results->states.single));
    if (model->results->states.alone)
      PetscCall(MpmOutputSetStateFiles(model->results->states.file, model->scene.name.prefix));
  }
  if (model->results->states.file && model->results->checkpoint.restart)
    PetscCall(MpmRestartOutput(model, PETSC_FALSE));
  PetscCall(MpmModelCreateHistory(model));
  if (model->results->states.file && model->results->checkpoint.restart) PetscCall(MpmRestartOutput(model, PETSC_TRUE));
  if (Waits(model)) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->results->states.file && !MpmOutputStarted(model->results->states.file)) {
    PetscCall(MpmModelWriteState(model));
    PetscCall(WriteStep(model));
  } else if (IsDue(model) && !AtEnd(model) && model->results->states.step != model->state.step)
    PetscCall(MpmModelWriteState(model)); /* of a run that has ended here, and goes on */
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of PETSc's that are still unused. */
static PetscErrorCode WarnUnused(MpmModel model, MpmMoment moment)
{
  const MpmOptions options = {model->comm, NULL, model->record};

  PetscFunctionBeginUser;
  if (model->caller.terminal) PetscCall(MpmOptionsWarnUnused(&options, moment));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Output of a converged step: its row, its line, and at times the points. */
static PetscErrorCode Report(MpmModel model, PetscReal dt)
{
  char line[MPM_WATER_TEXT];

  PetscFunctionBeginUser;
  model->results->dt = dt;
  if (model->state.step % model->results->history_every == 0 || AtEnd(model)) PetscCall(MpmModelWriteHistory(model));
  PetscCall(MpmTerminalStep(model, dt));
  PetscCall(MpmWaterFindTension(model, line));
  if (line[0]) PetscCall(MpmTerminalWarn(model, "%s", line));
  PetscCall(MpmWaterFindLost(model, line));
  if (line[0]) PetscCall(MpmTerminalWarn(model, "%s", line));
  if (model->solver.iterations.linear_total) PetscCall(WarnUnused(model, MPM_AFTER_SOLVE));
  PetscCall(WriteDue(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The row of the last step, where it was not due. A step that failed has overwritten the nodal data that it needs. */
static PetscErrorCode WriteLastRow(MpmModel model)
{
  PetscFunctionBeginUser;
  if (model->results->history_step < model->state.step && model->disc.nodal.committed)
    PetscCall(MpmModelWriteHistory(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Output at the end of a run, whatever has ended it. */
static PetscErrorCode Finish(MpmModel model, PetscBool interrupted)
{
  const MpmResults *results = model->results;
  const char       *why;
  PetscBool         gone, step;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  if (!model->caller.outcome.code && AtEnd(model)) PetscCall(FinishStage(model, &model->caller.outcome));
  why  = Reason(model);
  gone = model->state.particles->gone;
  step = (PetscBool)(results->states.file && (!IsDue(model) || !MpmOutputStarted(results->states.file)));
  if ((why || model->caller.stop) && !gone) PetscCall(MpmCheckpointWrite(model));
  if (!gone) PetscCall(WriteLastRow(model));
  if (!interrupted && results->states.every && results->states.step != model->state.step && !gone) {
    PetscCall(MpmModelWriteState(model));
    if (step) PetscCall(WriteStep(model));
  }
  if (results->states.file) PetscCall(MpmOutputFinish(results->states.file));
  if (!gone) PetscCall(MpmRunoutWrite(model));
  if (why) {
    PetscCall(MpmTerminalWarn(model, "gave up after step %" PetscInt_FMT " at time %g: %s", model->state.step,
                              (double)model->state.time, why));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelRunSteps(MpmModel model, PetscBool *interrupted)
{
  PetscReal dt;

  PetscFunctionBeginUser;
  if (model->laboratory) PetscFunctionReturn(MpmLaboratoryRunSteps(model, interrupted));
  MpmOutcomeClear(&model->caller.outcome);
  PetscCall(MpmTerminalBegin(model, NULL));
  PetscCall(MpmGradientBegin(model));
  PetscCall(OpenResults(model));
  model->results->history_step = model->state.step;
  if (model->gradient) PetscCall(MpmGradientCollect(model));
  PetscCall(MpmCheckpointStep(model, interrupted));
  while (!*interrupted && !model->caller.stop && !model->caller.points && !AtEnd(model)) {
    const PetscInt before = model->state.step;

    PetscCall(TakeStep(model, &dt));
    if (model->caller.outcome.code && model->state.step == before) break;
    if (!model->state.scheme.rescuing.on && model->state.step > before) PetscCall(Report(model, dt));
    if (model->state.step > before) PetscCall(MpmGradientRecord(model));
    if (!model->caller.outcome.code) PetscCall(MpmWaterFindHeave(model, &model->caller.outcome));
    if (model->caller.outcome.code) break;
    PetscCall(MpmCheckpointStep(model, interrupted));
  }
  if (AtEnd(model)) model->caller.stop = PETSC_FALSE;
  PetscCall(Finish(model, *interrupted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelRunEnd(MpmModel model, PetscBool interrupted)
{
  const char *why = Reason(model);

  PetscFunctionBeginUser;
  PetscCall(MpmModelWriteSummary(model, why                  ? why
                                        : interrupted        ? "interrupted"
                                        : model->caller.stop ? "stopped"
                                                             : "completed"));
  PetscCall(WarnUnused(model, MPM_AT_END));
  if (!model->laboratory) PetscCall(MpmModelViewFromOptions(model));
  if (interrupted) PetscCall(MpmTerminalInterrupted(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- settings and requests of the caller ---- */

PetscErrorCode MpmModelStop(MpmModel model)
{
  PetscFunctionBeginUser;
  model->caller.stop = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelGetReason(MpmModel model, const char **why)
{
  PetscFunctionBeginUser;
  *why = Reason(model);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelGetTime(MpmModel model, PetscReal *time, PetscInt *step)
{
  PetscFunctionBeginUser;
  if (time) *time = model->state.time;
  if (step) *step = model->state.step;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelGetTimeStep(MpmModel model, PetscReal *dt)
{
  PetscFunctionBeginUser;
  PetscCheck(model->caller.set_up, model->comm, PETSC_ERR_ARG_WRONGSTATE, "MpmModelSetUp() comes first");
  *dt = model->state.dt.wanted;
  if (!AtStageEnd(model)) (void)MpmNextTime(model, model->state.dt.wanted, dt);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetTimeStep(MpmModel model, PetscReal dt)
{
  PetscFunctionBeginUser;
  PetscCheck(model->caller.set_up, model->comm, PETSC_ERR_ARG_WRONGSTATE, "MpmModelSetUp() comes first");
  PetscCheck(dt > 0. && !PetscIsInfOrNanReal(dt), model->comm, PETSC_ERR_ARG_OUTOFRANGE,
             "a step of %g: must be a finite number > 0", (double)dt);
  model->state.dt.wanted = dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetBeforeStep(MpmModel model, MpmStepHook hook, void *ctx)
{
  PetscFunctionBeginUser;
  model->caller.before     = hook;
  model->caller.before_ctx = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetAfterStep(MpmModel model, MpmStepHook hook, void *ctx)
{
  PetscFunctionBeginUser;
  model->caller.after     = hook;
  model->caller.after_ctx = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}
