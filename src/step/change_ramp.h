#pragma once
/*
  A change of material by a ramp (change_ramp.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* Fields of the points: the old mass over the new less 1, and the part of the old stress that the new material does not
   bear, Pa. */
#define MPM_CHANGE_FIELDS 7
extern const char *const MpmChangeFields[MPM_CHANGE_FIELDS];
/* How many of them the scene has; 0: no stage has a ramp. */
PetscInt MpmChangeFieldCount(const MpmModel model);

/* The fields' values, and Note for one point: `mass` is the old one over the new less 1, `stress` (xx, yy, zz, xy (,
   yz, xz)) in Pa the old one less
   the new. Without a ramp in the scene they do nothing. */
PetscErrorCode MpmChangeGet(MpmModel model, PetscReal *field[]);
PetscErrorCode MpmChangeRestore(MpmModel model, PetscReal *field[]);
void           MpmChangeNote(const MpmModel model, PetscReal *const field[], PetscInt p, PetscReal mass,
                             const PetscReal stress[]);

/* Adds their remainder at a time, N at the local nodes, `block` components each. */
PetscErrorCode MpmChangeAdd(MpmModel model, PetscReal time, PetscReal force[]);
