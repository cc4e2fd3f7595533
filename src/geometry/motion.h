#pragma once
/*
  Prescribed motion of a rigid thing: displacement and rotation in total, times a ramp, or a table of them by time.

  Order of calls: MpmMotionRead(), MpmMotionPose(), MpmMotionDestroy().
*/
#include "base/types.h"
#include "geometry/pose.h"

typedef struct {
  PetscReal  translation[MPM_MAX_DIM], rotation[MPM_MAX_DIM]; /* m, radians; times ramp */
  PetscReal  pivot[MPM_MAX_DIM], growth;                      /* growth: of a radius, m, times ramp */
  MpmRamp    ramp;
  PetscBool  given; /* the ramp, by the scene */
  PetscReal  delay; /* of the ramp, s */
  PetscInt   rows;  /* of the table; 0 without one */
  PetscReal *time, *value;
} MpmMotion;

/*
  Reads -<prefix>motion, rotation, pivot, ramp and motion_table. Collective. On entry `pivot` holds its default and
  `growth` the owner's option.
*/
PetscErrorCode MpmMotionRead(const MpmOptions *block, PetscInt dim, MpmMotion *motion);
/* True where it moves at any time. */
PetscBool      MpmMotionMoves(const MpmMotion *motion);
MpmPose        MpmMotionPose(const MpmMotion *motion, PetscReal time);
PetscErrorCode MpmMotionDestroy(MpmMotion *motion);
