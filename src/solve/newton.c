/*
  Newton's parts: residual and Jacobian as SNES calls them, when a step has converged, and the line search.
*/
#include <petsc/private/petscimpl.h> /* PetscObjectStateGet() */
#include "point/layout.h"
#include "point/material.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"
#include "terms/discretization.h"
#include "terms/body_contact.h"
#include "terms/contact.h"
#include "terms/inertia.h"
#include "terms/rigid_body.h"
#include "terms/sparsity.h"
#include "terms/terms.h"
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
  solver->cache.made_count++;
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
static PetscBool KeepJacobian(const MpmSolver *solver, PetscInt it, PetscReal fnorm, PetscReal target)
{
  if (!solver->cache.solving || !solver->cache.lag || !it || solver->cache.lagged || !solver->cache.assembled)
    return PETSC_FALSE;
  return (PetscBool)(fnorm * fnorm <= 0.3 * target * solver->cache.fnorm_last);
}

static PetscErrorCode FormJacobian(SNES snes, Vec x, Mat J, Mat P, void *ctx)
{
  MpmSolver     *solver = (MpmSolver *)ctx;
  PetscLogDouble since;
  PetscReal      fnorm = 0., rtol;
  PetscInt       it;
  PetscBool      keep;

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(snes, &it));
  PetscCall(SNESGetFunctionNorm(snes, &fnorm));
  PetscCall(SNESGetTolerances(snes, NULL, &rtol, NULL, NULL, NULL));
  if (solver->disc->layout->field_count > 1) {
    fnorm = solver->cache.fields.excess;
    keep  = KeepJacobian(solver, it, fnorm, 1.);
  } else keep = KeepJacobian(solver, it, fnorm, rtol * solver->cache.reference);
  solver->cache.fnorm_last = fnorm;
  solver->cache.lagged     = keep;
  if (keep) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmMonitorBegin(solver->monitor, MPM_TIME_JACOBIAN, &since));
  if (solver->jacobian) PetscCall(AssembleJacobian(solver, x, P));
  if (solver->shell) PetscCall(MpmMatfreeSetState(J, x));
  PetscCall(MpmMonitorEnd(solver->monitor, MPM_TIME_JACOBIAN, since));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stiffness of the firmest boundary against a node, N/m. */
