/*
  Differences between the Jacobian's forms, for authors of a law or a physics: one step is prepared, an increment made
  up, and the Jacobian there made in all ways.
*/
#include "particles/particles.h"
#include "bc/bc.h"
#include "query/model.h"
#include "step/step.h"
#include "model/build.h"

/* A number in [-1, 1] that depends on its arguments alone, not on the ranks. */
static PetscReal Noise(PetscInt a, PetscInt b)
{
  const PetscReal x = PetscSinReal(12.9898 * (PetscReal)a + 78.233 * (PetscReal)b + 1.) * 43758.5453;

  return 2. * (x - PetscFloorReal(x)) - 1.;
}

/* Adds noise to the free unknowns, or makes a direction of it. */
static PetscErrorCode AddNoise(MpmModel model, PetscReal cells, PetscInt seed, Vec x)
{
  const MpmDiscretization *disc = &model->disc;
  const PetscInt           bs = disc->block, dim = disc->dim;
  PetscInt                 owned;
  const PetscInt          *nodes = MpmOwnedNodes(disc, &owned);
  PetscScalar             *values;

  PetscFunctionBeginUser;
  PetscCall(VecGetArray(x, &values));
  for (PetscInt k = 0; k < owned * bs; k++) {
    const PetscInt *node = &nodes[(k / bs) * dim], c = k % bs;
    const PetscReal scale = cells * disc->h[c % dim]; /* in the unknowns' units: a part of 1, or of a stiffness */
    const PetscInt  place = node[0] + 31 * node[1] + (dim > 2 ? 977 * node[2] : 0);

    if (MpmConstraintsFree(disc->constraints, k)) values[k] += scale * Noise(place, seed * MPM_MAX_BLOCK + c);
  }
  PetscCall(VecRestoreArray(x, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* |A - B| / |A|, B made in one of the ways. */
static PetscErrorCode Assembled(MpmModel model, MpmJacobianType type, Vec x, Mat A, PetscReal *distance)
{
  Mat       B = model->solver.jacobian.assembled, difference;
  PetscReal norm;

  PetscFunctionBeginUser;
  model->solver.jacobian.form = type;
  PetscCall(SNESComputeJacobian(model->solver.snes, x, B, B));
  PetscCall(MatDuplicate(A, MAT_COPY_VALUES, &difference));
  PetscCall(MatAXPY(difference, -1., B, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatNorm(difference, NORM_FROBENIUS, distance));
  PetscCall(MatNorm(A, NORM_FROBENIUS, &norm));
  *distance /= norm;
  PetscCall(MatDestroy(&difference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* |A v - J v| / |A v|, J without a matrix. */
static PetscErrorCode Action(MpmModel model, Vec x, Mat A, PetscBool stored, PetscReal *distance)
{
  Mat       J;
  Vec       v, y, z;
  PetscReal norm;

  PetscFunctionBeginUser;
  PetscCall(MpmMatfreeCreate(&model->solver, stored, &J));
  PetscCall(MpmMatfreeSetState(J, x));
  PetscCall(VecDuplicate(x, &v));
  PetscCall(VecDuplicate(x, &y));
  PetscCall(VecDuplicate(x, &z));
  PetscCall(VecZeroEntries(v));
  PetscCall(AddNoise(model, 1., 1, v));
  PetscCall(MatMult(A, v, y));
  PetscCall(MatMult(J, v, z));
  PetscCall(VecNorm(y, NORM_2, &norm));
  PetscCall(VecAXPY(z, -1., y));
  PetscCall(VecNorm(z, NORM_2, distance));
  *distance /= norm;
  PetscCall(VecDestroy(&v));
  PetscCall(VecDestroy(&y));
  PetscCall(VecDestroy(&z));
  PetscCall(MatDestroy(&J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Without extras for direct solvers: raised diagonals of weak nodes. */
static PetscErrorCode Compare(MpmModel model, Vec x, MpmJacobianCheck *check)
{
  const MpmJacobianType type       = model->solver.jacobian.form;
  const PetscBool       factorises = model->solver.preset.factorises;
  Mat                   A;

  PetscFunctionBeginUser;
  model->solver.preset.factorises = PETSC_FALSE;
  model->solver.jacobian.form     = MPM_JACOBIAN_LOCAL;
  PetscCall(
    SNESComputeJacobian(model->solver.snes, x, model->solver.jacobian.assembled, model->solver.jacobian.assembled));
  PetscCall(MatDuplicate(model->solver.jacobian.assembled, MAT_COPY_VALUES, &A));
  PetscCall(Assembled(model, MPM_JACOBIAN_COLORING, x, A, &check->coloring));
  PetscCall(Assembled(model, MPM_JACOBIAN_DENSE, x, A, &check->dense));
  PetscCall(Assembled(model, MPM_JACOBIAN_FD, x, A, &check->differences));
  PetscCall(Action(model, x, A, PETSC_TRUE, &check->matfree[0]));
  PetscCall(Action(model, x, A, PETSC_FALSE, &check->matfree[1]));
  PetscCall(MatDestroy(&A));
  model->solver.jacobian.form     = type;
  model->solver.preset.factorises = factorises;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Check(MpmModel model, PetscReal cells, MpmJacobianCheck *check)
{
  const PetscReal dt = model->state.dt.wanted;
  MpmOutcome      outcome;
  Vec             x;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscCall(MpmParticlesDistribute(model->state.particles, model->disc.grid, &outcome));
  PetscCheck(!outcome.code, model->comm, PETSC_ERR_ARG_WRONGSTATE, "%s", outcome.text);
  PetscCall(MpmStepPrepare(model, model->state.time + dt, dt, PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code, model->comm, PETSC_ERR_ARG_WRONGSTATE, "%s", outcome.text);
  PetscCheck(model->solver.jacobian.assembled, model->comm, PETSC_ERR_SUP,
             "the preconditioner does without a matrix: there is none to compare with");
  PetscCall(VecDuplicate(model->solver.x, &x));
  PetscCall(VecCopy(model->solver.x, x));
  PetscCall(AddNoise(model, cells, 0, x));
  PetscCall(Compare(model, x, check));
  PetscCall(VecDestroy(&x));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelCheckJacobian(MpmModel model, PetscReal cells, MpmJacobianCheck *check)
{
  PetscFunctionBeginUser;
  PetscCheck(!model->laboratory, model->comm, PETSC_ERR_SUP, "a stress point has no grid's Jacobian");
  PetscCall(MpmModelSetUp(model));
  MpmModelCall(model, Check(model, cells, check));
  PetscFunctionReturn(PETSC_SUCCESS);
}
