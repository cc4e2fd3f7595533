#pragma once
/*
  Where a rigid thing stands that has moved from its place: first turned about its pivot, then displaced,

    x = pivot + R (X - pivot) + translation .

  All zeros: at rest. One that has not turned needs neither R nor pivot, and is never multiplied by an identity.
*/
#include "base/base.h"

typedef struct {
  PetscReal translation[MPM_MAX_DIM], growth; /* m; growth: of a radius */
  PetscBool turned;
  PetscReal rotation[MPM_MAX_DIM][MPM_MAX_DIM], pivot[MPM_MAX_DIM]; /* where turned */
} MpmPose;

/* Turns a pose by a rotation vector (its length the angle in radians) about the pivot; 0 for no turn. */
void MpmPoseSetRotation(MpmPose *pose, const PetscReal pivot[MPM_MAX_DIM], const PetscReal vector[MPM_MAX_DIM]);
/* Place at `after` of a place x fixed to a body that stands at `before`. Growth carries nothing along. */
void MpmPoseCarry(PetscInt dim, const MpmPose *before, const MpmPose *after, const PetscReal x[], PetscReal y[]);
/* Vector at `after` of a vector v fixed to the body at `before`: w = R_after R_before^T v; w may be v. */
void MpmPoseTurn(PetscInt dim, const MpmPose *before, const MpmPose *after, const PetscReal v[], PetscReal w[]);
