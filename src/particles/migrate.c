/*
  Points on the move between ranks, and the partition that follows them.

  Ownership is arithmetic on the grid: the rank that owns a cell's lower node owns the points in it, so a point goes to
  its rank in one message however far it moved.
*/
#include "base/outcome.h"
#include "grid/grid.h"
#include "grid/partition.h"
#include "particles/particles.h"

/* Another partition is taken when the fullest rank then holds this much less. */
#define BALANCE_GAIN 1.02

/* ---- points on the move ---- */

/* A point that this rank has sent away, kept until all have arrived. */
typedef struct {
  PetscInt  id;
  PetscReal x[MPM_MAX_DIM];
} Traveller;

/* In C's own format: PETSc's writes a dot behind whole numbers. */
static void Describe(MpmParticles *particles, PetscInt id, const char *what, const PetscReal x[])
{
  char third[32] = "";

  if (particles->dim > 2) snprintf(third, sizeof(third), ", %g", (double)x[2]);
  snprintf(particles->lost, sizeof(particles->lost), "point %lld %s (%g, %g%s)", (long long)id, what, (double)x[0],
           (double)x[1], third);
}

/* All ranks get the text in particles->lost of the lowest rank that has one. */
static PetscErrorCode ShareLost(MpmParticles *particles, const MpmGrid *grid, PetscBool tell, PetscBool *told)
{
  PetscMPIInt rank = tell ? grid->rank : grid->size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rank, 1, MPI_INT, MPI_MIN, grid->comm));
  *told = (PetscBool)(rank < grid->size);
  if (*told) PetscCallMPI(MPI_Bcast(particles->lost, (PetscMPIInt)sizeof(particles->lost), MPI_CHAR, rank, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Finds the id that is missing, or there twice, and its last place, where the points are not those before. */
static PetscErrorCode FindMissing(MpmParticles *particles, const MpmGrid *grid, PetscInt count,
                                  const Traveller travellers[])
{
  PetscInt   *id, local, rows, first, *found, *once, wrong[2] = {PETSC_INT_MAX, 0}, ids = (PetscInt)particles->total;
  PetscLayout layout;
  PetscSF     sf;
  PetscBool   seen = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &local));
  PetscCall(MpmParticlesGetField(particles, "id", &id));
  for (PetscInt p = 0; p < local; p++) ids = PetscMax(ids, id[p] + 1); /* bodies that were taken away leave holes */
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &ids, 1, MPIU_INT, MPI_MAX, grid->comm));
  PetscCall(PetscLayoutCreateFromSizes(grid->comm, PETSC_DECIDE, ids, 1, &layout));
  PetscCall(PetscLayoutGetLocalSize(layout, &rows));
  PetscCall(PetscLayoutGetRange(layout, &first, NULL));
  PetscCall(PetscSFCreate(grid->comm, &sf));
  PetscCall(PetscSFSetGraphLayout(sf, layout, local, NULL, PETSC_COPY_VALUES, id));
  PetscCall(MpmParticlesRestoreField(particles, &id));
  PetscCall(PetscCalloc1(rows, &found));
  PetscCall(PetscMalloc1(local, &once));
  for (PetscInt p = 0; p < local; p++) once[p] = 1;
  PetscCall(PetscSFReduceBegin(sf, MPIU_INT, once, found, MPI_SUM));
  PetscCall(PetscSFReduceEnd(sf, MPIU_INT, once, found, MPI_SUM));
  for (PetscInt k = rows - 1; k >= 0; k--)
    if (found[k] != 1) wrong[0] = first + k;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &wrong[0], 1, MPIU_INT, MPI_MIN, grid->comm));
  if (wrong[0] >= first && wrong[0] < first + rows) wrong[1] = found[wrong[0] - first];
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &wrong[1], 1, MPIU_INT, MPI_MAX, grid->comm));
  for (PetscInt k = 0; k < count && !seen; k++) {
    if (travellers[k].id != wrong[0]) continue;
    seen = PETSC_TRUE;
    Describe(particles, wrong[0], wrong[1] ? "has arrived twice at" : "was lost on its way to", travellers[k].x);
  }
  PetscCall(ShareLost(particles, grid, seen, &seen));
  if (!seen) {
    PetscCall(PetscSNPrintf(particles->lost, sizeof(particles->lost),
                            "point %" PetscInt_FMT " is %s; where it was is not known", wrong[0],
                            wrong[1] ? "there twice" : "missing"));
  }
  particles->gone = PETSC_TRUE;
  PetscCall(PetscFree(found));
  PetscCall(PetscFree(once));
  PetscCall(PetscSFDestroy(&sf));
  PetscCall(PetscLayoutDestroy(&layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first point that is nowhere in the grid, or -1. */
MPM_INLINE PetscInt FindStray(const PetscInt dim, const MpmGrid *grid, PetscInt count, const PetscReal x[])
{
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  for (PetscInt a = 0; a < dim; a++) {
    lower[a] = grid->lower[a];
    upper[a] = grid->upper[a];
  }
  for (PetscInt p = 0; p < count; p++)
    for (PetscInt a = 0; a < dim; a++) /* not-a-number is neither above nor below */
      if (!(x[p * dim + a] >= lower[a] && x[p * dim + a] <= upper[a])) return p;
  return -1;
}

/* Rank of each point; `leaving` ones go to other ranks. The first that is nowhere in the grid is reported. */
static PetscErrorCode Address(MpmParticles *particles, const MpmGrid *grid, PetscInt count, PetscInt *leaving,
                              PetscBool *astray)
{
  const PetscInt dim = grid->dim;
  PetscReal     *x;
  PetscInt      *rank, *id, stray;

  PetscFunctionBeginUser;
  *leaving = 0;
  PetscCall(MpmParticlesGetField(particles, "position", &x));
  PetscCall(DMSwarmGetField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  PetscCall(MpmParticlesGetField(particles, "id", &id));
  stray = dim == 2 ? FindStray(2, grid, count, x) : FindStray(3, grid, count, x);
  for (PetscInt p = 0; p < count && stray < 0 && grid->size > 1; p++) {
    PetscInt cell[MPM_MAX_DIM];

    MpmGridFindCell(grid, &x[p * dim], cell);
    rank[p] = MpmGridCellOwner(grid, cell);
    *leaving += rank[p] != grid->rank;
  }
  *astray = (PetscBool)(stray >= 0);
  if (*astray) Describe(particles, id[stray], "is not in the grid but at", &x[stray * dim]);
  PetscCall(MpmParticlesRestoreField(particles, &id));
  PetscCall(DMSwarmRestoreField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  PetscCall(MpmParticlesRestoreField(particles, &x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes who leaves, and sends them off. */
static PetscErrorCode Send(MpmParticles *particles, const MpmGrid *grid, PetscInt count, Traveller travellers[])
{
  PetscReal *x;
  PetscInt  *rank, *id, n = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetField(particles, "position", &x));
  PetscCall(DMSwarmGetField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  PetscCall(MpmParticlesGetField(particles, "id", &id));
  for (PetscInt p = 0; p < count; p++) {
    if (rank[p] == grid->rank) continue;
    travellers[n].id = id[p];
    for (PetscInt a = 0; a < grid->dim; a++) travellers[n].x[a] = x[p * grid->dim + a];
    n++;
  }
  PetscCall(MpmParticlesRestoreField(particles, &id));
  PetscCall(DMSwarmRestoreField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  PetscCall(MpmParticlesRestoreField(particles, &x));
  PetscCall(MpmParticlesRelease(particles));
  PetscCall(DMSwarmMigrate(particles->swarm, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesMigrate(MpmParticles *particles, MpmGrid *grid)
{
  PetscInt   count, leaving;
  PetscInt64 sum[3]; /* points, those that leave, ranks with one that is nowhere */
  Traveller *travellers;
  PetscBool  astray = PETSC_FALSE, told;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(Address(particles, grid, count, &leaving, &astray));
  sum[0] = count;
  sum[1] = leaving;
  sum[2] = astray;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, 3, MPIU_INT64, MPI_SUM, grid->comm));
  if (sum[0] != particles->total) PetscCall(FindMissing(particles, grid, 0, NULL));
  else if (sum[2]) PetscCall(ShareLost(particles, grid, astray, &told));
  if (particles->lost[0] || !sum[1]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(leaving, &travellers));
  PetscCall(Send(particles, grid, count, travellers));
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  sum[0] = count;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, sum, 1, MPIU_INT64, MPI_SUM, grid->comm));
  if (sum[0] != particles->total) PetscCall(FindMissing(particles, grid, leaving, travellers));
  PetscCall(PetscFree(travellers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRebalance(MpmParticles *particles, MpmGrid *grid, PetscBool always, PetscBool *moved)
{
  PetscReal *x, most;
  PetscInt   count;

  PetscFunctionBeginUser;
  *moved = PETSC_FALSE;
  if (grid->size == 1 && grid->splits) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  most = (PetscReal)count;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, grid->comm));
  if (!always && most * grid->size <= grid->balance * (PetscReal)particles->total) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmParticlesGetField(particles, "position", &x));
  PetscCall(MpmGridPartition(grid, count, x, always ? PETSC_MAX_REAL : most / BALANCE_GAIN, moved));
  PetscCall(MpmParticlesRestoreField(particles, &x));
  if (*moved && !always) particles->rebalances++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesDistribute(MpmParticles *particles, MpmGrid *grid, MpmOutcome *outcome)
{
  PetscBool moved = PETSC_TRUE;
  PetscInt  count, most;

  PetscFunctionBeginUser;
  if (!grid->splits) PetscCall(MpmParticlesRebalance(particles, grid, PETSC_TRUE, &moved));
  PetscCall(MpmParticlesMigrate(particles, grid));
  if (!particles->lost[0]) PetscCall(MpmParticlesRebalance(particles, grid, PETSC_FALSE, &moved));
  if (!particles->lost[0] && moved) PetscCall(MpmParticlesMigrate(particles, grid));
  MpmOutcomeClear(outcome);
  if (particles->lost[0]) PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_OUTSIDE, "%s", particles->lost));
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(MPIU_Allreduce(&count, &most, 1, MPIU_INT, MPI_MAX, grid->comm));
  if (particles->total)
    particles->imbalance = PetscMax(particles->imbalance, (PetscReal)most * grid->size / (PetscReal)particles->total);
  PetscCall(PetscInfo(particles->swarm, "points: %" PetscInt64_FMT ", %" PetscInt_FMT " on the fullest rank%s\n",
                      particles->total, most, moved ? ", new partition" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}
