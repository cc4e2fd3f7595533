/*
  Least squares by the Jacobian J of the residuals r, with bounds.

  A step of the parameters in units of their sizes D is

    D^-1 dt = -V diag(w/(w^2 + a w_1^2)) U^T r ,   J D = U diag(w) V^T ,

  Gauss and Newton's for a = 0, damped as by Levenberg, Quarterly of Applied Mathematics 2, 164-168 (1944),
  doi:10.1090/qam/10666, after a run that failed or has no smaller objective. Combinations that the data do not tell
  stay. A parameter at a bound that the objective pushes against stays there in the step; steps end at the bounds.
*/
#include "inverse/analysis.h"
#include "inverse/singular.h"

#define TOLD         1e-8 /* singular values below this part of the largest are left out */
#define DAMPING      0.05 /* the first one */
#define MORE         8.   /* times the damping after a step that was not taken */
#define LESS         0.05 /* after one that was */
#define LEAST        1e-4 /* smaller ones are none */
#define MOST_DAMPING 1e8
#define MOST_CHANGE  2.302585092994046 /* of a logarithm in one step: tenfold */

/* Parameters that a step changes. */
static PetscInt FindFree(const MpmInverse *inverse, const MpmEvaluation *at, PetscInt of[])
{
  PetscInt free = 0;

  for (PetscInt k = 0; k < inverse->problem.count; k++) {
    PetscReal lower, upper;

    MpmRangeBounds(&inverse->problem.ranges->at[k], &lower, &upper);
    if (at->t[k] <= lower && at->gradient[k] > 0.) continue;
    if (at->t[k] >= upper && at->gradient[k] < 0.) continue;
    of[free++] = k;
  }
  return free;
}

/* A step in which no logarithm changes by more than is sensible: derivatives tell nothing of places so far away. */
static void Shorten(const MpmInverse *inverse, const PetscReal from[], PetscReal to[])
{
  PetscReal most = MOST_CHANGE;

  for (PetscInt k = 0; k < inverse->problem.count; k++)
    if (inverse->problem.ranges->at[k].transform != MPM_TRANSFORM_NONE)
      most = PetscMax(most, PetscAbsReal(to[k] - from[k]));
  for (PetscInt k = 0; k < inverse->problem.count; k++) to[k] = from[k] + (to[k] - from[k]) * MOST_CHANGE / most;
}

/* The parameters after a step with this damping. */
static PetscErrorCode FindTrial(const MpmInverse *inverse, const MpmEvaluation *at, PetscReal damping, PetscReal t[])
{
  const PetscInt count = inverse->problem.count;
  PetscInt      *of, free;
  PetscReal     *scaled;
  MpmSingular    singular;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(count, &of, (at->rows * count), &scaled));
  free = FindFree(inverse, at, of);
  for (PetscInt i = 0; i < at->rows; i++)
    for (PetscInt k = 0; k < free; k++)
      scaled[i * free + k] = at->jacobian[i * count + of[k]] * MpmInverseSize(inverse, at->t, of[k]);
  PetscCall(MpmSingularCreate(at->rows, free, scaled, &singular));
  PetscCall(PetscArraycpy(t, at->t, count));
  for (PetscInt i = 0; i < singular.count; i++) {
    const PetscReal w = singular.value[i], first = singular.value[0];
    PetscReal       sum = 0.;

    if (w <= TOLD * first) continue;
    for (PetscInt n = 0; n < at->rows; n++) sum += singular.u[n * singular.count + i] * at->residual[n];
    for (PetscInt k = 0; k < free; k++)
      t[of[k]] -= singular.v[k * singular.count + i] * sum * w / (w * w + damping * first * first) *
                  MpmInverseSize(inverse, at->t, of[k]);
  }
  Shorten(inverse, at->t, t);
  MpmInverseClip(inverse, t);
  PetscCall(MpmSingularDestroy(&singular));
  PetscCall(PetscFree2(of, scaled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The largest change, in sizes of the parameters. */
static PetscReal Change(const MpmInverse *inverse, const PetscReal from[], const PetscReal to[])
{
  PetscReal change = 0.;

  for (PetscInt k = 0; k < inverse->problem.count; k++)
    change = PetscMax(change, PetscAbsReal(to[k] - from[k]) / MpmInverseSize(inverse, from, k));
  return change;
}

/* One step that makes the objective smaller; `moved` false where there is none. */
static PetscErrorCode TakeStep(MpmInverse *inverse, MpmEvaluation *at, PetscReal *damping, PetscReal *change,
                               PetscBool *moved)
{
  MpmEvaluation trial = {0}, other;
  PetscReal    *t;

  PetscFunctionBeginUser;
  *moved = PETSC_FALSE;
  PetscCall(PetscMalloc1(inverse->problem.count, &t));
  while (!*moved && !inverse->interrupted) {
    PetscCall(FindTrial(inverse, at, *damping, t));
    *change = Change(inverse, at->t, t);
    if (*change < inverse->settings->tolerance || *damping > MOST_DAMPING) break;
    PetscCall(MpmInverseEvaluate(&inverse->problem, t, MPM_JACOBIAN, at->objective, &trial));
    inverse->interrupted = trial.interrupted;
    *moved               = (PetscBool)(trial.objective < at->objective);
    if (*moved) *damping = *damping * LESS < LEAST ? 0. : *damping * LESS;
    else *damping = PetscMax(DAMPING, MORE * *damping);
  }
  if (*moved) {
    other = *at;
    *at   = trial;
    trial = other;
  }
  PetscCall(MpmEvaluationDestroy(&trial));
  PetscCall(PetscFree(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGaussNewtonRun(MpmInverse *inverse, MpmEvaluation *at)
{
  PetscReal damping = 0., change = 0.;
  PetscBool stop, moved;
  PetscInt  iteration = MpmInverseFirst(inverse);

  PetscFunctionBeginUser;
  PetscCall(MpmInverseReport(inverse, iteration, at, &stop));
  while (!stop) {
    PetscCall(TakeStep(inverse, at, &damping, &change, &moved));
    inverse->converged = (PetscBool)(change < inverse->settings->tolerance);
    if (moved) PetscCall(MpmInverseReport(inverse, ++iteration, at, &stop));
    if (inverse->converged || !moved) break;
  }
  inverse->reason = inverse->converged ? "the parameters stay within the tolerance"
                    : stop             ? "the iterations are used up"
                                       : "no step has a smaller objective";
  PetscFunctionReturn(PETSC_SUCCESS);
}
