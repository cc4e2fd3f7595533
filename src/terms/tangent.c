/*
  The Jacobian, point by point: the kernel on duals that are seeded with the point's inputs gives the point's D, and the
  element block of a group is the sum of B^T D B over its points. Where the physics has a mean, each cell adds the
  products of a few vectors over all of its nodes.
*/
#include "terms/cell_mean.h"
#include "terms/point_term.h"
#include "terms/sparsity.h"

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
  What ties the nodes of a cell together through its mean m_bar, and f, the flux conjugate to it: one value for each
  unknown of the cell's box, [i][c].

    K_cell += flux_by_mean mean_by_u^T + mean_by_u (f_by_u + f_by_mean mean_by_u)^T
*/
typedef struct {
  PetscReal  *flux_by_mean, *mean_by_u, *f_by_u, f_by_mean;
  PetscReal  *part[3], *storage; /* those of one group, [c][i] */
  MpmCellWork cell;
} Coupling;

static PetscErrorCode CouplingCreate(const MpmSum *sum, Coupling *coupling)
{
  const PetscInt n = PetscPowInt(sum->space->reach + 1, sum->space->dim) * sum->layout->block;

  PetscFunctionBeginUser;
  PetscCall(MpmCellWorkCreate(sum, &coupling->cell));
  coupling->storage = NULL;
  if (!sum->layout->means) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((6 * n), &coupling->storage));
  coupling->flux_by_mean = coupling->storage;
  coupling->mean_by_u    = coupling->flux_by_mean + n;
  coupling->f_by_u       = coupling->mean_by_u + n;
  for (PetscInt v = 0; v < 3; v++) coupling->part[v] = coupling->storage + (3 + v) * n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CouplingDestroy(Coupling *coupling)
{
  PetscFunctionBeginUser;
  PetscCall(MpmCellWorkDestroy(&coupling->cell));
  PetscCall(PetscFree(coupling->storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A new cell begins: the tangents of its points. */
static PetscErrorCode CouplingBegin(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], Coupling *coupling,
                                    PetscInt *failed)
{
  const PetscInt n = sum->space->groups[cell->box].node_count * sum->layout->block;

  PetscFunctionBeginUser;
  if (!sum->layout->means) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmCellTangent(sum, cell, u, &coupling->cell, failed));
  for (PetscInt k = 0; k < n; k++) coupling->flux_by_mean[k] = coupling->mean_by_u[k] = coupling->f_by_u[k] = 0.;
  coupling->f_by_mean = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One group's part of the vectors goes from [c][i] to its place in the cell's box. */
MPM_INLINE void CouplingTakePart(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, Coupling *coupling)
{
  const PetscInt bs = known.block, *const count = known.count;
  const MpmGroup *box = &sum->space->groups[sum->space->cells[group->cell].box];
  PetscInt        i   = 0;

  for (PetscInt l = 0; l < (known.dim == 2 ? 1 : count[2]); l++) {
    for (PetscInt j = 0; j < count[1]; j++) {
      const PetscInt first =
        ((l + group->first[2] - box->first[2]) * box->count[1] + j + group->first[1] - box->first[1]) * box->count[0] +
        group->first[0] - box->first[0];

      for (PetscInt k = 0; k < count[0]; k++, i++) {
        for (PetscInt c = 0; c < bs; c++) {
          coupling->flux_by_mean[(first + k) * bs + c] += coupling->part[0][c * known.n + i];
          coupling->mean_by_u[(first + k) * bs + c] += coupling->part[1][c * known.n + i];
          coupling->f_by_u[(first + k) * bs + c] += coupling->part[2][c * known.n + i];
        }
      }
    }
  }
}

/* The vectors of one group's points. */
MPM_INLINE void CouplingAddGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, Coupling *coupling)
{
  for (PetscInt v = 0; v < 3; v++)
    for (PetscInt k = 0; k < known.n * known.block; k++) coupling->part[v][k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const MpmCellPoint *at = &coupling->cell.point[s - coupling->cell.begin];

    MpmSumAddFlux(known, sum->layout, &at->basis, at->tangent.by_mean, coupling->part[0]);
    MpmSumAddFlux(known, sum->layout, &at->basis, at->tangent.dm, coupling->part[1]);
    MpmSumAddFlux(known, sum->layout, &at->basis, at->tangent.of_mean, coupling->part[2]);
    coupling->f_by_mean += at->tangent.second[0];
  }
  CouplingTakePart(known, sum, group, coupling);
}

/* The cell is complete: its products are flux_by_mean mean_by_u^T + mean_by_u f_by_u^T from here on. */
static void CouplingEnd(const MpmSum *sum, const MpmCell *cell, Coupling *coupling)
{
  const PetscInt n = sum->space->groups[cell->box].node_count * sum->layout->block;

  for (PetscInt k = 0; k < n; k++) coupling->f_by_u[k] += coupling->f_by_mean * coupling->mean_by_u[k];
}

static void CouplingAddToDiagonal(const MpmSum *sum, const MpmCell *cell, const Coupling *coupling, PetscReal blocks[])
{
  const MpmGroup *box   = &sum->space->groups[cell->box];
  const PetscInt  bs    = sum->layout->block;
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];

  for (PetscInt i = 0; i < box->node_count; i++) {
    const PetscReal *a = &coupling->flux_by_mean[i * bs], *b = &coupling->mean_by_u[i * bs],
                    *f = &coupling->f_by_u[i * bs];

    for (PetscInt c = 0; nodes[i] >= 0 && c < bs; c++)
      for (PetscInt d = 0; d < bs; d++) blocks[(nodes[i] * bs + c) * bs + d] += a[c] * b[d] + b[c] * f[d];
  }
}

