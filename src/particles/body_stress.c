/*
  A uniform initial Cauchy stress of a body's points: history that gives it, or of laws without history a deformation
  (stress_inversion.c). Volume, domain and mass are as drawn.
*/
#include "point/material.h"
#include "point/registry.h"
#include "point/stress_inversion.h"
#include "particles/body_stress.h"
#include "particles/point_mass.h"
#include "particles/points.h"

/* Returns MpmInitialFind()'s result. */
static int SetStress(const MpmInitial *initial, MpmStretch stretch, const PetscReal stress[], PetscInt p,
                     MpmPoints *points, PetscReal state_n[])
{
  const PetscInt dim = initial->model_dim, size = MpmSymSize(dim);
  PetscReal     *sigma = &points->stress[p * size], *F = MpmPointF(points, p), U[MPM_MAX_DIM];
  PetscReal      state[MPM_INITIAL_STATE];
  int            answer;

  for (PetscInt c = 0; c < size; c++) sigma[c] = stress[c];
  answer = MpmInitialFind(initial, state_n, sigma, F, state, points->across ? &points->across[p] : NULL);
  if (answer) return answer;
  for (PetscInt k = 0; k < initial->material->state_size; k++) state_n[k] = state[k];
  if (stretch(F, U)) return 2;
  points->volume0[p] /= MpmPointJ(points, p);
  for (PetscInt a = 0; points->domain.half_length && a < dim; a++) points->domain.half_length[p * dim + a] /= U[a];
  return 0;
}

PetscErrorCode MpmBodyStressFill(const MpmMaterial *material, PetscInt dim, const PetscReal stress[],
                                 PetscInt state_size, const PetscInt range[2], MpmPoints *points, int *worst)
{
  const MpmStretch stretch = MpmStretchFind(dim);
  PetscReal        none[MPM_INITIAL_STATE];
  MpmInitial       initial;

  PetscFunctionBeginUser;
  PetscCall(MpmInitialCreate(material, dim, &initial));
  for (PetscInt p = range[0]; p < range[1]; p++) {
    int answer;

    initial.own = MpmPointOwn(points, material, p);
    answer      = SetStress(&initial, stretch, stress, p, points, state_size ? &points->state[p * state_size] : none);
    if (answer > *worst) *worst = answer;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
