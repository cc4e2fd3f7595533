/*
  How steps follow one another.
*/
#include "point/material.h"
#include "grid/shape.h"
#include "particles/particles.h"
#include "particles/body.h"
#include "query/model.h"
#include "query/query.h"
#include "step/integrator.h"
#include "step/moving_grid.h"
#include "integrators/consolidation.h"
#include "integrators/relaxation.h"
#include "integrators/time_error.h"
#include "schedule/reduction.h"
#include "schedule/remedies.h"
#include "schedule/rescue.h"
#include "schedule/schedule.h"
#include "schedule/settle.h"
#include "schedule/stage.h"

/* An error in time that falls no faster than this power of the step's length has another cause; after a sudden load it
   is 3/8. */
#define STUBBORN 0.15

/*
  Rejects the solved step where its error in time is too large. Not where a shorter step has not reduced it, since it
  then has a sudden cause, or where no shorter step may be tried; that is reported.
*/
static PetscErrorCode LookAtError(MpmModel model, PetscReal dt, MpmOutcome *outcome)
{
  MpmScheme      *scheme = &model->state.scheme;
  const PetscReal before = scheme->error.refused, part = before > 0. ? dt / scheme->error.refused_dt : 1.;
  PetscBool       shorter;

  PetscFunctionBeginUser;
  scheme->error.refused = 0.;
  if (!(scheme->error.accepted > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(scheme->integrator->error(model, &scheme->error.estimate));
  if (model->scene.stages.given.taken) PetscFunctionReturn(PETSC_SUCCESS);
  if (scheme->error.estimate <= scheme->error.accepted) PetscFunctionReturn(PETSC_SUCCESS);
  shorter = (PetscBool)(MpmTimeErrorFactor(model) * dt >= model->state.dt.least);
  if (shorter && !(before > 0. && scheme->error.estimate > PetscPowReal(part, STUBBORN) * before)) {
    scheme->error.refused    = scheme->error.estimate;
    scheme->error.refused_dt = dt;
    PetscCall(
      MpmOutcomeFail(outcome, MPM_OUTCOME_REFUSED, "the error in time is %.2g", (double)scheme->error.estimate));
  } else {
    PetscCall(MpmMonitorNote(&model->monitor, "the error in time is %.2g, and no less in shorter steps",
                             (double)scheme->error.estimate));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStep(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome)
{
  const MpmIntegrator *integrator = model->state.scheme.integrator;
  const PetscBool      removes    = MpmRemovalGoesOn(model);
  MpmOutcome           lost;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  if (!again) model->state.scheme.error.refused = 0.;
  PetscCall(MpmReductionApply(model, time));
  if (model->state.scheme.inflow && !again) PetscCall(MpmInflowEnter(model, outcome));
  if (removes) PetscCall(MpmRemovalSet(model, time, outcome));
  if (!outcome->code) PetscCall(integrator->begin(model, time, dt, (PetscBool)(again && !removes), outcome));
  if (!outcome->code) {
    PetscCall(integrator->predict(model));
    PetscCall(integrator->solve(model, outcome));
    if (!outcome->code) {
      outcome->retryable = PETSC_TRUE;
      PetscCall(LookAtError(model, dt, outcome));
      if (!outcome->code) PetscCall(MpmReductionLook(model, time, outcome));
      if (!outcome->code && !model->scene.stages.given.taken) PetscCall(MpmSlideLook(model, time, outcome));
    } else model->state.scheme.error.refused = 0.;
    PetscCall((outcome->code ? integrator->roll_back : integrator->accept)(model));
  }
  if (outcome->code) PetscCall(MpmReductionApply(model, model->state.time));
  if (removes && outcome->code) PetscCall(MpmRemovalSet(model, model->state.time, &lost));
  else if (removes) PetscCall(MpmRemovalCommit(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Elements have p + 1 points a cell, which are too far apart once drawn out by a fifth (stabilization.c). */
static PetscErrorCode DividePoints(MpmModel model)
{
  const PetscReal drawn = MpmShapeOrder(model->scene.shape.type) > 1 ? 1.2 : 1.25;
  PetscInt        divided;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesDivide(model->state.particles, model->disc.grid, model->scene.materials->at,
                               model->scene.stabilization.divide, drawn, &divided));
  if (divided) PetscCall(PetscInfo(model->state.particles->swarm, "%" PetscInt_FMT " points are divided\n", divided));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepArrange(MpmModel model, MpmOutcome *outcome)
{
  PetscLogDouble since;

  PetscFunctionBeginUser;
  PetscCall(MpmMovingGridFollow(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_MIGRATE, &since));
  if (model->scene.stabilization.divide > 0.) PetscCall(DividePoints(model));
  PetscCall(MpmParticlesDistribute(model->state.particles, model->disc.grid, outcome));
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_MIGRATE, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step of the motion that goes on where a quasi-static step gave up. */
static PetscErrorCode AdvanceRescue(MpmModel model, PetscReal *dt, MpmOutcome *outcome)
{
  PetscReal next;

  PetscFunctionBeginUser;
  PetscCall(model->state.scheme.integrator->length(model, outcome));
  if (!outcome->code) {
    PetscCall(MpmRescueNextTime(model, &next));
    PetscCall(MpmStep(model, next, model->state.dt.wanted, PETSC_FALSE, outcome));
  }
  if (outcome->code) {
    PetscCall(MpmOutcomeExplain(outcome, "the relaxation that goes on to time %.6g: %s",
                                (double)model->state.scheme.rescuing.end, outcome->text));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  model->state.time = next;
  PetscCall(MpmReductionObserve(model));
  PetscCall(MpmRescueOver(model, dt, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmStageHasFinish(const MpmModel model)
{
  return (PetscBool)(model->state.scheme.integrator->finish && !MpmModelRelaxes(model));
}

PetscErrorCode MpmStageFinish(MpmModel model, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  if (!MpmStageHasFinish(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmStepArrange(model, outcome));
  if (!outcome->code) PetscCall((*model->state.scheme.integrator->finish)(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The weight of a body that a stage adds acts in full at once: the ground may have no equilibrium under it. */
static PetscErrorCode ExplainAdded(const MpmModel model, MpmOutcome *outcome)
{
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];

  PetscFunctionBeginUser;
  if (!outcome->code || model->state.time > model->state.period.start) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; stage->adds && b < model->scene.bodies->count; b++) {
    if (!stage->adds[b]) continue;
    PetscCall(MpmOutcomeExplain(outcome,
                                "%s; all of body %.40s weighs from the first step of stage %.40s on, and the ground "
                                "may not bear it",
                                outcome->text, model->scene.bodies->names[b], stage->name));
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAdvance(MpmModel model, PetscReal *dt, MpmOutcome *outcome)
{
  const PetscBool explicit = (PetscBool)(model->state.scheme.integrator->length != NULL);
  MpmRemedies remedies;
  PetscReal   next;

  PetscFunctionBeginUser;
  PetscCall(MpmStepArrange(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->state.scheme.rescuing.on) {
    PetscCall(AdvanceRescue(model, dt, outcome));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmConsolidationBegin(model));
  model->state.cuts.step = 0;
  if (MpmRescueServes(model)) MpmRelaxationForget(model);
  if (explicit) PetscCall(model->state.scheme.integrator->length(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->scene.stages.given.count) (void)MpmNextTime(model, 0., &model->state.dt.wanted);
  MpmRemediesBegin(model, &remedies);
  for (;;) {
    next = MpmNextTime(model, model->state.dt.wanted, dt);
    if (MpmReductionBrackets(model, next) && model->state.scheme.settling.needed) {
      PetscCall(MpmSettle(model, next, *dt, outcome));
      outcome->retryable = PETSC_TRUE;
    } else PetscCall(MpmStep(model, next, *dt, remedies.again, outcome));
    if (!outcome->code) break;
    if (model->scene.stages.given.count)
      PetscCall(MpmOutcomeExplain(outcome, "the schedule's step to %.9g: %s", (double)next, outcome->text));
    if (!outcome->retryable || model->scene.stages.given.count) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(MpmRemediesTry(model, next, *dt, &remedies, outcome));
    if (!remedies.over) continue;
    PetscCall(ExplainAdded(model, outcome));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  model->state.time = next;
  model->state.step++;
  MpmSlideObserve(model);
  PetscCall(MpmReductionObserve(model));
  PetscCall(MpmConsolidationObserve(model));
  if (explicit && MpmModelRelaxes(model)) PetscCall(MpmRelaxationOver(model, outcome));
  if (explicit) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmRemediesUndo(model, &remedies));
  if (!(model->state.safety.failed > 0.)) model->state.dt.wanted = MpmNextLength(model, *dt, model->state.dt.wanted);
  PetscFunctionReturn(PETSC_SUCCESS);
}
