#pragma once
/*
  Passes between points and nodes in vectors of the processor: the numbers of a node stand side by side in one, since a
  point touches few nodes on an axis, and there are as many numbers. Inlined into the loops of transfer/.
*/
#include "grid/grid.h"
#include "space/point_loop.h"

/* No vector crosses a call: all functions here are inlined. Without AVX gcc warns of its place in one. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

/* A vector of the processor; a pointer to numbers may be taken for one to vectors. */
#define SLIM 4
typedef PetscReal Slim __attribute__((vector_size(SLIM * sizeof(PetscReal)), aligned(sizeof(PetscReal)), may_alias));

/* A second moment below this part of a cell's square is no base for a quotient: points on an edge of the grid. */
#define MPM_STENCIL_THIN 1e-2

MPM_INLINE Slim MpmSlimLoad(PetscInt dim, const PetscReal v[])
{
  return (Slim){v[0], v[1], dim == MPM_MAX_DIM ? v[2] : 0., 0.};
}

/* Where the nodes of a point's group stand from it along each axis. */
typedef struct {
  PetscReal away[MPM_MAX_DIM][MPM_MAX_WIDTH]; /* m */
  PetscReal second[MPM_MAX_DIM];              /* D_b, second moment of the weights, m2 */
  PetscReal line[MPM_MAX_DIM]
                [MPM_MAX_WIDTH]; /* factors along an axis in place of the weights, for the affine velocity */
  PetscBool thin;                /* a gradient among them: a point on an edge of the grid */
} MpmStencil;

