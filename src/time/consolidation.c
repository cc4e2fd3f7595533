/*
  The end of a stage at a degree of consolidation.

    stage_wait: {time: {end: 1e9, step: 1e4}, until: {consolidation: 0.95}}

  The excess pressure is that over the pressure of the steady flow, which a step from the stage's start to its end finds with
  drained ground, under the loads and conditions of the end; the points go back. With |e| the mean size of the excess over the
  material, the degree of consolidation is

    U = 1 - |e|/max |e| ,   the largest |e| from the stage's start on.

  For a layer under a sudden load that is Terzaghi's average degree. A stage does not end before its loads and conditions have the
  values of its end.
*/
#include "geometry/geometry.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "point/layout.h"
#include "bc/bc.h"
#include "terms/body_surface.h"
#include "terms/discretization.h"
#include "terms/load.h"
#include "terms/water_table.h"
#include "time/integrator.h"
#include "time/model.h"
#include "time/step.h"
#include "time/time.h"
#include "time/water_state.h"

const char *const MpmConsolidationField = "pressure_steady";

PetscBool MpmStagesConsolidate(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stage_count; k++)
    if (model->scene.stages[k].consolidation > 0.) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* The mean size of the excess over the material. Collective. */
static PetscErrorCode FindExcess(MpmModel model, PetscReal *excess)
{
  const PetscInt rates  = model->disc.layout->rates;
  PetscReal      sum[2] = {0., 0.}, *steady;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(MpmParticlesGetField(model->state.particles, MpmConsolidationField, &steady));
  for (PetscInt p = 0; p < points.count; p++) {
    sum[0] += points.volume0[p] * PetscAbsReal(points.value[p * rates] - steady[p]);
    sum[1] += points.volume0[p];
  }
  PetscCall(MpmParticlesRestoreField(model->state.particles, &steady));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, 2, MPIU_REAL, MPIU_SUM, model->comm));
  *excess = sum[0] / sum[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The pressures that a drained step to the stage's end leaves at the points. */
static PetscErrorCode FindSteady(MpmModel model, const char **why)
{
  const MpmIntegrator *integrator = &MpmIntegratorQuasistatic;
  const PetscReal      dt         = model->state.time_end - model->state.time;
  MpmStage            *stage      = &model->scene.stages[model->state.stage];
  PetscReal           *steady;
  PetscBool            retryable;

  PetscFunctionBeginUser;
  stage->drained = PETSC_TRUE;
  PetscCall((*integrator->begin)(model, model->state.time_end, dt, PETSC_FALSE, why));
  if (!*why) {
    PetscCall((*integrator->predict)(model));
    PetscCall((*integrator->solve)(model, why, &retryable));
  }
  if (!*why) {
    PetscCall(MpmStepFindTrial(model));
    PetscCall(MpmParticlesGetField(model->state.particles, MpmConsolidationField, &steady));
    PetscCall(MpmRatesAtPoints(model->disc.sum, model->disc.u, steady));
    PetscCall(MpmParticlesRestoreField(model->state.particles, &steady));
  }
  PetscCall((*integrator->roll_back)(model));
  stage->drained = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConsolidationBegin(MpmModel model)
{
  MpmConsolidating *state = &model->state.consolidating;
  const MpmStage   *stage = &model->scene.stages[model->state.stage];
  const char       *why   = NULL;

  PetscFunctionBeginUser;
  if (!(stage->consolidation > 0.) || model->state.time > model->state.time_start) PetscFunctionReturn(PETSC_SUCCESS);
  *state = (MpmConsolidating){.most = -1.};
  PetscCall(FindSteady(model, &why));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  if (why)
    PetscCall(
      MpmMonitorNote(&model->monitor, "no drained state at the stage's end (%s): the stage lasts its time", why));
  else PetscCall(FindExcess(model, &state->most));
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
  const PetscReal       now = model->state.time, end = model->state.time_end;
  const MpmPrescription at[2] = {MpmStepPrescription(model, now), MpmStepPrescription(model, end)};

  for (PetscInt l = 0; l < loads + surfaces; l++)
    if (Differ(MpmModelLoadFactor(model, l, now), MpmModelLoadFactor(model, l, end))) return PETSC_FALSE;
  for (PetscInt k = 0; k < surfaces; k++)
    if (model->state.loads[loads + k].active &&
        Differ(MpmModelSurfacePressure(model, k, now), MpmModelSurfacePressure(model, k, end)))
      return PETSC_FALSE;
  for (PetscInt b = 0; b < model->scene.bcs->count; b++)
    if (model->state.bcs[b].active &&
        Differ(MpmStepFactor(&at[0], b, PETSC_FALSE), MpmStepFactor(&at[1], b, PETSC_FALSE)))
      return PETSC_FALSE;
  return (PetscBool)(!model->scene.water->there || !Differ(MpmRampEvaluate(model->scene.water->ramp, now),
                                                           MpmRampEvaluate(model->scene.water->ramp, end)));
}

PetscErrorCode MpmConsolidationObserve(MpmModel model)
{
  MpmConsolidating *state = &model->state.consolidating;
  const MpmStage   *stage = &model->scene.stages[model->state.stage];
  PetscReal         excess;
  PetscBool         over;

  PetscFunctionBeginUser;
  if (!(stage->consolidation > 0.) || state->most < 0.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindExcess(model, &excess));
  state->most   = PetscMax(state->most, excess);
  state->degree = state->most > 0. ? 1. - excess / state->most : 1.;
  over          = (PetscBool)(state->degree >= stage->consolidation && IsSettled(model));
  if (over || model->state.time >= model->state.time_end)
    PetscCall(MpmMonitorNote(&model->monitor, "stage %s ends %.4g %% consolidated%s", stage->name,
                             (double)(100. * state->degree), over ? "" : ", its time being over"));
  if (!over) PetscFunctionReturn(PETSC_SUCCESS);
  model->state.run_end -= model->state.time_end - model->state.time;
  model->state.time_end = model->state.relaxing.ended[model->state.stage] = model->state.time;
  PetscFunctionReturn(PETSC_SUCCESS);
}
