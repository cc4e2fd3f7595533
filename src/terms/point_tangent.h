#pragma once
/*
  What the sums over tangents share: a point's own, and what ties the nodes of a cell together through its mean. Inlined into
  the loops of tangent.c and tangent_diagonal.c.
*/
#include "space/unit.h"
#include "terms/cell_mean.h"
#include "terms/point_term.h"
#include "terms/sparsity.h"

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

static inline PetscErrorCode CouplingCreate(const MpmSum *sum, Coupling *coupling)
{
  const PetscInt n = PetscPowInt(sum->space->reach + 1, sum->space->dim) * sum->block;

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

static inline PetscErrorCode CouplingDestroy(Coupling *coupling)
{
  PetscFunctionBeginUser;
  PetscCall(MpmCellWorkDestroy(&coupling->cell));
  PetscCall(PetscFree(coupling->storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A new cell begins: the tangents of its points. */
static inline PetscErrorCode CouplingBegin(const MpmSum *sum, const MpmCell *cell, const PetscReal u[],
                                           Coupling *coupling, PetscInt *failed)
{
  const PetscInt n = sum->space->groups[cell->box].node_count * sum->block;

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
static inline void CouplingEnd(const MpmSum *sum, const MpmCell *cell, Coupling *coupling)
{
  const PetscInt n = sum->space->groups[cell->box].node_count * sum->block;

  for (PetscInt k = 0; k < n; k++) coupling->f_by_u[k] += coupling->f_by_mean * coupling->mean_by_u[k];
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
