#pragma once
/*
  The potential whose derivative a step's residual is (potential.c).
*/
#include "base/base.h"
#include "base/types.h"

/* True where the discrete problem has a potential, as set up: by laws, physics and terms, without later additions of
   stages. */
PetscBool MpmPotentialExists(const MpmDiscretization *disc);
/*
  At the displacement disc->nodal.u of all local nodes, ghosts included: its value, J, and the sum of the magnitudes of
  its terms, a measure of its rounding; the trial becomes that of u. `failed` as for MpmTermsResidual(), summed over all
  ranks; value and size are then meaningless. Collective.
*/
PetscErrorCode MpmPotentialEvaluate(MpmDiscretization *disc, PetscReal *value, PetscReal *size, PetscInt *failed);
