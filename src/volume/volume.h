#pragma once
/*
  Terms of the material's volume without an object of their own.
*/
#include "assembly/terms.h"

extern const MpmTerm MpmTermWaterWeight; /* water taken up by points, where the physics has it (water_weight.c) */
/* J at the increment dF of point p's F, with its derivatives by dF and, unless NULL, by F at the step's start. */
PetscReal MpmWaterVolume(const MpmSum *sum, PetscInt p, const PetscReal dF[], PetscReal by[], PetscReal by_F[]);

extern const MpmTerm MpmTermGhost; /* the ghost penalty (ghost_penalty.c) */
/*
  The ghost penalty with rho h^2 in place of E_s, h the size of cells along the normal, beside a consistent mass: y += G
  a, and its diagonal, dim values a local node; each rank has its part. kg.
*/
PetscErrorCode MpmGhostMass(const MpmSum *sum, const PetscReal a[], PetscReal y[]);
PetscErrorCode MpmGhostMassDiagonal(const MpmSum *sum, PetscReal diagonal[]);
