/*
  Convergence of Newton's method: residual relative to that at zero displacement, for any start, with a floor of
  rounding; balance of the forces of contact and supports; stagnation.
*/
#include "point/layout.h"
#include "point/material.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "assembly/terms.h"
#include "volume/inertia.h"
#include "problem/discretization.h"
#include "problem/fields.h"
#include "solve/line_search.h"

/* Stiffness of the firmest contact against a node, N/m. */
static PetscReal Contact(const MpmSolver *solver)
{
  const MpmDiscretization *disc    = solver->disc;
  PetscReal                modulus = 0.;

  for (PetscInt m = 0; m < disc->material.count; m++)
    modulus = PetscMax(modulus, disc->sum->materials[m].moduli.penalty);
  return MpmNodeStiffness(disc, MpmTermsFirmness(disc->terms) * modulus);
}

#define BODY_IMBALANCE 1e-12 /* of a body's loads */

/*
  A free body's few equations are a small share of all, and may be off by more than that share: iterations go on until
  these equations are met, or stagnate.
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
  Rounding error of the residual at x, which cannot be reduced further. Strains are known to eps and to eps |u|/h, the
  last from the differences of nodal values; times stiffness and a node's share of volume that is eps K (h + |u|) a
  node. A boundary's penalty adds that of the rounding of places.
*/
static PetscReal Floor(const MpmSolver *solver, PetscReal xnorm)
{
  const PetscReal unknowns = (PetscReal)(MpmNodesTotal(solver->disc) * solver->disc->block);
  const PetscReal cells    = solver->disc->h[0] * PetscSqrtReal(unknowns); /* a cell a node */
  const PetscReal size     = PetscMin(xnorm, 16. * cells); /* a node gone astray must not raise the floor */

  return PETSC_MACHINE_EPSILON * (2. * solver->disc->matrix.diagonal + 0.5 * Contact(solver)) * (cells + size);
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

#define ROUGH 1e4 /* times the tolerance */

/* Converged where a residual with this norm is small enough. */
static PetscErrorCode TestNorm(MpmSolver *solver, PetscReal xnorm, PetscReal fnorm, SNESConvergedReason *reason)
{
  PetscReal atol, rtol;

  PetscFunctionBeginUser;
  PetscCall(SNESGetTolerances(solver->snes, &atol, &rtol, NULL, NULL, NULL));
  if (MpmFieldsHaveNorms(solver->disc->layout)) {
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

/* stagnation: so many iterations have not reduced the least residual to this fraction */
#define STALL      6
#define STALL_GAIN 0.9

/* True on stagnation of Newton's method. Where contact alternates between states it lasts for ever. */
static PetscBool Stalls(MpmEvaluations *cache, PetscInt it, PetscReal fnorm)
{
  if (!it || fnorm < STALL_GAIN * cache->stagnation.least) {
    cache->stagnation.least    = fnorm;
    cache->stagnation.least_at = it;
  }
  return (PetscBool)(it - cache->stagnation.least_at >= STALL);
}

/* With contact a prediction is an answer only where it is so much better than required of an iteration: forces
   balance. */
#define PREDICTION 1e-3

/* Tolerance of the balance relative to the driving forces, and bound of the iterations taken for it alone. */
#define BALANCE      1e-6
#define BALANCE_MOST 12

/*
  Squares of the reactions, N2, of the owned unknowns with prescribed motion, in a step without inertia whose only
  unknown is the displacement. The residual is that of the last iterate.
*/
static PetscErrorCode ReactionSquares(const MpmDiscretization *disc, PetscReal *squares)
{
  const MpmConstraints *constraints = disc->constraints;
  const PetscInt        owned       = MpmNodesOwned(disc) * disc->block;
  const PetscReal      *force       = disc->nodal.residual;
  PetscReal            *turned      = NULL;

  PetscFunctionBeginUser;
  *squares = 0.;
  if (!constraints->any || disc->context.inertia->active || !MpmFieldsDoWork(disc->layout) || !disc->layout->motion)
    PetscFunctionReturn(PETSC_SUCCESS);
  if (constraints->frame_of) {
    PetscCall(PetscMalloc1(owned, &turned));
    PetscCall(PetscArraycpy(turned, force, owned));
    MpmFramesToUnknowns(constraints, disc->block, MpmNodesOwned(disc), turned);
    force = turned;
  }
  for (PetscInt k = 0; k < owned; k++)
    if (!MpmConstraintsFree(constraints, k) && constraints->value[k] != 0.) *squares += PetscSqr(force[k]);
  PetscCall(PetscFree(turned));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  True where the forces of contacts, and of prescribed motions, are in balance. A motion makes the residual at rest
  large, and with it the tolerance, however small its force.
*/
static PetscErrorCode IsBalanced(MpmSolver *solver, PetscReal fnorm, PetscBool *balanced)
{
  const MpmDiscretization *disc    = solver->disc;
  PetscReal                squares = 0.;

  PetscFunctionBeginUser;
  PetscCall(ReactionSquares(disc, &squares));
  *balanced = (PetscBool)(solver->cache.rough || solver->cache.balances == BALANCE_MOST);
  if (*balanced) PetscFunctionReturn(PETSC_SUCCESS);
  if (MpmSolverHasContact(solver)) PetscCall(MpmTermsAddSquares(disc->terms, disc->sum, disc->nodal.u, &squares));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &squares, 1, MPIU_REAL, MPIU_SUM, disc->comm));
  *balanced = (PetscBool)(!(squares > 0.) || fnorm <= BALANCE * PetscSqrtReal(squares));
  if (!*balanced) solver->cache.balances++;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmNewtonConverged(SNES snes, PetscInt it, PetscReal xnorm, PetscReal snorm, PetscReal fnorm,
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
  if (Stalls(&solver->cache, it, fnorm) && solver->cache.stagnation.stops && *reason == SNES_CONVERGED_ITERATING)
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
