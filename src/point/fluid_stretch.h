#pragma once
/*
  Fluids, which have no memory of shear, in explicit steps.
*/
#include "base/base.h"
#include "base/types.h"

/* These materials where a fluid is among them, otherwise NULL. */
const MpmMaterial *MpmFluidsAmong(const MpmMaterial *materials, PetscInt count);
/*
  Stretch along the axes of the domain of a point whose material is number m of these, or NULL where none flows, from F,
  dim x dim, and the function for the diagonal of U: of fluids as in fluid_stretch.c, of others that diagonal. Non-zero
  where there is none.
*/
int MpmDomainStretch(const MpmMaterial *fluids, PetscInt m, MpmStretch stretch, PetscInt dim, const PetscReal F[],
                     PetscReal diagonal[]);
