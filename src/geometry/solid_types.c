/*
  The process' list of types of bodies in contact, to which callers and plugins add until PetscFinalize(), as to that of
  laws (registry.c).
*/
#include "base/base.h"
#include "geometry/solid.h"
#include "geometry/solid_types.h"

static struct {
  PetscInt            count;
  MpmContactBodyType *type;
} registry;

static PetscErrorCode Forget(void)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(registry.type));
  registry.count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmContactBodyType *MpmContactBodyTypeAt(PetscInt k)
{
  return k >= 0 && k < registry.count ? &registry.type[k] : NULL;
}

PetscErrorCode MpmContactBodyRegister(const MpmContactBodyType *type)
{
  PetscFunctionBegin;
  MpmCheckInput(type->name && type->name[0] && type->distance,
                "a type of body without a name or without distance() cannot be registered");
  for (PetscInt k = 0; k < registry.count; k++) {
    if (strcmp(registry.type[k].name, type->name)) continue;
    MpmCheckInput(registry.type[k].distance == type->distance, "body %s: there is a type of this name already",
                  type->name);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt k = 0; k < MPM_SOLID_ADDED; k++)
    MpmCheckInput(strcmp(MpmSolidTypes[k], type->name), "body %s: a type of this name is built in", type->name);
  if (!registry.count) PetscCall(PetscRegisterFinalize(Forget));
  PetscCall(PetscRealloc((size_t)(registry.count + 1) * sizeof(*registry.type), &registry.type));
  registry.type[registry.count++] = *type;
  PetscFunctionReturn(PETSC_SUCCESS);
}
