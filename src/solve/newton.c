/*
  Residual and Jacobian as SNES calls them in Newton's method.
*/
#include "point/layout.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "points/jacobian_coloring.h"
#include "problem/discretization.h"
#include "problem/fields.h"
#include "solve/iterate.h"
#include "solve/line_search.h"

/* Sums of the residual and of the Jacobian, in one pass. */
static PetscErrorCode SumBoth(MpmSolver *solver, Vec x, PetscInt *failed)
{
  PetscFunctionBeginUser;
  PetscCall(MpmVersionGet(x, &solver->cache.summed));
  for (PetscInt k = 0; k < solver->disc->space->local * solver->disc->block; k++)
    solver->disc->nodal.residual[k] = -solver->disc->nodal.force[k];
  solver->cache.assembled    = PETSC_FALSE;
  solver->disc->trial->of.id = 0;
  PetscCall(MpmSolverMindContact(solver, PETSC_FALSE));
  PetscCall(MpmPatternBegin(solver->disc->matrix.pattern, solver->disc->space, solver->disc->constraints,
                            solver->jacobian.assembled));
  PetscCall(MpmTermsTangent(solver->disc->terms, solver->disc->sum, solver->disc->nodal.u, solver->disc->matrix.pattern,
                            solver->disc->nodal.residual, failed));
  MpmConstraintsGather(solver->disc->constraints, solver->disc->space, solver->disc->nodal.residual);
  PetscCall(MpmSpaceAddToOwners(solver->disc->space, solver->disc->block, solver->disc->nodal.residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Where a point has no answer f becomes infinite and SNES backs off. The tangents' kernel gives the fluxes too: where a
  Jacobian at the same place is sure to follow, its sums are made in the same pass.
*/
PetscErrorCode MpmNewtonResidual(MpmSolver *solver, Vec x, MpmMode mode, Vec f)
{
  const PetscBool both =
    (PetscBool)(solver->cache.ahead && solver->jacobian.form == MPM_JACOBIAN_LOCAL && mode == MPM_MODE_END);
  const MpmTimer timer = both ? MPM_TIME_JACOBIAN : MPM_TIME_RESIDUAL;
  PetscScalar   *values;
  PetscLogDouble since;
  PetscInt       failed;

  PetscFunctionBeginUser;
  PetscCall(MpmGatherSolution(solver, x));
  solver->cache.ahead = PETSC_FALSE;
  PetscCall(MpmMonitorBegin(solver->monitor, timer, &since));
  if (both) PetscCall(SumBoth(solver, x, &failed));
  else PetscCall(MpmSumResidual(solver, x, mode, &failed));
  PetscCall(MpmEvaluationEquations(solver->disc, x, solver->disc->nodal.residual, f));
  /* a rank may own no unknown of its failing points: the flag travels apart */
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_MAX, solver->disc->comm));
  PetscCall(VecGetArray(f, &values));
  if (failed && solver->disc->space->owned) values[0] = PETSC_INFINITY;
  PetscCall(VecRestoreArray(f, &values));
  PetscCall(MpmMonitorEnd(solver->monitor, timer, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FormFunction(SNES snes, Vec x, Vec f, void *ctx)
{
  PetscFunctionBeginUser;
  (void)snes;
  PetscCall(MpmNewtonResidual((MpmSolver *)ctx, x, MPM_MODE_END, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sums over points of the Jacobian, in the chosen form. */
static PetscErrorCode SumJacobian(MpmSolver *solver, Vec x, Mat P)
{
  PetscInt failed;

  PetscFunctionBeginUser;
  PetscCall(MpmGatherSolution(solver, x));
  PetscCall(MpmSolverMindContact(solver, PETSC_FALSE));
  PetscCall(MpmPatternBegin(solver->disc->matrix.pattern, solver->disc->space, solver->disc->constraints, P));
  if (solver->jacobian.form == MPM_JACOBIAN_LOCAL || solver->jacobian.form == MPM_JACOBIAN_MATFREE)
    PetscCall(MpmTermsTangent(solver->disc->terms, solver->disc->sum, solver->disc->nodal.u,
                              solver->disc->matrix.pattern, NULL, &failed));
  else
    PetscCall(MpmJacobianColoring(solver->disc->terms, solver->disc->sum, solver->jacobian.form, solver->disc->nodal.u,
                                  solver->disc->matrix.pattern, &failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AssembleJacobian(MpmSolver *solver, Vec x, Mat P)
{
  MpmVersion place;

  PetscFunctionBeginUser;
  PetscCall(MpmVersionGet(x, &place));
  if (!MpmVersionIsSame(&place, &solver->cache.summed)) PetscCall(SumJacobian(solver, x, P));
  solver->cache.summed.id = 0;
  solver->cache.assembled = PETSC_TRUE;
  PetscCall(MpmPatternEnd(solver->disc->matrix.pattern, solver->disc->space, P));
  if (solver->preset.factorises) PetscCall(MpmJacobianLift(solver, P));
  if (solver->definite.symmetric || solver->at_rest.count)
    PetscCall(MatSetOption(P, MAT_SYMMETRIC, (PetscBool)(solver->definite.symmetric || solver->at_rest.now)));
  PetscCall(MpmFieldsplitUpdate(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Decides whether to reuse the Jacobian: modified Newton reduces the residual by the last factor again, since that
  factor is the distance of the last iterate; a new Jacobian squares it. The old one is kept for one iteration where
  that brings the residual to its tolerance with some margin.
*/
static PetscBool LastWillDo(const MpmSolver *solver, PetscInt it, PetscReal fnorm, PetscReal target)
{
  if (solver->disc->layout->traits.alternate) return PETSC_FALSE;
  if (!solver->cache.solving || !solver->cache.reuse.allowed || !it || solver->cache.reuse.last) return PETSC_FALSE;
  return (PetscBool)(fnorm * fnorm <= 0.3 * target * solver->cache.fnorm_last);
}

static PetscErrorCode FormJacobian(SNES snes, Vec x, Mat J, Mat P, void *ctx)
{
  MpmSolver     *solver = (MpmSolver *)ctx;
  PetscLogDouble since;
  PetscReal      fnorm = 0., rtol;
  PetscInt       it;
  PetscBool      last;

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(snes, &it));
  PetscCall(SNESGetFunctionNorm(snes, &fnorm));
  PetscCall(SNESGetTolerances(snes, NULL, &rtol, NULL, NULL, NULL));
  if (MpmFieldsHaveNorms(solver->disc->layout)) {
    fnorm = solver->cache.fields.excess;
    last  = LastWillDo(solver, it, fnorm, 1.);
  } else last = LastWillDo(solver, it, fnorm, rtol * solver->cache.reference);
  solver->cache.fnorm_last = fnorm;
  solver->cache.reuse.last = (PetscBool)(last && solver->cache.assembled);
  if (solver->cache.reuse.last) PetscFunctionReturn(PETSC_SUCCESS);
  if (!last) solver->cache.reuse.needed++;
  if (solver->disc->layout->traits.alternate && solver->cache.solving) MpmAlternationBegin(solver, it);
  PetscCall(MpmMonitorBegin(solver->monitor, MPM_TIME_JACOBIAN, &since));
  if (solver->jacobian.assembled) PetscCall(AssembleJacobian(solver, x, P));
  if (solver->jacobian.shell) PetscCall(MpmMatfreeSetState(J, x));
  PetscCall(MpmMonitorEnd(solver->monitor, MPM_TIME_JACOBIAN, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* More where each one leads downhill: a step that is far too long gets there, which cuts would not do sooner. */
#define ITERATIONS          25
#define ITERATIONS_DOWNHILL 50
#define ITERATIONS_IN_TURN  5000 /* a crack that runs */

PetscErrorCode MpmNewtonAttach(MpmSolver *solver)
{
  SNESLineSearch search;

  PetscFunctionBeginUser;
  PetscCall(SNESSetType(solver->snes, SNESNEWTONLS));
  PetscCall(SNESSetTolerances(solver->snes, PETSC_DEFAULT, 1e-8, 0.,
                              solver->disc->layout->traits.alternate ? ITERATIONS_IN_TURN
                              : solver->cache.minimisation.on        ? ITERATIONS_DOWNHILL
                                                                     : ITERATIONS,
                              PETSC_DEFAULT));
  PetscCall(SNESSetDivergenceTolerance(solver->snes, 1e12));
  PetscCall(SNESGetLineSearch(solver->snes, &search));
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  PetscCall(MpmLineSearchShellSet(search, MpmLineSearch, solver));
  PetscCall(SNESSetConvergenceTest(solver->snes, MpmNewtonConverged, solver, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmNewtonSetMats(MpmSolver *solver)
{
  PetscFunctionBeginUser;
  PetscCall(SNESSetFunction(solver->snes, solver->f, FormFunction, solver));
  if (solver->cache.minimisation.on) PetscCall(SNESSetObjective(solver->snes, MpmObjective, solver));
  PetscCall(SNESSetJacobian(solver->snes, solver->jacobian.shell ? solver->jacobian.shell : solver->jacobian.assembled,
                            solver->jacobian.assembled ? solver->jacobian.assembled : solver->jacobian.shell,
                            FormJacobian, solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}
