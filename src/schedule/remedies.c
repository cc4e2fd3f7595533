/*
  Remedies where a step fails, in the order in which they are tried: a shorter step for an error in time; ground that
  settles and a narrower bracket while the factor of safety is sought; F-bar that averages dilation; the bracket's end;
  a shorter step; a relaxation.
*/
#include "assembly/terms.h"
#include "volume/inertia.h"
#include "query/model.h"
#include "query/query.h"
#include "integrators/relaxation.h"
#include "integrators/time_error.h"
#include "schedule/reduction.h"
#include "schedule/remedies.h"
#include "schedule/rescue.h"
#include "schedule/schedule.h"

/* Cuts of one step before F-bar averages dilation, too; while the factor of safety is sought. */
#define CUTS_WITH_DILATION 1
#define CUTS_IN_REDUCTION  5
/* Steps that do so alone, before all that follow do. */
#define STEPS_WITH_AVERAGE 3
/* Cuts of one step before the ground settles, in steps from rest with inertia, while the factor of safety is sought. */
#define CUTS_BEFORE_SETTLING 2

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
  model->state.dt.wanted = dt;
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
  if (!model->state.cuts.step || 2 * model->solver.iterations.newton <= most) PetscFunctionReturn(PETSC_SUCCESS);
  if (AveragesOnce(model)) model->state.rescue.averaged++;
  else PetscCall(AverageDilation(model, "a short step was hard, too", model->state.dt.wanted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A shorter step. */
static PetscErrorCode Cut(MpmModel model, const char *why, PetscReal dt)
{
  PetscFunctionBeginUser;
  model->state.dt.wanted = dt;
  model->state.cuts.step++;
  model->state.cuts.total++;
  PetscCall(MpmMonitorNote(&model->monitor, "%s; the step is cut to %.4g", why, (double)model->state.dt.wanted));
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

/* True where a step of the reduction may settle: not with bodies whose motion is solved for, which the term of
   settle.c omits. */
static PetscBool MaySettle(const MpmModel model)
{
  return (PetscBool)(model->disc.context.inertia->settles && !(MpmTermsTraits(model->disc.terms) & MPM_TERM_UNKNOWNS));
}

/* A failed attempt. */
typedef struct {
  PetscReal next, dt;
  PetscBool brackets; /* part of a bracket of the factor of safety */
  PetscBool shorter;  /* a shorter step may be tried */
} Attempt;

static PetscBool HasTimeError(const MpmModel model, const MpmRemedies *remedies, const Attempt *attempt)
{
  (void)remedies;
  (void)attempt;
  return (PetscBool)(model->state.scheme.error.refused > 0.);
}

static PetscErrorCode CutByError(MpmModel model, const Attempt *attempt, MpmRemedies *remedies, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  remedies->again = PETSC_TRUE;
  PetscCall(Cut(model, outcome->text, MpmTimeErrorLength(model, MpmTimeErrorFactor(model) * attempt->dt)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool NeedsSettling(const MpmModel model, const MpmRemedies *remedies, const Attempt *attempt)
{
  (void)remedies;
  return (PetscBool)(attempt->brackets && MaySettle(model) && !model->state.scheme.settling.needed &&
                     !(model->state.safety.beyond > 0.) &&
                     (!attempt->shorter || model->state.cuts.step >= CUTS_BEFORE_SETTLING));
}

static PetscErrorCode Settle(MpmModel model, const Attempt *attempt, MpmRemedies *remedies, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  (void)attempt;
  model->state.scheme.settling.needed = PETSC_TRUE;
  remedies->again                     = PETSC_FALSE;
  PetscCall(
    MpmMonitorChange(&model->monitor, MPM_CHANGE_SETTLING, "%s; from here on the ground settles", outcome->text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsWide(const MpmModel model, const MpmRemedies *remedies, const Attempt *attempt)
{
  (void)model;
  (void)remedies;
  return (PetscBool)(attempt->brackets && attempt->shorter);
}

static PetscErrorCode Narrow(MpmModel model, const Attempt *attempt, MpmRemedies *remedies, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  remedies->again = (PetscBool)!model->state.scheme.settling.needed;
  PetscCall(Cut(model, outcome->text, 0.5 * attempt->dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool KeepsDilation(const MpmModel model, const MpmRemedies *remedies, const Attempt *attempt)
{
  const PetscInt most = remedies->seeks ? CUTS_IN_REDUCTION : CUTS_WITH_DILATION;

  return (PetscBool)(model->state.rescue.dilation && !(attempt->brackets && MaySettle(model)) &&
                     !(model->state.safety.beyond > 0.) && (!attempt->shorter || model->state.cuts.step >= most));
}

static PetscErrorCode Average(MpmModel model, const Attempt *attempt, MpmRemedies *remedies, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  remedies->again = PETSC_FALSE;
  PetscCall(AverageDilation(model, outcome->text, attempt->brackets ? attempt->dt : model->state.dt.nominal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where dilation was averaged in this step alone; otherwise a short step may call for it in the next ones. */
static PetscErrorCode EndAverage(MpmModel model, const MpmRemedies *remedies)
{
  PetscFunctionBeginUser;
  if (remedies->dilation && !model->state.rescue.dilation) {
    MpmStepAverageDilation(model, PETSC_FALSE);
    if (!remedies->seeks) model->state.rescue.averaged++;
  } else if (model->state.rescue.dilation && !remedies->seeks) PetscCall(MindStruggle(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsNarrow(const MpmModel model, const MpmRemedies *remedies, const Attempt *attempt)
{
  (void)model;
  (void)remedies;
  return attempt->brackets;
}

static PetscErrorCode Close(MpmModel model, const Attempt *attempt, MpmRemedies *remedies, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  remedies->again = PETSC_FALSE;
  PetscCall(MpmReductionClose(model, attempt->next, outcome));
  remedies->over         = (PetscBool)(outcome->code || model->state.time >= model->state.period.end);
  model->state.dt.wanted = model->state.dt.nominal;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsLong(const MpmModel model, const MpmRemedies *remedies, const Attempt *attempt)
{
  (void)model;
  (void)remedies;
  return attempt->shorter;
}

static PetscErrorCode Halve(MpmModel model, const Attempt *attempt, MpmRemedies *remedies, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  remedies->again = PETSC_TRUE;
  PetscCall(Cut(model, outcome->text, 0.5 * attempt->dt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One remedy: `undo`, or NULL, runs once the step has succeeded. */
typedef struct {
  const char *name;
  PetscBool (*applies)(const MpmModel model, const MpmRemedies *remedies, const Attempt *attempt);
  PetscErrorCode (*apply)(MpmModel model, const Attempt *attempt, MpmRemedies *remedies, MpmOutcome *outcome);
  PetscErrorCode (*undo)(MpmModel model, const MpmRemedies *remedies);
} Remedy;

static const Remedy table[] = {
  {"shorter step for the error in time", HasTimeError, CutByError, NULL},
  {"ground that settles", NeedsSettling, Settle, NULL},
  {"narrower bracket", IsWide, Narrow, NULL},
  {"average of dilation", KeepsDilation, Average, EndAverage},
  {"end of the bracket", IsNarrow, Close, NULL},
  {"shorter step", IsLong, Halve, NULL},
};

void MpmRemediesBegin(const MpmModel model, MpmRemedies *remedies)
{
  *remedies = (MpmRemedies){.seeks    = (PetscBool)(model->state.rescue.dilation && MpmReductionSeeks(model)),
                            .dilation = (PetscBool)(model->state.rescue.dilation && AveragesOnce(model))};
}

PetscErrorCode MpmRemediesTry(MpmModel model, PetscReal next, PetscReal dt, MpmRemedies *remedies, MpmOutcome *outcome)
{
  Attempt attempt = {.next = next, .dt = dt, .shorter = PETSC_TRUE};

  PetscFunctionBeginUser;
  attempt.brackets = (PetscBool)(MpmReductionBrackets(model, next) && !MpmRescueServes(model));
  if (!HasTimeError(model, remedies, &attempt)) /* a bracket takes note of an attempt that failed */
    attempt.shorter =
      attempt.brackets ? MpmReductionNarrows(model, next) : (PetscBool)(0.5 * dt >= model->state.dt.least);
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(table); k++) {
    if (!table[k].applies(model, remedies, &attempt)) continue;
    PetscCall(PetscInfo(model->solver.snes, "remedy: %s\n", table[k].name));
    PetscCall(table[k].apply(model, &attempt, remedies, outcome));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  remedies->over = PETSC_TRUE;
  PetscCall(OfferRelaxation(model, outcome));
  if (outcome->code) PetscCall(MpmSlideExplain(model, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRemediesUndo(MpmModel model, const MpmRemedies *remedies)
{
  PetscFunctionBeginUser;
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(table); k++)
    if (table[k].undo) PetscCall(table[k].undo(model, remedies));
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
