/*
  Derivatives of what happens between steps: the beginning of a stage, and of the run.

  Points are the same before and after, but for those that join, whose state has no derivative, and those that are gone.
  Where displacements begin anew the position from which they count becomes that of the points.
*/
#include "particles/body.h"
#include "particles/points.h"
#include "space/sum.h"
#include "query/point_vector.h"
#include "sensitivity/replayed_step.h"

/* True where displacements begin anew at the start of step n. */
static PetscBool Resets(const MpmModel model, PetscInt n, const MpmPointVector *vector)
{
  const MpmTape *tape = &model->gradient->tape;

  return (PetscBool)(vector->size[MPM_VECTOR_ORIGIN] && MpmTapeBeginsStage(tape, n) &&
                     model->scene.stages.at[tape->step[n].stage].reset);
}

/*
  Points that join at the start of step n, where masses are the points' own: the relative change of theirs with a
  density; with a sum its derivative, from the bars in `vector`.
*/
static void Joining(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscInt parameter, PetscReal *sum,
                    MpmPointVector *vector)
{
  const MpmTape           *tape   = &model->gradient->tape;
  const MpmSceneParameter *of     = &map->parameters->at[parameter];
  const MpmPoints         *points = map->sum->points;
  const PetscBool         *adds   = model->scene.stages.at[tape->step[n].stage].adds;

  if (!vector->size[MPM_VECTOR_MASS] || !n || !MpmTapeBeginsStage(tape, n) || of->kind != MPM_OF_LAW || !of->density)
    return;
  for (PetscInt b = 0; b < model->scene.bodies->count; b++) {
    PetscInt first, end;

    if (!adds[b]) continue;
    MpmBodyGetIds(model->scene.bodies->at[b], &first, &end);
    for (PetscInt p = 0; p < points->count; p++) {
      PetscReal *mass = &vector->at[MPM_VECTOR_MASS][p];

      if (points->id[p] < first || points->id[p] >= end || points->material[p] != of->index) continue;
      if (sum) *sum += *mass / of->value;
      else *mass += 1. / of->value;
    }
  }
}

void MpmStageAlong(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscInt parameter, MpmPointVector *vector)
{
  PetscReal *origin = vector->at[MPM_VECTOR_ORIGIN];

  Joining(model, n, map, parameter, NULL, vector);
  if (!Resets(model, n, vector)) return;
  for (PetscInt k = 0; k < vector->count * vector->dim; k++) origin[k] = vector->x[k];
}

void MpmStagePull(const MpmModel model, PetscInt n, const MpmStepMap *map, PetscReal gradient[], MpmPointVector *vector)
{
  PetscReal *origin = vector->at[MPM_VECTOR_ORIGIN];

  for (PetscInt k = 0; k < map->parameters->count; k++) Joining(model, n, map, k, &gradient[k], vector);
  if (!Resets(model, n, vector)) return;
  for (PetscInt k = 0; k < vector->count * vector->dim; k++) {
    vector->x[k] += origin[k];
    origin[k] = 0.;
  }
}

/* ---- the run's start ---- */

void MpmStartSlopes(const MpmGradient *gradient, PetscReal slopes[])
{
  const MpmGradientStart *start = &gradient->start;
  const PetscInt          count = gradient->objectives.count;

  for (PetscInt k = 0; start->slopes && k < gradient->parameters.count; k++)
    for (PetscInt i = 0; i < start->rows * count; i++)
      slopes[k * gradient->rows * count + i] = start->slopes[k * start->rows * count + i];
}

/* The sum of products of all fields. */
static PetscReal Dot(const MpmPointVector *one, const MpmPointVector *other)
{
  PetscReal sum = 0.;

  for (PetscInt f = 0; f < MPM_VECTOR_FIELDS; f++)
    for (PetscInt i = 0; i < one->count * one->size[f]; i++) sum += one->at[f][i] * other->at[f][i];
  return sum;
}

PetscErrorCode MpmStartPull(MpmModel model, const MpmPointVector *vector, PetscReal values[])
{
  const MpmGradient      *gradient = model->gradient;
  const MpmGradientStart *start    = &gradient->start;
  const PetscInt          count    = gradient->objectives.count;

  PetscFunctionBeginUser;
  if (!start->at) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < gradient->parameters.count; k++) {
    MpmPointVector here = {0};

    PetscCall(MpmPointVectorCopy(&start->at[k], PETSC_FALSE, &here));
    PetscCall(MpmPointVectorMove(model->comm, vector, &here));
    values[k] += Dot(&here, &start->at[k]);
    PetscCall(MpmPointVectorDestroy(&here));
    for (PetscInt o = 0; !model->rank && o < count; o++)
      for (PetscInt n = 0; n < start->rows; n++)
        values[k] += gradient->weights[o * gradient->rows + n] * start->slopes[(k * start->rows + n) * count + o];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
