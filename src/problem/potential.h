#pragma once
/*
  The potential whose derivative a step's residual is (potential.c).
*/
#include "base/base.h"
#include "base/types.h"

/* Has the discrete problem one, as it has been set up? Laws, physics and terms decide; not what the scene's stages add to the terms. */
PetscBool MpmPotentialExists(const MpmDiscretization *disc);
/*
  At the displacement disc->u of all local nodes, ghosts included: its value, J, and the sum of the sizes of its parts, which tells its
  rounding; the trial becomes that of u. `failed` as for MpmTermsResidual(), summed over all ranks; value and size then mean nothing.
  Collective.
*/
PetscErrorCode MpmPotentialEvaluate(MpmDiscretization *disc, PetscReal *value, PetscReal *size, PetscInt *failed);
