#pragma once
/*
  Boundaries whose surface is of a type from outside the tree.
*/
#include "base/base.h"
#include "base/types.h"
#include "geometry/solid.h"

/* The body of a solid of the type MPM_SOLID_ADDED, with the parameters in its block; of others nothing. */
PetscErrorCode MpmAddedBodyRead(const MpmOptions *block, const char name[], MpmSolid *solid);
/* For -help: every type with its parameters. */
PetscErrorCode MpmAddedBodiesPrint(const MpmOptions *block);
PetscErrorCode MpmAddedBodyDestroy(MpmSolid *solid);
