/*
  Begin of a step, for any integrator: space, conditions and loads.
*/
#include "point/layout.h"
#include "point/registry.h"
#include "particles/particles.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/body_motion.h"
#include "assembly/terms.h"
#include "volume/damping.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "problem/evaluation.h"
#include "terrain/bed_flow.h"
#include "query/model.h"
#include "query/query.h"
#include "step/change_ramp.h"
#include "step/integrator.h"
#include "step/step.h"
#include "step/water_state.h"

PetscReal MpmStepLoadFactor(const MpmModel model, PetscInt load, PetscReal time)
{
  const PetscReal part = model->state.scheme.load_at_start, end = MpmModelLoadFactor(model, load, time);

  return part > 0. ? (1. - part) * end + part * MpmModelLoadFactor(model, load, model->state.time) : end;
}

MpmRules MpmStepRules(MpmModel model, PetscReal time)
{
  const MpmStage         *stage  = &model->scene.stages.at[model->state.stage];
  const MpmIntegratorType motion = stage->time.motion.type;
  const PetscBool         solves = (PetscBool)!model->state.scheme.integrator->length;
  MpmRules                rules;

  rules =
    (MpmRules){.grid           = model->disc.grid,
               .shape          = model->scene.shape.type,
               .edge           = model->scene.shape.edge,
               .layout         = model->disc.layout,
               .walls          = {model->state.acting.walls.count, model->state.acting.walls.at},
               .stretch        = model->scene.deformation.bed ? MpmBedStretch
                                 : solves                     ? model->scene.deformation.stretch
                                                              : MpmStretchFindQuick(model->disc.dim),
               .touch          = model->scene.deformation.bed ? MPM_SHAPE_TOUCH_COLUMNS : MPM_SHAPE_TOUCH,
               .longest        = solves ? 0. : MPM_SPRAY_HALF_LENGTH,
               .parts          = model->disc.material.parts,
               .materials      = model->disc.sum->materials,
               .material_count = model->disc.material.count,
               .penalty.ghost  = solves ? model->disc.matrix.ghost : 0.,
               .filled         = solves ? model->scene.stabilization.filled : 0.,
               .penalty.sparse = solves && model->scene.stabilization.ghost_auto ? MPM_GHOST_SPARSE : 0.,
               .penalty.interior =
                 solves && stage->geostatic.method == MPM_GEOSTATIC_NONE ? model->scene.stabilization.interior : 0.,
               .smooth   = model->scene.stabilization.smooth,
               .means    = !model->disc.layout->means               ? MPM_MEANS_NONE
                           : model->scene.stabilization.fbar_spread ? MPM_MEANS_SPREAD
                                                                    : MPM_MEANS_CELL,
               .put_back = model->state.scheme.put_back,
               .time     = {model->state.time, time, model->state.scheme.load_at_start},
               .dynamic  = (PetscBool)(motion != MPM_QUASISTATIC && solves)};
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    const MpmLoad *load = &model->scene.loads->at[l];

    for (PetscInt a = 0; load->type == MPM_LOAD_GRAVITY && a < model->disc.dim; a++)
      rules.gravity[a] += MpmStepLoadFactor(model, l, time) * load->value[a];
  }
  return rules;
}

