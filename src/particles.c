/*
  The material points: a DMSwarm of type BASIC whose fields are those that the scene's physics and materials use, and no
  other.

  Ownership is arithmetic on the grid: the rank that owns a cell's lower node owns the points in it, so a point goes to
  its rank in one message however far it moved.
*/
#include "mpmimpl.h"

/* Rebalance when the fullest rank holds this much more than the mean. */
#define IMBALANCE_LIMIT 1.05

/* Every field of the swarm is registered here: what is listed travels with its point and stands in checkpoints. */
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
#define OWN_FIELDS 16

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
  particles->swarm       = swarm;
  particles->field_count = 0;
  PetscCall(PetscCalloc1((OWN_FIELDS + extra_count), &particles->fields));
  PetscCall(Register(particles, "id", 1, PETSC_INT));
  PetscCall(Register(particles, "material", 1, PETSC_INT));
  PetscCall(Register(particles, "position", dim, PETSC_REAL));
  PetscCall(Register(particles, "position0", dim, PETSC_REAL));
  PetscCall(Register(particles, "F", dim * dim, PETSC_REAL));
  PetscCall(Register(particles, "volume0", 1, PETSC_REAL));
  PetscCall(Register(particles, "stress", dim == 2 ? 4 : 6, PETSC_REAL));
  if (particles->has_mass) PetscCall(Register(particles, "mass", 1, PETSC_REAL));
  if (half_length) PetscCall(Register(particles, "half_length", dim, PETSC_REAL));
  if (state_size) PetscCall(Register(particles, "state", state_size, PETSC_REAL));
  if (increment) PetscCall(Register(particles, "increment", dim + dim * dim, PETSC_REAL));
  if (rates) PetscCall(Register(particles, "value", rates, PETSC_REAL));
  for (PetscInt e = 0; e < extra_count; e++) PetscCall(Register(particles, extra[e], 1, PETSC_REAL));
  PetscCall(DMSwarmFinalizeFieldRegister(swarm));
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
  for (PetscInt k = 0; k < particles->field_count; k++) PetscCall(PetscFree(particles->fields[k].name));
  PetscCall(PetscFree(particles->fields));
  particles->field_count = 0;
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
  if (particles->has_mass) PetscCall(DMSwarmGetField(swarm, "mass", NULL, NULL, (void **)&points->mass));
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
  if (particles->has_mass) PetscCall(DMSwarmRestoreField(swarm, "mass", NULL, NULL, (void **)&points->mass));
  if (particles->has_half_length)
    PetscCall(DMSwarmRestoreField(swarm, "half_length", NULL, NULL, (void **)&points->half_length));
  if (particles->state_size) PetscCall(DMSwarmRestoreField(swarm, "state", NULL, NULL, (void **)&points->state));
  if (particles->has_increment)
    PetscCall(DMSwarmRestoreField(swarm, "increment", NULL, NULL, (void **)&points->increment));
  if (particles->rates) PetscCall(DMSwarmRestoreField(swarm, "value", NULL, NULL, (void **)&points->value));
  PetscCall(PetscMemzero(points, sizeof(*points)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesMigrate(MpmParticles *particles, MpmGrid *grid)
{
  PetscReal *x;
  PetscInt  *rank, count, leaving = 0;

  PetscFunctionBeginUser;
  if (grid->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(DMSwarmGetField(particles->swarm, "position", NULL, NULL, (void **)&x));
  PetscCall(DMSwarmGetField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  for (PetscInt p = 0; p < count; p++) {
    PetscInt cell[MPM_MAX_DIM];

    MpmGridFindCell(grid, &x[p * grid->dim], cell);
    rank[p] = MpmGridNodeOwner(grid, cell);
    leaving += rank[p] != grid->rank;
  }
  PetscCall(DMSwarmRestoreField(particles->swarm, DMSwarmField_rank, NULL, NULL, (void **)&rank));
  PetscCall(DMSwarmRestoreField(particles->swarm, "position", NULL, NULL, (void **)&x));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &leaving, 1, MPIU_INT, MPI_MAX, grid->comm));
  if (leaving) {
    PetscInt total;

    PetscCall(DMSwarmMigrate(particles->swarm, PETSC_TRUE));
    PetscCall(DMSwarmGetSize(particles->swarm, &total));
    PetscCheck(total == particles->total, grid->comm, PETSC_ERR_PLIB,
               "migration lost points: %" PetscInt_FMT " of %" PetscInt64_FMT " are left", total, particles->total);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesRebalance(MpmParticles *particles, MpmGrid *grid, PetscBool always, PetscBool *moved)
{
  PetscReal *x;
  PetscInt   count, most;

  PetscFunctionBeginUser;
  *moved = PETSC_FALSE;
  if (grid->size == 1 && grid->da) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(MPIU_Allreduce(&count, &most, 1, MPIU_INT, MPI_MAX, grid->comm));
  if (!always && (PetscReal)most * grid->size <= IMBALANCE_LIMIT * (PetscReal)particles->total)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(DMSwarmGetField(particles->swarm, "position", NULL, NULL, (void **)&x));
  PetscCall(MpmGridPartition(grid, count, x));
  PetscCall(DMSwarmRestoreField(particles->swarm, "position", NULL, NULL, (void **)&x));
  *moved = PETSC_TRUE;
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
    PetscCall(DMSwarmGetField(particles->swarm, particles->fields[k].name, NULL, NULL, &fields[k]));
  }
  for (PetscInt k = 0; k < count; k++)
    PetscCall(CopyRow(particles, fields, index ? index[k] : first + k, data + (size_t)k * bytes, out));
  for (PetscInt k = 0; k < particles->field_count; k++)
    PetscCall(DMSwarmRestoreField(particles->swarm, particles->fields[k].name, NULL, NULL, &fields[k]));
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

PetscErrorCode MpmParticlesRemove(MpmParticles *particles, PetscInt first, PetscInt end, MpmParked *parked)
{
  PetscInt *id, *index, count, found = 0;
  size_t    bytes = 0;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &count));
  PetscCall(PetscMalloc1(count, &index));
  PetscCall(DMSwarmGetField(particles->swarm, "id", NULL, NULL, (void **)&id));
  for (PetscInt p = 0; p < count; p++)
    if (id[p] >= first && id[p] < end) index[found++] = p;
  PetscCall(DMSwarmRestoreField(particles->swarm, "id", NULL, NULL, (void **)&id));
  if (parked) {
    for (PetscInt k = 0; k < particles->field_count; k++) bytes += FieldBytes(&particles->fields[k]);
    parked->count = found;
    PetscCall(PetscMalloc1(((size_t)found * bytes), &parked->data));
    PetscCall(CopyRows(particles, found, index, 0, parked->data, PETSC_TRUE));
  }
  /* the last point takes the place of the one that goes, so from the end */
  while (found--) PetscCall(DMSwarmRemovePointAtIndex(particles->swarm, index[found]));
  PetscCall(PetscFree(index));
  PetscCall(CountTotal(particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesReturn(MpmParticles *particles, MpmParked *parked)
{
  PetscInt first;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &first));
  if (parked->count) {
    PetscCall(DMSwarmAddNPoints(particles->swarm, parked->count));
    PetscCall(CopyRows(particles, parked->count, NULL, first, parked->data, PETSC_FALSE));
  }
  PetscCall(PetscFree(parked->data));
  parked->count = 0;
  PetscCall(CountTotal(particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}
