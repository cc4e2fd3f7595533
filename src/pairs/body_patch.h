#pragma once
/*
  The force of one patch between two bodies (body_patch.c).
*/
#include "pairs/body_contact.h"
#include "space/sum.h"

#define MPM_PAIR_WATER MPM_MAX_DIM /* place of the water beside the axes: difference of pressures, flow */
#define MPM_PAIR_ROWS  (MPM_MAX_DIM + 1)

/* Answer of a patch to a mean relative displacement w. */
typedef struct {
  PetscBool active, refused; /* refused: the barrier has no answer */
  PetscReal gap, pressure;
  PetscReal force[MPM_MAX_DIM];                  /* on the first body */
  PetscReal slip[MPM_MAX_DIM];                   /* slip to be kept */
  PetscReal stiffness[MPM_MAX_DIM][MPM_MAX_DIM]; /* -d force/dw */
} MpmPairAnswer;

/* The unknown of a row. */
static inline PetscInt MpmPairComponent(const MpmPairContacts *contacts, PetscInt row)
{
  return row == MPM_PAIR_WATER ? contacts->water : row;
}

/* True where the row acts. */
static inline PetscBool MpmPairActs(const MpmPairPatch *patch, PetscInt dim, PetscInt row)
{
  return (PetscBool)(row == MPM_PAIR_WATER ? patch->through > 0. : row < dim);
}

/* k'/k of a patch. */
PetscReal MpmPairAlong(const MpmPairContacts *contacts, const MpmPairPatch *patch);
/* Force of its geostatic state on the first body, N. */
void MpmPairRestForce(const MpmPairContacts *contacts, const MpmPairPatch *patch, PetscInt dim, PetscReal force[]);
/* By how much a patch gives. */
PetscReal MpmPairGiving(const MpmPairContacts *contacts, const MpmPairPatch *patch);
/* sum_i w_i u_i of the first side less that of the second; MPM_PAIR_ROWS numbers. */
void MpmPairRelative(const MpmPairContacts *contacts, const MpmPairPatch *patch, const MpmSum *sum, const PetscReal u[],
                     PetscReal w[]);
void MpmPairEvaluate(const MpmPairContacts *contacts, const MpmPairPatch *patch, PetscInt dim, const PetscReal w[],
                     MpmPairAnswer *answer);
