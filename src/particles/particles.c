/*
  The material points: a DMSwarm of type BASIC whose fields are those that the scene's physics and materials use, and no
  other.
*/
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"

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

/* All fields of a scene: first those of the points themselves, then those that parts of the program ask for by name. */
static PetscErrorCode RegisterFields(const MpmGrid *grid, const MpmParticleFields *fields, MpmParticles *particles)
{
  const PetscInt dim = grid->dim;
  const struct {
    const char   *name;
    PetscBool     there;
    PetscInt      components;
    PetscDataType type;
  } rows[] = {
    {"id", PETSC_TRUE, 1, PETSC_INT},
    {"material", PETSC_TRUE, 1, PETSC_INT},
    {"position", PETSC_TRUE, dim, PETSC_REAL},
    {"position0", PETSC_TRUE, dim, PETSC_REAL},
    {"origin", fields->origin, dim, PETSC_REAL},
    {"F", PETSC_TRUE, MpmGridF(grid), PETSC_REAL},
    {"volume0", PETSC_TRUE, 1, PETSC_REAL},
    {"stress", PETSC_TRUE, MpmSymSize(dim), PETSC_REAL},
    {"mass", particles->has_mass, 1, PETSC_REAL},
    {"across", fields->across, 1, PETSC_REAL},
    {"half_length", fields->half_length, dim, PETSC_REAL},
    {"drawn", fields->drawn, dim, PETSC_REAL},
    {"faces", fields->faces, 1, PETSC_INT},
    {"divisions", fields->divisions, 1, PETSC_INT},
    {"part", fields->part, 1, PETSC_INT},
    {"cut", fields->part, dim + 1, PETSC_REAL},
    {"state", (PetscBool)(fields->state_size > 0), fields->state_size, PETSC_REAL},
    {"parameter", (PetscBool)(fields->parameters > 0), fields->parameters, PETSC_REAL},
    {"own", (PetscBool)(fields->own_size > 0), fields->own_size, PETSC_REAL},
    {"increment", fields->increment, MPM_INCREMENT(dim), PETSC_REAL},
    {"value", (PetscBool)(fields->rates > 0), fields->rates, PETSC_REAL},
    {"value_gradient", (PetscBool)(fields->rates > 0), fields->rates * dim, PETSC_REAL},
    {"velocity", fields->velocity, dim, PETSC_REAL},
    {"affine", fields->affine, dim * dim, PETSC_REAL},
    {"acceleration", fields->acceleration, dim, PETSC_REAL},
  };
  const size_t count = PETSC_STATIC_ARRAY_LENGTH(rows);

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(((PetscInt)count + fields->extra_count), &particles->fields));
  for (size_t k = 0; k < count; k++)
    if (rows[k].there) PetscCall(Register(particles, rows[k].name, rows[k].components, rows[k].type));
  for (PetscInt e = 0; e < fields->extra_count; e++) PetscCall(Register(particles, fields->extra[e], 1, PETSC_REAL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

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
  PetscCall(RegisterFields(grid, fields, particles));
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
  particles->lent = 0; /* a scene that is refused while it is set up has not given its fields back */
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
  points->id                 = HeldArray(particles, "id");
  points->material           = HeldArray(particles, "material");
  points->x                  = HeldArray(particles, "position");
  points->x0                 = HeldArray(particles, "position0");
  points->origin             = MpmParticlesHaveField(particles, "origin") ? HeldArray(particles, "origin") : points->x0;
  points->F_size             = particles->F_size;
  points->F                  = HeldArray(particles, "F");
  points->volume0            = HeldArray(particles, "volume0");
  points->stress             = HeldArray(particles, "stress");
  points->mass               = HeldArray(particles, "mass");
  points->across             = HeldArray(particles, "across");
  points->domain.half_length = HeldArray(particles, "half_length");
  points->domain.drawn =
    MpmParticlesHaveField(particles, "drawn") ? HeldArray(particles, "drawn") : points->domain.half_length;
  points->state                  = HeldArray(particles, "state");
  points->parameter              = HeldArray(particles, "parameter");
  points->physics.own            = HeldArray(particles, "own");
  points->motion.increment       = HeldArray(particles, "increment");
  points->domain.faces           = HeldArray(particles, "faces");
  points->domain.divisions       = HeldArray(particles, "divisions");
  points->domain.part            = HeldArray(particles, "part");
  points->domain.cut             = HeldArray(particles, "cut");
  points->physics.value          = HeldArray(particles, "value");
  points->physics.value_gradient = HeldArray(particles, "value_gradient");
  points->motion.velocity        = HeldArray(particles, "velocity");
  points->motion.affine          = HeldArray(particles, "affine");
  points->motion.acceleration    = HeldArray(particles, "acceleration");
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
