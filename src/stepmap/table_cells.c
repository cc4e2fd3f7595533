/*
  The points' part of a step's pull where the physics has a mean over the cell, with a table: L as in cells_map.c.
*/
#include "points/cell_mean.h"
#include "stepmap/point_table.h"

/* One point of the cell: its volume and share of it, mean and derivatives of it, H and K. */
typedef struct {
  PetscReal volume, share, m, dm[MPM_MAX_INPUTS], input[MPM_MAX_INPUTS], other_input[MPM_MAX_INPUTS];
} CellPoint;

/* Sums of the cell. */
typedef struct {
  CellPoint *at;
  PetscInt   begin;
  PetscReal  volume, mean, flux, along, by_mean;
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

/* The points' H and K, means and M. The table is filled where there are bars. */
static PetscErrorCode SumMeans(const MpmStepMap *map, const MpmCell *of, const MpmPointVector *end,
                               const PetscReal lam[], Cell *cell, MpmPointWork *work)
{
  const MpmSpace  *space  = map->sum->space;
  const MpmPoints *points = map->sum->points;

  PetscFunctionBeginUser;
  for (PetscInt g = of->group_begin; g < of->group_end; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, lam, work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt   p = space->order[s], N = work->known.inputs;
      const PetscReal *mean = MpmPointTableMean(map->table, p);
      CellPoint       *at   = &cell->at[s - cell->begin];
      MpmKernelPoint   point;

      MpmPointEnter(map, p, PETSC_TRUE, work, &point);
      if (end) PetscCall(MpmPointTableFillMean(map, p, &point, work));
      PetscCall(PetscArraycpy(at->input, work->input, N));
      PetscCall(PetscArraycpy(at->other_input, work->other_input, N));
      at->volume = points->volume0[p] * MpmDeterminant(points->F_size, MpmPointF(points, p));
      at->m      = mean[0];
      PetscCall(PetscArraycpy(at->dm, &mean[1], N));
      for (PetscInt k = 0; k < N; k++) cell->along += at->volume * at->dm[k] * at->other_input[k];
      cell->volume += at->volume;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fluxes, and dL/dm_bar. */
static PetscErrorCode SumFluxes(const MpmStepMap *map, const MpmCell *of, const MpmPointVector *end, Cell *cell,
                                MpmPointWork *work)
{
  const PetscInt    N = work->known.inputs, packs = MpmPointTableInputPacks(map->table);
  const MpmMeanPull mean = {.along = cell->along};

  PetscFunctionBeginUser;
  for (PetscInt s = cell->begin; s < MpmCellEnd(map->sum, of); s++) {
    const PetscInt   p  = map->sum->space->order[s];
    const CellPoint *at = &cell->at[s - cell->begin];
    PetscReal        totals[MPM_MAX_INPUTS + MPM_PACK];
    MpmKernelPoint   point;

    PetscCall(PetscArraycpy(work->input, at->input, N));
    PetscCall(PetscArraycpy(work->other_input, at->other_input, N));
    work->input[N] = cell->mean;
    if (end) {
      MpmPointMake(map, p, work, &point);
      PetscCall(MpmPointTableFill(map, p, &point, end, work));
    }
    MpmPointTableTotals(map, p, packs, &mean, work, totals);
    cell->flux += MpmPointTableFlux(map->table, p)[N];
    cell->by_mean += totals[N];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The cell's sums; `end` NULL: with the table as it is. */
static PetscErrorCode SumPull(const MpmStepMap *map, const MpmCell *of, const MpmPointVector *end,
                              const PetscReal lam[], Cell *cell, MpmPointWork *work)
{
  PetscFunctionBeginUser;
  cell->begin  = MpmCellBegin(map->sum, of);
  cell->volume = cell->mean = cell->flux = cell->along = cell->by_mean = 0.;
  PetscCall(SumMeans(map, of, end, lam, cell, work));
  for (PetscInt s = 0; s < MpmCellEnd(map->sum, of) - cell->begin; s++) {
    cell->at[s].share = cell->at[s].volume / cell->volume;
    cell->mean += cell->at[s].share * cell->at[s].m;
  }
  cell->along /= cell->volume;
  PetscCall(SumFluxes(map, of, end, cell, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmMeanPull MeanPull(const Cell *cell, const CellPoint *at)
{
  return (MpmMeanPull){at->share, cell->by_mean, cell->flux, cell->along};
}

PetscErrorCode MpmTableCellsPullSolution(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                         PetscReal u[])
{
  const MpmSpace *space = map->sum->space;
  const PetscInt  packs = MpmPointTableInputPacks(map->table);
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
        PetscReal         by_input[MPM_MAX_INPUTS + MPM_PACK];
        MpmKernelPoint    point;

        MpmPointEnter(map, p, PETSC_TRUE, &work, &point);
        MpmPointTableTotals(map, p, packs, &mean, &work, by_input);
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

/* dL by F_n through the point's share; `own` is A m_q - f dm_q . K_q, `all` its mean. */
static void PullShare(const MpmStepMap *map, PetscInt p, const Cell *cell, PetscReal own, PetscReal all,
                      MpmPointVector *start)
{
  const MpmPoints *points = map->sum->points;
  PetscReal        cofactor[MPM_F_MAX];

  (void)MpmCofactors(points->F_size, MpmPointF(points, p), cofactor);
  for (PetscInt k = 0; k < points->F_size; k++)
    start->F[p * points->F_size + k] += (own - all) / cell->volume * points->volume0[p] * cofactor[k];
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
  const CellPoint  *at   = &cell->at[s - cell->begin];
  const MpmMeanPull mean = MeanPull(cell, at);
  const PetscInt    p    = map->sum->space->order[s];
  const PetscReal  *flux = MpmPointTableFlux(map->table, p);
  PetscReal         own = cell->by_mean * at->m, *totals = map->table->totals;

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(work->other_input, at->other_input, work->known.inputs));
  MpmPointTableTotals(map, p, MpmPointTablePacks(map, p), &mean, work, totals);
  MpmPointTableAdd(map, p, totals, ends->start, gradient);
  for (PetscInt k = 0; k < work->known.inputs; k++) {
    own -= cell->flux * at->dm[k] * work->other_input[k];
    work->flux[k] = flux[k] + cell->flux * at->share * at->dm[k];
  }
  PullShare(map, p, cell, own, cell->by_mean * cell->mean - cell->flux * cell->along, ends->start);
  PetscCall(MpmTablePullWeights(map, group, p, ends->end, totals, ends->start, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTableCellsPullStart(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                      MpmPointVector *start, PetscReal gradient[])
{
  const MpmSpace *space = map->sum->space;
  MpmPointWork    work;
  Cell            cell;

  PetscFunctionBeginUser;
  PetscCall(MpmPointWorkCreate(map, &work));
  PetscCall(CellCreate(map, &cell));
  for (PetscInt c = 0; c < space->cells.count; c++) {
    PetscCall(SumPull(map, &space->cells.at[c], NULL, lam, &cell, &work));
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
