/*
  A step as a minimisation: the objective, and its use in the line search.

  The residual is the objective's derivative, so that G . Y at both ends of a step shows its change along the step.
  Where the slope at the end is small beside that at the start the objective has fallen by about half of the first; it
  is evaluated where slopes leave a doubt. A change within rounding is none.

  Sources: Armijo (1966), Pacific J. Math. 16, 1-3, doi:10.2140/pjm.1966.16.1; Nocedal, Wright (2006), Numerical
  Optimization, 2nd edition, Springer, chapter 3 (backtracking by interpolation).
*/
#include "solve/line_search.h"

#define SURE      0.5   /* of the slope at the start: no more at the end leaves no doubt */
#define ARMIJO    1e-4  /* of the fall that the slope promises: so much at least */
#define ROUNDING  1e-12 /* of the sizes of the objective's parts */
#define TRIALS    25
#define CUT_LEAST 0.1
#define CUT_MOST  0.5

/* An objective and its rounding; infinite where a point has no answer. */
typedef struct {
  PetscReal value, noise;
} Objective;

static PetscErrorCode Evaluate(MpmSolver *solver, Vec x, Objective *objective)
{
  PetscReal size = 0.;
  PetscInt  failed;

  PetscFunctionBeginUser;
  PetscCall(MpmSumPotential(solver, x, &objective->value, &size, &failed));
  if (failed || PetscIsInfOrNanReal(objective->value)) objective->value = PETSC_INFINITY;
  objective->noise = ROUNDING * size;
  PetscCall(PetscInfo(solver->snes, "the objective is %.16g\n", (double)objective->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmObjective(SNES snes, Vec x, PetscReal *value, void *ctx)
{
  MpmSolver     *solver = (MpmSolver *)ctx;
  Objective      objective;
  PetscLogDouble since;

  PetscFunctionBeginUser;
  (void)snes;
  PetscCall(MpmMonitorBegin(solver->monitor, MPM_TIME_RESIDUAL, &since));
  PetscCall(Evaluate(solver, x, &objective));
  PetscCall(MpmMonitorEnd(solver->monitor, MPM_TIME_RESIDUAL, since));
  *value = objective.value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* At the search's start, where it may be known, and at the step that is tried. */
static PetscErrorCode AtEnds(MpmSearch *search, Objective *start, Objective *end)
{
  MpmMinimisation *kept = &search->solver->cache.minimisation;
  MpmVersion       place;

  PetscFunctionBeginUser;
  PetscCall(Evaluate(search->solver, search->W, end)); /* first: the trial is there */
  PetscCall(MpmVersionGet(search->X, &place));
  if (MpmVersionIsSame(&place, &kept->at)) {
    start->value = kept->value;
    start->noise = end->noise;
  } else PetscCall(Evaluate(search->solver, search->X, start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Shorter steps, downhill, until the objective falls. */
static PetscErrorCode Backtrack(MpmSearch *search, PetscReal start, const Objective *from, Objective *to,
                                PetscBool *found)
{
  const PetscReal way    = start < 0. ? -1. : 1.; /* along -Y, or against it */
  PetscReal       length = PetscAbsReal(search->lambda), cut;

  PetscFunctionBeginUser;
  for (PetscInt trial = 0; trial < TRIALS; trial++) {
    const PetscReal fall = PetscAbsReal(start) * length, rise = to->value - from->value;

    cut = PetscIsInfOrNanReal(rise) || way * search->lambda < 0. ? CUT_MOST : 0.5 * fall / (rise + fall);
    length *= PetscClipInterval(cut, CUT_LEAST, CUT_MOST);
    search->lambda = way * length;
    PetscCall(MpmSearchTry(search));
    to->value = PETSC_INFINITY;
    if (!PetscIsInfOrNanReal(search->norm)) PetscCall(Evaluate(search->solver, search->W, to));
    *found = (PetscBool)(to->value <= from->value - ARMIJO * PetscAbsReal(start) * length + from->noise);
    if (*found) break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSearchDescend(MpmSearch *search, PetscBool *found)
{
  MpmMinimisation *kept = &search->solver->cache.minimisation;
  PetscReal        start, end;
  PetscScalar      dot;
  Objective        from, to;

  PetscFunctionBeginUser;
  kept->known = PETSC_FALSE;
  PetscCall(VecDot(search->F, search->Y, &dot));
  start = PetscRealPart(dot);
  PetscCall(VecDot(search->G, search->Y, &dot));
  end = PetscRealPart(dot);
  if (start > 0. && PetscAbsReal(end) <= SURE * start) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AtEnds(search, &from, &to));
  if (to.value > from.value + from.noise && PetscAbsReal(start) > from.noise)
    PetscCall(Backtrack(search, start, &from, &to, found));
  kept->known = *found;
  kept->value = to.value;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSearchTaken(MpmSearch *search)
{
  MpmMinimisation *kept = &search->solver->cache.minimisation;

  PetscFunctionBeginUser;
  kept->at.id = 0;
  if (kept->known) PetscCall(MpmVersionGet(search->X, &kept->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}
