/*
  The Jacobian, point by point: the kernel on duals that are seeded with the point's inputs gives the point's D, and the
  element block of a group is the sum of B^T D B over its points. Where the physics has a mean, each cell adds the
  products of a few vectors over all of its nodes.
*/
#include "sum.h"

/* to = sum_k factor_k row_k, added to what is there or in its place; the compiler must not unroll what it can vectorise */
MPM_INLINE void RowSum(PetscInt length, PetscInt count, const PetscReal factor[], const PetscReal *const row[],
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
  } else {
    for (PetscInt m = 0; !add && m < length; m++) to[m] = 0.;
    for (PetscInt k = 0; k < count; k++)
      for (PetscInt m = 0; m < length; m++) to[m] += factor[k] * row[k][m];
  }
}

/*
  element[i][c][d][j] += sum_{k in c, l in d} phi_k(i) D_kl phi_l(j)

  The inner sum over l is made once for all i, as rows of all (d, j): loops that long fill the vector registers, where
  loops over the few nodes alone do not.
*/
MPM_INLINE void AddElement(const MpmKnown known, const MpmLayout *layout, const MpmBasis *basis, const PetscReal D[],
                           PetscReal rows[], PetscReal element[])
{
  const PetscInt bs = known.block, N = known.inputs, n = known.n, length = bs * n;

  for (PetscInt k = 0; k < N; k++) {
    for (PetscInt d = 0; d < bs; d++) {
      const PetscInt l0    = known.solid ? d * known.dim : layout->component_first[d];
      const PetscInt count = known.solid ? known.dim : layout->component_first[d + 1] - l0;

      RowSum(n, count, &D[k * N + l0], (const PetscReal *const *)&basis->basis[KnownBasis(known, layout, l0)],
             PETSC_FALSE, &rows[k * length + d * n]);
    }
  }
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt c = 0; c < bs; c++) {
      const PetscInt   first = known.solid ? c * known.dim : layout->component_first[c];
      const PetscInt   count = known.solid ? known.dim : layout->component_first[c + 1] - first;
      PetscReal        phi[MPM_MAX_INPUTS];
      const PetscReal *row[MPM_MAX_INPUTS];

      for (PetscInt k = 0; k < count; k++) {
        phi[k] = basis->basis[KnownBasis(known, layout, first + k)][i];
        row[k] = &rows[(first + k) * length];
      }
      RowSum(length, count, phi, row, PETSC_TRUE, &element[(i * bs + c) * length]);
    }
  }
}

/*
  What ties the nodes of a cell together through its mean, one value for each unknown of the cell's box, [c][i]:

    K_cell += flux_by_mean mean_by_u^T + mean_by_u mean_flux_by_u^T + second mean_by_u mean_by_u^T
*/
typedef struct {
  PetscReal *flux_by_mean, *mean_flux_by_u, *mean_by_u, second;
  PetscReal *element, *storage;
} Coupling;

static PetscErrorCode CouplingCreate(const MpmSum *sum, Coupling *coupling)
{
  const PetscInt n = PetscPowInt(sum->space->reach + 1, sum->space->dim) * sum->layout->block;

  PetscFunctionBeginUser;
  coupling->storage = NULL;
  if (!sum->layout->means) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((3 * n + n * n), &coupling->storage));
  coupling->flux_by_mean   = coupling->storage;
  coupling->mean_flux_by_u = coupling->flux_by_mean + n;
  coupling->mean_by_u      = coupling->mean_flux_by_u + n;
  coupling->element        = coupling->mean_by_u + n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A new cell begins. */
static void CouplingClear(const MpmSum *sum, const MpmCell *cell, Coupling *coupling)
{
  const PetscInt n = sum->space->groups[cell->box].node_count * sum->layout->block;

  for (PetscInt k = 0; k < n; k++)
    coupling->flux_by_mean[k] = coupling->mean_flux_by_u[k] = coupling->mean_by_u[k] = 0.;
  coupling->second = 0.;
}

/* The place in the cell's box of a group's node k, x fastest. */
static PetscInt PlaceInBox(const MpmGroup *group, const MpmGroup *box, PetscInt k)
{
  const PetscInt i = k % group->count[0], j = k / group->count[0] % group->count[1];
  const PetscInt l = k / (group->count[0] * group->count[1]);

  return ((l + group->first[2] - box->first[2]) * box->count[1] + j + group->first[1] - box->first[1]) * box->count[0] +
         i + group->first[0] - box->first[0];
}

