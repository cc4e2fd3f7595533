/*
  Stages: what acts, and on what, one after the other on the same points.

    stages: geostatic,dig,load
    stage_dig: {remove: "pit", bcs: "base,sides", loads: "weight", time: {end: 1, step: 0.1}}

  Order of calls: MpmStagesReadLists() before conditions and loads are read, MpmStagesRead() after (stage_read.c),
  MpmStagesSelect() when the points are there, then MpmStageBegin() for each stage in turn.

  Time grows on through the stages. A ramp counts from the start of the stage in which its condition or load joins; one
  that acts in the next stage too goes on with its own time. A prescribed displacement therefore stays where it is, and
  a load that has reached its full value keeps it.

  Forces and tractions pick their points in the initial state, among the bodies that are there when they first act. A
  body that goes takes its shares with it.
*/
#include "base/columns.h"
#include "geometry/geometry.h"
#include "grid/shape.h"
#include "grid/walls.h"
#include "particles/body.h"
#include "facets/outer_faces.h"
#include "particles/particles.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/query.h"
#include "step/energy.h"
#include "step/moving_grid.h"
#include "step/water_state.h"
#include "integrators/dynamics.h"
#include "integrators/integrators.h"
#include "integrators/relaxation.h"
#include "integrators/time_error.h"
#include "schedule/reduction.h"
#include "schedule/schedule.h"
#include "schedule/stage.h"

