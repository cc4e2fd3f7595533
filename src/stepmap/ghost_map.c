/*
  The part of a step's derivatives of the penalty on jumps across faces: r = K u, with K in proportion to gamma E_s for
  each face, E_s the stiffer one of the materials beside it (volume/ghost_penalty.c). Which faces have it is decided.
*/
#include <string.h>
#include "point/layout.h"
#include "point/material.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "volume/ghost_faces.h"
#include "volume/volume.h"
#include "stepmap/step_map.h"

/* True where a parameter is the modulus with which the penalty of its material goes. */
static PetscBool IsModulus(const MpmStepMap *map, const MpmSceneParameter *parameter)
{
  if (parameter->kind != MPM_OF_LAW) return PETSC_FALSE;
  return (PetscBool)!strcmp(map->sum->materials[parameter->index].info.parameters[parameter->place].name, "E");
}

/* The part of a face's modulus that is a material's: the stiffer one's, or half of each where both are equal. */
static PetscReal PartOf(const MpmMaterial *materials, const MpmFace *face, PetscInt material)
{
  const PetscReal E[]  = {materials[face->material[0]].moduli.penalty, materials[face->material[1]].moduli.penalty};
  PetscReal       part = 0.;

  for (int side = 0; side < 2; side++)
    if (face->material[side] == material && E[side] >= E[1 - side]) part += E[side] > E[1 - side] ? 1. : 0.5;
  return part;
}

/* Adds times dK/dE u at the local nodes, E that of a material. */
static PetscErrorCode AddByModulus(const MpmStepMap *map, PetscInt material, PetscReal times, PetscReal force[])
{
  const MpmMaterial *materials = map->sum->materials;
  const MpmFaces    *faces     = &map->sum->space->boxes.faces;
  MpmSpace           space     = *map->sum->space;
  MpmSum             sum       = *map->sum;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((faces->count + 1), &space.boxes.faces.face));
  for (PetscInt f = 0; f < faces->count; f++) {
    MpmFace *face = &space.boxes.faces.face[f];

    *face       = faces->face[f];
    face->gamma = 0.;
    face->stiffness *= times / materials[material].moduli.penalty * PartOf(materials, face, material);
  }
  sum.space = &space;
  PetscCall(MpmTermGhost.apply(NULL, &sum, NULL, map->u, force));
  PetscCall(PetscFree(space.boxes.faces.face));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGhostAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[])
{
  const MpmSceneParameter *parameter = direction->parameter < 0 ? NULL : &map->parameters->at[direction->parameter];
  const MpmFieldParameter *field     = direction->ground ? &map->grounds->at[direction->ground->index] : NULL;

  PetscFunctionBeginUser;
  if (!map->sum->space->boxes.faces.count) PetscFunctionReturn(PETSC_SUCCESS);
  if (direction->du) PetscCall(MpmTermGhost.apply(NULL, map->sum, NULL, direction->du, residual));
  if (parameter && IsModulus(map, parameter)) PetscCall(AddByModulus(map, parameter->index, 1., residual));
  if (field && field->modulus)
    PetscCall(AddByModulus(map, field->material, direction->ground->change[field->largest], residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGhostPullSolution(const MpmStepMap *map, const PetscReal lam[], PetscReal u[])
{
  const PetscInt count = map->sum->space->local * map->sum->block;
  PetscReal     *force;

  PetscFunctionBeginUser;
  if (!map->sum->space->boxes.faces.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((count + 1), &force));
  PetscCall(MpmTermGhost.apply(NULL, map->sum, NULL, lam, force));
  for (PetscInt k = 0; k < count; k++) u[k] -= force[k];
  PetscCall(PetscFree(force));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGhostPullStart(const MpmStepMap *map, const PetscReal lam[], PetscReal gradient[])
{
  const PetscInt count = map->sum->space->local * map->sum->block;
  PetscReal     *force;

  PetscFunctionBeginUser;
  if (!map->sum->space->boxes.faces.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((count + 1), &force));
  for (PetscInt k = 0; k < map->parameters->count; k++) {
    if (!IsModulus(map, &map->parameters->at[k])) continue;
    PetscCall(PetscArrayzero(force, count));
    PetscCall(AddByModulus(map, map->parameters->at[k].index, 1., force));
    for (PetscInt i = 0; i < count; i++) gradient[k] -= lam[i] * force[i];
  }
  for (PetscInt k = 0; k < map->grounds->count; k++) {
    MpmFieldParameter *field = &map->grounds->at[k];

    if (!field->modulus) continue;
    PetscCall(PetscArrayzero(force, count));
    PetscCall(AddByModulus(map, field->material, 1., force));
    for (PetscInt i = 0; i < count; i++) field->by_largest -= lam[i] * force[i];
  }
  PetscCall(PetscFree(force));
  PetscFunctionReturn(PETSC_SUCCESS);
}