/* One point's part, and its tangent with the mean's row and column taken out. */
static PetscErrorCode CouplingAddPoint(const MpmSum *sum, const MpmGroup *group, PetscInt p,
                                       const MpmKernelPoint *point, const PetscReal input[], const MpmBasis *basis,
                                       PetscReal tangent[], Coupling *coupling)
{
  const MpmLayout *layout = sum->layout;
  const PetscInt   N = layout->inputs, n = group->node_count;
  const MpmGroup  *box = &sum->space->groups[sum->space->cells[group->cell].box];
  PetscReal        m, dm[MPM_MAX_INPUTS];

  if (layout->kernel->mean(point, input, &m, dm)) return PETSC_SUCCESS; /* has failed before */
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt at = PlaceInBox(group, box, i);

    for (PetscInt k = 0; k < N; k++) {
      const PetscReal phi = basis->basis[layout->basis_of[k]][i];
      const PetscInt  to  = layout->component_of[k] * box->node_count + at;

      coupling->flux_by_mean[to] += phi * tangent[k * (N + 1) + N];
      coupling->mean_flux_by_u[to] += phi * tangent[N * (N + 1) + k];
      coupling->mean_by_u[to] += phi * sum->space->share[p] * dm[k];
    }
  }
  coupling->second += tangent[N * (N + 1) + N];
  for (PetscInt k = 1; k < N; k++)
    for (PetscInt l = 0; l < N; l++) tangent[k * N + l] = tangent[k * (N + 1) + l];
  return PETSC_SUCCESS;
}

static PetscReal CouplingEntry(const Coupling *coupling, PetscInt a, PetscInt b)
{
  return coupling->flux_by_mean[a] * coupling->mean_by_u[b] +
         coupling->mean_by_u[a] * (coupling->mean_flux_by_u[b] + coupling->second * coupling->mean_by_u[b]);
}

/* The cell is complete. */
static void CouplingAddToPattern(const MpmSum *sum, const MpmCell *cell, Coupling *coupling, MpmPattern *pattern)
{
  const MpmGroup *box = &sum->space->groups[cell->box];
  const PetscInt  n = box->node_count, bs = sum->layout->block;

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c < bs; c++)
      for (PetscInt d = 0; d < bs; d++)
        for (PetscInt j = 0; j < n; j++)
          coupling->element[((i * bs + c) * bs + d) * n + j] = CouplingEntry(coupling, c * n + i, d * n + j);
  MpmPatternAddBlock(pattern, sum->space, box, sum->constraints, coupling->element);
}

static void CouplingAddToDiagonal(const MpmSum *sum, const MpmCell *cell, const Coupling *coupling, PetscReal blocks[])
{
  const MpmGroup *box = &sum->space->groups[cell->box];
  const PetscInt  n = box->node_count, bs = sum->layout->block;
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; nodes[i] >= 0 && c < bs; c++)
      for (PetscInt d = 0; d < bs; d++)
        blocks[(nodes[i] * bs + c) * bs + d] += CouplingEntry(coupling, c * n + i, d * n + i);
}

/* The tangent of a point, without the mean's part, and its flux; PETSC_FALSE where it has no answer. */
MPM_INLINE PetscBool PointTangent(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, PetscInt p,
                                  PetscBool weights, MpmWorkspace *work, Coupling *coupling, PetscReal flux[],
                                  PetscReal tangent[])
{
  MpmKernelPoint point;
  PetscReal      input[MPM_MAX_INPUTS];

  MpmSumBasis(known, sum->space, p, weights, &work->basis);
  MpmSumInputs(known, sum->layout, work->values, &work->basis, input);
  MpmSumPoint(sum, p, &point);
  MpmSumMean(sum, group, p, &point, input);
  if (sum->layout->kernel->tangent(&point, input, flux, tangent)) return PETSC_FALSE;
  if (sum->layout->means) CouplingAddPoint(sum, group, p, &point, input, &work->basis, tangent, coupling);
  return PETSC_TRUE;
}

/* Where the sums over a group's points go; `residual` is NULL where nobody asks for it. */
typedef struct {
  PetscReal *element, *residual;
  PetscReal *rows; /* room for AddElement */
} Target;