PetscErrorCode MpmStagesDestroy(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(model->scene.stages.given.time));
  for (PetscInt k = 0; model->scene.stages.at && k < model->scene.stages.count; k++) {
    MpmStage *stage = &model->scene.stages.at[k];

    PetscCall(PetscFree(stage->name));
    PetscCall(PetscFree(stage->bcs));
    PetscCall(PetscFree(stage->motions));
    PetscCall(PetscFree(stage->loads));
    PetscCall(PetscFree(stage->surfaces));
    PetscCall(PetscFree(stage->removed));
    PetscCall(PetscFree(stage->adds));
    PetscCall(PetscFree(stage->material));
    PetscCall(PetscFree(stage->geostatic.k0));
    PetscCall(MpmRampDestroy(&stage->removal));
    PetscCall(MpmRampDestroy(&stage->change));
    PetscCall(MpmRampDestroy(&stage->reduction.ramp));
  }
  for (PetscInt b = 0; model->state.scheme.parked && b < model->scene.bodies->count; b++)
    PetscCall(PetscFree(model->state.scheme.parked[b].data));
  PetscCall(PetscFree(model->scene.stages.at));
  PetscCall(PetscFree(model->state.scheme.parked));
  PetscCall(MpmInflowDestroy(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- queries of the model ---- */

/* ---- the points are there ---- */

/* Takes the bodies out that are not there in a stage, or before the first one (stage 0 before its own changes). */
static PetscErrorCode ParkAbsent(MpmModel model, PetscInt stage)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    PetscBool there = PETSC_TRUE;
    PetscInt  first, end;

    for (PetscInt k = 0; k < model->scene.stages.count; k++) {
      if (k > stage && model->scene.stages.at[k].adds[b]) there = PETSC_FALSE;
      if (k <= stage && model->scene.stages.at[k].removed[b]) there = PETSC_FALSE;
    }
    if (there) continue;
    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    PetscCall(MpmParticlesRemove(model->state.particles, first, end, &model->state.scheme.parked[b]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReturnAll(MpmModel model)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++)
    PetscCall(MpmParticlesReturn(model->state.particles, &model->state.scheme.parked[b]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The stage in which a load first acts; 0 where it never does. */
static PetscInt FirstStage(const MpmModel model, PetscInt load)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].loads[load]) return k;
  return 0;
}

static PetscErrorCode ClearShares(MpmModel model)
{
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  for (PetscInt l = 0; l < model->scene.loads->count; l++) {
    const char *field = model->scene.loads->at[l].share_field;
    PetscReal  *share;

    if (!field) continue;
    PetscCall(MpmParticlesGetField(model->state.particles, field, &share));
    PetscCall(PetscArrayzero(share, count));
    PetscCall(MpmParticlesRestoreField(model->state.particles, &share));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillStage(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)column;
  PetscFunctionBeginUser;
  values[0] = (PetscReal)model->state.stage + 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStagesAddColumns(MpmModel model, MpmColumns *columns)
{
  const MpmColumn row = {.name = "stage", .unit = "-", .fill = FillStage};

  PetscFunctionBeginUser;
  if (model->scene.stages.at[0].name) PetscCall(MpmColumnsAdd(columns, NULL, &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStagesSelect(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(MpmReductionCheck(model));
  PetscCall(ClearShares(model));
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    PetscCall(ParkAbsent(model, k));
    for (PetscInt l = 0; l < model->scene.loads->count; l++) {
      if (FirstStage(model, l) == k)
        PetscCall(
          MpmLoadSelect(&model->scene.loads->at[l], model->disc.grid, model->scene.materials, model->state.particles));
    }
    PetscCall(ReturnAll(model));
  }
  PetscCall(ParkAbsent(model, -1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a stage begins ---- */

static PetscErrorCode ChangeBodies(MpmModel model, const MpmStage *stage)
{
  PetscInt   first, end;
  MpmOutcome outcome; /* reported by the next step */

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    if (stage->adds[b]) PetscCall(MpmParticlesReturn(model->state.particles, &model->state.scheme.parked[b]));
    if (stage->removed[b] && !MpmRemovalBegin(model, stage, b))
      PetscCall(MpmParticlesRemove(model->state.particles, first, end, NULL));
  }
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    if (!stage->adds[b]) continue;
    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    if (model->state.stage) PetscCall(MpmGapClose(model, b, stage->name));
    PetscCall(MpmWaterFillPressure(model, first, end));
  }
  PetscCall(MpmMovingGridFollow(model, &outcome));
  PetscCall(MpmParticlesMigrate(model->state.particles, model->disc.grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a surface has a load; drained boundaries are drained in all stages. */
static PetscBool ActsOn(const MpmModel model, const MpmStage *stage, PetscInt surface)
{
  return (PetscBool)(surface >= model->scene.surfaces->named || stage->surfaces[surface]);
}

/* Start of the ramp of a condition or motion: in geostatic stages at the run's start nothing moves, but behind them. */
static PetscReal RampStart(const MpmModel model, PetscBool moves)
{
  return moves ? PetscMax(model->state.period.start, MpmGeostaticEnd(model)) : model->state.period.start;
}

/* Start of the ramp of load l, or of a surface behind the loads: a geostatic stage ends under the whole of one that has
   none. */
static PetscReal LoadStart(const MpmModel model, const MpmStage *stage, PetscInt l)
{
  const PetscInt        loads   = model->scene.loads->count;
  const MpmLoad        *load    = l < loads ? &model->scene.loads->at[l] : NULL;
  const MpmBodySurface *surface = load ? NULL : &model->scene.surfaces->at[l - loads];
  const MpmRamp         ramp    = load ? load->ramp : surface->ramp;
  const PetscReal       start   = model->state.period.start;

  if (stage->geostatic.method == MPM_GEOSTATIC_NONE || !ramp || (load ? load->ramped : surface->ramped)) return start;
  return PetscMin(start, model->state.period.end - MpmRampLastChange(ramp));
}

/* Conditions, motions, loads and surfaces active from here on, and the walls that follow. */
static PetscErrorCode Activate(MpmModel model, const MpmStage *stage)
{
  PetscFunctionBeginUser;
  model->state.acting.walls.count = 0;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) {
    MpmActing *bc = &model->state.acting.bcs[b];
    PetscInt   walls;

    if (stage->bcs[b] && !bc->active)
      bc->start = RampStart(model, MpmConditionMoves(&model->scene.bcs->at[b], model->disc.dim));
    bc->active = stage->bcs[b];
    if (!bc->active) continue;
    PetscCall(MpmConditionGetWalls(&model->scene.bcs->at[b], model->disc.grid,
                                   MpmShapeIsSpline(model->scene.shape.type), &walls,
                                   &model->state.acting.walls.at[model->state.acting.walls.count]));
    model->state.acting.walls.count += walls;
  }
  for (PetscInt m = 0; m < model->scene.motions->count; m++) {
    MpmActing *motion = &model->state.acting.bcs[model->scene.bcs->count + m];

    if (stage->motions[m] && !motion->active) motion->start = RampStart(model, PETSC_TRUE);
    motion->active = stage->motions[m];
  }
  for (PetscInt l = 0; l < model->scene.loads->count + model->scene.surfaces->count; l++) {
    MpmLoadActing  *load = &model->state.acting.loads[l];
    const PetscBool acts =
      l < model->scene.loads->count ? stage->loads[l] : ActsOn(model, stage, l - model->scene.loads->count);

    if (acts && !load->active) load->start = LoadStart(model, stage, l);
    load->active = acts;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Which stage is under way, and how its time runs. */
static void SetTime(MpmModel model, PetscInt k)
{
  const MpmTimeControl *control = &model->scene.stages.at[k].time;

  model->state.stage             = k;
  model->state.scheme.load_scale = 1.;
  model->state.period.start      = model->state.time;
  model->state.period.end        = MpmTimeRound(model->state.time + control->end);
  if (model->state.relaxing.ended[k] >= 0.) model->state.period.end = model->state.relaxing.ended[k];
  model->state.dt.nominal  = control->step;
  model->state.dt.least    = control->step_min;
  model->state.dt.most     = control->step_max;
  model->state.dt.growth   = control->growth;
  model->state.dt.adaptive = control->adaptive;

  model->state.scheme.integrator     = &MpmIntegratorQuasistatic;
  model->state.scheme.error.accepted = 0.;
  model->state.scheme.load_at_start  = 0.;
  MpmDynamicsSetStage(model);
  if (model->scene.stages.at[k].geostatic.method != MPM_GEOSTATIC_NONE) return;
  if (control->motion.type == MPM_EXPLICIT) {
    model->state.scheme.integrator = &MpmIntegratorExplicit;
    if (!(control->step > 0.)) { /* each step is as long as it may be */
      model->state.dt.nominal = model->state.dt.most = control->end;
      model->state.dt.adaptive                       = PETSC_TRUE;
    }
    return;
  }
  model->state.scheme.error.accepted = control->error;
  if (control->motion.type != MPM_QUASISTATIC) {
    model->state.scheme.integrator  = &MpmIntegratorImplicit;
    model->state.scheme.error.order = control->motion.type == MPM_BACKWARD_EULER ? 1. : 2.;
    return;
  }
  if (!control->second) return;
  model->state.scheme.error.order = 3.;
  model->state.scheme.integrator  = &MpmIntegratorSdirk;
}

PetscErrorCode MpmStageBegin(MpmModel model, PetscInt k)
{
  const MpmStage *stage  = &model->scene.stages.at[k];
  const PetscReal factor = k ? MpmReductionFactor(model, model->state.time) : 1.;

  PetscFunctionBeginUser;
  PetscCall(MpmEnergyMark(model));
  model->state.safety.start = factor;
  MpmSlideBegin(model);
  SetTime(model, k);
  model->state.dt.wanted = model->state.dt.nominal;
  model->state.dt.last = model->state.scheme.behind = 0.; /* nothing goes on as before */
  PetscCall(MpmReductionApply(model, model->state.time));
  if (stage->name) {
    PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
    PetscCall(ChangeBodies(model, stage));
    PetscCall(MpmMaterialsChange(model, stage));
    if (stage->reset) {
      PetscCall(MpmParticlesStartHere(model->state.particles));
      model->state.reference_output = PETSC_TRUE;
    }
    PetscCall(MpmReductionBegin(model));
    if (model->solver.jacobian.assembled)
      PetscCall(MatSetNearNullSpace(model->solver.jacobian.assembled, NULL)); /* other unknowns may be constrained */
  }
  PetscCall(Activate(model, stage));
  for (PetscInt b = 0; b < model->scene.bcs->count; b++) model->state.acting.bcs[b].volume = 0.;
  PetscCall(MpmOuterFacesUpdate(model->state.particles, model->scene.materials, model->disc.grid));
  PetscCall(MpmTimeErrorBegin(model));
  PetscCall(MpmDynamicsBegin(model));
  MpmRelaxationBegin(model);
  PetscCall(MpmEnergyRebase(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStageResume(MpmModel model)
{
  const PetscInt  stage = model->state.stage;
  const PetscReal time  = model->state.time;

  PetscFunctionBeginUser;
  model->state.time = 0.;
  for (PetscInt k = 0; k <= stage; k++) {
    if (k) model->state.time = model->state.period.end;
    SetTime(model, k);
    PetscCall(Activate(model, &model->scene.stages.at[k]));
    for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
      if (model->scene.stages.at[k].removed[b]) (void)MpmRemovalBegin(model, &model->scene.stages.at[k], b);
      if (!model->scene.stages.at[k].adds[b]) continue;
      PetscCall(PetscFree(model->state.scheme.parked[b].data));
      model->state.scheme.parked[b].count = 0;
    }
  }
  model->state.time = time;
  MpmRemovalResume(model);
  PetscCall(MpmReductionApply(model, time));
  PetscFunctionReturn(PETSC_SUCCESS);
}
