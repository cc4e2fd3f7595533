/*
  The process' list of types of terms, to which callers and plugins add until PetscFinalize(), as to that of laws
  (registry.c).
*/
#include "base/base.h"
#include "point/term_types.h"

static struct {
  PetscInt     count;
  MpmTermType *type;
} registry;

static PetscErrorCode Forget(void)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(registry.type));
  registry.count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTermType *MpmTermTypeAt(PetscInt k)
{
  return k < registry.count ? &registry.type[k] : NULL;
}

const MpmTermType *MpmTermTypeFind(const char name[])
{
  for (PetscInt k = 0; k < registry.count; k++)
    if (!strcmp(registry.type[k].name, name)) return &registry.type[k];
  return NULL;
}

PetscErrorCode MpmTermRegister(const MpmTermType *type)
{
  const MpmTermType *other;

  PetscFunctionBegin;
  MpmCheckInput(type->name && type->name[0] && type->evaluate,
                "a type of term without a name or without evaluate() cannot be registered");
  other = MpmTermTypeFind(type->name);
  if (other && other->evaluate == type->evaluate) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!other, "term %s: there is a type of this name already", type->name);
  if (!registry.count) PetscCall(PetscRegisterFinalize(Forget));
  PetscCall(PetscRealloc((size_t)(registry.count + 1) * sizeof(*registry.type), &registry.type));
  registry.type[registry.count++] = *type;
  PetscFunctionReturn(PETSC_SUCCESS);
}
