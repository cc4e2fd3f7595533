/*
  The numbers that the kernel of a physics with a rate takes from the step's start.
*/
#include "stepmap/rates_map.h"

#define MOST_VALUES 64 /* of a physics' parameters */

PetscErrorCode MpmStageNumbersCreate(const MpmStepMap *map, MpmStageNumbers *stage)
{
  const MpmLayout *layout = map->sum->layout;
  const PetscInt   count  = map->sum->points->count;

  PetscFunctionBeginUser;
  *stage = (MpmStageNumbers){0};
  if (!layout->rate.count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((count * layout->deviation.count + 1), &stage->deviation_n));
  if (!map->sum->step.first) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((count * map->sum->points->F_size + 1), &stage->F));
  PetscCall(PetscCalloc1((count * layout->rate.count + 1), &stage->value));
  PetscCall(PetscCalloc1((count * layout->deviation.count + 1), &stage->deviation));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStageNumbersDestroy(MpmStageNumbers *stage)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(stage->deviation_n));
  PetscCall(PetscFree(stage->F));
  PetscCall(PetscFree(stage->value));
  PetscCall(PetscFree(stage->deviation));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmRateSize(const MpmStepMap *map, MpmRateNumber kind)
{
  const MpmSum  *sum   = map->sum;
  const PetscInt rates = sum->layout->rate.count, first = sum->step.first ? rates : 0;

  switch (kind) {
  case MPM_RATE_OWN:
    return sum->kept.own;
  case MPM_RATE_FIRST_F:
    return first ? sum->points->F_size : 0;
  case MPM_RATE_FIRST_VALUE:
  case MPM_RATE_FIRST_DEVIATION:
    return first;
  default:
    return rates;
  }
}

PetscInt MpmRateSizes(const MpmStepMap *map)
{
  PetscInt size = 0;

  for (PetscInt k = 0; k < MPM_RATE_NUMBERS; k++) size += MpmRateSize(map, (MpmRateNumber)k);
  return size;
}

PetscInt MpmPhysicsValues(const MpmStepMap *map)
{
  return MPM_MAX_DIM * map->physics->parameter_count + map->physics->common_count;
}

const double **MpmRateMember(MpmKernelDirection *direction, MpmRateNumber kind)
{
  const double **members[MPM_RATE_NUMBERS] = {&direction->value_n,     &direction->own_n,
                                              &direction->deviation_n, &direction->stage.F,
                                              &direction->stage.value, &direction->stage.deviation};

  return members[kind];
}

PetscReal *MpmRateArray(const MpmPointVector *start, const MpmStageNumbers *stage, MpmRateNumber kind)
{
  PetscReal *const arrays[MPM_RATE_NUMBERS] = {start->at[MPM_VECTOR_VALUE],       start->at[MPM_VECTOR_OWN],
                                               stage ? stage->deviation_n : NULL, stage ? stage->F : NULL,
                                               stage ? stage->value : NULL,       stage ? stage->deviation : NULL};

  return arrays[kind];
}

PetscBool MpmPhysicsHasParameter(const MpmSceneParameter *parameter, PetscInt material)
{
  return (PetscBool)(parameter->kind == MPM_OF_PHYSICS && (parameter->index < 0 || parameter->index == material));
}

/* The change of the physics' values of a material with a parameter. */
static void Change(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscInt material, double change[])
{
  for (PetscInt k = 0; k < parameter->places; k++) {
    const PetscInt place = parameter->place + k;

    if (map->physics->change) map->physics->change(map->sum->materials[material].physics_parameter, (int)place, change);
    else change[place] = 1.;
  }
}

PetscReal MpmPhysicsSlope(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscInt material, PetscInt value)
{
  double change[MOST_VALUES] = {0.};

  Change(map, parameter, material, change);
  return change[value];
}

void MpmPhysicsDirection(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscInt material, double rows[])
{
  double change[MOST_VALUES] = {0.};

  Change(map, parameter, material, change);
  for (PetscInt k = 0; k < MpmPhysicsValues(map); k++) rows[k * MPM_PACK] = change[k];
}
