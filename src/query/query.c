/*
  Questions of scene and state that have their answer there.
*/
#include "geometry/geometry.h"
#include "point/material.h"
#include "particles/body.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/query.h"
#include "query/scene.h"

const char *MpmKindText(const MpmModel model)
{
  return model->scene.deformation.kinematics == MPM_AXISYMMETRY ? "axisymmetric" : model->disc.dim == 2 ? "2D" : "3D";
}

PetscBool MpmStagesAreGeostatic(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].geostatic.method != MPM_GEOSTATIC_NONE) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscReal MpmGeostaticEnd(const MpmModel model)
{
  PetscReal end = 0.;

  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    if (model->scene.stages.at[k].geostatic.method == MPM_GEOSTATIC_NONE) return end;
    end += model->scene.stages.at[k].time.end;
  }
  return end;
}

PetscBool MpmStagesKeepMass(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    for (PetscInt b = 0; b < model->scene.bodies->count; b++)
      if (model->scene.stages.at[k].material[b] >= 0) return PETSC_TRUE;
  return MpmStagesAreGeostatic(model);
}

PetscReal MpmModelLoadFactor(const MpmModel model, PetscInt load, PetscReal time)
{
  const MpmLoadActing *acting = &model->state.acting.loads[load];
  const PetscInt       loads  = model->scene.loads->count;
  const MpmRamp ramp = load < loads ? model->scene.loads->at[load].ramp : model->scene.surfaces->at[load - loads].ramp;

  if (!acting->active || !ramp) return 0.;
  if (acting->forced) return model->state.scheme.load_scale * acting->factor;
  return model->state.scheme.load_scale * MpmRampEvaluate(ramp, time - acting->start);
}

PetscReal MpmModelSurfacePressure(const MpmModel model, PetscInt surface, PetscReal time)
{
  const MpmBodySurface *of     = &model->scene.surfaces->at[surface];
  const MpmLoadActing  *acting = &model->state.acting.loads[model->scene.loads->count + surface];

  return of->ramped ? of->pressure * MpmRampEvaluate(of->ramp, time - acting->start) : of->pressure;
}

const MpmMotionControl *MpmModelMotion(const MpmModel model)
{
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];

  return model->state.scheme.rescuing.on ? &stage->relaxation.motion : &stage->time.motion;
}

PetscBool MpmModelRelaxes(const MpmModel model)
{
  return (PetscBool)(model->scene.stages.at[model->state.stage].relaxation.on || model->state.scheme.rescuing.on);
}

PetscBool MpmStagesRelax(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].relaxation.on || model->scene.stages.at[k].time.rescue) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmModelScales(const MpmModel model)
{
  return (PetscBool)(MpmModelRelaxes(model) && model->scene.stages.at[model->state.stage].relaxation.scaled);
}

PetscBool MpmStageSettles(const MpmStage *stage)
{
  return (PetscBool)(stage->reduction.ramp && stage->time.motion.type == MPM_QUASISTATIC && !stage->time.rescue);
}

PetscBool MpmStagesReduce(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].reduction.ramp) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmReductionSeeks(const MpmModel model)
{
  if (!model->scene.stages.at) return PETSC_FALSE; /* a stress point has none */
  return (PetscBool)(model->scene.stages.at[model->state.stage].reduction.ramp && !(model->state.safety.factor > 0.));
}

PetscReal MpmReductionFactor(const MpmModel model, PetscReal time)
{
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];
  const PetscReal along = time - model->state.period.start, left = 1. - along / model->state.dt.nominal;
  PetscReal       factor;

  if (!stage->reduction.ramp) return 1.;
  factor = MpmRampEvaluate(stage->reduction.ramp, along);
  if (left > 0. && stage->time.motion.type == MPM_QUASISTATIC && model->state.safety.start > 0.)
    factor += left * (model->state.safety.start - MpmRampEvaluate(stage->reduction.ramp, 0.));
  return factor;
}

PetscBool MpmRemovalGoesOn(const MpmModel model)
{
  for (PetscInt b = 0; model->state.scheme.fading && b < model->scene.bodies->count; b++)
    if (model->state.scheme.fading[b].ramp) return PETSC_TRUE;
  return PETSC_FALSE;
}

/*
  With z = w dt of a lumped mode and q in [0, 1] the fraction of its velocity kept by the node-point-node transfer, a
  step is

    musl  s += z v',  v' = v - q z s       z^2 q < 4
    usf   musl in the other order          z^2 q < 4
    usl   s += z (v - z s),  v' as above   z^2 (2 - q) < 4

  and w < 2/crossing: hence the factor sqrt(1/2) of usl, whose finest modes have q near 0.
*/
PetscReal MpmExplicitPart(const MpmMotionControl *motion)
{
  return motion->update == MPM_UPDATE_USL ? PetscSqrtReal(0.5) : 1.;
}

void MpmStageEndHere(MpmModel model)
{
  MpmState *state = &model->state;

  state->period.run_end -= state->period.end - state->time;
  state->period.end = state->relaxing.ended[state->stage] = state->time;
}

PetscBool MpmStagesControlError(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].time.second && model->scene.stages.at[k].time.error > 0.) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmStagesConsolidate(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stages.count; k++)
    if (model->scene.stages.at[k].consolidation > 0.) return PETSC_TRUE;
  return PETSC_FALSE;
}

PetscBool MpmSceneIsSymmetric(MpmModel model)
{
  const MpmPhysics *physics = &model->scene.physics;

  if (!physics->symmetric) return (PetscBool)((physics->traits & MPM_PHYSICS_SYMMETRIC) != 0);
  for (PetscInt l = 0; l < model->scene.loads->count && physics->taken_up; l++)
    if (model->scene.loads->at[l].type == MPM_LOAD_GRAVITY) return PETSC_FALSE; /* water taken up has weight */
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    const MpmMaterial       *material = &model->scene.materials->at[m];
    const MpmPhysicsMaterial of       = MpmMaterialForPhysics(material, NULL, model->disc.dim);

    if (!physics->symmetric(&of, material->physics_parameter)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

void MpmModelExchange(MpmModel model, MpmProblem *problem)
{
  const MpmProblem own = {.disc = model->disc, .solver = model->solver, .materials = model->scene.materials};

  model->disc            = problem->disc;
  model->solver          = problem->solver;
  model->scene.materials = problem->materials;
  *problem               = own;
}
