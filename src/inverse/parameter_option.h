#pragma once
/*
  Options of a scene's parameters, for runs with other values.
*/
#include "sensitivity/parameters.h"
#include "talus/talus.h"

/* The option of a parameter gets this value, in the database in force; of a factor its multiple of the scene's. */
PetscErrorCode MpmSceneParameterSetOption(const MpmModel model, const MpmSceneParameter *parameter, PetscReal number);
