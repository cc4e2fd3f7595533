/*
  The pressure of water that a scene starts from, and where it is held.

  Dry ground begins at the first row of nodes that is not below the water's level: up to there the pressure goes on as that of
  water at rest, at the row itself a cell's height of it below 0 at most; above, it is 0 and no water moves. Water at rest
  therefore stays at rest wherever the level is.
*/
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "terms/body_surface.h"
#include "terms/discretization.h"
#include "terms/water_table.h"
#include "time/model.h"
#include "time/water_state.h"

PetscErrorCode MpmWaterRead(MpmModel model, const MpmOptions *options)
{
  const MpmLayout *layout = model->disc.layout;
  PetscReal        bounds[2 * MPM_MAX_DIM];

  PetscFunctionBeginUser;
  if (MpmPressureComponent(layout) < 0 || layout->taken_up < 0) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt b = 0; b < model->scene.bodies->count; b++)
    PetscCall(MpmBodyReadPressure(options, model->scene.bodies->names[b], model->scene.bodies->at[b]));
  model->scene.water->weight = model->scene.materials->at[0].physics_parameter[layout->taken_up];
  for (PetscInt a = 0; a < model->disc.dim; a++) {
    bounds[a]               = model->disc.grid->lower[a];
    bounds[MPM_MAX_DIM + a] = model->disc.grid->upper[a];
  }
  PetscCall(MpmWaterTableCreate(options, model->disc.dim, bounds, model->scene.loads, model->scene.water));
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++) /* the load of open water follows its face */
    if (model->scene.water->there && model->scene.surfaces->at[k].drained) model->solver.symmetric = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The height of the row of nodes where dry ground begins; infinite where there is none. */
static PetscReal DryHeight(const MpmModel model, PetscReal time)
{
  const MpmWaterTable *table               = model->scene.water;
  const MpmGrid       *grid                = model->disc.grid;
  const PetscReal      origin[MPM_MAX_DIM] = {0., 0., 0.};
  PetscReal            level, base, h;

  if (!table->there || table->suction) return PETSC_INFINITY;
  level = MpmWaterTableDepth(table, time, origin);
  base  = table->up > 0 ? grid->lower[table->axis] : -grid->upper[table->axis];
  h     = grid->h[table->axis];
  return base + h * PetscCeilReal((level - base) / h - MPM_TOLERANCE);
}

PetscErrorCode MpmWaterFill(MpmModel model, PetscInt first, PetscInt end)
{
  const MpmWaterTable *table = model->scene.water;
  const PetscInt       dim = model->disc.dim, rates = model->disc.layout->rates;
  const PetscReal      dry = DryHeight(model, model->state.time);
  const char          *pressure;
  PetscInt            *body;
  MpmPoints            points;

  PetscFunctionBeginUser;
  if (MpmPressureComponent(model->disc.layout) < 0) PetscFunctionReturn(PETSC_SUCCESS);
  pressure = model->disc.layout->component_name[MpmPressureComponent(model->disc.layout)];
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscMalloc1(points.count, &body));
  MpmBodiesOfPoints(model->scene.bodies->count, model->scene.bodies->at, &points, body);
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscReal *x        = &points.x[p * dim];
    PetscReal       *gradient = &points.value_gradient[p * rates * dim];

    if (points.id[p] < first || points.id[p] >= end) continue;
    if (end < PETSC_MAX_INT && MpmBodyFilePressure(model->scene.bodies->at[body[p]], pressure)) continue; /* its own */
    points.value[p * rates] = MpmBodyPressure(model->scene.bodies->at[body[p]]);
    for (PetscInt a = 0; a < dim; a++) gradient[a] = 0.;
    if (!table->there || (PetscReal)table->up * x[table->axis] >= dry) continue;
    points.value[p * rates] += table->weight * MpmWaterTableDepth(table, model->state.time, x);
    gradient[table->axis] = -(PetscReal)table->up * table->weight;
  }
  PetscCall(PetscFree(body));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmDryGround MpmWaterDry(const MpmModel model, PetscReal time)
{
  const PetscReal from = DryHeight(model, time);

  if (from == PETSC_INFINITY) return (MpmDryGround){.any = PETSC_FALSE};
  return (MpmDryGround){PETSC_TRUE, model->scene.water->axis, model->scene.water->up, from};
}

