/*
  The points' part of a step's derivatives along several directions. With means over cells (step_means.h): fluxes also
  have V_q g_bar_q dm_q, where g_bar_q is the mean of the cells' sums of the flux conjugate to the mean, over V_c.
*/
#include "stepmap/point_along.h"
#include "stepmap/step_means.h"

#define ROW (1 + MPM_PACK) /* a number and its changes */

/* A pass over the steps' directions; numbers of a batch's points, where the physics has means. */
typedef struct {
  const MpmStepMap        *map;
  const MpmStepDirections *directions;
  MpmAlongWork             work;
  MpmBatch                 batch;
  MpmMeans                 means;
  PetscInt                 numbers; /* a point */
  PetscReal               *kept;
} Along;

/* Kept of one point: rows m and V; H, fluxes and dm with their changes, as the kernels have them. */
typedef struct {
  PetscReal *m, *volume, *input, *dinput, *flux, *dflux, *dm, *ddm;
} Kept;

static PetscInt KeptSize(PetscInt N)
{
  return 2 * ROW + 3 * N * ROW;
}

static Kept KeptAt(const Along *along, PetscInt s)
{
  const PetscInt N  = along->map->sum->layout->input.count;
  PetscReal     *at = &along->kept[(s - along->batch.point_begin) * KeptSize(N)], *rows = &at[2 * ROW];

  return (Kept){
    at, at + ROW, rows, rows + N, rows + N * ROW, rows + N * (ROW + 1), rows + 2 * N * ROW, rows + 2 * N * ROW + N};
}

typedef PetscErrorCode (*Visit)(Along *along, const MpmGroup *group, PetscInt s);

