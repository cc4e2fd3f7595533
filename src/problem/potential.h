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
  At the displacement u of all local nodes, ghosts included, with the trial that goes with it: its value, J, and the sum
  of the magnitudes of its terms, a measure of its rounding. Collective.
*/
PetscErrorCode MpmPotentialEvaluate(const MpmDiscretization *disc, const MpmSum *sum, const PetscReal u[],
                                    const MpmTrial *trial, PetscReal *value, PetscReal *size);
