/*
  Newton's parts: residual and Jacobian as SNES calls them, when a step has converged, and the line search.
*/
#include "mpmimpl.h"

/* Brings the solution vector to the local nodes, ghosts included, as components along the axes. */
PetscErrorCode MpmGatherSolution(MpmModel model, Vec x)
{
  const PetscScalar *values;

  PetscFunctionBeginUser;
  PetscCall(VecGetArrayRead(x, &values));
  PetscCall(PetscArraycpy(model->u, values, model->space.owned * model->layout.block));
  PetscCall(VecRestoreArrayRead(x, &values));
  PetscCall(MpmSpaceToGhosts(&model->space, model->layout.block, model->u));
  MpmFramesToAxes(&model->constraints, model->layout.block, model->space.local, model->u);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSumResidual(MpmModel model, PetscInt *failed)
{
  const PetscInt count = model->space.local * model->layout.block;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) model->residual[k] = -model->force[k];
  model->sum.trial = model->sum.rest ? NULL : &model->trial;
  PetscCall(MpmResidualLocal(&model->sum, model->u, model->residual, failed));
  PetscCall(MpmSpaceAddToOwners(&model->space, model->layout.block, model->residual));
  model->trial.made = (PetscBool)(model->sum.trial != NULL);
  if (model->trial.made) PetscCall(PetscArraycpy(model->trial.u, model->u, count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The same with the Jacobian's sums, in one pass. */
static PetscErrorCode SumBoth(MpmModel model, PetscInt *failed)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < model->space.local * model->layout.block; k++) model->residual[k] = -model->force[k];
  model->overwritten = PETSC_TRUE;
  model->trial.made  = PETSC_FALSE;
  PetscCall(MpmPatternBegin(&model->pattern, &model->space, model->jacobian));
  PetscCall(MpmJacobianLocal(&model->sum, model->u, &model->pattern, model->residual, failed));
  PetscCall(MpmSpaceAddToOwners(&model->space, model->layout.block, model->residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  f = internal - external force; on held unknowns, diagonal * (u - value). Where a point has no answer f becomes
  infinite and SNES backs off. The tangents' kernel gives the fluxes too: where a Jacobian at the same place is sure to
  follow, its sums are made in the same pass.
*/
static PetscErrorCode FormFunction(SNES snes, Vec x, Vec f, void *ctx)
{
  MpmModel           model = (MpmModel)ctx;
  const PetscInt     bs    = model->layout.block;
  const PetscScalar *at;
  PetscScalar       *values;
  PetscLogDouble     since;
  PetscInt           failed;

  PetscFunctionBeginUser;
  (void)snes;
  PetscCall(PetscTime(&since));
  PetscCall(MpmGatherSolution(model, x));
  model->made  = (PetscBool)(model->ahead && model->jacobian_type == MPM_JACOBIAN_LOCAL);
  model->ahead = PETSC_FALSE;
  if (model->made) PetscCall(SumBoth(model, &failed));
  else PetscCall(MpmSumResidual(model, &failed));
  MpmFramesToUnknowns(&model->constraints, bs, model->space.owned, model->residual);
  PetscCall(VecGetArrayRead(x, &at));
  PetscCall(VecGetArrayWrite(f, &values));
  for (PetscInt k = 0; k < model->space.owned * bs; k++) {
    values[k] = model->constraints.condition[k] < 0 ? model->residual[k]
                                                    : model->diagonal * (at[k] - model->constraints.value[k]);
  }
  PetscCall(VecRestoreArrayRead(x, &at));
  /* a rank may own no unknown of its failing points: the flag travels apart */
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &failed, 1, MPIU_INT, MPI_MAX, model->comm));
  if (failed && model->space.owned) values[0] = PETSC_INFINITY;
  PetscCall(VecRestoreArrayWrite(f, &values));
  MpmClock(model, model->made ? MPM_TIME_JACOBIAN : MPM_TIME_RESIDUAL, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A displacement unknown is weak when its diagonal is below this part of a typical one; it is raised by that part. */
#define WEAK_NODE 1e-3
#define WEAK_LIFT 1e-11

/*
  Nodes that the corner of a single domain touches have more unknowns than the point has strains: a direct solver then
  returns, in modes without energy, whatever rounding gives, and the result depends on the number of ranks. Raising the
  diagonal of weak nodes a little makes these modes zero. Newton's residual is untouched, so what it converges to is.
*/
static PetscErrorCode LiftWeakNodes(MpmModel model, Mat J)
{
  const PetscInt bs = model->layout.block, dim = model->grid.dim;
  Vec            diagonal;
  PetscScalar   *d;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(model->x, &diagonal));
  PetscCall(MatGetDiagonal(J, diagonal));
  PetscCall(VecGetArray(diagonal, &d));
  for (PetscInt k = 0; k < model->space.owned * bs; k++) {
    if (k % bs < dim && PetscAbsScalar(d[k]) < WEAK_NODE * model->diagonal) d[k] *= 1. + WEAK_LIFT;
  }
  PetscCall(VecRestoreArray(diagonal, &d));
  PetscCall(MatDiagonalSet(J, diagonal, INSERT_VALUES));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sums over points that the Jacobian consists of, in the way that was asked for. */
static PetscErrorCode SumJacobian(MpmModel model, Vec x, Mat P)
{
  PetscInt failed;

  PetscFunctionBeginUser;
  PetscCall(MpmGatherSolution(model, x));
  PetscCall(MpmPatternBegin(&model->pattern, &model->space, P));
  if (model->jacobian_type == MPM_JACOBIAN_LOCAL || model->jacobian_type == MPM_JACOBIAN_MATFREE)
    PetscCall(MpmJacobianLocal(&model->sum, model->u, &model->pattern, NULL, &failed));
  else PetscCall(MpmJacobianColoring(&model->sum, model->jacobian_type, model->u, &model->pattern, &failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AssembleJacobian(MpmModel model, Vec x, Mat P)
{
  PetscFunctionBeginUser;
  if (!model->made) PetscCall(SumJacobian(model, x, P));
  model->made = model->overwritten = PETSC_FALSE;
  model->made_count++;
  PetscCall(MpmPatternEnd(&model->pattern, &model->space, &model->constraints, model->diagonal, P));
  if (model->factorises) PetscCall(LiftWeakNodes(model, P));
  if (model->symmetric) PetscCall(MatSetOption(P, MAT_SYMMETRIC, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Will the last Jacobian do? With it the residual goes on falling by about its last factor, since that factor is the
  distance of the last iterate; a new one squares it. So the old one is kept for one iteration where that brings the
  residual to its tolerance with some room.
*/
static PetscBool KeepJacobian(const MpmModel model, PetscInt it, PetscReal fnorm, PetscReal target)
{
  if (!model->solving || !model->lag || !it || model->lagged || model->overwritten) return PETSC_FALSE;
  return (PetscBool)(fnorm * fnorm <= 0.3 * target * model->fnorm_last);
}

static PetscErrorCode FormJacobian(SNES snes, Vec x, Mat J, Mat P, void *ctx)
{
  MpmModel       model = (MpmModel)ctx;
  PetscLogDouble since;
  PetscReal      fnorm = 0., rtol;
  PetscInt       it;
  PetscBool      keep;

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(snes, &it));
  PetscCall(SNESGetFunctionNorm(snes, &fnorm));
  PetscCall(SNESGetTolerances(snes, NULL, &rtol, NULL, NULL, NULL));
  keep              = KeepJacobian(model, it, fnorm, rtol * model->reference);
  model->fnorm_last = fnorm;
  model->lagged     = keep;
  if (keep) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&since));
  if (model->jacobian) PetscCall(AssembleJacobian(model, x, P));
  if (model->shell) PetscCall(MpmMatfreeSetState(J, x));
  MpmClock(model, MPM_TIME_JACOBIAN, since);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Stiffness of the firmest boundary against a node, N/m. */
static PetscReal Contact(const MpmModel model)
{
  PetscReal penalty = 0., modulus = 0.;

  for (PetscInt k = 0; k < model->boundary_count; k++) penalty = PetscMax(penalty, model->boundaries[k].penalty);
  for (PetscInt m = 0; m < model->material_count; m++) modulus = PetscMax(modulus, model->materials[m].penalty);
  return penalty * modulus * PetscPowRealInt(model->grid.h[0], model->grid.dim - 2);
}

/*
  Relative to the residual of a step in which nothing moves, whatever the first guess; and a floor: a residual as small
  as rounding makes it cannot be reduced. Strains are known to eps and to eps |u|/h, the last from the differences of
  nodal values; times stiffness and a node's share of volume that is eps K (h + |u|) a node. A boundary's penalty adds what
  it makes of the rounding of places.
*/
static PetscErrorCode TestConvergence(SNES snes, PetscInt it, PetscReal xnorm, PetscReal snorm, PetscReal fnorm,
                                      SNESConvergedReason *reason, void *ctx)
{
  const MpmModel  model    = (MpmModel)ctx;
  const PetscReal unknowns = (PetscReal)(model->space.global_count * model->layout.block);
  const PetscReal cells    = model->grid.h[0] * PetscSqrtReal(unknowns); /* a cell a node */
  const PetscReal size     = PetscMin(xnorm, 16. * cells); /* a node gone astray must not raise the floor */
  const PetscReal floor    = PETSC_MACHINE_EPSILON * (2. * model->diagonal + 0.5 * Contact(model)) * (cells + size);
  PetscReal       atol, rtol, stol, divtol;

  PetscFunctionBeginUser;
  PetscCall(SNESGetTolerances(snes, &atol, &rtol, &stol, NULL, NULL));
  PetscCall(SNESGetDivergenceTolerance(snes, &divtol));
  if (!it && !(model->reference > 0.)) model->reference = fnorm;
  *reason = SNES_CONVERGED_ITERATING;
  if (PetscIsInfOrNanReal(fnorm)) *reason = MPM_SNES_DIVERGED_NAN;
  else if (fnorm <= PetscMax(atol, floor)) *reason = SNES_CONVERGED_FNORM_ABS;
  else if (fnorm <= rtol * model->reference) *reason = SNES_CONVERGED_FNORM_RELATIVE;
  else if (it && snorm < stol * xnorm) *reason = SNES_CONVERGED_SNORM_RELATIVE;
  else if (it && divtol > 0. && fnorm > divtol * model->reference) *reason = SNES_DIVERGED_DTOL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- line search ---- */

/* a step is too long when it raises both the residual and, this much, the slope's size; less patience in later iterations */
#define LINE_SEARCH_RATIO    2.
#define LINE_SEARCH_PATIENT  2
#define LINE_SEARCH_LATER    1.
#define LINE_SEARCH_TRIALS   8
#define LINE_SEARCH_SHORTEST 0.02

/* Will a new Jacobian be asked for after this iteration? Steps are much like the last one. */
static PetscErrorCode LookAhead(MpmModel model, SNES snes)
{
  PetscInt it;

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(snes, &it));
  model->ahead = (PetscBool)(model->solving && it + 1 < model->made_count_last);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Tries X - lambda Y: the residual there, its norm, and the slope G . Y, which is the rate of work for a potential. */
static PetscErrorCode Try(SNESLineSearch search, SNES snes, PetscReal lambda, PetscReal *norm, PetscReal *slope)
{
  Vec         X, F, Y, W, G;
  PetscScalar dot;

  PetscFunctionBeginUser;
  (void)search;
  PetscCall(SNESLineSearchGetVecs(search, &X, &F, &Y, &W, &G));
  PetscCall(VecWAXPY(W, -lambda, Y, X));
  PetscCall(SNESComputeFunction(snes, W, G));
  PetscCall(VecNorm(G, NORM_2, norm));
  *slope = 0.;
  if (PetscIsInfOrNanReal(*norm)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDot(G, Y, &dot));
  *slope = PetscRealPart(dot);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The program's own line search: the full step costs one residual and is taken when the residual falls or the slope of
  the work does; otherwise the slope's zero is bracketed by regula falsi. A trial without an answer halves the step.

  A test on the residual alone would throttle bending and rotation, where a good full step raises the residual first. It
  does so at the solution's start only; in plastic flow without change of volume, steps that later raise the slope's size
  run away (a footing on clay: 63 iterations and two cuts in place of 24).
*/
static PetscErrorCode LineSearch(SNESLineSearch search, void *ctx)
{
  Vec         X, F, Y, W, G;
  SNES        snes;
  PetscReal   xnorm, fnorm, ynorm, norm = 0., slope = 0., lambda = 1., good = 0., slope_good;
  PetscScalar dot;
  PetscInt    it;

  PetscFunctionBeginUser;
  PetscCall(SNESLineSearchGetSNES(search, &snes));
  PetscCall(LookAhead((MpmModel)ctx, snes));
  PetscCall(SNESLineSearchGetVecs(search, &X, &F, &Y, &W, &G));
  PetscCall(SNESLineSearchGetNorms(search, &xnorm, &fnorm, &ynorm));
  PetscCall(VecDot(F, Y, &dot));
  PetscCall(SNESGetIterationNumber(snes, &it));
  const PetscReal start = PetscRealPart(dot), ratio = it < LINE_SEARCH_PATIENT ? LINE_SEARCH_RATIO : LINE_SEARCH_LATER;

  slope_good = start;
  for (PetscInt trial = 0;; trial++) {
    PetscCall(Try(search, snes, lambda, &norm, &slope));
    if (PetscIsInfOrNanReal(norm)) {
      if (trial == LINE_SEARCH_TRIALS) {
        PetscCall(SNESLineSearchSetReason(search, SNES_LINESEARCH_FAILED_NANORINF));
        PetscFunctionReturn(PETSC_SUCCESS);
      }
      lambda = 0.5 * (lambda + good);
      continue;
    }
    if (norm <= fnorm || start <= 0. || PetscAbsReal(slope) <= ratio * start || trial >= LINE_SEARCH_TRIALS) break;
    if (slope > 0.) break; /* still downhill */
    /* overshot: the zero lies between the last good length and this one */
    {
      const PetscReal next = good + (lambda - good) * slope_good / (slope_good - slope);

      if (next < LINE_SEARCH_SHORTEST) break;
      lambda = PetscMin(next, 0.9 * lambda);
    }
  }
  PetscCall(VecNorm(Y, NORM_2, &ynorm));
  PetscCall(VecCopy(W, X));
  PetscCall(VecCopy(G, F));
  PetscCall(VecNorm(X, NORM_2, &xnorm));
  PetscCall(SNESLineSearchSetLambda(search, lambda));
  PetscCall(SNESLineSearchSetNorms(search, xnorm, norm, ynorm));
  PetscCall(SNESLineSearchSetReason(search, SNES_LINESEARCH_SUCCEEDED));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmNewtonAttach(MpmModel model)
{
  SNESLineSearch search;

  PetscFunctionBeginUser;
  PetscCall(SNESSetType(model->snes, SNESNEWTONLS));
  PetscCall(SNESSetTolerances(model->snes, PETSC_DEFAULT, 1e-8, 0., 25, PETSC_DEFAULT));
  PetscCall(SNESSetDivergenceTolerance(model->snes, 1e12));
  PetscCall(SNESGetLineSearch(model->snes, &search));
  PetscCall(SNESLineSearchSetType(search, SNESLINESEARCHSHELL));
  PetscCall(MpmLineSearchShellSet(search, LineSearch, model));
  PetscCall(SNESSetConvergenceTest(model->snes, TestConvergence, model, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmNewtonSetMats(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(SNESSetFunction(model->snes, model->f, FormFunction, model));
  PetscCall(SNESSetJacobian(model->snes, model->shell ? model->shell : model->jacobian,
                            model->jacobian ? model->jacobian : model->shell, FormJacobian, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}
