/*
  Derivatives of a stress point's steps.

  A step solves r(e; s, p) = 0 for the unknown strains e, the prescribed components of the stress less their goals, from
  the state s and parameters p, and makes the state s' = c(e; s, p). Along a direction of s and p

    J de = -dr,   ds' = dc/de de + dc/ds ds + dc/dp dp

  with J by the law's sensitivity form, as all else. Where strains only redistribute plastic flow J is singular, and the
  step was the shortest one from the strains at its start: the part of de that J does not see is that of the start's.
  Goals do not depend on s and p.
*/
#include <petscsys.h>
#include <petscblaslapack.h>
#include "base/outcome.h"
#include "point/material.h"
#include "point/stress_inversion.h"
#include "laboratory/stress_point_slopes.h"

#define SINGULAR     1e-12 /* of the law's stiffness: singular values below are rounding */
#define ROUNDING     1e-9  /* of the stress */
#define SMALL_STRAIN 1e-6
#define UNSOLVED     1e-6 /* of the right-hand side's parts: what J must not leave of their sum */

PetscInt MpmStressPointChangeSize(const MpmStressPoint *point)
{
  return MPM_CHANGE_HISTORY + point->material->state_size;
}

/* ---- the law ---- */

/* dF and F_n along a change of the deformation at the step's end and of the start. */
static void DeformationAlong(const MpmStressPointSlopes *slopes, const PetscReal F[], const PetscReal start[],
                             PetscReal dF[9], PetscReal F_n[9])
{
  const MpmStressPoint *point = slopes->point;
  const PetscInt        n     = point->dim;
  PetscReal             now[9], carrier[9], block[9] = {0.}, part[9], whole[9];

  for (PetscInt k = 0; k < n * n; k++) dF[k] = F_n[k] = 0.;
  if (F) {
    MpmMatrixBlock(n, F, block);
    MpmMatrixMultiply(n, block, slopes->increment.F_n_inverse, dF);
  }
  if (!start) return;
  MpmMatrixBlock(n, &start[MPM_CHANGE_F], block);
  MpmMatrixMultiply(n, slopes->increment.dF, block, part);
  MpmMatrixMultiply(n, part, slopes->increment.F_n_inverse, whole);
  for (PetscInt k = 0; k < n * n; k++) dF[k] -= whole[k];
  MpmMatrixBlock(n, point->F_start, carrier);
  MpmMatrixMultiply(n, block, carrier, part);
  MpmMatrixBlock(n, point->now.F, now);
  MpmMatrixBlock(n, &start[MPM_CHANGE_CARRIER], block);
  MpmMatrixMultiply(n, now, block, F_n);
  for (PetscInt k = 0; k < n * n; k++) F_n[k] += part[k];
}

