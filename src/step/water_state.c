/*
  The initial pressure of water, and nodes where it is prescribed.

  Water at rest. Below its level the water is at rest where p = gamma d, d the depth; dry ground above has p = 0. The
  basis functions of the grid have no such bend within a cell, and splines have none at all. A discrete pressure sum_i
  phi_i c_i stands for it, and

    g_p = -(sum_i d phi_i/dz (x_p) c_i)/gamma g

  in place of g drives the water of a point: whatever the shape, the permeability on either side and the place of the
  level between the nodes, c is at rest to rounding. Where all nodes of a point are wet g_p is g; where all are dry it
  is 0.

  The coefficients are those of p at the nodes but beside the bend, which keep the integral of the pressure: with the
  level a h above the last node j that is not above it, and splines of degree k,

    c_j = gamma h (a - (1 - a) b) ,   c_{j+1} = -gamma h (a (1 - a)/2 + a b) ,   b = (k - 1)/24 .

  a (1 - a)/2 is the error of the trapezoidal rule at a bend; b follows from the second moment (k + 1)/12 of the spline.

  Prescribed pressures. Nodes that are not below the water's level have the pressure of water at rest: in dry ground 0
  but beside the level, hydrostatic where no point stands above it.
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
#include "loads/body_surface.h"
#include "loads/water_table.h"
#include "problem/discretization.h"
#include "query/model.h"
#include "step/water_state.h"

/* ---- water at rest ---- */

/* Water at rest below its level at a time. */
typedef struct {
  const MpmWaterTable *table;
  PetscReal            time, h; /* s; of a cell up the axis, m */
  PetscReal            bend;    /* (degree of the spline - 1)/24 */
  PetscInt             count;   /* of points */
  PetscBool            dry;     /* above the level the pressure is 0; otherwise hydrostatic, negative */
} MpmStillWater;

