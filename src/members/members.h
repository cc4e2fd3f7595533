#pragma once
/*
  Runs of an ensemble's members.
*/
#include "talus/talus.h"

/*
  The task ensemble: runs all members, those that are there already aside, and writes tables, statistics and maps;
  `status` of the program. The scene itself is not run. Collective, with the model's options in force.
*/
PetscErrorCode MpmEnsembleRun(MpmModel model, int *status);
