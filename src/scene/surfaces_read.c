/*
  Surfaces of bodies, and boundaries that are drained: their data from the scene.
*/
#include "point/layout.h"
#include "point/registry.h"
#include "particles/body.h"
#include "bc/bc.h"
#include "rigid/rigid.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "query/model.h"
#include "scene/scene_read.h"

/* Rows of the state of surfaces: bodies' points, and water that has passed. */
static PetscErrorCode AddRows(MpmModel model)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++) {
    MpmLoadActing *acting = &model->state.acting.loads[model->scene.loads->count + k];
    const MpmRow   rows[] = {
        {"first", MPM_ROW_INT, MPM_ROW_RUN, &acting->first, 0, 0},
        {"end", MPM_ROW_INT, MPM_ROW_RUN, &acting->end, 0, 0},
        {"outflow", MPM_ROW_REAL, MPM_ROW_STATE, &acting->outflow, 0, 0},
    };
    char *head = NULL;

    PetscCall(MpmTextAppend(&head, "surface_%s_", model->scene.surfaces->names[k]));
    PetscCall(MpmRowsAdd(model->state.rows, head, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
    PetscCall(PetscFree(head));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfacesRead(MpmModel model, const MpmOptions *options)
{
  MpmBodySurfaces *surfaces = model->scene.surfaces;

  PetscFunctionBeginUser;
  PetscCall(MpmBodySurfacesAddDrained(model->scene.boundaries, surfaces));
  PetscCall(PetscCalloc1((model->scene.loads->count + surfaces->count), &model->state.acting.loads));
  PetscCall(AddRows(model));
  for (PetscInt k = 0; k < surfaces->named; k++) {
    PetscReal tolerance[MPM_MAX_DIM];

    for (PetscInt a = 0; a < model->disc.dim; a++) tolerance[a] = MPM_TOLERANCE * model->disc.h[a];
    PetscCall(MpmBodySurfaceCreate(options, surfaces->names[k], model->disc.layout, tolerance, model->scene.bodies,
                                   &surfaces->at[k]));
    if (surfaces->at[k].loaded) model->solver.definite.symmetric = PETSC_FALSE; /* the load follows its face */
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmSurfacesSetBodies(MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++) {
    MpmLoadActing *acting = &model->state.acting.loads[model->scene.loads->count + k];

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
    PetscCall(MpmPhysicsCreate(model->scene.physics.name, &model->scene.stabilization.plain, &found));
    kernel = found ? &model->scene.stabilization.plain.kernels[model->scene.deformation.kinematics] : kernel;
  }
  PetscCall(MpmDiscretizationAddSurfaces(&model->disc, model->scene.surfaces,
                                         &model->state.acting.loads[model->scene.loads->count], kernel));
  model->disc.context.surfaces->bcs        = model->scene.bcs;
  model->disc.context.surfaces->bcs_acting = model->state.acting.bcs;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfacesTellHeld(MpmModel model)
{
  const MpmBodySurfaces *surfaces = model->scene.surfaces;
  PetscInt              *held;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(model->scene.bcs->count, &held));
  for (PetscInt k = 0; k < surfaces->named; k++) {
    char   names[256] = "";
    size_t length     = 0;

    if (!MpmBodySurfaceIsAll(&surfaces->at[k], model->disc.dim)) continue;
    if (!model->state.acting.loads[model->scene.loads->count + k].active) continue;
    if (model->state.acting.loads[model->scene.loads->count + k].start < model->state.period.start)
      continue; /* reported before */
    PetscCall(MpmSurfaceFacesFindHeld(model->disc.context.surfaces, model->disc.grid, model->state.particles, k, held));
    for (PetscInt b = 0; b < model->scene.bcs->count; b++) {
      if (!held[b]) continue;
      PetscCall(
        PetscSNPrintf(&names[length], sizeof(names) - length, "%s%s", length ? ", " : "", model->scene.bcs->names[b]));
      PetscCall(PetscStrlen(names, &length));
    }
    if (length)
      PetscCall(
        MpmMonitorLine(&model->monitor,
                       "surface %s: faces on planes of symmetry left out, whose nodes are held along the normal by %s",
                       surfaces->names[k], names));
  }
  PetscCall(PetscFree(held));
  PetscFunctionReturn(PETSC_SUCCESS);
}
