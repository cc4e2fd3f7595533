/*
  Ordinary kriging between pilot points.

    C(a, b) = exp(-|(a - b)/l|)                  covariance over the sill, l the correlation length of each axis
    w = C^-1 (c + 1 (1 - 1.C^-1 c)/(1.C^-1 1))   weights at x, c_i = C(x, x_i); their sum is 1
    z(x) = w . z = m + c . b ,   m = 1.C^-1 z/(1.C^-1 1) ,   b = C^-1 (z - m 1)

  A pilot's place has its value; constant values make a constant field. Derivatives by z of sum_x g w(x) . z need the
  sums q of g c and s of g alone: they are C^-1 (q + 1 (s - 1.C^-1 q)/(1.C^-1 1)).
  Source: Isaaks and Srivastava (1989), An Introduction to Applied Geostatistics, chapter 12.
*/
#include "ground/ground.h"
#include <petscblaslapack.h>

struct _p_MpmKriging {
  PetscInt   dim, count;
  PetscReal *at; /* over the lengths, dim each */
  PetscReal  length[MPM_MAX_DIM];
  PetscReal *factor; /* of Cholesky's, by columns, lower */
  PetscReal *ones;   /* C^-1 1 */
  PetscReal  sum;    /* 1.C^-1 1 */
};

/* Covariance of a place over the lengths and one of the points. */
static PetscReal Covariance(const MpmKriging kriging, const PetscReal x[], PetscInt k)
{
  PetscReal square = 0.;

  for (PetscInt a = 0; a < kriging->dim; a++) square += PetscSqr(x[a] - kriging->at[k * kriging->dim + a]);
  return PetscExpReal(-PetscSqrtReal(square));
}

/* y becomes C^-1 y. */
static PetscErrorCode Solve(const MpmKriging kriging, PetscReal y[])
{
  PetscBLASInt n, one = 1, info;

  PetscFunctionBeginUser;
  PetscCall(PetscBLASIntCast(kriging->count, &n));
  PetscCallBLAS("LAPACKpotrs", LAPACKpotrs_("L", &n, &one, kriging->factor, &n, y, &n, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK potrs failed with %d", (int)info);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmKrigingCreate(PetscInt dim, PetscInt count, const PetscReal at[], const PetscReal length[],
                                MpmKriging *kriging)
{
  MpmKriging   made;
  PetscBLASInt n, info;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&made));
  *kriging    = made;
  made->dim   = dim;
  made->count = count;
  PetscCall(PetscBLASIntCast(count, &n));
  PetscCall(
    PetscMalloc3((size_t)(count * dim), &made->at, (size_t)count * (size_t)count, &made->factor, count, &made->ones));
  for (PetscInt a = 0; a < dim; a++) made->length[a] = length[a];
  for (PetscInt k = 0; k < count * dim; k++) made->at[k] = at[k] / length[k % dim];
  for (PetscInt k = 0; k < count; k++)
    for (PetscInt i = 0; i < count; i++) made->factor[k * count + i] = Covariance(made, &made->at[k * dim], i);
  PetscCallBLAS("LAPACKpotrf", LAPACKpotrf_("L", &n, made->factor, &n, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK potrf failed with %d", (int)info);
  for (PetscInt k = 0; k < count; k++) made->ones[k] = 1.;
  PetscCall(Solve(made, made->ones));
  for (PetscInt k = 0; k < count; k++) made->sum += made->ones[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmKrigingDestroy(MpmKriging *kriging)
{
  PetscFunctionBeginUser;
  if (!*kriging) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree3((*kriging)->at, (*kriging)->factor, (*kriging)->ones));
  PetscCall(PetscFree(*kriging));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmKrigingFit(const MpmKriging kriging, const PetscReal z[], PetscReal coefficient[])
{
  const PetscInt count = kriging->count;
  PetscReal      mean  = 0.;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) mean += kriging->ones[k] * z[k] / kriging->sum;
  for (PetscInt k = 0; k < count; k++) coefficient[k] = z[k] - mean;
  PetscCall(Solve(kriging, coefficient));
  coefficient[count] = mean;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A place over the lengths. */
static void Scale(const MpmKriging kriging, const PetscReal x[], PetscReal scaled[])
{
  for (PetscInt a = 0; a < kriging->dim; a++) scaled[a] = x[a] / kriging->length[a];
}

PetscReal MpmKrigingEvaluate(const MpmKriging kriging, const PetscReal coefficient[], const PetscReal x[])
{
  PetscReal sum = coefficient[kriging->count], at[MPM_MAX_DIM];

  Scale(kriging, x, at);
  for (PetscInt k = 0; k < kriging->count; k++) sum += coefficient[k] * Covariance(kriging, at, k);
  return sum;
}

void MpmKrigingAdd(const MpmKriging kriging, const PetscReal x[], PetscReal by, PetscReal sums[])
{
  PetscReal at[MPM_MAX_DIM];

  Scale(kriging, x, at);
  for (PetscInt k = 0; k < kriging->count; k++) sums[k] += by * Covariance(kriging, at, k);
  sums[kriging->count] += by;
}

PetscErrorCode MpmKrigingPull(const MpmKriging kriging, const PetscReal sums[], PetscReal z[])
{
  const PetscInt count = kriging->count;
  PetscReal      rest  = sums[count];

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(z, sums, count));
  PetscCall(Solve(kriging, z));
  for (PetscInt k = 0; k < count; k++) rest -= z[k];
  for (PetscInt k = 0; k < count; k++) z[k] += kriging->ones[k] * rest / kriging->sum;
  PetscFunctionReturn(PETSC_SUCCESS);
}
