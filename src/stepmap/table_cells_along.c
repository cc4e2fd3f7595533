/*
  The points' part of a step's derivatives along several directions where the physics has a mean over the cell, as
  cells_map.c has it for one.
*/
#include "points/cell_mean.h"
#include "stepmap/table_along.h"

/* One point of the cell: mean, its derivatives, volume, share, fluxes, that of the mean last, and inputs; d: rows of
   their changes. */
typedef struct {
  PetscReal m, dm[MPM_MAX_INPUTS], volume, share, flux[MPM_MAX_INPUTS], input[MPM_MAX_INPUTS];
  PetscReal d_m[MPM_PACK], d_dm[MPM_MAX_INPUTS * MPM_PACK], d_volume[MPM_PACK], d_share[MPM_PACK];
  PetscReal d_flux[MPM_MAX_INPUTS * MPM_PACK], d_input[MPM_MAX_INPUTS * MPM_PACK];
} CellPoint;

/* Sums of the cell. */
typedef struct {
  CellPoint *at;
  PetscInt   begin;
  PetscReal  volume, mean, flux, d_volume[MPM_PACK], d_mean[MPM_PACK], d_flux[MPM_PACK];
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

/* A point's volume. */
static void TakeVolume(const MpmStepMap *map, PetscInt p, const PetscReal dF[], CellPoint *at, Cell *cell)
{
  const MpmPoints *points = map->sum->points;
  PetscReal        cofactor[MPM_F_MAX];

  at->volume = points->volume0[p] * MpmCofactors(points->F_size, MpmPointF(points, p), cofactor);
  cell->volume += at->volume;
  for (PetscInt j = 0; j < MPM_PACK; j++) {
    at->d_volume[j] = 0.;
    for (PetscInt k = 0; k < points->F_size; k++)
      at->d_volume[j] += points->volume0[p] * cofactor[k] * dF[k * MPM_PACK + j];
    cell->d_volume[j] += at->d_volume[j];
  }
}

/* First pass: inputs, volumes and means. */
static PetscErrorCode TakeMeans(const MpmStepMap *map, const MpmStepDirections *directions, const MpmCell *of,
                                Cell *cell, MpmAlongWork *work)
{
  const MpmSpace *space = map->sum->space;

  PetscFunctionBeginUser;
  for (PetscInt g = of->group_begin; g < of->group_end; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmAlongGather(map, directions, group, work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt     p = space->order[s], N = work->point.known.inputs;
      CellPoint         *at = &cell->at[s - cell->begin];
      MpmKernelPoint     point;
      MpmKernelDirection direction;
      PetscReal          m[1 + MPM_PACK];

      PetscCall(MpmAlongEnter(map, directions, group, p, work, &point));
      direction = MpmAlongDirection(map, directions, p, work);
      PetscCheck(
        !map->sum->layout->kernel->mean_sensitivity(&point, work->point.input, &direction, m, at->dm, at->d_dm),
        PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no mean at the solution of its step");
      at->m = m[0];
      PetscCall(PetscArraycpy(at->d_m, &m[1], MPM_PACK));
      PetscCall(PetscArraycpy(at->input, work->point.input, N));
      PetscCall(PetscArraycpy(at->d_input, work->dinput, N * MPM_PACK));
      TakeVolume(map, p, work->dF, at, cell);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shares, and the mean. */
static void FindMean(PetscInt count, Cell *cell)
{
  for (PetscInt s = 0; s < count; s++) {
    CellPoint *at = &cell->at[s];

    at->share = at->volume / cell->volume;
    cell->mean += at->share * at->m;
    for (PetscInt j = 0; j < MPM_PACK; j++) {
      at->d_share[j] = (at->d_volume[j] - at->share * cell->d_volume[j]) / cell->volume;
      cell->d_mean[j] += at->d_share[j] * at->m + at->share * at->d_m[j];
    }
  }
}

/* Second pass: fluxes, and the step's end but for the place. */
static PetscErrorCode TakeFluxes(const MpmStepMap *map, const MpmStepDirections *directions, const MpmCell *of,
                                 Cell *cell, MpmAlongWork *work)
{
  const PetscInt N = work->point.known.inputs;

  PetscFunctionBeginUser;
  for (PetscInt s = cell->begin; s < MpmCellEnd(map->sum, of); s++) {
    const PetscInt p  = map->sum->space->order[s];
    CellPoint     *at = &cell->at[s - cell->begin];
    MpmKernelPoint point;

    MpmPointMake(map, p, &work->point, &point);
    PetscCall(PetscArraycpy(work->point.input, at->input, N));
    PetscCall(PetscArraycpy(work->dinput, at->d_input, N * MPM_PACK));
    work->point.input[N] = cell->mean;
    PetscCall(PetscArraycpy(&work->dinput[N * MPM_PACK], cell->d_mean, MPM_PACK));
    PetscCall(MpmAlongDifferentiate(map, directions, p, &point, work));
    PetscCall(PetscArraycpy(at->flux, work->point.flux, N + 1));
    PetscCall(PetscArraycpy(at->d_flux, work->dflux, (N + 1) * MPM_PACK));
    cell->flux += at->flux[N];
    for (PetscInt j = 0; j < MPM_PACK; j++) cell->d_flux[j] += at->d_flux[N * MPM_PACK + j];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Third pass: forces, with the mean's part f w dm of the fluxes, and places. */
static PetscErrorCode AddForces(const MpmStepMap *map, const MpmStepDirections *directions, const MpmCell *of,
                                const Cell *cell, MpmAlongWork *work)
{
  const MpmSpace *space = map->sum->space;

  PetscFunctionBeginUser;
  for (PetscInt g = of->group_begin; g < of->group_end; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmAlongGather(map, directions, group, work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt   p  = space->order[s];
      const CellPoint *at = &cell->at[s - cell->begin];
      MpmKernelPoint   point;

      PetscCall(MpmAlongEnter(map, directions, group, p, work, &point));
      MpmAlongPlace(map, directions, p, work);
      for (PetscInt k = 0; k < work->point.known.inputs; k++) {
        work->point.flux[k] = at->flux[k] + cell->flux * at->share * at->dm[k];
        for (PetscInt j = 0; j < MPM_PACK; j++)
          work->dflux[k * MPM_PACK + j] =
            at->d_flux[k * MPM_PACK + j] + cell->d_flux[j] * at->share * at->dm[k] +
            cell->flux * (at->d_share[j] * at->dm[k] + at->share * at->d_dm[k * MPM_PACK + j]);
      }
      MpmAlongForces(map, directions, work->point.flux, work->dflux, work);
    }
    MpmAlongScatter(map, directions, group, work);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTableCellsAlong(const MpmStepMap *map, const MpmStepDirections *directions)
{
  const MpmSpace *space = map->sum->space;
  MpmAlongWork    work;
  Cell            cell;

  PetscFunctionBeginUser;
  PetscCall(MpmAlongWorkCreate(map, &work));
  PetscCall(CellCreate(map, &cell));
  for (PetscInt c = 0; c < space->cells.count; c++) {
    const MpmCell *of = &space->cells.at[c];

    cell = (Cell){.at = cell.at, .begin = MpmCellBegin(map->sum, of)};
    PetscCall(TakeMeans(map, directions, of, &cell, &work));
    FindMean(MpmCellEnd(map->sum, of) - cell.begin, &cell);
    PetscCall(TakeFluxes(map, directions, of, &cell, &work));
    PetscCall(AddForces(map, directions, of, &cell, &work));
  }
  PetscCall(PetscFree(cell.at));
  PetscCall(MpmAlongWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}
