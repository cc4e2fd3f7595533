/*
  The material points: a DMSwarm of type BASIC whose fields are those that the scene's physics and materials use, and no
  other.

  Ownership is arithmetic on the grid: the rank that owns a cell's lower node owns the points in it, so a point goes to
  its rank in one message however far it moved.
*/
#include "mpmimpl.h"

/* Other cuts are taken when the fullest rank then holds this much less. */
#define BALANCE_GAIN 1.02

PetscErrorCode MpmParticlesCreate(MpmGrid *grid, PetscInt state_size, PetscInt rates, PetscBool half_length,
                                  PetscBool increment, PetscInt extra_count, char *const extra[],
                                  MpmParticles *particles)
{
  const PetscInt dim = grid->dim;
  DM             swarm;

  PetscFunctionBeginUser;
  PetscCall(DMCreate(grid->comm, &swarm));
  PetscCall(DMSetType(swarm, DMSWARM));
  PetscCall(DMSetDimension(swarm, dim));
  PetscCall(DMSwarmSetType(swarm, DMSWARM_BASIC));
  PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "id", 1, PETSC_INT));
  PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "material", 1, PETSC_INT));
  PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "position", dim, PETSC_REAL));
  PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "position0", dim, PETSC_REAL));
  PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "F", dim * dim, PETSC_REAL));
  PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "volume0", 1, PETSC_REAL));
  PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "stress", dim == 2 ? 4 : 6, PETSC_REAL));
  if (half_length) PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "half_length", dim, PETSC_REAL));
  if (state_size) PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "state", state_size, PETSC_REAL));
  if (increment) PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "increment", dim + dim * dim, PETSC_REAL));
  if (rates) PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, "value", rates, PETSC_REAL));
  for (PetscInt e = 0; e < extra_count; e++)
    PetscCall(DMSwarmRegisterPetscDatatypeField(swarm, extra[e], 1, PETSC_REAL));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm));
  particles->swarm           = swarm;
  particles->dim             = dim;
  particles->stress_size     = dim == 2 ? 4 : 6;
  particles->state_size      = state_size;
  particles->rates           = rates;
  particles->has_half_length = half_length;
  particles->has_increment   = increment;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesDestroy(MpmParticles *particles)
{
  PetscFunctionBeginUser;
  PetscCall(DMDestroy(&particles->swarm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesGetArrays(MpmParticles *particles, MpmPoints *points)
{
  DM swarm = particles->swarm;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(points, sizeof(*points)));
  PetscCall(DMSwarmGetLocalSize(swarm, &points->count));
  PetscCall(DMSwarmGetField(swarm, "id", NULL, NULL, (void **)&points->id));
  PetscCall(DMSwarmGetField(swarm, "material", NULL, NULL, (void **)&points->material));
  PetscCall(DMSwarmGetField(swarm, "position", NULL, NULL, (void **)&points->x));
  PetscCall(DMSwarmGetField(swarm, "position0", NULL, NULL, (void **)&points->x0));
  PetscCall(DMSwarmGetField(swarm, "F", NULL, NULL, (void **)&points->F));
  PetscCall(DMSwarmGetField(swarm, "volume0", NULL, NULL, (void **)&points->volume0));
  PetscCall(DMSwarmGetField(swarm, "stress", NULL, NULL, (void **)&points->stress));
  if (particles->has_half_length)
    PetscCall(DMSwarmGetField(swarm, "half_length", NULL, NULL, (void **)&points->half_length));
  if (particles->state_size) PetscCall(DMSwarmGetField(swarm, "state", NULL, NULL, (void **)&points->state));
  if (particles->has_increment) PetscCall(DMSwarmGetField(swarm, "increment", NULL, NULL, (void **)&points->increment));
  if (particles->rates) PetscCall(DMSwarmGetField(swarm, "value", NULL, NULL, (void **)&points->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRestoreArrays(MpmParticles *particles, MpmPoints *points)
{
  DM swarm = particles->swarm;

  PetscFunctionBeginUser;
  if (!points->id && !points->count) PetscFunctionReturn(PETSC_SUCCESS); /* nothing is lent */
  PetscCall(DMSwarmRestoreField(swarm, "id", NULL, NULL, (void **)&points->id));
  PetscCall(DMSwarmRestoreField(swarm, "material", NULL, NULL, (void **)&points->material));
  PetscCall(DMSwarmRestoreField(swarm, "position", NULL, NULL, (void **)&points->x));
  PetscCall(DMSwarmRestoreField(swarm, "position0", NULL, NULL, (void **)&points->x0));
  PetscCall(DMSwarmRestoreField(swarm, "F", NULL, NULL, (void **)&points->F));
  PetscCall(DMSwarmRestoreField(swarm, "volume0", NULL, NULL, (void **)&points->volume0));
  PetscCall(DMSwarmRestoreField(swarm, "stress", NULL, NULL, (void **)&points->stress));
  if (particles->has_half_length)
    PetscCall(DMSwarmRestoreField(swarm, "half_length", NULL, NULL, (void **)&points->half_length));
  if (particles->state_size) PetscCall(DMSwarmRestoreField(swarm, "state", NULL, NULL, (void **)&points->state));
  if (particles->has_increment)
    PetscCall(DMSwarmRestoreField(swarm, "increment", NULL, NULL, (void **)&points->increment));
  if (particles->rates) PetscCall(DMSwarmRestoreField(swarm, "value", NULL, NULL, (void **)&points->value));
  PetscCall(PetscMemzero(points, sizeof(*points)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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

/* All ranks learn what the lowest of those that have something to tell has written in particles->lost. */
static PetscErrorCode ShareLost(MpmParticles *particles, const MpmGrid *grid, PetscBool tell, PetscBool *told)
{
  PetscMPIInt rank = tell ? grid->rank : grid->size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &rank, 1, MPI_INT, MPI_MIN, grid->comm));
  *told = (PetscBool)(rank < grid->size);
  if (*told) PetscCallMPI(MPI_Bcast(particles->lost, (PetscMPIInt)sizeof(particles->lost), MPI_CHAR, rank, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The points are not those that they were: which id is missing, or there twice, and where was it last? */
static PetscErrorCode FindMissing(MpmParticles *particles, const MpmGrid *grid, PetscInt count,
                                  const Traveller travellers[])
{
  PetscInt   *id, local, rows, first, *found, *once, wrong[2] = {PETSC_INT_MAX, 0};
  PetscLayout layout;
  PetscSF     sf;
  PetscBool   seen = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(PetscLayoutCreateFromSizes(grid->comm, PETSC_DECIDE, (PetscInt)particles->total, 1, &layout));
  PetscCall(PetscLayoutGetLocalSize(layout, &rows));
  PetscCall(PetscLayoutGetRange(layout, &first, NULL));
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &local));
  PetscCall(DMSwarmGetField(particles->swarm, "id", NULL, NULL, (void **)&id));
  PetscCall(PetscSFCreate(grid->comm, &sf));
  PetscCall(PetscSFSetGraphLayout(sf, layout, local, NULL, PETSC_COPY_VALUES, id));
  PetscCall(DMSwarmRestoreField(particles->swarm, "id", NULL, NULL, (void **)&id));
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

/* Which rank each point belongs to; `leaving` ones are not here any more. The first that is nowhere in the grid is told. */
static PetscErrorCode Address(MpmParticles *particles, const MpmGrid *grid, PetscInt count, PetscInt *leaving,
                              PetscBool *astray)
{
  const PetscInt dim = grid->dim;
  PetscReal     *x;
  PetscInt      *rank, *id, stray = -1;

  PetscFunctionBeginUser;
  *leaving = 0;
  PetscCall(DMSwarmGetField(particles->swarm, "position", NULL, NULL, (void **)&x));
  PetscCall(DMSwarmGetField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  PetscCall(DMSwarmGetField(particles->swarm, "id", NULL, NULL, (void **)&id));
  for (PetscInt p = 0; p < count && stray < 0; p++) {
    PetscInt cell[MPM_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++) /* not-a-number is neither above nor below */
      if (!(x[p * dim + a] >= grid->lower[a] && x[p * dim + a] <= grid->upper[a])) stray = p;
    if (stray >= 0 || grid->size == 1) continue;
    MpmGridFindCell(grid, &x[p * dim], cell);
    rank[p] = MpmGridNodeOwner(grid, cell);
    *leaving += rank[p] != grid->rank;
  }
  *astray = (PetscBool)(stray >= 0);
  if (*astray) Describe(particles, id[stray], "is not in the grid but at", &x[stray * dim]);
  PetscCall(DMSwarmRestoreField(particles->swarm, "id", NULL, NULL, (void **)&id));
  PetscCall(DMSwarmRestoreField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  PetscCall(DMSwarmRestoreField(particles->swarm, "position", NULL, NULL, (void **)&x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Notes who leaves, and sends them off. */
static PetscErrorCode Send(MpmParticles *particles, const MpmGrid *grid, PetscInt count, Traveller travellers[])
{
  PetscReal *x;
  PetscInt  *rank, *id, n = 0;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetField(particles->swarm, "position", NULL, NULL, (void **)&x));
  PetscCall(DMSwarmGetField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  PetscCall(DMSwarmGetField(particles->swarm, "id", NULL, NULL, (void **)&id));
  for (PetscInt p = 0; p < count; p++) {
    if (rank[p] == grid->rank) continue;
    travellers[n].id = id[p];
    for (PetscInt a = 0; a < grid->dim; a++) travellers[n].x[a] = x[p * grid->dim + a];
    n++;
  }
  PetscCall(DMSwarmRestoreField(particles->swarm, "id", NULL, NULL, (void **)&id));
  PetscCall(DMSwarmRestoreField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  PetscCall(DMSwarmRestoreField(particles->swarm, "position", NULL, NULL, (void **)&x));
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
  if (grid->size == 1 && grid->cuts) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  most = (PetscReal)count;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, grid->comm));
  if (!always && most * grid->size <= grid->balance * (PetscReal)particles->total) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DMSwarmGetField(particles->swarm, "position", NULL, NULL, (void **)&x));
  PetscCall(MpmGridPartition(grid, count, x, always ? PETSC_MAX_REAL : most / BALANCE_GAIN, moved));
  PetscCall(DMSwarmRestoreField(particles->swarm, "position", NULL, NULL, (void **)&x));
  if (*moved && !always) particles->rebalances++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesDistribute(MpmParticles *particles, MpmGrid *grid, const char **why)
{
  PetscBool moved = PETSC_TRUE;
  PetscInt  count, most;

  PetscFunctionBeginUser;
  if (!grid->cuts) PetscCall(MpmParticlesRebalance(particles, grid, PETSC_TRUE, &moved));
  PetscCall(MpmParticlesMigrate(particles, grid));
  if (!particles->lost[0]) PetscCall(MpmParticlesRebalance(particles, grid, PETSC_FALSE, &moved));
  if (!particles->lost[0] && moved) PetscCall(MpmParticlesMigrate(particles, grid));
  *why = particles->lost[0] ? particles->lost : NULL;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(MPIU_Allreduce(&count, &most, 1, MPIU_INT, MPI_MAX, grid->comm));
  if (particles->total)
    particles->imbalance = PetscMax(particles->imbalance, (PetscReal)most * grid->size / (PetscReal)particles->total);
  PetscCall(PetscInfo(particles->swarm, "points: %" PetscInt64_FMT ", %" PetscInt_FMT " on the fullest rank%s\n",
                      particles->total, most, moved ? ", new partition" : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}
