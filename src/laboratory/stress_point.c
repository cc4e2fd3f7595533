/*
  One step of a stress point.

  The deformation since the start is a stretch, symmetric, that follows from the strain: rotation is fixed, and the
  strain's components are prescribed or unknown. With U(e) the stretch of the strain e, and F_0 the initial deformation
  that carries the stress, the law is evaluated as in any run, with dF = U(e_{n+1}) U(e_n)^{-1}. The unknown strains
  make the stress equal to the prescribed one, in its measure:

    r = tau(dF) - goal  or  tau/J - goal ,   J = det(U F_0)

  by Newton's method with the law's own tangent: tau = P dF^T, where P is the flux of the solid's kernel and its
  derivative by dF that of the kernel's tangent form, and dF follows dU/de. For a small-strain law P = sigma F_n^T,
  without J.

  Rank 0 has all unknowns and all equations, so that the solver's monitors print once; the answer goes to all ranks.
*/
#include <petscsys.h>
#include <petscblaslapack.h>
#include "base/outcome.h"
#include "base/newton_reason.h"
#include "point/material.h"
#include "point/registry.h"
#include "point/stress_inversion.h"
#include "laboratory/stress_point.h"
#include "laboratory/stress_point_impl.h"

const char *const MpmStressMeasures[] = {"cauchy", "kirchhoff", NULL};

#define NEWTON_RTOL  1e-12
#define NEWTON_LIMIT 50
#define NOISE        16.   /* machine epsilons of stiffness and stress: the residual that rounding leaves */
#define SINGULAR     1e-12 /* of the law's stiffness: singular values below are rounding */
#define STALLED      1e-10 /* of the stress: a residual below this at which a line search stagnates is rounding too */
#define STRESS_MET   1e-8  /* relative: tolerance of the stress at the start */

/* Stress in its measure, six components; history unless `history` is NULL. PETSC_FALSE where the law has no answer. */
static PetscBool FindStress(const MpmStressPoint *point, const PetscReal F[9], PetscReal stress[MPM_SPACE_SYM],
                            PetscReal history[])
{
  MpmPointIncrement increment;
  MpmKernelPoint    at;
  PetscReal         flux[9], F_next[9], sym[MPM_SPACE_SYM] = {0.}, J;

  if (!MpmPointIncrementFind(point, F, &increment)) return PETSC_FALSE;
  at            = MpmPointKernel(point, &increment);
  at.end.state  = history;
  at.end.F      = F_next;
  at.end.stress = sym;
  if (point->kernel.residual(&at, increment.H, flux)) return PETSC_FALSE;
  J = point->stress_measure == MPM_STRESS_CAUCHY || MpmPointIsSmallStrain(point)
        ? 1.
        : MpmDeterminant(point->dim * point->dim, F_next);
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) {
    stress[s] = J * sym[s];
    if (PetscIsInfOrNanReal(stress[s])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* One column of the Jacobian: the stress' derivative by one strain, from P and its derivative by dF. */
static void Column(const MpmStressPoint *point, const MpmPointIncrement *increment, const PetscReal P[],
                   const PetscReal tangent[], const PetscReal change[], PetscReal column[9])
{
  const PetscInt  n     = point->dim;
  const PetscBool small = MpmPointIsSmallStrain(point);
  PetscReal       A[9], tau[9], cofactor[9], J, dJ = 0., dP[9] = {0.};

  for (PetscInt k = 0; k < n * n; k++)
    for (PetscInt l = 0; l < n * n; l++) dP[k] += tangent[k * n * n + l] * change[l];
  if (small) MpmMatrixInvert(n, increment->F_n, A);
  else PetscArraycpy(A, increment->dF, 9);
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt j = 0; j < n; j++) {
      tau[i * n + j] = column[i * n + j] = 0.;
      for (PetscInt c = 0; c < n; c++) {
        tau[i * n + j] += P[i * n + c] * A[j * n + c];
        column[i * n + j] += dP[i * n + c] * A[j * n + c] + (small ? 0. : P[i * n + c] * change[j * n + c]);
      }
    }
  }
  if (small || point->stress_measure == MPM_STRESS_KIRCHHOFF) return;
  J = MpmCofactors(n * n, increment->dF, cofactor);
  for (PetscInt k = 0; k < n * n; k++) dJ += cofactor[k] * change[k] / J;
  J *= MpmDeterminant(n * n, increment->F_n);
  for (PetscInt k = 0; k < n * n; k++) column[k] = (column[k] - dJ * tau[k]) / J;
}