static PetscReal Contact(const MpmSolver *solver)
{
  const MpmDiscretization *disc     = solver->disc;
  const MpmContacts       *contacts = disc->contacts;
  PetscReal                penalty = 0., modulus = 0.;

  for (PetscInt k = 0; contacts->newton.near && k < contacts->boundary_count; k++)
    penalty = PetscMax(penalty, contacts->boundaries[k].penalty);
  for (PetscInt m = 0; m < disc->material_count; m++) modulus = PetscMax(modulus, disc->sum->materials[m].penalty);
  return penalty * modulus * PetscPowRealInt(solver->disc->h[0], solver->disc->dim - 2);
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
  PetscCall(MpmRigidImbalance(solver->disc->contacts, solver->disc->space, solver->disc->block, values,
                              solver->disc->comm, &solver->cache.imbalance));
  PetscCall(VecRestoreArrayRead(f, &values));
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

/* Residual over tolerance where there are several fields. */
static PetscErrorCode FindExcess(MpmSolver *solver, Vec x, Vec f, PetscReal *excess)
{
  PetscReal rtol, xnorm;

  PetscFunctionBeginUser;
  PetscCall(SNESGetTolerances(solver->snes, NULL, &rtol, NULL, NULL, NULL));
  PetscCall(VecNorm(x, NORM_2, &xnorm));
  PetscCall(MpmFieldsConverged(solver, f, rtol, Floor(solver, xnorm), excess));
  PetscFunctionReturn(PETSC_SUCCESS);
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
    PetscCall(FindExcess(solver, x, f, &solver->cache.fields.excess));
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
  if (MpmSolverHasContact(solver)) {
    PetscCall(MpmContactsAddSquares(disc->contacts, disc->sum, disc->u, &squares));
    MpmPairsAddSquares(disc->pairs, disc->sum, disc->u, &squares);
  }
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
  if (*reason > 0 && (solver->disc->contacts->newton.holds || solver->disc->pairs->holds))
    *reason = SNES_CONVERGED_ITERATING;
  if (!it) solver->cache.imbalance = PETSC_INFINITY;
  if (solver->disc->contacts->bodies) PetscCall(TestBodies(snes, solver, reason));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- line search ---- */

/* a step is too long when it raises both the residual and, this much, the slope's size; less patience in later iterations */
#define LINE_SEARCH_RATIO    2.
#define LINE_SEARCH_PATIENT  2
#define LINE_SEARCH_LATER    1.
#define LINE_SEARCH_TRIALS   8
#define LINE_SEARCH_SHORTEST 0.02
#define LINE_SEARCH_OVERSHOT 0.3 /* with contact: so much of the slope, with the other sign, in later iterations */
/* with contact: a slope so many times as large, with the other sign, comes from a stiff kink; and what is progress */
#define EXCURSION_KINK 30.
#define EXCURSION_GAIN 0.9

/* with care, the zero of the slope is looked for in a bracket: */
#define BRACKET_OVERSHOT 0.3 /* so much of the slope, with the other sign, may be left in later iterations */
#define BRACKET_SLOPE    0.5 /* once there is a bracket, so much of it at most */
#define BRACKET_EDGE     0.1 /* no trial is nearer to an end than this part of the bracket */
#define BRACKET_TRIALS   20
#define BRACKET_REFUSED  12  /* trials until one has an answer */
#define BRACKET_FLAT     0.9 /* of the slope, and of the residual: a step that leaves as much is far too short, */
#define BRACKET_LONGER   4.  /* and is tried so many times as long, */
#define BRACKET_LONGEST  1e5 /* up to this */
#define BRACKET_GROWTH   2.  /* of the residual, where the slope says nothing */
#define BRACKET_HALVES   5

/* Will a new Jacobian be asked for after this iteration? Steps are much like the last one. */
static PetscErrorCode LookAhead(MpmSolver *solver, SNES snes)
{
  PetscInt it;

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(snes, &it));
  solver->cache.ahead = (PetscBool)(solver->cache.solving && it + 1 < solver->cache.made_count_last);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bodies that an iterate x has left far from balance come to rest on the material there; `last`: the one before, or NULL. */
PetscErrorCode MpmRelaxBodies(MpmSolver *solver, Vec last, Vec x)
{
  const PetscScalar *before = NULL;
  PetscScalar       *values;

  PetscFunctionBeginUser;
  if (!solver->disc->contacts->bodies) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmGatherSolution(solver, x));
  if (last) PetscCall(VecGetArrayRead(last, &before));
  PetscCall(VecGetArray(x, &values));
  PetscCall(MpmRigidRelax(solver->disc->contacts, solver->disc->sum, solver->disc->u, (PetscBool)(last != NULL), before,
                          values));
  PetscCall(VecRestoreArray(x, &values));
  if (last) PetscCall(VecRestoreArrayRead(last, &before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSearchTry(MpmSearch *search)
{
  PetscFunctionBeginUser;
  PetscCall(VecWAXPY(search->W, -search->lambda, search->Y, search->X));
  PetscCall(MpmRelaxBodies(search->solver, search->X, search->W));
  PetscCall(SNESComputeFunction(search->solver->snes, search->W, search->G));
  PetscCall(VecNorm(search->G, NORM_2, &search->norm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmSolverHasContact(const MpmSolver *solver)
{
  return solver->disc->contacts->newton.near;
}

/* Is there contact, and has a step gone well beyond the zero of the slope? */
static PetscBool Overshot(const MpmSolver *solver, PetscInt it, PetscReal start, PetscReal slope)
{
  return (PetscBool)(MpmSolverHasContact(solver) && it >= LINE_SEARCH_PATIENT && start > 0. &&
                     slope < -LINE_SEARCH_OVERSHOT * start);
}

PetscErrorCode MpmExcursionEnd(MpmExcursion *excursion)
{
  PetscFunctionBeginUser;
  PetscCall(VecDestroy(&excursion->x));
  PetscCall(VecDestroy(&excursion->y));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A full step: residuals' norms and slopes at its start and its end. */
typedef struct {
  PetscReal norm_start, start, norm, slope;
} FullStep;

/*
  Where a penalty is stiff, the slope's zero lies where the first patch touches, and a line search that stops there takes an
  iteration a patch. Full steps, each of which finds the patches that touch after the last one, get on: so one is taken although the slope
  forbids it, another may follow, and more as long as the residual falls. When it rises, and is not below what it was at first,
  `back` says to return to the start, *step becomes that first one, and the line search has its way.
*/
static PetscErrorCode Excursion(MpmSolver *solver, Vec X, Vec Y, FullStep *step, PetscBool fine, PetscBool *take,
                                PetscBool *back)
{
  MpmExcursion *excursion = &solver->excursion;

  PetscFunctionBeginUser;
  *take = *back = PETSC_FALSE;
  if (excursion->x && step->norm <= EXCURSION_GAIN * excursion->norm) PetscCall(MpmExcursionEnd(excursion));
  if (excursion->x && !excursion->more && step->norm > step->norm_start) {
    *back = PETSC_TRUE;
    PetscCall(VecCopy(excursion->x, X));
    PetscCall(VecCopy(excursion->y, Y));
    *step = (FullStep){excursion->norm, excursion->start, step->norm, excursion->slope};
    PetscCall(MpmExcursionEnd(excursion));
  } else if (excursion->x) {
    excursion->more = PETSC_FALSE;
    *take           = PETSC_TRUE;
  } else if (fine) *take = PETSC_TRUE;
  else if (MpmSolverHasContact(solver) && step->norm > step->norm_start &&
           step->slope < -EXCURSION_KINK * step->start) {
    PetscCall(VecDuplicate(X, &excursion->x));
    PetscCall(VecDuplicate(Y, &excursion->y));
    PetscCall(VecCopy(X, excursion->x));
    PetscCall(VecCopy(Y, excursion->y));
    excursion->norm  = step->norm_start;
    excursion->start = step->start;
    excursion->slope = step->slope;
    excursion->more  = PETSC_TRUE;
    *take            = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Where a line search has been: lengths with a slope downhill and uphill of its zero (-1: none yet), the slopes, and which end moved
  last (-1: none).
*/
typedef struct {
  PetscReal start, at[2], slope[2];
  PetscInt  moved;
} Bracket;

/* The next length in the bracket: by regula falsi; its middle where an end moves twice. */
static void Narrow(Bracket *bracket, PetscReal slope, PetscReal *lambda)
{
  const PetscInt uphill = slope < 0.;
  PetscReal      part   = 0.5;

  bracket->at[uphill]    = *lambda;
  bracket->slope[uphill] = slope;
  if (uphill != bracket->moved) part = bracket->slope[0] / (bracket->slope[0] - bracket->slope[1]);
  bracket->moved = uphill;
  *lambda =
    bracket->at[0] + (bracket->at[1] - bracket->at[0]) * PetscClipInterval(part, BRACKET_EDGE, 1. - BRACKET_EDGE);
}

/*
  By the work: the full step costs one residual and is taken when the residual falls or the slope of the work, G . Y, does;
  otherwise the slope's zero is bracketed by regula falsi. A trial without an answer halves the step. `found`: there is one.

  A test on the residual alone would throttle bending and rotation, where a good full step raises the residual first. It
  does so at the solution's start only; in plastic flow without change of volume, steps that later raise the slope's size
  run away (a footing on clay: 63 iterations and two cuts in place of 24).

  Where contact sticks, slips or opens from one iterate to the next, full steps may go to and fro over a kink for ever, each
  with a slope as large as the last and of the other sign, and a residual that falls on every other one. So there the slope
  has to be less after a step than before. Between two that slide to and fro the zero is a kink, where it sticks: one interpolation
  gets a part of the way there, 1/2, 1/3, 1/4 ... from one iteration to the next, and the bracket is narrowed instead.
*/
static PetscErrorCode SearchByWork(MpmSearch *search, PetscBool *found)
{
  const PetscReal ratio   = search->it < LINE_SEARCH_PATIENT ? LINE_SEARCH_RATIO : LINE_SEARCH_LATER;
  FullStep        step    = {.norm_start = search->fnorm};
  Bracket         bracket = {.at = {0., -1.}, .moved = -1};
  PetscScalar     dot;
  PetscBool       take, stalls, back = PETSC_FALSE;

  PetscFunctionBeginUser;
  *found = PETSC_TRUE;
  if (!search->it) PetscCall(MpmExcursionEnd(&search->solver->excursion));
  PetscCall(VecDot(search->F, search->Y, &dot));
  step.start = bracket.start = bracket.slope[0] = PetscRealPart(dot);
  for (PetscInt trial = 0;; trial++) {
    PetscCall(MpmSearchTry(search));
    if (PetscIsInfOrNanReal(search->norm)) {
      *found = (PetscBool)(trial < LINE_SEARCH_TRIALS);
      if (!*found) break;
      search->lambda = 0.5 * search->lambda;
      continue;
    }
    PetscCall(VecDot(search->G, search->Y, &dot));
    step.norm  = search->norm;
    step.slope = PetscRealPart(dot);
    if (trial >= LINE_SEARCH_TRIALS) break;
    take =
      (PetscBool)(!Overshot(search->solver, search->it, step.start, step.slope) &&
                  (step.norm <= step.norm_start || step.start <= 0. || PetscAbsReal(step.slope) <= ratio * step.start));
    if (search->lambda == 1. && !back) {
      PetscCall(Excursion(search->solver, search->X, search->Y, &step, take, &take, &back));
      if (back) {
        search->lambda = PetscMax(step.start / (step.start - step.slope), LINE_SEARCH_SHORTEST);
        continue;
      }
    }
    stalls = (PetscBool)(MpmSolverHasContact(search->solver) && bracket.at[1] >= 0. &&
                         step.slope > BRACKET_SLOPE * step.start);
    if (stalls || (!take && step.slope <= 0. && bracket.at[0] > 0.)) {
      Narrow(&bracket, step.slope, &search->lambda);
      continue;
    }
    if (take || step.slope > 0.) break; /* slope > 0: still downhill */
    /* overshot: the zero lies between 0 and this length */
    bracket.at[1]        = search->lambda;
    bracket.slope[1]     = step.slope;
    const PetscReal next = search->lambda * step.start / (step.start - step.slope);

    if (next < LINE_SEARCH_SHORTEST) break;
    search->lambda = PetscMin(next, 0.9 * search->lambda);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Is the residual at search->lambda, with this slope there, good enough? */
static PetscBool IsGood(const MpmSearch *search, const Bracket *bracket, PetscReal slope)
{
  const PetscBool early = (PetscBool)(search->it < LINE_SEARCH_PATIENT);

  if (bracket->start <= 0.) return (PetscBool)(search->norm <= BRACKET_GROWTH * search->fnorm);
  if (!early && slope < -BRACKET_OVERSHOT * bracket->start) return PETSC_FALSE;
  if (bracket->at[1] >= 0.) return (PetscBool)(PetscAbsReal(slope) <= BRACKET_SLOPE * bracket->start);
  return (PetscBool)(slope > 0. || search->norm <= search->fnorm ||
                     -slope <= (early ? LINE_SEARCH_RATIO : LINE_SEARCH_LATER) * bracket->start);
}

/*
  Has a length changed nothing, with none yet uphill? So it is where all of a body slides: the zero is where some of it sticks, farther on.
*/
static PetscBool IsFlat(const MpmSearch *search, const Bracket *bracket, PetscReal slope)
{
  return (PetscBool)(bracket->start > 0. && bracket->at[1] < 0. && slope > BRACKET_FLAT * bracket->start &&
                     search->norm > BRACKET_FLAT * search->fnorm && search->lambda >= 1. &&
                     search->lambda < BRACKET_LONGEST);
}

/*
  The same with care, for contact. Where it sticks, slips, closes or opens on the way the slope has kinks, often a thousand times as steep behind them
  as before, and full steps may go to and fro over them for ever, with a residual that falls on every other one. So the
  slope's zero is bracketed, by regula falsi that keeps off the ends. Where friction makes the slope negative at the start, it says nothing
  and the residual counts.
*/
static PetscErrorCode SearchByBracket(MpmSearch *search, PetscBool *found)
{
  Bracket     bracket = {.at = {0., -1.}, .moved = -1};
  PetscScalar dot;

  PetscFunctionBeginUser;
  *found = PETSC_TRUE;
  PetscCall(VecDot(search->F, search->Y, &dot));
  bracket.start = bracket.slope[0] = PetscRealPart(dot);
  for (PetscInt trial = 0;; trial++) {
    PetscCall(MpmSearchTry(search));
    if (PetscIsInfOrNanReal(search->norm)) {
      *found = (PetscBool)(trial < BRACKET_REFUSED);
      if (!*found) break;
      search->lambda = 0.5 * (bracket.at[0] + search->lambda);
      continue;
    }
    PetscCall(VecDot(search->G, search->Y, &dot));
    if (trial < BRACKET_TRIALS && IsFlat(search, &bracket, PetscRealPart(dot))) {
      bracket.at[0]    = search->lambda;
      bracket.slope[0] = PetscRealPart(dot);
      search->lambda *= BRACKET_LONGER;
      continue;
    }
    if (trial >= BRACKET_TRIALS || IsGood(search, &bracket, PetscRealPart(dot))) break;
    if (bracket.start <= 0.) {
      if (trial >= BRACKET_HALVES) break;
      search->lambda *= 0.5;
      continue;
    }
    Narrow(&bracket, PetscRealPart(dot), &search->lambda);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step is too long when the residual grows by more than this, early on or later; it is cut to between these parts. */
#define NORM_GROWTH       10.
#define NORM_GROWTH_LATER 1.
#define NORM_CUT_LEAST    0.2
#define NORM_CUT_MOST     0.7

/*
  By the residual: where fields are solved for that no energy has its least value at, as with a pressure that keeps the
  volume. Each field's residual counts over its own tolerance, and the one that is furthest from it. Where the step
  is too long, the next length is the minimum of the parabola through the square at 0, its slope there, and this one.
*/
static PetscErrorCode SearchByNorm(MpmSearch *search, PetscBool *found)
{
  const PetscReal growth = search->it < LINE_SEARCH_PATIENT ? NORM_GROWTH : NORM_GROWTH_LATER;
  PetscReal       start, excess;

  PetscFunctionBeginUser;
  *found = PETSC_TRUE;
  if (!search->it) PetscCall(MpmFieldsLearn(search->solver, search->X, search->Y));
  PetscCall(FindExcess(search->solver, search->X, search->F, &start));
  for (PetscInt trial = 0;; trial++) {
    PetscCall(MpmSearchTry(search));
    if (PetscIsInfOrNanReal(search->norm)) {
      *found = (PetscBool)(trial < LINE_SEARCH_TRIALS);
      if (!*found) break;
      search->lambda *= 0.5;
      continue;
    }
    PetscCall(FindExcess(search->solver, search->W, search->G, &excess));
    if (excess <= growth * start || excess <= 1. || trial >= LINE_SEARCH_TRIALS) break;
    {
      const PetscReal ratio = excess / start, lambda = search->lambda;
      const PetscReal least = lambda * lambda / (ratio * ratio - 1. + 2. * lambda);

      if (NORM_CUT_LEAST * lambda < LINE_SEARCH_SHORTEST) break;
      search->lambda = PetscMin(PetscMax(least, NORM_CUT_LEAST * lambda), NORM_CUT_MOST * lambda);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tells the contacts of the iterate that is taken; those that were held until now do otherwise there. */
static PetscErrorCode FollowContacts(MpmSearch *search)
{
  const MpmDiscretization *disc   = search->solver->disc;
  const PetscBool          held   = (PetscBool)(disc->contacts->newton.holds || disc->pairs->holds);
  const PetscBool          secant = disc->contacts->newton.secant;

  PetscFunctionBeginUser;
  if (!disc->contacts->newton.careful && !held) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmGatherSolution(search->solver, search->W));
  PetscCall(MpmContactsFollow(disc->contacts, disc->sum, disc->u));
  MpmPairsRelease(disc->pairs);
  if (secant != disc->contacts->newton.secant) search->solver->cache.summed.id = 0; /* another Jacobian */
  if (!held) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESComputeFunction(search->solver->snes, search->W, search->G));
  PetscCall(VecNorm(search->G, NORM_2, &search->norm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The program's own line search. */
static PetscErrorCode LineSearch(SNESLineSearch object, void *ctx)
{
  MpmSearch search = {.solver = (MpmSolver *)ctx, .lambda = 1.};
  MpmPlace  tried;
  SNES      snes;
  PetscReal xnorm, ynorm;
  PetscBool found;

  PetscFunctionBeginUser;
  PetscCall(SNESLineSearchGetSNES(object, &snes));
  PetscCall(LookAhead(search.solver, snes));
  PetscCall(SNESLineSearchGetVecs(object, &search.X, &search.F, &search.Y, &search.W, &search.G));
  PetscCall(SNESLineSearchGetNorms(object, &xnorm, &search.fnorm, &ynorm));
  PetscCall(SNESGetIterationNumber(snes, &search.it));
  if (search.solver->disc->layout->field_count > 1) PetscCall(SearchByNorm(&search, &found));
  else if (search.solver->careful) PetscCall(SearchByBracket(&search, &found));
  else PetscCall(SearchByWork(&search, &found));
  if (found && search.solver->cache.minimisation.on) PetscCall(MpmSearchDescend(&search, &found));
  if (!found) {
    PetscCall(SNESLineSearchSetReason(object, SNES_LINESEARCH_FAILED_NANORINF));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(FollowContacts(&search));
  PetscCall(VecNorm(search.Y, NORM_2, &ynorm));
  PetscCall(MpmPlaceGet(search.W, &tried));
  PetscCall(VecCopy(search.W, search.X));
  PetscCall(VecCopy(search.G, search.F));
  if (MpmPlaceIsSame(&tried, &search.solver->cache.summed))
    PetscCall(MpmPlaceGet(search.X, &search.solver->cache.summed)); /* the same values */
  PetscCall(MpmSearchTaken(&search));
  PetscCall(VecNorm(search.X, NORM_2, &xnorm));
  PetscCall(SNESLineSearchSetLambda(object, search.lambda));
  PetscCall(SNESLineSearchSetNorms(object, xnorm, search.norm, ynorm));
  PetscCall(SNESLineSearchSetReason(object, SNES_LINESEARCH_SUCCEEDED));
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
  PetscCall(MpmLineSearchShellSet(search, LineSearch, solver));
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
