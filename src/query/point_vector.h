#pragma once
/*
  Vectors over the points' states: directions in which a state changes, and derivatives of numbers by a state.
*/
#include "base/base.h"
#include "base/types.h"

/* By point of this rank, in the order of `id`. */
struct MpmPointVector {
  PetscInt   count, dim, F_size, state_size;
  PetscInt  *id;
  PetscReal *x, *F, *state; /* by position, F and history of the law */
};

/* Zeros, for these points as they are lent. Destroy leaves zeros. */
PetscErrorCode MpmPointVectorCreate(const MpmPoints *points, PetscInt dim, PetscInt state_size, MpmPointVector *vector);
PetscErrorCode MpmPointVectorDestroy(MpmPointVector *vector);
/* Numbers a point of all fields; those of point p, in the order x, F, state. */
PetscInt MpmPointVectorSize(const MpmPointVector *vector);
/* Takes the numbers of the points of `from`, on whatever ranks these are; zeros for points that are not there.
   Collective. */
PetscErrorCode MpmPointVectorMove(MPI_Comm comm, const MpmPointVector *from, MpmPointVector *to);
