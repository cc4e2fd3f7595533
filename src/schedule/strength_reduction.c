/*
  Strength reduction: a stage divides every strength of every material by a factor F of its time.

    stage_fail: {reduction: "0:1,1:2", time: {end: 1, step: 0.02}}

  The law's table marks strengths (MPM_STRENGTH, MPM_STRENGTH_ANGLE; of angles the tangent is divided); all others,
  elasticity among them, stay. F and history of the points stay, too: the return of the next step brings the stress to
  the smaller yield surface, and Newton's method the forces into balance again.

  Parameters belong to the time of a step's end. Apply() sets them when a step is tried, and again for the step's start
  when it is rolled back. In stages without a reduction F is 1.

  The factor of safety is F when the first point has moved `reduction_limit` times the slope's height since its stage
  began: between the ends of two steps, in proportion to the longest ways. Where the points stood as the stage began
  travels with them and stands in checkpoints. Elastic ground moves before it fails, and ground that slides stiffens as
  it changes its shape: the limit is the strain that a layer of the slope's height has by its own weight, between
  bounds, unless the scene sets it.

  Steps without inertia bracket it. A step fails where Newton's method finds no equilibrium, or where a point would pass
  the limit: it is rolled back and halved, until its factors are as close as `reduction_tolerance`. The failure beyond
  the last state that stood is then that of the slope, and the stage ends in that state, or goes on with
  `reduction_slide`. Where the solver alone fails the last factor is a lower bound. The rate of movement by F grows, so
  that the limit would be passed no later than at the last step's rate: where that is within a hundredth the factor is
  known, and otherwise the run gives up.

  Where the ramp begins with another factor than the last stage ended with, these steps take the difference over their
  first step's nominal length, so that a slope that fails there is bracketed from the state before.

  Order of calls: Begin() once its bodies are there; Look() at a solution before it is accepted, Observe() after each
  step; after a step that failed Narrows(), and Close() once that is false.
*/
#include "base/columns.h"
#include "geometry/geometry.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/sum.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/query.h"
#include "schedule/reduction.h"

/* Largest part of the mass that a reduction may leave as it is. */
#define MOST_UNREDUCED 0.5

/* Where the solver alone fails: how far above the last factor, relative, the slope may pass the limit by its last rate
   if it slides. */
#define RUNS_AWAY 0.01

const char *const MpmReductionFields[MPM_MAX_DIM] = {"reduction_start_x", "reduction_start_y", "reduction_start_z"};

/* ---- the factor ---- */

