/*
  Start of Newton's method in a step whose supports move and that no earlier step predicts.

  Prescribed nodes that are displaced alone strain the cells beside them as nothing else in the step: the tangent
  there is that of another state. The start is the solution of the problem linearised at the step's beginning instead,

    K(0) u = -r(0) ,    u = g where prescribed,

  whose columns of prescribed unknowns are taken by a difference: K(0) g = (r(eps g) - r(0)) / eps.
*/
#include "options/database.h"
#include "point/layout.h"
#include "bc/bc.h"
#include "problem/discretization.h"
#include "problem/fields.h"
#include "solve/solve.h"

#define DIFFERENCE 1e-6 /* cells: largest motion in the difference; supports that move less need no such start */

static PetscErrorCode Start(MpmSolver *solver, Vec x, PetscReal most, PetscBool *made)
{
  const PetscReal    eps = DIFFERENCE * solver->disc->h[0] / most;
  Vec                at, start, moved, change;
  KSP                ksp;
  KSPConvergedReason reason;
  PetscInt           iterations;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(x, &at));
  PetscCall(VecDuplicate(x, &start));
  PetscCall(VecDuplicate(x, &moved));
  PetscCall(VecDuplicate(x, &change));
  PetscCall(SNESComputeFunction(solver->snes, x, start));
  PetscCall(MpmSolverSetReference(solver, start));
  PetscCall(VecAXPBY(at, eps, 0., x));
  PetscCall(SNESComputeFunction(solver->snes, at, moved));
  PetscCall(VecZeroEntries(at));
  PetscCall(SNESComputeFunction(solver->snes, at, start));
  PetscCall(SNESComputeJacobian(solver->snes, at,
                                solver->jacobian.shell ? solver->jacobian.shell : solver->jacobian.assembled,
                                solver->jacobian.assembled ? solver->jacobian.assembled : solver->jacobian.shell));
  /* -(r(0) + K(0) g); rows of prescribed unknowns stay as they are */
  PetscCall(VecAXPY(moved, -1., start));
  PetscCall(VecAXPBYPCZ(at, -1., -1. / eps, 0., start, moved));
  {
    PetscScalar *values;

    PetscCall(VecGetArray(at, &values));
    MpmConstraintsZero(solver->disc->constraints, MpmNodesOwned(solver->disc) * solver->disc->block, values);
    PetscCall(VecRestoreArray(at, &values));
  }
  PetscCall(SNESGetKSP(solver->snes, &ksp));
  PetscCall(KSPSetOperators(ksp, solver->jacobian.shell ? solver->jacobian.shell : solver->jacobian.assembled,
                            solver->jacobian.assembled ? solver->jacobian.assembled : solver->jacobian.shell));
  PetscCall(KSPSolve(ksp, at, change));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCall(KSPGetIterationNumber(ksp, &iterations));
  *made = (PetscBool)(reason > 0);
  if (*made) PetscCall(VecAXPY(x, 1., change));
  else PetscCall(MpmSolverRenew(solver));
  solver->iterations.newton_total++;
  solver->iterations.linear_total += iterations;
  PetscCall(VecDestroy(&at));
  PetscCall(VecDestroy(&start));
  PetscCall(VecDestroy(&moved));
  PetscCall(VecDestroy(&change));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverStartLinear(MpmSolver *solver, Vec x, PetscBool *made)
{
  PetscReal     *seconds = solver->monitor->seconds, before, most;
  PetscLogDouble since, now;

  PetscFunctionBeginUser;
  *made = PETSC_FALSE;
  if (!MpmFieldsDoWork(solver->disc->layout) || !solver->disc->layout->motion) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecNorm(x, NORM_INFINITY, &most));
  if (!(most > DIFFERENCE * solver->disc->h[0])) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&since));
  before = seconds[MPM_TIME_RESIDUAL] + seconds[MPM_TIME_JACOBIAN];
  MpmDatabaseCall(solver->database, Start(solver, x, most, made));
  PetscCall(PetscTime(&now));
  seconds[MPM_TIME_SOLVE] += now - since - (seconds[MPM_TIME_RESIDUAL] + seconds[MPM_TIME_JACOBIAN] - before);
  PetscFunctionReturn(PETSC_SUCCESS);
}
