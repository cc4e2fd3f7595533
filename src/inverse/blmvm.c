/*
  Limited-memory quasi-Newton steps with bounds, by the gradient alone: PETSc's TAOBLMVM, for many parameters.

  Parameters are counted in sizes of their start: t = size z. Values of a field with a prior are those of independent
  numbers z, t = t_0 + s L z with the prior's covariance s^2 L L^T: a step along the gradient by z is as smooth as the
  prior is. All ranks take the steps alike. A run that fails has a parabola about
  the best parameters in place of its objective, from which the line search steps back.
*/
#include <petsctao.h>
#include "inverse/analysis.h"

/* A monitor of TAO's, renamed in 3.21. */
#if PETSC_VERSION_LT(3, 21, 0)
#define MpmTaoMonitorSet TaoSetMonitor
#else
#define MpmTaoMonitorSet TaoMonitorSet
#endif

#define HISTORY 30 /* steps that are kept: few against runs in time and memory */
#define LEAST   5  /* PETSc's default */

typedef struct {
  MpmInverse   *inverse;
  MpmEvaluation at, *best, *now; /* the last run, that of the last iteration, and the one asked for */
  PetscReal    *size, *last;     /* sizes; z of the last iteration */
  PetscReal    *origin;          /* t where z is 0 */
  PetscBool    *spread;          /* by regularization: its field's z are those of its prior */
  PetscInt      first;
} Search;

