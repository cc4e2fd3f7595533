#pragma once
/*
  Vectors over the points' states: directions in which a state changes, and derivatives of numbers by a state.
*/
#include "base/base.h"
#include "base/types.h"

/* Fields of a point's state. */
typedef enum {
  MPM_VECTOR_X, /* position */
  MPM_VECTOR_F,
  MPM_VECTOR_STATE,    /* history of the law */
  MPM_VECTOR_VALUE,    /* of fields with a rate, */
  MPM_VECTOR_GRADIENT, /* and their derivatives by x */
  MPM_VECTOR_OWN,      /* states of the physics' own */
  MPM_VECTOR_FIELDS
} MpmVectorField;

/* By point of this rank, in the order of `id`. */
struct MpmPointVector {
  PetscInt   count;
  PetscInt  *id;
  PetscInt   size[MPM_VECTOR_FIELDS]; /* numbers a point; 0: the points have no such field */
  PetscReal *at[MPM_VECTOR_FIELDS];
  PetscInt   dim, F_size, state_size; /* sizes and numbers of the first fields by name */
  PetscReal *x, *F, *state;
};

/* Zeros, for these points as they are lent. Destroy leaves zeros. */
PetscErrorCode MpmPointVectorCreate(const MpmPoints *points, const PetscInt size[], MpmPointVector *vector);
PetscErrorCode MpmPointVectorDestroy(MpmPointVector *vector);
/* Numbers a point of all fields. */
PetscInt MpmPointVectorSize(const MpmPointVector *vector);
/* Takes the numbers of the points of `from`, on whatever ranks these are; zeros for points that are not there.
   Collective. */
PetscErrorCode MpmPointVectorMove(MPI_Comm comm, const MpmPointVector *from, MpmPointVector *to);
/* A field of point p. */
static inline PetscReal *MpmPointNumbers(const MpmPointVector *vector, MpmVectorField field, PetscInt p)
{
  return &vector->at[field][p * vector->size[field]];
}
