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
#include "loads/load.h"
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
