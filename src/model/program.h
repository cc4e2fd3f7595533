#pragma once
/*
  Calls that the program makes of a model beside those of the library (talus.h).
*/
#include "options/database.h"
#include "talus/talus.h"

/* Where the options of the command line were given; borrowed until the model is destroyed. */
void MpmModelSetSources(MpmModel model, MpmSources sources);
/* Prints what a scene comes to, and whether its first step converges; writes no file. `status` of the program. */
PetscErrorCode MpmModelCheck(MpmModel model, int *status);
/* Writes the points before the first step and the options, as a run does, under a prefix of its own. */
PetscErrorCode MpmModelWriteStart(MpmModel model, const char prefix[]);
