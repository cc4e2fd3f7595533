/*
  The tangent-linear run: the change of every step's state with one parameter, from the first step to the last.

    J du = -(dr/ds ds + dr/dp dp),    ds' = dc/du du + dc/ds ds + dc/dp dp
*/
#include "base/columns.h"
#include "query/point_vector.h"
#include "space/space.h"
#include "bc/bc.h"
#include "observe/results.h"
#include "watermap/water_map.h"
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

/* True where a column depends on the balance at the nodes, and not on the points' state alone. */
static PetscBool AnyBalance(const MpmModel model)
{
  const MpmObjectives *objectives = &model->gradient->objectives;

  for (PetscInt o = 0; o < objectives->count; o++)
    if (model->results->columns.map[objectives->at[o].row]->balance) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Derivatives of the objectives' columns by a parameter, in the row of step n. */
static PetscReal *Slopes(const MpmGradient *gradient, PetscInt n, PetscInt parameter)
{
  return &gradient->slopes[(parameter * gradient->rows + gradient->tape.step[n].row) * gradient->objectives.count];
}

/* A parameter, or behind all of them a direction of a field, from the step's start on. */
static PetscErrorCode Enter(MpmModel model, PetscInt n, PetscInt number, const MpmStepMap *map, MpmPointVector *vector,
                            MpmPointVector *start, MpmStepDirection *direction)
{
  const MpmPointVector *first = n ? NULL : model->gradient->start.at;
  const PetscInt        field = number - map->parameters->count;

  PetscFunctionBeginUser;
  *direction = (MpmStepDirection){
    .start = start, .parameter = field < 0 ? number : -1, .ground = field < 0 ? NULL : &map->grounds->direction[field]};
  PetscCall(MpmStepVectorCreate(map, start));
  PetscCall(MpmPointVectorMove(model->comm, first && field < 0 ? &first[number] : vector, start));
  PetscCall(MpmPointVectorDestroy(vector));
  MpmStageAlong(model, n, map, direction->parameter, start);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The change of the residual's parts beside the points' along a direction. */
static PetscErrorCode PartsAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[])
{
  PetscFunctionBeginUser;
  PetscCall(MpmLoadsAlong(map, direction, residual));
  PetscCall(MpmGhostAlong(map, direction, residual));
  PetscCall(MpmWaterWeightAlong(map, direction, residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One stage along these directions: du and, if they are wanted, dr with it and the changes of its end. */
static PetscErrorCode StageAlong(MpmModel model, const MpmReplayedStep *step, PetscBool balance, PetscReal *const du[],
                                 MpmPointVector end[], MpmStepDirection of[], MpmStepDirections *directions)
{
  const MpmStepMap *map      = &step->map;
  const PetscInt    count    = model->disc.space->local * model->disc.block;
  PetscReal *const *residual = directions->residual;

  PetscFunctionBeginUser;
  PetscCall(MpmPointsAlong(map, directions));
  PetscCall(MpmSurfacesAlong(map, directions));
  for (PetscInt k = 0; k < directions->count; k++) {
    PetscCall(PartsAlong(map, &of[k], residual[k]));
    for (PetscInt i = 0; i < count; i++) residual[k][i] = -residual[k][i];
    PetscCall(MpmReplayedSolve(model, step, PETSC_FALSE, residual[k], du[k]));
    PetscCall(PetscArrayzero(residual[k], count));
    of[k].du = du[k];
  }
  directions->end      = end;
  directions->residual = balance ? residual : NULL;
  PetscCall(MpmPointsAlong(map, directions));
  PetscCall(MpmSurfacesAlong(map, directions));
  for (PetscInt k = 0; balance && k < directions->count; k++) { PetscCall(PartsAlong(map, &of[k], residual[k])); }
  for (PetscInt k = 0; k < directions->count; k++) of[k].du = NULL;
  directions->end      = NULL;
  directions->residual = residual;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The first of two stages along the second one's directions, which get the changes of its end; the residuals are the
  changes of its own.
*/
static PetscErrorCode FirstAlong(MpmModel model, PetscInt n, PetscBool balance, PetscReal *const du[],
                                 const MpmStageNumbers stage[], MpmStepDirection of[], MpmStepDirections *directions)
{
  MpmPointVector  end[MPM_PACK] = {{0}};
  MpmReplayedStep step;

  PetscFunctionBeginUser;
  PetscCall(MpmTapeFirstStage(model, &model->gradient->tape, n));
  PetscCall(MpmReplayedStepCreate(model, &step));
  PetscCall(MpmReplayedStepLinearise(model, &step));
  for (PetscInt k = 0; k < directions->count; k++) PetscCall(MpmStageVectorCreate(&step.map, NULL, &end[k]));
  PetscCall(StageAlong(model, &step, balance, du, end, of, directions));
  for (PetscInt k = 0; k < directions->count; k++) {
    const PetscInt count = end[k].count, rates = end[k].size[MPM_VECTOR_VALUE];

    PetscCall(PetscArraycpy(stage[k].F, end[k].F, count * end[k].F_size));
    PetscCall(PetscArraycpy(stage[k].value, end[k].at[MPM_VECTOR_VALUE], count * rates));
    PetscCall(PetscArraycpy(stage[k].deviation, end[k].at[MPM_VECTOR_DEVIATION], count * rates));
    PetscCall(MpmPointVectorDestroy(&end[k]));
  }
  PetscCall(MpmReplayedStepDestroy(&step));
  PetscCall(MpmTapeSecondStage(model, &model->gradient->tape, n));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Up to MPM_PACK numbers in one step, whose solver is set up. */
static PetscErrorCode StepAlong(MpmModel model, PetscInt n, PetscInt many, const PetscInt which[],
                                MpmReplayedStep *step, MpmPointVector vectors[])
{
  const MpmStepMap *map      = &step->map;
  MpmGradient      *gradient = model->gradient;
  const PetscInt    count    = model->disc.space->local * model->disc.block;
  const PetscBool   balance = AnyBalance(model), two = MpmTapeHasTwoStages(&gradient->tape, n);
  MpmPointVector    start[MPM_PACK] = {{0}}, end[MPM_PACK] = {{0}};
  MpmStageNumbers   stage[MPM_PACK];
  MpmStepDirection  of[MPM_PACK];
  PetscReal        *residual[MPM_PACK], *du[MPM_PACK], *flow, *room;
  MpmStepDirections directions = {.count = many, .of = of, .residual = residual};

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2((2 * many * count + 1), &room, ((two ? many * count : 0) + 1), &flow));
  for (PetscInt k = 0; k < many; k++) {
    residual[k] = &room[2 * k * count];
    du[k]       = &room[(2 * k + 1) * count];
    PetscCall(Enter(model, n, which[k], map, &vectors[which[k]], &start[k], &of[k]));
    PetscCall(MpmStageNumbersCreate(map, &stage[k]));
    if (stage[k].deviation_n) PetscCall(MpmDeviationsAlong(map, &start[k], stage[k].deviation_n));
    of[k].stage = &stage[k];
    PetscCall(MpmStepVectorCreate(map, &end[k]));
  }
  if (two) {
    PetscCall(FirstAlong(model, n, balance, du, stage, of, &directions));
    for (PetscInt k = 0; k < many; k++) {
      MpmReplayedAddFlow(model, residual[k], &flow[k * count]);
      PetscCall(PetscArrayzero(residual[k], count));
    }
    PetscCall(MpmReplayedStepLinearise(model, step));
  }
  PetscCall(StageAlong(model, step, balance, du, end, of, &directions));
  for (PetscInt k = 0; k < many; k++) {
    for (PetscInt i = 0; two && i < count; i++) residual[k][i] += flow[k * count + i];
    MpmPointVectorAddConstant(&start[k], &end[k]);
    PetscCall(FindSlopes(model, &end[k], residual[k], Slopes(gradient, n, which[k])));
    vectors[which[k]] = end[k];
    PetscCall(MpmPointVectorDestroy(&start[k]));
    PetscCall(MpmStageNumbersDestroy(&stage[k]));
  }
  PetscCall(PetscFree2(room, flow));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All parameters in step n that have derivatives in closed form. */
static PetscErrorCode StepAlongAll(MpmModel model, PetscInt n, MpmReplayedStep *step, MpmPointVector vectors[])
{
  const PetscInt count = model->gradient->parameters.count + model->gradient->grounds.direction_count;
  PetscInt       which[MPM_PACK], many = 0;

  PetscFunctionBeginUser;
  if (!MpmTapeHasTwoStages(&model->gradient->tape, n)) PetscCall(MpmReplayedStepLinearise(model, step));
  for (PetscInt k = 0; k < count; k++) {
    if (!MpmGradientIsClosed(model->gradient, k)) continue;
    which[many++] = k;
    if (many < MPM_PACK) continue;
    PetscCall(StepAlong(model, n, many, which, step, vectors));
    many = 0;
  }
  if (many) PetscCall(StepAlong(model, n, many, which, step, vectors));
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

    PetscCall(MpmTapeReplay(model, &gradient->tape, n, PETSC_TRUE));
    PetscCall(MpmReplayedStepCreate(model, &step));
    PetscCall(StepAlongAll(model, n, &step, vectors));
    PetscCall(MpmReplayedStepDestroy(&step));
  }
  for (PetscInt k = 0; k < count; k++) PetscCall(MpmPointVectorDestroy(&vectors[k]));
  PetscCall(PetscFree(vectors));
  MpmGradientSumSlopes(gradient, values);
  PetscFunctionReturn(PETSC_SUCCESS);
}
