#pragma once
/*
  The law of a stress point over a step, shared by its steps and their derivatives.
*/
#include "laboratory/stress_point.h"

/* A step of the law: start and result, n x n. */
typedef struct {
  PetscReal F_n[9], F_n_inverse[9]; /* in all; and of the stretch since the start */
  PetscReal dF[9], H[9];
} MpmPointIncrement;

/* The increment from the state now to the deformation F since the start; PETSC_FALSE where it turns inside out. */
PetscBool      MpmPointIncrementFind(const MpmStressPoint *point, const PetscReal F[9], MpmPointIncrement *increment);
MpmKernelPoint MpmPointKernel(const MpmStressPoint *point, const MpmPointIncrement *increment);
PetscBool      MpmPointIsSmallStrain(const MpmStressPoint *point);

/* C = A B, n x n; A^{-1} for det A not 0; the block of a 3 x 3 matrix that the model's dimension has. */
void MpmMatrixMultiply(PetscInt n, const PetscReal A[], const PetscReal B[], PetscReal C[]);
void MpmMatrixInvert(PetscInt n, const PetscReal A[], PetscReal inverse[]);
void MpmMatrixBlock(PetscInt n, const PetscReal full[9], PetscReal block[]);
