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

/* One number in one step: `start` becomes the step's end. */
static PetscErrorCode StepAlong(MpmModel model, PetscInt n, PetscInt number, const MpmStepMap *map,
                                MpmPointVector *vector)
{
  MpmGradient     *gradient = model->gradient;
  const PetscInt   count    = model->disc.space->local * model->disc.block;
  const PetscInt   row      = number * gradient->rows + gradient->tape.step[n].row;
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
  PetscCall(FindSlopes(model, &end, residual, &gradient->slopes[row * gradient->objectives.count]));
  *vector = end;
  PetscCall(MpmPointVectorDestroy(&start));
  PetscCall(PetscFree2(residual, du));
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
    for (PetscInt k = 0; k < count; k++)
      if (MpmGradientIsClosed(gradient, k)) PetscCall(StepAlong(model, n, k, &step.map, &vectors[k]));
    PetscCall(MpmReplayedStepDestroy(&step));
  }
  for (PetscInt k = 0; k < count; k++) PetscCall(MpmPointVectorDestroy(&vectors[k]));
  PetscCall(PetscFree(vectors));
  MpmGradientSumSlopes(gradient, values);
  PetscFunctionReturn(PETSC_SUCCESS);
}
