/*
  The loads' part of a step's derivatives: forces on the points, and their derivatives by parameters.
*/
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/point_shape.h"
#include "space/rules.h"
#include "space/sum.h"
#include "sensitivity/step_map.h"

/* Adds `factor` times a load's vector times each point's share of it, or its mass, to the points' forces. */
static PetscErrorCode AddLoad(const MpmStepMap *map, const MpmLoad *load, PetscReal factor, PetscReal body[])
{
  const MpmPoints *points = map->sum->points;
  const PetscInt   dim    = map->sum->space->dim;
  PetscReal       *share  = NULL;

  PetscFunctionBeginUser;
  if (load->share_field) PetscCall(MpmParticlesGetField(map->particles, load->share_field, &share));
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal amount = factor * (share ? share[p] : MpmPointMass(points, map->sum->materials, p));

    for (PetscInt a = 0; a < dim; a++) body[p * dim + a] += amount * load->value[a];
  }
  if (share) PetscCall(MpmParticlesRestoreField(map->particles, &share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadsFind(const MpmStepMap *map, PetscReal body[])
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(body, map->sum->points->count * map->sum->space->dim));
  for (PetscInt l = 0; l < map->load_count; l++) PetscCall(AddLoad(map, &map->loads[l], map->factors[l], body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The change of gravity's force with a material's density. */
static void AddDensity(const MpmStepMap *map, PetscInt material, PetscReal body[])
{
  const MpmPoints *points = map->sum->points;
  const PetscInt   dim    = map->sum->space->dim;

  for (PetscInt p = 0; p < points->count; p++)
    for (PetscInt a = 0; points->material[p] == material && a < dim; a++)
      body[p * dim + a] += points->volume0[p] * map->rules->gravity[a];
}

/* The change of the points' forces with a parameter; `any`: there is one. */
static PetscErrorCode Differentiate(const MpmStepMap *map, PetscInt k, PetscReal body[], PetscBool *any)
{
  const MpmSceneParameter *parameter = &map->parameters->at[k];

  PetscFunctionBeginUser;
  *any = (PetscBool)(parameter->kind == MPM_OF_LOAD || parameter->density);
  if (!*any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArrayzero(body, map->sum->points->count * map->sum->space->dim));
  if (parameter->density) AddDensity(map, parameter->index, body);
  else PetscCall(AddLoad(map, &map->loads[parameter->index], map->factors[parameter->index] / parameter->value, body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* residual -= the points' forces at the local nodes, where that is not NULL; *work += lam . these forces likewise. */
static PetscErrorCode Spread(const MpmStepMap *map, const PetscReal body[], PetscReal residual[], const PetscReal lam[],
                             PetscReal *work)
{
  const MpmSum   *sum   = map->sum;
  const MpmSpace *space = sum->space;
  const PetscInt  dim   = space->dim;
  MpmBasis        basis;

  PetscFunctionBeginUser;
  PetscCall(MpmBasisCreate(space, &basis));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscReal *force           = &body[space->order[s] * dim];
      PetscReal        at[MPM_MAX_DIM] = {0.};

      MpmSpaceEvaluate(space, group, space->order[s], &basis);
      if (residual) MpmWeightsAdd(MpmBasisWeights(&basis), group, sum, -1., force, residual);
      if (lam) MpmBasisInterpolate(space, group, &basis, sum->block, lam, dim, at);
      for (PetscInt a = 0; lam && a < dim; a++) *work += at[a] * force[a];
    }
  }
  PetscCall(MpmBasisDestroy(&basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadsAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[])
{
  PetscReal *body;
  PetscBool  any;

  PetscFunctionBeginUser;
  if (direction->parameter < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((map->sum->points->count * map->sum->space->dim + 1), &body));
  PetscCall(Differentiate(map, direction->parameter, body, &any));
  if (any) PetscCall(Spread(map, body, residual, NULL, NULL));
  PetscCall(PetscFree(body));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadsPull(const MpmStepMap *map, const PetscReal lam[], PetscReal gradient[])
{
  PetscReal *body;
  PetscBool  any;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((map->sum->points->count * map->sum->space->dim + 1), &body));
  for (PetscInt k = 0; k < map->parameters->count; k++) {
    PetscCall(Differentiate(map, k, body, &any));
    if (any) PetscCall(Spread(map, body, NULL, lam, &gradient[k]));
  }
  PetscCall(PetscFree(body));
  PetscFunctionReturn(PETSC_SUCCESS);
}
