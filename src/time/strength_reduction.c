/*
  Strength reduction: a stage divides every strength of every material by a factor F of its time.

    stage_fail: {reduction: "0:1,1:2", time: {end: 1, step: 0.02}}

  Which parameters are strengths the law's table says (MPM_STRENGTH, MPM_STRENGTH_ANGLE; of angles it is the tangent that
  is divided); all others, elasticity among them, stay. So do F and history of the points: the return of the next step
  brings the stress to the smaller yield surface, and Newton's method the forces into balance again.

  Parameters belong to the time of a step's end. Apply() sets them when a step is tried, and again for the step's start
  when it is rolled back. In stages without a reduction F is 1.

  The factor of safety is F at the end of the first step of the run after which a point has moved `reduction_limit` times
  the material's height since its stage began. Where the points stood then travels with them and stands in checkpoints.

  Order of calls: Read() with the stage; Begin() once its bodies are there, Observe() after each of its steps.
*/
#include "options/options.h"
#include "geometry/geometry.h"
#include "point/material.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "terms/load.h"
#include "time/model.h"
#include "time/time.h"

const char *const MpmReductionFields[MPM_MAX_DIM] = {"reduction_start_x", "reduction_start_y", "reduction_start_z"};

/* ---- what is read ---- */

/* Both ends of the ramp must leave every law parameters that it accepts. */
static PetscErrorCode CheckParameters(MpmModel model, const MpmStage *stage)
{
  PetscReal ends[2];
  char      why[MPM_FAULT_TEXT], factor[MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  MpmRampBounds(stage->reduction.ramp, &ends[0], &ends[1]);
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    MpmMaterial *material = &model->scene.materials->at[m];

    for (PetscInt k = 0; k < 2; k++) {
      MpmMaterialReduce(material, ends[k]);
      MpmRealText(ends[k], factor);
      MpmCheckInput(!MpmMaterialIsFaulty(material, why), "-mpm_stage_%s_reduction: %s leaves material %s %s",
                    stage->name, factor, material->name, why);
    }
    MpmMaterialReduce(material, 1.);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReductionRead(MpmModel model, const MpmOptions *block, MpmStage *stage)
{
  PetscReal least, most;
  PetscBool given, any = PETSC_FALSE;
  char     *text, number[MPM_NUMBER_TEXT];

  PetscFunctionBeginUser;
  stage->reduction.limit = 0.01;
  PetscCall(MpmOptionsHas(block, "reduction", &given));
  if (MpmOptionsHelp()) {
    PetscCall(MpmOptionsText(block, "reduction",
                             "what cohesion, tan(friction) and other strengths are divided by, over the stage's time, "
                             "time:factor pairs (s:-); default: 1",
                             NULL, MPM_OPTIONAL, &text));
    PetscCall(PetscFree(text));
  } else if (!given) PetscFunctionReturn(PETSC_SUCCESS);
  else PetscCall(MpmRampCreate(block, "reduction", NULL, &stage->reduction.ramp));
  PetscCall(MpmOptionsReal(block, "reduction_limit", "-",
                           "how far a point has moved in the stage, in heights of the material, where the reduction is "
                           "taken as the factor of safety",
                           MPM_RANGE_POSITIVE, MPM_OPTIONAL, &stage->reduction.limit, NULL));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmRampBounds(stage->reduction.ramp, &least, &most);
  MpmRealText(least, number);
  MpmCheckInput(least > 0., "-%sreduction: the factor %s must be > 0", block->prefix, number);
  MpmCheckInput(stage->geostatic.method == MPM_GEOSTATIC_NONE,
                "-%sreduction: a geostatic stage does not reduce strength; one that follows can", block->prefix);
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    if (MpmMaterialHasStrength(&model->scene.materials->at[m])) any = PETSC_TRUE;
  MpmCheckInput(any, "-%sreduction: no material has a strength that it could reduce", block->prefix);
  PetscCall(CheckParameters(model, stage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmStagesReduce(const MpmModel model)
{
  for (PetscInt k = 0; k < model->scene.stage_count; k++)
    if (model->scene.stages[k].reduction.ramp) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* ---- the factor ---- */

PetscReal MpmReductionFactor(const MpmModel model, PetscReal time)
{
  const MpmRamp ramp = model->scene.stages[model->state.stage].reduction.ramp;

  return ramp ? MpmRampEvaluate(ramp, time - model->state.time_start) : 1.;
}

void MpmReductionApply(MpmModel model, PetscReal time)
{
  const PetscReal factor = MpmReductionFactor(model, time);

  if (!MpmStagesReduce(model)) return;
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    MpmMaterialReduce(&model->scene.materials->at[m], factor);
}

/* ---- the factor of safety ---- */

/* How high the material stands against gravity. */
static PetscErrorCode FindHeight(MpmModel model, const MpmPoints *points, PetscReal *height)
{
  const PetscInt dim      = model->disc.dim;
  PetscReal      reach[2] = {PETSC_NINFINITY, PETSC_NINFINITY}, U[MPM_MAX_DIM];
  PetscInt       axis, up;

  PetscFunctionBeginUser;
  MpmLoadsGetVertical(model->scene.loads, dim, &axis, &up);
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal y = points->x[p * dim + axis];
    PetscReal       half;

    PetscCheck(!model->scene.stretch(&points->F[p * dim * dim], U), PETSC_COMM_SELF, PETSC_ERR_FP,
               "point %" PetscInt_FMT " has no stretch", points->id[p]);
    half     = points->half_length[p * dim + axis] * U[axis];
    reach[0] = PetscMax(reach[0], half + y);
    reach[1] = PetscMax(reach[1], half - y);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, 2, MPIU_REAL, MPIU_MAX, model->comm));
  *height = reach[0] + reach[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the points stand as the stage begins, into their fields; or with `moved` the square of their way from there. */
static PetscErrorCode EachAxis(MpmModel model, const MpmPoints *points, PetscReal moved[])
{
  const PetscInt dim = model->disc.dim;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < dim; a++) {
    PetscReal *start;

    PetscCall(DMSwarmGetField(model->state.particles->swarm, MpmReductionFields[a], NULL, NULL, (void **)&start));
    for (PetscInt p = 0; p < points->count; p++) {
      if (moved) moved[p] += PetscSqr(points->x[p * dim + a] - start[p]);
      else start[p] = points->x[p * dim + a];
    }
    PetscCall(DMSwarmRestoreField(model->state.particles->swarm, MpmReductionFields[a], NULL, NULL, (void **)&start));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReductionBegin(MpmModel model)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  if (!model->scene.stages[model->state.stage].reduction.ramp) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(FindHeight(model, &points, &model->state.safety.height));
  PetscCall(EachAxis(model, &points, NULL));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmReductionObserve(MpmModel model)
{
  const MpmReduction *reduction = &model->scene.stages[model->state.stage].reduction;
  PetscReal           largest   = 0., *moved;
  MpmPoints           points;

  PetscFunctionBeginUser;
  if (!reduction->ramp || model->state.safety.factor > 0.) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscCalloc1(points.count, &moved));
  PetscCall(EachAxis(model, &points, moved));
  for (PetscInt p = 0; p < points.count; p++) largest = PetscMax(largest, PetscSqrtReal(moved[p]));
  PetscCall(PetscFree(moved));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &largest, 1, MPIU_REAL, MPIU_MAX, model->comm));
  if (largest < reduction->limit * model->state.safety.height) PetscFunctionReturn(PETSC_SUCCESS);
  model->state.safety.factor = MpmReductionFactor(model, model->state.time);
  PetscCall(MpmMonitorNote(&model->monitor, "factor of safety %.4g: a point has moved %.3g m, %g of the height",
                           (double)model->state.safety.factor, (double)largest,
                           (double)(largest / model->state.safety.height)));
  PetscFunctionReturn(PETSC_SUCCESS);
}
