/*
  Limits of what a scene's water can be: heave, pressures that no water bears, water without effect, closed pores.
*/
#include <string.h>
#include "geometry/geometry.h"
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/sum.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "loads/water_table.h"
#include "problem/discretization.h"
#include "query/model.h"
#include "step/water_state.h"

/* ---- heave ---- */

/*
  Hydraulic heave: rising water lifts ground without cohesion.

  Above the critical gradient level ground has no equilibrium. Where its effective stress has gone the ground opens, and
  the material above is lifted until the way of the water is so long that its gradient is critical again. The ground is
  then a suspension of grains, for which no law of a skeleton is valid. Ground at a point is open where

    |sigma'| <= 1e-6 p ,    J > 1.02 ,    -dp/dz > gamma_w (water rises) ,

  and it heaves where half of a level of cells, with a tenth of the ground above it, is open. Undrained ground that has
  just been loaded has no effective stress, either, but has not expanded; ground that opens beside a wall or at a
  slope's toe leaves most of its level. Source: Terzaghi (1943), Theoretical Soil Mechanics, doi:10.1002/9780470172766.
*/
#define NO_STRESS 1e-6 /* of the water's pressure */
#define PARTED    0.02 /* expansion */
#define ALONG     1e-6 /* of gravity may be across its axis */
#define LEVEL     0.5  /* of a level's volume */
#define LIFTED    0.1  /* of all */

