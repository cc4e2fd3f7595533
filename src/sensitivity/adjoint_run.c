/*
  The adjoint run: from the last step to the first, the derivative of the objectives by each step's start, and by all
  parameters.

    J^T lam = dc/du^T s'bar ,   L = s'bar . c - lam . r ,   sbar = dL/ds ,   pbar += dL/dp

  A reaction is a residual of constrained nodes: its weight stands there in lam.
*/
#include "base/columns.h"
#include "query/point_vector.h"
#include "space/space.h"
#include "bc/bc.h"
#include "observe/results.h"
#include "watermap/water_map.h"
#include "sensitivity/replayed_step.h"

/* Adds the derivatives of the objectives by the end of step n, and their part of lam at the owned nodes. */
static PetscErrorCode PullObjectives(MpmModel model, PetscInt n, MpmPointVector *end, PetscReal lam[])
{
  const MpmGradient *gradient = model->gradient;

  PetscFunctionBeginUser;
  for (PetscInt o = 0; o < gradient->objectives.count; o++) {
    const MpmObjective *objective                  = &gradient->objectives.at[o];
    const MpmColumn    *row                        = &model->results->columns.at[objective->row];
    PetscReal           weights[MPM_MAX_BLOCK + 1] = {0.};

    weights[objective->part] = MpmGradientWeight(gradient, o, n);
    if (weights[objective->part] != 0.)
      PetscCall((*model->results->columns.map[objective->row]->pull)(model, row, weights, end, lam));
  }
  PetscCall(MpmSpaceToGhosts(model->disc.space, model->disc.block, lam));
  MpmConstraintsExtend(model->disc.constraints, model->disc.space, lam);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  One stage, with bars of its end, and in lam the weights of its reactions: bars of its start and derivatives by
  parameters are added.
*/
static PetscErrorCode StagePull(MpmModel model, MpmReplayedStep *step, const MpmPointVector *end, PetscReal lam[],
                                MpmPointVector *start, PetscReal values[], MpmPointTable **table)
{
  MpmStepMap    *map   = &step->map;
  const PetscInt count = model->disc.space->local * model->disc.block;
  PetscReal     *ubar, *solved;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2((count + 1), &ubar, (count + 1), &solved));
  PetscCall(MpmReplayedStepLinearise(model, step));
  PetscCall(MpmPointTableCreate(map, table));
  map->table = *table;
  PetscCall(MpmPointsPullSolution(map, end, lam, ubar));
  PetscCall(MpmGhostPullSolution(map, lam, ubar));
  PetscCall(MpmWaterWeightPullSolution(map, lam, ubar));
  PetscCall(MpmSurfacesPullSolution(map, lam, ubar));
  PetscCall(MpmReplayedSolve(model, step, PETSC_TRUE, ubar, solved));
  for (PetscInt k = 0; k < count; k++) lam[k] += solved[k];
  PetscCall(MpmPointsPullStart(map, end, lam, start, values));
  PetscCall(MpmLoadsPullStart(map, lam, start, values));
  PetscCall(MpmGhostPullStart(map, lam, values));
  PetscCall(MpmWaterWeightPullStart(map, lam, start, values));
  PetscCall(MpmSurfacesPullStart(map, lam, start, values));
  PetscCall(PetscFree2(ubar, solved));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first of two stages, with bars of the second one's numbers, which also has those of deviations at the start. */
static PetscErrorCode FirstPull(MpmModel model, PetscInt n, const MpmStageNumbers *bars, PetscReal lam[],
                                MpmPointVector *start, PetscReal values[], MpmPointTable **table)
{
  const MpmStageNumbers stage = {.deviation_n = bars->deviation_n};
  MpmPointVector        end   = {0};
  MpmReplayedStep       step;

  PetscFunctionBeginUser;
  PetscCall(MpmTapeFirstStage(model, &model->gradient->tape, n));
  PetscCall(MpmReplayedStepCreate(model, &step));
  step.map.stage = &stage;
  PetscCall(MpmStageVectorCreate(&step.map, bars, &end));
  PetscCall(StagePull(model, &step, &end, lam, start, values, table));
  PetscCall(MpmPointVectorDestroy(&end));
  PetscCall(MpmReplayedStepDestroy(&step));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One step: `vector`, the derivative by its end, becomes that by its start. */
static PetscErrorCode StepPull(MpmModel model, PetscInt n, MpmReplayedStep *step, MpmPointVector *vector,
                               PetscReal values[], MpmPointTable **table)
{
  MpmStepMap     *map   = &step->map;
  const PetscBool two   = MpmTapeHasTwoStages(&model->gradient->tape, n);
  const PetscInt  count = model->disc.space->local * model->disc.block;
  MpmPointVector  start = {0}, end = {0};
  MpmStageNumbers stage = {0};
  PetscReal      *lam, *first;

  PetscFunctionBeginUser;
  PetscCall(MpmStageNumbersCreate(map, &stage));
  map->stage = &stage;
  PetscCall(PetscCalloc2((count + 1), &lam, (count + 1), &first));
  PetscCall(MpmStepVectorCreate(map, &start));
  PetscCall(MpmStepVectorCreate(map, &end));
  PetscCall(MpmPointVectorMove(model->comm, vector, &end));
  PetscCall(MpmPointVectorDestroy(vector));
  PetscCall(PullObjectives(model, n, &end, lam));
  if (two) MpmReplayedAddFlow(model, lam, first);
  PetscCall(StagePull(model, step, &end, lam, &start, values, table));
  if (two) PetscCall(FirstPull(model, n, &stage, first, &start, values, table));
  if (stage.deviation_n) PetscCall(MpmDeviationsPull(map, stage.deviation_n, &start));
  PetscCall(MpmStageNumbersDestroy(&stage));
  MpmPointVectorAddConstant(&end, &start);
  MpmStagePull(model, n, map, values, &start);
  *vector = start;
  PetscCall(MpmPointVectorDestroy(&end));
  PetscCall(PetscFree2(lam, first));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAdjointRun(MpmModel model, PetscReal values[])
{
  MpmGradient   *gradient = model->gradient;
  const PetscInt count    = gradient->parameters.count;
  MpmPointVector vector   = {0};
  MpmPointTable *table    = NULL;

  PetscFunctionBeginUser;
  PetscCall(MpmFieldParametersBegin(&gradient->grounds));
  for (PetscInt n = gradient->tape.count - 1; n >= 0; n--) {
    MpmReplayedStep step;

    PetscCall(MpmTapeReplay(model, &gradient->tape, n, PETSC_FALSE));
    PetscCall(MpmReplayedStepCreate(model, &step));
    PetscCall(StepPull(model, n, &step, &vector, values, &table));
    PetscCall(MpmReplayedStepDestroy(&step));
    if (!gradient->checks) PetscCall(MpmTapeDone(&gradient->tape, n));
  }
  PetscCall(MpmPointTableDestroy(&table));
  PetscCall(MpmStartPull(model, &vector, values));
  PetscCall(MpmPointVectorDestroy(&vector));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, values, (PetscMPIInt)count, MPIU_REAL, MPIU_SUM, model->comm));
  PetscCall(MpmFieldParametersEnd(model->comm, &gradient->grounds, &values[count]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
