/*
  The background grid: a regular lattice of which only the window around the material is spread over the ranks.
*/
#include "mpmimpl.h"

PetscErrorCode MpmGridSetFromOptions(MpmGrid *grid, const MpmOptions *options, PetscInt dim)
{
  const MpmOptions block  = {options->comm, "mpm_grid_", options->record};
  PetscInt         refine = 1;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(grid, sizeof(*grid)));
  grid->comm = options->comm;
  grid->dim  = dim;
  PetscCallMPI(MPI_Comm_rank(grid->comm, &grid->rank));
  PetscCallMPI(MPI_Comm_size(grid->comm, &grid->size));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    grid->cells[a] = grid->nodes[a] = 1;
    grid->h[a]                      = 1.;
  }
  PetscCall(MpmOptionsHeading(&block, "Grid"));
  PetscCall(MpmOptionsReals(&block, "lower", "m", "lower corner", MPM_RANGE_ANY, MPM_REQUIRED, dim, grid->lower, NULL));
  PetscCall(MpmOptionsReals(&block, "upper", "m", "upper corner", MPM_RANGE_ANY, MPM_REQUIRED, dim, grid->upper, NULL));
  PetscCall(MpmOptionsInts(&block, "cells", "cells per axis", 1, 999999999, MPM_REQUIRED, dim, grid->cells, NULL));
  PetscCall(MpmOptionsInt(&block, "refine", "multiplies the cells per axis", 1, 1000000, MPM_OPTIONAL, &refine, NULL));
  for (PetscInt a = 0; a < dim && !MpmOptionsHelp(); a++) {
    MpmCheckInput(grid->upper[a] > grid->lower[a],
                  "-mpm_grid_upper: axis %c ends at %g, must lie above -mpm_grid_lower, %g", "xyz"[a],
                  (double)(grid->upper[a]), (double)(grid->lower[a]));
    MpmCheckInput((PetscInt64)grid->cells[a] * refine < 1000000000,
                  "-mpm_grid_refine %" PetscInt_FMT ": too many cells on axis %c", refine, "xyz"[a]);
    grid->cells[a] *= refine;
    grid->nodes[a] = grid->cells[a] + 1;
    grid->h[a]     = (grid->upper[a] - grid->lower[a]) / (PetscReal)grid->cells[a];
    MpmCheckInput(
      grid->h[a] > 1e-300 && grid->h[a] > 1e-12 * PetscMax(PetscAbsReal(grid->lower[a]), PetscAbsReal(grid->upper[a])),
      "-mpm_grid_cells: a cell of %g on axis %c is too small for its coordinates", (double)(grid->h[a]), "xyz"[a]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GridResetWindow(MpmGrid *grid)
{
  PetscFunctionBeginUser;
  PetscCall(DMDestroy(&grid->da));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) PetscCall(PetscFree(grid->proc_of[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridDestroy(MpmGrid *grid)
{
  PetscFunctionBeginUser;
  PetscCall(GridResetWindow(grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmGridFindCell(const MpmGrid *grid, const PetscReal x[], PetscInt cell[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) cell[a] = 0;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal xi = PetscFloorReal((x[a] - grid->lower[a]) / grid->h[a]);

    cell[a] = (PetscInt)PetscMin(PetscMax(xi, 0.), (PetscReal)(grid->cells[a] - 1));
  }
}

PetscMPIInt MpmGridNodeOwner(const MpmGrid *grid, const PetscInt node[])
{
  PetscInt proc[MPM_MAX_DIM] = {0, 0, 0};

  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscInt i = node[a] - grid->window_lower[a];

    proc[a] = grid->proc_of[a][PetscMin(PetscMax(i, 0), grid->window_nodes[a] - 1)];
  }
  return (PetscMPIInt)((proc[2] * grid->procs[1] + proc[1]) * grid->procs[0] + proc[0]);
}

/* ---- partition ---- */

/* How the window is cut: `procs` ranks an axis, rank coordinate k owning window nodes [begin[k], begin[k+1]). */
typedef struct {
  PetscInt  procs[MPM_MAX_DIM];
  PetscInt *begin[MPM_MAX_DIM];
} Cut;

/* The window: the cells that hold points and the nodes around them, with a margin to move in. */
static PetscErrorCode GridFindWindow(MpmGrid *grid, PetscInt count, const PetscReal x[])
{
  PetscInt bound[2 * MPM_MAX_DIM]; /* minima and negated maxima */

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    bound[a]               = grid->cells[a];
    bound[MPM_MAX_DIM + a] = 0;
  }
  for (PetscInt p = 0; p < count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    MpmGridFindCell(grid, &x[p * grid->dim], cell);
    for (PetscInt a = 0; a < grid->dim; a++) {
      bound[a]               = PetscMin(bound[a], cell[a]);
      bound[MPM_MAX_DIM + a] = PetscMin(bound[MPM_MAX_DIM + a], -cell[a]);
    }
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, bound, 2 * MPM_MAX_DIM, MPIU_INT, MPI_MIN, grid->comm));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const PetscInt lower = bound[a], upper = -bound[MPM_MAX_DIM + a] + 1;
    const PetscInt margin = 3 + (upper - lower) / 10;

    grid->window_lower[a] = a < grid->dim ? PetscMax(lower - margin, 0) : 0;
    grid->window_nodes[a] =
      a < grid->dim ? PetscMin(upper + margin, grid->nodes[a] - 1) - grid->window_lower[a] + 1 : 1;
    /* every rank needs a node, even where there is little material */
    while (a < grid->dim && grid->window_nodes[a] < PetscMin(grid->nodes[a], (PetscInt)grid->size)) {
      if (grid->window_lower[a] > 0) grid->window_lower[a]--;
      grid->window_nodes[a] = PetscMin(grid->window_nodes[a] + 1, grid->nodes[a] - grid->window_lower[a]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Points per cell layer of the window along one axis, over all ranks. */
static PetscErrorCode GridHistogram(const MpmGrid *grid, PetscInt axis, PetscInt count, const PetscReal x[],
                                    PetscInt64 **histogram)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->window_nodes[axis], histogram));
  for (PetscInt p = 0; p < count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    MpmGridFindCell(grid, &x[p * grid->dim], cell);
    (*histogram)[cell[axis] - grid->window_lower[axis]]++;
  }
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, *histogram, (PetscMPIInt)grid->window_nodes[axis], MPIU_INT64, MPI_SUM, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Splits one axis so that every part holds about as many points, and at least one node. Returns the points at the cuts.
*/
static PetscInt64 SplitAxis(PetscInt nodes, const PetscInt64 histogram[], PetscInt procs, PetscInt begin[])
{
  PetscInt64 total = 0, sum = 0, at_cuts = 0;
  PetscInt   i = 0;

  for (PetscInt k = 0; k < nodes; k++) total += histogram[k];
  begin[0] = 0;
  for (PetscInt part = 1; part < procs; part++) {
    const PetscReal target = (PetscReal)total * (PetscReal)part / (PetscReal)procs;
    const PetscInt  lower = begin[part - 1] + 1, upper = nodes - (procs - part);

    while (i < upper && (i < lower || (PetscReal)sum + 0.5 * (PetscReal)histogram[i] < target)) sum += histogram[i++];
    begin[part] = i;
    if (i > 0) at_cuts += PetscMin(histogram[i - 1], histogram[PetscMin(i, nodes - 1)]);
  }
  begin[procs] = nodes;
  return at_cuts;
}

/* The cost of a cut: points on the fullest rank, and something for the points beside its faces. */
static PetscErrorCode CutCost(MpmGrid *grid, const Cut *cut, PetscInt64 at_cuts, PetscInt count, const PetscReal x[],
                              PetscReal *cost)
{
  PetscInt64 *load, most = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->size, &load));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    grid->procs[a] = cut->procs[a];
    for (PetscInt k = 0; k < cut->procs[a]; k++)
      for (PetscInt i = cut->begin[a][k]; i < cut->begin[a][k + 1]; i++) grid->proc_of[a][i] = k;
  }
  for (PetscInt p = 0; p < count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    MpmGridFindCell(grid, &x[p * grid->dim], cell);
    load[MpmGridNodeOwner(grid, cell)]++;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, load, grid->size, MPIU_INT64, MPI_SUM, grid->comm));
  for (PetscMPIInt r = 0; r < grid->size; r++) most = PetscMax(most, load[r]);
  *cost = (PetscReal)most + 0.25 * (PetscReal)at_cuts / (PetscReal)grid->size;
  PetscCall(PetscFree(load));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode GridCreateDMDA(MpmGrid *grid, const Cut *cut)
{
  const DMBoundaryType none = DM_BOUNDARY_NONE;
  PetscInt            *range[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    PetscCall(PetscMalloc1(cut->procs[a], &range[a]));
    for (PetscInt k = 0; k < cut->procs[a]; k++) {
      range[a][k] = cut->begin[a][k + 1] - cut->begin[a][k];
      for (PetscInt i = cut->begin[a][k]; i < cut->begin[a][k + 1]; i++) grid->proc_of[a][i] = k;
    }
    grid->procs[a] = cut->procs[a];
  }
  /* ghost exchange follows the active nodes, not the window: no stencil width is needed here */
  if (grid->dim == 2) {
    PetscCall(DMDACreate2d(grid->comm, none, none, DMDA_STENCIL_BOX, grid->window_nodes[0], grid->window_nodes[1],
                           cut->procs[0], cut->procs[1], 1, 0, range[0], range[1], &grid->da));
  } else {
    PetscCall(DMDACreate3d(grid->comm, none, none, none, DMDA_STENCIL_BOX, grid->window_nodes[0], grid->window_nodes[1],
                           grid->window_nodes[2], cut->procs[0], cut->procs[1], cut->procs[2], 1, 0, range[0], range[1],
                           range[2], &grid->da));
  }
  PetscCall(DMSetUp(grid->da));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) PetscCall(PetscFree(range[a]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tries every way to factor the ranks over the axes and keeps the cheapest. */
static PetscErrorCode GridChooseCut(MpmGrid *grid, PetscInt64 *const histogram[], PetscInt count, const PetscReal x[],
                                    Cut *best)
{
  PetscReal best_cost = PETSC_MAX_REAL;
  Cut       trial;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) PetscCall(PetscMalloc1((grid->size + 1), &trial.begin[a]));
  for (PetscInt n = 1; n <= grid->size; n++) {
    for (PetscInt m = 1; m <= grid->size / n; m++) {
      PetscInt64 at_cuts = 0;
      PetscReal  cost    = 0.;
      PetscBool  fits    = PETSC_TRUE;

      if (grid->size % (m * n)) continue;
      trial.procs[0] = m;
      trial.procs[1] = n;
      trial.procs[2] = grid->size / (m * n);
      for (PetscInt a = 0; a < MPM_MAX_DIM; a++) fits = (PetscBool)(fits && trial.procs[a] <= grid->window_nodes[a]);
      if (!fits) continue;
      for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
        at_cuts += SplitAxis(grid->window_nodes[a], histogram[a], trial.procs[a], trial.begin[a]);
      PetscCall(CutCost(grid, &trial, at_cuts, count, x, &cost));
      if (cost < best_cost) {
        best_cost = cost;
        for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
          best->procs[a] = trial.procs[a];
          PetscCall(PetscArraycpy(best->begin[a], trial.begin[a], trial.procs[a] + 1));
        }
      }
    }
  }
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) PetscCall(PetscFree(trial.begin[a]));
  MpmCheckInput(best_cost < PETSC_MAX_REAL, "-mpm_grid_cells: the grid has too few nodes for %d ranks", grid->size);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridPartition(MpmGrid *grid, PetscInt count, const PetscReal x[])
{
  PetscInt64 *histogram[MPM_MAX_DIM];
  Cut         cut;

  PetscFunctionBeginUser;
  PetscCall(GridResetWindow(grid));
  PetscCall(GridFindWindow(grid, count, x));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    PetscCall(PetscCalloc1(grid->window_nodes[a], &grid->proc_of[a]));
    PetscCall(PetscMalloc1((grid->size + 1), &cut.begin[a]));
    PetscCall(GridHistogram(grid, a, count, x, &histogram[a]));
  }
  PetscCall(GridChooseCut(grid, histogram, count, x, &cut));
  PetscCall(GridCreateDMDA(grid, &cut));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    PetscCall(PetscFree(cut.begin[a]));
    PetscCall(PetscFree(histogram[a]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the partition as numbers ---- */

PetscErrorCode MpmGridGetCut(const MpmGrid *grid, PetscInt *count, PetscInt **numbers)
{
  PetscInt *number;

  PetscFunctionBeginUser;
  *count = 3 * MPM_MAX_DIM;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) *count += grid->window_nodes[a];
  PetscCall(PetscMalloc1(*count, numbers));
  number = *numbers;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    *number++ = grid->window_lower[a];
    *number++ = grid->window_nodes[a];
    *number++ = grid->procs[a];
  }
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
    for (PetscInt i = 0; i < grid->window_nodes[a]; i++) *number++ = grid->proc_of[a][i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridSetCut(MpmGrid *grid, PetscInt count, const PetscInt numbers[], PetscBool *set)
{
  const PetscInt *number = &numbers[3 * MPM_MAX_DIM];
  PetscInt        needed = 3 * MPM_MAX_DIM, ranks = 1;
  Cut             cut;

  PetscFunctionBeginUser;
  *set = PETSC_FALSE;
  for (PetscInt a = 0; a < MPM_MAX_DIM && count >= 3 * MPM_MAX_DIM; a++) {
    needed += numbers[3 * a + 1];
    ranks *= numbers[3 * a + 2];
  }
  if (count != needed || ranks != grid->size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(GridResetWindow(grid));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    grid->window_lower[a] = numbers[3 * a];
    grid->window_nodes[a] = numbers[3 * a + 1];
    cut.procs[a]          = numbers[3 * a + 2];
    PetscCall(PetscCalloc1(grid->window_nodes[a], &grid->proc_of[a]));
    PetscCall(PetscCalloc1((cut.procs[a] + 1), &cut.begin[a]));
    for (PetscInt i = 0; i < grid->window_nodes[a]; i++) cut.begin[a][*number++ + 1] = i + 1;
  }
  PetscCall(GridCreateDMDA(grid, &cut));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) PetscCall(PetscFree(cut.begin[a]));
  *set = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}
