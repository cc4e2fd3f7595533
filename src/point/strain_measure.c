/*
  Logarithmic and engineering strain, by principal values.

  With e = Q diag(e_a) Q^T the stretch is U = Q diag(exp(e_a)) Q^T, and its derivative in the direction H is

    dU = Q (D o Q^T H Q) Q^T,
    D_ab = (exp(e_a) - exp(e_b))/(e_a - e_b) = exp((e_a + e_b)/2) sinh(t)/t,   t = (e_a - e_b)/2

  (o component by component): exact where principal values are equal or nearly so. Source: Daleckii and Krein (1965),
  AMS Translations 47, 1-30, doi:10.1090/trans2/047/01.
*/
#include <petscsys.h>
#include <petscblaslapack.h>
#include "point/strain_measure.h"

const char *const MpmStrainMeasures[]             = {"log", "engineering", NULL};
const PetscInt    MpmSpacePairs[MPM_SPACE_SYM][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};

static void FullFromSym(const PetscReal sym[MPM_SPACE_SYM], PetscReal full[9])
{
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++)
    full[MpmSpacePairs[s][0] * 3 + MpmSpacePairs[s][1]] = full[MpmSpacePairs[s][1] * 3 + MpmSpacePairs[s][0]] = sym[s];
}

/* Principal values of a symmetric tensor, and their axes: axis a is axes[3 a], axes[3 a + 1], axes[3 a + 2]. */
static PetscErrorCode Principal(const PetscReal full[9], PetscReal value[3], PetscReal axes[9])
{
  PetscBLASInt n = 3, size = 34, info;
  PetscScalar  work[34];

  PetscFunctionBeginUser;
  PetscCall(PetscArraycpy(axes, full, 9));
  PetscCallBLAS("LAPACKsyev", LAPACKsyev_("V", "U", &n, axes, &n, value, work, &size, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK syev failed with %d", (int)info);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPrincipalValues(const PetscReal sym[MPM_SPACE_SYM], PetscReal value[3])
{
  PetscReal full[9], axes[9];

  PetscFunctionBeginUser;
  FullFromSym(sym, full);
  PetscCall(Principal(full, value, axes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* sum_ab middle_ab axis_a (x) axis_b */
static void FromAxes(const PetscReal axes[9], const PetscReal middle[9], PetscReal full[9])
{
  for (PetscInt i = 0; i < 3; i++) {
    for (PetscInt j = 0; j < 3; j++) {
      PetscReal sum = 0.;

      for (PetscInt a = 0; a < 3; a++)
        for (PetscInt b = 0; b < 3; b++) sum += middle[3 * a + b] * axes[3 * a + i] * axes[3 * b + j];
      full[3 * i + j] = sum;
    }
  }
}

PetscErrorCode MpmStrainFromDeformation(MpmStrainMeasure measure, const PetscReal F[9], PetscReal strain[MPM_SPACE_SYM])
{
  PetscReal b[9], value[3], axes[9], middle[9] = {0.}, full[9];

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < 3; i++)
    for (PetscInt j = 0; j < 3; j++)
      b[3 * i + j] = F[3 * i] * F[3 * j] + F[3 * i + 1] * F[3 * j + 1] + F[3 * i + 2] * F[3 * j + 2];
  if (measure == MPM_STRAIN_LOG) {
    PetscCall(Principal(b, value, axes));
    for (PetscInt a = 0; a < 3; a++) middle[4 * a] = 0.5 * PetscLogReal(value[a]);
    FromAxes(axes, middle, full);
  } else {
    for (PetscInt i = 0; i < 3; i++)
      for (PetscInt j = 0; j < 3; j++) full[3 * i + j] = 0.5 * (F[3 * i + j] + F[3 * j + i]) - (i == j ? 1. : 0.);
  }
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) strain[s] = full[3 * MpmSpacePairs[s][0] + MpmSpacePairs[s][1]];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStretchFromStrain(MpmStrainMeasure measure, const PetscReal strain[MPM_SPACE_SYM], PetscReal F[9])
{
  PetscReal full[9], value[3], axes[9], middle[9] = {0.};

  PetscFunctionBeginUser;
  FullFromSym(strain, full);
  if (measure == MPM_STRAIN_LOG) {
    PetscCall(Principal(full, value, axes));
    for (PetscInt a = 0; a < 3; a++) middle[4 * a] = PetscExpReal(value[a]);
    FromAxes(axes, middle, F);
  } else
    for (PetscInt k = 0; k < 9; k++) F[k] = full[k] + (k % 4 ? 0. : 1.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* (exp(a) - exp(b))/(a - b) */
static PetscReal ExpDifference(PetscReal a, PetscReal b)
{
  const PetscReal t = 0.5 * (a - b), t2 = t * t;

  return PetscExpReal(0.5 * (a + b)) * (t2 < 1e-6 ? 1. + t2 / 6. * (1. + t2 / 20.) : PetscSinhReal(t) / t);
}

PetscErrorCode MpmStretchDerivative(MpmStrainMeasure measure, const PetscReal strain[MPM_SPACE_SYM], PetscInt component,
                                    PetscReal dF[9])
{
  const PetscInt i = MpmSpacePairs[component][0], j = MpmSpacePairs[component][1];
  PetscReal      full[9], value[3], axes[9], middle[9];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < 9; k++) dF[k] = (k == 3 * i + j || k == 3 * j + i) ? 1. : 0.;
  if (measure == MPM_STRAIN_ENGINEERING) PetscFunctionReturn(PETSC_SUCCESS);
  FullFromSym(strain, full);
  PetscCall(Principal(full, value, axes));
  for (PetscInt a = 0; a < 3; a++) {
    for (PetscInt b = 0; b < 3; b++) {
      middle[3 * a + b] = axes[3 * a + i] * axes[3 * b + j];
      if (i != j) middle[3 * a + b] += axes[3 * a + j] * axes[3 * b + i];
      middle[3 * a + b] *= ExpDifference(value[a], value[b]);
    }
  }
  FromAxes(axes, middle, dF);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmVolumeStrain(MpmStrainMeasure measure, const PetscReal F[9])
{
  const PetscReal J = MpmDeterminant(9, F);

  return measure == MPM_STRAIN_LOG ? PetscLogReal(J) : J - 1.;
}

PetscReal MpmDeviatorSize(const PetscReal sym[MPM_SPACE_SYM])
{
  const PetscReal xy = sym[0] - sym[1], yz = sym[1] - sym[2], zx = sym[2] - sym[0];

  return PetscSqrtReal(0.5 * (xy * xy + yz * yz + zx * zx) +
                       3. * (sym[3] * sym[3] + sym[4] * sym[4] + sym[5] * sym[5]));
}
