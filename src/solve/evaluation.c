/*
  Evaluations at a solution vector: nodal values from it, the residual's sums over terms, and the place of a vector's
  values.
*/
#include <petsc/private/petscimpl.h> /* PetscObjectStateGet() */
#include "point/layout.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "solve/line_search.h"

/* Brings the solution vector to the local nodes, ghosts included, as components along the axes. */
PetscErrorCode MpmGatherSolution(MpmSolver *solver, Vec x)
{
  const PetscScalar *values;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &values));
  PetscCall(PetscArraycpy(solver->disc->u, values, solver->disc->space->owned * solver->disc->block));
  PetscCall(VecRestoreArrayRead(x, &values));
  MpmUnitsTimes(solver->disc->constraints, solver->disc->space->owned * solver->disc->block, solver->disc->u);
  PetscCall(MpmSpaceToGhosts(solver->disc->space, solver->disc->block, solver->disc->u));
  MpmFramesToAxes(solver->disc->constraints, solver->disc->block, solver->disc->space->local, solver->disc->u);
  MpmConstraintsExtend(solver->disc->constraints, solver->disc->space, solver->disc->u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSumResidual(MpmSolver *solver, PetscInt *failed)
{
  const PetscInt count = solver->disc->space->local * solver->disc->block;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) solver->disc->residual[k] = -solver->disc->force[k];
  solver->disc->sum->trial = solver->disc->sum->rest ? NULL : solver->disc->trial;
  PetscCall(MpmTermsResidual(solver->disc->terms, solver->disc->sum, solver->disc->u, solver->disc->residual, failed));
  MpmConstraintsGather(solver->disc->constraints, solver->disc->space, solver->disc->residual);
  PetscCall(MpmSpaceAddToOwners(solver->disc->space, solver->disc->block, solver->disc->residual));
  solver->disc->trial->made   = (PetscBool)(solver->disc->sum->trial != NULL);
  solver->disc->trial->framed = PETSC_FALSE;
  if (solver->disc->trial->made) PetscCall(PetscArraycpy(solver->disc->trial->u, solver->disc->u, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPlaceGet(Vec x, MpmPlace *place)
{
  PetscFunctionBeginUser;
  PetscCall(PetscObjectGetId((PetscObject)x, &place->id));
  PetscCall(PetscObjectStateGet((PetscObject)x, &place->state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmPlaceIsSame(const MpmPlace *a, const MpmPlace *b)
{
  return (PetscBool)(a->id == b->id && a->state == b->state);
}

PetscBool MpmSolverHasContact(const MpmSolver *solver)
{
  return MpmTermsNear(solver->disc->terms, MPM_TERM_CONTACT);
}
