#pragma once
/*
  Element blocks, B^T D B of a point: products of its basis functions with the derivatives D of the kernel's fluxes by
  its inputs, inlined into loops over points.
*/
#include "space/point_loop.h"

/* to (+)= sum_k factor_k row_k; the compiler must not unroll loops that it can vectorise */
MPM_INLINE void MpmRowSum(PetscInt length, PetscInt count, const PetscReal factor[], const PetscReal *const row[],
                          PetscBool add, PetscReal *restrict to)
{
  if (count == 2) {
    const PetscReal *restrict a = row[0], *restrict b = row[1];

#pragma GCC unroll 1
    for (PetscInt m = 0; m < length; m++) to[m] = (add ? to[m] : 0.) + factor[0] * a[m] + factor[1] * b[m];
  } else if (count == 3) {
    const PetscReal *restrict a = row[0], *restrict b = row[1], *restrict c = row[2];

#pragma GCC unroll 1
    for (PetscInt m = 0; m < length; m++)
      to[m] = (add ? to[m] : 0.) + factor[0] * a[m] + factor[1] * b[m] + factor[2] * c[m];
  } else if (count == 4) {
    const PetscReal *restrict a = row[0], *restrict b = row[1], *restrict c = row[2], *restrict d = row[3];

#pragma GCC unroll 1
    for (PetscInt m = 0; m < length; m++)
      to[m] = (add ? to[m] : 0.) + factor[0] * a[m] + factor[1] * b[m] + factor[2] * c[m] + factor[3] * d[m];
  } else {
    for (PetscInt m = 0; !add && m < length; m++) to[m] = 0.;
    for (PetscInt k = 0; k < count; k++)
      for (PetscInt m = 0; m < length; m++) to[m] += factor[k] * row[k][m];
  }
}

/* The k-th input by component. */
MPM_INLINE PetscInt MpmInputAt(const MpmKnown known, const MpmLayout *layout, PetscInt k)
{
  return known.solid ? k : layout->input.by_component.input[k];
}

/*
  element[i][c][d][j] += sum_{k in c, l in d} phi_k(i) D_kl phi_l(j)

  The inner sum over l is made once for all i, as rows of all (d, j): loops that long fill the vector registers, where
  loops over the few nodes alone do not.
*/
MPM_INLINE void MpmSumAddBlock(const MpmKnown known, const MpmLayout *layout, const MpmBasis *basis,
                               const PetscReal D[], PetscReal rows[], PetscReal element[])
{
  const PetscInt bs = known.block, N = known.inputs, n = known.n, length = bs * n;

  for (PetscInt k = 0; k < N; k++) {
    for (PetscInt d = 0; d < bs; d++) {
      const PetscInt   l0    = known.solid ? d * known.dim : layout->input.by_component.first[d];
      const PetscInt   count = known.solid ? known.dim : layout->input.by_component.first[d + 1] - l0;
      PetscReal        by[MPM_MAX_INPUTS];
      const PetscReal *phi[MPM_MAX_INPUTS];

      for (PetscInt q = 0; q < count; q++) {
        const PetscInt l = MpmInputAt(known, layout, l0 + q);

        by[q]  = D[k * N + l];
        phi[q] = basis->basis[KnownBasis(known, layout, l)];
      }
      MpmRowSum(n, count, by, phi, PETSC_FALSE, &rows[k * length + d * n]);
    }
  }
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt c = 0; c < bs; c++) {
      const PetscInt   first = known.solid ? c * known.dim : layout->input.by_component.first[c];
      const PetscInt   count = known.solid ? known.dim : layout->input.by_component.first[c + 1] - first;
      PetscReal        phi[MPM_MAX_INPUTS];
      const PetscReal *row[MPM_MAX_INPUTS];

      for (PetscInt k = 0; k < count; k++) {
        const PetscInt input = MpmInputAt(known, layout, first + k);

        phi[k] = basis->basis[KnownBasis(known, layout, input)][i];
        row[k] = &rows[input * length];
      }
      MpmRowSum(length, count, phi, row, PETSC_TRUE, &element[(i * bs + c) * length]);
    }
  }
}

