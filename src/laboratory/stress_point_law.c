/*
  The law of a stress point over a step: its increment, from the state at the step's start.
*/
#include "point/material.h"
#include "laboratory/stress_point_impl.h"

PetscBool MpmPointIsSmallStrain(const MpmStressPoint *point)
{
  return (PetscBool)((point->material->info.traits & MPM_LAW_SMALL_STRAIN) != 0);
}

void MpmMatrixMultiply(PetscInt n, const PetscReal A[], const PetscReal B[], PetscReal C[])
{
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt j = 0; j < n; j++) {
      C[i * n + j] = 0.;
      for (PetscInt k = 0; k < n; k++) C[i * n + j] += A[i * n + k] * B[k * n + j];
    }
  }
}

void MpmMatrixInvert(PetscInt n, const PetscReal A[], PetscReal inverse[])
{
  PetscReal       cofactor[9];
  const PetscReal J = MpmCofactors(n * n, A, cofactor);

  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++) inverse[i * n + j] = cofactor[j * n + i] / J;
}

void MpmMatrixBlock(PetscInt n, const PetscReal full[9], PetscReal block[])
{
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++) block[i * n + j] = full[3 * i + j];
}

PetscBool MpmPointIncrementFind(const MpmStressPoint *point, const PetscReal F[9], MpmPointIncrement *increment)
{
  const PetscInt n        = point->dim;
  PetscReal      start[9] = {0.}, now[9] = {0.}, next[9] = {0.};

  MpmMatrixBlock(n, F, next);
  MpmMatrixBlock(n, point->now.F, now);
  MpmMatrixBlock(n, point->F_start, start);
  MpmMatrixMultiply(n, now, start, increment->F_n);
  MpmMatrixInvert(n, now, increment->F_n_inverse);
  MpmMatrixMultiply(n, next, increment->F_n_inverse, increment->dF);
  for (PetscInt k = 0; k < n * n; k++) increment->H[k] = increment->dF[k] - (k % (n + 1) ? 0. : 1.);
  return (PetscBool)(MpmDeterminant(n * n, next) > 0.);
}

MpmKernelPoint MpmPointKernel(const MpmStressPoint *point, const MpmPointIncrement *increment)
{
  return (MpmKernelPoint){.material.parameter = point->material->parameter,
                          .state_n            = point->now.history,
                          .F_n                = increment->F_n,
                          .volume0            = 1.,
                          .dt                 = point->dt,
                          .material.traits    = point->material->info.traits,
                          .material.law       = point->material->law,
                          .material.table     = point->material->table};
}
