/*
  Singular values of small matrices. LAPACK takes columns: of it the transpose is asked for.
*/
#include "inverse/singular.h"
#include <petscblaslapack.h>

PetscErrorCode MpmSingularCreate(PetscInt rows, PetscInt columns, const PetscReal a[], MpmSingular *singular)
{
  const PetscBLASInt m = (PetscBLASInt)columns, n = (PetscBLASInt)rows, count = PetscMin(m, n);
  PetscBLASInt       info, size = 5 * (m + n) + 64;
  PetscReal         *copy, *left, *right, *work;

  PetscFunctionBeginUser;
  *singular = (MpmSingular){.rows = rows, .columns = columns, .count = count};
  PetscCall(
    PetscMalloc3((count + 1), &singular->value, (rows * count + 1), &singular->u, (columns * count + 1), &singular->v));
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc4((rows * columns), &copy, (m * count), &left, (count * n), &right, (PetscInt)size, &work));
  PetscCall(PetscArraycpy(copy, a, (rows * columns)));
  PetscCallBLAS("LAPACKgesvd",
                LAPACKgesvd_("S", "S", &m, &n, copy, &m, singular->value, left, &m, right, &count, work, &size, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK gesvd failed with %d", (int)info);
  for (PetscInt i = 0; i < count; i++) {
    for (PetscInt k = 0; k < columns; k++) singular->v[k * count + i] = left[i * m + k];
    for (PetscInt k = 0; k < rows; k++) singular->u[k * count + i] = right[k * count + i];
  }
  PetscCall(PetscFree4(copy, left, right, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSingularDestroy(MpmSingular *singular)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree3(singular->value, singular->u, singular->v));
  PetscFunctionReturn(PETSC_SUCCESS);
}
