/*
  The line search of Newton's method: by the work, with care for contact, or by the norms of several fields.
*/
#include "point/layout.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "problem/discretization.h"
#include "problem/fields.h"
#include "solve/line_search.h"

/* a step is too long when it raises both the residual and, by this factor, the slope's magnitude; less in later
   iterations */
#define LINE_SEARCH_RATIO    2.
#define LINE_SEARCH_PATIENT  2
#define LINE_SEARCH_LATER    1.
#define LINE_SEARCH_TRIALS   8
#define LINE_SEARCH_SHORTEST 0.02
#define LINE_SEARCH_OVERSHOT 0.3 /* with contact: so much of the slope, with the other sign, in later iterations */
/* with contact: a slope so many times as large, of opposite sign, comes from a stiff kink; measure of progress */
#define EXCURSION_KINK 30.
#define EXCURSION_GAIN 0.9

/* with care, the zero of the slope is looked for in a bracket: */
#define BRACKET_OVERSHOT 0.3 /* accepted ratio of the slope, of opposite sign, in later iterations */
#define BRACKET_SLOPE    0.5 /* once there is a bracket, so much of it at most */
#define BRACKET_EDGE     0.1 /* no trial is nearer to an end than this part of the bracket */
#define BRACKET_TRIALS   20
#define BRACKET_REFUSED  12  /* trials until one has an answer */
#define BRACKET_FLAT     0.9 /* of the slope, and of the residual: a step that leaves as much is far too short, */
#define BRACKET_LONGER   4.  /* and is tried so many times as long, */
#define BRACKET_LONGEST  1e5 /* up to this */
#define BRACKET_GROWTH   2.  /* of the residual, where the slope says nothing */
#define BRACKET_HALVES   5

