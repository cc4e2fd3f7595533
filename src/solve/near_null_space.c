/*
  Near null space of the Jacobian, for multigrid.
*/
#include "geometry/rotations.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "space/space.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "solve/solve.h"

/* Rigid body mode k at place x: translations, then rotations about the axes. */
static void RigidMode(PetscInt dim, PetscInt k, const PetscReal x[], PetscScalar mode[])
{
  for (PetscInt a = 0; a < dim; a++) mode[a] = a == k ? 1. : 0.;
  if (k < dim) return;
  {
    const PetscInt axis = MpmRotationAxis(dim, k - dim), p = (axis + 1) % 3, q = (axis + 2) % 3;

    mode[p] = -x[q];
    mode[q] = x[p];
  }
}

/* Rigid body modes of the displacement, or none. */
static PetscInt CountRigid(const MpmLayout *layout)
{
  const PetscBool rigid = (PetscBool)(layout->component[0].near_null == MPM_NEAR_NULL_RIGID);

  return rigid ? layout->dim + MpmRotationCount(layout->dim) : 0;
}

/* Modes that the physics names for its fields: rigid body modes of the displacement, then constants of components. */
static PetscInt CountModes(const MpmLayout *layout)
{
  PetscInt count = CountRigid(layout);

  for (PetscInt c = 0; c < layout->block; c++) count += layout->component[c].near_null == MPM_NEAR_NULL_CONSTANT;
  return count;
}

static void SetMode(const MpmLayout *layout, PetscInt k, const PetscReal x[], PetscScalar mode[])
{
  const PetscInt rigid = CountRigid(layout);
  PetscInt       at    = rigid;

  if (k < rigid) RigidMode(layout->dim, k, x, mode);
  for (PetscInt c = 0; c < layout->block; c++)
    if (layout->component[c].near_null == MPM_NEAR_NULL_CONSTANT && at++ == k) mode[c] = 1.;
}

/* Sets the mode at the terms' own nodes. */
static void SetOwnModes(const MpmSolver *solver, PetscInt k, PetscScalar values[])
{
  const MpmSpace *space = solver->disc->space;
  const PetscInt  dim = solver->disc->dim, bs = solver->disc->block, rigid = CountRigid(solver->disc->layout);
  PetscReal       along[3] = {0., 0., 0.}, turn[3] = {0., 0., 0.};

  for (PetscInt i = space->extra.begin; i < PetscMin(space->owned, space->extra.begin + space->extra.count); i++)
    for (PetscInt c = 0; c < bs; c++) values[i * bs + c] = 0.;
  if (k >= rigid) return;
  if (k < dim) along[k] = 1.;
  else turn[MpmRotationAxis(dim, k - dim)] = 1.;
  MpmTermsMode(solver->disc->terms, solver->disc->sum, solver->disc->grid->lower, along, turn, values);
}

/*
  Modes of little energy for multigrid. Constrained unknowns do not move, so the modes are zero there; the remaining
  values are made orthonormal.
*/
PetscErrorCode MpmSolverSetNearNullSpace(MpmSolver *solver)
{
  const MpmLayout *layout = solver->disc->layout;
  const PetscInt   dim = layout->dim, bs = layout->block, modes = CountModes(layout);
  MatNullSpace     space;
  Vec             *mode;
  PetscScalar     *dot;
  PetscInt         kept = 0;

  PetscFunctionBeginUser;
  if (!solver->jacobian.assembled || !modes) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetNearNullSpace(solver->jacobian.assembled, &space));
  if (solver->preset.factorises || space) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(modes, &mode, modes, &dot));
  for (PetscInt k = 0; k < modes; k++) {
    PetscScalar *values;
    PetscReal    norm;

    PetscCall(VecDuplicate(solver->x, &mode[kept]));
    PetscCall(VecZeroEntries(mode[kept]));
    PetscCall(VecGetArray(mode[kept], &values));
    for (PetscInt i = 0; i < solver->disc->space->owned; i++) {
      PetscReal x[MPM_MAX_DIM] = {0., 0., 0.};
      PetscInt  at[MPM_MAX_DIM];

      MpmSpaceAt(solver->disc->space, &solver->disc->space->node[i * dim], at);
      for (PetscInt a = 0; a < dim; a++) x[a] = solver->disc->grid->h[a] * MpmGridNodeXi(solver->disc->grid, at[a]);
      SetMode(layout, k, x, &values[i * bs]);
    }
    if (solver->disc->space->extra.count) SetOwnModes(solver, k, values);
    MpmFramesToUnknowns(solver->disc->constraints, bs, solver->disc->space->owned, values);
    MpmConstraintsZero(solver->disc->constraints, solver->disc->space->owned * bs, values);
    PetscCall(VecRestoreArray(mode[kept], &values));
    for (PetscInt pass = 0; pass < 2 && kept; pass++) {
      PetscCall(VecMDot(mode[kept], kept, mode, dot));
      for (PetscInt j = 0; j < kept; j++) dot[j] = -dot[j];
      PetscCall(VecMAXPY(mode[kept], kept, dot, mode));
    }
    PetscCall(VecNormalize(mode[kept], &norm));
    if (norm > PETSC_SQRT_MACHINE_EPSILON) kept++;
    else PetscCall(VecDestroy(&mode[kept]));
  }
  PetscCall(MatNullSpaceCreate(solver->disc->comm, PETSC_FALSE, kept, mode, &space));
  PetscCall(MatSetNearNullSpace(solver->jacobian.assembled, space));
  PetscCall(MatNullSpaceDestroy(&space));
  for (PetscInt k = 0; k < kept; k++) PetscCall(VecDestroy(&mode[k]));
  PetscCall(PetscFree2(mode, dot));
  PetscFunctionReturn(PETSC_SUCCESS);
}
