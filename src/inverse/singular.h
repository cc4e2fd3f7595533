#pragma once
/*
  Singular values of small matrices, by LAPACK.
*/
#include "base/base.h"

/*
  A = U diag(value) V^T of a matrix of rows x columns, row by row; `count` is the lesser of both. u[row*count + i],
  v[column*count + i]; values descend.
*/
typedef struct {
  PetscInt   rows, columns, count;
  PetscReal *value, *u, *v;
} MpmSingular;

PetscErrorCode MpmSingularCreate(PetscInt rows, PetscInt columns, const PetscReal a[], MpmSingular *singular);
PetscErrorCode MpmSingularDestroy(MpmSingular *singular);
