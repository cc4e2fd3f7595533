/*
  The steps of a run, kept and replayed.
*/
#include "particles/particles.h"
#include "space/space.h"
#include "space/sum.h"
#include "query/query.h"
#include "step/integrator.h"
#include "integrators/sdirk.h"
#include "schedule/schedule.h"
#include "schedule/stage.h"
#include "sensitivity/tape.h"

PetscErrorCode MpmTapeBegin(MpmModel model, MpmTape *tape)
{
  PetscFunctionBeginUser;
  tape->states.stride = 1;
  PetscCall(MpmTapeStoreAdd(model, 0, &tape->states));
  PetscCall(MpmTapeStoreCheck(model, &tape->states));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeRestart(MpmModel model, MpmTape *tape)
{
  PetscFunctionBeginUser;
  if (tape->states.count) PetscCall(MpmTapeStorePin(model, tape->count, &tape->states));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmTapeBeginsStage(const MpmTape *tape, PetscInt n)
{
  return (PetscBool)(!n || tape->step[n].stage != tape->step[n - 1].stage);
}

PetscErrorCode MpmTapeRecord(MpmModel model, PetscInt row, MpmTape *tape)
{
  const PetscScalar *x;
  MpmTapeStep       *step;

  PetscFunctionBeginUser;
  if (tape->count == tape->capacity) {
    tape->capacity = 2 * tape->capacity + 16;
    PetscCall(PetscRealloc((size_t)tape->capacity * sizeof(*tape->step), &tape->step));
  }
  step        = &tape->step[tape->count++];
  step->time  = model->state.time;
  step->dt    = model->disc.sum->step.span;
  step->stage = model->state.stage;
  step->row   = row;
  step->count = model->disc.space->owned * model->disc.block;
  PetscCall(PetscMalloc1((step->count + 1), &step->x));
  PetscCall(VecGetArrayRead(model->solver.x, &x));
  PetscCall(PetscArraycpy(step->x, x, step->count));
  PetscCall(VecRestoreArrayRead(model->solver.x, &x));
  step->first = NULL;
  if (model->state.scheme.integrator->second) {
    step->first                      = model->state.scheme.sdirk->first;
    model->state.scheme.sdirk->first = NULL;
  }
  PetscCall(MpmTapeStoreCount(model, (step->first ? 2. : 1.) * (PetscReal)step->count * (PetscReal)sizeof(PetscScalar),
                              &tape->states));
  PetscCall(MpmTapeStoreAdd(model, tape->count, &tape->states));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Conditions, loads and lengths of steps of a stage are in force again at the present time. */
static PetscErrorCode EnterStage(MpmModel model, PetscInt stage)
{
  PetscFunctionBeginUser;
  if (model->scene.stages.count == 1) PetscFunctionReturn(PETSC_SUCCESS);
  model->state.stage = stage;
  PetscCall(MpmStageResume(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bodies that are taken away by a ramp lose their part of a step. */
static PetscErrorCode Remove(MpmModel model, PetscReal time, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  if (!MpmRemovalGoesOn(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRemovalSet(model, time, outcome));
  PetscCall(MpmRemovalCommit(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmTapeHasTwoStages(const MpmTape *tape, PetscInt n)
{
  return (PetscBool)(tape->step[n].first != NULL);
}

/* A solution of a step, or of a stage, becomes the solver's. */
static PetscErrorCode TakeSolution(MpmModel model, const PetscScalar solution[], PetscBool evaluate)
{
  PetscScalar *x;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayWrite(model->solver.x, &x));
  PetscCall(PetscArraycpy(x, solution, model->disc.space->owned * model->disc.block));
  PetscCall(VecRestoreArrayWrite(model->solver.x, &x));
  if (evaluate) PetscCall(SNESComputeFunction(model->solver.snes, model->solver.x, model->solver.f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CheckReplay(MpmModel model, const MpmTape *tape, PetscInt n, const MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  PetscCheck(!outcome->code && tape->step[n].count == model->disc.space->owned * model->disc.block, model->comm,
             PETSC_ERR_PLIB, "step %" PetscInt_FMT " cannot be replayed: %s", n + 1,
             outcome->code ? outcome->text : "other unknowns");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeFirstStage(MpmModel model, const MpmTape *tape, PetscInt n)
{
  const MpmTapeStep *step = &tape->step[n];
  MpmOutcome         outcome;

  PetscFunctionBeginUser;
  PetscCall((*model->state.scheme.integrator->begin)(model, step->time, step->dt, PETSC_TRUE, &outcome));
  PetscCall(CheckReplay(model, tape, n, &outcome));
  PetscCall(TakeSolution(model, step->first, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* From the solution of the first stage, which is evaluated. */
static PetscErrorCode GoToSecond(MpmModel model, const MpmTape *tape, PetscInt n, PetscBool evaluate)
{
  MpmOutcome outcome;

  PetscFunctionBeginUser;
  PetscCall(SNESComputeFunction(model->solver.snes, model->solver.x, model->solver.f));
  PetscCall((*model->state.scheme.integrator->second)(model, &outcome));
  PetscCall(CheckReplay(model, tape, n, &outcome));
  PetscCall(TakeSolution(model, tape->step[n].x, evaluate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeSecondStage(MpmModel model, const MpmTape *tape, PetscInt n)
{
  return GoToSecond(model, tape, n, PETSC_TRUE);
}

/* The model, at a step's start, is brought to its solution; evaluated there, if the step is to be accepted. */
static PetscErrorCode GoToSolution(MpmModel model, const MpmTape *tape, PetscInt n, PetscBool evaluate)
{
  const MpmTapeStep *step = &tape->step[n];
  MpmOutcome         outcome;

  PetscFunctionBeginUser;
  PetscCall(EnterStage(model, step->stage));
  PetscCall(MpmStepArrange(model, &outcome));
  if (!outcome.code) PetscCall(Remove(model, step->time, &outcome));
  if (!outcome.code)
    PetscCall((*model->state.scheme.integrator->begin)(model, step->time, step->dt, PETSC_FALSE, &outcome));
  PetscCall(CheckReplay(model, tape, n, &outcome));
  if (!step->first) PetscFunctionReturn(TakeSolution(model, step->x, evaluate));
  PetscCall(TakeSolution(model, step->first, PETSC_FALSE));
  PetscCall(GoToSecond(model, tape, n, evaluate));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The solution of step n, where the model stands, becomes the state after it. */
static PetscErrorCode Accept(MpmModel model, const MpmTape *tape, PetscInt n)
{
  PetscFunctionBeginUser;
  PetscCall((*model->state.scheme.integrator->accept)(model));
  model->state.time = tape->step[n].time;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The state after n steps: from the solution of the last one, or from the last state before it that is there. */
static PetscErrorCode GoToState(MpmModel model, MpmTape *tape, PetscInt n)
{
  PetscInt at = MpmTapeStoreLast(&tape->states, n), next;

  PetscFunctionBeginUser;
  if (at < n && n == tape->next) {
    PetscCall(Accept(model, tape, n - 1));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmTapeStoreTake(model, at, &tape->states));
  while (at < n) {
    PetscCall(MpmTapeStoreNext(model, at, n, &tape->states, &next));
    for (; at < next; at++) {
      PetscCall(GoToSolution(model, tape, at, PETSC_TRUE));
      PetscCall(Accept(model, tape, at));
    }
    if (at < n) PetscCall(MpmTapeStoreKeep(model, at, &tape->states));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeReplay(MpmModel model, MpmTape *tape, PetscInt n, PetscBool forward)
{
  PetscFunctionBeginUser;
  if (!tape->end.points) {
    PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
    PetscCall(MpmStateCopy(&model->state, &tape->end));
  }
  PetscCall(GoToState(model, tape, n));
  PetscCall(GoToSolution(model, tape, n, (PetscBool)(forward && MpmTapeStoreLast(&tape->states, n + 1) <= n)));
  tape->next = n + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeDone(MpmTape *tape, PetscInt n)
{
  PetscFunctionBeginUser;
  PetscCall(MpmTapeStoreForget(PetscMax(n, 1), &tape->states));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeFinish(MpmModel model, MpmTape *tape)
{
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  if (tape->end.points) {
    PetscCall(MpmRowsLoad(model->state.rows, &tape->end.values, "", PETSC_FALSE));
    PetscCall(MpmStateReturn(&model->state, &tape->end));
    PetscCall(EnterStage(model, model->state.stage));
  }
  PetscCall(PetscMemzero(&tape->end, sizeof(tape->end)));
  PetscCall(MpmTapeDestroy(tape));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTapeDestroy(MpmTape *tape)
{
  PetscFunctionBeginUser;
  for (PetscInt n = 0; n < tape->count; n++) {
    PetscCall(PetscFree(tape->step[n].x));
    PetscCall(PetscFree(tape->step[n].first));
  }
  if (tape->end.points) PetscCall(MpmStateForget(&tape->end));
  PetscCall(MpmTapeStoreDestroy(&tape->states));
  PetscCall(PetscFree(tape->step));
  tape->count = tape->capacity = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}