/*
  MpmSumAddBlock() for Biot's fields, without the products that are zero (MPM_PHYSICS_BIOT). p and its gradient are the
  inputs P to P + dim.
*/
MPM_INLINE void MpmSumAddBlockBiot(const MpmKnown known, const MpmBasis *basis, const PetscReal D[], PetscReal rows[],
                                   PetscReal element[])
{
  const PetscInt          dim = known.dim, n = known.n, N = dim * dim + dim + 2, P = dim * dim, DEVIATION = N - 1;
  const PetscInt          by_u = dim * n, length = by_u + n;
  const PetscReal        *phi = basis->basis[0], *deviation = basis->basis[MPM_DEVIATION(dim)];
  const PetscReal *const *gradient = (const PetscReal *const *)&basis->basis[1];
  PetscReal              *by_p = &rows[(P + 1 + dim) * by_u], *flow = by_p + by_u;

  for (PetscInt k = 0; k < P + 1 + dim; k++)
    for (PetscInt d = 0; d < dim; d++)
      MpmRowSum(n, dim, &D[k * N + d * dim], gradient, PETSC_FALSE, &rows[k * by_u + d * n]);
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal column[MPM_MAX_DIM];

    for (PetscInt b = 0; b < dim; b++) column[b] = D[(a * dim + b) * N + P];
    MpmRowSum(n, dim, column, gradient, PETSC_FALSE, &by_p[a * n]);
    MpmRowSum(n, dim, &D[(P + 1 + a) * N + P + 1], gradient, PETSC_FALSE, &flow[a * n]);
  }
  for (PetscInt i = 0; i < n; i++) {
    PetscReal       *to = &element[i * (dim + 1) * length], g[MPM_MAX_DIM + 1], p[2];
    const PetscReal *row[MPM_MAX_DIM + 1];

    for (PetscInt b = 0; b < dim; b++) g[b] = gradient[b][i];
    for (PetscInt a = 0; a < dim; a++, to += length) {
      PetscReal *restrict of_p = to + by_u;
      const PetscReal factor   = by_p[a * n + i];

      for (PetscInt b = 0; b < dim; b++) row[b] = &rows[(a * dim + b) * by_u];
      MpmRowSum(by_u, dim, g, row, PETSC_TRUE, to);
#pragma GCC unroll 1
      for (PetscInt m = 0; m < n; m++) of_p[m] += factor * phi[m];
    }
    for (PetscInt b = 0; b <= dim; b++) row[b] = &rows[(P + (b + 1) % (dim + 1)) * by_u];
    g[dim] = phi[i];
    MpmRowSum(by_u, dim + 1, g, row, PETSC_TRUE, to);
    for (PetscInt b = 0; b < dim; b++) row[b] = &flow[b * n];
    MpmRowSum(n, dim, g, row, PETSC_TRUE, to + by_u);
    p[0]   = D[P * N + P] * phi[i];
    p[1]   = D[DEVIATION * N + DEVIATION] * deviation[i];
    row[0] = phi;
    row[1] = deviation;
    MpmRowSum(n, 2, p, row, PETSC_TRUE, to + by_u);
  }
}

/* blocks[node][c][d] += sum_{k in c, l in d} phi_k(i) D_kl phi_l(i): diagonal blocks, block^2 values a local node. */
MPM_INLINE void MpmSumAddDiagonal(const MpmKnown known, const MpmLayout *layout, const MpmBasis *basis,
                                  const PetscReal D[], const PetscInt nodes[], PetscReal blocks[])
{
  const PetscInt N = known.inputs, bs = known.block;

  for (PetscInt i = 0; i < known.n; i++) {
    PetscReal *block = &blocks[nodes[i] * bs * bs];

    for (PetscInt k = 0; k < N; k++) {
      const PetscReal phi = basis->basis[KnownBasis(known, layout, k)][i];
      PetscReal      *row = &block[KnownComponent(known, layout, k) * bs];

      for (PetscInt l = 0; l < N; l++)
        row[KnownComponent(known, layout, l)] += phi * D[k * N + l] * basis->basis[KnownBasis(known, layout, l)][i];
    }
  }
}
