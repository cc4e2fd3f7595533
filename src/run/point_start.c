/*
  What points start with that bodies do not know: the physics' own states, parameters, and the parts of the material.
*/
#include "point/layout.h"
#include "point/material.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "rigid/rigid.h"
#include "contact/body_contact.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "time/scene.h"
#include "run/run.h"

/* Contact, regions of surfaces and parameters that vary need initial places, which a stage may overwrite otherwise. */
PetscBool MpmOriginIsKept(const MpmModel model)
{
  PetscBool wanted = (PetscBool)(model->scene.boundaries->count > 0 || model->scene.pairs->count > 0),
            resets = PETSC_FALSE;

  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    wanted = (PetscBool)(wanted || model->scene.materials->at[m].varies);
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++)
    wanted = (PetscBool)(wanted || model->scene.surfaces->at[k].region);
  for (PetscInt s = 0; s < model->scene.stage_count; s++) resets = (PetscBool)(resets || model->scene.stages[s].reset);
  return (PetscBool)(wanted && resets);
}

/* Numbers that a point has of its own where parameters vary, as many for each. */
PetscInt MpmOwnParametersSize(MpmModel model)
{
  MpmMaterials *materials = model->scene.materials;
  PetscInt      most      = 0;

  for (PetscInt m = 0; m < materials->count; m++) most = PetscMax(most, MpmMaterialOwnSize(&materials->at[m]));
  for (PetscInt m = 0; m < materials->count; m++)
    if (materials->at[m].varies) materials->at[m].varies->stride = most;
  return most;
}

PetscErrorCode MpmBodiesPrepare(MpmModel model)
{
  PetscInt axis, up;

  PetscFunctionBeginUser;
  MpmLoadsGetVertical(model->scene.loads, model->disc.dim, &axis, &up);
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    PetscBool joins = PETSC_FALSE;

    MpmBodySetVertical(model->scene.bodies->at[b], axis, up);
    for (PetscInt k = 1; k < model->scene.stage_count; k++)
      joins = (PetscBool)(joins || model->scene.stages[k].adds[b]);
    if (joins) MpmBodySetJoins(model->scene.bodies->at[b]);
    MpmCheckInput(joins || MpmBodyFills(model->scene.bodies->at[b]) != MPM_FILL_YES,
                  "-mpm_body_%s_fill true: the body joins no stage, must be in the list of bodies of a later one",
                  model->scene.bodies->names[b]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFillOwnStates(MpmModel model)
{
  const MpmPhysics *physics = &model->scene.physics;
  MpmPoints         points;

  PetscFunctionBeginUser;
  if (!model->disc.layout->own_size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const MpmMaterial *material   = &model->scene.materials->at[points.material[p]];
    const double      *own_values = MpmPointOwn(&points, material, p);
    PetscReal         *own        = &points.own[p * model->disc.layout->own_size];

    MpmStatesAtRest((size_t)physics->state_count, physics->states, model->disc.dim, own);
    if (physics->initial) {
      const MpmPhysicsMaterial of = MpmMaterialForPhysics(material, own_values, model->disc.dim);

      physics->initial(&of, MpmMaterialPhysicsValues(material, own_values),
                       points.state ? &points.state[p * model->state.particles->state_size] : NULL, own);
    }
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- what files have ---- */

PetscErrorCode MpmReadBodyFile(MpmModel model, const MpmOptions *options, PetscInt b)
{
  const MpmPhysics *physics = &model->scene.physics;
  const MpmLayout  *layout  = model->disc.layout;
  MpmFileField     *fields;
  PetscInt          count = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((size_t)(physics->state_count + layout->rates + 1), &fields));
  for (PetscInt s = 0; s < physics->state_count; s++) {
    const MpmStateVariable *state = &physics->states[s];

    fields[count++] =
      (MpmFileField){state->name, state->kind == MPM_STATE_SYM ? 6 : MpmStateComponents(state, model->disc.dim)};
  }
  for (PetscInt r = 0; r < layout->rates; r++)
    fields[count++] = (MpmFileField){layout->component_name[layout->rate_component[r]], 1};
  PetscCall(MpmBodyReadFile(options, model->scene.bodies->names[b], model->disc.grid, model->scene.materials->at, count,
                            fields, model->scene.bodies->at[b]));
  PetscCall(PetscFree(fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The row's states of the physics and values with a rate, of point p; its mass is then that of the file. */
static void TakeFields(MpmModel model, MpmBody body, PetscInt row, PetscInt p, MpmPoints *points)
{
  const MpmPhysics *physics = &model->scene.physics;
  const MpmLayout  *layout  = model->disc.layout;
  PetscReal        *own     = points->own ? &points->own[p * layout->own_size] : NULL;

  for (PetscInt s = 0; s < physics->state_count; s++) {
    const PetscInt   size   = MpmStateComponents(&physics->states[s], model->disc.dim);
    const PetscInt   stride = physics->states[s].kind == MPM_STATE_SYM ? 6 : size;
    const PetscReal *value  = MpmBodyFileField(body, physics->states[s].name);

    for (PetscInt c = 0; value && c < size; c++) own[c] = value[row * stride + c];
    own += size;
  }
  for (PetscInt r = 0; r < layout->rates; r++) {
    const PetscReal *value = MpmBodyFilePressure(body, layout->component_name[layout->rate_component[r]]);

    if (value) points->value[p * layout->rates + r] = value[row];
  }
  if (layout->taken_up >= 0 && MpmBodyFileHasMass(body))
    points->mass[p] += points->mass[p] - MpmPointMassNow(points, model->scene.materials->at, layout, p);
}

PetscErrorCode MpmFillFromFiles(MpmModel model)
{
  const MpmBodies *bodies = model->scene.bodies;
  PetscInt        *body_of, row = 0;
  MpmPoints        points;

  PetscFunctionBeginUser;
  if (!model->disc.layout->rates && !model->disc.layout->own_size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscMalloc1(points.count, &body_of));
  MpmBodiesOfPoints(bodies->count, bodies->at, &points, body_of);
  for (PetscInt p = 0; p < points.count; p++, row++) {
    if (!p || body_of[p] != body_of[p - 1]) row = 0;
    if (MpmBodyIsImported(bodies->at[body_of[p]])) TakeFields(model, bodies->at[body_of[p]], row, p, &points);
  }
  PetscCall(PetscFree(body_of));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFillParts(MpmModel model)
{
  const MpmBodies *bodies = model->scene.bodies;
  PetscInt        *body_of;
  MpmPoints        points;

  PetscFunctionBeginUser;
  if (model->disc.parts == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscMalloc1(points.count, &body_of));
  MpmBodiesOfPoints(bodies->count, bodies->at, &points, body_of);
  for (PetscInt p = 0; p < points.count; p++) points.part[p] = bodies->part[body_of[p]];
  PetscCall(PetscFree(body_of));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}
