/*
  Columns of a depth-averaged flow from points in three dimensions.
*/
#include "options/options.h"
#include "grid/grid.h"
#include "files/point_table.h"
#include "point/registry.h"
#include "handover/handover.h"

#define ONE_PLACE 1e-9 /* of a cell of the lattice: points nearer than this have one x and y */

enum { POSITION, VOLUME, MASS, VELOCITY, HALF_LENGTH, DEFORMATION, QUANTITIES };

static const struct {
  const char *name;
  PetscInt    components;
  MpmNeed     need;
} quantities[QUANTITIES] = {{"position", 3, MPM_REQUIRED}, {"volume", 1, MPM_REQUIRED},      {"mass", 1, MPM_REQUIRED},
                            {"velocity", 3, MPM_OPTIONAL}, {"half_length", 3, MPM_OPTIONAL}, {"F", 9, MPM_OPTIONAL}};

/* Sums over the points in a cell of the lattice. */
enum { VOLUMES, MASSES, PLACES, MOMENTA = PLACES + 2, BASES = MOMENTA + 2, HEIGHTS = BASES + 2, SUMS };

typedef struct {
  PetscInt   n[2];
  PetscReal  lower[2], size[2];
  PetscReal *sum;  /* SUMS a cell */
  PetscReal *ends; /* -x, x, -y, y: extremes of the points in each */
} Lattice;

/* The cell of a place, or -1. */
static PetscInt64 Find(const Lattice *lattice, const PetscReal x[])
{
  PetscInt at[2];

  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal s = (x[a] - lattice->lower[a]) / lattice->size[a];

    if (!(s >= 0. && s <= (PetscReal)lattice->n[a])) return -1;
    at[a] = PetscMin((PetscInt)s, lattice->n[a] - 1);
  }
  return (PetscInt64)at[1] * lattice->n[0] + at[0];
}

/* Adds a point; its domain's lengths along the axes are those at the start times the stretches of F. */
static void Add(PetscReal *const value[], PetscInt p, PetscInt64 cell, Lattice *lattice)
{
  PetscReal *sum = &lattice->sum[SUMS * cell], *ends = &lattice->ends[4 * cell];
  PetscReal  volume = value[VOLUME][p], mass = value[MASS][p], U[MPM_MAX_DIM] = {1., 1., 1.};

  sum[VOLUMES] += volume;
  sum[MASSES] += mass;
  if (value[DEFORMATION] && MpmStretchFind(3)(&value[DEFORMATION][9 * p], U)) U[0] = U[1] = U[2] = 1.;
  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal x = value[POSITION][3 * p + a];

    sum[PLACES + a] += mass * (x - lattice->lower[a]);
    if (value[VELOCITY]) sum[MOMENTA + a] += mass * value[VELOCITY][3 * p + a];
    if (value[HALF_LENGTH]) sum[BASES + a] += volume * value[HALF_LENGTH][3 * p + a] * U[a];
    ends[2 * a]     = PetscMax(ends[2 * a], -x);
    ends[2 * a + 1] = PetscMax(ends[2 * a + 1], x);
  }
  if (value[HALF_LENGTH]) sum[HEIGHTS] += 2. * value[HALF_LENGTH][3 * p + 2] * U[2];
}

/* This rank's points into the lattice; the mass that is outside of it is summed. */
static PetscErrorCode Collect(const MpmOptions *block, const char *path, const char *step, Lattice *lattice,
                              PetscReal *outside)
{
  const PetscInt64 cells = (PetscInt64)lattice->n[0] * lattice->n[1];
  PetscReal       *value[QUANTITIES];
  MpmPointFile     file;

  PetscFunctionBeginUser;
  *outside = 0.;
  PetscCall(MpmPointFileOpen(block, 3, path, step, &file));
  for (PetscInt q = 0; q < QUANTITIES; q++)
    PetscCall(MpmPointFileGet(file, quantities[q].name, quantities[q].components, quantities[q].need, &value[q]));
  for (PetscInt p = 0; p < MpmPointFileCount(file); p++) {
    const PetscInt64 cell = Find(lattice, &value[POSITION][3 * p]);

    if (cell < 0) *outside += value[MASS][p];
    else Add(value, p, cell, lattice);
  }
  PetscCall(MpmPointFileClose(&file));
  for (PetscInt q = 0; q < QUANTITIES; q++) PetscCall(PetscFree(value[q]));
  for (PetscInt64 k = 0; k < cells; k += 1 << 20) {
    const PetscMPIInt some = (PetscMPIInt)PetscMin(cells - k, 1 << 20);

    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &lattice->sum[SUMS * k], SUMS * some, MPIU_REAL, MPI_SUM, block->comm));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &lattice->ends[4 * k], 4 * some, MPIU_REAL, MPI_MAX, block->comm));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, outside, 1, MPIU_REAL, MPIU_SUM, block->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The column of a cell. */