PetscErrorCode MpmReductionApply(MpmModel model, PetscReal time)
{
  const PetscReal factor = MpmReductionFactor(model, time);

  PetscFunctionBeginUser;
  if (!MpmStagesReduce(model)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    MpmMaterialReduce(&model->scene.materials->at[m], factor);
  PetscCall(MpmModelSetOwn(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelSetOwn(MpmModel model)
{
  PetscInt  vertical[2];
  MpmPoints points;

  PetscFunctionBeginUser;
  if (!MpmParticlesHaveField(model->state.particles, "parameter")) PetscFunctionReturn(PETSC_SUCCESS);
  MpmLoadsGetVertical(model->scene.loads, model->disc.dim, &vertical[0], &vertical[1]);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  MpmPointsSetOwn(model->scene.materials->at, vertical, model->disc.dim, 0, points.count, &points);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- materials that stay as they are ---- */

/* Adds the mass of points to that of all, and of each material without strength; `material`: of a body's points, or
   NULL. */
static PetscErrorCode AddMasses(MpmModel model, const MpmPoints *points, const PetscInt material[], PetscReal mass[])
{
  const MpmMaterials *materials = model->scene.materials;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++) {
    PetscInt m = points->material[p];

    for (PetscInt b = 0, first, end; material && b < model->scene.bodies->count; b++) {
      MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
      if (points->id[p] >= first && points->id[p] < end && material[b] != -1) m = material[b];
    }
    if (m < -1) continue;
    mass[materials->count] += MpmPointMass(points, materials->at, p);
    if (!MpmMaterialHasStrength(&materials->at[m])) mass[m] += MpmPointMass(points, materials->at, p);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, mass, (PetscMPIInt)(materials->count + 1), MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* "rock (12 % of the mass), wall (3 %)", and the part of the mass that stays as it is. */
static void NameUnreduced(const MpmModel model, const PetscReal mass[], size_t size, char text[], PetscReal *part)
{
  const MpmMaterials *materials = model->scene.materials;
  char                one[96];

  *part   = 0.;
  text[0] = '\0';
  for (PetscInt m = 0; m < materials->count; m++) {
    const PetscReal share = mass[m] / mass[materials->count];

    if (!(mass[m] > 0.)) continue;
    snprintf(one, sizeof(one), "%s%.40s (%.3g %%%s)", text[0] ? ", " : "", materials->at[m].name,
             (double)(100. * share), text[0] ? "" : " of the mass");
    if (strlen(text) + strlen(one) < size) strcat(text, one);
    *part += share;
  }
}

static PetscErrorCode PrintUnreduced(MpmModel model)
{
  char       text[512];
  PetscReal *mass, part;
  MpmPoints  points;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((model->scene.materials->count + 1), &mass));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(AddMasses(model, &points, NULL, mass));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  NameUnreduced(model, mass, sizeof(text), text, &part);
  PetscCall(PetscFree(mass));
  if (part > 0.) PetscCall(MpmMonitorNote(&model->monitor, "materials without a strength stay as they are: %s", text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define GONE (-2) /* the body is not there */

/* Materials of bodies in a stage: -1 as at the start, or GONE. */
static void FindMaterials(const MpmModel model, PetscInt stage, PetscInt material[])
{
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    material[b] = -1;
    for (PetscInt k = 0; k < model->scene.stages.count; k++) {
      const MpmStage *at = &model->scene.stages.at[k];

      if (k > stage ? at->adds[b] : at->removed[b]) material[b] = GONE;
      if (k <= stage && material[b] != GONE && at->material[b] >= 0) material[b] = at->material[b];
    }
  }
}

PetscErrorCode MpmReductionCheck(MpmModel model)
{
  const PetscInt count = model->scene.materials->count;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < model->scene.stages.count; k++) {
    const MpmStage *stage = &model->scene.stages.at[k];
    PetscInt       *material;
    PetscReal      *mass, part;
    char            text[512];
    MpmPoints       points;

    if (!stage->reduction.ramp) continue;
    PetscCall(PetscCalloc2((count + 1), &mass, model->scene.bodies->count, &material));
    FindMaterials(model, k, material);
    PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
    PetscCall(AddMasses(model, &points, material, mass));
    PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
    NameUnreduced(model, mass, sizeof(text), text, &part);
    PetscCall(PetscFree2(mass, material));
    MpmCheckInput(part <= MOST_UNREDUCED,
                  "-mpm_stage_%s_reduction: materials without a strength that it could reduce are more than half of "
                  "the mass: %s",
                  stage->name, text);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the limit ---- */

/* Bounds of the limit that elasticity sets, in heights of the slope. */
#define LEAST_WAY 0.001
#define MOST_WAY  0.01

/* Mean weight of a volume over 3 G, E at nu = 1/2, of the softest point with a strength, 1/m. Laws without a shear
   modulus count by their
   stiffness. */
static PetscErrorCode FindSoftness(MpmModel model, const MpmPoints *points, PetscReal *softness)
{
  const PetscInt     dim = model->disc.dim, size = model->state.particles->state_size;
  const MpmMaterial *materials            = model->scene.materials->at;
  PetscReal          gravity[MPM_MAX_DIM] = {0., 0., 0.}, sum[2] = {0., 0.}; /* kg, m3 */

  PetscFunctionBeginUser;
  *softness = 0.; /* 1/Pa so far */
  for (PetscInt l = 0; l < model->scene.loads->count; l++)
    for (PetscInt a = 0; model->scene.loads->at[l].type == MPM_LOAD_GRAVITY && a < dim; a++)
      gravity[a] += model->scene.loads->at[l].value[a];
  for (PetscInt p = 0; p < points->count; p++) {
    const MpmMaterial *material = &materials[points->material[p]];
    const double      *own      = MpmPointOwn(points, material, p);
    const PetscReal   *state = size ? &points->state[p * size] : NULL, *F = MpmPointF(points, p);
    PetscReal          modulus = 3. * MpmMaterialShearModulusAt(material, own, state, F);

    if (!(modulus > 0.)) modulus = MpmMaterialStiffnessAt(material, own, state, F);
    if (MpmMaterialHasStrength(material) && modulus > 0.) *softness = PetscMax(*softness, 1. / modulus);
    sum[0] += MpmPointMass(points, materials, p);
    sum[1] += points->volume0[p];
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, softness, 1, MPIU_REAL, MPIU_MAX, model->comm));
  for (PetscInt a = 1; a < MPM_MAX_DIM; a++) gravity[0] = hypot(gravity[0], gravity[a]);
  *softness *= sum[1] > 0. ? gravity[0] * sum[0] / sum[1] : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FindLimit(MpmModel model, const MpmPoints *points)
{
  MpmSafety *safety = &model->state.safety;
  PetscReal  share = model->scene.stages.at[model->state.stage].reduction.limit, softness = 0.;

  PetscFunctionBeginUser;
  if (!(share > 0.)) {
    PetscCall(FindSoftness(model, points, &softness));
    share = PetscMin(MOST_WAY, PetscMax(LEAST_WAY, softness * safety->height));
  }
  safety->limit = share * safety->height;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the factor of safety ---- */

/* The highest and the lowest place of the material against gravity, and its highest place in each column of cells. */
static PetscErrorCode FindTops(MpmModel model, const MpmPoints *points, PetscReal reach[2], PetscReal top[])
{
  const PetscInt *cells = model->disc.grid->cells, dim = model->disc.dim;
  PetscReal       U[MPM_MAX_DIM];
  PetscInt        axis, up, cell[MPM_MAX_DIM] = {0, 0, 0};

  PetscFunctionBeginUser;
  MpmLoadsGetVertical(model->scene.loads, dim, &axis, &up);
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal y = points->x[p * dim + axis] * (PetscReal)up;
    PetscReal       half, *highest;

    PetscCheck(!model->scene.deformation.stretch(MpmPointF(points, p), U), PETSC_COMM_SELF, PETSC_ERR_FP,
               "point %" PetscInt_FMT " has no stretch", points->id[p]);
    half     = points->domain.half_length[p * dim + axis] * U[axis];
    reach[0] = PetscMax(reach[0], y + half);
    reach[1] = PetscMax(reach[1], half - y);
    MpmGridFindCell(model->disc.grid, &points->x[p * dim], cell);
    cell[axis] = 0;
    highest    = &top[(cell[2] * (axis == 1 ? 1 : cells[1]) + cell[1]) * (axis == 0 ? 1 : cells[0]) + cell[0]];
    *highest   = PetscMax(*highest, y + half);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The height of the slope: from the lowest to the highest ground, of all columns of cells that hold material. Where the
  ground is level, to a fifth of the material's height, that height instead.
*/
static PetscErrorCode FindHeight(MpmModel model, const MpmPoints *points, PetscReal *height)
{
  const PetscInt *cells    = model->disc.grid->cells;
  PetscReal       reach[2] = {PETSC_NINFINITY, PETSC_NINFINITY}, lowest = PETSC_INFINITY, *top;
  PetscInt        axis, up, count;

  PetscFunctionBeginUser;
  MpmLoadsGetVertical(model->scene.loads, model->disc.dim, &axis, &up);
  count = cells[0] * cells[1] * cells[2] / cells[axis];
  PetscCall(PetscMalloc1(count, &top));
  for (PetscInt c = 0; c < count; c++) top[c] = PETSC_NINFINITY;
  PetscCall(FindTops(model, points, reach, top));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, 2, MPIU_REAL, MPIU_MAX, model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, top, (PetscMPIInt)count, MPIU_REAL, MPIU_MAX, model->comm));
  for (PetscInt c = 0; c < count; c++)
    if (top[c] > PETSC_NINFINITY) lowest = PetscMin(lowest, top[c]);
  PetscCall(PetscFree(top));
  *height = reach[0] + reach[1];
  if (reach[0] - lowest > 0.2 * *height) *height = reach[0] - lowest;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the points stand as the stage begins, into their fields; or with `moved` the square of their way to where they
   are and, with
   `more`, go. */
static PetscErrorCode EachAxis(MpmModel model, const MpmPoints *points, const PetscReal more[], PetscReal moved[])
{
  const PetscInt dim = model->disc.dim;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal *start;

    PetscCall(MpmParticlesGetField(model->state.particles, MpmReductionFields[a], &start));
    for (PetscInt p = 0; p < points->count; p++) {
      if (moved) moved[p] += PetscSqr(points->x[p * dim + a] + (more ? more[p * dim + a] : 0.) - start[p]);
      else start[p] = points->x[p * dim + a];
    }
    PetscCall(MpmParticlesRestoreField(model->state.particles, &start));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A stage whose factor changes seeks anew. */
static void SeekAnew(MpmModel model)
{
  MpmSafety *safety = &model->state.safety;
  PetscReal  least, most;

  MpmRampBounds(model->scene.stages.at[model->state.stage].reduction.ramp, &least, &most);
  if (least != most || safety->start != most) safety->factor = 0.;
  safety->rate = safety->failed = 0.;
  model->state.scheme.settling  = (MpmSettling){0};
}

static PetscErrorCode FillReduction(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)column;
  PetscFunctionBeginUser;
  values[0] = MpmReductionFactor(model, model->state.time);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReductionAddColumns(MpmModel model, MpmColumns *columns)
{
  const MpmColumn row = {.name = "reduction", .unit = "-", .fill = FillReduction};

  PetscFunctionBeginUser;
  if (MpmStagesReduce(model)) PetscCall(MpmColumnsAdd(columns, NULL, &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReductionAddRows(MpmModel model)
{
  MpmSafety   *safety = &model->state.safety;
  const MpmRow rows[] = {
    {"reduction_height", MPM_ROW_REAL, MPM_ROW_RUN, &safety->height, 0, 0},
    {"reduction_limit", MPM_ROW_REAL, MPM_ROW_RUN, &safety->limit, 0, 0},
    {"factor_of_safety", MPM_ROW_REAL, MPM_ROW_RUN, &safety->factor, 0, 0},
    {"reduction_moved", MPM_ROW_REAL, MPM_ROW_RUN, &safety->moved, 0, 0},
    {"reduction_last", MPM_ROW_REAL, MPM_ROW_RUN, &safety->reduced, 0, 0},
    {"reduction_start", MPM_ROW_REAL, MPM_ROW_RUN, &safety->start, 0, 0},
    {"reduction_rate", MPM_ROW_REAL, MPM_ROW_RUN, &safety->rate, 0, 0},
    {"reduction_failed", MPM_ROW_REAL, MPM_ROW_RUN, &safety->failed, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReductionBegin(MpmModel model)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  if (!model->scene.stages.at[model->state.stage].reduction.ramp) PetscFunctionReturn(PETSC_SUCCESS);
  SeekAnew(model);
  PetscCall(PrintUnreduced(model));
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(FindHeight(model, &points, &model->state.safety.height));
  PetscCall(FindLimit(model, &points));
  PetscCall(EachAxis(model, &points, NULL, NULL));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  model->state.safety.moved   = 0.;
  model->state.safety.reduced = MpmReductionFactor(model, model->state.period.start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The longest way of a point since the stage began, to where it is or, with `more`, goes. */
static PetscErrorCode FindMoved(MpmModel model, const PetscReal more[], PetscReal *longest)
{
  const PetscBool lent = (PetscBool)(more != NULL); /* within a step the points' arrays are lent */
  PetscReal      *moved;
  MpmPoints       own, *points = lent ? model->disc.points : &own;

  PetscFunctionBeginUser;
  *longest = 0.;
  if (!lent) PetscCall(MpmParticlesGetArrays(model->state.particles, &own));
  PetscCall(PetscCalloc1(points->count, &moved));
  PetscCall(EachAxis(model, points, more, moved));
  for (PetscInt p = 0; p < points->count; p++) *longest = PetscMax(*longest, PetscSqrtReal(moved[p]));
  PetscCall(PetscFree(moved));
  if (!lent) PetscCall(MpmParticlesRestoreArrays(model->state.particles, &own));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, longest, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* F where the longest way passes the limit, between two states. */
static PetscReal FactorAtLimit(const MpmSafety *before, PetscReal limit, PetscReal moved, PetscReal factor)
{
  if (!(moved > before->moved)) return factor;
  return before->reduced + (factor - before->reduced) * (limit - before->moved) / (moved - before->moved);
}

PetscErrorCode MpmReductionObserve(MpmModel model)
{
  const MpmReduction *reduction = &model->scene.stages.at[model->state.stage].reduction;
  const MpmSafety     before    = model->state.safety;
  MpmSafety          *safety    = &model->state.safety;
  const PetscReal     limit     = before.limit;

  PetscFunctionBeginUser;
  if (!reduction->ramp || before.factor > 0.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindMoved(model, NULL, &safety->moved));
  safety->reduced = MpmReductionFactor(model, model->state.time);
  if (safety->reduced > before.reduced)
    safety->rate = (safety->moved - before.moved) / (safety->reduced - before.reduced);
  if (model->state.time >= safety->failed) safety->failed = 0.;
  if (safety->moved < limit) PetscFunctionReturn(PETSC_SUCCESS);
  safety->factor = FactorAtLimit(&before, limit, safety->moved, safety->reduced);
  PetscCall(MpmMonitorNote(&model->monitor, "factor of safety %.4g: a point has moved %.3g m, %.2g of the height",
                           (double)safety->factor, (double)limit, (double)(limit / safety->height)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the bracket ---- */

PetscBool MpmReductionBrackets(const MpmModel model, PetscReal next)
{
  if (!MpmReductionSeeks(model) || model->state.scheme.rescuing.on) return PETSC_FALSE;
  if (model->scene.stages.at[model->state.stage].time.motion.type != MPM_QUASISTATIC) return PETSC_FALSE;
  return (PetscBool)(MpmReductionFactor(model, next) > model->state.safety.reduced);
}

PetscErrorCode MpmReductionLook(MpmModel model, PetscReal next, MpmOutcome *outcome)
{
  MpmSafety      *safety = &model->state.safety;
  const PetscReal limit  = safety->limit;
  PetscReal      *more, moved;

  PetscFunctionBeginUser;
  safety->beyond = 0.;
  if (!MpmReductionBrackets(model, next)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1((model->disc.points->count * model->disc.dim), &more));
  PetscCall(MpmDisplacementsAtPoints(model->disc.sum, model->disc.nodal.u, more));
  PetscCall(FindMoved(model, more, &moved));
  PetscCall(PetscFree(more));
  if (moved < limit) PetscFunctionReturn(PETSC_SUCCESS);
  safety->beyond = moved;
  PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_REFUSED, "a point moves %.3g m with a reduction of %.5g", (double)moved,
                           (double)MpmReductionFactor(model, next)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmReductionNarrows(MpmModel model, PetscReal next)
{
  MpmSafety      *safety = &model->state.safety;
  const PetscReal factor = MpmReductionFactor(model, next);

  safety->failed = next;
  return (PetscBool)(factor - safety->reduced >
                     model->scene.stages.at[model->state.stage].reduction.tolerance * safety->reduced);
}

/* F at which the way would pass the limit by the last step's rate: an upper bound, since the rate grows as strength
   goes. */
static PetscReal FactorByRate(const MpmSafety *safety, PetscReal limit)
{
  return safety->rate > 0. ? safety->reduced + (limit - safety->moved) / safety->rate : PETSC_INFINITY;
}

PetscErrorCode MpmReductionClose(MpmModel model, PetscReal next, MpmOutcome *outcome)
{
  const MpmReduction *reduction = &model->scene.stages.at[model->state.stage].reduction;
  MpmSafety          *safety    = &model->state.safety;
  const PetscReal     limit = safety->limit, factor = MpmReductionFactor(model, next);
  const PetscReal     most = FactorByRate(safety, limit);
  char                text[MPM_OUTCOME_TEXT];

  PetscFunctionBeginUser;
  if (safety->beyond > 0.) {
    safety->factor = FactorAtLimit(safety, limit, safety->beyond, factor);
    PetscCall(MpmMonitorNote(&model->monitor, "factor of safety %.4g: a point moves %.3g m, %.2g of the height",
                             (double)safety->factor, (double)limit, (double)(limit / safety->height)));
  } else {
    safety->factor = safety->reduced;
    PetscCall(PetscSNPrintf(text, sizeof(text), "at %.5g %s", (double)factor, outcome->text));
    if (!(most <= (1. + RUNS_AWAY) * safety->reduced)) {
      PetscCall(
        MpmOutcomeFail(outcome, MPM_OUTCOME_REFUSED,
                       "factor of safety at least %.4g, by the last movement at most %.4g: %s; no point has moved "
                       "further than %.3g m",
                       (double)safety->factor, (double)most, text, (double)safety->moved));
      PetscFunctionReturn(PETSC_SUCCESS);
    }
    PetscCall(MpmMonitorNote(&model->monitor,
                             "factor of safety %.4g to %.4g: the slope slides, a point has moved %.3g m; %s",
                             (double)safety->factor, (double)most, (double)safety->moved, text));
  }
  MpmOutcomeClear(outcome);
  if (!reduction->slide) MpmStageEndHere(model);
  PetscFunctionReturn(PETSC_SUCCESS);
}
