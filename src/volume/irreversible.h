#pragma once
/*
  Nodal values of a field with a rate that may not fall (irreversible.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/point/tables.h"
#include "assembly/terms.h"

extern const MpmTerm MpmTermIrreversible; /* ctx: MpmHeldField */

/* Places of numbers among the physics' values of a material, and the bounds of a step at the owned nodes. */
typedef struct MpmHeldField {
  PetscInt   irreversible, tolerance;
  PetscInt   dissipated; /* place of the dissipated energy among the physics' own states */
  PetscInt   start;      /* of a point's own bound, its value at the start; -1: there is none */
  PetscInt   count;      /* of nodes; 0: no material has a bound */
  PetscReal *least;      /* value at the step's start */
  PetscReal *stiffness;  /* of the spring below it, in the field's equation */
} MpmHeldField;

/*
  For a physics with the scene's words and numbers `irreversible`, whose first word is that of bounds, and
  `tolerance`, states `fracture_energy` and, if any, `damage_start`, one field with a rate and a factor of the ghost
  penalty; NULL for others.
*/
PetscErrorCode MpmHeldFieldCreate(const MpmPhysics *physics, PetscInt dim, MpmHeldField **held);
PetscErrorCode MpmHeldFieldDestroy(MpmHeldField **held);
