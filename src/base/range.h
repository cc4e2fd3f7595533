#pragma once
/*
  Ranges of numbers.
*/
#include "base/base.h"

/* Accepted range; `open` excludes the bounds themselves. */
typedef struct {
  PetscReal lower, upper;
  PetscBool open;
} MpmRange;
#define MPM_RANGE_ANY          ((MpmRange){PETSC_NINFINITY, PETSC_INFINITY, PETSC_FALSE})
#define MPM_RANGE_POSITIVE     ((MpmRange){0., PETSC_INFINITY, PETSC_TRUE})
#define MPM_RANGE_NON_NEGATIVE ((MpmRange){0., PETSC_INFINITY, PETSC_FALSE})
