/*
  Evaluations of Newton's method: nodal values, residual, trial and potential at an iterate, kept in the problem.
*/
#include "space/sum.h"
#include "assembly/terms.h"
#include "points/point_terms.h"
#include "problem/discretization.h"
#include "problem/potential.h"
#include "solve/line_search.h"

PetscErrorCode MpmGatherSolution(MpmSolver *solver, Vec x)
{
  PetscFunctionBeginUser;
  PetscCall(MpmEvaluationNodes(solver->disc, x, solver->disc->nodal.u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSumResidual(MpmSolver *solver, PetscInt *failed)
{
  MpmDiscretization *disc = solver->disc;

  PetscFunctionBeginUser;
  disc->sum->trial = disc->sum->rest ? NULL : disc->trial;
  PetscCall(MpmEvaluateForces(disc, disc->sum, disc->nodal.u, disc->nodal.residual, failed));
  disc->trial->made = (PetscBool)(disc->sum->trial != NULL);
  if (disc->trial->made) PetscCall(PetscArraycpy(disc->trial->u, disc->nodal.u, MpmNodesLocal(disc) * disc->block));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The trial becomes that of disc->nodal.u, without the residual, which it no longer goes with; unless it is there. */
static PetscErrorCode FindTrial(MpmDiscretization *disc, PetscInt *failed)
{
  PetscBool same = disc->trial->made;

  PetscFunctionBeginUser;
  *failed = 0;
  if (same) PetscCall(PetscArraycmp(disc->trial->u, disc->nodal.u, MpmNodesLocal(disc) * disc->block, &same));
  if (same) PetscFunctionReturn(PETSC_SUCCESS);
  disc->trial->made = PETSC_FALSE;
  disc->sum->trial  = disc->trial;
  PetscCall(MpmPointsUpdate(disc->sum, disc->nodal.u, failed));
  disc->sum->trial = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSumPotential(MpmSolver *solver, Vec x, PetscReal *value, PetscReal *size, PetscInt *failed)
{
  MpmDiscretization *disc = solver->disc;

  PetscFunctionBeginUser;
  PetscCall(MpmGatherSolution(solver, x));
  PetscCall(FindTrial(disc, failed));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, failed, 1, MPIU_INT, MPI_SUM, disc->comm));
  if (*failed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPotentialEvaluate(disc, disc->sum, disc->nodal.u, disc->trial, value, size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmSolverHasContact(const MpmSolver *solver)
{
  return MpmTermsNear(solver->disc->terms, MPM_TERM_CONTACT);
}