/* True where the run is one with these parameters, but for rounding. */
static PetscBool IsOf(const MpmEvaluation *at, PetscInt count, const PetscReal t[])
{
  for (PetscInt k = 0; k < count; k++)
    if (!at->t || PetscAbsReal(at->t[k] - t[k]) > 4. * PETSC_MACHINE_EPSILON * PetscAbsReal(t[k])) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* t of z; `transposed`: derivatives by z from those by t, in the same place. */
static PetscErrorCode Map(const Search *search, PetscBool transposed, PetscReal z[])
{
  const MpmInverseProblem *problem = &search->inverse->problem;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < problem->count; k++) z[k] *= search->size[k];
  for (PetscInt n = 0; n < problem->penalties; n++)
    if (search->spread[n]) PetscCall(MpmPenaltySpread(&problem->penalty[n], transposed, &z[problem->penalty[n].first]));
  for (PetscInt k = 0; k < problem->count && !transposed; k++) z[k] += search->origin[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Evaluate(Search *search, const PetscReal z[])
{
  MpmInverse    *inverse = search->inverse;
  const PetscInt count   = inverse->problem.count;
  PetscReal     *t;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &t));
  PetscCall(PetscArraycpy(t, z, count));
  PetscCall(Map(search, PETSC_FALSE, t));
  search->now = IsOf(search->best, count, t) ? search->best : &search->at;
  if (!IsOf(search->now, count, t)) {
    PetscCall(MpmInverseEvaluate(&inverse->problem, t, MPM_GRADIENT_ONLY, PETSC_INFINITY, &search->at));
    inverse->interrupted = search->at.interrupted;
  }
  PetscCall(PetscFree(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FormGradient(Tao tao, Vec x, PetscReal *objective, Vec gradient, void *ctx)
{
  Search              *search = (Search *)ctx;
  const PetscInt       count  = search->inverse->problem.count;
  const PetscReal     *z, *last = search->last, least = search->best->objective;
  const MpmEvaluation *now;
  PetscReal           *g, distance = 0.;

  (void)tao;
  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &z));
  PetscCall(VecGetArray(gradient, &g));
  PetscCall(Evaluate(search, z));
  now        = search->now;
  *objective = now->objective;
  for (PetscInt k = 0; k < count; k++) distance += PetscSqr(z[k] - last[k]);
  if (now->failed) {
    *objective = 2. * PetscAbsReal(least) + least;
    for (PetscInt k = 0; k < count; k++) g[k] = 4. * PetscAbsReal(least) * (z[k] - last[k]) / distance;
  } else {
    PetscCall(PetscArraycpy(g, now->gradient, count));
    PetscCall(Map(search, PETSC_TRUE, g));
  }
  PetscCall(VecRestoreArray(gradient, &g));
  PetscCall(VecRestoreArrayRead(x, &z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Reports an iteration, whose parameters have been evaluated last or are the best. */
static PetscErrorCode Monitor(Tao tao, void *ctx)
{
  Search          *search  = (Search *)ctx;
  MpmInverse      *inverse = search->inverse;
  const PetscInt   count   = inverse->problem.count;
  const PetscReal *z;
  PetscReal        change = 0.;
  PetscInt         iteration;
  PetscBool        stop;
  Vec              x;

  PetscFunctionBeginUser;
  PetscCall(TaoGetIterationNumber(tao, &iteration));
  PetscCall(TaoGetSolution(tao, &x));
  PetscCall(VecGetArrayRead(x, &z));
  if (!inverse->interrupted) PetscCall(Evaluate(search, z));
  for (PetscInt k = 0; k < count; k++) {
    change          = PetscMax(change, PetscAbsReal(z[k] - search->last[k]));
    search->last[k] = z[k];
  }
  PetscCall(VecRestoreArrayRead(x, &z));
  if (search->now == &search->at && !search->at.failed) {
    MpmEvaluation other = *search->best;

    *search->best = search->at;
    search->at    = other;
    search->now   = search->best;
  }
  if (!search->now->failed) PetscCall(MpmInverseReport(inverse, iteration + search->first, search->now, &stop));
  if (iteration && change < inverse->settings->tolerance) inverse->converged = PETSC_TRUE;
  if (inverse->converged || inverse->interrupted || inverse->met)
    PetscCall(TaoSetConvergedReason(tao, TAO_CONVERGED_USER));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SetBounds(const Search *search, Tao tao, Vec x)
{
  const MpmParameterRanges *ranges = search->inverse->problem.ranges;
  Vec                       low, high;
  PetscReal                *lower, *upper;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(x, &low));
  PetscCall(VecDuplicate(x, &high));
  PetscCall(VecGetArray(low, &lower));
  PetscCall(VecGetArray(high, &upper));
  for (PetscInt k = 0; k < ranges->count; k++) {
    MpmRangeBounds(&ranges->at[k], &lower[k], &upper[k]);
    lower[k] = PetscMax((lower[k] - search->origin[k]) / search->size[k], PETSC_NINFINITY);
    upper[k] = PetscMin((upper[k] - search->origin[k]) / search->size[k], PETSC_INFINITY);
  }
  PetscCall(VecRestoreArray(low, &lower));
  PetscCall(VecRestoreArray(high, &upper));
  PetscCall(TaoSetVariableBounds(tao, low, high));
  PetscCall(VecDestroy(&low));
  PetscCall(VecDestroy(&high));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options of the caller; without one the history is longer than PETSc's, which has no other way to set it. */
static PetscErrorCode Configure(Tao tao, PetscInt count)
{
  static const char name[] = "-inverse_tao_blmvm_mat_lmvm_hist_size";
  char              text[MPM_NUMBER_TEXT];
  PetscBool         given;

  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(NULL, NULL, name, &given));
  PetscCall(PetscSNPrintf(text, sizeof(text), "%" PetscInt_FMT, PetscClipInterval(count, LEAST, HISTORY)));
  if (!given) PetscCall(PetscOptionsSetValue(NULL, name, text));
  PetscCall(TaoSetFromOptions(tao));
  if (!given) PetscCall(PetscOptionsClearValue(NULL, name));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Solve(Search *search)
{
  const MpmInverse  *inverse = search->inverse;
  Tao                tao;
  TaoConvergedReason why;
  Vec                x;

  PetscFunctionBeginUser;
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, inverse->problem.count, &x));
  for (PetscInt k = 0; k < inverse->problem.count; k++) PetscCall(VecSetValue(x, k, search->last[k], INSERT_VALUES));
  PetscCall(VecAssemblyBegin(x));
  PetscCall(VecAssemblyEnd(x));
  PetscCall(TaoCreate(PETSC_COMM_SELF, &tao));
  PetscCall(TaoSetOptionsPrefix(tao, "inverse_"));
  PetscCall(TaoSetType(tao, TAOBLMVM));
  PetscCall(TaoSetSolution(tao, x));
  PetscCall(SetBounds(search, tao, x));
  PetscCall(TaoSetObjectiveAndGradient(tao, NULL, FormGradient, search));
  PetscCall(MpmTaoMonitorSet(tao, Monitor, search, NULL));
  PetscCall(TaoSetTolerances(tao, 0., 0., inverse->settings->tolerance));
  PetscCall(TaoSetMaximumIterations(tao, inverse->settings->iterations - search->first));
  PetscCall(Configure(tao, inverse->problem.count));
  PetscCall(TaoSolve(tao));
  PetscCall(TaoGetConvergedReason(tao, &why));
  search->inverse->converged = (PetscBool)(!inverse->interrupted && why > 0);
  search->inverse->reason    = inverse->converged           ? "the parameters stay within the tolerance"
                               : why == TAO_DIVERGED_MAXITS ? "the iterations are used up"
                                                            : "no step has a smaller objective";
  PetscCall(TaoDestroy(&tao));
  PetscCall(VecDestroy(&x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where no value of a regularization's field has bounds. */
static PetscBool IsFree(const MpmInverseProblem *problem, const MpmPenalty *penalty)
{
  for (PetscInt k = penalty->first; k < penalty->first + penalty->count; k++) {
    PetscReal lower, upper;

    MpmRangeBounds(&problem->ranges->at[k], &lower, &upper);
    if (lower > PETSC_NINFINITY || upper < PETSC_INFINITY) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* Sizes, origins and z at the start. */
static PetscErrorCode Begin(Search *search, const PetscReal t[])
{
  const MpmInverseProblem *problem = &search->inverse->problem;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < problem->count; k++) {
    search->size[k]   = MpmInverseSize(search->inverse, t, k);
    search->origin[k] = 0.;
    search->last[k]   = t[k] / search->size[k];
  }
  for (PetscInt n = 0; n < problem->penalties; n++) {
    const MpmPenalty *penalty = &problem->penalty[n];

    search->spread[n] = (PetscBool)(penalty->factor && IsFree(problem, penalty));
    for (PetscInt k = 0; k < n; k++)
      if (search->spread[k] && problem->penalty[k].first == penalty->first) search->spread[n] = PETSC_FALSE;
    for (PetscInt k = penalty->first; search->spread[n] && k < penalty->first + penalty->count; k++) {
      search->size[k]   = 1.;
      search->origin[k] = t[k];
      search->last[k]   = 0.;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBlmvmRun(MpmInverse *inverse, MpmEvaluation *at)
{
  const PetscInt count  = inverse->problem.count;
  Search         search = {.inverse = inverse, .best = at, .first = MpmInverseFirst(inverse)};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc4(count, &search.size, count, &search.last, count, &search.origin,
                         inverse->problem.penalties + 1, &search.spread));
  PetscCall(Begin(&search, at->t));
  PetscCall(Solve(&search));
  PetscCall(MpmEvaluationDestroy(&search.at));
  PetscCall(PetscFree4(search.size, search.last, search.origin, search.spread));
  PetscFunctionReturn(PETSC_SUCCESS);
}
