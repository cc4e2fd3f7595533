/*
  Poses of rigid bodies: rotation and displacement, and places carried along.
*/
#include "geometry/pose.h"

#include <math.h>

/* R = I + sin(t)/t K + (1 - cos t)/t^2 K^2, with K v = vector x v and t = |vector| (Rodrigues). */
void MpmPoseSetRotation(MpmPose *pose, const PetscReal pivot[MPM_MAX_DIM], const PetscReal vector[MPM_MAX_DIM])
{
  const PetscReal angle = hypot(hypot(vector[0], vector[1]), vector[2]), half = 0.5 * angle;
  const PetscReal K[3][3] = {{0., -vector[2], vector[1]}, {vector[2], 0., -vector[0]}, {-vector[1], vector[0], 0.}};

  pose->turned = (PetscBool)(angle > 0.);
  if (!pose->turned) return;
  const PetscReal once = PetscSinReal(angle) / angle, twice = 0.5 * PetscSqr(PetscSinReal(half) / half);

  for (PetscInt a = 0; a < 3; a++) {
    pose->pivot[a] = pivot[a];
    for (PetscInt b = 0; b < 3; b++) {
      PetscReal square = 0.;

      for (PetscInt c = 0; c < 3; c++) square += K[a][c] * K[c][b];
      pose->rotation[a][b] = (a == b ? 1. : 0.) + once * K[a][b] + twice * square;
    }
  }
}

void MpmPoseTurn(PetscInt dim, const MpmPose *before, const MpmPose *after, const PetscReal v[], PetscReal w[])
{
  PetscReal fixed[MPM_MAX_DIM] = {0., 0., 0.};

  for (PetscInt a = 0; a < dim; a++) fixed[a] = v[a];
  for (PetscInt a = 0; before->turned && a < dim; a++) {
    fixed[a] = 0.;
    for (PetscInt b = 0; b < dim; b++) fixed[a] += before->rotation[b][a] * v[b];
  }
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal turned = after->turned ? 0. : fixed[a];

    for (PetscInt b = 0; after->turned && b < dim; b++) turned += after->rotation[a][b] * fixed[b];
    w[a] = turned;
  }
}

void MpmPoseCarry(PetscInt dim, const MpmPose *before, const MpmPose *after, const PetscReal x[], PetscReal y[])
{
  const PetscReal *pivot            = after->turned ? after->pivot : before->pivot;
  PetscReal        arm[MPM_MAX_DIM] = {0., 0., 0.};

  if (!before->turned && !after->turned) {
    for (PetscInt a = 0; a < dim; a++) y[a] = x[a] + (after->translation[a] - before->translation[a]);
    return;
  }
  for (PetscInt a = 0; a < dim; a++) arm[a] = x[a] - before->translation[a] - pivot[a];
  MpmPoseTurn(dim, before, after, arm, arm);
  for (PetscInt a = 0; a < dim; a++) y[a] = pivot[a] + arm[a] + after->translation[a];
}
