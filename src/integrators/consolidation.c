/*
  Stages beside the time of consolidation: their length, and their end at a degree.

  The time factor of a material is T = t c_v/h^2, with the stage's length t, c_v = m M by the mobility m and the
  constrained modulus M at rest, and h the height of the material up gravity's axis. One-dimensional consolidation of a
  layer that drains at its top has come to 11 % at T = 0.01 and to 93 % at T = 1. Source: Terzaghi (1943),
  doi:10.1002/9780470172766.

    stage_wait: {time: {end: 1e9, step: 1e4}, until: {consolidation: 0.95}}

  The excess pressure is that over the pressure of the steady flow, which a step from the stage's start to its end finds
  with drained ground, under the loads and conditions of the end; the points go back. With |e| the mean size of the
  excess over the material, the degree of consolidation is

    U = 1 - |e|/max |e| .

  max |e| is the largest from the stage's start on, or that of an undrained step to the loads of the end, if that is
  more. For a layer under a sudden load U is Terzaghi's average degree, whatever the first step. A stage does not end
  before its loads and conditions have the values of its end.
*/
#include "base/columns.h"
#include "geometry/geometry.h"
#include "point/layout.h"
#include "point/material.h"
#include "particles/particles.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "loads/water_table.h"
#include "query/model.h"
#include "query/query.h"
#include "step/step.h"
#include "integrators/consolidation.h"
#include "integrators/integrators.h"

#define UNDRAINED 0.01
#define DRAINED   1.
#define LONG      1e20 /* s; flow outweighs storage in it */
#define LINE      512
#define SHORT     1e-9 /* of the stage: a step in which nothing flows */

const char *const MpmConsolidationField = "pressure_steady";

/* ---- length ---- */

/* The largest mobility of a material by axes, m2/(Pa s): the ghost penalty's flow in a long step. */
static PetscReal Mobility(const MpmModel model, const MpmMaterial *material)
{
  const MpmPhysicsMaterial of = MpmMaterialForPhysics(material, NULL, model->disc.dim);

  return PetscAbsReal(model->disc.layout->ghost(&of, material->physics_parameter, LONG, 1.)) / LONG;
}

/* Heights of the materials up gravity's axis, negative where there is none of it. Collective. */
static PetscErrorCode FindHeights(MpmModel model, PetscReal height[])
{
  const PetscInt count = model->scene.materials->count, dim = model->disc.dim;
  PetscInt       axis, up, points, *material;
  PetscReal     *reach, *position;

  PetscFunctionBeginUser;
  MpmLoadsGetVertical(model->scene.loads, dim, &axis, &up);
  PetscCall(PetscMalloc1((2 * count), &reach));
  for (PetscInt k = 0; k < 2 * count; k++) reach[k] = PETSC_MIN_REAL / 4.;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &points));
  PetscCall(MpmParticlesGetField(model->state.particles, "position", &position));
  PetscCall(MpmParticlesGetField(model->state.particles, "material", &material));
  for (PetscInt p = 0; p < points; p++) {
    PetscReal *of = &reach[2 * material[p]];

    of[0] = PetscMax(of[0], position[p * dim + axis]);
    of[1] = PetscMax(of[1], -position[p * dim + axis]);
  }
  PetscCall(MpmParticlesRestoreField(model->state.particles, &material));
  PetscCall(MpmParticlesRestoreField(model->state.particles, &position));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, (PetscMPIInt)(2 * count), MPIU_REAL, MPIU_MAX, model->comm));
  for (PetscInt m = 0; m < count; m++)
    height[m] = reach[2 * m] + reach[2 * m + 1] + model->scene.materials->at[m].spacing * model->disc.h[axis];
  PetscCall(PetscFree(reach));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Times of consolidation by material, s; negative where there is none of it. Collective. */
