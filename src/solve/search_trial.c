/*
  Trial steps of a line search.
*/
#include "point/layout.h"
#include "bc/bc.h"
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

/* The trial within the bounds of its unknowns; `residual` NULL: stopped there, else with the forces of bounds. */
static PetscErrorCode KeepBounds(MpmSearch *search, Vec residual, PetscBool *changed)
{
  const MpmDiscretization *disc = search->solver->disc;
  const PetscScalar       *last, *force = NULL;
  PetscScalar             *values;

  PetscFunctionBeginUser;
  *changed = PETSC_FALSE;
  PetscCall(VecGetArrayRead(search->X, &last));
  if (residual) PetscCall(VecGetArrayRead(residual, &force));
  PetscCall(VecGetArray(search->W, &values));
  MpmTermsBound(disc->terms, disc->sum, disc->constraints, last, force, values, changed);
  PetscCall(VecRestoreArray(search->W, &values));
  if (residual) PetscCall(VecRestoreArrayRead(residual, &force));
  PetscCall(VecRestoreArrayRead(search->X, &last));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, changed, 1, MPIU_BOOL, MPI_LOR, disc->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSearchTry(MpmSearch *search)
{
  PetscBool bound = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(VecWAXPY(search->W, -search->lambda, search->Y, search->X));
  PetscCall(MpmRelaxBodies(search->solver, search->X, search->W));
  if (search->solver->disc->layout->traits.alternate) PetscCall(KeepBounds(search, NULL, &bound));
  PetscCall(SNESComputeFunction(search->solver->snes, search->W, search->G));
  if (bound) {
    PetscCall(KeepBounds(search, search->G, &bound));
    PetscCall(SNESComputeFunction(search->solver->snes, search->W, search->G));
  }
  PetscCall(VecNorm(search->G, NORM_2, &search->norm));
  PetscFunctionReturn(PETSC_SUCCESS);
}
