/*
  Affine velocities of fluids at a step's end. C = sum_i v_i (x) grad w_i is a derivative by the place at the step's
  start; by that at its end it is

    C <- C dF^-1 ,

  never larger than before. Material that is drawn out moves on with the velocities that it has, so that its velocity
  changes less on a length, 1/(1 + C t) C without forces. With C kept, the ends of a domain of length l would move apart
  with 2 C l, faster and faster as it grows, and in splashes the flow would gain energy. Where material is compressed
  the derivative grows, but not the part of the weights' second moment that is the cell's: there C gains nothing.

  Rotations and simple shear go on unchanged, to the second order of the step.
*/
#include "point/material.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "transfer/motion.h"
#include "transfer/transfer.h"

/* dF^-1 = F_n F_{n+1}^-1 of point p */
static void InverseIncrement(PetscInt dim, const PetscReal F_n[], const PetscReal F[], PetscReal inverse[])
{
  PetscReal       cofactor[MPM_MAX_DIM * MPM_MAX_DIM];
  const PetscReal det = MpmCofactors(dim * dim, F, cofactor);

  for (PetscInt i = 0; i < dim; i++) {
    for (PetscInt j = 0; j < dim; j++) {
      inverse[i * dim + j] = 0.;
      for (PetscInt k = 0; k < dim; k++) inverse[i * dim + j] += F_n[i * dim + k] * cofactor[j * dim + k] / det;
    }
  }
}

/* C <- C dF^-1, its size at most what it was; `scale`: of each column of the point's numbers over that of C */
static void Convect(PetscInt dim, const PetscReal inverse[], const PetscReal scale[], PetscReal affine[])
{
  PetscReal C[MPM_MAX_DIM * MPM_MAX_DIM], before = 0., after = 0., by;

  for (PetscInt i = 0; i < dim; i++) {
    for (PetscInt j = 0; j < dim; j++) {
      PetscReal sum = 0.;

      for (PetscInt k = 0; k < dim; k++) sum += affine[i * dim + k] / scale[k] * inverse[k * dim + j];
      C[i * dim + j] = sum;
      before += PetscSqr(affine[i * dim + j] / scale[j]);
      after += sum * sum;
    }
  }
  by = after > before ? PetscSqrtReal(before / after) : 1.;
  for (PetscInt k = 0; k < dim * dim; k++) affine[k] = by * scale[k % dim] * C[k];
}

void MpmMotionConvect(const MpmSum *sum, const MpmTransfer *transfer, const MpmTrial *trial)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = sum->space->dim;
  PetscReal        inverse[MPM_MAX_DIM * MPM_MAX_DIM], scale[MPM_MAX_DIM];

  if (transfer->type != MPM_TRANSFER_APIC) return;
  for (PetscInt a = 0; a < dim; a++) scale[a] = transfer->degree < 2 ? 1. : PetscSqr(sum->grid->h[a]);
  for (PetscInt p = 0; p < points->count; p++) {
    if (!(sum->materials[points->material[p]].info.traits & MPM_LAW_VISCOUS)) continue;
    InverseIncrement(dim, MpmPointF(points, p), &trial->F[p * points->F_size], inverse);
    Convect(dim, inverse, scale, &points->motion.affine[p * dim * dim]);
  }
}
