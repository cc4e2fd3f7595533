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
  PetscCall(PetscArraycpy(solver->disc->nodal.u, values, solver->disc->space->owned * solver->disc->block));
  PetscCall(VecRestoreArrayRead(x, &values));
  MpmUnitsTimes(solver->disc->constraints, solver->disc->space->owned * solver->disc->block, solver->disc->nodal.u);
  PetscCall(MpmSpaceToGhosts(solver->disc->space, solver->disc->block, solver->disc->nodal.u));
  MpmFramesToAxes(solver->disc->constraints, solver->disc->block, solver->disc->space->local, solver->disc->nodal.u);
  MpmConstraintsExtend(solver->disc->constraints, solver->disc->space, solver->disc->nodal.u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSumResidual(MpmSolver *solver, PetscInt *failed)
{
  const PetscInt count = solver->disc->space->local * solver->disc->block;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) solver->disc->nodal.residual[k] = -solver->disc->nodal.force[k];
  solver->disc->sum->trial = solver->disc->sum->rest ? NULL : solver->disc->trial;
  PetscCall(MpmTermsResidual(solver->disc->terms, solver->disc->sum, solver->disc->nodal.u,
                             solver->disc->nodal.residual, failed));
  MpmConstraintsGather(solver->disc->constraints, solver->disc->space, solver->disc->nodal.residual);
  PetscCall(MpmSpaceAddToOwners(solver->disc->space, solver->disc->block, solver->disc->nodal.residual));
  solver->disc->trial->made   = (PetscBool)(solver->disc->sum->trial != NULL);
  solver->disc->trial->framed = PETSC_FALSE;
  if (solver->disc->trial->made) PetscCall(PetscArraycpy(solver->disc->trial->u, solver->disc->nodal.u, count));
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
