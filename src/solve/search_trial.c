/*
  Trial steps of a line search.
*/
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "solve/line_search.h"

PetscErrorCode MpmRelaxBodies(MpmSolver *solver, Vec last, Vec x)
{
  const PetscScalar *before = NULL;
  PetscScalar       *values;

  PetscFunctionBeginUser;
  if (!(MpmTermsTraits(solver->disc->terms) & MPM_TERM_UNKNOWNS)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmGatherSolution(solver, x));
  if (last) PetscCall(VecGetArrayRead(last, &before));
  PetscCall(VecGetArray(x, &values));
  PetscCall(MpmTermsRelax(solver->disc->terms, solver->disc->sum, solver->disc->nodal.u, (PetscBool)(last != NULL),
                          before, values));
  PetscCall(VecRestoreArray(x, &values));
  if (last) PetscCall(VecRestoreArrayRead(last, &before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSearchTry(MpmSearch *search)
{
  PetscFunctionBeginUser;
  PetscCall(VecWAXPY(search->W, -search->lambda, search->Y, search->X));
  PetscCall(MpmRelaxBodies(search->solver, search->X, search->W));
  PetscCall(SNESComputeFunction(search->solver->snes, search->W, search->G));
  PetscCall(VecNorm(search->G, NORM_2, &search->norm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
