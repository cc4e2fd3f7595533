/*
  Points that come and go: copies of their fields are parked, removed, returned and halved.
*/
#include "grid/grid.h"
#include "maps/bed.h"
#include "particles/particles.h"

/* ---- points that come and go ---- */

static size_t FieldBytes(const MpmPointField *field)
{
  return (size_t)field->components * (field->integer ? sizeof(PetscInt) : sizeof(PetscReal));
}

/* Copies `count` points, index[k] or first + k, between the swarm and parked data, which have field after field. */
static PetscErrorCode CopyPoints(MpmParticles *particles, PetscInt count, const PetscInt index[], PetscInt first,
                                 char *data, PetscBool out)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < particles->field_count; k++) {
    const size_t bytes = FieldBytes(&particles->fields[k]);
    const size_t run   = index ? bytes : (size_t)count * bytes;
    char        *field;

    PetscCall(MpmParticlesGetField(particles, particles->fields[k].name, (void **)&field));
    for (PetscInt i = 0; i < (index ? count : 1); i++, data += run) {
      char *at = field + (size_t)(index ? index[i] : first) * bytes;

      if (out) PetscCall(PetscMemcpy(data, at, run));
      else PetscCall(PetscMemcpy(at, data, run));
    }
    PetscCall(MpmParticlesRestoreField(particles, &field));
  }
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

size_t MpmParkedBytes(const MpmParticles *particles, const MpmParked *parked)
{
  size_t bytes = 0;

  for (PetscInt k = 0; k < particles->field_count; k++) bytes += FieldBytes(&particles->fields[k]);
  return (size_t)parked->count * bytes;
}

/* Copies points, `index` or all, into data that is made for them. */
static PetscErrorCode Park(MpmParticles *particles, PetscInt count, const PetscInt index[], MpmParked *parked)
{
  PetscFunctionBeginUser;
  parked->count = count;
  PetscCall(PetscMalloc1(MpmParkedBytes(particles, parked), &parked->data));
  PetscCall(CopyPoints(particles, count, index, 0, parked->data, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesTakeOut(MpmParticles *particles, PetscInt count, const PetscInt index[], MpmParked *parked)
{
  PetscFunctionBeginUser;
  if (parked) PetscCall(Park(particles, count, index, parked));
  PetscCall(MpmParticlesRelease(particles));
  /* the last point takes the place of the one that goes, so from the end */
  while (count--) PetscCall(DMSwarmRemovePointAtIndex(particles->swarm, index[count]));
  PetscCall(CountTotal(particles));
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
  PetscCall(MpmParticlesTakeOut(particles, found, index, parked));
  PetscCall(PetscFree(index));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesFindOutside(MpmParticles *particles, const MpmGrid *grid, const MpmBed *bed, PetscInt *here,
                                       PetscInt **outside, PetscInt *count)
{
  PetscInt  *index, local;
  PetscReal *x;

  PetscFunctionBeginUser;
  *here = 0;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &local));
  PetscCall(PetscMalloc1(local, &index));
  PetscCall(MpmParticlesGetField(particles, "position", &x));
  for (PetscInt p = 0; p < local; p++) {
    PetscBool out = bed ? MpmBedIsMissing(bed, &x[p * grid->dim]) : PETSC_FALSE;

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
  PetscCall(CopyPoints(particles, count, index, 0, data, PETSC_TRUE));
  PetscCall(MpmParticlesRelease(particles));
  if (count) PetscCall(DMSwarmAddNPoints(particles->swarm, count));
  PetscCall(CopyPoints(particles, count, NULL, first, data, PETSC_FALSE));
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

/* Copies of the parked points follow the others. */
static PetscErrorCode Append(MpmParticles *particles, const MpmParked *parked)
{
  PetscInt first;

  PetscFunctionBeginUser;
  PetscCall(DMSwarmGetLocalSize(particles->swarm, &first));
  if (parked->count) {
    PetscCall(MpmParticlesRelease(particles));
    PetscCall(DMSwarmAddNPoints(particles->swarm, parked->count));
    PetscCall(CopyPoints(particles, parked->count, NULL, first, parked->data, PETSC_FALSE));
  }
  PetscCall(CountTotal(particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParticlesReturn(MpmParticles *particles, MpmParked *parked)
{
  PetscFunctionBeginUser;
  PetscCall(Append(particles, parked));
  PetscCall(PetscFree(parked->data));
  parked->count = 0;
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

PetscErrorCode MpmParticlesTakeUp(MpmParticles *particles, const MpmParked *kept)
{
  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRelease(particles));
  PetscCall(DMSwarmSetLocalSizes(particles->swarm, kept->count, -1));
  PetscCall(CopyPoints(particles, kept->count, NULL, 0, kept->data, PETSC_FALSE));
  PetscCall(CountTotal(particles));
  PetscFunctionReturn(PETSC_SUCCESS);
}
