#pragma once
/*
  Reading of stages (stage_read.c, geostatic_read.c) and of relaxations (relaxation_read.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"
#include "query/scene.h"

/* Stages, whose lists have been read (stage_lists.h), when the scene is known. */
PetscErrorCode MpmStagesRead(MpmModel model, const MpmOptions *options);
/*
  A geostatic stage (geostatic_read.c). Read: its options. Check: the stage is a state of equilibrium, and the engine
  must know the stress of every law.
*/
PetscErrorCode MpmGeostaticRead(MpmModel model, const MpmOptions *options, const char *name, MpmGeostatic *geostatic);
PetscErrorCode MpmGeostaticCheck(MpmModel model, const MpmStage *stage);
/* Options of a relaxation, and of a rescue by one; `relaxation` holds the defaults on entry. */
void           MpmRelaxationDefaults(MpmRelaxation *relaxation);
PetscErrorCode MpmRelaxationRead(const MpmOptions *block, PetscBool rescue, MpmRelaxation *relaxation);