/* A point as the sums over a group take it; where there is a mean the passes over its cell have made it. */
typedef struct {
  PetscReal        flux_here[MPM_MAX_INPUTS], tangent_here[MPM_MAX_INPUTS * MPM_MAX_INPUTS];
  const PetscReal *flux, *tangent;
  MpmBasis         basis;
} Point;

/* PETSC_FALSE where it has no answer. */
MPM_INLINE PetscBool PointTangent(const MpmKnown known, const MpmSum *sum, PetscInt s, const MpmWorkspace *work,
                                  const Coupling *coupling, Point *at)
{
  const PetscInt  p       = sum->space->order[s];
  const PetscBool weights = work->weights;
  MpmKernelPoint  point;
  PetscReal       input[MPM_MAX_INPUTS];

  if (sum->layout->means) {
    const MpmCellPoint *made = &coupling->cell.point[s - coupling->cell.begin];

    at->flux    = made->flux;
    at->tangent = made->tangent.by_input;
    at->basis   = made->basis;
    return PETSC_TRUE;
  }
  MpmSumFetch(known, sum, s);
  MpmSumBasis(known, sum->space, p, weights, &work->basis);
  MpmSumInputs(known, sum->layout, work->values, &work->basis, input);
  MpmSumPoint(sum, p, &point);
  at->flux    = at->flux_here;
  at->tangent = at->tangent_here;
  at->basis   = work->basis;
  return (PetscBool)!sum->layout->kernel->tangent(&point, input, at->flux_here, at->tangent_here);
}

/* Where the sums over a group's points go; `residual` is NULL where nobody asks for it. */
typedef struct {
  PetscReal *element, *residual;
  PetscReal *rows;   /* room for AddElement */
  PetscReal *blocks; /* the diagonal blocks of all nodes, in place of elements */
  Coupling   coupling;
} Target;

