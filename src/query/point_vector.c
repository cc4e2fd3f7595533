/*
  Vectors over the points' states.
*/
#include <petscsf.h>
#include "particles/particles.h"
#include "query/point_vector.h"
#include "particles/points.h"

PetscErrorCode MpmPointVectorCreate(const MpmPoints *points, PetscInt dim, PetscInt state_size, MpmPointVector *vector)
{
  PetscFunctionBeginUser;
  vector->count      = points->count;
  vector->dim        = dim;
  vector->F_size     = points->F_size;
  vector->state_size = state_size;
  PetscCall(PetscMalloc1((points->count + 1), &vector->id));
  PetscCall(PetscArraycpy(vector->id, points->id, points->count));
  PetscCall(PetscCalloc3((points->count * dim + 1), &vector->x, (points->count * points->F_size + 1), &vector->F,
                         (points->count * state_size + 1), &vector->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointVectorDestroy(MpmPointVector *vector)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(vector->id));
  PetscCall(PetscFree3(vector->x, vector->F, vector->state));
  PetscCall(PetscMemzero(vector, sizeof(*vector)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmPointVectorSize(const MpmPointVector *vector)
{
  return vector->dim + vector->F_size + vector->state_size;
}

/* A star forest from these points to a directory of all ids. */
static PetscErrorCode PointAt(MPI_Comm comm, PetscLayout directory, const MpmPointVector *vector, PetscSF *sf)
{
  PetscFunctionBeginUser;
  PetscCall(PetscSFCreate(comm, sf));
  PetscCall(PetscSFSetGraphLayout(*sf, directory, vector->count, NULL, PETSC_COPY_VALUES, vector->id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointVectorMove(MPI_Comm comm, const MpmPointVector *from, MpmPointVector *to)
{
  const PetscInt   size[]   = {to->dim, to->F_size, to->state_size};
  const PetscReal *source[] = {from->x, from->F, from->state};
  PetscReal       *target[] = {to->x, to->F, to->state};
  PetscInt         largest  = -1, slots;
  PetscLayout      directory;
  PetscSF          leave, arrive;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < from->count; p++) largest = PetscMax(largest, from->id[p]);
  for (PetscInt p = 0; p < to->count; p++) largest = PetscMax(largest, to->id[p]);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &largest, 1, MPIU_INT, MPI_MAX, comm));
  PetscCall(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, largest + 1, 1, &directory));
  PetscCall(PetscLayoutGetLocalSize(directory, &slots));
  PetscCall(PointAt(comm, directory, from, &leave));
  PetscCall(PointAt(comm, directory, to, &arrive));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(size); k++) {
    MPI_Datatype unit;
    PetscReal   *slot;

    if (!size[k]) continue;
    PetscCallMPI(MPI_Type_contiguous((PetscMPIInt)size[k], MPIU_REAL, &unit));
    PetscCallMPI(MPI_Type_commit(&unit));
    PetscCall(PetscCalloc1((slots * size[k] + 1), &slot));
    PetscCall(PetscSFReduceBegin(leave, unit, source[k], slot, MPI_REPLACE));
    PetscCall(PetscSFReduceEnd(leave, unit, source[k], slot, MPI_REPLACE));
    PetscCall(PetscSFBcastBegin(arrive, unit, slot, target[k], MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(arrive, unit, slot, target[k], MPI_REPLACE));
    PetscCall(PetscFree(slot));
    PetscCallMPI(MPI_Type_free(&unit));
  }
  PetscCall(PetscSFDestroy(&leave));
  PetscCall(PetscSFDestroy(&arrive));
  PetscCall(PetscLayoutDestroy(&directory));
  PetscFunctionReturn(PETSC_SUCCESS);
}
