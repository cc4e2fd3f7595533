/*
  Newton's parts: residual and Jacobian as SNES calls them, and when a step has converged.
*/
#include <petsc/private/petscimpl.h> /* PetscObjectStateGet() */
#include "point/layout.h"
#include "point/material.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "volume/inertia.h"
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

/* The same with the Jacobian's sums, in one pass. */
static PetscErrorCode SumBoth(MpmSolver *solver, Vec x, PetscInt *failed)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPlaceGet(x, &solver->cache.summed));
  for (PetscInt k = 0; k < solver->disc->space->local * solver->disc->block; k++)
    solver->disc->residual[k] = -solver->disc->force[k];
  solver->cache.assembled   = PETSC_FALSE;
  solver->disc->trial->made = PETSC_FALSE;
  PetscCall(MpmSolverMindContact(solver, PETSC_FALSE));
  PetscCall(MpmPatternBegin(solver->disc->pattern, solver->disc->space, solver->disc->constraints, solver->jacobian));
  PetscCall(MpmTermsTangent(solver->disc->terms, solver->disc->sum, solver->disc->u, solver->disc->pattern,
                            solver->disc->residual, failed));
  MpmConstraintsGather(solver->disc->constraints, solver->disc->space, solver->disc->residual);
  PetscCall(MpmSpaceAddToOwners(solver->disc->space, solver->disc->block, solver->disc->residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  f = internal - external force; on constrained unknowns, diagonal * (u - value). Where a point has no answer f becomes
  infinite and SNES backs off. The tangents' kernel gives the fluxes too: where a Jacobian at the same place is sure to
  follow, its sums are made in the same pass.
*/
static PetscErrorCode FormFunction(SNES snes, Vec x, Vec f, void *ctx)
{
  MpmSolver         *solver = (MpmSolver *)ctx;
  const PetscInt     bs     = solver->disc->block;
  const PetscScalar *at;
  PetscScalar       *values;
  PetscLogDouble     since;
  MpmTimer           timer;
  PetscInt           failed;
  PetscBool          both;

  PetscFunctionBeginUser;
  (void)snes;
  PetscCall(MpmGatherSolution(solver, x));
  both                = (PetscBool)(solver->cache.ahead && solver->jacobian_type == MPM_JACOBIAN_LOCAL);
  solver->cache.ahead = PETSC_FALSE;
  timer               = both ? MPM_TIME_JACOBIAN : MPM_TIME_RESIDUAL;
  PetscCall(MpmMonitorBegin(solver->monitor, timer, &since));
  if (both) PetscCall(SumBoth(solver, x, &failed));
  else PetscCall(MpmSumResidual(solver, &failed));
  MpmFramesToUnknowns(solver->disc->constraints, bs, solver->disc->space->owned, solver->disc->residual);
  solver->disc->trial->framed = PETSC_TRUE;
  PetscCall(VecGetArrayRead(x, &at));
  PetscCall(VecGetArrayWrite(f, &values));
  PetscCall(PetscArraycpy(values, solver->disc->residual, solver->disc->space->owned * bs));
  MpmUnitsTimes(solver->disc->constraints, solver->disc->space->owned * bs, values);
  MpmConstraintsResidual(solver->disc->constraints, solver->disc->space->owned * bs, at, values);
  PetscCall(VecRestoreArrayRead(x, &at));
  /* a rank may own no unknown of its failing points: the flag travels apart */
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_MAX, solver->disc->comm));
  if (failed && solver->disc->space->owned) values[0] = PETSC_INFINITY;
  PetscCall(VecRestoreArrayWrite(f, &values));
  PetscCall(MpmMonitorEnd(solver->monitor, timer, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sums over points that the Jacobian consists of, in the way that was asked for. */
static PetscErrorCode SumJacobian(MpmSolver *solver, Vec x, Mat P)
{
  PetscInt failed;

  PetscFunctionBeginUser;
  PetscCall(MpmGatherSolution(solver, x));
  PetscCall(MpmSolverMindContact(solver, PETSC_FALSE));
  PetscCall(MpmPatternBegin(solver->disc->pattern, solver->disc->space, solver->disc->constraints, P));
  if (solver->jacobian_type == MPM_JACOBIAN_LOCAL || solver->jacobian_type == MPM_JACOBIAN_MATFREE)
    PetscCall(
      MpmTermsTangent(solver->disc->terms, solver->disc->sum, solver->disc->u, solver->disc->pattern, NULL, &failed));
  else
    PetscCall(MpmJacobianColoring(solver->disc->terms, solver->disc->sum, solver->jacobian_type, solver->disc->u,
                                  solver->disc->pattern, &failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AssembleJacobian(MpmSolver *solver, Vec x, Mat P)
{
  MpmPlace place;

  PetscFunctionBeginUser;
  PetscCall(MpmPlaceGet(x, &place));
  if (!MpmPlaceIsSame(&place, &solver->cache.summed)) PetscCall(SumJacobian(solver, x, P));
  solver->cache.summed.id = 0;
  solver->cache.assembled = PETSC_TRUE;
  PetscCall(MpmPatternEnd(solver->disc->pattern, solver->disc->space, P));
  if (solver->factorises) PetscCall(MpmJacobianLift(solver, P));
  if (solver->symmetric || solver->at_rest.count)
    PetscCall(MatSetOption(P, MAT_SYMMETRIC, (PetscBool)(solver->symmetric || solver->at_rest.now)));
  PetscCall(MpmFieldsplitUpdate(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Will the last Jacobian do? With it the residual goes on falling by about its last factor, since that factor is the
  distance of the last iterate; a new one squares it. So the old one is kept for one iteration where that brings the
  residual to its tolerance with some room.
*/
static PetscBool LastWillDo(const MpmSolver *solver, PetscInt it, PetscReal fnorm, PetscReal target)
{
  if (!solver->cache.solving || !solver->cache.lag || !it || solver->cache.lagged) return PETSC_FALSE;
  return (PetscBool)(fnorm * fnorm <= 0.3 * target * solver->cache.fnorm_last);
}

static PetscErrorCode FormJacobian(SNES snes, Vec x, Mat J, Mat P, void *ctx)
{
  MpmSolver     *solver = (MpmSolver *)ctx;
  PetscLogDouble since;
  PetscReal      fnorm = 0., rtol;
  PetscInt       it;
  PetscBool      last;

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(snes, &it));
  PetscCall(SNESGetFunctionNorm(snes, &fnorm));
  PetscCall(SNESGetTolerances(snes, NULL, &rtol, NULL, NULL, NULL));
  if (solver->disc->layout->field_count > 1) {
    fnorm = solver->cache.fields.excess;
    last  = LastWillDo(solver, it, fnorm, 1.);
  } else last = LastWillDo(solver, it, fnorm, rtol * solver->cache.reference);
  solver->cache.fnorm_last = fnorm;
  solver->cache.lagged     = (PetscBool)(last && solver->cache.assembled);
  if (solver->cache.lagged) PetscFunctionReturn(PETSC_SUCCESS);
  if (!last) solver->cache.needed_count++;
  PetscCall(MpmMonitorBegin(solver->monitor, MPM_TIME_JACOBIAN, &since));
  if (solver->jacobian) PetscCall(AssembleJacobian(solver, x, P));
  if (solver->shell) PetscCall(MpmMatfreeSetState(J, x));
  PetscCall(MpmMonitorEnd(solver->monitor, MPM_TIME_JACOBIAN, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stiffness of the firmest contact against a node, N/m. */
static PetscReal Contact(const MpmSolver *solver)
{
  const MpmDiscretization *disc    = solver->disc;
  PetscReal                modulus = 0.;

  for (PetscInt m = 0; m < disc->material_count; m++) modulus = PetscMax(modulus, disc->sum->materials[m].penalty);
  return MpmTermsFirmness(disc->terms) * modulus * PetscPowRealInt(disc->h[0], disc->dim - 2);
}

#define BODY_IMBALANCE 1e-12 /* of what pushes a body */

/*
  A free body's few equations are part of all, and may be off by more than their share: Newton goes on until they are met,
  or come no closer.
*/
static PetscErrorCode TestBodies(SNES snes, MpmSolver *solver, SNESConvergedReason *reason)
{
  const PetscReal    last = solver->cache.imbalance;
  const PetscScalar *values;
  Vec                f;

  PetscFunctionBeginUser;
  PetscCall(SNESGetFunction(snes, &f, NULL, NULL));
  PetscCall(VecGetArrayRead(f, &values));
  solver->cache.imbalance = MpmTermsImbalance(solver->disc->terms, solver->disc->sum, values);
  PetscCall(VecRestoreArrayRead(f, &values));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &solver->cache.imbalance, 1, MPIU_REAL, MPIU_MAX, solver->disc->comm));
  if (*reason > 0 && !solver->cache.rough && solver->cache.imbalance > BODY_IMBALANCE &&
      solver->cache.imbalance < 0.5 * last)
    *reason = SNES_CONVERGED_ITERATING;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSolverSetReference(MpmSolver *solver, Vec f)
{
  PetscFunctionBeginUser;
  PetscCall(VecNorm(f, NORM_2, &solver->cache.reference));
  if (PetscIsInfOrNanReal(solver->cache.reference)) solver->cache.reference = 0.;
  PetscCall(MpmFieldsSetReference(solver, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  What rounding leaves of the residual, at x: a residual as small cannot be reduced. Strains are known to eps and to
  eps |u|/h, the last from the differences of nodal values; times stiffness and a node's share of volume that is eps K (h + |u|)
  a node. A boundary's penalty adds what it makes of the rounding of places.
*/
static PetscReal Floor(const MpmSolver *solver, PetscReal xnorm)
{
  const PetscReal unknowns = (PetscReal)(solver->disc->space->global_count * solver->disc->block);
  const PetscReal cells    = solver->disc->h[0] * PetscSqrtReal(unknowns); /* a cell a node */
  const PetscReal size     = PetscMin(xnorm, 16. * cells); /* a node gone astray must not raise the floor */

  return PETSC_MACHINE_EPSILON * (2. * solver->disc->diagonal + 0.5 * Contact(solver)) * (cells + size);
}

PetscErrorCode MpmFieldsExcess(MpmSolver *solver, Vec x, Vec f, PetscReal *excess)
{
  PetscReal rtol, xnorm;

  PetscFunctionBeginUser;
  PetscCall(SNESGetTolerances(solver->snes, NULL, &rtol, NULL, NULL, NULL));
  PetscCall(VecNorm(x, NORM_2, &xnorm));
  PetscCall(MpmFieldsConverged(solver, f, rtol, Floor(solver, xnorm), excess));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmSolverHasContact(const MpmSolver *solver)
{
  return MpmTermsNear(solver->disc->terms, MPM_TERM_CONTACT);
}

#define ROUGH 1e4 /* times the tolerance */

/* Is a residual with this norm small enough? */
static PetscErrorCode TestNorm(MpmSolver *solver, PetscReal xnorm, PetscReal fnorm, SNESConvergedReason *reason)
{
  PetscReal atol, rtol;

  PetscFunctionBeginUser;
  PetscCall(SNESGetTolerances(solver->snes, &atol, &rtol, NULL, NULL, NULL));
  if (solver->disc->layout->field_count > 1) {
    Vec x, f;

    PetscCall(SNESGetSolution(solver->snes, &x));
    PetscCall(SNESGetFunction(solver->snes, &f, NULL, NULL));
    PetscCall(MpmFieldsExcess(solver, x, f, &solver->cache.fields.excess));
    if (fnorm <= atol) *reason = SNES_CONVERGED_FNORM_ABS;
    else if (solver->cache.fields.excess <= 1.) *reason = SNES_CONVERGED_FNORM_RELATIVE;
    solver->cache.rough = PETSC_FALSE;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (fnorm <= PetscMax(atol, Floor(solver, xnorm))) *reason = SNES_CONVERGED_FNORM_ABS;
  else if (fnorm <= rtol * solver->cache.reference) *reason = SNES_CONVERGED_FNORM_RELATIVE;
  if (*reason > 0) solver->cache.rough = PETSC_FALSE;
  else if (solver->cache.rough && fnorm <= ROUGH * rtol * solver->cache.reference)
    *reason = SNES_CONVERGED_FNORM_RELATIVE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* It gets nowhere when so many iterations have not reduced the least residual to this part. */
#define STALL      6
#define STALL_GAIN 0.9

/* Does Newton's method get nowhere? Where contact goes to and fro between states it does so for ever. */
static PetscBool Stalls(MpmEvaluations *cache, PetscInt it, PetscReal fnorm)
{
  if (!it || fnorm < STALL_GAIN * cache->least) {
    cache->least    = fnorm;
    cache->least_at = it;
  }
  return (PetscBool)(it - cache->least_at >= STALL);
}

/* With contact a prediction is an answer only where it is so much better than an iteration has to be: forces balance. */
#define PREDICTION 1e-3

/* They do so to this part of what pushes, but for that no more than so many iterations are taken. */
#define BALANCE      1e-6
#define BALANCE_MOST 12

/*
  Squares of the reactions, N2, of the owned unknowns that are prescribed to move, in a step without inertia whose only unknown is the
  displacement. The residual is that of the last iterate.
*/
static PetscReal ReactionSquares(const MpmDiscretization *disc)
{
  const MpmConstraints *constraints = disc->constraints;
  PetscReal             squares     = 0.;

  if (!constraints->any || disc->inertia->active || disc->layout->field_count > 1) return 0.;
  for (PetscInt k = 0; k < disc->space->owned * disc->block; k++)
    if (!MpmConstraintsFree(constraints, k) && constraints->value[k] != 0.) squares += PetscSqr(disc->residual[k]);
  return squares;
}

/*
  Are the forces of contacts, and of what is prescribed to move, in balance? What moves makes the residual at rest large, and with it the
  tolerance, however little it presses.
*/
static PetscErrorCode IsBalanced(MpmSolver *solver, PetscReal fnorm, PetscBool *balanced)
{
  const MpmDiscretization *disc    = solver->disc;
  PetscReal                squares = ReactionSquares(disc);

  PetscFunctionBeginUser;
  *balanced = (PetscBool)(solver->cache.rough || solver->cache.balances == BALANCE_MOST);
  if (*balanced) PetscFunctionReturn(PETSC_SUCCESS);
  if (MpmSolverHasContact(solver)) PetscCall(MpmTermsAddSquares(disc->terms, disc->sum, disc->u, &squares));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &squares, 1, MPIU_REAL, MPIU_SUM, disc->comm));
  *balanced = (PetscBool)(!(squares > 0.) || fnorm <= BALANCE * PetscSqrtReal(squares));
  if (!*balanced) solver->cache.balances++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Relative to the residual at zero displacement, whatever the first guess; and a floor. */
static PetscErrorCode TestConvergence(SNES snes, PetscInt it, PetscReal xnorm, PetscReal snorm, PetscReal fnorm,
                                      SNESConvergedReason *reason, void *ctx)
{
  MpmSolver *solver = (MpmSolver *)ctx;
  PetscReal  stol, divtol, rtol;
  PetscBool  balanced;
  Vec        f;

  PetscFunctionBeginUser;
  PetscCall(SNESGetTolerances(snes, NULL, NULL, &stol, NULL, NULL));
  PetscCall(SNESGetDivergenceTolerance(snes, &divtol));
  PetscCall(SNESGetFunction(snes, &f, NULL, NULL));
  if (!it && !(solver->cache.reference > 0.)) PetscCall(MpmSolverSetReference(solver, f));
  if (!it) solver->cache.balances = 0;
  *reason = SNES_CONVERGED_ITERATING;
  if (PetscIsInfOrNanReal(fnorm)) *reason = MPM_SNES_DIVERGED_NAN;
  else PetscCall(TestNorm(solver, xnorm, fnorm, reason));
  if (!it && *reason > 0 && MpmSolverHasContact(solver) && solver->cache.reference > Floor(solver, xnorm)) {
    PetscCall(SNESGetTolerances(snes, NULL, &rtol, NULL, NULL, NULL));
    if (fnorm > PREDICTION * rtol * solver->cache.reference) *reason = SNES_CONVERGED_ITERATING;
  }
  if (*reason == SNES_CONVERGED_ITERATING && it) {
    if (snorm < stol * xnorm) *reason = SNES_CONVERGED_SNORM_RELATIVE;
    else if (divtol > 0. && fnorm > divtol * solver->cache.reference) *reason = SNES_DIVERGED_DTOL;
  }
  if (Stalls(&solver->cache, it, fnorm) && solver->cache.hasty && *reason == SNES_CONVERGED_ITERATING)
    *reason = SNES_DIVERGED_LOCAL_MIN;
  if (*reason == SNES_CONVERGED_FNORM_RELATIVE) {
    PetscCall(IsBalanced(solver, fnorm, &balanced));
    if (!balanced) *reason = SNES_CONVERGED_ITERATING;
  }
  if (*reason > 0 && MpmTermsHold(solver->disc->terms)) *reason = SNES_CONVERGED_ITERATING;
  if (!it) solver->cache.imbalance = PETSC_INFINITY;
  if (MpmTermsTraits(solver->disc->terms) & MPM_TERM_UNKNOWNS) PetscCall(TestBodies(snes, solver, reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* More where each one leads downhill: a step that is far too long gets there, which cuts would not do sooner. */
#define ITERATIONS          25
#define ITERATIONS_DOWNHILL 50

PetscErrorCode MpmNewtonAttach(MpmSolver *solver)
{
  SNESLineSearch search;

  PetscFunctionBeginUser;
  PetscCall(SNESSetType(solver->snes, SNESNEWTONLS));
  PetscCall(SNESSetTolerances(solver->snes, PETSC_DEFAULT, 1e-8, 0.,
                              solver->cache.minimisation.on ? ITERATIONS_DOWNHILL : ITERATIONS, PETSC_DEFAULT));
  PetscCall(SNESSetDivergenceTolerance(solver->snes, 1e12));
  PetscCall(SNESGetLineSearch(solver->snes, &search));
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  PetscCall(MpmLineSearchShellSet(search, MpmLineSearch, solver));
  PetscCall(SNESSetConvergenceTest(solver->snes, TestConvergence, solver, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmNewtonSetMats(MpmSolver *solver)
{
  PetscFunctionBeginUser;
  PetscCall(SNESSetFunction(solver->snes, solver->f, FormFunction, solver));
  if (solver->cache.minimisation.on) PetscCall(SNESSetObjective(solver->snes, MpmObjective, solver));
  PetscCall(SNESSetJacobian(solver->snes, solver->shell ? solver->shell : solver->jacobian,
                            solver->jacobian ? solver->jacobian : solver->shell, FormJacobian, solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}