/* The points' pressures at the local nodes. */
static PetscErrorCode Project(MpmModel model, PetscInt c, PetscReal nodal[])
{
  const MpmLayout     *layout = model->disc.layout;
  const MpmPointValues values = {layout->shape_of[c],
                                 1,
                                 layout->rates,
                                 model->disc.points->value,
                                 model->disc.points->value_gradient,
                                 layout->rates * model->disc.dim};

  PetscFunctionBeginUser;
  PetscCall(MpmProjectToNodes(model->disc.sum, &values, nodal));
  PetscCall(MpmNodesToGhosts(&model->disc, 1, nodal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Is there dry ground: does a point stand above `from`? Asked for splines, which smooth the corner that the pressure has there and
  need not where the ground ends below it. Collective.
*/
static PetscErrorCode FindDryGround(const MpmModel model, PetscReal from, PetscBool *any)
{
  const MpmWaterTable *table = model->scene.water;
  const PetscInt       dim   = model->disc.dim;

  PetscFunctionBeginUser;
  *any = (PetscBool)(MpmShapeDegree(model->scene.shape) < 2);
  for (PetscInt p = 0; !*any && p < model->disc.points->count; p++)
    *any = (PetscBool)((PetscReal)table->up * model->disc.points->x[p * dim + table->axis] > from);
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, any, 1, MPM_MPI_BOOL, MPI_LOR, model->disc.grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is the node where dry ground begins, at a height, or above? And its pressure: `dry` above, or that of water at rest goes on. */
static PetscBool IsDry(const MpmModel model, PetscReal time, PetscReal from, PetscBool dry, PetscInt node,
                       PetscReal *pressure)
{
  const MpmWaterTable *table = model->scene.water;
  PetscReal            x[MPM_MAX_DIM], slack, height;

  MpmNodePosition(&model->disc, node, x);
  slack  = MPM_TOLERANCE * model->disc.grid->h[table->axis];
  height = (PetscReal)table->up * x[table->axis];
  if (height < from - slack) return PETSC_FALSE;
  *pressure = !dry || height < from + slack ? table->weight * PetscMin(MpmWaterTableDepth(table, time, x), 0.) : 0.;
  return PETSC_TRUE;
}

PetscErrorCode MpmWaterHold(MpmModel model, PetscReal time)
{
  const PetscInt count = MpmNodesLocal(&model->disc), bs = model->disc.block,
                 c     = MpmPressureComponent(model->disc.layout);
  const PetscBool all  = model->state.scheme.water_held;
  const PetscReal from = DryHeight(model, time);
  PetscBool       dry  = PETSC_TRUE;
  PetscReal      *nodal;

  PetscFunctionBeginUser;
  if (c < 0 || !(from < PETSC_INFINITY || all)) PetscFunctionReturn(PETSC_SUCCESS);
  if (from < PETSC_INFINITY) PetscCall(FindDryGround(model, from, &dry));
  PetscCall(PetscCalloc1(count, &nodal));
  if (all) PetscCall(Project(model, c, nodal));
  for (PetscInt i = 0; i < count; i++) {
    if (!MpmNodeInGrid(&model->disc, i) || !MpmConstraintsFree(model->disc.constraints, i * bs + c)) continue;
    if (all || IsDry(model, time, from, dry, i, &nodal[i]))
      MpmConstraintsHold(model->disc.constraints, i * bs + c, nodal[i]);
  }
  PetscCall(PetscFree(nodal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- heave ---- */

/*
  Hydraulic heave: rising water lifts ground without cohesion.

  Above the critical gradient level ground has no equilibrium. It parts where its effective stress has gone, and what lies above is
  lifted until the way of the water has become so long that its gradient is critical again: a suspension of grains, for which no law
  of a skeleton holds. Ground at a point has parted where

    |sigma'| <= 1e-6 p ,    J > 1.02 ,    -dp/dz > gamma_w (water rises) ,

  and it heaves where half of a level of cells has parted that a tenth of the ground lies above. Ground that has just been
  loaded and keeps its water has no effective stress, either, but has not expanded; ground that parts beside a wall or at a
  slope's toe leaves most of its level.
  Source: Terzaghi (1943), Theoretical Soil Mechanics, doi:10.1002/9780470172766.
*/
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
