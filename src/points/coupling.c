/*
  The vectors that tie the nodes of a cell together through its mean, summed over its points.
*/
#include "space/point_loop.h"
#include "points/coupling.h"

PetscErrorCode MpmCouplingCreate(const MpmSum *sum, MpmCoupling *coupling)
{
  const PetscInt n = PetscPowInt(sum->space->boxes.reach + 1, sum->space->dim) * sum->block;

  PetscFunctionBeginUser;
  PetscCall(MpmCellWorkCreate(sum, &coupling->cell));
  coupling->storage = NULL;
  coupling->spread  = NULL;
  if (!sum->layout->means) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((6 * n), &coupling->storage));
  coupling->flux_by_mean = coupling->storage;
  coupling->mean_by_u    = coupling->flux_by_mean + n;
  coupling->f_by_u       = coupling->mean_by_u + n;
  for (PetscInt v = 0; v < 3; v++) coupling->part[v] = coupling->storage + (3 + v) * n;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCouplingDestroy(MpmCoupling *coupling)
{
  PetscFunctionBeginUser;
  PetscCall(MpmCellWorkDestroy(&coupling->cell));
  PetscCall(PetscFree(coupling->storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCouplingBegin(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], MpmCoupling *coupling,
                                PetscInt *failed)
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
MPM_INLINE void TakePart(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, MpmCoupling *coupling)
{
  const PetscInt bs = known.block, *const count = known.count;
  const MpmGroup *box = &sum->space->groups[sum->space->cells.at[group->cell].box];
  PetscInt        i   = 0;

  for (PetscInt l = 0; l < count[2]; l++) {
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

MPM_INLINE PetscErrorCode AddGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                   MpmCoupling *coupling)
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
  TakePart(known, sum, group, coupling);
  return PETSC_SUCCESS;
}

PetscErrorCode MpmCouplingAddGroup(const MpmSum *sum, const MpmGroup *group, MpmCoupling *coupling)
{
  PetscFunctionBeginUser;
  if (sum->layout->means) MPM_DISPATCH(sum->layout, group, AddGroup, sum, group, coupling);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmCouplingEnd(const MpmSum *sum, const MpmCell *cell, MpmCoupling *coupling)
{
  const PetscInt n = sum->space->groups[cell->box].node_count * sum->block;

  for (PetscInt k = 0; k < n; k++) coupling->f_by_u[k] += coupling->f_by_mean * coupling->mean_by_u[k];
}
