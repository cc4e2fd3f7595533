/*
  The Jacobian as a PETSc shell: products from the points, and the diagonal and point-block diagonal that smoothers and
  simple preconditioners ask for. Constrained unknowns keep the row `diagonal` times identity.
*/
#include "bc/bc.h"
#include "assembly/terms.h"
#include "points/action.h"
#include "problem/discretization.h"
#include "solve/solve.h"

typedef struct {
  MpmSolver *solver;
  MpmAction  action;
  PetscReal *du, *y;  /* local nodes */
  PetscReal *inverse; /* of the diagonal blocks of owned nodes, column-major for PETSc */
} Matfree;

/* Local values of a vector, as components along the axes; constrained unknowns are zero. */
static PetscErrorCode Gather(const Matfree *free, Vec x, PetscReal local[])
{
  const MpmSpace    *space = free->solver->disc->space;
  const PetscInt     bs    = free->solver->disc->block;
  const PetscScalar *values;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &values));
  PetscCall(PetscArraycpy(local, values, space->owned * bs));
  MpmConstraintsZero(free->solver->disc->constraints, space->owned * bs, local);
  MpmUnitsTimes(free->solver->disc->constraints, space->owned * bs, local);
  PetscCall(VecRestoreArrayRead(x, &values));
  PetscCall(MpmSpaceToGhosts(space, bs, local));
  MpmFramesToAxes(free->solver->disc->constraints, bs, space->local, local);
  MpmConstraintsExtend(free->solver->disc->constraints, space, local);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* y = J x, or J^T x. */
static PetscErrorCode Multiply(Mat J, PetscBool transposed, Vec x, Vec y)
{
  Matfree           *free;
  const PetscScalar *from;
  PetscScalar       *to;
  PetscInt           failed;

  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(J, &free));
  const MpmSolver *solver = free->solver;
  const PetscInt   bs     = solver->disc->block;

  PetscCall(Gather(free, x, free->du));
  PetscCall(PetscArrayzero(free->y, solver->disc->space->local * bs));
  PetscCall((transposed ? MpmActionTranspose : MpmActionApply)(&free->action, free->du, free->y, &failed));
  MpmConstraintsGather(solver->disc->constraints, solver->disc->space, free->y);
  PetscCall(MpmSpaceAddToOwners(solver->disc->space, bs, free->y));
  MpmFramesToUnknowns(solver->disc->constraints, bs, solver->disc->space->owned, free->y);
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArrayWrite(y, &to));
  PetscCall(PetscArraycpy(to, free->y, solver->disc->space->owned * bs));
  MpmUnitsTimes(solver->disc->constraints, solver->disc->space->owned * bs, to);
  MpmConstraintsMultiply(solver->disc->constraints, solver->disc->space->owned * bs, from, to);
  PetscCall(VecRestoreArrayWrite(y, &to));
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MatMult_Matfree(Mat J, Vec x, Vec y)
{
  return Multiply(J, PETSC_FALSE, x, y);
}

static PetscErrorCode MatMultTranspose_Matfree(Mat J, Vec x, Vec y)
{
  return Multiply(J, PETSC_TRUE, x, y);
}

/*
  Contributions of followers' diagonal blocks to their masters', e^2 K_ss. The coupling of a follower with others is
  left out, since it would need all entries of the matrix.
*/
static void ExtendBlocks(const MpmConstraints *constraints, const MpmSpace *space, PetscReal blocks[])
{
  const MpmExtension *extension = &space->extension;
  const PetscInt      bs        = constraints->block;

  for (PetscInt f = 0; f < extension->count; f++) {
    const PetscInt   s    = extension->follower[f];
    const PetscReal *from = &blocks[s * bs * bs];

    for (PetscInt k = extension->offset[f]; k < extension->offset[f + 1]; k++) {
      PetscReal *to = &blocks[extension->master[k] * bs * bs];

      for (PetscInt e = 0; e < bs * bs; e++)
        if (constraints->condition[s * bs + e / bs] == MPM_FOLLOWS &&
            constraints->condition[s * bs + e % bs] == MPM_FOLLOWS)
          to[e] += PetscSqr(extension->weight[k]) * from[e];
    }
  }
}

/* Diagonal blocks of the owned nodes, row-major; `blocks` has room for the local nodes. */
static PetscErrorCode Blocks(const Matfree *free, PetscReal blocks[])
{
  const MpmSolver *solver = free->solver;
  const PetscInt   bs     = solver->disc->block;
  PetscInt         failed;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(blocks, solver->disc->space->local * bs * bs));
  PetscCall(MpmActionDiagonal(&free->action, blocks, &failed));
  ExtendBlocks(solver->disc->constraints, solver->disc->space, blocks);
  PetscCall(MpmSpaceAddToOwners(solver->disc->space, bs * bs, blocks));
  MpmFramesRotateBlocks(solver->disc->constraints, bs, solver->disc->space->owned, blocks);
  for (PetscInt i = 0; i < solver->disc->space->owned; i++)
    MpmUnitsTimesRows(solver->disc->constraints, 1, &blocks[i * bs * bs]);
  MpmConstraintsBlocks(solver->disc->constraints, solver->disc->space->owned, blocks);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MatGetDiagonal_Matfree(Mat J, Vec diagonal)
{
  Matfree     *free;
  PetscReal   *blocks;
  PetscScalar *to;

  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(J, &free));
  const PetscInt bs = free->solver->disc->block;

  PetscCall(PetscMalloc1((free->solver->disc->space->local * bs * bs), &blocks));
  PetscCall(Blocks(free, blocks));
  PetscCall(VecGetArrayWrite(diagonal, &to));
  for (PetscInt k = 0; k < free->solver->disc->space->owned * bs; k++)
    to[k] = blocks[k / bs * bs * bs + (k % bs) * (bs + 1)];
  PetscCall(VecRestoreArrayWrite(diagonal, &to));
  PetscCall(PetscFree(blocks));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Inverts an n x n matrix in place by Gauss-Jordan with pivots on the diagonal, as suits a block of a stable Jacobian.
