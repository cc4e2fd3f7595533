#pragma once
/*
  Scenes of depth-averaged flow: the bed, and depths of bodies.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* The bed of a scene whose physics is one of columns, once the grid has been read; otherwise nothing. */
PetscErrorCode MpmTerrainRead(MpmModel model, const MpmOptions *options);
/* Parameters of laws of the bed by maps, once the materials have been read. */
PetscErrorCode MpmTerrainReadParameters(MpmModel model, const MpmOptions *options);
/* Fails where the stages or loads are none of depth-averaged flow. */
PetscErrorCode MpmTerrainCheck(const MpmModel model);
PetscErrorCode MpmTerrainDestroy(MpmModel model);
