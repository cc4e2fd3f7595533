/*
  The pressure of water that a scene starts from, and where it is held.

  Dry ground begins at the first row of nodes that is not below the water's level: up to there the pressure goes on as that of
  water at rest, at the row itself a cell's height of it below 0 at most; above, it is 0 and no water moves. Water at rest
  therefore stays at rest wherever the level is.
*/
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
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
  PetscInt            *body;
  MpmPoints            points;

  PetscFunctionBeginUser;
  if (MpmPressureComponent(model->disc.layout) < 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscMalloc1(points.count, &body));
  MpmBodiesOfPoints(model->scene.bodies->count, model->scene.bodies->at, &points, body);
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscReal *x        = &points.x[p * dim];
    PetscReal       *gradient = &points.value_gradient[p * rates * dim];

    if (points.id[p] < first || points.id[p] >= end) continue;
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
  PetscCall(MpmSpaceToGhosts(model->disc.space, 1, nodal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is the node where the ground is dry, from a height on? And the pressure that it then has. */
static PetscBool IsDry(const MpmModel model, PetscReal time, PetscReal from, PetscInt node, PetscReal *pressure)
{
  const MpmWaterTable *table = model->scene.water;
  PetscReal            x[MPM_MAX_DIM], slack, height;

  MpmNodePosition(&model->disc, node, x);
  slack  = MPM_TOLERANCE * model->disc.grid->h[table->axis];
  height = (PetscReal)table->up * x[table->axis];
  if (height < from - slack) return PETSC_FALSE;
  *pressure = height < from + slack ? table->weight * PetscMin(MpmWaterTableDepth(table, time, x), 0.) : 0.;
  return PETSC_TRUE;
}

PetscErrorCode MpmWaterHold(MpmModel model, PetscReal time)
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  bs = model->disc.block, c = MpmPressureComponent(model->disc.layout);
  const PetscBool all  = model->state.scheme.water_held;
  const PetscReal from = DryHeight(model, time);
  PetscReal      *nodal;

  PetscFunctionBeginUser;
  if (c < 0 || !(from < PETSC_INFINITY || all)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(space->local, &nodal));
  if (all) PetscCall(Project(model, c, nodal));
  for (PetscInt i = 0; i < space->local; i++) {
    if (MpmSpaceIsExtra(space, i) || !MpmConstraintsFree(model->disc.constraints, i * bs + c)) continue;
    if (all || IsDry(model, time, from, i, &nodal[i]))
      MpmConstraintsHold(model->disc.constraints, i * bs + c, nodal[i]);
  }
  PetscCall(PetscFree(nodal));
  PetscFunctionReturn(PETSC_SUCCESS);
}
