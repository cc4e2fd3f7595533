/*
  Evaluations of Newton's method: nodal values, residual, trial and potential at an iterate, kept in the problem.
*/
#include "space/sum.h"
#include "assembly/terms.h"
#include "points/point_terms.h"
#include "problem/discretization.h"
#include "problem/potential.h"
#include "solve/iterate.h"
#include "solve/line_search.h"

PetscErrorCode MpmGatherSolution(MpmSolver *solver, Vec x)
{
  PetscFunctionBeginUser;
  PetscCall(MpmEvaluationNodes(solver->disc, x, solver->disc->nodal.u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSumResidual(MpmSolver *solver, Vec x, MpmMode mode, PetscInt *failed)
{
  MpmDiscretization *disc  = solver->disc;
  const MpmTrial    *trial = mode == MPM_MODE_START ? NULL : disc->trial;
  MpmSum             sum   = *disc->sum;

  PetscFunctionBeginUser;
  sum.mode           = mode;
  disc->trial->of.id = 0;
  PetscCall(MpmEvaluateForces(disc, &sum, disc->nodal.u, trial, disc->nodal.residual, failed));
  if (x && trial) PetscCall(MpmVersionGet(x, &disc->trial->of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSumPotential(MpmSolver *solver, Vec x, PetscReal *value, PetscReal *size, PetscInt *failed)
{
  MpmDiscretization *disc = solver->disc;
  MpmVersion         at;

  PetscFunctionBeginUser;
  *failed = 0;
  PetscCall(MpmGatherSolution(solver, x));
  PetscCall(MpmVersionGet(x, &at));
  if (!MpmVersionIsSame(&at, &disc->trial->of)) {
    disc->trial->of.id = 0; /* the residual stays that of other unknowns */
    PetscCall(MpmPointsUpdate(disc->sum, disc->nodal.u, disc->trial, failed));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, failed, 1, MPIU_INT, MPI_SUM, disc->comm));
  if (*failed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPotentialEvaluate(disc, disc->sum, disc->nodal.u, disc->trial, value, size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmSolverHasContact(const MpmSolver *solver)
{
  return MpmTermsNear(solver->disc->terms, MPM_TERM_CONTACT);
}