/* The element block of one group, and its forces. */
MPM_INLINE PetscErrorCode ElementGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                       PetscBool weights, const PetscReal u[], MpmWorkspace *work, Coupling *coupling,
                                       const Target *to, PetscInt *failed)
{
  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt k = 0; k < known.n * known.block; k++) work->force[k] = 0.;
  for (PetscInt k = 0; k < known.n * known.n * known.block * known.block; k++) to->element[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    PetscReal flux[MPM_MAX_INPUTS], tangent[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

    MpmSumFetch(known, sum, s);
    if (!PointTangent(known, sum, group, sum->space->order[s], weights, work, coupling, flux, tangent)) {
      (*failed)++;
      continue;
    }
    AddElement(known, sum->layout, &work->basis, tangent, to->rows, to->element);
    if (to->residual) MpmSumAddFlux(known, sum->layout, &work->basis, flux, work->force);
  }
  if (to->residual) MpmSumScatter(known, sum, group, work->force, to->residual);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmJacobianLocal(const MpmSum *sum, const PetscReal u[], MpmPattern *pattern, PetscReal residual[],
                                PetscInt *failed)
{
  const MpmSpace *space   = sum->space;
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);
  const PetscInt  most = PetscPowInt(space->width, space->dim), bs = sum->layout->block;
  Target          to = {.residual = residual};
  MpmWorkspace    work;
  Coupling        coupling;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(MpmMeanEvaluate(sum, u, failed));
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(CouplingCreate(sum, &coupling));
  PetscCall(PetscMalloc2((most * most * bs * bs), &to.element, (most * bs * sum->layout->inputs), &to.rows));
  for (PetscInt unit = 0; unit < MpmUnitCount(sum); unit++) {
    const MpmCell groups = MpmUnitGroups(sum, unit);

    if (coupling.storage) CouplingClear(sum, &groups, &coupling);
    for (PetscInt g = groups.group_begin; g < groups.group_end; g++) {
      const MpmGroup *group = &space->groups[g];

      MPM_DISPATCH(sum->layout, group, ElementGroup, sum, group, weights, u, &work, &coupling, &to, failed);
      MpmPatternAddBlock(pattern, space, group, sum->constraints, to.element);
    }
    if (coupling.storage) CouplingAddToPattern(sum, &groups, &coupling, pattern);
  }
  PetscCall(MpmGhostJacobian(sum, pattern));
  PetscCall(MpmContactsJacobian(sum, u, pattern));
  if (residual) {
    PetscCall(MpmGhostResidual(sum, u, residual));
    MpmContactsResidual(sum, u, residual);
  }
  PetscCall(PetscFree2(to.element, to.rows));
  PetscCall(PetscFree(coupling.storage));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The diagonal blocks of one group's nodes. */
MPM_INLINE PetscErrorCode DiagonalGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                        PetscBool weights, const PetscReal u[], MpmWorkspace *work, Coupling *coupling,
                                        PetscReal blocks[], PetscInt *failed)
{
  const PetscInt  N = known.inputs, bs = known.block;
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    PetscReal flux[MPM_MAX_INPUTS], tangent[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

    if (!PointTangent(known, sum, group, sum->space->order[s], weights, work, coupling, flux, tangent)) {
      (*failed)++;
      continue;
    }
    for (PetscInt i = 0; i < known.n; i++) {
      PetscReal *block = &blocks[nodes[i] * bs * bs];

      for (PetscInt k = 0; k < N; k++) {
        const PetscReal phi = work->basis.basis[KnownBasis(known, sum->layout, k)][i];
        PetscReal      *row = &block[KnownComponent(known, sum->layout, k) * bs];

        for (PetscInt l = 0; l < N; l++)
          row[KnownComponent(known, sum->layout, l)] +=
            phi * tangent[k * N + l] * work->basis.basis[KnownBasis(known, sum->layout, l)][i];
      }
    }
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmJacobianDiagonal(const MpmSum *sum, const PetscReal u[], PetscReal blocks[], PetscInt *failed)
{
  const MpmSpace *space   = sum->space;
  const PetscBool weights = MpmLayoutUsesValues(sum->layout);
  MpmWorkspace    work;
  Coupling        coupling;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(PetscArrayzero(blocks, space->local * sum->layout->block * sum->layout->block));
  PetscCall(MpmMeanEvaluate(sum, u, failed));
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(CouplingCreate(sum, &coupling));
  for (PetscInt unit = 0; unit < MpmUnitCount(sum); unit++) {
    const MpmCell groups = MpmUnitGroups(sum, unit);

    if (coupling.storage) CouplingClear(sum, &groups, &coupling);
    for (PetscInt g = groups.group_begin; g < groups.group_end; g++) {
      const MpmGroup *group = &space->groups[g];

      MPM_DISPATCH(sum->layout, group, DiagonalGroup, sum, group, weights, u, &work, &coupling, blocks, failed);
    }
    if (coupling.storage) CouplingAddToDiagonal(sum, &groups, &coupling, blocks);
  }
  PetscCall(MpmGhostDiagonal(sum, blocks));
  MpmContactsDiagonal(sum, u, blocks);
  PetscCall(PetscFree(coupling.storage));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
