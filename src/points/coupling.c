/*
  The vectors that tie the nodes of a cell together through its mean, summed over its points.
*/
#include "space/point_loop.h"
#include "points/coupling.h"

PetscErrorCode MpmCouplingCreate(const MpmSum *sum, MpmCoupling *coupling)
{
  const PetscInt n     = PetscPowInt(sum->space->boxes.reach + 1, sum->space->dim) * sum->block;
  const PetscInt modes = sum->space->cells.modes;

  PetscFunctionBeginUser;
  PetscCall(MpmCellWorkCreate(sum, &coupling->cell));
  coupling->storage = NULL;
  coupling->spread  = NULL;
  coupling->modes   = modes;
  if (!sum->layout->means) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((3 * (modes + 1) * n), &coupling->storage));
  for (PetscInt i = 0; i < modes; i++) {
    PetscReal *at = coupling->storage + 3 * i * n;

    coupling->mode[i] = (MpmModeCoupling){at, at + n, at + 2 * n};
  }
  for (PetscInt v = 0; v < 3; v++) coupling->part[v] = coupling->storage + (3 * modes + v) * n;
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
  for (PetscInt i = 0; i < coupling->modes; i++) {
    const MpmModeCoupling mode = coupling->mode[i];

    for (PetscInt k = 0; k < n; k++) mode.flux_by_mean[k] = mode.mean_by_u[k] = mode.f_by_u[k] = 0.;
  }
  for (PetscInt k = 0; k < PetscSqr(coupling->modes); k++) coupling->f_by_mean[k] = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One group's part of the vectors of a polynomial goes from [c][i] to its place in the cell's box. */
MPM_INLINE void TakePart(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, const MpmCoupling *coupling,
                         const MpmModeCoupling mode)
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
          mode.flux_by_mean[(first + k) * bs + c] += coupling->part[0][c * known.n + i];
          mode.mean_by_u[(first + k) * bs + c] += coupling->part[1][c * known.n + i];
          mode.f_by_u[(first + k) * bs + c] += coupling->part[2][c * known.n + i];
        }
      }
    }
  }
}

/* Adds a point's fluxes, times the value of a polynomial at it, to the nodes of its group. */
MPM_INLINE void AddFlux(const MpmKnown known, const MpmSum *sum, const MpmBasis *basis, PetscReal phi,
                        const PetscReal flux[], PetscReal part[])
{
  PetscReal scaled[MPM_MAX_INPUTS];

  for (PetscInt k = 0; k < known.inputs; k++) scaled[k] = phi * flux[k];
  MpmSumAddFlux(known, sum->layout, basis, scaled, part);
}

MPM_INLINE PetscErrorCode AddGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                   MpmCoupling *coupling)
{
  const MpmCells *cells = &sum->space->cells;

  for (PetscInt i = 0; i < coupling->modes; i++) {
    for (PetscInt v = 0; v < 3; v++)
      for (PetscInt k = 0; k < known.n * known.block; k++) coupling->part[v][k] = 0.;
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const MpmCellPoint *at  = &coupling->cell.point[s - coupling->cell.begin];
      const PetscReal     phi = MpmModeValue(cells, sum->space->order[s], i);

      AddFlux(known, sum, &at->basis, phi, at->tangent.by_mean, coupling->part[0]);
      AddFlux(known, sum, &at->basis, phi, at->tangent.dm, coupling->part[1]);
      AddFlux(known, sum, &at->basis, phi, at->tangent.of_mean, coupling->part[2]);
      MpmModesAdd(cells, sum->space->order[s], phi * at->tangent.second[0], &coupling->f_by_mean[i * coupling->modes]);
    }
    TakePart(known, sum, group, coupling, coupling->mode[i]);
  }
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
  const PetscInt n = sum->space->groups[cell->box].node_count * sum->block, modes = coupling->modes;

  for (PetscInt i = 0; i < modes; i++)
    for (PetscInt j = 0; j < modes; j++)
      for (PetscInt k = 0; k < n; k++)
        coupling->mode[i].f_by_u[k] += coupling->f_by_mean[i * modes + j] * coupling->mode[j].mean_by_u[k];
}
