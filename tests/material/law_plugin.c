/*
  The law of a plugin as the one under test. The plugin registers all that it has, as with the program; its laws are kept, and
  all else is passed over.
*/
#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include "law_plugin.h"
#include "laws.h"
#include "talus/plugin.h"

static struct {
  const char *name;
  Constructor found[INSTANCES];
} wanted;

static PetscErrorCode KeepLaw(PetscInt count, const MpmLawInstance instances[])
{
  static const int place[MPM_FORM_COUNT] = {[MPM_FORM_RESIDUAL]    = PLAIN,
                                            [MPM_FORM_DIRECTION]   = ONE_DIRECTION,
                                            [MPM_FORM_TANGENT]     = ALL_DIRECTIONS,
                                            [MPM_FORM_SENSITIVITY] = SENSITIVITY};

  for (PetscInt k = 0; k < count; ++k)
    if (instances[k].kinematics == DIM && !strcmp(instances[k].name, wanted.name))
      wanted.found[place[instances[k].form]] = instances[k].create;
  return 0;
}

static PetscErrorCode PassPhysics(const MpmPhysics *physics)
{
  (void)physics;
  return 0;
}

static PetscErrorCode PassTerm(const MpmTermType *type)
{
  (void)type;
  return 0;
}

static PetscErrorCode PassContactBody(const MpmContactBodyType *type)
{
  (void)type;
  return 0;
}

static int Refuse(const char path[], const char fault[], const char detail[])
{
  (void)fprintf(stderr, "talus: error: check-law %s: %s%s\n", path, fault, detail);
  return 2;
}

int LawPluginUse(const char path[], const char name[])
{
  const MpmPluginHost host = {KeepLaw, PassPhysics, PassTerm, PassContactBody};
  char                place[4096];
  const char         *version;
  void               *handle;
  PetscErrorCode (*entry)(const MpmPluginHost *);

  (void)snprintf(place, sizeof place, "%s%s", strchr(path, '/') ? "" : "./", path);
  handle = dlopen(place, RTLD_NOW | RTLD_LOCAL);
  if (!handle) return Refuse(path, "cannot be loaded: ", dlerror());
  version                    = (const char *)dlsym(handle, "MpmPluginVersion");
  *(void **)(void *)(&entry) = dlsym(handle, "MpmPluginRegister");
  if (!version || !entry) return Refuse(path, "is no plugin: it has no MpmPluginVersion and MpmPluginRegister", "");
  if (strcmp(version, MPM_VERSION))
    return Refuse(path, "these tests are of Talus " MPM_VERSION ", it is for ", version);
  wanted.name = name;
  if (entry(&host)) return Refuse(path, "does not register", "");
  for (int k = 0; k < INSTANCES; ++k)
    if (!wanted.found[k]) return Refuse(path, "has no law ", name);
  LawUse(wanted.found);
  return 0;
}
