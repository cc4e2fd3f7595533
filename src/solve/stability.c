/*
  Stability of the equilibrium that a step has found.

  Where no material has a history, the tangent of a symmetric problem is the second derivative of its energy. Once it is
  no longer positive definite there is more than one equilibrium near by, and that found by Newton's method is unstable:
  the surface of rubber wrinkles, a column buckles (Hill 1958, doi:10.1016/0022-5096(58)90029-2; Biot 1963,
  doi:10.1007/BF03184980, for the surface of a half-space). Newton's method alone cannot detect this: a uniform block
  stays uniform. By Sylvester's law the factors of a direct solver have as many negative pivots as the tangent has
  negative eigenvalues, so that the test is free; CG meets a negative curvature. Only then is the tangent made once
  more, at the solution, and the mode found by inverse iteration, A v_{k+1} = D v_k with D = |diag A|, which finds the
  eigenvalue nearest to zero.

  A law with a history flows: at a limit load its tangent has lost definiteness by nature, and nothing is reported.
*/
#include "base/outcome.h"
#include "options/options.h"
#include "point/layout.h"
#include "point/material.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "problem/discretization.h"
#include "precondition/pc_band.h"
#include "solve/solve.h"

#define MODE_ITERATIONS  12
#define EIGENVALUE_NOISE 1e-6 /* of the diagonal */

/* In the order of MpmUnstable. */
static const char *const words[] = {"auto", "stop", "follow", NULL};

PetscErrorCode MpmStabilityRead(MpmSolver *solver, const MpmOptions *options)
{
  const MpmOptions block  = {options->comm, "mpm_stabilization_", options->record};
  PetscInt         choice = 0;

  PetscFunctionBeginUser;
  PetscCall(
    MpmOptionsWord(&block, "unstable",
                   "an elastic equilibrium that is not stable: stop with its place, or say it once and follow it; auto "
                   "stops where nu is above 0.45, since nothing but failed steps comes then, and follows elsewhere; "
                   "where a material has a history nobody looks",
                   words, MPM_OPTIONAL, &choice, NULL));
  solver->unstable.choice = (MpmUnstable)choice;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where definiteness means stability. */
static PetscBool Applies(const MpmSolver *solver)
{
  for (PetscInt m = 0; m < solver->disc->material.count; m++)
    if (solver->disc->sum->materials[m].state_size) return PETSC_FALSE;
  return (PetscBool)(solver->definite.symmetric && solver->disc->layout->traits.solid);
}

/* True where the run ends at a loss of stability. */
static PetscBool Stops(const MpmSolver *solver)
{
  PetscBool locks = PETSC_FALSE;

  for (PetscInt m = 0; m < solver->disc->material.count; m++)
    locks = (PetscBool)(locks || solver->disc->sum->materials[m].moduli.nu > MPM_NU_LOCKS);
  return (PetscBool)(solver->unstable.choice == MPM_UNSTABLE_STOP ||
                     (solver->unstable.choice == MPM_UNSTABLE_AUTO && locks));
}

PetscBool MpmStabilityWanted(const MpmSolver *solver)
{
  return (PetscBool)(Applies(solver) && !solver->unstable.told);
}

/* Negative eigenvalues of the matrix factorised last; 0 where the solver does not report them. */
static PetscErrorCode CountNegative(MpmSolver *solver, PetscInt *negative)
{
  KSP           ksp;
  PC            pc;
  PetscBool     band, cholesky;
  MatSolverType package;
  Mat           factor;

  PetscFunctionBeginUser;
  *negative = 0;
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(MpmBandIs(pc, &band));
  if (band) PetscCall(MpmBandGetWhole(pc, &pc)); /* NULL where the band was positive definite */
  if (!pc) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscObjectTypeCompare((PetscObject)pc, PCCHOLESKY, &cholesky));
  if (!cholesky) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCFactorGetMatSolverType(pc, &package));
  if (!package || strcmp(package, MATSOLVERMUMPS)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCFactorGetMatrix(pc, &factor));
  PetscCall(MatMumpsGetInfog(factor, 12, negative));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A start for the inverse iteration that does not depend on the ranks. */
