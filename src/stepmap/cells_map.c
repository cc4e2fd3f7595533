/*
  The points' part of a step's derivatives where the physics has a mean over the cell.

    m_bar = sum_q w_q m_q ,   w_q = V_q/sum V ,   V = volume0 det F_n ,   f = sum_q f_q

  With f the flux conjugate to m_bar, and K_q = sum_i lam_i grad w_i, the cell's part of L is

    sum_q [ bars . (F'_q, z'_q) - q_q . K_q ] - f M ,   M = sum_q w_q dm_q/dH_q . K_q

  whose derivative by m_bar is A = sum_q d[ bars . (F'_q, z'_q) - q_q . K_q - f_q M ]/dm_bar. Other derivatives have the
  point's own part at constant m_bar, A dm_bar, and -f dM.
*/
#include "points/cell_mean.h"
#include "stepmap/point_work.h"

/* One point of the cell: its mean and derivatives, also along the direction; fluxes, that of the mean last. */
typedef struct {
  PetscReal m[2], dm[2][MPM_MAX_INPUTS], volume[2], share[2], flux[2][MPM_MAX_INPUTS];
} CellPoint;

/* Sums of the cell. */
typedef struct {
  CellPoint *at;
  PetscInt   begin;
  PetscReal  volume[2], mean[2], flux[2], along, by_mean;
} Cell;

