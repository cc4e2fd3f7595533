/*
  The tangent-linear run: the change of every step's state with one parameter, from the first step to the last.

    J du = -(dr/ds ds + dr/dp dp),    ds' = dc/du du + dc/ds ds + dc/dp dp
*/
#include "base/columns.h"
#include "query/point_vector.h"
#include "space/space.h"
#include "bc/bc.h"
#include "observe/results.h"
#include "sensitivity/replayed_step.h"

/* The change of the objectives' columns with a step's end; `residual` is dr at the local nodes, a rank's part. */
static PetscErrorCode FindSlopes(MpmModel model, const MpmPointVector *end, PetscReal residual[], PetscReal slopes[])
{
  const MpmGradient *gradient = model->gradient;

  PetscFunctionBeginUser;
  MpmConstraintsGather(model->disc.constraints, model->disc.space, residual);
  PetscCall(MpmSpaceAddToOwners(model->disc.space, model->disc.block, residual));
  for (PetscInt o = 0; o < gradient->objectives.count; o++) {
    const MpmObjective *objective                 = &gradient->objectives.at[o];
    const MpmColumn    *row                       = &model->results->columns.at[objective->row];
    PetscReal           values[MPM_MAX_BLOCK + 1] = {0.};

    PetscCall((*model->results->columns.map[objective->row]->along)(model, row, end, residual, values));
    slopes[o] = values[objective->part];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivatives of the objectives' columns by a parameter, in the row of step n. */
static PetscReal *Slopes(const MpmGradient *gradient, PetscInt n, PetscInt parameter)
{
  return &gradient->slopes[(parameter * gradient->rows + gradient->tape.step[n].row) * gradient->objectives.count];
}

/* One number in one step: `start` becomes the step's end. */
static PetscErrorCode StepAlong(MpmModel model, PetscInt n, PetscInt number, const MpmStepMap *map,
                                MpmPointVector *vector)
{
  MpmGradient     *gradient = model->gradient;
  const PetscInt   count    = model->disc.space->local * model->disc.block;
  MpmPointVector   start = {0}, end = {0};
  const PetscInt   field     = number - map->parameters->count;
  MpmStepDirection direction = {.start     = &start,
                                .parameter = field < 0 ? number : -1,
                                .ground    = field < 0 ? NULL : &map->grounds->direction[field]};
  PetscReal       *residual, *du;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2((count + 1), &residual, (count + 1), &du));
  PetscCall(MpmStepVectorCreate(map, &start));
  PetscCall(MpmStepVectorCreate(map, &end));
  PetscCall(MpmPointVectorMove(model->comm,
                               !n && gradient->start.at && field < 0 ? &gradient->start.at[number] : vector, &start));
  PetscCall(MpmPointVectorDestroy(vector));
  MpmStageAlong(model, n, map, direction.parameter, &start);
  PetscCall(MpmPointsAlong(map, &direction, residual, NULL));
  PetscCall(MpmLoadsAlong(map, &direction, residual));
  PetscCall(MpmGhostAlong(map, &direction, residual));
  for (PetscInt k = 0; k < count; k++) residual[k] = -residual[k];
  PetscCall(MpmReplayedSolve(model, PETSC_FALSE, residual, du));
  PetscCall(PetscArrayzero(residual, count));
  direction.du = du;
  PetscCall(MpmPointsAlong(map, &direction, residual, &end));
  PetscCall(MpmLoadsAlong(map, &direction, residual));
  PetscCall(MpmGhostAlong(map, &direction, residual));
  MpmPointVectorAddConstant(&start, &end);
  PetscCall(FindSlopes(model, &end, residual, Slopes(gradient, n, number)));
  *vector = end;
  PetscCall(MpmPointVectorDestroy(&start));
  PetscCall(PetscFree2(residual, du));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Several parameters in one step, where the points' directions go in packs. */
static PetscErrorCode StepAlongPack(MpmModel model, PetscInt n, PetscInt many, const PetscInt which[],
                                    const MpmStepMap *map, MpmPointVector vectors[])
{
  MpmGradient      *gradient        = model->gradient;
  const PetscInt    count           = model->disc.space->local * model->disc.block;
  MpmPointVector    start[MPM_PACK] = {{0}}, end[MPM_PACK] = {{0}};
  MpmStepDirection  of[MPM_PACK];
  PetscReal        *residual[MPM_PACK], *du[MPM_PACK], *room;
  MpmStepDirections directions = {.count = many, .of = of, .residual = residual};

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((2 * many * count + 1), &room));
  for (PetscInt k = 0; k < many; k++) {
    residual[k] = &room[2 * k * count];
    du[k]       = &room[(2 * k + 1) * count];
    of[k]       = (MpmStepDirection){.start = &start[k], .parameter = which[k]};
    PetscCall(MpmStepVectorCreate(map, &start[k]));
    PetscCall(MpmStepVectorCreate(map, &end[k]));
    PetscCall(MpmPointVectorMove(
      model->comm, !n && gradient->start.at ? &gradient->start.at[which[k]] : &vectors[which[k]], &start[k]));
    PetscCall(MpmPointVectorDestroy(&vectors[which[k]]));
    MpmStageAlong(model, n, map, which[k], &start[k]);
  }
  PetscCall(MpmTableAlong(map, &directions));
  for (PetscInt k = 0; k < many; k++) {
    PetscCall(MpmLoadsAlong(map, &of[k], residual[k]));
    PetscCall(MpmGhostAlong(map, &of[k], residual[k]));
    for (PetscInt i = 0; i < count; i++) residual[k][i] = -residual[k][i];
    PetscCall(MpmReplayedSolve(model, PETSC_FALSE, residual[k], du[k]));
    PetscCall(PetscArrayzero(residual[k], count));
    of[k].du = du[k];
  }
  directions.end = end;
  PetscCall(MpmTableAlong(map, &directions));
  for (PetscInt k = 0; k < many; k++) {
    PetscCall(MpmLoadsAlong(map, &of[k], residual[k]));
    PetscCall(MpmGhostAlong(map, &of[k], residual[k]));
    MpmPointVectorAddConstant(&start[k], &end[k]);
    PetscCall(FindSlopes(model, &end[k], residual[k], Slopes(gradient, n, which[k])));
    vectors[which[k]] = end[k];
    PetscCall(MpmPointVectorDestroy(&start[k]));
  }
  PetscCall(PetscFree(room));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All parameters in step n that have derivatives in closed form. */
static PetscErrorCode StepAlongAll(MpmModel model, PetscInt n, const MpmStepMap *map, MpmPointVector vectors[])
{
  const PetscInt  count = model->gradient->parameters.count + model->gradient->grounds.direction_count;
  const PetscBool packs = MpmStepHasTable(map);
  PetscInt        which[MPM_PACK], many = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) {
    if (!MpmGradientIsClosed(model->gradient, k)) continue;
    if (!packs) PetscCall(StepAlong(model, n, k, map, &vectors[k]));
    else which[many++] = k;
    if (many < MPM_PACK) continue;
    PetscCall(StepAlongPack(model, n, many, which, map, vectors));
    many = 0;
  }
  if (many) PetscCall(StepAlongPack(model, n, many, which, map, vectors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTangentRun(MpmModel model, PetscReal values[])
{
  MpmGradient    *gradient = model->gradient;
  PetscInt        count;
  MpmPointVector *vectors;

  PetscFunctionBeginUser;
  PetscCall(MpmGroundDirectionsCreate(gradient->checks, &gradient->grounds));
  count = gradient->parameters.count + gradient->grounds.direction_count;
  PetscCall(PetscCalloc1(count, &vectors));
  PetscCall(PetscFree(gradient->slopes));
  PetscCall(PetscCalloc1((count * gradient->rows * gradient->objectives.count), &gradient->slopes));
  MpmStartSlopes(gradient, gradient->slopes);
  for (PetscInt n = 0; n < gradient->tape.count; n++) {
    MpmReplayedStep step;

    PetscCall(MpmTapeReplay(model, &gradient->tape, n));
    PetscCall(MpmReplayedStepCreate(model, n, &step));
    PetscCall(MpmReplayedSolveSetUp(model));
    PetscCall(StepAlongAll(model, n, &step.map, vectors));
    PetscCall(MpmReplayedStepDestroy(&step));
  }
  for (PetscInt k = 0; k < count; k++) PetscCall(MpmPointVectorDestroy(&vectors[k]));
  PetscCall(PetscFree(vectors));
  MpmGradientSumSlopes(gradient, values);
  PetscFunctionReturn(PETSC_SUCCESS);
}
