/*
  What points start with that bodies do not know: the physics' own states, and the parts of the material.
*/
#include "point/layout.h"
#include "point/material.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "run/run.h"

PetscErrorCode MpmFillOwnStates(MpmModel model)
{
  const MpmPhysics *physics = &model->scene.physics;
  MpmPoints         points;

  PetscFunctionBeginUser;
  if (!model->disc.layout->own_size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const MpmMaterial *material = &model->scene.materials->at[points.material[p]];
    PetscReal         *own      = &points.own[p * model->disc.layout->own_size];

    MpmStatesAtRest((size_t)physics->state_count, physics->states, model->disc.dim, own);
    if (physics->initial) {
      const MpmPhysicsMaterial of = MpmMaterialForPhysics(material, model->disc.dim);

      physics->initial(&of, material->physics_parameter,
                       points.state ? &points.state[p * model->state.particles->state_size] : NULL, own);
    }
  }
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
