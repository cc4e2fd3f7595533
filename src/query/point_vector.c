/*
  Vectors over the points' states.
*/
#include <petscsf.h>
#include "particles/particles.h"
#include "query/point_vector.h"
#include "particles/points.h"

static PetscErrorCode Create(PetscInt count, const PetscInt id[], const PetscInt size[], MpmPointVector *vector)
{
  PetscFunctionBeginUser;
  vector->count = count;
  PetscCall(PetscMalloc1((count + 1), &vector->id));
  PetscCall(PetscArraycpy(vector->id, id, count));
  for (PetscInt k = 0; k < MPM_VECTOR_FIELDS; k++) {
    vector->size[k] = size[k];
    PetscCall(PetscCalloc1((count * size[k] + 1), &vector->at[k]));
  }
  vector->dim        = size[MPM_VECTOR_X];
  vector->F_size     = size[MPM_VECTOR_F];
  vector->state_size = size[MPM_VECTOR_STATE];
  vector->x          = vector->at[MPM_VECTOR_X];
  vector->F          = vector->at[MPM_VECTOR_F];
  vector->state      = vector->at[MPM_VECTOR_STATE];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointVectorCreate(const MpmPoints *points, const PetscInt size[], MpmPointVector *vector)
{
  PetscFunctionBeginUser;
  PetscCall(Create(points->count, points->id, size, vector));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointVectorCopy(const MpmPointVector *from, PetscBool numbers, MpmPointVector *to)
{
  PetscFunctionBeginUser;
  PetscCall(Create(from->count, from->id, from->size, to));
  for (PetscInt k = 0; numbers && k < MPM_VECTOR_FIELDS; k++)
    PetscCall(PetscArraycpy(to->at[k], from->at[k], from->count * from->size[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPointVectorTake(const MpmPoints *points, MpmPointVector *vector)
{
  const PetscReal *const fields[MPM_VECTOR_FIELDS] = {
    points->x,           points->F, points->state, points->physics.value, points->physics.value_gradient,
    points->physics.own, NULL,      points->x0,    points->volume0,       points->domain.half_length,
    points->mass};

  for (PetscInt f = 0; f < MPM_VECTOR_FIELDS; f++)
    for (PetscInt i = 0; i < vector->count * vector->size[f]; i++)
      vector->at[f][i] = f >= MPM_VECTOR_VOLUME ? PetscLogReal(fields[f][i]) : fields[f][i];
}

PetscErrorCode MpmPointVectorDestroy(MpmPointVector *vector)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(vector->id));
  for (PetscInt k = 0; k < MPM_VECTOR_FIELDS; k++) PetscCall(PetscFree(vector->at[k]));
  PetscCall(PetscMemzero(vector, sizeof(*vector)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmPointVectorSize(const MpmPointVector *vector)
{
  PetscInt size = 0;

  for (PetscInt k = 0; k < MPM_VECTOR_FIELDS; k++) size += vector->size[k];
  return size;
}

void MpmPointVectorAddConstant(const MpmPointVector *from, MpmPointVector *to)
{
  for (PetscInt k = MPM_VECTOR_ORIGIN; k < MPM_VECTOR_FIELDS; k++)
    for (PetscInt i = 0; i < from->count * from->size[k]; i++) to->at[k][i] += from->at[k][i];
}

/* A star forest from these points to a directory of all ids. */
static PetscErrorCode PointAt(MPI_Comm comm, PetscLayout directory, const MpmPointVector *vector, PetscSF *sf)
{
  PetscFunctionBeginUser;
  PetscCall(PetscSFCreate(comm, sf));
  PetscCall(PetscSFSetGraphLayout(*sf, directory, vector->count, NULL, PETSC_COPY_VALUES, vector->id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies where no point has moved on any rank. Collective. */
static PetscErrorCode Copy(MPI_Comm comm, const MpmPointVector *from, MpmPointVector *to, PetscBool *same)
{
  PetscFunctionBeginUser;
  *same = (PetscBool)(from->count == to->count);
  for (PetscInt p = 0; *same && p < to->count; p++) *same = (PetscBool)(from->id[p] == to->id[p]);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, same, 1, MPIU_BOOL, MPI_LAND, comm));
  for (PetscInt k = 0; *same && k < MPM_VECTOR_FIELDS; k++)
    PetscCall(PetscArraycpy(to->at[k], from->at[k], to->count * to->size[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointVectorMove(MPI_Comm comm, const MpmPointVector *from, MpmPointVector *to)
{
  PetscInt    largest = -1, slots;
  PetscBool   same;
  PetscLayout directory;
  PetscSF     leave, arrive;

  PetscFunctionBeginUser;
  PetscCall(Copy(comm, from, to, &same));
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt p = 0; p < from->count; p++) largest = PetscMax(largest, from->id[p]);
  for (PetscInt p = 0; p < to->count; p++) largest = PetscMax(largest, to->id[p]);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &largest, 1, MPIU_INT, MPI_MAX, comm));
  PetscCall(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, largest + 1, 1, &directory));
  PetscCall(PetscLayoutGetLocalSize(directory, &slots));
  PetscCall(PointAt(comm, directory, from, &leave));
  PetscCall(PointAt(comm, directory, to, &arrive));
  for (PetscInt k = 0; k < MPM_VECTOR_FIELDS; k++) {
    const PetscInt size = to->size[k];
    MPI_Datatype   unit;
    PetscReal     *slot;

    if (!size) continue;
    PetscCallMPI(MPI_Type_contiguous((PetscMPIInt)size, MPIU_REAL, &unit));
    PetscCallMPI(MPI_Type_commit(&unit));
    PetscCall(PetscCalloc1((slots * size + 1), &slot));
    PetscCall(PetscSFReduceBegin(leave, unit, from->at[k], slot, MPI_REPLACE));
    PetscCall(PetscSFReduceEnd(leave, unit, from->at[k], slot, MPI_REPLACE));
    PetscCall(PetscSFBcastBegin(arrive, unit, slot, to->at[k], MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(arrive, unit, slot, to->at[k], MPI_REPLACE));
    PetscCall(PetscFree(slot));
    PetscCallMPI(MPI_Type_free(&unit));
  }
  PetscCall(PetscSFDestroy(&leave));
  PetscCall(PetscSFDestroy(&arrive));
  PetscCall(PetscLayoutDestroy(&directory));
  PetscFunctionReturn(PETSC_SUCCESS);
}
