/*
  Stress along a line, from the points beside it.

  At each place x a linear function is fitted to the stresses of the points within 1.5 cells, with their volumes and
  the distance as weights:

    sum_p w_p |sigma_0 + g (x_p - x) - sigma_p|^2 -> min ,   w_p = V_p prod_a (1 - |x_p - x|_a/(1.5 h_a))

  so that a linear field comes out exactly, at the edge of the material, too, where points stand on one side only. Where
  they stand on one line or in one place the gradient across has no part. A place with no point nearer than the size of
  one is not in the material.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "selection/selection.h"
#include "observe/profile.h"

#define SUPPORT 1.5  /* cells to each side */
#define LEAST   1e-8 /* added to the diagonal of the gradient's equations, over the sum of the weights */

PetscErrorCode MpmProfileDestroy(MpmProfile *profile)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(profile->name));
  PetscCall(PetscFree(profile->chosen_field));
  PetscCall(PetscFree(profile->stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmProfileSelect(MpmProfile *profile, const MpmBodies *bodies, MpmParticles *particles)
{
  PetscInt64 chosen;

  PetscFunctionBeginUser;
  if (!profile->chosen_field) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPointsChoose(bodies, profile->body, NULL, profile->chosen_field, particles, &chosen));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- places ---- */

void MpmProfilePlace(const MpmProfile *profile, PetscInt dim, PetscInt k, PetscReal x[])
{
  const PetscReal part = (PetscReal)k / (PetscReal)(profile->count - 1);

  for (PetscInt a = 0; a < dim; a++) x[a] = (1. - part) * profile->first[a] + part * profile->last[a];
}

void MpmProfileTraction(const MpmProfile *profile, PetscInt dim, PetscInt k, PetscReal traction[])
{
  static const PetscInt plane[] = {0, 3, 3, 1}, solid[] = {0, 3, 5, 3, 1, 4, 5, 4, 2};
  const PetscReal      *stress = &profile->stress[k * profile->size];

  for (PetscInt t = 0; t < dim; t++) {
    traction[t] = 0.;
    for (PetscInt i = 0; i < dim * dim; i++)
      traction[t] += profile->axis[t][i / dim] * stress[dim == 2 ? plane[i] : solid[i]] * profile->axis[0][i % dim];
  }
}

/* ---- the fit ---- */

#define TERMS (MPM_MAX_DIM + 1) /* of a linear function */
#define MOST  6                 /* components of a stress */

/* Normal equations of one place: weights times products of (1, d), and times stresses; and the number of nearby
   points. */
typedef struct {
  PetscReal matrix[TERMS * TERMS], stress[TERMS * MOST], next;
} Fit;

static void AddPoint(const MpmGrid *grid, const PetscReal x[], const MpmPoints *points, PetscInt p, PetscInt size,
                     Fit *fit)
{
  const PetscInt  dim      = grid->dim;
  const PetscReal volume   = points->volume0[p] * MpmPointJ(points, p);
  const PetscReal side     = PetscPowReal(MpmPointExtent(points, dim, p), 1. / (PetscReal)dim);
  PetscReal       d[TERMS] = {1.}, weight = volume, far = 0.;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal way = points->x[p * dim + a] - x[a];

    d[1 + a] = way / (SUPPORT * grid->h[a]);
    if (PetscAbsReal(d[1 + a]) >= 1.) return;
    weight *= 1. - PetscAbsReal(d[1 + a]);
    far = PetscMax(far, PetscAbsReal(way));
  }
  fit->next += far <= side;
  for (PetscInt i = 0; i <= dim; i++) {
    for (PetscInt j = 0; j <= dim; j++) fit->matrix[i * TERMS + j] += weight * d[i] * d[j];
    for (PetscInt c = 0; c < size; c++) fit->stress[i * MOST + c] += weight * d[i] * points->stress[p * size + c];
  }
}

/* The fit's value at its place: Gauss elimination that ends with the constant, which is the first unknown. */
static void Solve(PetscInt dim, PetscInt size, Fit *fit, PetscReal value[])
{
  const PetscReal weight = fit->matrix[0];

  for (PetscInt c = 0; c < size; c++) value[c] = NAN;
  if (!(weight > 0. && fit->next > 0.)) return;
  for (PetscInt i = dim; i > 0; i--) {
    PetscReal pivot;

    fit->matrix[i * TERMS + i] += LEAST * weight;
    pivot = fit->matrix[i * TERMS + i];
    for (PetscInt r = 0; r < i; r++) {
      const PetscReal factor = fit->matrix[r * TERMS + i] / pivot;

      for (PetscInt j = 0; j < i; j++) fit->matrix[r * TERMS + j] -= factor * fit->matrix[i * TERMS + j];
      for (PetscInt c = 0; c < size; c++) fit->stress[r * MOST + c] -= factor * fit->stress[i * MOST + c];
    }
  }
  /* the constant's equation is nearly singular where the points stand on one side in one row: then their mean */
  for (PetscInt c = 0; c < size; c++) value[c] = fit->stress[c] / fit->matrix[0];
}

/* The places that a point may reach: those whose part of the line lies within the support. */
static void FindReach(const MpmProfile *profile, const MpmGrid *grid, const PetscReal x[], PetscInt *begin,
                      PetscInt *end)
{
  PetscReal low = 0., high = 1.;

  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal way = profile->last[a] - profile->first[a], reach = SUPPORT * grid->h[a];
    const PetscReal one = (x[a] - reach - profile->first[a]) / way, two = (x[a] + reach - profile->first[a]) / way;

    if (way == 0.) {
      if (PetscAbsReal(x[a] - profile->first[a]) >= reach) high = -1.;
      continue;
    }
    low  = PetscMax(low, PetscMin(one, two));
    high = PetscMin(high, PetscMax(one, two));
  }
  *begin = *end = 0;
  if (!(low <= high)) return;
  *begin = (PetscInt)PetscFloorReal(low * (PetscReal)(profile->count - 1));
  *end   = PetscMin((PetscInt)PetscCeilReal(high * (PetscReal)(profile->count - 1)) + 1, profile->count);
}

PetscErrorCode MpmProfileEvaluate(MpmProfile *profile, const MpmGrid *grid, MpmParticles *particles)
{
  const PetscInt dim    = grid->dim;
  PetscReal     *chosen = NULL, x[MPM_MAX_DIM];
  Fit           *fits;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(profile->count, &fits));
  PetscCall(MpmParticlesGetArrays(particles, &points));
  if (profile->chosen_field) PetscCall(MpmParticlesGetField(particles, profile->chosen_field, &chosen));
  for (PetscInt p = 0; p < points.count; p++) {
    PetscInt begin, end;

    if (chosen && chosen[p] == 0.) continue;
    FindReach(profile, grid, &points.x[p * dim], &begin, &end);
    for (PetscInt k = begin; k < end; k++) {
      MpmProfilePlace(profile, dim, k, x);
      AddPoint(grid, x, &points, p, profile->size, &fits[k]);
    }
  }
  if (chosen) PetscCall(MpmParticlesRestoreField(particles, &chosen));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, fits,
                           (PetscMPIInt)(profile->count * (PetscInt)(sizeof(Fit) / sizeof(PetscReal))), MPIU_REAL,
                           MPIU_SUM, grid->comm));
  for (PetscInt k = 0; k < profile->count; k++)
    Solve(dim, profile->size, &fits[k], &profile->stress[k * profile->size]);
  PetscCall(PetscFree(fits));
  PetscFunctionReturn(PETSC_SUCCESS);
}
