#pragma once
/*
  How a scene's and its stages' time is cut into steps: options of time blocks.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"
#include "query/scene.h"

/* One block, by its prefix; `control` holds the defaults on entry, where a step of 0 is none. */
PetscErrorCode MpmTimeControlRead(const MpmOptions *options, const char *prefix, MpmTimeControl *control);
/* The scene's own block. Where all stages have a step of their own, the scene needs none. */
PetscErrorCode MpmSceneTimeRead(MpmModel model, const MpmOptions *options, MpmTimeControl *control);
