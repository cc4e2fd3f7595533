/*
  Time that a run still needs: the steps to come times their cost.

  Steps of the stage under way grow as those before them did, up to the longest allowed; those of later stages, as the
  scene has it. A step costs what steps of its kind did, in a mean that forgets: over twenty steps, or a fourth of all
  that there were. Explicit steps of a later stage are as long as those of an earlier one.
*/
#include "query/model.h"
#include "query/query.h"
#include "observe/results.h"

#define LEAST_MEMORY 20. /* steps */
#define MEMORY_SHARE 4.  /* of the steps of a kind */
#define GROWTH_WAY   0.9 /* weight of the growth before a step */

/* Of a laboratory test, which has no stage, the steps are implicit. */
static MpmStepKind Kind(const MpmStage *stage)
{
  if (!stage) return MPM_STEP_IMPLICIT;
  if (stage->geostatic.method != MPM_GEOSTATIC_NONE) return MPM_STEP_GEOSTATIC;
  return stage->time.motion.type == MPM_EXPLICIT ? MPM_STEP_EXPLICIT : MPM_STEP_IMPLICIT;
}

/* The stage under way. */
static const MpmStage *Stage(const MpmModel model)
{
  return model->scene.stages.count ? &model->scene.stages.at[model->state.stage] : NULL;
}

/* Growth of a stage's steps before any is taken, and the longest. */
static PetscReal PlannedGrowth(const MpmTimeControl *control)
{
  return control->adaptive && control->motion.type != MPM_EXPLICIT ? control->growth : 1.;
}

/* Number of steps dt, g dt, g^2 dt, ..., `most` at most, that cover a time. */
static PetscReal CountSteps(PetscReal time, PetscReal dt, PetscReal growth, PetscReal most)
{
  PetscReal growing, covered;

  if (!(dt > 0.) || time <= 0.) return 0.;
  if (growth < 1. + 1e-6 || most <= dt) return PetscCeilReal(time / dt - 1e-3);
  growing = PetscLogReal(most / dt) / PetscLogReal(growth);
  covered = (most - dt) / (growth - 1.);
  if (!(covered < time)) return PetscLogReal(1. + time * (growth - 1.) / dt) / PetscLogReal(growth);
  return growing + (time - covered) / most;
}

/* Adds a step of length dt that took so many seconds. */
static void Learn(const MpmModel model, MpmTimeLeft *learnt, PetscReal dt, PetscReal seconds)
{
  const MpmStage *stage  = Stage(model);
  MpmStepCost    *cost   = &learnt->cost[Kind(stage)];
  const PetscReal memory = 1. - 1. / PetscMax(LEAST_MEMORY, (PetscReal)cost->count / MEMORY_SHARE);

  cost->count++;
  cost->seconds = memory * cost->seconds + seconds;
  cost->steps   = memory * cost->steps + 1.;
  if (Kind(stage) == MPM_STEP_EXPLICIT) learnt->explicit_step = dt;
  if (learnt->stage != model->state.stage + 1) {
    learnt->stage  = model->state.stage + 1;
    learnt->growth = stage ? PetscLogReal(PlannedGrowth(&stage->time)) : 0.;
  } else if (learnt->last > 0.) {
    learnt->growth = GROWTH_WAY * learnt->growth + (1. - GROWTH_WAY) * PetscLogReal(dt / learnt->last);
  }
  learnt->last = dt;
}

/* Seconds of a step of a kind; of one without steps yet, those of the present one. */
static PetscReal StepSeconds(const MpmTimeLeft *learnt, MpmStepKind kind, MpmStepKind present)
{
  const MpmStepCost *cost = &learnt->cost[learnt->cost[kind].count ? kind : present];

  return cost->seconds / cost->steps;
}

/* Steps of a later stage. */
static PetscReal PlannedSteps(const MpmTimeLeft *learnt, const MpmStage *stage)
{
  const MpmTimeControl *control = &stage->time;

  if (Kind(stage) == MPM_STEP_GEOSTATIC) return 1.;
  if (control->step > 0.) return CountSteps(control->end, control->step, PlannedGrowth(control), control->step_max);
  return CountSteps(control->end, learnt->explicit_step, 1., control->end);
}

PetscReal MpmTimeLeftAfter(const MpmModel model, PetscReal dt, PetscReal seconds)
{
  MpmTimeLeft      *learnt = &model->results->terminal.left;
  const MpmStages  *stages = &model->scene.stages;
  const MpmStepKind kind   = Kind(Stage(model));
  const PetscReal   end    = stages->count ? model->state.period.end : model->state.period.run_end;
  const PetscReal   next   = model->state.dt.wanted > 0. ? model->state.dt.wanted : dt;
  PetscReal         left, growth;

  Learn(model, learnt, dt, seconds);
  growth = kind == MPM_STEP_EXPLICIT ? 1. : PetscExpReal(PetscMax(learnt->growth, 0.));
  left   = CountSteps(end - model->state.time, next, growth, model->state.dt.most) * StepSeconds(learnt, kind, kind);
  for (PetscInt k = model->state.stage + 1; k < stages->count; k++)
    left += PlannedSteps(learnt, &stages->at[k]) * StepSeconds(learnt, Kind(&stages->at[k]), kind);
  return left;
}
