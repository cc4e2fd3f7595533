/*
  The material points: a DMSwarm of type BASIC whose fields are those that the scene's physics and materials use, and no
  other.

  Ownership is arithmetic on the grid: the rank that owns a cell's lower node owns the points in it, so a point goes to
  its rank in one message however far it moved.
*/
#include "base/outcome.h"
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "grid/partition.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"

/* Another partition is taken when the fullest rank then holds this much less. */
#define BALANCE_GAIN 1.02

/* Every field of the swarm is registered here: listed fields travel with their point and stand in checkpoints. */
static PetscErrorCode Register(MpmParticles *particles, const char *name, PetscInt components, PetscDataType type)
{
  MpmPointField *field = &particles->fields[particles->field_count++];

  PetscFunctionBeginUser;
  PetscCall(DMSwarmRegisterPetscDatatypeField(particles->swarm, name, components, type));
  PetscCall(PetscStrallocpy(name, &field->name));
  field->components = components;
  field->integer    = (PetscBool)(type == PETSC_INT);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Fields besides the scene's own, at most. */
#define OWN_FIELDS 22

PetscErrorCode MpmParticlesCreate(MpmGrid *grid, const MpmParticleFields *fields, MpmParticles *particles)
{
  const PetscInt dim = grid->dim;
  DM             swarm;

  PetscFunctionBeginUser;
  PetscCall(DMCreate(grid->comm, &swarm));
  PetscCall(DMSetType(swarm, DMSWARM));
  PetscCall(DMSetDimension(swarm, dim));
  PetscCall(DMSwarmSetType(swarm, DMSWARM_BASIC));
  particles->swarm       = swarm;
  particles->field_count = 0;
  particles->lent        = 0;
  PetscCall(PetscNew(&particles->held));
  PetscCall(PetscCalloc1((OWN_FIELDS + fields->extra_count), &particles->fields));
  PetscCall(Register(particles, "id", 1, PETSC_INT));
  PetscCall(Register(particles, "material", 1, PETSC_INT));
  PetscCall(Register(particles, "position", dim, PETSC_REAL));
  PetscCall(Register(particles, "position0", dim, PETSC_REAL));
  if (fields->origin) PetscCall(Register(particles, "origin", dim, PETSC_REAL));
  PetscCall(Register(particles, "F", MpmGridF(grid), PETSC_REAL));
  PetscCall(Register(particles, "volume0", 1, PETSC_REAL));
  PetscCall(Register(particles, "stress", MpmSymSize(dim), PETSC_REAL));
  if (particles->has_mass) PetscCall(Register(particles, "mass", 1, PETSC_REAL));
  if (fields->across) PetscCall(Register(particles, "across", 1, PETSC_REAL));
  if (fields->half_length) PetscCall(Register(particles, "half_length", dim, PETSC_REAL));
  if (fields->faces) PetscCall(Register(particles, "faces", 1, PETSC_INT));
  if (fields->divisions) PetscCall(Register(particles, "divisions", 1, PETSC_INT));
  if (fields->part) PetscCall(Register(particles, "part", 1, PETSC_INT));
  if (fields->part) PetscCall(Register(particles, "cut", dim + 1, PETSC_REAL));
  if (fields->state_size) PetscCall(Register(particles, "state", fields->state_size, PETSC_REAL));
  if (fields->parameters) PetscCall(Register(particles, "parameter", fields->parameters, PETSC_REAL));
  if (fields->own_size) PetscCall(Register(particles, "own", fields->own_size, PETSC_REAL));
  if (fields->increment) PetscCall(Register(particles, "increment", MPM_INCREMENT(dim), PETSC_REAL));
  if (fields->rates) PetscCall(Register(particles, "value", fields->rates, PETSC_REAL));
  if (fields->rates) PetscCall(Register(particles, "value_gradient", fields->rates * dim, PETSC_REAL));
  if (fields->velocity) PetscCall(Register(particles, "velocity", dim, PETSC_REAL));
  if (fields->affine) PetscCall(Register(particles, "affine", dim * dim, PETSC_REAL));
  if (fields->acceleration) PetscCall(Register(particles, "acceleration", dim, PETSC_REAL));
  for (PetscInt e = 0; e < fields->extra_count; e++) PetscCall(Register(particles, fields->extra[e], 1, PETSC_REAL));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm));
  for (PetscInt k = 0; k < particles->field_count; k++) {
    const MpmPointField *field = &particles->fields[k];
    const PetscInt       extra = k - (particles->field_count - fields->extra_count);

    particles->fields[k].shared = (PetscBool)((extra >= 0 && extra < fields->shared) ||
                                              !strcmp(field->name, "volume0") || !strcmp(field->name, "mass"));
  }
  particles->dim         = dim;
  particles->F_size      = MpmGridF(grid);
  particles->stress_size = MpmSymSize(dim);
  particles->state_size  = fields->state_size;
  particles->own_size    = fields->own_size;
  particles->rates       = fields->rates;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesDestroy(MpmParticles *particles)
{
  PetscFunctionBeginUser;
  if (particles->held) PetscCall(MpmParticlesRelease(particles));
  PetscCall(PetscFree(particles->held));
  PetscCall(DMDestroy(&particles->swarm));
  for (PetscInt k = 0; k < particles->field_count; k++) PetscCall(PetscFree(particles->fields[k].name));
  PetscCall(PetscFree(particles->fields));
  particles->field_count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* NULL: it is not registered. */
static const MpmPointField *FindField(const MpmParticles *particles, const char name[])
{
  for (PetscInt k = 0; k < particles->field_count; k++)
    if (!strcmp(particles->fields[k].name, name)) return &particles->fields[k];
  return NULL;
}

PetscBool MpmParticlesHaveField(const MpmParticles *particles, const char name[])
{
  return (PetscBool)(FindField(particles, name) != NULL);
}

static void *HeldArray(const MpmParticles *particles, const char name[])
{
  const MpmPointField *field = FindField(particles, name);

  return field ? field->array : NULL;
}

/* Array of a registered field on a rank without points, where the swarm has NULL: NULL is a field that is not
   registered. */
static PetscReal nothing[1];

/*
  Takes all fields from the swarm, which looks each up by name: too slow for each step of a small scene. The fields stay
  taken until the number of points changes.
*/
static PetscErrorCode Hold(MpmParticles *particles)
{
  MpmPoints *points = particles->held;

  PetscFunctionBeginUser;
  if (points->lent) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < particles->field_count; k++) {
    PetscCall(DMSwarmGetField(particles->swarm, particles->fields[k].name, NULL, NULL, &particles->fields[k].array));
    if (!particles->fields[k].array) particles->fields[k].array = nothing;
  }
  points->lent = PETSC_TRUE;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &points->count));
  points->id             = HeldArray(particles, "id");
  points->material       = HeldArray(particles, "material");
  points->x              = HeldArray(particles, "position");
  points->x0             = HeldArray(particles, "position0");
  points->origin         = MpmParticlesHaveField(particles, "origin") ? HeldArray(particles, "origin") : points->x0;
  points->F_size         = particles->F_size;
  points->F              = HeldArray(particles, "F");
  points->volume0        = HeldArray(particles, "volume0");
  points->stress         = HeldArray(particles, "stress");
  points->mass           = HeldArray(particles, "mass");
  points->across         = HeldArray(particles, "across");
  points->half_length    = HeldArray(particles, "half_length");
  points->state          = HeldArray(particles, "state");
  points->parameter      = HeldArray(particles, "parameter");
  points->own            = HeldArray(particles, "own");
  points->increment      = HeldArray(particles, "increment");
  points->faces          = HeldArray(particles, "faces");
  points->divisions      = HeldArray(particles, "divisions");
  points->part           = HeldArray(particles, "part");
  points->cut            = HeldArray(particles, "cut");
  points->value          = HeldArray(particles, "value");
  points->value_gradient = HeldArray(particles, "value_gradient");
  points->velocity       = HeldArray(particles, "velocity");
  points->affine         = HeldArray(particles, "affine");
  points->acceleration   = HeldArray(particles, "acceleration");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRelease(MpmParticles *particles)
{
  PetscFunctionBeginUser;
  PetscCheck(!particles->lent, PETSC_COMM_SELF, PETSC_ERR_ORDER, "the points' fields are lent %" PetscInt_FMT " times",
             particles->lent);
  if (!particles->held->lent) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < particles->field_count; k++)
    PetscCall(
      DMSwarmRestoreField(particles->swarm, particles->fields[k].name, NULL, NULL, &particles->fields[k].array));
  PetscCall(PetscMemzero(particles->held, sizeof(*particles->held)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesGetArrays(MpmParticles *particles, MpmPoints *points)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(points, sizeof(*points)));
  PetscCall(Hold(particles));
  particles->lent++;
  *points = *particles->held;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRestoreArrays(MpmParticles *particles, MpmPoints *points)
{
  PetscFunctionBeginUser;
  if (!points->lent) PetscFunctionReturn(PETSC_SUCCESS);
  particles->lent--;
  PetscCall(PetscMemzero(points, sizeof(*points)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesGetField(MpmParticles *particles, const char name[], void *array)
{
  const MpmPointField *field = FindField(particles, name);

  PetscFunctionBeginUser;
  PetscCheck(field, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE, "the points have no field %s", name);
  PetscCall(Hold(particles));
  particles->lent++;
  *(void **)array = field->array;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRestoreField(MpmParticles *particles, void *array)
{
  PetscFunctionBeginUser;
  particles->lent--;
  *(void **)array = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesLendArrays(MpmParticles *particles, MpmPoints *points)
{
  PetscFunctionBeginUser;
  if (!points->lent) PetscCall(MpmParticlesGetArrays(particles, points));
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
    rank[p] = MpmGridNodeOwner(grid, cell);
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

/* ---- points that come and go ---- */

static size_t FieldBytes(const MpmPointField *field)
{
  return (size_t)field->components * (field->integer ? sizeof(PetscInt) : sizeof(PetscReal));
}

/* Copies all fields of one point between the swarm and a row of parked data. */
static PetscErrorCode CopyRow(MpmParticles *particles, void *const fields[], PetscInt p, char *row, PetscBool out)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < particles->field_count; k++) {
    const size_t bytes = FieldBytes(&particles->fields[k]);
    char        *field = (char *)fields[k] + (size_t)p * bytes;

    if (out) PetscCall(PetscMemcpy(row, field, bytes));
    else PetscCall(PetscMemcpy(field, row, bytes));
    row += bytes;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies `count` points, index[k] or first + k, between the swarm and parked data. */
static PetscErrorCode CopyRows(MpmParticles *particles, PetscInt count, const PetscInt index[], PetscInt first,
                               char *data, PetscBool out)
{
  void **fields;
  size_t bytes = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(particles->field_count, &fields));
  for (PetscInt k = 0; k < particles->field_count; k++) {
    bytes += FieldBytes(&particles->fields[k]);
    PetscCall(MpmParticlesGetField(particles, particles->fields[k].name, &fields[k]));
  }
  for (PetscInt k = 0; k < count; k++)
    PetscCall(CopyRow(particles, fields, index ? index[k] : first + k, data + (size_t)k * bytes, out));
  for (PetscInt k = 0; k < particles->field_count; k++) PetscCall(MpmParticlesRestoreField(particles, &fields[k]));
  PetscCall(PetscFree(fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CountTotal(MpmParticles *particles)
{
  PetscInt total;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetSize(particles->swarm, &total));
  particles->total = total;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies points, `index` or all, into data that is made for them. */
static PetscErrorCode Park(MpmParticles *particles, PetscInt count, const PetscInt index[], MpmParked *parked)
{
  size_t bytes = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < particles->field_count; k++) bytes += FieldBytes(&particles->fields[k]);
  parked->count = count;
  PetscCall(PetscMalloc1(((size_t)count * bytes), &parked->data));
  PetscCall(CopyRows(particles, count, index, 0, parked->data, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRemove(MpmParticles *particles, PetscInt first, PetscInt end, MpmParked *parked)
{
  PetscInt *id, *index, count, found = 0;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(PetscMalloc1(count, &index));
  PetscCall(MpmParticlesGetField(particles, "id", &id));
  for (PetscInt p = 0; p < count; p++)
    if (id[p] >= first && id[p] < end) index[found++] = p;
  PetscCall(MpmParticlesRestoreField(particles, &id));
  if (parked) PetscCall(Park(particles, found, index, parked));
  PetscCall(MpmParticlesRelease(particles));
  /* the last point takes the place of the one that goes, so from the end */
  while (found--) PetscCall(DMSwarmRemovePointAtIndex(particles->swarm, index[found]));
  PetscCall(PetscFree(index));
  PetscCall(CountTotal(particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesFindOutside(MpmParticles *particles, const MpmGrid *grid, PetscInt *here, PetscInt **outside,
                                       PetscInt *count)
{
  PetscInt  *index, local;
  PetscReal *x;

  PetscFunctionBeginUser;
  *here = 0;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &local));
  PetscCall(PetscMalloc1(local, &index));
  PetscCall(MpmParticlesGetField(particles, "position", &x));
  for (PetscInt p = 0; p < local; p++) {
    PetscBool out = PETSC_FALSE;

    for (PetscInt a = 0; a < grid->dim; a++) {
      const PetscReal at = x[p * grid->dim + a];

      if (!(at >= grid->lower[a] && at <= grid->upper[a])) out = PETSC_TRUE;
    }
    if (out) index[(*here)++] = p;
  }
  PetscCall(MpmParticlesRestoreField(particles, &x));
  *outside = index;
  PetscCall(MPIU_Allreduce(here, count, 1, MPIU_INT, MPI_SUM, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRemoveAt(MpmParticles *particles, PetscInt count, const PetscInt place[])
{
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRelease(particles));
  for (PetscInt k = count - 1; k >= 0; k--) PetscCall(DMSwarmRemovePointAtIndex(particles->swarm, place[k]));
  PetscCall(CountTotal(particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesHalve(MpmParticles *particles, PetscInt count, const PetscInt index[])
{
  PetscInt   first;
  size_t     bytes = 0;
  char      *data;
  PetscReal *amount;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < particles->field_count; k++) bytes += FieldBytes(&particles->fields[k]);
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &first));
  PetscCall(PetscMalloc1(((size_t)count * bytes), &data));
  PetscCall(CopyRows(particles, count, index, 0, data, PETSC_TRUE));
  PetscCall(MpmParticlesRelease(particles));
  if (count) PetscCall(DMSwarmAddNPoints(particles->swarm, count));
  PetscCall(CopyRows(particles, count, NULL, first, data, PETSC_FALSE));
  PetscCall(PetscFree(data));
  for (PetscInt k = 0; k < particles->field_count; k++) {
    if (!particles->fields[k].shared) continue;
    PetscCall(MpmParticlesGetField(particles, particles->fields[k].name, &amount));
    for (PetscInt i = 0; i < count; i++) amount[first + i] = amount[index[i]] *= 0.5;
    PetscCall(MpmParticlesRestoreField(particles, &amount));
  }
  PetscCall(CountTotal(particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesReturn(MpmParticles *particles, MpmParked *parked)
{
  PetscInt first;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &first));
  if (parked->count) {
    PetscCall(MpmParticlesRelease(particles));
    PetscCall(DMSwarmAddNPoints(particles->swarm, parked->count));
    PetscCall(CopyRows(particles, parked->count, NULL, first, parked->data, PETSC_FALSE));
  }
  PetscCall(PetscFree(parked->data));
  parked->count = 0;
  PetscCall(CountTotal(particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesKeep(MpmParticles *particles, MpmParked *kept)
{
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(Park(particles, count, NULL, kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesTakeUp(MpmParticles *particles, MpmParked *kept)
{
  PetscInt count;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRelease(particles));
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  while (count--) PetscCall(DMSwarmRemovePointAtIndex(particles->swarm, count));
  PetscCall(MpmParticlesReturn(particles, kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPointsSetOwn(const MpmMaterial *materials, const PetscInt vertical[2], PetscInt dim, PetscInt first,
                     PetscInt end, const MpmPoints *points)
{
  for (PetscInt p = first; points->parameter && p < end; p++) {
    const MpmMaterial *material = &materials[points->material[p]];
    const PetscReal   *x        = &points->origin[p * dim];

    if (material->varies)
      MpmMaterialOwn(material, (PetscReal)vertical[1] * x[vertical[0]], x,
                     &points->parameter[p * material->varies->stride]);
  }
}

PetscReal MpmPointVolumeRatio(const MpmMaterial *material, const PetscReal F[])
{
  const PetscInt size = MpmKinematicsF(material->kinematics), dim = MpmKinematicsDim(material->kinematics);
  PetscReal      ratio = 1.;

  if (!(material->info.traits & MPM_LAW_SMALL_STRAIN)) return MpmDeterminant(size, F);
  for (PetscInt a = 0; a < dim; a++) ratio += F[a * dim + a] - 1.;
  return ratio + (size > dim * dim ? F[size - 1] - 1. : 0.);
}

PetscReal MpmPointMassStart(const MpmPoints *points, const MpmMaterial *materials, PetscInt p)
{
  return MpmPointMass(points, materials, p);
}

PetscReal MpmPointMassNow(const MpmPoints *points, const MpmMaterial *materials, const MpmLayout *layout, PetscInt p)
{
  const MpmMaterial *material = &materials[points->material[p]];
  PetscReal          mass     = MpmPointMass(points, materials, p);

  if (layout->own.taken_up < 0) return mass;
  return mass + MpmMaterialPhysicsValues(material, MpmPointOwn(points, material, p))[layout->own.taken_up] *
                  points->volume0[p] * (MpmPointVolumeRatio(material, MpmPointF(points, p)) - 1.);
}

PetscErrorCode MpmParticlesStartHere(MpmParticles *particles)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(PetscArraycpy(points.x0, points.x, points.count * particles->dim));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsStop(const MpmPoints *points, PetscInt dim)
{
  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(points->velocity, points->count * dim));
  if (points->affine) PetscCall(PetscArrayzero(points->affine, points->count * dim * dim));
  if (points->acceleration) PetscCall(PetscArrayzero(points->acceleration, points->count * dim));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsClear(PetscInt count, PetscReal value[])
{
  const unsigned char *byte = (const unsigned char *)value; /* whatever they stand for, -0 is not 0 */
  unsigned char        any  = 0;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < (size_t)count * sizeof(*value); k++) any |= byte[k];
  if (any) PetscCall(PetscArrayzero(value, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesGetExtents(MpmParticles *particles, MpmPoints *points, PetscReal lower[], PetscReal upper[])
{
  const PetscInt dim                    = particles->dim;
  PetscReal      reach[2 * MPM_MAX_DIM] = {0.};

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 2 * dim; k++) reach[k] = PETSC_NINFINITY;
  PetscCall(MpmParticlesLendArrays(particles, points));
  for (PetscInt k = 0; k < points->count * dim; k++) {
    reach[k % dim]       = PetscMax(reach[k % dim], points->x[k]);
    reach[dim + k % dim] = PetscMax(reach[dim + k % dim], -points->x[k]);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, reach, (PetscMPIInt)(2 * dim), MPIU_REAL, MPIU_MAX,
                           PetscObjectComm((PetscObject)particles->swarm)));
  for (PetscInt a = 0; a < dim; a++) {
    upper[a] = reach[a];
    lower[a] = -reach[dim + a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRest(MpmParticles *particles)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(MpmPointsStop(&points, particles->dim));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmPointsKinetic(const MpmPoints *points, const MpmMaterial *materials, PetscInt dim)
{
  PetscReal sum = 0.;

  for (PetscInt k = 0; k < points->count * dim; k++)
    sum += 0.5 * MpmPointMass(points, materials, k / dim) * PetscSqr(points->velocity[k]);
  return sum;
}
