/*
  Lists of integers from some ranks to some others, of which the receivers do not know beforehand.
*/
#include "base/base.h"

PetscErrorCode MpmListsDestroy(MpmLists *lists)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(lists->rank));
  PetscCall(PetscFree(lists->offset));
  PetscCall(PetscFree(lists->data));
  lists->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmListsExchange(MPI_Comm comm, const MpmLists *sent, MpmLists *received)
{
  PetscMPIInt  from_count, *from, tag;
  PetscInt    *length, *from_length;
  MPI_Request *request;

  PetscFunctionBeginUser;
  PetscCall(PetscCommGetNewTag(comm, &tag));
  PetscCall(PetscMalloc1(sent->count, &length));
  for (PetscInt k = 0; k < sent->count; k++) length[k] = sent->offset[k + 1] - sent->offset[k];
  PetscCall(PetscCommBuildTwoSided(comm, 1, MPIU_INT, (PetscMPIInt)sent->count, sent->rank, length, &from_count, &from,
                                   (void *)&from_length));
  received->count = from_count;
  PetscCall(PetscMalloc1(from_count, &received->rank));
  PetscCall(PetscMalloc1((from_count + 1), &received->offset));
  received->offset[0] = 0;
  for (PetscInt k = 0; k < from_count; k++) {
    received->rank[k]       = from[k];
    received->offset[k + 1] = received->offset[k] + from_length[k];
  }
  PetscCall(PetscMalloc1(received->offset[from_count], &received->data));
  PetscCall(PetscMalloc1((from_count + sent->count), &request));
  for (PetscInt k = 0; k < from_count; k++) {
    PetscCallMPI(MPI_Irecv(&received->data[received->offset[k]], (PetscMPIInt)from_length[k], MPIU_INT, from[k], tag,
                           comm, &request[k]));
  }
  for (PetscInt k = 0; k < sent->count; k++) {
    PetscCallMPI(MPI_Isend(&sent->data[sent->offset[k]], (PetscMPIInt)length[k], MPIU_INT, sent->rank[k], tag, comm,
                           &request[from_count + k]));
  }
  PetscCallMPI(MPI_Waitall((PetscMPIInt)(from_count + sent->count), request, MPI_STATUSES_IGNORE));
  PetscCall(PetscFree(request));
  PetscCall(PetscFree(length));
  PetscCall(PetscFree(from));
  PetscCall(PetscFree(from_length));
  PetscFunctionReturn(PETSC_SUCCESS);
}