/* Stress in the test's measure and history along F at the end, the start and parameters. */
static PetscErrorCode LawAlong(const MpmStressPointSlopes *slopes, const PetscReal F[], const PetscReal start[],
                               const PetscReal parameter[], PetscReal end[])
{
  const MpmStressPoint *point     = slopes->point;
  const PetscInt        n         = point->dim;
  const PetscBool       kirchhoff = (PetscBool)(point->stress_measure == MPM_STRESS_KIRCHHOFF);
  PetscReal dF[9] = {0.}, F_n[9] = {0.}, F_end[2][9], stress[2][MPM_SPACE_SYM] = {{0.}}, flux[9], dflux[9], cofactor[9];
  PetscReal         *state, J = 1., dJ = 0.;
  MpmKernelPoint     at;
  MpmKernelDirection direction = {.input = dF, .parameter = parameter, .F_n = F_n};
  MpmKernelEnd       derivative;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((point->material->state_size + 1), &state));
  DeformationAlong(slopes, F, start, dF, F_n);
  if (start && point->material->state_size) direction.state_n = &start[MPM_CHANGE_HISTORY];
  at         = MpmPointKernel(point, &slopes->increment);
  at.end     = (MpmKernelEnd){.F = F_end[0], .stress = stress[0]};
  derivative = (MpmKernelEnd){.F = F_end[1], .stress = stress[1]};
  if (point->material->state_size) {
    at.end.state     = state;
    derivative.state = &end[MPM_CHANGE_HISTORY];
  }
  PetscCheck(!point->kernel.sensitivity(&at, slopes->increment.H, &direction, flux, dflux, &derivative),
             PETSC_COMM_SELF, PETSC_ERR_FP, "the law has no answer at the solution of its step");
  if (kirchhoff && !MpmPointIsSmallStrain(point)) {
    J = MpmCofactors(n * n, F_end[0], cofactor);
    for (PetscInt k = 0; k < n * n; k++) dJ += cofactor[k] * F_end[1][k];
  }
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) end[MPM_CHANGE_STRESS + s] = J * stress[1][s] + dJ * stress[0][s];
  PetscCall(PetscFree(state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the equations ---- */

/* The inverse of J in the directions that it sees: V S^+ U^T. */
static PetscErrorCode Invert(MpmStressPointSlopes *slopes)
{
  const MpmStressPoint *point = slopes->point;
  const PetscInt        n     = point->equations.count;
  const PetscReal       least = SINGULAR * MpmMaterialStiffness(point->material, NULL, point->now.history, NULL);
  PetscReal             copy[MPM_SPACE_SYM * MPM_SPACE_SYM], left[MPM_SPACE_SYM * MPM_SPACE_SYM];
  PetscReal             right[MPM_SPACE_SYM * MPM_SPACE_SYM], singular[MPM_SPACE_SYM], work[10 * MPM_SPACE_SYM];
  PetscBLASInt          order, room = 10 * MPM_SPACE_SYM, info = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscBLASIntCast(n, &order));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++) copy[j * n + i] = slopes->jacobian[i * n + j];
  PetscCallBLAS("LAPACKgesvd", LAPACKgesvd_("A", "A", &order, &order, copy, &order, singular, left, &order, right,
                                            &order, work, &room, &info));
  PetscCheck(!info, PETSC_COMM_SELF, PETSC_ERR_LIB, "LAPACK gesvd failed with %d", (int)info);
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt j = 0; j < n; j++) {
      slopes->inverse[i * n + j] = 0.;
      for (PetscInt k = 0; k < n && singular[k] > least; k++)
        slopes->inverse[i * n + j] += right[i * n + k] / singular[k] * left[k * n + j];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* J, and the changes of the end by the unknown strains. */
static PetscErrorCode FindJacobian(MpmStressPointSlopes *slopes, const PetscReal strain[MPM_SPACE_SYM])
{
  const MpmStressPoint *point = slopes->point;
  const PetscInt        count = point->equations.count, size = MpmStressPointChangeSize(point);

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((count * size + 1), &slopes->by_unknown));
  for (PetscInt k = 0; k < count; k++) {
    const PetscInt component = point->equations.unknown[k];
    PetscReal     *end       = &slopes->by_unknown[k * size];

    PetscCall(MpmStretchDerivative(point->strain_measure, strain, component, &end[MPM_CHANGE_F]));
    PetscCall(LawAlong(slopes, &end[MPM_CHANGE_F], NULL, NULL, end));
    end[MPM_CHANGE_STRAIN + component] = 1.;
    for (PetscInt l = 0; l < count; l++)
      slopes->jacobian[l * count + k] = end[MPM_CHANGE_STRESS + point->equations.unknown[l]];
  }
  if (count) PetscCall(Invert(slopes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStressPointSlopesCreate(MpmStressPoint *point, const MpmPointControl *control, PetscReal dt,
                                          const PetscReal strain[MPM_SPACE_SYM], MpmStressPointSlopes *slopes)
{
  PetscReal F[9];

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(slopes, sizeof(*slopes)));
  slopes->point = point;
  point->dt     = dt;
  if (control->whole) PetscCall(PetscArraycpy(F, control->F, 9));
  else PetscCall(MpmStretchFromStrain(point->strain_measure, strain, F));
  PetscCheck(MpmPointIncrementFind(point, F, &slopes->increment), PETSC_COMM_SELF, PETSC_ERR_FP,
             "a stress point turns inside out at the solution of its step");
  PetscCall(FindJacobian(slopes, strain));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStressPointSlopesDestroy(MpmStressPointSlopes *slopes)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(slopes->by_unknown));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- along and back ---- */

/* de of J de = rate, from `start` on in directions that J does not see; PETSC_FALSE where J cannot meet the rate. */
static PetscBool SolveStrains(const MpmStressPointSlopes *slopes, PetscReal rounding, const PetscReal rate[],
                              const PetscReal start[], PetscReal strain[])
{
  const PetscInt n    = slopes->point->equations.count;
  PetscReal      most = 0., gap[MPM_SPACE_SYM];
  PetscBool      met  = PETSC_TRUE;

  for (PetscInt i = 0; i < n; i++) {
    PetscReal size = PetscAbsReal(rate[i]);

    gap[i] = rate[i];
    for (PetscInt j = 0; j < n; j++) {
      gap[i] -= slopes->jacobian[i * n + j] * start[j];
      size += PetscAbsReal(slopes->jacobian[i * n + j] * start[j]);
    }
    most = PetscMax(most, size);
  }
  for (PetscInt i = 0; i < n; i++) {
    strain[i] = start[i];
    for (PetscInt j = 0; j < n; j++) strain[i] += slopes->inverse[i * n + j] * gap[j];
  }
  for (PetscInt i = 0; i < n; i++) {
    PetscReal left = rate[i];

    for (PetscInt j = 0; j < n; j++) left -= slopes->jacobian[i * n + j] * strain[j];
    if (PetscAbsReal(left) > UNSOLVED * most + rounding) met = PETSC_FALSE;
  }
  return met;
}

/* The part that rounding leaves of the stress' change along parameters. */
static PetscReal Rounding(const MpmStressPoint *point, const PetscReal parameter[])
{
  const double *value = point->material->parameter;
  PetscReal     most = 0., stress = SMALL_STRAIN * point->material->moduli.stiffness;

  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) stress = PetscMax(stress, PetscAbsReal(point->now.stress[s]));
  for (size_t k = 0; parameter && k < point->material->info.parameter_count; k++)
    if (value[k] != 0.) most = PetscMax(most, PetscAbsReal(parameter[k] / value[k]));
  return ROUNDING * stress * most;
}

/* The change of the end; `met` is false where J cannot meet its rate. */
static PetscErrorCode EndAlong(const MpmStressPointSlopes *slopes, const PetscReal parameter[], const PetscReal start[],
                               PetscReal end[], PetscBool *met)
{
  const MpmStressPoint *point = slopes->point;
  const PetscInt        count = point->equations.count, size = MpmStressPointChangeSize(point);
  PetscReal             rate[MPM_SPACE_SYM], before[MPM_SPACE_SYM], strain[MPM_SPACE_SYM];

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(end, size));
  PetscCall(LawAlong(slopes, NULL, start, parameter, end));
  for (PetscInt k = 0; k < 9 && start; k++) end[MPM_CHANGE_CARRIER + k] = start[MPM_CHANGE_CARRIER + k];
  for (PetscInt k = 0; k < count; k++) {
    rate[k]   = -end[MPM_CHANGE_STRESS + point->equations.unknown[k]];
    before[k] = start ? start[MPM_CHANGE_STRAIN + point->equations.unknown[k]] : 0.;
  }
  *met = (PetscBool)(!count || SolveStrains(slopes, Rounding(point, parameter), rate, before, strain));
  for (PetscInt k = 0; k < count; k++)
    for (PetscInt i = 0; i < size; i++) end[i] += strain[k] * slopes->by_unknown[k * size + i];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStressPointSlopesAlong(const MpmStressPointSlopes *slopes, const PetscReal parameter[],
                                         const PetscReal start[], PetscReal end[], MpmOutcome *outcome)
{
  PetscBool met;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  PetscCall(EndAlong(slopes, parameter, start, end, &met));
  if (!met)
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                             "the test's stress lies at an apex of the yield surface, where no strain changes it: "
                             "there is no derivative"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Along one number of the start alone J need not meet the rate; along a parameter's change of all of them it does. */
PetscErrorCode MpmStressPointSlopesPull(const MpmStressPointSlopes *slopes, const PetscReal end[], PetscReal start[])
{
  const PetscInt size = MpmStressPointChangeSize(slopes->point);
  PetscReal     *unit, *change;
  PetscBool      met;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(size, &unit, size, &change));
  for (PetscInt i = 0; i < size; i++) {
    start[i] = 0.;
    if (i >= MPM_CHANGE_STRESS && i < MPM_CHANGE_F) continue; /* no step depends on it */
    unit[i] = 1.;
    PetscCall(EndAlong(slopes, NULL, unit, change, &met));
    unit[i] = 0.;
    for (PetscInt k = 0; k < size; k++) start[i] += end[k] * change[k];
  }
  PetscCall(PetscFree2(unit, change));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the start ---- */

/* True where the wanted stress is J times Cauchy's, with J of a deformation that carries it. */
static PetscBool IsScaled(const MpmStressPoint *point)
{
  return (PetscBool)(point->stress_measure == MPM_STRESS_KIRCHHOFF && !MpmPointIsSmallStrain(point));
}

/* A change of the start, in the rows of stress_inversion.h. */
typedef struct {
  PetscReal F[9], state[MPM_INITIAL_STATE], stress[MPM_SPACE_SYM], J;
} StartChange;

static PetscBool FindChange(const MpmStressPoint *point, const MpmInitial *initial, const PetscReal cauchy[],
                            const MpmInitialDirection *direction, StartChange *change)
{
  const PetscInt n = point->dim;
  PetscReal      rest[MPM_INITIAL_STATE], block[9], cofactor[9];

  MpmMaterialStateAtRest(point->material, n, rest);
  if (MpmInitialAlong(initial, rest, cauchy, direction, change->F, change->state, change->stress)) return PETSC_FALSE;
  MpmMatrixBlock(n, point->F_start, block);
  (void)MpmCofactors(n * n, block, cofactor);
  change->J = 0.;
  for (PetscInt k = 0; k < n * n; k++) change->J += cofactor[k] * change->F[k];
  return PETSC_TRUE;
}

/* Adds a multiple of one change to another. */
static void AddChange(const MpmStressPoint *point, PetscReal factor, const StartChange *from, StartChange *to)
{
  for (PetscInt k = 0; k < point->dim * point->dim; k++) to->F[k] += factor * from->F[k];
  for (PetscInt k = 0; k < point->material->state_size; k++) to->state[k] += factor * from->state[k];
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) to->stress[s] += factor * from->stress[s];
}

/*
  Of J times Cauchy's stress the latter is stress/J, and changes with J, which changes with it: dJ = a + b dJ, a along
  the parameters and b along the stress.
*/
PetscErrorCode MpmStressPointStartAlong(const MpmStressPoint *point, const PetscReal stress[MPM_SPACE_SYM],
                                        const PetscReal parameter[], PetscReal start[], MpmOutcome *outcome)
{
  const PetscBool     scaled = IsScaled(point);
  const PetscReal     J      = scaled ? MpmDeterminant(9, point->F_start) : 1.;
  PetscReal           cauchy[MPM_SPACE_SYM], less[MPM_SPACE_SYM], part = 0.;
  MpmInitialDirection by_parameter = {.parameter = parameter}, by_stress = {.stress = less};
  StartChange         change = {.J = 0.}, other = {.J = 0.};
  MpmInitial          initial;
  PetscBool           found;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  PetscCall(PetscArrayzero(start, MpmStressPointChangeSize(point)));
  PetscCall(MpmInitialCreate(point->material, point->dim, &initial));
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) {
    cauchy[s] = stress[s] / J;
    less[s]   = -cauchy[s] / J;
  }
  found = FindChange(point, &initial, cauchy, &by_parameter, &change);
  if (found && scaled) found = FindChange(point, &initial, cauchy, &by_stress, &other);
  if (!found) {
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                             "the stress at the start lies on the yield surface: its state has no derivative"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (scaled) {
    part = change.J / (1. - other.J);
    AddChange(point, part, &other, &change);
  }
  for (PetscInt i = 0; i < point->dim; i++)
    for (PetscInt j = 0; j < point->dim; j++) start[MPM_CHANGE_CARRIER + 3 * i + j] = change.F[i * point->dim + j];
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) start[MPM_CHANGE_STRESS + s] = J * change.stress[s] + part * cauchy[s];
  for (PetscInt k = 0; k < point->material->state_size; k++) start[MPM_CHANGE_HISTORY + k] = change.state[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}