static PetscErrorCode CellCreate(const MpmStepMap *map, Cell *cell)
{
  const MpmSpace *space = map->sum->space;
  PetscInt        most  = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(cell, sizeof(*cell)));
  for (PetscInt c = 0; c < space->cells.count; c++)
    most = PetscMax(most, MpmCellEnd(map->sum, &space->cells.at[c]) - MpmCellBegin(map->sum, &space->cells.at[c]));
  PetscCall(PetscMalloc1((most + 1), &cell->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void CellBegin(const MpmStepMap *map, const MpmCell *of, Cell *cell)
{
  cell->begin = MpmCellBegin(map->sum, of);
  cell->along = cell->by_mean = 0.;
  for (int k = 0; k < 2; k++) cell->volume[k] = cell->mean[k] = cell->flux[k] = 0.;
}

/* A point's own m and volume, with their changes along a direction. */
static PetscErrorCode TakeMean(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                               const MpmKernelDirection *direction, const MpmPointWork *work, CellPoint *at)
{
  const MpmPoints *points = map->sum->points;
  PetscReal        cofactor[MPM_F_MAX];

  PetscFunctionBeginUser;
  PetscCheck(!map->sum->layout->kernel->mean_sensitivity(point, work->input, direction, at->m, at->dm[0], at->dm[1]),
             PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no mean at the solution of its step");
  at->volume[0] = points->volume0[p] * MpmCofactors(points->F_size, MpmPointF(points, p), cofactor);
  at->volume[1] = 0.;
  for (PetscInt k = 0; direction->F_n && k < points->F_size; k++)
    at->volume[1] += points->volume0[p] * cofactor[k] * direction->F_n[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void AddVolume(const CellPoint *at, Cell *cell)
{
  for (int k = 0; k < 2; k++) cell->volume[k] += at->volume[k];
}

/* Shares, and the mean. */
static void FindMean(const MpmStepMap *map, const MpmCell *of, Cell *cell)
{
  for (PetscInt s = 0; s < MpmCellEnd(map->sum, of) - cell->begin; s++) {
    CellPoint *at = &cell->at[s];

    at->share[0] = at->volume[0] / cell->volume[0];
    at->share[1] = (at->volume[1] - at->share[0] * cell->volume[1]) / cell->volume[0];
    cell->mean[0] += at->share[0] * at->m[0];
    cell->mean[1] += at->share[1] * at->m[0] + at->share[0] * at->m[1];
  }
}

/* ---- along ---- */

/* A point as its kernel takes it, and a direction. */
typedef struct {
  MpmKernelPoint     point;
  MpmKernelDirection direction;
  PetscReal          dinput[MPM_MAX_INPUTS]; /* of the direction, that of the mean last */
} Entered;

/* The point, and the change of its inputs but the mean. */
static PetscErrorCode EnterAlong(const MpmStepMap *map, const MpmGroup *group, PetscInt p,
                                 const MpmStepDirection *direction, MpmPointWork *work, Entered *at)
{
  const MpmPointVector    *start     = direction->start;
  const MpmSceneParameter *parameter = direction->parameter < 0 ? NULL : &map->parameters->at[direction->parameter];

  PetscFunctionBeginUser;
  MpmPointEnter(map, p, (PetscBool)(direction->du != NULL), work, &at->point);
  PetscCall(MpmPointWeightsAlong(map, group, p, start, work));
  MpmSumInputs(work->known, map->sum->layout, work->u, &work->slope, at->dinput);
  for (PetscInt k = 0; direction->du && k < work->known.inputs; k++) at->dinput[k] += work->other_input[k];
  at->dinput[work->known.inputs] = 0.;
  at->direction                  = (MpmKernelDirection){
                     .input = at->dinput, .state_n = &start->state[p * start->state_size], .F_n = &start->F[p * start->F_size]};
  if (parameter && MpmPointHasParameter(map, parameter, p)) {
    MpmPointSetDirection(map, parameter, 1., work);
    at->direction.parameter = work->parameter;
  }
  if (direction->ground && MpmPointGroundEnter(map, direction->ground, p, work))
    at->direction.parameter = work->parameter;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void LeaveAlong(const MpmStepMap *map, const MpmStepDirection *direction, MpmPointWork *work)
{
  if (direction->parameter >= 0 && map->parameters->at[direction->parameter].kind == MPM_OF_LAW)
    MpmPointSetDirection(map, &map->parameters->at[direction->parameter], 0., work);
  if (direction->ground) MpmPointGroundForget(map, direction->ground, work);
}

/* First pass: means; second: fluxes and the step's end. */
static PetscErrorCode PassAlong(const MpmStepMap *map, const MpmCell *of, const MpmStepDirection *direction,
                                PetscBool second, Cell *cell, MpmPointWork *work, MpmPointVector *end)
{
  const MpmSpace *space = map->sum->space;

  PetscFunctionBeginUser;
  for (PetscInt g = of->group_begin; g < of->group_end; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, direction->du, work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s], N = work->known.inputs;
      CellPoint     *at = &cell->at[s - cell->begin];
      Entered        entered;

      PetscCall(EnterAlong(map, group, p, direction, work, &entered));
      if (!second) {
        PetscCall(TakeMean(map, p, &entered.point, &entered.direction, work, at));
        at->volume[1] += at->volume[0] * MpmPointNumber(direction->start, MPM_VECTOR_VOLUME, p);
        AddVolume(at, cell);
      } else {
        work->input[N]    = cell->mean[0];
        entered.dinput[N] = cell->mean[1];
        PetscCall(MpmPointDifferentiate(map, &entered.point, &entered.direction, work));
        MpmPointVolumeAlong(direction->start, p, work);
        PetscCall(PetscArraycpy(at->flux[0], work->flux, N + 1));
        PetscCall(PetscArraycpy(at->flux[1], work->dflux, N + 1));
        for (int k = 0; k < 2; k++) cell->flux[k] += at->flux[k][N];
        if (end) MpmPointEndAlong(map, p, direction, work, end);
      }
      LeaveAlong(map, direction, work);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Third pass: forces, with the mean's part f w dm of the fluxes. */
static PetscErrorCode ScatterAlong(const MpmStepMap *map, const MpmCell *of, const MpmStepDirection *direction,
                                   const Cell *cell, MpmPointWork *work, PetscReal residual[])
{
  const MpmSpace *space = map->sum->space;

  PetscFunctionBeginUser;
  for (PetscInt g = of->group_begin; g < of->group_end; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, NULL, work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt   p  = space->order[s];
      const CellPoint *at = &cell->at[s - cell->begin];
      MpmKernelPoint   point;

      MpmPointEnter(map, p, PETSC_FALSE, work, &point);
      PetscCall(MpmPointWeightsAlong(map, group, p, direction->start, work));
      for (PetscInt k = 0; k < work->known.inputs; k++) {
        work->flux[k]  = at->flux[0][k] + cell->flux[0] * at->share[0] * at->dm[0][k];
        work->dflux[k] = at->flux[1][k] + cell->flux[1] * at->share[0] * at->dm[0][k] +
                         cell->flux[0] * (at->share[1] * at->dm[0][k] + at->share[0] * at->dm[1][k]);
      }
      MpmSumAddFlux(work->known, map->sum->layout, &work->slope, work->flux, work->force);
      MpmSumAddFlux(work->known, map->sum->layout, &work->basis, work->dflux, work->force);
    }
    MpmSumScatter(work->known, map->sum, group, work->force, residual);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCellsAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[],
                             MpmPointVector *end)
{
  const MpmSpace *space = map->sum->space;
  MpmPointWork    work;
  Cell            cell;

  PetscFunctionBeginUser;
  PetscCall(MpmPointWorkCreate(map, &work));
  PetscCall(CellCreate(map, &cell));
  for (PetscInt c = 0; c < space->cells.count; c++) {
    const MpmCell *of = &space->cells.at[c];

    CellBegin(map, of, &cell);
    PetscCall(PassAlong(map, of, direction, PETSC_FALSE, &cell, &work, NULL));
    FindMean(map, of, &cell);
    PetscCall(PassAlong(map, of, direction, PETSC_TRUE, &cell, &work, end));
    PetscCall(ScatterAlong(map, of, direction, &cell, &work, residual));
  }
  PetscCall(PetscFree(cell.at));
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pull ---- */

/* First pass: means and M; second: fluxes, and dL/dm_bar. */
static PetscErrorCode PassPull(const MpmStepMap *map, const MpmCell *of, const MpmPointVector *end,
                               const PetscReal lam[], PetscBool second, Cell *cell, MpmPointWork *work)
{
  const MpmSpace *space                = map->sum->space;
  PetscReal       unit[MPM_MAX_INPUTS] = {0.};

  PetscFunctionBeginUser;
  unit[map->sum->layout->input.count] = 1.;
  for (PetscInt g = of->group_begin; g < of->group_end; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, lam, work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s], N = work->known.inputs;
      CellPoint     *at = &cell->at[s - cell->begin];
      MpmKernelPoint point;

      MpmPointEnter(map, p, PETSC_TRUE, work, &point);
      if (!second) {
        PetscCall(TakeMean(map, p, &point, &(MpmKernelDirection){0}, work, at));
        AddVolume(at, cell);
        for (PetscInt k = 0; k < N; k++) cell->along += at->volume[0] * at->dm[0][k] * work->other_input[k];
        continue;
      }
      work->input[N] = cell->mean[0];
      PetscCall(MpmPointDifferentiate(map, &point, &(MpmKernelDirection){.input = unit}, work));
      PetscCall(PetscArraycpy(at->flux[0], work->flux, N + 1));
      cell->flux[0] += work->flux[N];
      cell->by_mean += MpmPointContract(map, p, end, work) - work->dflux[N] * cell->along;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The cell's sums. */
static PetscErrorCode SumPull(const MpmStepMap *map, const MpmCell *of, const MpmPointVector *end,
                              const PetscReal lam[], Cell *cell, MpmPointWork *work)
{
  PetscFunctionBeginUser;
  CellBegin(map, of, cell);
  PetscCall(PassPull(map, of, end, lam, PETSC_FALSE, cell, work));
  FindMean(map, of, cell);
  cell->along /= cell->volume[0];
  PetscCall(PassPull(map, of, end, lam, PETSC_TRUE, cell, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmMeanPull MeanPull(const Cell *cell, const CellPoint *at)
{
  return (MpmMeanPull){at->share[0], cell->by_mean, cell->flux[0], cell->along};
}

PetscErrorCode MpmCellsPullSolution(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                    PetscReal u[])
{
  const MpmSpace *space = map->sum->space;
  MpmPointWork    work;
  Cell            cell;

  PetscFunctionBeginUser;
  PetscCall(MpmPointWorkCreate(map, &work));
  PetscCall(CellCreate(map, &cell));
  for (PetscInt c = 0; c < space->cells.count; c++) {
    PetscCall(SumPull(map, &space->cells.at[c], end, lam, &cell, &work));
    for (PetscInt g = space->cells.at[c].group_begin; g < space->cells.at[c].group_end; g++) {
      const MpmGroup *group = &space->groups[g];

      MpmPointWorkGather(map, group, lam, &work);
      for (PetscInt s = group->point_begin; s < group->point_end; s++) {
        const PetscInt    p = space->order[s], n = work.known.n;
        const MpmMeanPull mean = MeanPull(&cell, &cell.at[s - cell.begin]);
        PetscReal         by_input[MPM_MAX_INPUTS];
        MpmKernelPoint    point;

        MpmPointEnter(map, p, PETSC_TRUE, &work, &point);
        work.input[work.known.inputs] = cell.mean[0];
        PetscCall(MpmPointPullInputs(map, p, &point, &(MpmPointPull){end, &mean}, by_input, &work));
        MpmSumAddFlux(work.known, map->sum->layout, &work.basis, by_input, work.force);
        for (PetscInt a = 0; a < end->dim; a++)
          MpmBasisAddForce(&work.basis, n, end->x[p * end->dim + a], &work.force[a * n]);
      }
      MpmSumScatter(work.known, map->sum, group, work.force, u);
    }
  }
  PetscCall(PetscFree(cell.at));
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* dL by F_n and volume0 through the point's share; `own` is A m_q - f dm_q . K_q, `all` its mean. */
static void PullShare(const MpmStepMap *map, PetscInt p, const Cell *cell, PetscReal own, PetscReal all,
                      MpmPointVector *start)
{
  const MpmPoints *points = map->sum->points;
  const PetscReal  by     = (own - all) / cell->volume[0] * points->volume0[p];
  PetscReal        cofactor[MPM_F_MAX], J;

  J = MpmCofactors(points->F_size, MpmPointF(points, p), cofactor);
  for (PetscInt k = 0; k < points->F_size; k++) start->F[p * points->F_size + k] += by * cofactor[k];
  if (start->size[MPM_VECTOR_VOLUME]) start->at[MPM_VECTOR_VOLUME][p] += by * J;
}

/* Bars of a step's end, and those of its start, which are added to. */
typedef struct {
  const MpmPointVector *end;
  MpmPointVector       *start;
} Ends;

/* The s-th point of the order, in the last pass. */
static PetscErrorCode PullPoint(const MpmStepMap *map, const MpmGroup *group, PetscInt s, const Ends *ends,
                                const Cell *cell, PetscReal gradient[], MpmPointWork *work)
{
  const CellPoint   *at    = &cell->at[s - cell->begin];
  const MpmMeanPull  mean  = MeanPull(cell, at);
  const MpmPointPull pull  = {ends->end, &mean};
  MpmPointVector    *start = ends->start;
  const PetscInt     p     = map->sum->space->order[s];
  const PetscInt     N     = work->known.inputs;
  PetscReal          own   = cell->by_mean * at->m[0], by_input[MPM_MAX_INPUTS];
  MpmKernelPoint     point;

  PetscFunctionBeginUser;
  MpmPointEnter(map, p, PETSC_TRUE, work, &point);
  work->input[N] = cell->mean[0];
  PetscCall(MpmPointPullInputs(map, p, &point, &pull, by_input, work));
  PetscCall(MpmPointPullKernel(map, p, &point, &pull, start, gradient, work));
  for (PetscInt k = 0; k < N; k++) {
    own -= cell->flux[0] * at->dm[0][k] * work->other_input[k];
    work->flux[k] = at->flux[0][k] + cell->flux[0] * at->share[0] * at->dm[0][k];
  }
  MpmPointPullVolume(at->flux[0], p, work, start);
  if (start->size[MPM_VECTOR_VOLUME]) start->at[MPM_VECTOR_VOLUME][p] -= at->flux[0][N] * cell->along;
  PullShare(map, p, cell, own, cell->by_mean * cell->mean[0] - cell->flux[0] * cell->along, start);
  PetscCall(MpmPointPullWeights(map, group, p, pull.end, by_input, start, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmCellsPullStart(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                 MpmPointVector *start, PetscReal gradient[])
{
  const MpmSpace *space = map->sum->space;
  MpmPointWork    work;
  Cell            cell;

  PetscFunctionBeginUser;
  PetscCall(MpmPointWorkCreate(map, &work));
  PetscCall(CellCreate(map, &cell));
  for (PetscInt c = 0; c < space->cells.count; c++) {
    PetscCall(SumPull(map, &space->cells.at[c], end, lam, &cell, &work));
    for (PetscInt g = space->cells.at[c].group_begin; g < space->cells.at[c].group_end; g++) {
      const MpmGroup *group = &space->groups[g];

      MpmPointWorkGather(map, group, lam, &work);
      for (PetscInt s = group->point_begin; s < group->point_end; s++)
        PetscCall(PullPoint(map, group, s, &(Ends){end, start}, &cell, gradient, &work));
    }
  }
  PetscCall(PetscFree(cell.at));
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}
