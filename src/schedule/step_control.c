/*
  How steps follow one another: their lengths, cuts after a failure, and the last resort before a run gives up.
*/
#include "point/material.h"
#include "particles/particles.h"
#include "space/rules.h"
#include "volume/inertia.h"
#include "assembly/terms.h"
#include "query/model.h"
#include "query/query.h"
#include "step/integrator.h"
#include "step/moving_grid.h"
#include "integrators/consolidation.h"
#include "integrators/relaxation.h"
#include "integrators/time_error.h"
#include "schedule/reduction.h"
#include "schedule/rescue.h"
#include "schedule/schedule.h"
#include "schedule/settle.h"
#include "schedule/stage.h"

/* An error in time that falls no faster than this power of the step's length has another cause; after a sudden load it
   is 3/8. */
#define STUBBORN 0.15

/* Relative rounding errors, in units of the machine's, that are taken out of times. */
#define ROUNDING 4

/* Cuts of one step before F-bar averages dilation, too; while the factor of safety is sought. */
#define CUTS_WITH_DILATION 1
#define CUTS_IN_REDUCTION  5
/* Steps that do so alone, before all that follow do. */
#define STEPS_WITH_AVERAGE 3
/* Cuts of one step before the ground settles, in steps from rest with inertia, while the factor of safety is sought. */
#define CUTS_BEFORE_SETTLING 2

