/*
  The bed's change at the nodes of the grid. Every rank has all of it: nodes that a rank does not own now may be its own
  later, and the heights about them count. A step sends the nodes that have changed.
*/
#include "grid/grid.h"
#include "io/io.h"
#include "entrainment/entrainment_impl.h"

PetscErrorCode MpmBedChangeCreate(const MpmGrid *grid, MpmBed *bed)
{
  PetscFunctionBeginUser;
  bed->change = (MpmMap){.columns = grid->nodes[0],
                         .rows    = grid->nodes[1],
                         .x0      = grid->lower[0],
                         .y0      = grid->lower[1],
                         .cell    = {grid->h[0], grid->h[1]}};
  PetscCall(PetscCalloc1((size_t)grid->nodes[0] * (size_t)grid->nodes[1], &bed->change.value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBedChangeAdd(MPI_Comm comm, const MpmBedSteps *steps, MpmBed *bed)
{
  PetscMPIInt size, own = (PetscMPIInt)steps->count, total = 0, *counts, *begins;
  PetscInt   *place;
  PetscReal  *height;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &size));
  if (size == 1) {
    for (PetscInt k = 0; k < steps->count; k++) bed->change.value[steps->place[k]] += steps->height[k];
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc2(size, &counts, size, &begins));
  PetscCallMPI(MPI_Allgather(&own, 1, MPI_INT, counts, 1, MPI_INT, comm));
  for (PetscMPIInt r = 0; r < size; r++) {
    begins[r] = total;
    total += counts[r];
  }
  PetscCall(PetscMalloc2(total, &place, total, &height));
  PetscCallMPI(MPI_Allgatherv(steps->place, own, MPIU_INT, place, counts, begins, MPIU_INT, comm));
  PetscCallMPI(MPI_Allgatherv(steps->height, own, MPIU_REAL, height, counts, begins, MPIU_REAL, comm));
  for (PetscMPIInt k = 0; k < total; k++) bed->change.value[place[k]] += height[k];
  PetscCall(PetscFree2(place, height));
  PetscCall(PetscFree2(counts, begins));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- checkpoints ---- */

PetscBool MpmEntrainmentHasChange(const MpmModel model)
{
  return (PetscBool)(model->entrainment && model->entrainment->bed->change.value);
}

/* Bytes of the change. */
static size_t Bytes(const MpmBed *bed)
{
  return sizeof(PetscReal) * (size_t)bed->change.columns * (size_t)bed->change.rows;
}

PetscErrorCode MpmEntrainmentSave(MpmModel model, MpmTextFile *bytes)
{
  const MpmBed *bed = model->entrainment->bed;

  PetscFunctionBeginUser;
  if (model->rank) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextFileReserve(bytes, Bytes(bed)));
  PetscCall(PetscMemcpy(bytes->data + bytes->length, bed->change.value, Bytes(bed)));
  bytes->length += Bytes(bed);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmEntrainmentLoad(MpmModel model, const MpmTextFile *bytes)
{
  MpmBed        *bed   = model->entrainment->bed;
  const PetscInt nodes = bed->change.columns * bed->change.rows;
  PetscBool      same  = PETSC_TRUE;

  PetscFunctionBeginUser;
  if (!model->rank) {
    same = (PetscBool)(bytes->length == Bytes(bed));
    if (same) PetscCall(PetscMemcpy(bed->change.value, bytes->data, Bytes(bed)));
  }
  PetscCallMPI(MPI_Bcast(&same, 1, MPM_MPI_BOOL, 0, model->comm));
  MpmCheckInput(same, "-mpm_restart: its change of the bed is of other nodes");
  PetscCallMPI(MPI_Bcast(bed->change.value, (PetscMPIInt)nodes, MPIU_REAL, 0, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
