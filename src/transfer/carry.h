#pragma once
/*
  The inner loops of the passes that carry momentum between points and nodes.

  The numbers of a node stand side by side in vectors of the processor: a point touches few nodes on an axis, and there
  are as many numbers.
*/
#include "point/material.h"
#include "particles/point_mass.h"
#include "transfer/stencil.h"

MPM_INLINE Slim MpmSlimLoad(PetscInt dim, const PetscReal v[])
{
  return dim == 2 ? (Slim){v[0], v[1], 0., 0.} : (Slim){v[0], v[1], v[2], 0.};
}

/* One point's contributions to its nodes: momentum, then mass, their derivatives, and the stress of its force; `hoop`:
   the share by the weights, with axial symmetry. */
typedef struct {
  Slim momentum, slope[MPM_MAX_DIM], P[MPM_MAX_DIM], hoop;
} MpmCarried;

/* A point's weights along x and their products with the distance to the nodes, used by every row of nodes. */
typedef struct {
  PetscReal weight[MPM_MAX_WIDTH], gradient[MPM_MAX_WIDTH], moment[MPM_MAX_WIDTH];
} MpmWeightRow;

/* A point's momentum, its mass behind it, and the derivatives of it that its affine velocity makes. */
MPM_INLINE void MpmCarryMomentum(const MpmKnown known, const MpmSum *sum, const MpmTransfer *transfer, PetscInt p,
                                 const MpmStencil *at, MpmCarried *of)
{
  const PetscInt  dim  = known.dim;
  const PetscReal mass = MpmPointMass(sum->points, sum->materials, p), *v = &sum->points->velocity[p * dim];
  PetscReal       C[MPM_MAX_DIM * MPM_MAX_DIM];

  of->momentum =
    dim == 2 ? (Slim){mass * v[0], mass * v[1], mass, 0.} : (Slim){mass * v[0], mass * v[1], mass * v[2], mass};
  if (transfer->type != MPM_TRANSFER_APIC) {
    for (PetscInt b = 0; b < dim; b++) of->slope[b] = (Slim){0.};
    return;
  }
  MpmStencilAffine(known, sum, transfer, p, at->second, C);
  for (PetscInt b = 0; b < dim; b++)
    of->slope[b] = dim == 2 ? (Slim){mass * C[b], mass * C[dim + b], 0., 0.}
                            : (Slim){mass * C[b], mass * C[dim + b], mass * C[2 * dim + b], 0.};
}

/* The stencil of the point at place s of the order, which is returned; prefetches the data of those ahead of it. */
MPM_INLINE PetscInt MpmStencilNext(const MpmKnown known, const MpmSum *sum, const MpmTransfer *transfer,
                                   const PetscInt first[], PetscInt s, MpmStencil *at)
{
  const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s), dim = known.dim;

  MpmFetch(sum->space->shape[0].weight, ahead, dim * sum->space->width);
  MpmFetch(sum->points->x, ahead, dim);
  MpmFetch(sum->points->velocity, ahead, dim);
  if (transfer->type == MPM_TRANSFER_APIC) MpmFetch(sum->points->affine, ahead, dim * dim);
  MpmStencilPlace(known, sum, first, p, at);
  return p;
}

/* The points' momentum alone, as AddPoint() has it. */
MPM_INLINE void MpmCarriedAdd(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmStencil *at,
                              const MpmCarried *of, const PetscInt nodes[], Slim *restrict sums)
{
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *wx = &sum->space->shape[0].weight[p * dim * W];
  MpmWeightRow     line;

  for (PetscInt k = 0; k < known.count[0]; k++) {
    line.weight[k] = wx[k];
    line.moment[k] = wx[k] * at->away[0][k];
  }

  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    for (PetscInt j = 0; j < known.count[1]; j++) {
      const PetscReal w       = dim == 2 ? wx[W + j] : wx[W + j] * wx[2 * W + l];
      const Slim      by_away = of->slope[0] * w;
      Slim            row     = of->momentum + of->slope[1] * at->away[1][j];

      if (dim == 3) row += of->slope[2] * at->away[2][l];
      row *= w;
      for (PetscInt k = 0; k < known.count[0]; k++) sums[*nodes++] += row * line.weight[k] + by_away * line.moment[k];
    }
  }
}

/* sums_i += w_i value at the nodes of one point */
MPM_INLINE void MpmSlimAdd(const MpmKnown known, const MpmSum *sum, PetscInt p, const Slim value,
                           const PetscInt nodes[], Slim *restrict sums)
{
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *wx = &sum->space->shape[0].weight[p * dim * W];

  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    for (PetscInt j = 0; j < known.count[1]; j++, nodes += known.count[0]) {
      const Slim row = value * (dim == 2 ? wx[W + j] : wx[W + j] * wx[2 * W + l]);

      for (PetscInt k = 0; k < known.count[0]; k++) sums[nodes[k]] += row * wx[k];
    }
  }
}

/* A field at a point, and its moments along the axes where `by` is not NULL. */
MPM_INLINE Slim MpmSlimInterpolate(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmStencil *at,
                                   const PetscInt nodes[], const Slim values[], Slim *by)
{
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *wx    = &sum->space->shape[0].weight[p * dim * W];
  Slim             total = {0.}, x = {0.}, y = {0.}, z = {0.};

  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    Slim sheet = {0.}, along = {0.}, across = {0.};

    for (PetscInt j = 0; j < known.count[1]; j++, nodes += known.count[0]) {
      Slim row = values[nodes[0]] * wx[0], moment = {0.};

      for (PetscInt k = 1; k < known.count[0]; k++) row += values[nodes[k]] * wx[k];
      for (PetscInt k = 0; by && k < known.count[0]; k++) moment += values[nodes[k]] * at->line[0][k];
      sheet += row * wx[W + j];
      if (!by) continue;
      along += moment * wx[W + j];
      across += row * at->line[1][j];
    }
    if (dim == 2) {
      total = sheet;
      x     = along;
      y     = across;
    } else {
      total += sheet * wx[2 * W + l];
      x += along * wx[2 * W + l];
      y += across * wx[2 * W + l];
      if (by) z += sheet * at->line[2][l];
    }
  }
  if (by) {
    by[0] = x;
    by[1] = y;
    by[2] = z;
  }
  return total;
}