/*
  Rejects the solved step where its error in time is too large. Not where a shorter step has not reduced it, since it
  then has a sudden cause, or where no shorter step may be tried; that is reported.
*/
static PetscErrorCode LookAtError(MpmModel model, PetscReal dt, MpmOutcome *outcome)
{
  MpmScheme      *scheme = &model->state.scheme;
  const PetscReal before = scheme->refused, part = before > 0. ? dt / scheme->refused_dt : 1.;
  PetscBool       shorter;

  PetscFunctionBeginUser;
  scheme->refused = 0.;
  if (!(scheme->error > 0.)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(scheme->integrator->error(model, &scheme->estimate));
  if (scheme->estimate <= scheme->error) PetscFunctionReturn(PETSC_SUCCESS);
  shorter = (PetscBool)(MpmTimeErrorFactor(model) * dt >= model->state.dt_min);
  if (shorter && !(before > 0. && scheme->estimate > PetscPowReal(part, STUBBORN) * before)) {
    scheme->refused    = scheme->estimate;
    scheme->refused_dt = dt;
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_REFUSED, "the error in time is %.2g", (double)scheme->estimate));
  } else {
    PetscCall(MpmMonitorNote(&model->monitor, "the error in time is %.2g, and no less in shorter steps",
                             (double)scheme->estimate));
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
  if (!again) model->state.scheme.refused = 0.;
  PetscCall(MpmReductionApply(model, time));
  if (removes) PetscCall(MpmRemovalSet(model, time, outcome));
  if (!outcome->code) PetscCall(integrator->begin(model, time, dt, (PetscBool)(again && !removes), outcome));
  if (!outcome->code) {
    PetscCall(integrator->predict(model));
    PetscCall(integrator->solve(model, outcome));
    if (!outcome->code) {
      outcome->retryable = PETSC_TRUE;
      PetscCall(LookAtError(model, dt, outcome));
      if (!outcome->code) PetscCall(MpmReductionLook(model, time, outcome));
      if (!outcome->code) PetscCall(MpmSlideLook(model, time, outcome));
    } else model->state.scheme.refused = 0.;
    PetscCall((outcome->code ? integrator->roll_back : integrator->accept)(model));
  }
  if (outcome->code) PetscCall(MpmReductionApply(model, model->state.time));
  if (removes && outcome->code) PetscCall(MpmRemovalSet(model, model->state.time, &lost));
  else if (removes) PetscCall(MpmRemovalCommit(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  A decimal number within the rounding errors of a sum of steps. A time is then independent of the number of steps that
  led to it, and of whether a run ends there or passes it.
*/
PetscReal MpmTimeRound(PetscReal time)
{
  char      text[32];
  PetscReal decimal;

  (void)snprintf(text, sizeof(text), "%.12e", (double)time);
  decimal = (PetscReal)strtod(text, NULL);
  return PetscAbsReal(decimal - time) <= ROUNDING * PETSC_MACHINE_EPSILON * PetscAbsReal(time) ? decimal : time;
}

PetscReal MpmNextTime(MpmModel model, PetscReal dt, PetscReal *step)
{
  const PetscReal small  = 1e-9 * model->state.dt_nominal;
  PetscReal       target = model->state.time_end, next;

  if (!model->state.adaptive) {
    target = MpmTimeRound(
      model->state.time_start +
      model->state.dt_nominal *
        PetscFloorReal((model->state.time - model->state.time_start + small) / model->state.dt_nominal + 1.));
    if (target > model->state.time_end - small) target = model->state.time_end;
  }
  next  = MpmTimeRound(model->state.time + dt);
  next  = next > target - PetscMax(small, 1e-3 * dt) ? target : next;
  *step = next - model->state.time;
  return next;
}

#define EASY 6 /* iterations */

/* After an easy step the next one is longer; after a hard one, when adaptive, it stays; also where the error in time
   is small. */
static PetscReal NextLength(MpmModel model, PetscReal dt, PetscReal wanted)
{
  if (!model->state.adaptive) return PetscMin(wanted * model->state.growth, model->state.dt_nominal);
  if (dt < 0.99 * wanted) return wanted; /* the end of the run cut it short */
  if (model->solver.iterations.newton <= EASY) {
    const PetscReal factor = PetscMin(model->state.growth, MpmTimeErrorFactor(model));

    return PetscMax(PetscMin(MpmTimeErrorLength(model, wanted * factor), model->state.dt_max), model->state.dt_min);
  }
  return wanted;
}

/*
  True where F-bar may average dilation for one step. Over many steps pressures would drift apart, and a limit load
  would rise by a hundredth within a few steps. Therefore always while the factor of safety is sought, and otherwise a
  few times: where many steps fail it would be expensive.
*/
static PetscBool AveragesOnce(const MpmModel model)
{
  return (PetscBool)(MpmReductionSeeks(model) || model->state.rescue.averaged < STEPS_WITH_AVERAGE);
}

static PetscErrorCode AverageDilation(MpmModel model, const char *why, PetscReal dt)
{
  const char *how_long = AveragesOnce(model) ? "this step" : "from here on";

  PetscFunctionBeginUser;
  MpmStepAverageDilation(model, PETSC_TRUE);
  model->state.dt_wanted = dt;
  PetscCall(
    MpmMonitorChange(&model->monitor, MPM_CHANGE_DILATION, "%s; %s with -mpm_stabilization_fbar plain", why, how_long));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step that was cut, and took more than half of the iterations allowed even so, counts as one that failed. */
static PetscErrorCode MindStruggle(MpmModel model)
{
  PetscInt most;

  PetscFunctionBeginUser;
  PetscCall(SNESGetTolerances(model->solver.snes, NULL, NULL, NULL, &most, NULL));
  if (!model->state.cuts || 2 * model->solver.iterations.newton <= most) PetscFunctionReturn(PETSC_SUCCESS);
  if (AveragesOnce(model)) model->state.rescue.averaged++;
  else PetscCall(AverageDilation(model, "a short step was hard, too", model->state.dt_wanted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Cut(MpmModel model, const char *why, PetscReal dt)
{
  PetscFunctionBeginUser;
  model->state.dt_wanted = dt;
  model->state.cuts++;
  model->state.cuts_total++;
  PetscCall(MpmMonitorNote(&model->monitor, "%s; the step is cut to %.4g", why, (double)model->state.dt_wanted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where Newton's method has found no state of rest in the shortest step, a relaxation may: it takes over, or is named
   in the reason. */
static PetscErrorCode OfferRelaxation(MpmModel model, MpmOutcome *outcome)
{
  SNESConvergedReason reason;

  PetscFunctionBeginUser;
  if (!MpmCouldRelax(model)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetConvergedReason(model->solver.snes, &reason));
  if (reason > 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (MpmRescueServes(model)) {
    PetscCall(MpmRescueBegin(model, outcome->text));
    MpmOutcomeClear(outcome);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmOutcomeExplain(outcome,
                              "%s; if there is a state of rest elsewhere, a stage of type relaxation may find it, or "
                              "-mpm_time_rescue relaxation in this one",
                              outcome->text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepControlAddRows(MpmModel model)
{
  MpmRescue   *rescue = &model->state.rescue;
  const MpmRow rows[] = {
    {"leaves_dilation", MPM_ROW_BOOL, MPM_ROW_RUN, &rescue->dilation, 0, 0},
    {"averaged_dilation", MPM_ROW_INT, MPM_ROW_RUN, &rescue->averaged, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DividePoints(MpmModel model)
{
  PetscInt divided;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesDivide(model->state.particles, model->disc.grid, model->scene.materials->at,
                               model->scene.stabilization.divide, &divided));
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
    PetscCall(MpmStep(model, next, model->state.dt_wanted, PETSC_FALSE, outcome));
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

/* Remedies where a step fails. */
typedef struct {
  PetscBool seeks, dilation; /* a factor of safety, with F-bar; F-bar may average dilation */
  PetscInt  most;            /* cuts before F-bar does */
} Remedies;

static Remedies FindRemedies(const MpmModel model)
{
  const PetscBool seeks = (PetscBool)(model->state.rescue.dilation && MpmReductionSeeks(model));

  return (Remedies){.seeks    = seeks,
                    .dilation = (PetscBool)(model->state.rescue.dilation && AveragesOnce(model)),
                    .most     = seeks ? CUTS_IN_REDUCTION : CUTS_WITH_DILATION};
}

/* True where a step of the reduction may settle: not with bodies whose motion is solved for, which the term of
   settle.c omits. */
static PetscBool MaySettle(const MpmModel model)
{
  return (PetscBool)(model->disc.context.inertia->settles && !(MpmTermsTraits(model->disc.terms) & MPM_TERM_UNKNOWNS));
}

/*
  After a step to `next` that failed: a shorter one, the step with another remedy, or the end: `again` and `outcome` as
  for MpmStep(), and `over`: nothing is left to try, or the stage has ended.
*/
static PetscErrorCode TryNext(MpmModel model, const Remedies *remedies, PetscReal next, PetscReal dt, PetscBool *again,
                              PetscBool *over, MpmOutcome *outcome)
{
  const PetscBool brackets = (PetscBool)(MpmReductionBrackets(model, next) && !MpmRescueServes(model));
  MpmRescue      *rescue   = &model->state.rescue;

  PetscFunctionBeginUser;
  *over = PETSC_FALSE;
  if (model->state.scheme.refused > 0.) {
    *again = PETSC_TRUE;
    PetscCall(Cut(model, outcome->text, MpmTimeErrorLength(model, MpmTimeErrorFactor(model) * dt)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *again = brackets ? MpmReductionNarrows(model, next) : (PetscBool)(0.5 * dt >= model->state.dt_min);
  if (brackets && MaySettle(model) && !model->state.scheme.settling.needed && !(model->state.safety.beyond > 0.) &&
      (!*again || model->state.cuts >= CUTS_BEFORE_SETTLING)) {
    model->state.scheme.settling.needed = PETSC_TRUE;
    PetscCall(
      MpmMonitorChange(&model->monitor, MPM_CHANGE_SETTLING, "%s; from here on the ground settles", outcome->text));
    *again = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (brackets && *again) {
    *again = (PetscBool)!model->state.scheme.settling.needed;
    PetscCall(Cut(model, outcome->text, 0.5 * dt));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (rescue->dilation && !(brackets && MaySettle(model)) && !(model->state.safety.beyond > 0.) &&
      (!*again || model->state.cuts >= remedies->most)) {
    PetscCall(AverageDilation(model, outcome->text, brackets ? dt : model->state.dt_nominal));
    *again = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (brackets) {
    PetscCall(MpmReductionClose(model, next, outcome));
    *over                  = (PetscBool)(outcome->code || model->state.time >= model->state.time_end);
    model->state.dt_wanted = model->state.dt_nominal;
  } else if (*again) PetscCall(Cut(model, outcome->text, 0.5 * dt));
  else {
    *over = PETSC_TRUE;
    PetscCall(OfferRelaxation(model, outcome));
    if (outcome->code) PetscCall(MpmSlideExplain(model, outcome));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAdvance(MpmModel model, PetscReal *dt, MpmOutcome *outcome)
{
  const PetscBool explicit = (PetscBool)(model->state.scheme.integrator->length != NULL);
  const Remedies remedies  = FindRemedies(model);
  PetscReal      next;
  PetscBool      again = PETSC_FALSE, over;

  PetscFunctionBeginUser;
  PetscCall(MpmStepArrange(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->state.scheme.rescuing.on) {
    PetscCall(AdvanceRescue(model, dt, outcome));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmConsolidationBegin(model));
  model->state.cuts = 0;
  if (MpmRescueServes(model)) MpmRelaxationForget(model);
  if (explicit) PetscCall(model->state.scheme.integrator->length(model, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  for (;;) {
    next = MpmNextTime(model, model->state.dt_wanted, dt);
    if (MpmReductionBrackets(model, next) && model->state.scheme.settling.needed) {
      PetscCall(MpmSettle(model, next, *dt, outcome));
      outcome->retryable = PETSC_TRUE;
    } else PetscCall(MpmStep(model, next, *dt, again, outcome));
    if (!outcome->code) break;
    if (!outcome->retryable) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(TryNext(model, &remedies, next, *dt, &again, &over, outcome));
    if (over) PetscFunctionReturn(PETSC_SUCCESS);
  }
  model->state.time = next;
  model->state.step++;
  MpmSlideObserve(model);
  PetscCall(MpmReductionObserve(model));
  PetscCall(MpmConsolidationObserve(model));
  if (explicit && MpmModelRelaxes(model)) PetscCall(MpmRelaxationOver(model, outcome));
  if (explicit) PetscFunctionReturn(PETSC_SUCCESS);
  if (remedies.dilation && !model->state.rescue.dilation) {
    MpmStepAverageDilation(model, PETSC_FALSE);
    if (!remedies.seeks) model->state.rescue.averaged++;
  } else if (model->state.rescue.dilation && !remedies.seeks) PetscCall(MindStruggle(model));
  if (!(model->state.safety.failed > 0.)) model->state.dt_wanted = NextLength(model, *dt, model->state.dt_wanted);
  PetscFunctionReturn(PETSC_SUCCESS);
}