/* Data independent of the step's length: arrays, space, pattern, solver. */
static PetscErrorCode PrepareSpace(MpmModel model, const MpmRules *rules, MpmOutcome *outcome)
{
  const PetscInt bs = model->disc.block;

  PetscFunctionBeginUser;
  model->disc.nodal.committed = PETSC_FALSE;
  PetscCall(MpmParticlesLendArrays(model->state.particles, model->disc.points));
  PetscCall(MpmTermsSetUpSpace(model->disc.terms, model->disc.space, rules, model->disc.points, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree3(model->disc.nodal.u, model->disc.nodal.residual, model->disc.nodal.force));
  PetscCall(PetscMalloc3((model->disc.space->local * bs + 1), &model->disc.nodal.u, (model->disc.space->local * bs + 1),
                         &model->disc.nodal.residual, (model->disc.space->local * bs + 1), &model->disc.nodal.force));
  PetscCall(MpmTrialReset(model->disc.trial));
  PetscCall(MpmTrialCreate(model->disc.sum, model->disc.trial));
  model->state.active_dofs_max = PetscMax(model->state.active_dofs_max, (PetscInt64)model->disc.space->number.unknowns);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepSpace(MpmModel model, MpmOutcome *outcome)
{
  const MpmRules rules = MpmStepRules(model, model->state.time);

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  PetscCall(PrepareSpace(model, &rules, outcome));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmPrescription MpmStepPrescription(MpmModel model, PetscReal time)
{
  return (MpmPrescription){.conditions = model->scene.bcs,
                           .motions    = model->scene.motions,
                           .acting     = model->state.acting.bcs,
                           .particles  = model->state.particles,
                           .time_n     = model->state.time,
                           .time       = time,
                           .diagonal   = model->disc.matrix.diagonal};
}

PetscErrorCode MpmModelPrescribe(MpmModel model, PetscReal time, MpmOutcome *outcome)
{
  const MpmPrescription step = MpmStepPrescription(model, time);
  PetscInt              contradicts;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  PetscCall(MpmConstraintsSetUp(model->disc.constraints, &step, model->disc.grid, model->disc.layout, model->disc.space,
                                &contradicts));
  PetscCall(MpmWaterHold(model, time));
  MpmConstraintsFollow(model->disc.constraints, model->disc.layout, model->disc.space);
  if (contradicts < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                           "motion %s meets nodes that a condition or another motion moves otherwise",
                           model->scene.motions->names[contradicts]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where any active condition prescribes a displacement other than 0. */
static PetscBool AnyMoves(const MpmModel model)
{
  for (PetscInt b = 0; b < model->scene.bcs->count; b++)
    if (model->state.acting.bcs[b].active && MpmConditionMoves(&model->scene.bcs->at[b], model->disc.dim))
      return PETSC_TRUE;
  return (PetscBool)(model->scene.motions->count > 0);
}

PetscBool MpmStepPrescribes(const MpmModel model)
{
  return (PetscBool)(model->disc.constraints->any || AnyMoves(model));
}

PetscErrorCode MpmStepPrescribedRate(MpmModel model, PetscReal time, PetscInt rate, PetscReal values[])
{
  MpmPrescription step        = MpmStepPrescription(model, time);
  MpmConstraints  constraints = {0};
  PetscInt        contradicts;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(values, model->disc.space->local * model->disc.block));
  if (!AnyMoves(model)) PetscFunctionReturn(PETSC_SUCCESS);
  step.rate = rate;
  PetscCall(
    MpmConstraintsSetUp(&constraints, &step, model->disc.grid, model->disc.layout, model->disc.space, &contradicts));
  PetscCall(PetscArraycpy(values, constraints.value, model->disc.space->local * model->disc.block));
  PetscCall(MpmConstraintsReset(&constraints));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Conditions that have lost the material that they move. */
static PetscErrorCode FindLostMaterial(MpmModel model, PetscReal time, MpmOutcome *outcome)
{
  const MpmPrescription step = MpmStepPrescription(model, time);
  PetscInt              lost;
  PetscReal             left;

  PetscFunctionBeginUser;
  PetscCall(MpmConditionsFindLost(&step, model->state.acting.bcs, model->scene.bodies, model->disc.sum, &lost, &left));
  if (lost < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (left > 0.)
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                             "condition %s has lost the material that it moves: its nodes hold %.2g %% of what they "
                             "held; a motion follows a body's points",
                             model->scene.bcs->names[lost], (double)(100. * left)));
  else
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                             "condition %s prescribes a displacement where there is no material; a motion follows a "
                             "body's points",
                             model->scene.bcs->names[lost]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Waves that come in through absorbing conditions in a step to `time`, like other loads. */
static PetscErrorCode AddIncoming(MpmModel model, PetscReal time, PetscReal end, PetscReal start, PetscReal force[])
{
  const MpmDamping *damping = model->disc.context.damping;

  PetscFunctionBeginUser;
  if (!damping->conditions) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmAbsorbingLoad(damping, model->disc.sum, time, end, force));
  if (start != 0.) PetscCall(MpmAbsorbingLoad(damping, model->disc.sum, model->state.time, start, force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepMeanLoads(MpmModel model, PetscReal time, PetscReal part, PetscReal force[])
{
  const MpmRules  rules = MpmStepRules(model, time);
  const PetscReal start = 0.5 - part;

  PetscFunctionBeginUser;
  if (start == 0.) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    const PetscReal change = MpmModelLoadFactor(model, l, model->state.time) - MpmModelLoadFactor(model, l, time);

    if (model->scene.loads->at[l].type == MPM_LOAD_GRAVITY && model->state.scheme.integrator->length) continue;
    PetscCall(
      MpmLoadApply(&model->scene.loads->at[l], start * change, &rules, model->disc.sum, model->state.particles, force));
  }
  PetscCall(AddIncoming(model, time, -start, start, force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Factor with which a load does its work in a step to `time`. */
static PetscReal MeanFactor(const MpmModel model, PetscInt load, PetscReal time)
{
  if (model->state.scheme.integrator->length) return MpmStepLoadFactor(model, load, time);
  return 0.5 * (MpmModelLoadFactor(model, load, model->state.time) + MpmModelLoadFactor(model, load, time));
}

/* Conditions and loads at the step's end. */
static PetscErrorCode PrepareConditions(MpmModel model, const MpmRules *rules, PetscReal time, MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelPrescribe(model, time, outcome));
  if (!outcome->code) PetscCall(FindLostMaterial(model, time, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++) {
    model->disc.context.surfaces->factor[k]   = MpmStepLoadFactor(model, model->scene.loads->count + k, time);
    model->disc.context.surfaces->pressure[k] = MpmModelSurfacePressure(model, k, time);
    model->disc.context.surfaces->mean[k]     = MeanFactor(model, model->scene.loads->count + k, time);
  }
  model->disc.context.surfaces->still = model->state.scheme.water_held;
  model->disc.context.surfaces->table = model->scene.water;
  model->disc.context.surfaces->open  = model->state.scheme.load_scale;
  PetscCall(MpmTermsPrepare(model->disc.terms, &(MpmTermStep){rules, model->disc.sum, model->state.particles}));
  PetscCall(PetscArrayzero(model->disc.nodal.force, model->disc.space->local * model->disc.block));
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    const MpmLoad *load = &model->scene.loads->at[l];

    if (load->type != MPM_LOAD_GRAVITY || !model->state.scheme.integrator->length)
      PetscCall(MpmLoadApply(load, MpmStepLoadFactor(model, l, time), rules, model->disc.sum, model->state.particles,
                             model->disc.nodal.force));
  }
  PetscCall(MpmChangeAdd(model, time, model->disc.nodal.force));
  PetscCall(AddIncoming(model, time, 1. - model->state.scheme.load_at_start, model->state.scheme.load_at_start,
                        model->disc.nodal.force));
  if (model->scene.body_force.function) {
    const PetscReal at = time - model->state.scheme.load_at_start * model->disc.sum->step.span;

    PetscCall(MpmBodyForceApply(model->scene.body_force.function, model->scene.body_force.ctx, at, model->disc.sum,
                                model->disc.nodal.force));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Data of the sums over points; a first sub-step of two stays. */
static void SetSums(MpmModel model, const MpmRules *rules, PetscReal time, PetscReal dt)
{
  MpmSumStep step = {.dt      = dt,
                     .span    = model->state.scheme.rescuing.on ? time - model->state.time : dt,
                     .part    = 1.,
                     .drained = model->scene.stages.at[model->state.stage].drained,
                     .first   = model->disc.sum->step.first};

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) step.gravity[a] = rules->gravity[a];
  MpmDiscretizationSetStep(&model->disc, &step);
}

PetscErrorCode MpmStepBegin(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, MpmOutcome *outcome)
{
  const MpmRules rules = MpmStepRules(model, time);
  PetscLogDouble since;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  PetscCall(MpmMonitorBegin(&model->monitor, MPM_TIME_TRANSFER, &since));
  if (!again) PetscCall(PrepareSpace(model, &rules, outcome));
  if (!outcome->code) {
    SetSums(model, &rules, time, dt);
    PetscCall(PrepareConditions(model, &rules, time, outcome));
  }
  PetscCall(MpmMonitorEnd(&model->monitor, MPM_TIME_TRANSFER, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}
