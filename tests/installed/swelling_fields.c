/*
  The fields and parameters of the physics `swelling`.
*/
#include "talus/plugin.h"

void MpmPhysicsDescribe_swelling(MpmPhysics *physics);

static const MpmField fields[] = {
  {.name = "displacement", .gradient = PETSC_TRUE, .increment = PETSC_TRUE},
  {.name = "solvent", .components = 1, .value = PETSC_TRUE, .gradient = PETSC_TRUE, .rate = PETSC_TRUE},
};
static const double parameters[] = {0.3, 0.1, 0.5};

void MpmPhysicsDescribe_swelling(MpmPhysics *physics)
{
  physics->name            = "swelling";
  physics->summary         = "a solid that swells with what diffuses through it";
  physics->field_count     = (PetscInt)(sizeof(fields) / sizeof(fields[0]));
  physics->fields          = fields;
  physics->parameter_count = (PetscInt)(sizeof(parameters) / sizeof(parameters[0]));
  physics->parameters      = parameters;
}
