/*
  Modes without stiffness. A direct solver returns rounding errors in these, and the result depends on the number of
  ranks. Raising the Jacobian's diagonal a little makes them zero. Newton's residual, and with it the solution, is
  unchanged; convergence is as fast in all modes that are stiffer than the addition.

  Nodes that the corner of a single domain touches have more unknowns than the point has strains. A body at rest that is
  supported by contact alone may slide along frictionless faces, or hang above its support.
*/
#include "assembly/terms.h"
#include "volume/inertia.h"
#include "problem/discretization.h"
#include "solve/solve.h"

/*
  A displacement unknown is weak when its diagonal is below this fraction of a typical one, and with the node's last one
  its other fields; their diagonals are raised by that fraction.
*/
#define WEAK_NODE 1e-3
#define WEAK_LIFT 1e-11
/*
  All are raised by this fraction where contact may release a body: in Newton's first iterations, whose corrections are
  large and have rounding, too. Later ones reduce the modes that are softer than this.
*/
#define LOOSE_LIFT  1e-8
#define LOOSE_FIRST 3

/* True for a step at rest in which nearby contact may release a body. */
static PetscBool MayLetGo(const MpmSolver *solver)
{
  if (solver->disc->context.inertia->active || !MpmSolverHasContact(solver)) return PETSC_FALSE;
  return (PetscBool)((MpmTermsTraits(solver->disc->terms) & MPM_TERM_RELEASES) > 0);
}

PetscErrorCode MpmJacobianLift(MpmSolver *solver, Mat J)
{
  const PetscInt bs = solver->disc->block, dim = solver->disc->dim;
  PetscReal      all = 0.;
  PetscInt       it;
  PetscBool      weak = PETSC_FALSE;
  Vec            diagonal;
  PetscScalar   *d;

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(solver->snes, &it));
  if (MayLetGo(solver)) all = it < LOOSE_FIRST ? LOOSE_LIFT : WEAK_LIFT;
  PetscCall(VecDuplicate(solver->x, &diagonal));
  PetscCall(MatGetDiagonal(J, diagonal));
  PetscCall(VecGetArray(diagonal, &d));
  for (PetscInt k = 0; k < MpmNodesOwned(solver->disc) * bs; k++) {
    weak = (PetscBool)(k % bs < dim ? PetscAbsScalar(d[k]) < WEAK_NODE * solver->disc->matrix.diagonal : weak);
    d[k] *= 1. + (weak ? WEAK_LIFT : 0.) + (k % bs < dim ? all : 0.);
  }
  PetscCall(VecRestoreArray(diagonal, &d));
  PetscCall(MatDiagonalSet(J, diagonal, INSERT_VALUES));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}
