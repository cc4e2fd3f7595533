/*
  Hydraulic heave: rising water lifts ground without cohesion.

  Above the critical gradient level ground has no equilibrium. It parts where its effective stress has gone, and what lies above is
  lifted until the way of the water has become so long that its gradient is critical again: a suspension of grains, for which no law
  of a skeleton holds. Ground at a point has parted where

    |sigma'| <= 1e-6 p ,    J > 1.02 ,    -dp/dz > gamma_w (water rises) ,

  and it heaves where half of a level of cells has parted that a tenth of the ground lies above. Ground that has just been loaded and keeps its water
  has no effective stress, either, but has not expanded; ground that parts beside a wall or at a slope's toe leaves most of its level.
  Source: Terzaghi (1943), Theoretical Soil Mechanics, doi:10.1002/9780470172766.
*/
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/sum.h"
#include "terms/discretization.h"
#include "time/model.h"
#include "time/water_state.h"

#define NO_STRESS 1e-6 /* of the water's pressure */
#define PARTED    0.02 /* expansion */
#define ALONG     1e-6 /* of gravity may be across its axis */
#define LEVEL     0.5  /* of a level's volume */
#define LIFTED    0.1  /* of all */

/* Which way is up: an axis and a sense, and the weight of the water, N/m3; PETSC_FALSE where no axis is. */
static PetscBool FindUp(const MpmModel model, PetscInt *axis, PetscReal *up, PetscReal *weight)
{
  const PetscReal *gravity = model->disc.sum->gravity;
  PetscReal        across  = 0.;

  *axis = 0;
  for (PetscInt a = 1; a < model->disc.dim; a++)
    if (PetscAbsReal(gravity[a]) > PetscAbsReal(gravity[*axis])) *axis = a;
  for (PetscInt a = 0; a < model->disc.dim; a++)
    if (a != *axis) across += PetscAbsReal(gravity[a]);
  *up = gravity[*axis] > 0. ? -1. : 1.;
  *weight =
    PetscAbsReal(gravity[*axis]) * model->scene.materials->at[0].physics_parameter[model->disc.layout->taken_up];
  return (PetscBool)(*weight > 0. && across <= ALONG * PetscAbsReal(gravity[*axis]));
}

static PetscBool HasParted(PetscInt stress_size, const PetscReal stress[], PetscReal pressure, PetscReal rise,
                           PetscReal ratio)
{
  if (!(pressure > 0. && rise > 0. && ratio > 1. + PARTED)) return PETSC_FALSE;
  for (PetscInt k = 0; k < stress_size; k++)
    if (PetscAbsReal(stress[k]) > NO_STRESS * pressure) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* Volumes of the ground in each level of cells, and of what of it has parted, `levels` values each. */
static PetscErrorCode SumLevels(MpmModel model, PetscInt axis, PetscReal up, PetscReal weight, PetscReal volume[])
{
  const PetscInt dim = model->disc.dim, rates = model->disc.layout->rates, levels = model->disc.grid->cells[axis];
  const PetscInt size = model->state.particles->stress_size;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscReal ratio =
      MpmPointVolumeRatio(&model->scene.materials->at[points.material[p]], dim, &points.F[p * dim * dim]);
    const PetscReal rise = -up * points.value_gradient[p * rates * dim + axis] - weight;
    PetscInt        cell[MPM_MAX_DIM];

    MpmGridFindCell(model->disc.grid, &points.x[p * dim], cell);
    volume[cell[axis]] += points.volume0[p] * ratio;
    if (HasParted(size, &points.stress[p * size], points.value[p * rates], rise, ratio))
      volume[levels + cell[axis]] += points.volume0[p] * ratio;
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, volume, (PetscMPIInt)(2 * levels), MPIU_REAL, MPIU_SUM, model->disc.grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterFindHeave(MpmModel model, const char **why)
{
  const MpmGrid *grid = model->disc.grid;
  PetscInt       axis, levels;
  PetscReal      up, weight, *volume, above = 0., all = 0.;

  PetscFunctionBeginUser;
  if (MpmPressureComponent(model->disc.layout) < 0 || model->disc.layout->taken_up < 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!FindUp(model, &axis, &up, &weight)) PetscFunctionReturn(PETSC_SUCCESS);
  levels = grid->cells[axis];
  PetscCall(PetscCalloc1((2 * levels), &volume));
  PetscCall(SumLevels(model, axis, up, weight, volume));
  for (PetscInt k = 0; k < levels; k++) all += volume[k];
  for (PetscInt i = 0; i < levels && !*why; i++) { /* from above */
    const PetscInt k = up > 0. ? levels - 1 - i : i;

    if (above > LIFTED * all && volume[levels + k] > LEVEL * volume[k]) {
      PetscCall(PetscSNPrintf(model->solver.lost, sizeof(model->solver.lost),
                              "the ground heaves: water that rises has left no effective stress %g m up axis %c",
                              (double)(grid->lower[axis] + ((PetscReal)k + 0.5) * grid->h[axis]), "xyz"[axis]));
      *why = model->solver.lost;
    }
    above += volume[k];
  }
  PetscCall(PetscFree(volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}