/* Where the nodes of the group, vertices of cells, stand from the point, and the second moments of its weights. */
MPM_INLINE void MpmStencilPlace(const MpmKnown known, const MpmSum *sum, const PetscInt first[], PetscInt p,
                                MpmStencil *at)
{
  const MpmGrid   *grid = sum->grid;
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *w = &sum->space->shapes.at[0].weight[p * dim * W], *x = &sum->points->x[p * dim];

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

/* Factors along each axis beside the weights in a pass over the nodes: a point's affine velocity. */
MPM_INLINE void MpmStencilLines(const MpmKnown known, const MpmSum *sum, PetscInt p, PetscInt degree, MpmStencil *at)
{
  const PetscInt dim = known.dim, W = sum->space->width;

  for (PetscInt b = 0; b < dim; b++) {
    const PetscReal *w    = &sum->space->shapes.at[0].weight[(p * dim + b) * W];
    const PetscReal *g    = &sum->space->shapes.at[0].gradient[(p * dim + b) * W];
    const PetscBool  thin = (PetscBool)(degree < 2 && at->second[b] < MPM_STENCIL_THIN * PetscSqr(sum->grid->h[b]));
    const PetscReal  by   = degree < 2 && !thin ? 1. / at->second[b] : 1.;

    if (thin) at->thin = PETSC_TRUE;
    for (PetscInt k = 0; k < known.count[b]; k++) at->line[b][k] = thin ? g[k] : by * w[k] * at->away[b][k];
  }
}

/* One point's contributions to its nodes: a quantity, momentum with the mass behind it, and its derivatives; and the
   stress of its force, with axial symmetry the share by the weights. */
typedef struct {
  Slim momentum, slope[MPM_MAX_DIM], P[MPM_MAX_DIM], hoop;
} MpmCarried;

/* Sums at a node: momentum, and mass behind it; and force. */
typedef struct {
  Slim moving, force;
} MpmCarriedSums;

/* A point's weights along x and their products with the distance to the nodes, used by every row of nodes. */
typedef struct {
  PetscReal weight[MPM_MAX_WIDTH], gradient[MPM_MAX_WIDTH], moment[MPM_MAX_WIDTH];
} MpmWeightRow;

/* sums_i += w_i (m + m' (x_i - x_p)) of one point */
MPM_INLINE void MpmCarriedAdd(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmStencil *at,
                              const MpmCarried *of, const PetscInt nodes[], Slim *restrict sums)
{
  const PetscInt dim = known.dim;
  const MpmLines w   = MpmPointLines(dim, sum->space, sum->space->shapes.at[0].weight, p, &MpmLineOne);
  MpmWeightRow   line;

  for (PetscInt k = 0; k < known.count[0]; k++) {
    line.weight[k] = w.along[0][k];
    line.moment[k] = w.along[0][k] * at->away[0][k];
  }
  for (PetscInt l = 0; l < known.count[2]; l++) {
    for (PetscInt j = 0; j < known.count[1]; j++) {
      const PetscReal by      = w.along[1][j] * w.along[2][l];
      const Slim      by_away = of->slope[0] * by;
      Slim            row     = of->momentum + of->slope[1] * at->away[1][j];

      if (dim == MPM_MAX_DIM) row += of->slope[2] * at->away[2][l];
      row *= by;
      for (PetscInt k = 0; k < known.count[0]; k++) sums[*nodes++] += row * line.weight[k] + by_away * line.moment[k];
    }
  }
}

/* MpmCarriedAdd(), and the force -P grad w_i */
MPM_INLINE void MpmCarriedAddForce(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmStencil *at,
                                   const MpmCarried *of, const PetscInt nodes[], MpmCarriedSums *restrict sums)
{
  const PetscInt dim = known.dim;
  const MpmLines w   = MpmPointLines(dim, sum->space, sum->space->shapes.at[0].weight, p, &MpmLineOne);
  const MpmLines g   = MpmPointLines(dim, sum->space, sum->space->shapes.at[0].gradient, p, &MpmLineZero);
  MpmWeightRow   line;

  for (PetscInt k = 0; k < known.count[0]; k++) {
    line.weight[k]   = w.along[0][k];
    line.gradient[k] = g.along[0][k];
    line.moment[k]   = w.along[0][k] * at->away[0][k];
  }
  for (PetscInt l = 0; l < known.count[2]; l++) {
    for (PetscInt j = 0; j < known.count[1]; j++) {
      const PetscReal by = w.along[1][j] * w.along[2][l], gy = g.along[1][j] * w.along[2][l];
      Slim            row = of->momentum + of->slope[1] * at->away[1][j], across = of->P[1] * gy;
      const Slim      along = of->P[0] * by, by_away = of->slope[0] * by;

      if (dim == MPM_MAX_DIM) row += of->slope[2] * at->away[2][l];
      if (dim == MPM_MAX_DIM) across += of->P[2] * (w.along[1][j] * g.along[2][l]);
      if (!known.solid) across += of->hoop * by;
      row *= by;
      for (PetscInt k = 0; k < known.count[0]; k++) {
        MpmCarriedSums *to = &sums[*nodes++];

        to->moving += row * line.weight[k] + by_away * line.moment[k];
        to->force -= across * line.weight[k] + along * line.gradient[k];
      }
    }
  }
}

/* sums_i += w_i value at the nodes of one point */
MPM_INLINE void MpmSlimAdd(const MpmKnown known, const MpmSum *sum, PetscInt p, const Slim value,
                           const PetscInt nodes[], Slim *restrict sums)
{
  const MpmLines w = MpmPointLines(known.dim, sum->space, sum->space->shapes.at[0].weight, p, &MpmLineOne);

  for (PetscInt l = 0; l < known.count[2]; l++) {
    for (PetscInt j = 0; j < known.count[1]; j++, nodes += known.count[0]) {
      const Slim row = value * (w.along[1][j] * w.along[2][l]);

      for (PetscInt k = 0; k < known.count[0]; k++) sums[nodes[k]] += row * w.along[0][k];
    }
  }
}

/* A field at a point, and its moments along the axes where `by` is not NULL. */
MPM_INLINE Slim MpmSlimInterpolate(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmStencil *at,
                                   const PetscInt nodes[], const Slim values[], Slim *by)
{
  const MpmLines w     = MpmPointLines(known.dim, sum->space, sum->space->shapes.at[0].weight, p, &MpmLineOne);
  Slim           total = {0.}, x = {0.}, y = {0.}, z = {0.};

  for (PetscInt l = 0; l < known.count[2]; l++) {
    Slim sheet = {0.}, along = {0.}, across = {0.};

    for (PetscInt j = 0; j < known.count[1]; j++, nodes += known.count[0]) {
      Slim row = values[nodes[0]] * w.along[0][0], moment = {0.};

      for (PetscInt k = 1; k < known.count[0]; k++) row += values[nodes[k]] * w.along[0][k];
      for (PetscInt k = 0; by && k < known.count[0]; k++) moment += values[nodes[k]] * at->line[0][k];
      sheet += row * w.along[1][j];
      if (!by) continue;
      along += moment * w.along[1][j];
      across += row * at->line[1][j];
    }
    total += sheet * w.along[2][l];
    x += along * w.along[2][l];
    y += across * w.along[2][l];
    if (by && known.dim == MPM_MAX_DIM) z += sheet * at->line[2][l];
  }
  if (by) {
    by[0] = x;
    by[1] = y;
    by[2] = z;
  }
  return total;
}
