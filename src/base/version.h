#pragma once
/*
  Versions of vectors, for results that belong to values of one.
*/
#include <petscvec.h>
#include "base/base.h"

/* Version of a vector's values: PETSc counts every change. */
typedef struct {
  PetscObjectId    id; /* 0: none */
  PetscObjectState state;
} MpmVersion;

PetscErrorCode MpmVersionGet(Vec u, MpmVersion *version);
PetscBool      MpmVersionIsSame(const MpmVersion *a, const MpmVersion *b);