/* Which way is up: an axis and a sense, and the weight of the water, N/m3; PETSC_FALSE where no axis is. */
static PetscBool FindUp(const MpmModel model, PetscInt *axis, PetscReal *up, PetscReal *weight)
{
  const PetscReal *gravity = model->disc.sum->step.gravity;
  PetscReal        across  = 0.;

  *axis = 0;
  for (PetscInt a = 1; a < model->disc.dim; a++)
    if (PetscAbsReal(gravity[a]) > PetscAbsReal(gravity[*axis])) *axis = a;
  for (PetscInt a = 0; a < model->disc.dim; a++)
    if (a != *axis) across += PetscAbsReal(gravity[a]);
  *up = gravity[*axis] > 0. ? -1. : 1.;
  *weight =
    PetscAbsReal(gravity[*axis]) * model->scene.materials->at[0].physics_parameter[model->disc.layout->own.taken_up];
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

/* Volumes of the ground in each level of cells, and of its open ground, `levels` values each. */
static PetscErrorCode SumLevels(MpmModel model, PetscInt axis, PetscReal up, PetscReal weight, PetscReal volume[])
{
  const PetscInt dim = model->disc.dim, rates = model->disc.layout->rate.count, levels = model->disc.grid->cells[axis];
  const PetscInt size = model->state.particles->stress_size;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscReal ratio = MpmPointVolumeRatio(&model->scene.materials->at[points.material[p]], MpmPointF(&points, p));
    const PetscReal rise  = -up * points.physics.value_gradient[p * rates * dim + axis] - weight;
    PetscInt        cell[MPM_MAX_DIM];

    MpmGridFindCell(model->disc.grid, &points.x[p * dim], cell);
    volume[cell[axis]] += points.volume0[p] * ratio;
    if (HasParted(size, &points.stress[p * size], points.physics.value[p * rates], rise, ratio))
      volume[levels + cell[axis]] += points.volume0[p] * ratio;
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, volume, (PetscMPIInt)(2 * levels), MPIU_REAL, MPIU_SUM, model->disc.grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterFindHeave(MpmModel model, MpmOutcome *outcome)
{
  const MpmGrid *grid = model->disc.grid;
  PetscInt       axis, levels;
  PetscReal      up, weight, *volume, above = 0., all = 0.;

  PetscFunctionBeginUser;
  if (MpmPressureComponent(model->disc.layout) < 0 || model->disc.layout->own.taken_up < 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!FindUp(model, &axis, &up, &weight)) PetscFunctionReturn(PETSC_SUCCESS);
  levels = grid->cells[axis];
  PetscCall(PetscCalloc1((2 * levels), &volume));
  PetscCall(SumLevels(model, axis, up, weight, volume));
  for (PetscInt k = 0; k < levels; k++) all += volume[k];
  for (PetscInt i = 0; i < levels && !outcome->code; i++) { /* from above */
    const PetscInt k = up > 0. ? levels - 1 - i : i;

    if (above > LIFTED * all && volume[levels + k] > LEVEL * volume[k]) {
      PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                               "the ground heaves: water that rises has left no effective stress %g m up axis %c",
                               (double)(grid->lower[axis] + ((PetscReal)k + 0.5) * grid->h[axis]), "xyz"[axis]));
    }
    above += volume[k];
  }
  PetscCall(PetscFree(volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pressures that no water bears, and closed pores ---- */

#define BOILS  (-100e3) /* Pa; water under the air's pressure parts below it */
#define CLOSED 0.01     /* porosity */

/* The value of `least` over all ranks, with the place that goes with it, `dim` numbers behind it. */
static PetscErrorCode FindLeast(MpmModel model, PetscReal least[1 + MPM_MAX_DIM])
{
  PetscReal lowest = least[0];
  PetscInt  rank   = model->rank;

  PetscFunctionBeginUser;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &lowest, 1, MPIU_REAL, MPIU_MIN, model->comm));
  if (least[0] > lowest) rank = model->size;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &rank, 1, MPIU_INT, MPI_MIN, model->comm));
  if (rank < model->size) PetscCallMPI(MPI_Bcast(least, 1 + MPM_MAX_DIM, MPIU_REAL, (PetscMPIInt)rank, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void PlaceText(const MpmModel model, const PetscReal x[], char text[MPM_WATER_TEXT])
{
  char third[32] = "";

  if (model->disc.dim > 2) (void)PetscSNPrintf(third, sizeof(third), ", %.4g", (double)x[2]);
  (void)PetscSNPrintf(text, MPM_WATER_TEXT, "(%.4g, %.4g%s)", (double)x[0], (double)x[1], third);
}

PetscErrorCode MpmWaterFindTension(MpmModel model, char text[MPM_WATER_TEXT])
{
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];
  const PetscInt  dim = model->disc.dim, rates = model->disc.layout->rate.count;
  PetscReal       least[1 + MPM_MAX_DIM] = {PETSC_INFINITY};
  char            place[MPM_WATER_TEXT];
  MpmPoints       points;

  PetscFunctionBeginUser;
  text[0] = '\0';
  if (MpmPressureComponent(model->disc.layout) < 0 || model->disc.layout->own.taken_up < 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (model->state.scheme.water.boiled > model->state.stage) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    if (points.physics.value[p * rates] >= least[0]) continue;
    least[0] = points.physics.value[p * rates];
    for (PetscInt a = 0; a < dim; a++) least[1 + a] = points.x[p * dim + a];
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(FindLeast(model, least));
  if (!(least[0] < BOILS)) PetscFunctionReturn(PETSC_SUCCESS);
  model->state.scheme.water.boiled = model->state.stage + 1;
  PlaceText(model, &least[1], place);
  PetscCall(PetscSNPrintf(text, MPM_WATER_TEXT,
                          "pore pressure %.4g kPa at %s%s%s: water boils below about -100 kPa; ground that drains in "
                          "a stage has `drained: true`",
                          (double)(1e-3 * least[0]), place, stage->name ? ", stage " : "",
                          stage->name ? stage->name : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Part of a load's water that goes to points above the level. Collective. */
static PetscErrorCode FindDryPart(MpmModel model, const MpmLoad *load, PetscReal *part)
{
  const PetscInt dim    = model->disc.dim;
  PetscReal      sum[2] = {0., 0.}, *share; /* dry, all */
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(MpmParticlesGetField(model->state.particles, load->share_field, &share));
  for (PetscInt p = 0; p < points.count; p++) {
    sum[1] += share[p];
    if (MpmWaterTableDepth(model->scene.water, model->state.time, &points.x[p * dim]) < 0.) sum[0] += share[p];
  }
  PetscCall(MpmParticlesRestoreField(model->state.particles, &share));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, model->comm));
  *part = sum[1] > 0. ? sum[0] / sum[1] : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether a level moves in ground that holds water above it, and reaches no drained face. */
static PetscBool MovesNothing(const MpmModel model)
{
  const MpmWaterTable *table = model->scene.water;
  PetscReal            least, most;

  if (!table->there || !table->suction) return PETSC_FALSE;
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++)
    if (model->scene.surfaces->at[k].drained) return PETSC_FALSE;
  MpmRampBounds(table->ramp, &least, &most);
  return (PetscBool)(most > least);
}

PetscErrorCode MpmWaterFindLost(MpmModel model, char text[MPM_WATER_TEXT])
{
  const MpmLoads *loads = model->scene.loads;
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];

  PetscFunctionBeginUser;
  text[0] = '\0';
  if (!model->state.scheme.water.lost && MovesNothing(model)) {
    model->state.scheme.water.lost = model->state.stage + 1;
    PetscCall(PetscSNPrintf(text, MPM_WATER_TEXT,
                            "water level: with -mpm_water_above suction it moves at drained faces alone, and there is "
                            "none"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!model->scene.water->there || model->scene.water->suction) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt l = 0; l < loads->count && model->state.scheme.water.lost <= model->state.stage; l++) {
    PetscReal part;

    if (loads->at[l].type != MPM_LOAD_FLUX || !stage->loads[l]) continue;
    PetscCall(FindDryPart(model, &loads->at[l], &part));
    if (!(part > 0.)) continue;
    model->state.scheme.water.lost = model->state.stage + 1;
    PetscCall(PetscSNPrintf(text, MPM_WATER_TEXT,
                            "load %s: %.3g %% of its water goes into ground above the level, which stays dry; "
                            "-mpm_water_above suction has water there",
                            loads->at[l].name, (double)(100. * part)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the porosity stands among the physics' own states; PETSC_FALSE where there is none. */
static PetscBool FindPorosity(const MpmModel model, PetscInt *first)
{
  const MpmPhysics *physics = &model->scene.physics;

  *first = 0;
  for (size_t k = 0; k < (size_t)physics->state_count; k++) {
    const MpmStateVariable *variable = &physics->states[k];

    if (!strcmp(variable->name, "porosity")) return PETSC_TRUE;
    *first += MpmStateComponents(variable, model->disc.dim);
  }
  return PETSC_FALSE;
}

PetscErrorCode MpmWaterFindClosed(MpmModel model, MpmOutcome *outcome)
{
  const PetscInt dim = model->disc.dim, size = model->disc.layout->own.size;
  PetscReal      least[1 + MPM_MAX_DIM] = {PETSC_INFINITY};
  char           place[MPM_WATER_TEXT];
  PetscInt       first;
  MpmPoints      points;

  PetscFunctionBeginUser;
  if (MpmPressureComponent(model->disc.layout) < 0 || model->disc.layout->own.taken_up < 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (!FindPorosity(model, &first)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    if (points.physics.own[p * size + first] >= least[0]) continue;
    least[0] = points.physics.own[p * size + first];
    for (PetscInt a = 0; a < dim; a++) least[1 + a] = points.x[p * dim + a];
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(FindLeast(model, least));
  if (!(least[0] < CLOSED)) PetscFunctionReturn(PETSC_SUCCESS);
  PlaceText(model, &least[1], place);
  PetscCall(
    MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE, "pores closed at %s: porosity %.2g", place, (double)least[0]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