/* All points of the batch; forces go to the residuals, where they are made. */
static PetscErrorCode VisitPoints(Along *along, Visit visit, PetscBool forces)
{
  const MpmSpace *space = along->map->sum->space;

  PetscFunctionBeginUser;
  for (PetscInt g = along->batch.group_begin; g < along->batch.group_end; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmAlongGather(along->map, along->directions, group, &along->work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) PetscCall((*visit)(along, group, s));
    if (forces) MpmAlongScatter(along->map, along->directions, group, &along->work);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- means ---- */

/* The volume at the step's start, with its changes. */
static void TakeVolume(const Along *along, PetscInt p, PetscReal volume[])
{
  const MpmPoints *points = along->map->sum->points;
  PetscReal        cofactor[MPM_F_MAX];

  volume[0] = points->volume0[p] * MpmCofactors(points->F_size, MpmPointF(points, p), cofactor);
  for (PetscInt j = 0; j < MPM_PACK; j++) volume[1 + j] = 0.;
  for (PetscInt k = 0; k < points->F_size; k++)
    MpmPackAdd(points->volume0[p] * cofactor[k], &along->work.dF[k * MPM_PACK], &volume[1]);
  for (PetscInt j = 0; j < along->directions->count; j++)
    volume[1 + j] += volume[0] * MpmPointNumber(along->directions->of[j].start, MPM_VECTOR_VOLUME, p);
}

static PetscErrorCode TakeMean(Along *along, const MpmGroup *group, PetscInt s)
{
  const MpmStepMap  *map  = along->map;
  MpmAlongWork      *work = &along->work;
  const PetscInt     p = map->sum->space->order[s], N = work->point.known.inputs;
  const Kept         at = KeptAt(along, s);
  MpmKernelPoint     point;
  MpmKernelDirection direction;

  PetscFunctionBeginUser;
  PetscCall(MpmAlongEnter(map, along->directions, group, p, work, &point));
  direction = MpmAlongDirection(map, along->directions, p, work);
  PetscCheck(!map->sum->layout->kernel->mean_sensitivity(&point, work->point.input, &direction, at.m, at.dm, at.ddm),
             PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no mean at the solution of its step");
  PetscCall(PetscArraycpy(at.input, work->point.input, N));
  PetscCall(PetscArraycpy(at.dinput, work->dinput, N * MPM_PACK));
  TakeVolume(along, p, at.volume);
  MpmAlongPlace(map, along->directions, p, work);
  MpmMeansEnter(&along->means, group, p, work->argument);
  MpmMeansAddFirst(&along->means, at.volume, at.m);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fluxes, and the step's end but for the place. */
static PetscErrorCode TakeFlux(Along *along, const MpmGroup *group, PetscInt s)
{
  const MpmStepMap *map  = along->map;
  MpmAlongWork     *work = &along->work;
  const PetscInt    p = map->sum->space->order[s], N = work->point.known.inputs;
  const Kept        at = KeptAt(along, s);
  PetscReal         row[ROW];
  MpmKernelPoint    point;

  PetscFunctionBeginUser;
  if (along->means.spread) PetscCall(MpmAlongArguments(map, along->directions, group, p, work));
  MpmMeansEnter(&along->means, group, p, work->argument);
  MpmMeansAt(&along->means, 0, 0, row);
  PetscCall(PetscArraycpy(work->point.input, at.input, N));
  PetscCall(PetscArraycpy(work->dinput, at.dinput, N * MPM_PACK));
  work->point.input[N] = row[0];
  PetscCall(PetscArraycpy(&work->dinput[N * MPM_PACK], &row[1], MPM_PACK));
  MpmPointMake(map, p, &work->point, &point);
  PetscCall(MpmAlongDifferentiate(map, along->directions, p, &point, work));
  PetscCall(PetscArraycpy(at.flux, work->point.flux, N));
  PetscCall(PetscArraycpy(at.dflux, work->dflux, N * MPM_PACK));
  row[0] = work->point.flux[N];
  PetscCall(PetscArraycpy(&row[1], &work->dflux[N * MPM_PACK], MPM_PACK));
  MpmMeansAddSecond(&along->means, row);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fluxes of a point, with the means' part. */
static PetscErrorCode MeanFluxes(Along *along, const MpmGroup *group, PetscInt s)
{
  const Kept     at   = KeptAt(along, s);
  const PetscInt N    = along->work.point.known.inputs;
  PetscReal     *flux = along->work.point.flux, *dflux = along->work.dflux, g[ROW], back[ROW];

  PetscFunctionBeginUser;
  MpmMeansEnter(&along->means, group, along->map->sum->space->order[s], along->work.argument);
  MpmMeansAt(&along->means, 1, 0, g);
  back[0] = at.volume[0] * g[0];
  for (PetscInt j = 1; j < ROW; j++) back[j] = at.volume[j] * g[0] + at.volume[0] * g[j];
  for (PetscInt k = 0; k < N; k++) {
    flux[k] = at.flux[k] + back[0] * at.dm[k];
    for (PetscInt j = 0; j < MPM_PACK; j++)
      dflux[k * MPM_PACK + j] =
        at.dflux[k * MPM_PACK + j] + back[1 + j] * at.dm[k] + back[0] * at.ddm[k * MPM_PACK + j];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TakeMeans(Along *along)
{
  PetscFunctionBeginUser;
  PetscCall(MpmMeansBegin(&along->means));
  PetscCall(VisitPoints(along, TakeMean, PETSC_FALSE));
  PetscCall(MpmMeansClose(&along->means, 0));
  PetscCall(VisitPoints(along, TakeFlux, PETSC_FALSE));
  PetscCall(MpmMeansClose(&along->means, 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all points ---- */

/* Forces and, without means, the step's end. */
static PetscErrorCode AddForces(Along *along, const MpmGroup *group, PetscInt s)
{
  const PetscInt p    = along->map->sum->space->order[s];
  MpmAlongWork  *work = &along->work;
  MpmKernelPoint point;

  PetscFunctionBeginUser;
  PetscCall(MpmAlongEnter(along->map, along->directions, group, p, work, &point));
  if (along->kept) PetscCall(MeanFluxes(along, group, s));
  else {
    PetscCall(MpmAlongDifferentiate(along->map, along->directions, p, &point, work));
    MpmAlongPlace(along->map, along->directions, p, work);
  }
  if (along->directions->residual) MpmAlongForces(along->map, along->directions, work->point.flux, work->dflux, work);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsAlong(const MpmStepMap *map, const MpmStepDirections *directions)
{
  const PetscInt means = map->sum->layout->means;
  Along          along = {.map = map, .directions = directions};

  PetscFunctionBeginUser;
  PetscCall(MpmAlongWorkCreate(map, &along.work));
  if (means) {
    PetscCall(MpmMeansCreate(map, ROW, 1, 1, &along.means));
    PetscCall(PetscMalloc1((MpmBatchMost(map) * KeptSize(map->sum->layout->input.count) + 1), &along.kept));
  }
  for (PetscInt b = 0; b < MpmBatchCount(map); b++) {
    along.batch = MpmBatchAt(map, b);
    if (means) PetscCall(TakeMeans(&along));
    if (directions->residual || !means)
      PetscCall(VisitPoints(&along, AddForces, (PetscBool)(directions->residual != NULL)));
  }
  if (means) PetscCall(MpmMeansDestroy(&along.means));
  PetscCall(PetscFree(along.kept));
  PetscCall(MpmAlongWorkDestroy(&along.work));
  PetscFunctionReturn(PETSC_SUCCESS);
}