/* ---- Newton ---- */

/* The strain that is prescribed, with the unknowns put in. */
static void TakeUnknowns(const MpmStressPoint *point, const PetscScalar x[], PetscReal strain[MPM_SPACE_SYM])
{
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) strain[s] = point->control.value[s];
  for (PetscInt k = 0; k < point->equations.count; k++) strain[point->equations.unknown[k]] = PetscRealPart(x[k]);
}

/* Rank 0: the residual of the unknowns; infinite where the law has no answer, and the line search backs off. */
static PetscErrorCode FillResidual(const MpmStressPoint *point, const PetscScalar unknown[], PetscScalar residual[])
{
  PetscReal strain[MPM_SPACE_SYM], F[9], stress[MPM_SPACE_SYM];
  PetscBool good;

  PetscFunctionBeginUser;
  TakeUnknowns(point, unknown, strain);
  PetscCall(MpmStretchFromStrain(point->strain_measure, strain, F));
  good = FindStress(point, F, stress, NULL);
  for (PetscInt k = 0; k < point->equations.count; k++)
    residual[k] =
      good ? stress[point->equations.unknown[k]] - point->control.value[point->equations.unknown[k]] : PETSC_INFINITY;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Every rank takes the array, also an empty one: the vector's norms are then computed anew. */
static PetscErrorCode FormFunction(SNES snes, Vec x, Vec f, void *ctx)
{
  const MpmStressPoint *point = (const MpmStressPoint *)ctx;
  const PetscScalar    *unknown;
  PetscScalar          *residual;

  PetscFunctionBeginUser;
  (void)snes;
  PetscCall(VecGetArrayRead(x, &unknown));
  PetscCall(VecGetArray(f, &residual));
  if (!point->rank) PetscCall(FillResidual(point, unknown, residual));
  PetscCall(VecRestoreArray(f, &residual));
  PetscCall(VecRestoreArrayRead(x, &unknown));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0: entries of the Jacobian at a strain; none where the law has no answer, as it had none for the residual. */
static PetscErrorCode FillJacobian(const MpmStressPoint *point, const PetscReal strain[MPM_SPACE_SYM], Mat matrix)
{
  const PetscInt    n = point->dim;
  PetscReal         F[9], P[9], tangent[81], block[9], change[9], column[9];
  MpmPointIncrement increment;
  MpmKernelPoint    at;

  PetscFunctionBeginUser;
  PetscCall(MpmStretchFromStrain(point->strain_measure, strain, F));
  if (!MpmPointIncrementFind(point, F, &increment)) PetscFunctionReturn(PETSC_SUCCESS);
  at = MpmPointKernel(point, &increment);
  if (point->kernel.tangent(&at, increment.H, P, tangent)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < point->equations.count; k++) {
    PetscReal derivative[9];

    PetscCall(MpmStretchDerivative(point->strain_measure, strain, point->equations.unknown[k], derivative));
    MpmMatrixBlock(n, derivative, block);
    MpmMatrixMultiply(n, block, increment.F_n_inverse, change);
    Column(point, &increment, P, tangent, change, column);
    for (PetscInt l = 0; l < point->equations.count; l++) {
      const PetscInt *pair = MpmSpacePairs[point->equations.unknown[l]];

      PetscCall(MatSetValue(matrix, l, k, column[pair[0] * n + pair[1]], INSERT_VALUES));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FormJacobian(SNES snes, Vec x, Mat matrix, Mat preconditioner, void *ctx)
{
  MpmStressPoint    *point = (MpmStressPoint *)ctx;
  const PetscScalar *unknown;
  PetscReal          strain[MPM_SPACE_SYM];

  PetscFunctionBeginUser;
  (void)snes;
  PetscCall(MatZeroEntries(preconditioner));
  if (!point->rank) {
    PetscCall(VecGetArrayRead(x, &unknown));
    TakeUnknowns(point, unknown, strain);
    PetscCall(VecRestoreArrayRead(x, &unknown));
    PetscCall(FillJacobian(point, strain, preconditioner));
  }
  PetscCall(MatAssemblyBegin(preconditioner, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(preconditioner, MAT_FINAL_ASSEMBLY));
  if (matrix != preconditioner) {
    PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* SNES' own tests, and the residual that rounding leaves. */
static PetscErrorCode TestConvergence(SNES snes, PetscInt it, PetscReal xnorm, PetscReal step, PetscReal fnorm,
                                      SNESConvergedReason *reason, void *ctx)
{
  const MpmStressPoint *point = (const MpmStressPoint *)ctx;

  PetscFunctionBeginUser;
  PetscCall(SNESConvergedDefault(snes, it, xnorm, step, fnorm, reason, NULL));
  if (*reason == SNES_CONVERGED_ITERATING && fnorm <= point->equations.noise) *reason = SNES_CONVERGED_FNORM_ABS;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ---- the linear solver: singular values, by rank 0 ----

  Where plastic flow goes along an edge or the apex of the yield surface, stress does not change with strains that only
  redistribute the flow: two equal lateral strains, say. The equations then leave the difference open, and the step is
  the shortest one that meets them. Components that no strain changes, as at an apex, go by the law's stiffness, back to
  where there is some.
*/
static PetscErrorCode Factor(PC pc)
{
  MpmStressPoint    *point;
  Mat                matrix;
  const PetscScalar *entries;
  PetscScalar        work[10 * MPM_SPACE_SYM];
  PetscBLASInt       n, room = 10 * MPM_SPACE_SYM, info = 0;
  int                failed;

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &point));
  PetscCall(PCGetOperators(pc, NULL, &matrix));
  if (!point->rank) {
    PetscScalar copy[MPM_SPACE_SYM * MPM_SPACE_SYM];

    PetscCall(PetscBLASIntCast(point->equations.count, &n));
    PetscCall(MatDenseGetArrayRead(matrix, &entries));
    PetscCall(PetscArraycpy(copy, entries, point->equations.count * point->equations.count));
    PetscCall(MatDenseRestoreArrayRead(matrix, &entries));
    PetscCallBLAS("LAPACKgesvd",
                  LAPACKgesvd_("A", "A", &n, &n, copy, &n, point->equations.singular, point->equations.left, &n,
                               point->equations.right, &n, work, &room, &info));
  }
  failed = info != 0;
  PetscCallMPI(MPI_Bcast(&failed, 1, MPI_INT, 0, point->comm));
  PetscCall(PCSetFailedReason(pc, failed ? PC_FACTOR_OTHER : PC_NOERROR));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* x = V S^+ U^T f, and the remainder of f over the law's stiffness; columns of U are side by side, those of V rows of
   `right`. */
static void ShortestStep(const MpmStressPoint *point, PetscScalar f[], PetscScalar x[])
{
  const PetscInt n = point->equations.count;

  for (PetscInt i = 0; i < n; i++) x[i] = 0.;
  for (PetscInt k = 0; k < n && point->equations.singular[k] > SINGULAR * point->stiffness; k++) {
    const PetscScalar *left = &point->equations.left[k * n];
    PetscScalar        part = 0.;

    for (PetscInt i = 0; i < n; i++) part += left[i] * f[i];
    for (PetscInt i = 0; i < n; i++) {
      f[i] -= part * left[i];
      x[i] += part / point->equations.singular[k] * point->equations.right[i * n + k];
    }
  }
  for (PetscInt i = 0; i < n; i++) x[i] += f[i] / point->stiffness;
}

static PetscErrorCode Substitute(PC pc, Vec f, Vec x)
{
  MpmStressPoint    *point;
  const PetscScalar *values;
  PetscScalar       *step, rest[MPM_SPACE_SYM];

  PetscFunctionBeginUser;
  PetscCall(PCShellGetContext(pc, &point));
  PetscCall(VecGetArrayRead(f, &values));
  PetscCall(VecGetArray(x, &step));
  for (PetscInt i = 0; i < point->equations.count && !point->rank; i++) rest[i] = values[i];
  if (!point->rank) ShortestStep(point, rest, step);
  PetscCall(VecRestoreArray(x, &step));
  PetscCall(VecRestoreArrayRead(f, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CreateSolver(MpmStressPoint *point)
{
  const PetscInt own = point->rank ? 0 : point->equations.count;
  SNESLineSearch search;
  KSP            ksp;
  PC             pc;

  PetscFunctionBeginUser;
  PetscCall(VecCreateMPI(point->comm, own, point->equations.count, &point->equations.x));
  PetscCall(VecDuplicate(point->equations.x, &point->equations.f));
  PetscCall(MatCreateDense(point->comm, own, own, point->equations.count, point->equations.count, NULL,
                           &point->equations.jacobian));
  PetscCall(SNESCreate(point->comm, &point->equations.snes));
  PetscCall(SNESSetType(point->equations.snes, SNESNEWTONLS));
  PetscCall(SNESSetTolerances(point->equations.snes, PETSC_DEFAULT, NEWTON_RTOL, 0., NEWTON_LIMIT, PETSC_DEFAULT));
  PetscCall(SNESSetDivergenceTolerance(point->equations.snes, 1e12));
  PetscCall(SNESSetFunction(point->equations.snes, point->equations.f, FormFunction, point));
  PetscCall(
    SNESSetJacobian(point->equations.snes, point->equations.jacobian, point->equations.jacobian, FormJacobian, point));
  PetscCall(SNESSetConvergenceTest(point->equations.snes, TestConvergence, point, NULL));
  PetscCall(SNESGetLineSearch(point->equations.snes, &search));
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHBT));
  PetscCall(SNESGetKSP(point->equations.snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCSHELL));
  PetscCall(PCShellSetName(pc, "singular values by LAPACK on rank 0"));
  PetscCall(PCShellSetContext(pc, point));
  PetscCall(PCShellSetSetUp(pc, Factor));
  PetscCall(PCShellSetApply(pc, Substitute));
  PetscCall(SNESSetFromOptions(point->equations.snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- life ---- */

PetscErrorCode MpmStressPointCreate(MPI_Comm comm, const MpmMaterial *material, PetscInt dim,
                                    const PetscBool prescribes_stress[MPM_SPACE_SYM], MpmStressPoint *point)
{
  MpmPhysics physics;
  PetscBool  found;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(point, sizeof(*point)));
  point->comm     = comm;
  point->material = material;
  point->dim      = dim;
  PetscCallMPI(MPI_Comm_rank(comm, &point->rank));
  PetscCall(MpmPhysicsCreate("solid", &physics, &found));
  PetscCheck(found, comm, PETSC_ERR_PLIB, "there is no physics solid");
  point->kernel = physics.kernels[dim];
  PetscCall(PetscCalloc1(material->state_size, &point->now.history)); /* one by one: steps swap them */
  PetscCall(PetscCalloc1(material->state_size, &point->next.history));
  for (PetscInt s = 0; prescribes_stress && s < MPM_SPACE_SYM; s++)
    if (prescribes_stress[s]) point->equations.unknown[point->equations.count++] = s;
  if (point->equations.count) PetscCall(CreateSolver(point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStressPointDestroy(MpmStressPoint *point)
{
  PetscFunctionBeginUser;
  PetscCall(SNESDestroy(&point->equations.snes));
  PetscCall(MatDestroy(&point->equations.jacobian));
  PetscCall(VecDestroy(&point->equations.x));
  PetscCall(VecDestroy(&point->equations.f));
  PetscCall(PetscFree(point->now.history));
  PetscCall(PetscFree(point->next.history));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  F and history with a stress. The stress of stress_inversion.c is Cauchy's: J of a law whose deformation carries the
  stress is found on the way.
*/
static int FindStart(const MpmStressPoint *point, const MpmInitial *initial, const PetscReal stress[MPM_SPACE_SYM],
                     PetscReal reached[MPM_SPACE_SYM], PetscReal F[9])
{
  const PetscBool kirchhoff =
    (PetscBool)(point->stress_measure == MPM_STRESS_KIRCHHOFF && !MpmPointIsSmallStrain(point));
  PetscReal rest[MPM_INITIAL_STATE], J = 1., J_before;
  PetscInt  turns = 0;

  MpmMaterialStateAtRest(point->material, point->dim, rest);
  do {
    J_before = J;
    for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) reached[s] = stress[s] / J;
    if (MpmInitialFind(initial, rest, reached, F, point->now.history, NULL) == 2) return 2;
    if (kirchhoff) J = MpmDeterminant(point->dim * point->dim, F);
  } while (PetscAbsReal(J - J_before) > PETSC_MACHINE_EPSILON && ++turns < 50);
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) reached[s] *= J;
  return 0;
}

PetscErrorCode MpmStressPointStart(MpmStressPoint *point, const PetscReal stress[MPM_SPACE_SYM], MpmOutcome *outcome)
{
  static const char *const names[] = {"xx", "yy", "zz", "xy", "yz", "xz"};
  const PetscInt           n       = point->dim;
  PetscReal                F[9], reached[MPM_SPACE_SYM] = {0.}, largest = 0.;
  MpmInitial               initial;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  for (PetscInt k = 0; k < 9; k++) point->now.F[k] = point->F_start[k] = k % 4 ? 0. : 1.;
  PetscCall(PetscArrayzero(point->now.strain, MPM_SPACE_SYM));
  PetscCall(MpmInitialCreate(point->material, n, &initial));
  if (FindStart(point, &initial, stress, reached, F)) {
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE, "material %s has no state with this stress",
                             point->material->name));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt j = 0; j < n; j++) point->F_start[3 * i + j] = F[i * n + j];
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) largest = PetscMax(largest, PetscAbsReal(stress[s]));
  largest = STRESS_MET * largest + 64. * PETSC_MACHINE_EPSILON * point->material->moduli.stiffness;
  for (PetscInt s = 0; s < MpmSymSize(n) && !outcome->code; s++) {
    if (PetscAbsReal(reached[s] - stress[s]) <= largest) continue;
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_INADMISSIBLE,
                             n == 2 && s == 2 ? "material %s in plane strain makes %s %g Pa of the other components"
                                              : "material %s cannot bear it: its %s would be %g Pa",
                             point->material->name, names[s], (double)reached[s]));
  }
  PetscCall(PetscArraycpy(point->now.stress, reached, MPM_SPACE_SYM));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a step ---- */

/* The unknown strains by Newton's method from those at the step's start, plus `time` times `rate`. */
static PetscErrorCode Solve(MpmStressPoint *point, PetscReal time, const PetscReal rate[MPM_SPACE_SYM],
                            MpmOutcome *outcome)
{
  PetscScalar         unknown[MPM_SPACE_SYM] = {0.}, *x;
  const PetscScalar  *found;
  PetscReal           largest = 0., norm;
  PetscInt            newton, linear;
  SNESConvergedReason reason;

  PetscFunctionBeginUser;
  for (PetscInt s = 0; s < MPM_SPACE_SYM; s++) largest = PetscMax(largest, PetscAbsReal(point->now.stress[s]));
  for (PetscInt k = 0; k < point->equations.count; k++)
    largest = PetscMax(largest, PetscAbsReal(point->control.value[point->equations.unknown[k]]));
  point->stiffness       = MpmMaterialStiffness(point->material, NULL, point->now.history, NULL);
  point->equations.noise = NOISE * PETSC_MACHINE_EPSILON * (largest + point->stiffness);
  PetscCall(VecGetArray(point->equations.x, &x));
  for (PetscInt k = 0; k < point->equations.count && !point->rank; k++)
    x[k] = point->now.strain[point->equations.unknown[k]] + time * rate[point->equations.unknown[k]];
  PetscCall(VecRestoreArray(point->equations.x, &x));
  PetscCall(SNESSolve(point->equations.snes, NULL, point->equations.x));
  PetscCall(SNESGetConvergedReason(point->equations.snes, &reason));
  PetscCall(SNESGetIterationNumber(point->equations.snes, &newton));
  PetscCall(SNESGetLinearSolveIterations(point->equations.snes, &linear));
  point->equations.newton += newton;
  point->equations.linear += linear;
  MpmOutcomeClear(outcome);
  if (reason == SNES_DIVERGED_LINE_SEARCH) {
    PetscCall(SNESGetFunctionNorm(point->equations.snes, &norm));
    if (norm <= STALLED * largest) reason = SNES_CONVERGED_FNORM_ABS;
  }
  if (reason <= 0) {
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_NO_SOLUTION, "%s", MpmNewtonReason(reason)));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecGetArrayRead(point->equations.x, &found));
  for (PetscInt k = 0; k < point->equations.count && !point->rank; k++) unknown[k] = found[k];
  PetscCall(VecRestoreArrayRead(point->equations.x, &found));
  PetscCallMPI(MPI_Bcast(unknown, MPM_SPACE_SYM, MPIU_SCALAR, 0, point->comm));
  TakeUnknowns(point, unknown, point->next.strain);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsUnknown(const MpmStressPoint *point, PetscInt component)
{
  for (PetscInt k = 0; k < point->equations.count; k++)
    if (point->equations.unknown[k] == component) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Unknown strains from three starts: those of the step's start; with the last step's rate, where extrapolated flow is
   too far for an elastic trial; with flow at constant volume, where the stress is at a corner, without stiffness. */
static PetscErrorCode SolveFromStarts(MpmStressPoint *point, PetscReal dt, MpmOutcome *outcome)
{
  PetscReal flow[MPM_SPACE_SYM] = {0.}, volume = 0.;
  PetscInt  normals = 0;

  PetscFunctionBeginUser;
  PetscCall(Solve(point, 0., point->rate, outcome));
  if (outcome->code) PetscCall(Solve(point, dt, point->rate, outcome));
  if (!outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < point->equations.count; k++) normals += point->equations.unknown[k] < MPM_MAX_DIM;
  for (PetscInt s = 0; s < MPM_MAX_DIM; s++)
    if (!IsUnknown(point, s)) volume += point->control.value[s] - point->now.strain[s];
  for (PetscInt s = 0; s < MPM_MAX_DIM && normals; s++) flow[s] = -volume / (PetscReal)normals;
  PetscCall(Solve(point, 1., flow, outcome));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The states of the step's end and its start. */
static void ChangePlaces(MpmStressPoint *point)
{
  const MpmPointState swap = point->now;

  point->now  = point->next;
  point->next = swap;
}

PetscErrorCode MpmStressPointStep(MpmStressPoint *point, const MpmPointControl *control, PetscReal dt,
                                  MpmOutcome *outcome)
{
  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  point->control          = *control;
  point->dt               = dt;
  point->equations.newton = point->equations.linear = 0;
  if (control->whole) {
    PetscCall(PetscArraycpy(point->next.F, control->F, 9));
    PetscCall(MpmStrainFromDeformation(point->strain_measure, point->next.F, point->next.strain));
  } else {
    if (!point->equations.count) PetscCall(PetscArraycpy(point->next.strain, control->value, MPM_SPACE_SYM));
    else PetscCall(SolveFromStarts(point, dt, outcome));
    if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(MpmStretchFromStrain(point->strain_measure, point->next.strain, point->next.F));
  }
  if (!FindStress(point, point->next.F, point->next.stress, point->next.history)) {
    PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_NO_ANSWER, "the law has no answer"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscArraycpy(point->rate_before, point->rate, MPM_SPACE_SYM));
  for (PetscInt k = 0; k < MPM_SPACE_SYM; k++)
    point->rate[k] = dt > 0. ? (point->next.strain[k] - point->now.strain[k]) / dt : 0.;
  ChangePlaces(point);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStressPointRollBack(MpmStressPoint *point)
{
  PetscFunctionBeginUser;
  ChangePlaces(point);
  PetscCall(PetscArraycpy(point->rate, point->rate_before, MPM_SPACE_SYM));
  PetscFunctionReturn(PETSC_SUCCESS);
}
