#pragma once
/*
  Motion from rest to rest where a quasi-static step finds no state under a smaller strength (settle.c).
*/
#include "base/types.h"
#include "talus/talus.h"
#include "query/scene.h"

/* Rows of the state (base/rows.h). */
PetscErrorCode MpmSettleAddRows(MpmModel model);
/*
  Goes on to `next`, by steps of `dt` for what rates there are, until the ground is at rest there. Failure: the ground
  passes the limit of the reduction (state.safety.beyond > 0), or does not settle; the points are then where they were.
*/
PetscErrorCode MpmSettle(MpmModel model, PetscReal next, PetscReal dt, MpmOutcome *outcome);
