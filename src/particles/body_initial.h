#pragma once
/*
  History that a scene gives a body's points to start with.
*/
#include "base/base.h"
#include "base/types.h"

typedef struct _p_MpmBodyInitial *MpmBodyInitial;
/* Reads -<prefix>initial_<state> for every scalar state variable of the material's law. */
PetscErrorCode MpmBodyInitialCreate(const MpmOptions *block, const MpmMaterial *material, MpmBodyInitial *initial);
PetscErrorCode MpmBodyInitialDestroy(MpmBodyInitial *initial);
/* Writes the values at a height into a point's history, and no other variables; a height without a value is noted. */
void MpmBodyInitialFill(MpmBodyInitial initial, PetscInt dim, PetscReal height, PetscReal state[]);
/* Ends the run where points were missed. Collective. */
PetscErrorCode MpmBodyInitialCheck(MpmBodyInitial initial, MPI_Comm comm);
