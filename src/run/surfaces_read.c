/*
  Surfaces of bodies, and boundaries that are drained: what of the scene they are.
*/
#include "point/layout.h"
#include "point/registry.h"
#include "particles/body.h"
#include "terms/body_surface.h"
#include "terms/load.h"
#include "terms/rigid.h"
#include "time/time.h"
#include "run/run.h"

PetscErrorCode MpmSurfacesRead(MpmModel model, const MpmOptions *options)
{
  MpmBodySurfaces *surfaces = model->scene.surfaces;

  PetscFunctionBeginUser;
  PetscCall(MpmBodySurfacesAddDrained(model->scene.boundaries, surfaces));
  PetscCall(PetscCalloc1((model->scene.loads->count + surfaces->count), &model->state.loads));
  for (PetscInt k = 0; k < surfaces->named; k++) {
    PetscReal tolerance[MPM_MAX_DIM];

    for (PetscInt a = 0; a < model->disc.dim; a++) tolerance[a] = MPM_TOLERANCE * model->disc.h[a];
    PetscCall(MpmBodySurfaceCreate(options, surfaces->names[k], model->disc.layout, tolerance, model->scene.bodies,
                                   &surfaces->at[k]));
    if (surfaces->at[k].loaded) model->solver.symmetric = PETSC_FALSE; /* the load follows its face */
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmSurfacesSetBodies(MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++) {
    MpmLoadActing *acting = &model->state.loads[model->scene.loads->count + k];

    const PetscInt body = model->scene.surfaces->at[k].body;

    acting->end = PETSC_INT_MAX; /* of all bodies */
    if (body >= 0) MpmBodyGetIds(model->scene.bodies->at[body], &acting->first, &acting->end);
  }
}

/* The surfaces of bodies, with the kernel of the physics itself where another one takes its place for F-bar. */
PetscErrorCode MpmSurfacesAdd(MpmModel model)
{
  const MpmKernelSet *kernel = model->disc.layout->kernel;
  PetscBool           found;

  PetscFunctionBeginUser;
  if (!model->scene.surfaces->count) PetscFunctionReturn(PETSC_SUCCESS);
  if (model->disc.layout->means) {
    PetscCall(MpmPhysicsCreate(model->scene.physics.name, &model->scene.plain, &found));
    kernel = found ? &model->scene.plain.kernels[model->disc.dim] : kernel;
  }
  PetscCall(MpmDiscretizationAddSurfaces(&model->disc, model->scene.surfaces,
                                         &model->state.loads[model->scene.loads->count], kernel));
  PetscFunctionReturn(PETSC_SUCCESS);
}
