#pragma once
/*
  The inner loops between points and nodes that carry mass and momentum: places of a point's nodes, and its affine
  velocity.
*/
#include "grid/grid.h"
#include "space/point_loop.h"
#include "transfer/transfer.h"

/* A vector of the processor; a pointer to numbers may be taken for one to vectors. */
#define SLIM 4
typedef PetscReal Slim __attribute__((vector_size(SLIM * sizeof(PetscReal)), aligned(sizeof(PetscReal)), may_alias));

/* A second moment below this part of a cell's square is no base for a quotient: points on an edge of the grid. */
#define MPM_STENCIL_THIN 1e-2

/* Where the nodes of a point's group stand from it along each axis. */
typedef struct {
  PetscReal away[MPM_MAX_DIM][MPM_MAX_WIDTH]; /* m */
  PetscReal second[MPM_MAX_DIM];              /* D_b, m2 */
  PetscReal line[MPM_MAX_DIM]
                [MPM_MAX_WIDTH]; /* factors along an axis in place of the weights, for the affine velocity */
  PetscBool thin;                /* a gradient among them: a point on an edge of the grid */
} MpmStencil;

/* Where the nodes of the group stand from the point, and the second moments of its weights. */
MPM_INLINE void MpmStencilPlace(const MpmKnown known, const MpmSum *sum, const PetscInt first[], PetscInt p,
                                MpmStencil *at)
{
  const MpmGrid   *grid = sum->grid;
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *w = &sum->space->shape[0].weight[p * dim * W], *x = &sum->points->x[p * dim];

  at->thin = PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal start = grid->lower[a] + grid->h[a] * (PetscReal)first[a] - x[a];

    at->second[a] = 0.;
    for (PetscInt k = 0; k < known.count[a]; k++) {
      at->away[a][k] = start + grid->h[a] * (PetscReal)k;
      at->second[a] += w[a * W + k] * at->away[a][k] * at->away[a][k];
    }
  }
}

/* C, by which the point's velocity varies */
MPM_INLINE void MpmStencilAffine(const MpmKnown known, const MpmSum *sum, const MpmTransfer *transfer, PetscInt p,
                                 const PetscReal second[], PetscReal C[])
{
  const PetscInt   dim = known.dim;
  const PetscReal *B   = &sum->points->affine[p * dim * dim];

  for (PetscInt b = 0; b < dim; b++) {
    const PetscReal h2 = PetscSqr(sum->grid->h[b]);
    const PetscReal by = transfer->degree < 2 ? 1. : 1. / PetscMax(second[b], MPM_STENCIL_THIN * h2);

    for (PetscInt a = 0; a < dim; a++) C[a * dim + b] = by * B[a * dim + b];
  }
}

/* Factors along each axis beside the weights in a pass over the nodes: a point's affine velocity. */
MPM_INLINE void MpmStencilLines(const MpmKnown known, const MpmSum *sum, PetscInt p, PetscInt degree, MpmStencil *at)
{
  const PetscInt dim = known.dim, W = sum->space->width;

  for (PetscInt b = 0; b < dim; b++) {
    const PetscReal *w    = &sum->space->shape[0].weight[(p * dim + b) * W];
    const PetscReal *g    = &sum->space->shape[0].gradient[(p * dim + b) * W];
    const PetscBool  thin = (PetscBool)(degree < 2 && at->second[b] < MPM_STENCIL_THIN * PetscSqr(sum->grid->h[b]));
    const PetscReal  by   = degree < 2 && !thin ? 1. / at->second[b] : 1.;

    if (thin) at->thin = PETSC_TRUE;
    for (PetscInt k = 0; k < known.count[b]; k++) at->line[b][k] = thin ? g[k] : by * w[k] * at->away[b][k];
  }
}
