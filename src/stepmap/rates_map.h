#pragma once
/*
  The numbers that the kernel of a physics with a rate takes beside inputs and those of a law: the points' values at the
  step's start and the deviations there, the physics' own states and parameters, and the first of two stages.
*/
#include "stepmap/point_work.h"

typedef enum {
  MPM_RATE_VALUE,
  MPM_RATE_OWN,
  MPM_RATE_DEVIATION,
  MPM_RATE_FIRST_F,
  MPM_RATE_FIRST_VALUE,
  MPM_RATE_FIRST_DEVIATION,
  MPM_RATE_NUMBERS
} MpmRateNumber;

/* How many a point has of a kind, 0: none; of all kinds; and values of the physics' parameters. */
PetscInt MpmRateSize(const MpmStepMap *map, MpmRateNumber kind);
PetscInt MpmRateSizes(const MpmStepMap *map);
PetscInt MpmPhysicsValues(const MpmStepMap *map);
/* Where a direction of the kernel has them. */
const double **MpmRateMember(MpmKernelDirection *direction, MpmRateNumber kind);
/* Those of all points in a direction of the state and the stage; or in bars. */
PetscReal *MpmRateArray(const MpmPointVector *start, const MpmStageNumbers *stage, MpmRateNumber kind);
/* True where a parameter is one of the physics' of a material. */
PetscBool MpmPhysicsHasParameter(const MpmSceneParameter *parameter, PetscInt material);
/* The derivative of one of the physics' values of a material by such a parameter. */
PetscReal MpmPhysicsSlope(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscInt material, PetscInt value);
/* The change of its values with that parameter, each in a row of MPM_PACK numbers; the others stay. */
void MpmPhysicsDirection(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscInt material, double rows[]);