/* Collective. Ground is dry where the scene says so and a point stands above the level. */
static PetscErrorCode FindStill(MpmModel model, PetscReal time, MpmStillWater *still)
{
  const MpmWaterTable *table = model->scene.water;
  const PetscInt       dim   = model->disc.dim;
  MpmPoints            points;

  PetscFunctionBeginUser;
  *still      = (MpmStillWater){.table = table, .time = time, .h = model->disc.grid->h[table->axis]};
  still->bend = (PetscReal)(MpmShapeDegree(model->scene.shape.type) - 1) / 24.;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  still->count = points.count;
  for (PetscInt p = 0; table->there && !table->suction && !still->dry && p < points.count; p++)
    still->dry = (PetscBool)(MpmWaterTableDepth(table, time, &points.x[p * dim]) < -MPM_TOLERANCE * still->h);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &still->dry, 1, MPM_MPI_BOOL, MPI_LOR, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The coefficient of a node at x, Pa. */
static PetscReal AtNode(const MpmStillWater *still, const PetscReal x[])
{
  const PetscReal gamma = still->table->weight, h = still->h;
  const PetscReal depth = MpmWaterTableDepth(still->table, still->time, x), a = depth / h;

  if (!still->dry || a >= 1.) return gamma * depth;
  if (a >= 0.) return gamma * h * (a - (1. - a) * still->bend);
  if (a > -1.) return gamma * h * (1. + a) * (0.5 * a - still->bend);
  return 0.;
}

/* Weights and derivatives along an axis. */
typedef struct {
  MpmShapeLine line;
  PetscReal    weight[MPM_MAX_WIDTH], gradient[MPM_MAX_WIDTH];
} Line;

static void MakeLine(const MpmModel model, PetscInt axis, PetscReal x, PetscReal half_length, Line *at)
{
  const MpmGrid  *grid = model->disc.grid;
  const PetscInt  last = grid->cells[axis];
  const PetscReal xi   = (x - grid->lower[axis]) / grid->h[axis];
  PetscReal       half = PetscMin(half_length / grid->h[axis], PetscMin(xi, (PetscReal)last - xi));

  half     = PetscMax(0., PetscMin(half, 0.5 * (PetscReal)(MPM_MAX_WIDTH - 5)));
  at->line = (MpmShapeLine){.weight = at->weight, .gradient = at->gradient};
  MpmShapeEvaluate(model->scene.shape.type,
                   MpmEdgeOf(model->scene.shape.edge, MpmShapeDegree(model->scene.shape.type), last), xi, half, 0, last,
                   &at->line);
}

/* The pressure at a point that has not moved yet, by the scene's shape, Pa, and its gradient. */
static PetscReal AtPoint(const MpmStillWater *still, const MpmModel model, const PetscReal x[],
                         const PetscReal half_length[], PetscReal gradient[])
{
  const MpmGrid *grid  = model->disc.grid;
  const PetscInt dim   = grid->dim;
  PetscInt       nodes = 1;
  PetscReal      value = 0.;
  Line           at[MPM_MAX_DIM];

  for (PetscInt a = 0; a < dim; a++) {
    MakeLine(model, a, x[a], half_length ? half_length[a] : 0., &at[a]);
    nodes *= at[a].line.count;
    gradient[a] = 0.;
  }
  for (PetscInt k = 0; k < nodes; k++) {
    PetscInt  rest = k, i[MPM_MAX_DIM];
    PetscReal y[MPM_MAX_DIM], c, weight = 1.;

    for (PetscInt a = 0; a < dim; rest /= at[a].line.count, a++) {
      i[a] = rest % at[a].line.count;
      y[a] = MpmGridNodeAt(grid, a, at[a].line.first + i[a]);
      weight *= at[a].weight[i[a]];
    }
    c = AtNode(still, y);
    value += weight * c;
    for (PetscInt b = 0; b < dim; b++) {
      PetscReal slope = at[b].gradient[i[b]] / grid->h[b];

      for (PetscInt a = 0; a < dim; a++) slope *= a == b ? 1. : at[a].weight[i[a]];
      gradient[b] += slope * c;
    }
  }
  return value;
}

/* Whether the pressure at rest is another one than the hydrostatic one, at a node. */
static PetscBool IsBent(const MpmStillWater *still, const PetscReal x[], PetscReal pressure)
{
  const PetscReal hydrostatic = still->table->weight * MpmWaterTableDepth(still->table, still->time, x);

  return (PetscBool)(PetscAbsReal(pressure - hydrostatic) > MPM_TOLERANCE * still->table->weight * still->h);
}

/* For the step's space: sum->still, the pressure at the local nodes, where that bends, and the gravity of the points'
   water. */
static PetscErrorCode SetStill(MpmModel model, const MpmStillWater *still)
{
  const MpmSum        *sum   = model->disc.sum;
  const MpmWaterTable *table = still->table;
  const PetscInt       dim = model->disc.dim, local = MpmNodesLocal(&model->disc), count = still->count;
  MpmWaterAtRest       rest = {NULL, NULL, NULL};

  PetscFunctionBeginUser;
  if (table->there) PetscCall(PetscCalloc3(local, &rest.pressure, local, &rest.bent, (count * dim), &rest.gravity));
  for (PetscInt i = 0; table->there && i < local; i++) {
    PetscReal x[MPM_MAX_DIM];

    if (!MpmNodeInGrid(&model->disc, i)) continue;
    MpmNodePosition(&model->disc, i, x);
    rest.pressure[i] = AtNode(still, x);
    rest.bent[i]     = IsBent(still, x, rest.pressure[i]);
  }
  if (table->there) PetscCall(MpmScalarAtPoints(sum, rest.pressure, NULL, rest.gravity));
  for (PetscInt p = 0; table->there && p < count; p++) {
    const PetscReal share = -(PetscReal)table->up * rest.gravity[p * dim + table->axis] / table->weight;

    for (PetscInt a = 0; a < dim; a++) rest.gravity[p * dim + a] = share * sum->step.gravity[a];
  }
  PetscCall(MpmDiscretizationSetWater(&model->disc, &rest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterReadLevel(MpmModel model, const MpmOptions *options)
{
  const MpmLayout *layout = model->disc.layout;
  PetscReal        bounds[2 * MPM_MAX_DIM];

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < model->scene.bodies->count && layout->rate.count == 1; b++)
    PetscCall(MpmBodyReadStart(options, model->scene.bodies->names[b],
                               layout->component[layout->rate.component[0]].name, model->scene.bodies->at[b]));
  if (MpmPressureComponent(layout) < 0 || layout->own.taken_up < 0) PetscFunctionReturn(PETSC_SUCCESS);
  model->scene.water->weight = model->scene.materials->at[0].physics_parameter[layout->own.taken_up];
  for (PetscInt a = 0; a < model->disc.dim; a++) {
    bounds[a]               = model->disc.grid->lower[a];
    bounds[MPM_MAX_DIM + a] = model->disc.grid->upper[a];
  }
  PetscCall(MpmWaterTableCreate(options, model->disc.dim, bounds, model->scene.loads, model->scene.water));
  for (PetscInt k = 0; k < model->scene.surfaces->count; k++) /* the load of open water follows its face */
    if (model->scene.water->there && model->scene.surfaces->at[k].drained)
      model->solver.definite.symmetric = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterFillPressure(MpmModel model, PetscInt first, PetscInt end)
{
  const PetscInt dim = model->disc.dim, rates = model->disc.layout->rate.count;
  const char    *field;
  MpmStillWater  still;
  PetscInt      *body;
  MpmPoints      points;

  PetscFunctionBeginUser;
  if (rates != 1) PetscFunctionReturn(PETSC_SUCCESS);
  field = model->disc.layout->component[model->disc.layout->rate.component[0]].name;
  PetscCall(FindStill(model, model->state.time, &still));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscMalloc1(points.count, &body));
  MpmBodiesOfPoints(model->scene.bodies->count, model->scene.bodies->at, &points, body);
  for (PetscInt p = 0; p < points.count; p++) {
    const PetscReal *half     = points.domain.half_length ? &points.domain.half_length[p * dim] : NULL;
    PetscReal       *gradient = &points.physics.value_gradient[p * rates * dim];

    if (points.id[p] < first || points.id[p] >= end) continue;
    if (MpmBodyFileStart(model->scene.bodies->at[body[p]], field)) continue; /* its own */
    points.physics.value[p * rates] = MpmBodyStart(model->scene.bodies->at[body[p]]);
    for (PetscInt a = 0; a < dim; a++) gradient[a] = 0.;
    if (still.table->there)
      points.physics.value[p * rates] += AtPoint(&still, model, &points.x[p * dim], half, gradient);
  }
  PetscCall(PetscFree(body));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values of the points and their gradients, less a part of those at rest. */
static PetscErrorCode SubtractStill(MpmModel model, PetscReal part, PetscReal value[], PetscReal gradient[])
{
  const PetscInt count = model->disc.points->count, dim = model->disc.dim, rates = model->disc.layout->rate.count;
  PetscReal     *rest, *slope;

  PetscFunctionBeginUser;
  if (!model->disc.sum->still.pressure) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(count, &rest, (count * dim), &slope));
  PetscCall(MpmScalarAtPoints(model->disc.sum, model->disc.sum->still.pressure, rest, slope));
  for (PetscInt p = 0; p < count; p++) {
    value[p * rates] -= part * rest[p];
    for (PetscInt a = 0; a < dim; a++) gradient[p * rates * dim + a] -= part * slope[p * dim + a];
  }
  PetscCall(PetscFree2(rest, slope));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Pressures at the local nodes as the points have them: exactly where these are at rest. */
static PetscErrorCode Project(MpmModel model, PetscInt c, PetscReal nodal[])
{
  const MpmLayout *layout = model->disc.layout;
  const PetscInt   count = model->disc.points->count * layout->rate.count, dim = model->disc.dim;
  const PetscReal *still = model->disc.sum->still.pressure, part = model->state.scheme.load_scale;
  MpmPointValues   values = {layout->component[c].shape, 1, layout->rate.count, NULL, NULL, layout->rate.count * dim};
  PetscReal       *value, *gradient;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(count, &value, (count * dim), &gradient));
  PetscCall(PetscArraycpy(value, model->disc.points->physics.value, count));
  PetscCall(PetscArraycpy(gradient, model->disc.points->physics.value_gradient, count * dim));
  PetscCall(SubtractStill(model, part, value, gradient));
  values.value    = value;
  values.gradient = gradient;
  PetscCall(MpmProjectToNodes(model->disc.sum, &values, nodal));
  PetscCall(MpmNodesToGhosts(&model->disc, 1, nodal));
  for (PetscInt i = 0; still && i < MpmNodesLocal(&model->disc); i++) nodal[i] += part * still[i];
  PetscCall(PetscFree2(value, gradient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether a node is not below the level, and there is dry ground or nothing. */
static PetscBool IsAbove(const MpmModel model, const MpmStillWater *still, PetscInt node)
{
  PetscReal x[MPM_MAX_DIM];

  if (!still->table->there || still->table->suction) return PETSC_FALSE;
  MpmNodePosition(&model->disc, node, x);
  return (PetscBool)(MpmWaterTableDepth(still->table, still->time, x) < MPM_TOLERANCE * still->h);
}

PetscErrorCode MpmWaterHold(MpmModel model, PetscReal time)
{
  const PetscInt count = MpmNodesLocal(&model->disc), bs = model->disc.block,
                 c    = MpmPressureComponent(model->disc.layout);
  const PetscBool all = model->state.scheme.water_held;
  MpmStillWater   still;
  PetscReal      *nodal;

  PetscFunctionBeginUser;
  if (c < 0 || !(model->scene.water->there || all)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindStill(model, time, &still));
  PetscCall(SetStill(model, &still));
  PetscCall(PetscCalloc1(count, &nodal));
  if (all) PetscCall(Project(model, c, nodal));
  for (PetscInt i = 0; i < count; i++) {
    if (!MpmNodeInGrid(&model->disc, i) || !MpmConstraintsFree(model->disc.constraints, i * bs + c)) continue;
    if (all) MpmConstraintsHold(model->disc.constraints, i * bs + c, nodal[i]);
    else if (IsAbove(model, &still, i))
      MpmConstraintsHold(model->disc.constraints, i * bs + c, model->disc.sum->still.pressure[i]);
  }
  PetscCall(PetscFree(nodal));
  PetscFunctionReturn(PETSC_SUCCESS);
}