static PetscErrorCode StartMode(MpmSolver *solver, Vec mode)
{
  const PetscInt  bs = solver->disc->block, dim = solver->disc->dim;
  PetscInt        owned;
  const PetscInt *nodes = MpmOwnedNodes(solver->disc, &owned);
  PetscScalar    *v;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayWrite(mode, &v));
  for (PetscInt k = 0; k < owned * bs; k++) {
    const PetscInt *node = &nodes[k / bs * dim];
    PetscReal       seed = 12.9898 * (PetscReal)node[0] + 78.233 * (PetscReal)node[1] + 3.7 * (PetscReal)(k % bs);

    if (dim > 2) seed += 37.719 * (PetscReal)node[2];
    v[k] = MpmConstraintsFree(solver->disc->constraints, k) ? PetscSinReal(seed) : 0.;
  }
  PetscCall(VecRestoreArrayWrite(mode, &v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The mode whose eigenvalue is nearest to zero, and that eigenvalue relative to the diagonal. */
static PetscErrorCode FindMode(MpmSolver *solver, Mat A, Vec mode, PetscReal *eigenvalue)
{
  Vec         diagonal, work;
  KSP         ksp;
  PetscReal   norm;
  PetscScalar top, bottom;

  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(VecDuplicate(mode, &diagonal));
  PetscCall(VecDuplicate(mode, &work));
  PetscCall(MatGetDiagonal(A, diagonal));
  PetscCall(VecAbs(diagonal));
  PetscCall(StartMode(solver, mode));
  for (PetscInt it = 0; it < MODE_ITERATIONS; it++) {
    PetscCall(VecPointwiseMult(work, diagonal, mode));
    PetscCall(KSPSolve(ksp, work, mode));
    PetscCall(VecNormalize(mode, &norm));
    if (!(norm > 0.)) break;
  }
  PetscCall(MatMult(A, mode, work));
  PetscCall(VecDot(work, mode, &top));
  PetscCall(VecPointwiseMult(work, diagonal, mode));
  PetscCall(VecDot(work, mode, &bottom));
  *eigenvalue = PetscRealPart(top) / PetscRealPart(bottom);
  PetscCall(VecDestroy(&diagonal));
  PetscCall(VecDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the mode is largest. */
static PetscErrorCode FindPlace(MpmSolver *solver, Vec mode, PetscReal place[])
{
  const PetscInt     bs = solver->disc->block, dim = solver->disc->dim;
  const PetscScalar *v;
  struct {
    double size;
    int    rank;
  } most = {.size = -1.};
  PetscInt owned;

  PetscFunctionBeginUser;
  (void)MpmOwnedNodes(solver->disc, &owned);
  PetscCallMPI(MPI_Comm_rank(solver->disc->comm, &most.rank));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) place[a] = 0.;
  PetscCall(VecGetArrayRead(mode, &v));
  for (PetscInt i = 0; i < owned; i++) {
    PetscReal size = 0.;

    for (PetscInt a = 0; a < dim; a++) size += PetscSqr(PetscRealPart(v[i * bs + a]));
    if (!(size > most.size)) continue;
    most.size = size;
    MpmNodePosition(solver->disc, i, place);
  }
  PetscCall(VecRestoreArrayRead(mode, &v));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE_INT, MPI_MAXLOC, solver->disc->comm));
  PetscCallMPI(MPI_Bcast(place, MPM_MAX_DIM, MPIU_REAL, most.rank, solver->disc->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Failure: the loss and its place. */
static PetscErrorCode Describe(MpmSolver *solver, const char *what, Vec mode, MpmOutcome *outcome)
{
  PetscReal place[MPM_MAX_DIM];
  char      text[96];

  PetscFunctionBeginUser;
  PetscCall(FindPlace(solver, mode, place));
  PetscCall(PetscSNPrintf(text, sizeof(text), solver->disc->dim > 2 ? "(%.4g, %.4g, %.4g)" : "(%.4g, %.4g)",
                          (double)place[0], (double)place[1], (double)place[2]));
  PetscCall(MpmOutcomeFail(outcome, MPM_OUTCOME_UNSTABLE,
                           "%s: the tangent has lost definiteness, in a mode that is largest at %s", what, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStabilityCheck(MpmSolver *solver, MpmOutcome *outcome)
{
  PetscInt  negative   = 0;
  PetscReal eigenvalue = 0.;
  PetscBool lost, cg;
  Mat       J;
  Vec       mode;
  KSP       ksp;

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  if (!MpmStabilityWanted(solver)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CountNegative(solver, &negative));
  if (negative <= 0 && !solver->definite.lost) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSolverLinearise(solver, solver->x, &J, &ksp));
  PetscCall(CountNegative(solver, &negative));
  PetscCall(VecDuplicate(solver->x, &mode));
  PetscCall(FindMode(solver, J, mode, &eigenvalue));
  /* an eigenvalue that is zero but for rounding, of a small-cut node, is none to speak of */
  lost = (PetscBool)(eigenvalue < -EIGENVALUE_NOISE || (negative > 0 && eigenvalue > EIGENVALUE_NOISE));
  if (lost) PetscCall(Describe(solver, "this equilibrium is not a stable one", mode, outcome));
  PetscCall(VecDestroy(&mode));
  cg = (PetscBool)(solver->definite.lost && !lost);
  if (cg) { /* only in an intermediate iterate: CG will find the next one */
    solver->definite.lost        = PETSC_FALSE;
    solver->definite.may_be_lost = PETSC_TRUE;
    PetscCall(MpmSolverRenew(solver));
  }
  if (!lost) PetscFunctionReturn(PETSC_SUCCESS);
  if (!Stops(solver)) {
    PetscCall(MpmMonitorNote(solver->monitor, "%s; followed", outcome->text));
    MpmOutcomeClear(outcome);
  }
  solver->unstable.told = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStabilityExplain(MpmSolver *solver, MpmOutcome *outcome)
{
  PetscInt  negative;
  PetscReal eigenvalue;
  Mat       J;
  Vec       mode;

  PetscFunctionBeginUser;
  if (!Applies(solver)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(CountNegative(solver, &negative));
  if (negative <= 0) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetJacobian(solver->snes, &J, NULL, NULL, NULL));
  PetscCall(VecDuplicate(solver->x, &mode));
  PetscCall(FindMode(solver, J, mode, &eigenvalue));
  PetscCall(Describe(solver, outcome->text, mode, outcome));
  PetscCall(VecDestroy(&mode));
  PetscFunctionReturn(PETSC_SUCCESS);
}