static void FillColumn(const Lattice *lattice, PetscInt64 cell, PetscInt p, MpmHandover *handover)
{
  const PetscReal *sum = &lattice->sum[SUMS * cell], *ends = &lattice->ends[4 * cell];
  PetscReal        area = 1.;
  PetscBool        one  = (PetscBool)(sum[HEIGHTS] > 0.);

  for (PetscInt a = 0; a < 2; a++)
    one = (PetscBool)(one && ends[2 * a] + ends[2 * a + 1] <= ONE_PLACE * lattice->size[a]);
  for (PetscInt a = 0; a < 2; a++) {
    handover->half_length[2 * p + a] = one ? sum[BASES + a] / sum[VOLUMES] : 0.5 * lattice->size[a];
    handover->position[2 * p + a]    = lattice->lower[a] + sum[PLACES + a] / sum[MASSES];
    handover->velocity[2 * p + a]    = sum[MOMENTA + a] / sum[MASSES];
    area *= lattice->size[a];
  }
  handover->volume[p] = sum[VOLUMES];
  handover->mass[p]   = sum[MASSES];
  handover->depth[p]  = one ? sum[HEIGHTS] : sum[VOLUMES] / area;
}

/* Each rank's share of the cells with points. */
static PetscErrorCode Fill(const MpmGrid *grid, const Lattice *lattice, MpmHandover *handover)
{
  const PetscInt64 cells = (PetscInt64)lattice->n[0] * lattice->n[1];
  const PetscInt64 first = cells * grid->rank / grid->size, end = cells * (grid->rank + 1) / grid->size;
  size_t           count = 1;

  PetscFunctionBeginUser;
  for (PetscInt64 k = first; k < end; k++) count += lattice->sum[SUMS * k + MASSES] > 0.;
  PetscCall(PetscMalloc1(2 * count, &handover->position));
  PetscCall(PetscMalloc1(2 * count, &handover->half_length));
  PetscCall(PetscMalloc1(2 * count, &handover->velocity));
  PetscCall(PetscMalloc1(count, &handover->volume));
  PetscCall(PetscMalloc1(count, &handover->mass));
  PetscCall(PetscMalloc1(count, &handover->depth));
  for (PetscInt64 k = first; k < end; k++)
    if (lattice->sum[SUMS * k + MASSES] > 0.) FillColumn(lattice, k, handover->count++, handover);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHandoverDepth(const MpmOptions *block, const MpmGrid *grid, MpmHandover *handover)
{
  PetscInt   per_cell[2] = {2, 2};
  PetscInt64 cells, count;
  PetscReal  outside;
  Lattice    lattice;
  char       text[256], *step;

  PetscFunctionBeginUser;
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(grid->dim < MPM_MAX_DIM, "-%sregion depth: exists with -mpm_physics depth_averaged only",
                block->prefix);
  PetscCall(MpmOptionsPath(block, "file", "HDF5 file of a run in three dimensions", MPM_REQUIRED, &handover->path));
  PetscCall(
    MpmOptionsText(block, "step", "which step of the file: a number, or latest", "latest", MPM_OPTIONAL, &step));
  PetscCall(
    MpmOptionsInts(block, "columns_per_cell", "columns per cell and axis", 1, 64, MPM_OPTIONAL, 2, per_cell, NULL));
  for (PetscInt a = 0; a < 2; a++) {
    lattice.n[a]     = grid->cells[a] * per_cell[a];
    lattice.lower[a] = grid->lower[a];
    lattice.size[a]  = grid->h[a] / (PetscReal)per_cell[a];
  }
  cells = (PetscInt64)lattice.n[0] * lattice.n[1];
  PetscCall(PetscCalloc1((size_t)(SUMS * cells), &lattice.sum));
  PetscCall(PetscMalloc1((size_t)(4 * cells), &lattice.ends));
  for (PetscInt64 k = 0; k < 4 * cells; k++) lattice.ends[k] = PETSC_NINFINITY;
  PetscCall(Collect(block, handover->path, step, &lattice, &outside));
  PetscCall(Fill(grid, &lattice, handover));
  count = handover->count;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT64, MPI_SUM, block->comm));
  PetscCall(PetscSNPrintf(text, sizeof(text), "points became %lld columns; %g kg are outside of the grid",
                          (long long)count, (double)outside));
  PetscCall(PetscStrallocpy(text, &handover->line));
  PetscCall(
    PetscSNPrintf(text, sizeof(text), "\"columns\": %lld, \"mass_outside\": %.17g", (long long)count, (double)outside));
  PetscCall(PetscStrallocpy(text, &handover->entries));
  PetscCall(PetscFree(lattice.sum));
  PetscCall(PetscFree(lattice.ends));
  PetscCall(PetscFree(step));
  PetscFunctionReturn(PETSC_SUCCESS);
}
