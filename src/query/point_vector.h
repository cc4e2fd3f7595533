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
  MPM_VECTOR_STATE,     /* history of the law */
  MPM_VECTOR_VALUE,     /* of fields with a rate, */
  MPM_VECTOR_GRADIENT,  /* and their derivatives by x */
  MPM_VECTOR_OWN,       /* states of the physics' own */
  MPM_VECTOR_DEVIATION, /* deviations at the first of two stages, whose vectors alone have them */
  MPM_VECTOR_ORIGIN,    /* position from which displacements count; those from here on stay in a step */
  MPM_VECTOR_VOLUME,    /* relative change of the initial volume, */
  MPM_VECTOR_LENGTH,    /* of the domain's initial half-lengths */
  MPM_VECTOR_MASS,      /* and of masses that are the points' own */
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
/* A vector of the points and fields of another one, with its numbers, or zeros. */
PetscErrorCode MpmPointVectorCopy(const MpmPointVector *from, PetscBool numbers, MpmPointVector *to);
/* The points' state itself: of relative changes the logarithms. */
void MpmPointVectorTake(const MpmPoints *points, MpmPointVector *vector);
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
/* NULL where the points have no such field. */
static inline PetscReal *MpmPointNumbersIf(const MpmPointVector *vector, MpmVectorField field, PetscInt p)
{
  return vector->size[field] ? &vector->at[field][p * vector->size[field]] : NULL;
}
/* A field of one number; 0 where the points have none. */
static inline PetscReal MpmPointNumber(const MpmPointVector *vector, MpmVectorField field, PetscInt p)
{
  return vector->size[field] ? vector->at[field][p] : 0.;
}
/* Adds the fields that stay in a step to those of a vector over the same points. */
void MpmPointVectorAddConstant(const MpmPointVector *from, MpmPointVector *to);
