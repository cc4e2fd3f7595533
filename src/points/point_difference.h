#pragma once
/*
  Differences of a point's kernel.
*/
#include "point/layout.h"

/* The derivative of a point's fluxes along dinput, by central differences; f: flux of the mean at the point. */
int MpmPointDifference(const MpmLayout *layout, const MpmKernelPoint *point, const PetscReal input[],
                       const PetscReal dinput[], PetscReal f, PetscReal dflux[]);
