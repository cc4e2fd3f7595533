#pragma once
/*
  The grid that follows a motion or a body (moving_grid.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/*
  The moving grid (moving_grid.c): Read takes the options, Select marks the points of a body that it follows, Follow
  sets the grid for the present points, at a step's start or where points come and go.
*/
PetscErrorCode MpmMovingGridRead(MpmModel model, const MpmOptions *options);
/* Columns of the history: extents of the grid along the axes on which it moves. */
PetscErrorCode MpmMovingGridAddColumns(MpmModel model, MpmColumns *columns);
PetscErrorCode MpmMovingGridSelect(MpmModel model);
PetscErrorCode MpmMovingGridFollow(MpmModel model, MpmOutcome *outcome);
/* After the solution of a step: the grid as the next one will have it; it borrows the model's grid's parts. */
PetscErrorCode MpmMovingGridNext(MpmModel model, MpmGrid *next);
/* The field of the points that a followed body has, NULL where the scene has none. */
const char *MpmMovingGridField(const MpmModel model);
