#pragma once
/*
  Columns of the history in scenes with a dynamic stage (motion_columns.c): velocities of tracks, energies, momentum.
*/
#include "base/base.h"
#include "base/types.h"

/* How many there are; 0 in scenes without. */
PetscInt       MpmMotionColumnCount(const MpmModel model);
PetscErrorCode MpmMotionAddColumns(MpmModel model, char **names, PetscInt *count);
/* Their values from row[*count] on. Collective. */
PetscErrorCode MpmMotionAddValues(MpmModel model, PetscReal row[], PetscInt *count);
