#pragma once
/*
  Scenes for the tests of the engine: a model made from a line of options, and a step of it in pieces, so that residual
  and Jacobian can be evaluated for any displacement.
*/
#include "grid/shape.h"
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "schedule/schedule.h"
#include "solve/iterate.h"
#include "step/step.h"
#include "query/model.h"
#include "unit.h"

#include <stdint.h>
#include <stdio.h>
#include <unistd.h>

/* A call that must succeed; a rank that fails ends them all, for the others would wait for it. */
#define SCENE_CALL(call) PetscCallAbort(PETSC_COMM_WORLD, call)

/* Whether it is true on every rank: ranks must agree on the outcome of a check. */
static inline PetscBool SceneAll(PetscBool fine)
{
  int all = (int)fine;

  return (PetscBool)(!MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD) && all);
}

/* A number in [-1, 1] that depends on its arguments alone, not on the ranks. */
static inline PetscReal SceneRandom(PetscInt seed, PetscInt a, PetscInt b)
{
  uint64_t z =
    (uint64_t)seed * 0x9e3779b97f4a7c15u + (uint64_t)a * 0xd1342543de82ef95u + (uint64_t)b * 0xaf251af3b0f025b5u;

  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  return 2. * (PetscReal)(z >> 11) / 9007199254740992. - 1.;
}