/* Decides whether a new Jacobian is made after this iteration. Steps are much like the last one. */
static PetscErrorCode LookAhead(MpmSolver *solver, SNES snes)
{
  PetscInt it;

  PetscFunctionBeginUser;
  PetscCall(SNESGetIterationNumber(snes, &it));
  if (solver->disc->layout->traits.alternate) PetscFunctionReturn(PETSC_SUCCESS); /* the next one may be another */
  solver->cache.ahead = (PetscBool)(solver->cache.solving && it + 1 < solver->cache.reuse.needed_last_time);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where there is contact, and a step went well beyond the zero of the slope. */
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
  Where a penalty is stiff, the slope's zero lies where the first patch touches, and a line search that stops there
  takes an iteration a patch. Full steps, each of which finds the patches that touch after the last one, converge
  faster. Therefore one is taken although the slope forbids it, another may follow, and more as long as the residual
  falls. When the residual rises, and is not below the first one, `back` requests a return to the start, *step becomes
  that first one, and the line search decides.
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
  Bracket of a line search: lengths with a slope downhill and uphill of its zero (-1: none yet), the slopes, and the end
  that moved last (-1: none).
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
  By the work: the full step costs one residual and is taken when the residual falls or the slope of the work, G . Y,
  does; otherwise the slope's zero is bracketed by regula falsi. A trial without an answer halves the step. `found`: a
  step was found.

  A test on the residual alone would throttle bending and rotation, where a good full step raises the residual first.
  Such rises occur at the solution's start only. In plastic flow without change of volume, steps that later raise the
  slope's magnitude diverge (a footing on clay: 63 iterations and two cuts in place of 24).

  Where contact sticks, slips or opens from one iterate to the next, full steps may alternate over a kink for ever, each
  with a slope as large as the last and of opposite sign, and a residual that falls on every other one. There the slope
  has to be less after a step than before. Between two that slide to and fro the zero is a kink, where contact sticks:
  one interpolation covers a fraction of the distance, 1/2, 1/3, 1/4 ... from one iteration to the next, and the bracket
  is narrowed instead.
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

/* True where the residual at search->lambda, with this slope there, is accepted. */
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
  True where a length has changed nothing, with none yet uphill: all of a body slides there, and the zero, where some of
  it sticks, is farther on.
*/
static PetscBool IsFlat(const MpmSearch *search, const Bracket *bracket, PetscReal slope)
{
  return (PetscBool)(bracket->start > 0. && bracket->at[1] < 0. && slope > BRACKET_FLAT * bracket->start &&
                     search->norm > BRACKET_FLAT * search->fnorm && search->lambda >= 1. &&
                     search->lambda < BRACKET_LONGEST);
}

/*
  The careful search, for contact. Where it sticks, slips, closes or opens on the way the slope has kinks, often a
  thousand times as steep behind them as before, and full steps may alternate over them for ever, with a residual that
  falls on every other one. The slope's zero is therefore bracketed, by regula falsi that keeps off the ends. Where
  friction makes the slope negative at the start, the slope is meaningless and the residual decides.
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
  PetscCall(MpmFieldsExcess(search->solver, search->X, search->F, &start));
  for (PetscInt trial = 0;; trial++) {
    PetscCall(MpmSearchTry(search));
    if (PetscIsInfOrNanReal(search->norm)) {
      *found = (PetscBool)(trial < LINE_SEARCH_TRIALS);
      if (!*found) break;
      search->lambda *= 0.5;
      continue;
    }
    PetscCall(MpmFieldsExcess(search->solver, search->W, search->G, &excess));
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

/* Passes the accepted iterate to the terms; contacts kept closed until now have other forces there. */
static PetscErrorCode AcceptIterate(MpmSearch *search)
{
  const MpmDiscretization *disc    = search->solver->disc;
  const PetscBool          held    = MpmTermsHold(disc->terms);
  const PetscBool          careful = (PetscBool)(search->solver->careful && MpmSolverHasContact(search->solver));
  PetscBool                changed;

  PetscFunctionBeginUser;
  if (!careful && !held) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmGatherSolution(search->solver, search->W));
  PetscCall(MpmTermsNewtonAccepted(disc->terms, disc->sum, disc->nodal.u, &changed));
  if (changed) search->solver->cache.summed.id = 0; /* another Jacobian */
  if (!held) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESComputeFunction(search->solver->snes, search->W, search->G));
  PetscCall(VecNorm(search->G, NORM_2, &search->norm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Results at the vector of version `from` belong to x, too, which has equal values. */
static PetscErrorCode Follow(const MpmVersion *from, Vec x, MpmVersion *of)
{
  PetscFunctionBeginUser;
  if (MpmVersionIsSame(from, of)) PetscCall(MpmVersionGet(x, of));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLineSearch(SNESLineSearch object, void *ctx)
{
  MpmSearch  search = {.solver = (MpmSolver *)ctx, .lambda = 1.};
  MpmVersion tried;
  SNES       snes;
  PetscReal  xnorm, ynorm;
  PetscBool  found;

  PetscFunctionBeginUser;
  PetscCall(SNESLineSearchGetSNES(object, &snes));
  PetscCall(LookAhead(search.solver, snes));
  PetscCall(SNESLineSearchGetVecs(object, &search.X, &search.F, &search.Y, &search.W, &search.G));
  PetscCall(SNESLineSearchGetNorms(object, &xnorm, &search.fnorm, &ynorm));
  PetscCall(SNESGetIterationNumber(snes, &search.it));
  if (search.solver->disc->layout->traits.alternate) PetscCall(MpmSearchInTurn(&search, &found));
  else if (!MpmFieldsDoWork(search.solver->disc->layout)) PetscCall(SearchByNorm(&search, &found));
  else if (search.solver->careful) PetscCall(SearchByBracket(&search, &found));
  else PetscCall(SearchByWork(&search, &found));
  if (found && search.solver->cache.minimisation.on) PetscCall(MpmSearchDescend(&search, &found));
  if (!found) {
    PetscCall(SNESLineSearchSetReason(object, SNES_LINESEARCH_FAILED_NANORINF));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(AcceptIterate(&search));
  PetscCall(VecNorm(search.Y, NORM_2, &ynorm));
  PetscCall(MpmVersionGet(search.W, &tried));
  PetscCall(VecCopy(search.W, search.X));
  PetscCall(VecCopy(search.G, search.F));
  PetscCall(Follow(&tried, search.X, &search.solver->cache.summed));
  PetscCall(Follow(&tried, search.X, &search.solver->disc->trial->of));
  PetscCall(MpmSearchTaken(&search));
  PetscCall(VecNorm(search.X, NORM_2, &xnorm));
  PetscCall(SNESLineSearchSetLambda(object, search.lambda));
  PetscCall(SNESLineSearchSetNorms(object, xnorm, search.norm, ynorm));
  PetscCall(SNESLineSearchSetReason(object, SNES_LINESEARCH_SUCCEEDED));
  PetscFunctionReturn(PETSC_SUCCESS);
}