*/
static PetscBool InvertBlock(PetscInt n, PetscReal a[])
{
  for (PetscInt k = 0; k < n; k++) {
    const PetscReal pivot = a[k * n + k];

    if (pivot == 0. || PetscIsInfOrNanReal(pivot)) return PETSC_FALSE;
    a[k * n + k] = 1.;
    for (PetscInt j = 0; j < n; j++) a[k * n + j] /= pivot;
    for (PetscInt i = 0; i < n; i++) {
      const PetscReal factor = a[i * n + k];

      if (i == k) continue;
      a[i * n + k] = 0.;
      for (PetscInt j = 0; j < n; j++) a[i * n + j] -= factor * a[k * n + j];
    }
  }
  return PETSC_TRUE;
}

static PetscErrorCode MatInvertBlockDiagonal_Matfree(Mat J, const PetscScalar **values)
{
  Matfree   *free;
  PetscReal *blocks;

  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(J, &free));
  const PetscInt bs = free->solver->disc->block, owned = free->solver->disc->space->owned;

  if (!free->inverse) PetscCall(PetscMalloc1((owned * bs * bs), &free->inverse));
  PetscCall(PetscMalloc1((free->solver->disc->space->local * bs * bs), &blocks));
  PetscCall(Blocks(free, blocks));
  for (PetscInt i = 0; i < owned; i++) {
    PetscReal *block = &blocks[i * bs * bs];

    if (!InvertBlock(bs, block)) { /* a node without stiffness: any number will do in a preconditioner */
      for (PetscInt k = 0; k < bs * bs; k++)
        block[k] = k % (bs + 1) ? 0. : 1. / free->solver->disc->constraints->diagonal;
    }
    for (PetscInt r = 0; r < bs; r++)
      for (PetscInt c = 0; c < bs; c++) free->inverse[(i * bs + c) * bs + r] = block[r * bs + c];
  }
  PetscCall(PetscFree(blocks));
  *values = free->inverse;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode MatDestroy_Matfree(Mat J)
{
  Matfree *free;

  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(J, &free));
  PetscCall(MpmActionDestroy(&free->action));
  PetscCall(PetscFree2(free->du, free->y));
  PetscCall(PetscFree(free->inverse));
  PetscCall(PetscFree(free));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMatfreeCreate(MpmSolver *solver, PetscBool stored, Mat *J)
{
  const PetscInt bs = solver->disc->block, rows = solver->disc->space->owned * bs;
  Matfree       *free;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&free));
  free->solver = solver;
  PetscCall(MpmActionCreate(solver->disc->terms, solver->disc->sum, stored, (PetscBool)solver->multigrid.single,
                            &free->action));
  PetscCall(PetscMalloc2((solver->disc->space->local * bs), &free->du, (solver->disc->space->local * bs), &free->y));
  PetscCall(MatCreateShell(solver->disc->comm, rows, rows, solver->disc->space->number.count * bs,
                           solver->disc->space->number.count * bs, free, J));
  PetscCall(MatSetBlockSize(*J, bs));
  PetscCall(MatShellSetOperation(*J, MATOP_MULT, (MpmFunction)MatMult_Matfree));
  PetscCall(MatShellSetOperation(
    *J, MATOP_MULT_TRANSPOSE, (MpmFunction)(solver->definite.symmetric ? MatMult_Matfree : MatMultTranspose_Matfree)));
  PetscCall(MatShellSetOperation(*J, MATOP_GET_DIAGONAL, (MpmFunction)MatGetDiagonal_Matfree));
  PetscCall(MatShellSetOperation(*J, MATOP_INVERT_BLOCK_DIAGONAL, (MpmFunction)MatInvertBlockDiagonal_Matfree));
  PetscCall(MatShellSetOperation(*J, MATOP_DESTROY, (MpmFunction)MatDestroy_Matfree));
  if (solver->definite.symmetric) PetscCall(MatSetOption(*J, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetUp(*J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMatfreeSetState(Mat J, Vec x)
{
  Matfree           *free;
  const PetscScalar *values;
  PetscInt           failed;

  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(J, &free));
  const MpmSolver *solver = free->solver;

  PetscCall(VecGetArrayRead(x, &values));
  PetscCall(PetscArraycpy(free->du, values, solver->disc->space->owned * solver->disc->block));
  PetscCall(VecRestoreArrayRead(x, &values));
  MpmUnitsTimes(solver->disc->constraints, solver->disc->space->owned * solver->disc->block, free->du);
  PetscCall(MpmSpaceToGhosts(solver->disc->space, solver->disc->block, free->du));
  MpmFramesToAxes(solver->disc->constraints, solver->disc->block, solver->disc->space->local, free->du);
  MpmConstraintsExtend(solver->disc->constraints, solver->disc->space, free->du);
  PetscCall(MpmActionSetState(&free->action, free->du, &failed));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY)); /* marks the change for preconditioners */
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMatfreeGetState(Mat J, const PetscReal **u, const MpmFactored **factored)
{
  Matfree *free;

  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(J, &free));
  *u        = free->action.u;
  *factored = free->action.factored;
  PetscFunctionReturn(PETSC_SUCCESS);
}
