#pragma once
/*
  A point's momentum as the passes between points and nodes carry it.
*/
#include "point/material.h"
#include "particles/point_mass.h"
#include "space/lanes.h"
#include "transfer/transfer.h"

/* C, by which the point's velocity varies */
MPM_INLINE void MpmPointAffine(const MpmKnown known, const MpmSum *sum, const MpmTransfer *transfer, PetscInt p,
                               const PetscReal second[], PetscReal C[])
{
  const PetscInt   dim = known.dim;
  const PetscReal *B   = &sum->points->motion.affine[p * dim * dim];

  for (PetscInt b = 0; b < dim; b++) {
    const PetscReal h2 = PetscSqr(sum->grid->h[b]);
    const PetscReal by = transfer->degree < 2 ? 1. : 1. / PetscMax(second[b], MPM_STENCIL_THIN * h2);

    for (PetscInt a = 0; a < dim; a++) C[a * dim + b] = by * B[a * dim + b];
  }
}

/* A point's momentum, its mass behind it, and the derivatives of it that its affine velocity makes. */
MPM_INLINE void MpmCarryMomentum(const MpmKnown known, const MpmSum *sum, const MpmTransfer *transfer, PetscInt p,
                                 const MpmStencil *at, MpmCarried *of)
{
  const PetscInt  dim  = known.dim;
  const PetscReal mass = MpmPointMass(sum->points, sum->materials, p);
  PetscReal       C[MPM_MAX_DIM * MPM_MAX_DIM];

  of->momentum      = MpmSlimLoad(dim, &sum->points->motion.velocity[p * dim]) * mass;
  of->momentum[dim] = mass;
  for (PetscInt b = 0; b < dim; b++) of->slope[b] = (Slim){0.};
  if (transfer->type != MPM_TRANSFER_APIC) return;
  MpmPointAffine(known, sum, transfer, p, at->second, C);
  for (PetscInt b = 0; b < dim; b++)
    for (PetscInt c = 0; c < dim; c++) of->slope[b][c] = mass * C[c * dim + b];
}

/* The stencil of the point at place s of the order, which is returned; prefetches the data of those ahead of it. */
MPM_INLINE PetscInt MpmStencilNext(const MpmKnown known, const MpmSum *sum, const MpmTransfer *transfer,
                                   const PetscInt first[], PetscInt s, MpmStencil *at)
{
  const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s), dim = known.dim;

  MpmSpaceFetch(known, sum->space, ahead);
  MpmFetch(sum->points->x, ahead, dim);
  MpmFetch(sum->points->motion.velocity, ahead, dim);
  if (transfer->type == MPM_TRANSFER_APIC) MpmFetch(sum->points->motion.affine, ahead, dim * dim);
  MpmStencilPlace(known, sum, first, p, at);
  return p;
}