/* The element block of one group, and its forces. */
MPM_INLINE PetscErrorCode ElementGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                       const PetscReal u[], MpmWorkspace *work, Target *to, PetscInt *failed)
{
  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt k = 0; k < known.n * known.block; k++) work->force[k] = 0.;
  for (PetscInt k = 0; k < known.n * known.n * known.block * known.block; k++) to->element[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    Point at;

    if (!PointTangent(known, sum, s, work, &to->coupling, &at)) {
      (*failed)++;
      continue;
    }
    AddElement(known, sum->layout, &at.basis, at.tangent, to->rows, to->element);
    if (to->residual) MpmSumAddFlux(known, sum->layout, &at.basis, at.flux, work->force);
  }
  if (sum->layout->means) CouplingAddGroup(known, sum, group, &to->coupling);
  if (to->residual) MpmSumScatter(known, sum, group, work->force, to->residual);
  return PETSC_SUCCESS;
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmSpace *space = sum->space;
  const PetscInt  most = PetscPowInt(space->width, space->dim), bs = sum->layout->block;
  Target          to = {.residual = residual};
  MpmWorkspace    work;

  PetscFunctionBeginUser;
  (void)ctx;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(CouplingCreate(sum, &to.coupling));
  PetscCall(PetscMalloc2((most * most * bs * bs), &to.element, (most * bs * sum->layout->inputs), &to.rows));
  for (PetscInt unit = 0; unit < MpmUnitCount(sum); unit++) {
    const MpmCell groups = MpmUnitGroups(sum, unit);

    PetscCall(CouplingBegin(sum, &groups, u, &to.coupling, failed));
    if (sum->layout->means && *failed) break;
    for (PetscInt g = groups.group_begin; g < groups.group_end; g++) {
      const MpmGroup *group = &space->groups[g];

      MPM_DISPATCH(sum->layout, group, ElementGroup, sum, group, u, &work, &to, failed);
      MpmPatternAddBlock(pattern, space, group, to.element);
    }
    if (sum->layout->means) {
      CouplingEnd(sum, &groups, &to.coupling);
      MpmPatternAddPair(pattern, space, &space->groups[groups.box], to.coupling.flux_by_mean, to.coupling.mean_by_u,
                        to.coupling.f_by_u);
    }
  }
  PetscCall(PetscFree2(to.element, to.rows));
  PetscCall(CouplingDestroy(&to.coupling));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The diagonal blocks of one group's nodes. */
MPM_INLINE PetscErrorCode DiagonalGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                        const PetscReal u[], MpmWorkspace *work, Target *to, PetscInt *failed)
{
  const PetscInt  N = known.inputs, bs = known.block;
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    Point at;

    if (!PointTangent(known, sum, s, work, &to->coupling, &at)) {
      (*failed)++;
      continue;
    }
    for (PetscInt i = 0; i < known.n; i++) {
      PetscReal *block = &to->blocks[nodes[i] * bs * bs];

      for (PetscInt k = 0; k < N; k++) {
        const PetscReal phi = at.basis.basis[KnownBasis(known, sum->layout, k)][i];
        PetscReal      *row = &block[KnownComponent(known, sum->layout, k) * bs];

        for (PetscInt l = 0; l < N; l++)
          row[KnownComponent(known, sum->layout, l)] +=
            phi * at.tangent[k * N + l] * at.basis.basis[KnownBasis(known, sum->layout, l)][i];
      }
    }
  }
  if (sum->layout->means) CouplingAddGroup(known, sum, group, &to->coupling);
  return PETSC_SUCCESS;
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  const MpmSpace *space = sum->space;
  Target          to    = {.blocks = blocks};
  MpmWorkspace    work;

  PetscFunctionBeginUser;
  (void)ctx;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(CouplingCreate(sum, &to.coupling));
  for (PetscInt unit = 0; unit < MpmUnitCount(sum); unit++) {
    const MpmCell groups = MpmUnitGroups(sum, unit);

    PetscCall(CouplingBegin(sum, &groups, u, &to.coupling, failed));
    if (sum->layout->means && *failed) break;
    for (PetscInt g = groups.group_begin; g < groups.group_end; g++) {
      const MpmGroup *group = &space->groups[g];

      MPM_DISPATCH(sum->layout, group, DiagonalGroup, sum, group, u, &work, &to, failed);
    }
    if (sum->layout->means) {
      CouplingEnd(sum, &groups, &to.coupling);
      CouplingAddToDiagonal(sum, &groups, &to.coupling, blocks);
    }
  }
  PetscCall(CouplingDestroy(&to.coupling));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermPoints = {
  .name = "points", .residual = MpmPointsResidual, .tangent = Tangent, .diagonal = Diagonal};
const MpmTerm MpmTermCellMeans = {.name     = "points with cell means",
                                  .boxes    = MpmCellsBoxes,
                                  .residual = MpmCellsResidual,
                                  .tangent  = Tangent,
                                  .diagonal = Diagonal};
