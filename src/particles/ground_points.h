#pragma once
/*
  Points and bodies in fields of the scene's numbers.
*/
#include "base/base.h"
#include "base/types.h"

/* Tells fields by body and by point the ids of the bodies' points, `room` from one to the next. Collective. */
PetscErrorCode MpmBodiesSetGrounds(PetscInt count, const MpmBody bodies[], const MpmMaterial *materials, PetscInt room);
/*
  Refuses points of bodies that are or become of a material, marked in `of`, where a field of the material has no value,
  or one that the law does not take. Collective.
*/
PetscErrorCode MpmGroundCheckPoints(const MpmMaterial *material, const PetscBool of[], const MpmBodies *bodies,
                                    const MpmPoints *points, PetscInt dim, MPI_Comm comm);
