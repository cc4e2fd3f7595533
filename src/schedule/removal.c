/*
  Bodies that are taken away by a ramp.

    stage_dig: {remove: pit, removal: "0:0,1:1", time: {end: 1, step: 0.1}}

  At the factor r a removed body has the fraction 1 - r of its material left: of volume, mass and shares of loads of its
  points. Stress, stiffness and weight then fade together, and the body's load passes over to the remaining ones. In a
  step that ends with r = 1 its points are gone. Shorter steps are thus smaller excavations; elastic ground ends where
  it would after removal at once.

  The fraction belongs to the time of a step's end. Set() applies it when a step is tried, and again for the step's
  start when it is rolled back. Points that are gone are parked until the step is accepted. A ramp that is longer than
  its stage goes on in the next one.

  Without the option the ramp is 0:0,1:1, or to the end of a shorter stage. Geostatic stages, and those with inertia and
  without the option, remove at once.

  Order of calls: Begin() as the stage takes its bodies; then for each step Set(), and Commit() once it is accepted.
*/
#include "geometry/geometry.h"
#include "particles/body.h"
#include "facets/outer_faces.h"
#include "particles/particles.h"
#include "loads/load.h"
#include "query/model.h"
#include "step/energy.h"
#include "schedule/stage.h"

PetscBool MpmRemovalBegin(MpmModel model, const MpmStage *stage, PetscInt body)
{
  MpmFading *fading = &model->state.scheme.fading[body];

  if (!stage->removal || MpmRampEvaluate(stage->removal, 0.) == 1.) return PETSC_FALSE;
  *fading = (MpmFading){.ramp = stage->removal, .start = model->state.period.start, .left = 1.};
  return PETSC_TRUE;
}

/* A smaller part is none: the ramp's times are sums of steps. */
#define LEAST 1e-9

/* The part of a body that is left at a time. */
static PetscReal Left(const MpmFading *fading, PetscReal time)
{
  const PetscReal left = 1. - MpmRampEvaluate(fading->ramp, time - fading->start);

  return left > LEAST ? left : 0.;
}

void MpmRemovalResume(MpmModel model)
{
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    MpmFading *fading = &model->state.scheme.fading[b];

    if (fading->ramp) fading->left = Left(fading, model->state.time);
    if (!(fading->left > 0.)) fading->ramp = NULL;
  }
}

/* Multiplies a field of one number a point. */
static PetscErrorCode ScaleField(MpmModel model, const char *name, const PetscInt id[], PetscInt first, PetscInt end,
                                 PetscReal by)
{
  PetscReal *value;
  PetscInt   count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  PetscCall(MpmParticlesGetField(model->state.particles, name, &value));
  for (PetscInt p = 0; p < count; p++)
    if (id[p] >= first && id[p] < end) value[p] *= by;
  PetscCall(MpmParticlesRestoreField(model->state.particles, &value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ScaleBody(MpmModel model, PetscInt body, PetscReal by)
{
  PetscInt first, end, *id;

  PetscFunctionBeginUser;
  MpmBodyGetIds(model->scene.bodies->at[body], &first, &end);
  PetscCall(MpmParticlesGetField(model->state.particles, "id", &id));
  PetscCall(ScaleField(model, "volume0", id, first, end, by));
  if (model->state.particles->has_mass) PetscCall(ScaleField(model, "mass", id, first, end, by));
  for (PetscInt l = 0; l < model->scene.loads->count; l++)
    if (model->scene.loads->at[l].share_field)
      PetscCall(ScaleField(model, model->scene.loads->at[l].share_field, id, first, end, by));
  PetscCall(MpmParticlesRestoreField(model->state.particles, &id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Brings one body to its part at a time; `moved`: its points have come or gone. */
static PetscErrorCode SetBody(MpmModel model, PetscInt body, PetscReal time, PetscBool *moved)
{
  MpmFading      *fading = &model->state.scheme.fading[body];
  const PetscReal left   = Left(fading, time);
  PetscInt        first, end;

  PetscFunctionBeginUser;
  MpmBodyGetIds(model->scene.bodies->at[body], &first, &end);
  if (fading->gone && left > 0.) {
    PetscCall(MpmParticlesReturn(model->state.particles, &model->state.scheme.parked[body]));
    fading->gone = PETSC_FALSE;
    *moved       = PETSC_TRUE;
  }
  if (!(left > 0.)) {
    if (fading->gone) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(MpmParticlesRemove(model->state.particles, first, end, &model->state.scheme.parked[body]));
    fading->gone = *moved = PETSC_TRUE;
  } else if (left != fading->left) {
    PetscCall(ScaleBody(model, body, left / fading->left));
    fading->left = left;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRemovalSet(MpmModel model, PetscReal time, MpmOutcome *outcome)
{
  PetscBool moved = PETSC_FALSE;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmEnergyMark(model));
  for (PetscInt b = 0; b < model->scene.bodies->count; b++)
    if (model->state.scheme.fading[b].ramp) PetscCall(SetBody(model, b, time, &moved));
  if (moved) {
    PetscCall(MpmParticlesDistribute(model->state.particles, model->disc.grid, outcome));
    PetscCall(MpmOuterFacesUpdate(model->state.particles, model->scene.materials, model->disc.grid));
  }
  PetscCall(MpmEnergyRebase(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRemovalCommit(MpmModel model)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    if (!model->state.scheme.fading[b].gone) continue;
    PetscCall(PetscFree(model->state.scheme.parked[b].data));
    model->state.scheme.parked[b].count = 0;
    model->state.scheme.fading[b]       = (MpmFading){.ramp = NULL};
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
