/*
  Numbers of rows by ascending id over all ranks.
*/
#include <petscsf.h>
#include "io/io.h"

/* Ids are distributed over the ranks in blocks, whatever holes there are between them. */
PetscErrorCode MpmNumberRows(MPI_Comm comm, PetscInt count, const PetscInt id[], PetscInt row[], PetscInt *largest)
{
  PetscInt ends[2] = {0, 0}, size, first, below = 0,
           *found; /* ends: the negative of the smallest id, and the largest */
  PetscBool   once = PETSC_TRUE;
  PetscLayout layout;
  PetscSF     sf;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < count; ++i) {
    ends[0] = PetscMax(ends[0], -id[i]);
    ends[1] = PetscMax(ends[1], id[i]);
    row[i]  = 1;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPIU_INT, MPI_MAX, comm));
  PetscCheck(ends[0] <= 0, comm, PETSC_ERR_ARG_OUTOFRANGE, "an id of a point is negative: %lld", -(long long)ends[0]);
  *largest = ends[1];
  PetscCall(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, ends[1] + 1, 1, &layout));
  PetscCall(PetscLayoutGetLocalSize(layout, &size));
  PetscCall(PetscSFCreate(comm, &sf));
  PetscCall(PetscSFSetGraphLayout(sf, layout, count, NULL, PETSC_COPY_VALUES, id));
  PetscCall(PetscCalloc1(size, &found));
  PetscCall(PetscSFReduceBegin(sf, MPIU_INT, row, found, MPI_SUM));
  PetscCall(PetscSFReduceEnd(sf, MPIU_INT, row, found, MPI_SUM));
  for (PetscInt i = 0; i < size; ++i) {
    once = (PetscBool)(once && found[i] <= 1);
    below += found[i];
  }
  PetscCallMPI(MPI_Scan(&below, &first, 1, MPIU_INT, MPI_SUM, comm));
  first -= below;
  for (PetscInt i = 0; i < size; ++i) {
    const PetscInt here = found[i];

    found[i] = first;
    first += here;
  }
  PetscCall(PetscSFBcastBegin(sf, MPIU_INT, found, row, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(sf, MPIU_INT, found, row, MPI_REPLACE));
  PetscCall(PetscFree(found));
  PetscCall(PetscSFDestroy(&sf));
  PetscCall(PetscLayoutDestroy(&layout));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &once, 1, MPM_MPI_BOOL, MPI_LAND, comm));
  PetscCheck(once, comm, PETSC_ERR_ARG_WRONG, "two points have the same id");
  PetscFunctionReturn(PETSC_SUCCESS);
}
