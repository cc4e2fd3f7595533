/*
  Nodal velocities and accelerations of elements of order 2 and more, from those of the points.

  A lumped mass, sum_p m_p w_ip, is negative at nodes of cells that the material fills in part, so that means weighted
  by mass do not exist. Nodal values are those of the least squares sum_p m_p (sum_i w_ip v_i - v_p)^2 instead,

    (M + G) v = sum_p m_p w_ip v_p ,

  with the consistent mass M. The ghost penalty G is that of the stiffness with rho h^2 in place of E_s: badly supported
  nodes continue the polynomials of their neighbours. Constrained unknowns keep their values, and small-cut nodes follow
  others, as in the balance of the step. Conjugate gradients with the diagonal solve the system.

  Source: Sticko, Kreiss (2019), SIAM J. Sci. Comput. 41, A1424-A1450, doi:10.1137/18M1202979 (the mass' penalty).
*/
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "volume/inertia.h"
#include "volume/volume.h"

#define RELATIVE 1e-13 /* of the residual */
#define MOST     1000  /* iterations */

/* The operator, with room for values of the local nodes. */
typedef struct {
  const MpmInertia     *inertia;
  const MpmSum         *sum;
  const MpmConstraints *constraints;
  PetscReal            *in, *out;
} Operator;

/* Forces of the local nodes, of which each rank has its part, to those of the owned unknowns; 0 at constrained ones. */
static PetscErrorCode ToUnknowns(const Operator *of, PetscReal forces[])
{
  const MpmSpace *space = of->sum->space;

  PetscFunctionBeginUser;
  MpmConstraintsGather(of->constraints, space, forces);
  PetscCall(MpmSpaceAddToOwners(space, space->dim, forces));
  MpmFramesToUnknowns(of->constraints, space->dim, space->owned, forces);
  for (PetscInt k = 0; k < space->owned * space->dim; k++)
    if (!MpmConstraintsFree(of->constraints, k)) forces[k] = 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values of the owned unknowns to those of all local nodes, along the axes. */
static PetscErrorCode ToNodes(const Operator *of, PetscReal values[])
{
  const MpmSpace *space = of->sum->space;

  PetscFunctionBeginUser;
  MpmFramesToAxes(of->constraints, space->dim, space->owned, values);
  PetscCall(MpmSpaceToGhosts(space, space->dim, values));
  MpmConstraintsExtend(of->constraints, space, values);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* out = (M + G) in, of the local nodes; out is this rank's part. */
static PetscErrorCode Multiply(const Operator *of)
{
  const MpmSpace *space = of->sum->space;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(of->out, space->local * space->dim));
  PetscCall(MpmInertiaTimes(of->inertia, of->sum, of->in, of->out));
  PetscCall(MpmGhostMass(of->sum, of->in, of->out));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(Mat mat, Vec x, Vec y)
{
  Operator          *of;
  const PetscScalar *from;
  PetscScalar       *to;
  PetscInt           count;

  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(mat, &of));
  count = of->sum->space->owned * of->sum->space->dim;
  PetscCall(VecGetArrayRead(x, &from));
  for (PetscInt k = 0; k < count; k++) of->in[k] = MpmConstraintsFree(of->constraints, k) ? from[k] : 0.;
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscCall(ToNodes(of, of->in));
  PetscCall(Multiply(of));
  PetscCall(ToUnknowns(of, of->out));
  PetscCall(VecGetArrayWrite(y, &to));
  PetscCall(PetscArraycpy(to, of->out, count));
  PetscCall(VecRestoreArrayWrite(y, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The diagonal without the share of followers; 1 where it has nothing. */
static PetscErrorCode Diagonal(Mat mat, Vec diagonal)
{
  Operator    *of;
  PetscScalar *to;
  PetscInt     dim;

  PetscFunctionBeginUser;
  PetscCall(MatShellGetContext(mat, &of));
  dim = of->sum->space->dim;
  PetscCall(PetscArrayzero(of->out, of->sum->space->local * dim));
  PetscCall(MpmInertiaDiagonal(of->inertia, of->sum, of->out));
  PetscCall(MpmGhostMassDiagonal(of->sum, of->out));
  PetscCall(MpmSpaceAddToOwners(of->sum->space, dim, of->out));
  PetscCall(VecGetArrayWrite(diagonal, &to));
  for (PetscInt k = 0; k < of->sum->space->owned * dim; k++) to[k] = of->out[k] > 0. ? of->out[k] : 1.;
  PetscCall(VecRestoreArrayWrite(diagonal, &to));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Solves for the free unknowns, right hand side and result in `x`. */
static PetscErrorCode Solve(MPI_Comm comm, Operator *of, PetscInt count, PetscReal x[])
{
  Mat mat;
  Vec right, result;
  KSP ksp;
  PC  pc;

  PetscFunctionBeginUser;
  PetscCall(MatCreateShell(comm, count, count, PETSC_DETERMINE, PETSC_DETERMINE, of, &mat));
  PetscCall(MatShellSetOperation(mat, MATOP_MULT, (void (*)(void))Apply));
  PetscCall(MatShellSetOperation(mat, MATOP_GET_DIAGONAL, (void (*)(void))Diagonal));
  PetscCall(VecCreateMPIWithArray(comm, 1, count, PETSC_DETERMINE, x, &right));
  PetscCall(VecDuplicate(right, &result));
  PetscCall(KSPCreate(comm, &ksp));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetOperators(ksp, mat, mat));
  PetscCall(KSPSetTolerances(ksp, RELATIVE, PETSC_DEFAULT, PETSC_DEFAULT, MOST));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  PetscCall(KSPSolve(ksp, right, result));
  PetscCall(VecCopy(result, right));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(VecDestroy(&result));
  PetscCall(VecDestroy(&right));
  PetscCall(MatDestroy(&mat));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInertiaSolve(const MpmInertia *inertia, const MpmSum *sum, const MpmConstraints *constraints,
                               MPI_Comm comm, const PetscReal right[], PetscReal values[])
{
  const PetscInt dim = sum->space->dim, all = sum->space->local * dim, owned = sum->space->owned * dim;
  Operator       of = {.inertia = inertia, .sum = sum, .constraints = constraints};
  PetscReal     *x;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(all, &of.in, all, &of.out, all, &x));
  /* right hand side less what the constrained unknowns take */
  PetscCall(PetscArraycpy(of.in, values, owned));
  MpmFramesToUnknowns(constraints, dim, sum->space->owned, of.in);
  for (PetscInt k = 0; k < owned; k++)
    if (MpmConstraintsFree(constraints, k)) of.in[k] = 0.;
  PetscCall(PetscArraycpy(values, of.in, owned));
  PetscCall(ToNodes(&of, of.in));
  PetscCall(Multiply(&of));
  for (PetscInt k = 0; k < all; k++) x[k] = (k < owned ? right[k] : 0.) - of.out[k];
  PetscCall(ToUnknowns(&of, x));
  PetscCall(Solve(comm, &of, owned, x));
  for (PetscInt k = 0; k < owned; k++)
    if (MpmConstraintsFree(constraints, k)) values[k] = x[k];
  PetscCall(ToNodes(&of, values));
  PetscCall(PetscFree3(of.in, of.out, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}