/* A model from options alone; those of an earlier scene are forgotten. Physics may be NULL. */
static inline PetscErrorCode SceneCreate(MPI_Comm comm, const MpmPhysics *physics, const char *options, MpmModel *model)
{
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsClear(NULL));
  PetscCall(PetscOptionsInsertString(NULL, options));
  PetscCall(MpmModelCreate(comm, model));
  if (physics) PetscCall(MpmModelSetPhysics(*model, physics));
  PetscCall(MpmModelSetFromOptions(*model));
  PetscCall(MpmModelSetUp(*model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static inline PetscErrorCode SceneDestroy(MpmModel *model)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelDestroy(model));
  PetscCall(PetscOptionsClear(NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All of a step that comes before Newton. */
static inline PetscErrorCode SceneBegin(MpmModel model, PetscReal dt)
{
  MpmOutcome outcome;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesMigrate(model->state.particles, model->disc.grid));
  PetscCall(MpmStepPrepare(model, model->state.time + dt, dt, PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code, model->comm, PETSC_ERR_PLIB, "%s", outcome.text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The displacement x becomes the state, in balance or not. */
static inline PetscErrorCode SceneCommit(MpmModel model, Vec x)
{
  PetscInt failed;

  PetscFunctionBeginUser;
  PetscCall(MpmGatherSolution(&model->solver, x));
  PetscCall(MpmSumResidual(&model->solver, x, MPM_MODE_END, &failed));
  PetscCheck(!failed, PETSC_COMM_SELF, PETSC_ERR_PLIB, "%" PetscInt_FMT " points have no answer", failed);
  PetscCall(MpmCommitLocal(model->disc.sum, model->disc.trial, model->disc.nodal.u));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, model->disc.points));
  model->state.time += model->disc.sum->step.dt;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Random values at the nodes, equal for any number of ranks: amplitude[c] times a number in [-1, 1], in the physics'
  units. Constrained unknowns take their values, or zero where `x` is a direction.
*/
static inline PetscErrorCode SceneFill(MpmModel model, PetscInt seed, const PetscReal amplitude[], PetscBool direction,
                                       Vec x)
{
  const PetscInt bs = model->disc.block, dim = model->disc.dim;
  PetscScalar   *values;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayWrite(x, &values));
  for (PetscInt k = 0; k < model->disc.space->owned * bs; k++) {
    const PetscInt *node  = &model->disc.space->node[(k / bs) * dim];
    const PetscInt  place = (node[0] * 1000 + node[1]) * 1000 + (dim > 2 ? node[2] : 0);

    values[k] = amplitude[k % bs] * SceneRandom(seed, place, k % bs) / model->disc.constraints->unit[k % bs];
    if (!MpmConstraintsFree(model->disc.constraints, k)) values[k] = direction ? 0. : model->disc.constraints->value[k];
  }
  PetscCall(VecRestoreArrayWrite(x, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A copy of the Jacobian made in one of the ways. */
static inline PetscErrorCode SceneJacobian(MpmModel model, MpmJacobianType type, Vec x, Mat *copy)
{
  PetscFunctionBeginUser;
  model->solver.jacobian.form = type;
  PetscCall(
    SNESComputeJacobian(model->solver.snes, x, model->solver.jacobian.assembled, model->solver.jacobian.assembled));
  PetscCall(MatDuplicate(model->solver.jacobian.assembled, MAT_COPY_VALUES, copy));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* |A - B| / |A| in the Frobenius norm; B is destroyed. */
static inline PetscErrorCode SceneDifference(Mat A, Mat *B, PetscReal *difference)
{
  PetscReal norm;

  PetscFunctionBeginUser;
  PetscCall(MatAXPY(*B, -1., A, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatNorm(*B, NORM_FROBENIUS, difference));
  PetscCall(MatNorm(A, NORM_FROBENIUS, &norm));
  PetscCall(MatDestroy(B));
  *difference /= norm;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The residual in the form that MatFDColoring calls; ctx is the SNES. */
static inline PetscErrorCode SceneResidual(void *unused, Vec x, Vec f, void *ctx)
{
  PetscFunctionBeginUser;
  (void)unused;
  PetscCall(SNESComputeFunction((SNES)ctx, x, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The Jacobian by PETSc's own colouring of the matrix's graph and its differences of the whole residual, without
   constraints. */
static inline PetscErrorCode ScenePetscColoring(MpmModel model, Mat local, Vec x, PetscReal *difference)
{
  Mat           other;
  MatColoring   coloring;
  ISColoring    colors;
  MatFDColoring differences;

  PetscFunctionBeginUser;
  PetscCall(MatDuplicate(local, MAT_DO_NOT_COPY_VALUES, &other));
  PetscCall(MatColoringCreate(other, &coloring));
  PetscCall(MatColoringSetType(coloring, MATCOLORINGJP));
  PetscCall(MatColoringSetDistance(coloring, 2));
  PetscCall(MatColoringApply(coloring, &colors));
  PetscCall(MatColoringDestroy(&coloring));
  PetscCall(MatFDColoringCreate(other, colors, &differences));
  /* the function's type has changed between PETSc's releases; void * fits all */
  PetscCall(MatFDColoringSetFunction(differences, (void *)SceneResidual, model->solver.snes));
  PetscCall(MatFDColoringSetParameters(differences, 1e-8, 1e-2));
  PetscCall(MatFDColoringSetUp(other, colors, differences));
  PetscCall(MatFDColoringApply(other, differences, x, model->solver.snes));
  PetscCall(MatFDColoringDestroy(&differences));
  PetscCall(ISColoringDestroy(&colors));
  PetscCall(SceneDifference(local, &other, difference));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Differences between the forms of a Jacobian. */
typedef struct {
  PetscReal norm;                /* of the local Jacobian */
  PetscReal coloring, dense, fd; /* distance from the local one, relative */
  PetscReal petsc;               /* of PETSc's own colouring and differences; 0 with constraints */
  PetscReal action[2];           /* of actions on a vector and transposed ones, with tangents kept and without */
  PetscReal diagonal, blocks; /* of the diagonal without a matrix, and of inverted blocks times blocks from identity */
  PetscReal asymmetry;
  PetscReal slope;     /* least order of the Taylor remainder */
  PetscReal remainder; /* relative to the residual's change */
} SceneVerdict;

#define SCENE_TAYLOR_LONGEST \
  8 /* eps from 2^-8 on: short beside the strain that has yielded, so that few points change branch */
#define SCENE_TAYLOR_SHORTEST 11

/* |r(x + eps v) - r(x) - eps J v| for halved eps */
static inline PetscErrorCode SceneTaylor(MpmModel model, Mat J, Vec x, Vec v, SceneVerdict *verdict)
{
  Vec       r0, r, Jv, at;
  PetscReal last = 0., norm, change;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(x, &r0));
  PetscCall(VecDuplicate(x, &r));
  PetscCall(VecDuplicate(x, &Jv));
  PetscCall(VecDuplicate(x, &at));
  PetscCall(SNESComputeFunction(model->solver.snes, x, r0));
  PetscCall(MatMult(J, v, Jv));
  PetscCall(VecNorm(Jv, NORM_2, &change));
  verdict->slope     = PETSC_MAX_REAL;
  verdict->remainder = 0.;
  for (int k = SCENE_TAYLOR_LONGEST; k <= SCENE_TAYLOR_SHORTEST; k++) {
    const PetscReal eps = 1. / (PetscReal)(1 << k);

    PetscCall(VecWAXPY(at, eps, v, x));
    PetscCall(SNESComputeFunction(model->solver.snes, at, r));
    PetscCall(VecAXPBYPCZ(r, -1., -eps, 1., r0, Jv));
    PetscCall(VecNorm(r, NORM_2, &norm));
    if (last > 0.) verdict->slope = PetscMin(verdict->slope, PetscLog2Real(last / norm));
    verdict->remainder = PetscMax(verdict->remainder, norm / (eps * change));
    last               = norm;
  }
  PetscCall(VecDestroy(&r0));
  PetscCall(VecDestroy(&r));
  PetscCall(VecDestroy(&Jv));
  PetscCall(VecDestroy(&at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* J v and J^T v without a matrix against the local Jacobian's products. */
static inline PetscErrorCode SceneAction(MpmModel model, Mat local, Vec x, Vec v, PetscBool stored,
                                         PetscReal *difference)
{
  Mat       J;
  Vec       y, z;
  PetscReal norm, transposed;

  PetscFunctionBeginUser;
  PetscCall(MpmMatfreeCreate(&model->solver, stored, &J));
  PetscCall(MpmMatfreeSetState(J, x));
  PetscCall(VecDuplicate(x, &y));
  PetscCall(VecDuplicate(x, &z));
  PetscCall(MatMult(J, v, y));
  PetscCall(MatMult(local, v, z));
  PetscCall(VecNorm(z, NORM_2, &norm));
  PetscCall(VecAXPY(y, -1., z));
  PetscCall(VecNorm(y, NORM_2, difference));
  *difference /= norm;
  PetscCall(MatMultTranspose(J, v, y));
  PetscCall(MatMultTranspose(local, v, z));
  PetscCall(VecNorm(z, NORM_2, &norm));
  PetscCall(VecAXPY(y, -1., z));
  PetscCall(VecNorm(y, NORM_2, &transposed));
  *difference = PetscMax(*difference, transposed / norm);
  PetscCall(VecDestroy(&y));
  PetscCall(VecDestroy(&z));
  PetscCall(MatDestroy(&J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Owned nodes that others follow: diagonal blocks without a matrix leave out the coupling of these with their
   followers. */
static inline PetscErrorCode SceneMasters(MpmModel model, PetscReal **masters)
{
  const MpmSpace     *space     = model->disc.space;
  const MpmExtension *extension = &space->extension;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(space->local, masters));
  for (PetscInt k = 0; extension->count && k < extension->offset[extension->count]; k++)
    (*masters)[extension->master[k]] = 1.;
  PetscCall(MpmSpaceAddToOwners(space, 1, *masters));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The diagonal without a matrix against the local Jacobian's, and the inverted diagonal blocks times its blocks against
  identity; at nodes that others follow both are approximate, with a positive diagonal.
*/
static inline PetscErrorCode SceneDiagonal(MpmModel model, Mat local, Vec x, SceneVerdict *verdict)
{
  const PetscInt     bs = model->disc.block;
  Mat                J;
  Vec                y, z;
  PetscReal          norm, *masters;
  const PetscScalar *inverse;
  PetscScalar       *values;

  PetscFunctionBeginUser;
  PetscCall(SceneMasters(model, &masters));
  PetscCall(MpmMatfreeCreate(&model->solver, PETSC_TRUE, &J));
  PetscCall(MpmMatfreeSetState(J, x));
  PetscCall(VecDuplicate(x, &y));
  PetscCall(VecDuplicate(x, &z));
  PetscCall(MatGetDiagonal(J, y));
  PetscCall(MatGetDiagonal(local, z));
  PetscCall(VecNorm(z, NORM_2, &norm));
  PetscCall(VecAXPY(y, -1., z));
  PetscCall(VecGetArray(y, &values));
  for (PetscInt k = 0; k < model->disc.space->owned * bs; k++)
    if (masters[k / bs] > 0.) values[k] = 0.;
  PetscCall(VecRestoreArray(y, &values));
  PetscCall(VecNorm(y, NORM_2, &verdict->diagonal));
  verdict->diagonal /= norm;
  PetscCall(MatInvertBlockDiagonal(J, &inverse));
  verdict->blocks = 0.;
  for (PetscInt i = 0; i < model->disc.space->owned; i++) {
    PetscInt    rows[MPM_MAX_BLOCK];
    PetscScalar block[MPM_MAX_BLOCK * MPM_MAX_BLOCK];
    PetscReal   off = 0., least = PETSC_MAX_REAL;

    if (masters[i] > 0.) continue;
    for (PetscInt c = 0; c < bs; c++) rows[c] = (model->disc.space->number.begin + i) * bs + c;
    PetscCall(MatGetValues(local, bs, rows, bs, rows, block));
    for (PetscInt r = 0; r < bs; r++) {
      least = PetscMin(least, PetscAbsScalar(block[r * bs + r]));
      for (PetscInt c = 0; c < bs; c++) {
        PetscScalar product = r == c ? -1. : 0.;

        for (PetscInt k = 0; k < bs; k++) product += inverse[(i * bs + k) * bs + r] * block[k * bs + c];
        off = PetscMax(off, PetscAbsScalar(product));
      }
    }
    if (least > 1e-6 * model->disc.matrix.diagonal) verdict->blocks = PetscMax(verdict->blocks, off);
  }
  PetscCall(VecDestroy(&y));
  PetscCall(VecDestroy(&z));
  PetscCall(MatDestroy(&J));
  PetscCall(PetscFree(masters));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &verdict->blocks, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Compares the Jacobians at x, and the local one with the residual's change along v. */
static inline PetscErrorCode SceneCompare(MpmModel model, Vec x, Vec v, SceneVerdict *verdict)
{
  const PetscBool factorises = model->solver.preset.factorises;
  Mat             local, other;

  PetscFunctionBeginUser;
  model->solver.preset.factorises = PETSC_FALSE; /* raised diagonals of weak nodes are no part of what is compared */
  PetscCall(SceneJacobian(model, MPM_JACOBIAN_LOCAL, x, &local));
  PetscCall(MatNorm(local, NORM_FROBENIUS, &verdict->norm));
  PetscCall(SceneJacobian(model, MPM_JACOBIAN_COLORING, x, &other));
  PetscCall(SceneDifference(local, &other, &verdict->coloring));
  PetscCall(SceneJacobian(model, MPM_JACOBIAN_DENSE, x, &other));
  PetscCall(SceneDifference(local, &other, &verdict->dense));
  PetscCall(SceneJacobian(model, MPM_JACOBIAN_FD, x, &other));
  PetscCall(SceneDifference(local, &other, &verdict->fd));
  PetscCall(MatTranspose(local, MAT_INITIAL_MATRIX, &other));
  PetscCall(SceneDifference(local, &other, &verdict->asymmetry));
  verdict->petsc = 0.;
  /* hundreds of residuals, in which the sanitizers see nothing new; columns of constrained unknowns differ */
  if (!UNIT_SANITIZED && SceneAll((PetscBool)!model->disc.constraints->any))
    PetscCall(ScenePetscColoring(model, local, x, &verdict->petsc));
  PetscCall(SceneAction(model, local, x, v, PETSC_TRUE, &verdict->action[0]));
  PetscCall(SceneAction(model, local, x, v, PETSC_FALSE, &verdict->action[1]));
  PetscCall(SceneDiagonal(model, local, x, verdict));
  PetscCall(SceneTaylor(model, local, x, v, verdict));
  PetscCall(MatDestroy(&local));
  model->solver.preset.factorises = factorises;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All steps, without files. */
static inline PetscErrorCode SceneRun(MpmModel model)
{
  const PetscInt steps = (PetscInt)PetscFloorReal(model->state.period.end / model->state.dt.nominal + 0.5);
  PetscBool      moved;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < steps; k++) {
    const PetscReal next = model->state.dt.nominal * (PetscReal)(k + 1);
    MpmOutcome      outcome;

    PetscCall(MpmParticlesRebalance(model->state.particles, model->disc.grid, PETSC_FALSE, &moved));
    PetscCall(MpmParticlesMigrate(model->state.particles, model->disc.grid));
    PetscCall(MpmStep(model, next, next - model->state.time, PETSC_FALSE, &outcome));
    PetscCheck(!outcome.code, PETSC_COMM_SELF, PETSC_ERR_NOT_CONVERGED, "step %" PetscInt_FMT ": %s", k, outcome.text);
    model->state.time = next;
    model->state.step++;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values of all points by id, on every rank of the model; free with PetscFree(). */
static inline PetscErrorCode SceneById(MpmModel model, PetscInt components, const char *field, PetscReal **all)
{
  const PetscInt total = (PetscInt)model->state.particles->total * components;
  PetscReal     *values;
  PetscInt      *id, count;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(total, all));
  PetscCall(DMSwarmGetLocalSize(model->state.particles->swarm, &count));
  PetscCall(MpmParticlesGetField(model->state.particles, "id", &id));
  PetscCall(MpmParticlesGetField(model->state.particles, field, &values));
  for (PetscInt k = 0; k < count * components; k++)
    (*all)[id[k / components] * components + k % components] += values[k];
  PetscCall(MpmParticlesRestoreField(model->state.particles, &values));
  PetscCall(MpmParticlesRestoreField(model->state.particles, &id));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, *all, (PetscMPIInt)total, MPIU_REAL, MPIU_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Largest difference of a field between two models of equal points, relative to the field's largest change from `base`
   (or 0). */
static inline PetscErrorCode SceneFieldDifference(MpmModel a, MpmModel b, PetscInt components, const char *field,
                                                  const char *base, PetscReal *difference)
{
  PetscReal *of_a, *of_b, *of_base = NULL, most = 0.;

  PetscFunctionBeginUser;
  PetscCheck(a->state.particles->total == b->state.particles->total, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "the models have different numbers of points");
  PetscCall(SceneById(a, components, field, &of_a));
  PetscCall(SceneById(b, components, field, &of_b));
  if (base) PetscCall(SceneById(a, components, base, &of_base));
  *difference = 0.;
  for (PetscInt k = 0; k < (PetscInt)a->state.particles->total * components; k++) {
    *difference = PetscMax(*difference, PetscAbsReal(of_a[k] - of_b[k]));
    most        = PetscMax(most, PetscAbsReal(of_a[k] - (of_base ? of_base[k] : 0.)));
  }
  *difference = most > 0. ? *difference / most : PETSC_MAX_REAL;
  PetscCall(PetscFree(of_a));
  PetscCall(PetscFree(of_b));
  PetscCall(PetscFree(of_base));
  PetscFunctionReturn(PETSC_SUCCESS);
}
