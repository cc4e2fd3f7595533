#pragma once
/*
  PC type `cells`: Jacobi, with the exact inverse in cells where stiff and soft points meet.
*/
#include "action/factored.h"
#include "levels/pc_levels.h"

/* Makes the type known to PETSc. */
PetscErrorCode MpmPatchesRegister(void);
/*
  MpmPatchesCompose - find the cells of matrix A whose tangents differ much, and keep their inverses with it

  Input Parameters:
+ step     - of the levels
. factored - the points' tangents
- A        - the Jacobian of both, with a new state; preconditioners of type `cells` take the inverses from it
*/
PetscErrorCode MpmPatchesCompose(const MpmLevelsStep *step, const MpmFactored *factored, Mat A);
