#pragma once
/*
  The initial pressure of water, nodes where it is prescribed (water_state.c), and limits of it (water_limits.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* Reads the level; materials, loads, grid and layout are known. */
PetscErrorCode MpmWaterReadLevel(MpmModel model, const MpmOptions *options);
/* The pressure of the points with ids in [first, end) at the time of the state: water at rest, and the bodies' excess;
   of another field with a rate what the bodies start with. Collective. */
PetscErrorCode MpmWaterFillPressure(MpmModel model, PetscInt first, PetscInt end);
/*
  Prescribed pressures at nodes in a step to `time`: those not below the level, and in a geostatic stage all, as at the
  points. Constraints and space are set up.
*/
PetscErrorCode MpmWaterHold(MpmModel model, PetscReal time);
/* A line on the lowest pressure where water would boil, once a stage; otherwise empty. Collective. */
#define MPM_WATER_TEXT 256
PetscErrorCode MpmWaterFindTension(MpmModel model, char text[MPM_WATER_TEXT]);
/* A line on water that has no effect, once a stage: what a load of type flux brings into dry ground, and a level that
   moves in ground with suction that nothing drains; otherwise empty. Collective. */
PetscErrorCode MpmWaterFindLost(MpmModel model, char text[MPM_WATER_TEXT]);
/* After a step that failed: another reason where a point's pores are as good as closed. Collective. */
PetscErrorCode MpmWaterFindClosed(MpmModel model, MpmOutcome *outcome);
/* After a step: fails where rising water lifts ground without effective stress. */
PetscErrorCode MpmWaterFindHeave(MpmModel model, MpmOutcome *outcome);
