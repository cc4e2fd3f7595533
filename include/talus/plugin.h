#pragma once
/*
  Laws, physics, terms and bodies in contact that are compiled outside the tree: a shared library that -mpm_plugin
  loads.

  talus_add_plugin() of the installed CMake package makes one; the file that it generates defines the two symbols below.
*/
#include "talus/talus.h"
#include "talus/contact.h"
#include "talus/term.h"

/* Services of the program for a plugin, which calls nothing else of it. */
typedef struct {
  PetscErrorCode (*register_law)(PetscInt count, const MpmLawInstance instances[]);
  PetscErrorCode (*register_physics)(const MpmPhysics *physics);
  PetscErrorCode (*register_term)(const MpmTermType *type);
  PetscErrorCode (*register_contact_body)(const MpmContactBodyType *type);
} MpmPluginHost;

#pragma GCC visibility push(default)
/* MPM_VERSION of the headers that the plugin was compiled with. */
extern const char MpmPluginVersion[];
/* Registers all that is in the plugin; called once. */
PetscErrorCode         MpmPluginRegister(const MpmPluginHost *host);
#pragma GCC visibility pop
