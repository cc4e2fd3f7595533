/*
  Limited-memory quasi-Newton steps with bounds, by the gradient alone: PETSc's TAOBLMVM, for many parameters.

  Parameters are counted in sizes of their start. All ranks take the steps alike. A run that fails has a parabola about
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

typedef struct {
  MpmInverse   *inverse;
  MpmEvaluation at, *best, *now; /* the last run, that of the last iteration, and the one asked for */
  PetscReal    *size, *last;     /* sizes; parameters of the last iteration, in them */
  PetscInt      first;
} Search;

/* True where the run is one with these parameters, but for rounding. */
static PetscBool IsOf(const MpmEvaluation *at, PetscInt count, const PetscReal t[])
{
  for (PetscInt k = 0; k < count; k++)
    if (!at->t || PetscAbsReal(at->t[k] - t[k]) > 4. * PETSC_MACHINE_EPSILON * PetscAbsReal(t[k])) return PETSC_FALSE;
  return PETSC_TRUE;
}

static PetscErrorCode Evaluate(Search *search, const PetscReal z[])
{
  MpmInverse    *inverse = search->inverse;
  const PetscInt count   = inverse->problem.count;
  PetscReal     *t;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(count, &t));
  for (PetscInt k = 0; k < count; k++) t[k] = z[k] * search->size[k];
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
  const PetscReal     *z, *best = search->best->t;
  const MpmEvaluation *now;
  PetscReal           *g, distance = 0.;

  (void)tao;
  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &z));
  PetscCall(VecGetArray(gradient, &g));
  PetscCall(Evaluate(search, z));
  now        = search->now;
  *objective = now->objective;
  for (PetscInt k = 0; k < count; k++) distance += PetscSqr(z[k] - best[k] / search->size[k]);
  if (now->failed) *objective = 2. * PetscAbsReal(search->best->objective) + search->best->objective;
  for (PetscInt k = 0; k < count; k++)
    g[k] = now->failed ? 4. * PetscAbsReal(search->best->objective) * (z[k] - best[k] / search->size[k]) / distance
                       : now->gradient[k] * search->size[k];
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
  if (inverse->converged || inverse->interrupted) PetscCall(TaoSetConvergedReason(tao, TAO_CONVERGED_USER));
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
    lower[k] = PetscMax(lower[k] / search->size[k], PETSC_NINFINITY);
    upper[k] = PetscMin(upper[k] / search->size[k], PETSC_INFINITY);
  }
  PetscCall(VecRestoreArray(low, &lower));
  PetscCall(VecRestoreArray(high, &upper));
  PetscCall(TaoSetVariableBounds(tao, low, high));
  PetscCall(VecDestroy(&low));
  PetscCall(VecDestroy(&high));
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
  PetscCall(TaoSetFromOptions(tao));
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

PetscErrorCode MpmBlmvmRun(MpmInverse *inverse, MpmEvaluation *at)
{
  const PetscInt count  = inverse->problem.count;
  Search         search = {.inverse = inverse, .best = at, .first = MpmInverseFirst(inverse)};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(count, &search.size, count, &search.last));
  for (PetscInt k = 0; k < count; k++) {
    search.size[k] = MpmInverseSize(inverse, at->t, k);
    search.last[k] = at->t[k] / search.size[k];
  }
  PetscCall(Solve(&search));
  PetscCall(MpmEvaluationDestroy(&search.at));
  PetscCall(PetscFree2(search.size, search.last));
  PetscFunctionReturn(PETSC_SUCCESS);
}