static PetscErrorCode FindTimes(MpmModel model, PetscReal time[])
{
  const MpmMaterials *materials = model->scene.materials;

  PetscFunctionBeginUser;
  PetscCall(FindHeights(model, time));
  for (PetscInt m = 0; m < materials->count; m++)
    if (time[m] > 0.)
      time[m] = PetscSqr(time[m]) / (Mobility(model, &materials->at[m]) * materials->at[m].moduli.stiffness);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends the names of materials whose time factors lie in a range. */
static PetscErrorCode ListMaterials(const MpmModel model, const PetscReal time[], PetscReal length, const char *word,
                                    const PetscReal range[2], char text[LINE])
{
  size_t    used;
  PetscBool any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    const PetscReal factor = time[m] > 0. ? length / time[m] : -1.;
    char            between[48];

    if (factor < 0. || factor < range[0] || factor >= range[1]) continue;
    PetscCall(PetscStrlen(text, &used));
    PetscCall(PetscSNPrintf(between, sizeof(between), "%s%s", used ? "; " : "", word));
    PetscCall(PetscSNPrintf(&text[used], LINE - used, "%s %s (%.2g s)", any ? "," : between,
                            model->scene.materials->names[m], (double)time[m]));
    any = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterTellStage(MpmModel model)
{
  const PetscReal undrained[] = {0., UNDRAINED}, partly[] = {UNDRAINED, DRAINED}, drained[] = {DRAINED, PETSC_INFINITY};
  const MpmStage *stage  = &model->scene.stages.at[model->state.stage];
  const PetscReal length = model->state.period.end - model->state.period.start;
  PetscReal      *time;
  char            text[LINE] = "";

  PetscFunctionBeginUser;
  if (MpmPressureComponent(model->disc.layout) < 0 || !model->disc.layout->ghost ||
      model->disc.layout->own.taken_up < 0)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (stage->geostatic.method != MPM_GEOSTATIC_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(model->scene.materials->count, &time));
  PetscCall(FindTimes(model, time));
  PetscCall(
    ListMaterials(model, time, length, stage->drained ? "without `drained` undrained" : "undrained", undrained, text));
  PetscCall(ListMaterials(model, time, length, "partly drained", partly, text));
  PetscCall(ListMaterials(model, time, length, "drained", drained, text));
  PetscCall(MpmMonitorLine(&model->monitor, "%s%.4g s beside h2/c_v: %s", stage->drained ? "drained stage, " : "",
                           (double)length, text));
  PetscCall(PetscFree(time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- end ---- */

/* The mean size of the excess over the material of pressures at the points. Collective. */
static PetscErrorCode MeanExcess(MpmModel model, const PetscReal pressure[], PetscReal *excess)
{
  const PetscInt rates  = model->disc.layout->rate.count;
  PetscReal      sum[2] = {0., 0.}, *steady, *volume;
  PetscInt       count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  PetscCall(MpmParticlesGetField(model->state.particles, MpmConsolidationField, &steady));
  PetscCall(MpmParticlesGetField(model->state.particles, "volume0", &volume));
  for (PetscInt p = 0; p < count; p++) {
    sum[0] += volume[p] * PetscAbsReal(pressure[p * rates] - steady[p]);
    sum[1] += volume[p];
  }
  PetscCall(MpmParticlesRestoreField(model->state.particles, &volume));
  PetscCall(MpmParticlesRestoreField(model->state.particles, &steady));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, model->comm));
  *excess = sum[0] / sum[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Excess of the present points. */
static PetscErrorCode FindExcess(MpmModel model, PetscReal *excess)
{
  PetscReal *pressure;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetField(model->state.particles, "value", &pressure));
  PetscCall(MeanExcess(model, pressure, excess));
  PetscCall(MpmParticlesRestoreField(model->state.particles, &pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Pressures at the points after a step from here to loads and conditions of the stage's end, drained or too short for
   flow. */
static PetscErrorCode TryStep(MpmModel model, PetscBool drained, PetscReal pressure[], MpmOutcome *outcome)
{
  const MpmIntegrator *integrator = &MpmIntegratorQuasistatic;
  const PetscReal      length     = model->state.period.end - model->state.time;
  MpmStage            *stage      = &model->scene.stages.at[model->state.stage];

  PetscFunctionBeginUser;
  stage->drained = drained;
  PetscCall(
    (*integrator->begin)(model, model->state.period.end, drained ? length : SHORT * length, PETSC_FALSE, outcome));
  if (!outcome->code) {
    PetscCall((*integrator->predict)(model));
    PetscCall((*integrator->solve)(model, outcome));
  }
  if (!outcome->code) {
    PetscCall(MpmStepFindTrial(model));
    PetscCall(MpmRatesAtPoints(model->disc.sum, model->disc.nodal.u, pressure));
  }
  PetscCall((*integrator->roll_back)(model));
  stage->drained = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The steady pressure, and the excess over it at the start and under the loads of the end at once. */
static PetscErrorCode FindSteady(MpmModel model, PetscReal *most, MpmOutcome *outcome)
{
  const PetscInt rates = model->disc.layout->rate.count;
  MpmOutcome     undrained;
  PetscReal     *steady, *pressure, excess;
  PetscInt       count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  PetscCall(PetscMalloc1((count * rates), &pressure));
  PetscCall(TryStep(model, PETSC_TRUE, pressure, outcome));
  if (!outcome->code) {
    PetscCall(MpmParticlesGetField(model->state.particles, MpmConsolidationField, &steady));
    for (PetscInt p = 0; p < count; p++) steady[p] = pressure[p * rates];
    PetscCall(MpmParticlesRestoreField(model->state.particles, &steady));
    PetscCall(FindExcess(model, most));
    PetscCall(TryStep(model, PETSC_FALSE, pressure, &undrained));
  }
  if (!outcome->code && !undrained.code) {
    PetscCall(MeanExcess(model, pressure, &excess));
    *most = PetscMax(*most, excess);
  }
  PetscCall(PetscFree(pressure));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillDegree(MpmModel model, const MpmColumn *column, PetscReal values[])
{
  (void)column;
  PetscFunctionBeginUser;
  values[0] = model->state.scheme.water.degree;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConsolidationAddColumns(MpmModel model, MpmColumns *columns)
{
  const MpmColumn row = {.name = "consolidation", .unit = "-", .fill = FillDegree};

  PetscFunctionBeginUser;
  if (MpmStagesConsolidate(model)) PetscCall(MpmColumnsAdd(columns, NULL, &row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConsolidationAddRows(MpmModel model)
{
  MpmWaterRun *water  = &model->state.scheme.water;
  const MpmRow rows[] = {
    {"consolidation_most", MPM_ROW_REAL, MPM_ROW_RUN, &water->most, 0, 0},
    {"consolidation", MPM_ROW_REAL, MPM_ROW_RUN, &water->degree, 0, 0},
  };

  PetscFunctionBeginUser;
  PetscCall(MpmRowsAdd(model->state.rows, NULL, PETSC_STATIC_ARRAY_LENGTH(rows), rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConsolidationBegin(MpmModel model)
{
  MpmWaterRun    *state = &model->state.scheme.water;
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];
  MpmOutcome      outcome;

  PetscFunctionBeginUser;
  if (!(stage->consolidation > 0.) || model->state.time > model->state.period.start) PetscFunctionReturn(PETSC_SUCCESS);
  state->most   = -1.;
  state->degree = 0.;
  PetscCall(FindSteady(model, &state->most, &outcome));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  if (outcome.code)
    PetscCall(MpmMonitorNote(&model->monitor, "no drained state at the stage's end (%s): the stage lasts its time",
                             outcome.text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool Differ(PetscReal one, PetscReal other)
{
  return (PetscBool)(PetscAbsReal(one - other) > 1e-9 * PetscMax(PetscAbsReal(one), PetscAbsReal(other)));
}

/* Whether loads, surfaces, conditions and the level have the values of the stage's end. */
static PetscBool IsSettled(const MpmModel model)
{
  const PetscInt        loads = model->scene.loads->count, surfaces = model->scene.surfaces->count;
  const PetscReal       now = model->state.time, end = model->state.period.end;
  const MpmPrescription at[2] = {MpmStepPrescription(model, now), MpmStepPrescription(model, end)};

  for (PetscInt l = 0; l < loads + surfaces; l++)
    if (Differ(MpmModelLoadFactor(model, l, now), MpmModelLoadFactor(model, l, end))) return PETSC_FALSE;
  for (PetscInt k = 0; k < surfaces; k++)
    if (model->state.acting.loads[loads + k].active &&
        Differ(MpmModelSurfacePressure(model, k, now), MpmModelSurfacePressure(model, k, end)))
      return PETSC_FALSE;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++)
    if (model->state.acting.bcs[b].active &&
        Differ(MpmStepFactor(&at[0], b, PETSC_FALSE), MpmStepFactor(&at[1], b, PETSC_FALSE)))
      return PETSC_FALSE;
  return (PetscBool)(!model->scene.water->there || !Differ(MpmRampEvaluate(model->scene.water->ramp, now),
                                                           MpmRampEvaluate(model->scene.water->ramp, end)));
}

PetscErrorCode MpmConsolidationObserve(MpmModel model)
{
  MpmWaterRun    *state = &model->state.scheme.water;
  const MpmStage *stage = &model->scene.stages.at[model->state.stage];
  PetscReal       excess;
  PetscBool       over;

  PetscFunctionBeginUser;
  if (!(stage->consolidation > 0.) || state->most < 0.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindExcess(model, &excess));
  state->most   = PetscMax(state->most, excess);
  state->degree = state->most > 0. ? 1. - excess / state->most : 1.;
  over          = (PetscBool)(state->degree >= stage->consolidation && IsSettled(model));
  if (over || model->state.time >= model->state.period.end)
    PetscCall(MpmMonitorNote(&model->monitor, "stage %s ends %.4g %% consolidated%s", stage->name,
                             (double)(100. * state->degree), over ? "" : ", its time being over"));
  if (!over) PetscFunctionReturn(PETSC_SUCCESS);
  model->state.period.run_end -= model->state.period.end - model->state.time;
  model->state.period.end = model->state.relaxing.ended[model->state.stage] = model->state.time;
  PetscFunctionReturn(PETSC_SUCCESS);
}
