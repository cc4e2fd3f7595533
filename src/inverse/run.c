/*
  The task `inverse`: parameters from data, how sure they are, and the results of the run with them.
*/
#include "observe/results.h"
#include "sensitivity/gradient.h"
#include "model/build.h"
#include "inverse/discrepancy.h"
#include "inverse/inverse.h"
#include "inverse/output.h"

#define MOST_STATISTICS 200 /* parameters: a run each for derivatives of all data */

static const MpmInverseMethodRun methods[] = {MpmGaussNewtonRun, MpmBlmvmRun, MpmDescentRun};

static PetscErrorCode PrintBegin(const MpmInverse *inverse)
{
  static const char *const names[] = {"gauss_newton", "blmvm", "descent"};
  const MpmModel           scene   = inverse->problem.scene;

  PetscFunctionBeginUser;
  if (!MpmTerminalShows(scene)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPrintf(scene->comm, "talus %s: inverse analysis by %s of %d parameters\n", MPM_VERSION,
                        names[inverse->settings->method], (int)inverse->problem.count));
  PetscCall(PetscPrintf(scene->comm, "%7s %14s %6s  %s\n", "step", "objective", "runs", "parameters"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where a start begins: the rows of an earlier analysis, the scene's values, or a place between the bounds. */
static PetscErrorCode Begin(const MpmInverse *inverse, PetscReal t[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < inverse->problem.count; k++)
    t[k] = MpmRangeTransform(&inverse->problem.ranges->at[k], inverse->problem.ranges->at[k].start);
  if (inverse->start) MpmInverseStart(inverse, inverse->start, t);
  if (inverse->start == inverse->earlier.start) PetscCall(PetscArraycpy(t, inverse->earlier.t, inverse->problem.count));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmEvaluationSlopes SlopesOf(const MpmInverse *inverse)
{
  return inverse->settings->method == MPM_GAUSS_NEWTON ? MPM_JACOBIAN : MPM_GRADIENT_ONLY;
}

/* One start; its result is kept where it is the best. */
static PetscErrorCode RunStart(MpmInverse *inverse, const PetscReal t[])
{
  MpmEvaluation at = {0}, other;
  PetscBool     better;

  PetscFunctionBeginUser;
  PetscCall(MpmInverseEvaluate(&inverse->problem, t, SlopesOf(inverse), PETSC_INFINITY, &at));
  inverse->interrupted = at.interrupted;
  inverse->converged   = PETSC_FALSE;
  if (!at.failed) PetscCall((*methods[inverse->settings->method])(inverse, &at));
  if (!at.failed) PetscCall(MpmDiscrepancyReturn(inverse, &at));
  if (inverse->met) inverse->reason = "the misfit is at the level of the noise";
  if (inverse->met) inverse->converged = PETSC_TRUE;
  better = (PetscBool)(!inverse->best.t || inverse->best.failed || at.objective < inverse->best.objective);
  if (better) {
    other               = inverse->best;
    inverse->best       = at;
    at                  = other;
    inverse->iterations = inverse->iteration;
  }
  PetscCall(MpmEvaluationDestroy(&at));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All starts, from that of an earlier analysis on. */
static PetscErrorCode RunStarts(MpmInverse *inverse)
{
  PetscReal *t;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(inverse->problem.count, &t));
  for (inverse->start = PetscMax(0, inverse->earlier.start); inverse->start < inverse->settings->starts;
       inverse->start++) {
    PetscCall(Begin(inverse, t));
    PetscCall(RunStart(inverse, t));
    if (inverse->interrupted || (inverse->best.failed && !inverse->start)) break;
  }
  PetscCall(PetscFree(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The best parameters with derivatives of all data. */
static PetscErrorCode FindBest(MpmInverse *inverse)
{
  const PetscBool jacobian = (PetscBool)(inverse->problem.count <= MOST_STATISTICS);
  const PetscBool earlier =
    (PetscBool)(inverse->earlier.least < inverse->best.objective * (1. - 1e-12) && !inverse->met);
  PetscReal *t;

  PetscFunctionBeginUser;
  if (!earlier && (inverse->best.jacobian || !jacobian)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(inverse->problem.count, &t));
  PetscCall(PetscArraycpy(t, earlier ? inverse->earlier.best : inverse->best.t, inverse->problem.count));
  PetscCall(
    MpmInverseEvaluate(&inverse->problem, t, jacobian ? MPM_JACOBIAN : MPM_NO_SLOPES, PETSC_INFINITY, &inverse->best));
  PetscCall(PetscFree(t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The run with the best parameters and its results, whose summary has those of the analysis. */
static PetscErrorCode RunBest(MpmInverse *inverse, const char text[], int *status)
{
  MpmModel model;

  PetscFunctionBeginUser;
  PetscCall(MpmInverseSetOptions(&inverse->problem, inverse->best.t));
  PetscCall(MpmInverseSetFieldFiles(inverse));
  PetscCall(MpmInverseModelCreate(&inverse->problem, &model));
  if (inverse->problem.scene->caller.terminal) PetscCall(MpmModelUseTerminal(model));
  PetscCall(MpmModelSetFromOptions(model));
  PetscCall(MpmGradientDestroy(&model->gradient));
  model->results->derivatives.inverse = text;
  PetscCall(MpmModelRun(model, status));
  PetscCall(MpmModelDestroy(&model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WriteResults(MpmInverse *inverse, int *status)
{
  MpmStatistics statistics = {0};
  char         *text;

  PetscFunctionBeginUser;
  if (inverse->best.jacobian) {
    PetscCall(MpmStatisticsCreate(&inverse->problem, &inverse->best, &statistics));
    PetscCall(MpmInverseWriteJacobian(inverse));
  }
  PetscCall(MpmInverseWriteResiduals(inverse));
  PetscCall(MpmInverseWriteFields(inverse));
  PetscCall(MpmInversePrint(inverse, statistics.count ? &statistics : NULL));
  PetscCall(MpmInverseText(inverse, statistics.count ? &statistics : NULL, &text));
  PetscCall(RunBest(inverse, text, status));
  PetscCall(PetscFree(text));
  PetscCall(MpmStatisticsDestroy(&statistics));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Run(MpmModel scene, int *status)
{
  MpmInverse inverse = {.settings = &scene->gradient->inverse};

  PetscFunctionBeginUser;
  PetscCall(MpmInverseProblemCreate(scene, &inverse.problem));
  PetscCall(MpmTraceRead(&inverse));
  PetscCall(PrintBegin(&inverse));
  PetscCall(RunStarts(&inverse));
  MpmCheckInput(!inverse.best.refused, "%s", inverse.best.why);
  *status = 0;
  if (inverse.interrupted) {
    PetscCall(MpmTerminalWarn(scene, "interrupted; with -mpm_inverse_restart the analysis goes on from its last row"));
  } else if (inverse.best.failed) {
    PetscCall(MpmTerminalWarn(scene, "the run with the start values gave up: %s", inverse.best.why));
    *status = MPM_EXIT_GAVEUP;
  } else {
    PetscCall(FindBest(&inverse));
    PetscCall(WriteResults(&inverse, status));
  }
  PetscCall(MpmEvaluationDestroy(&inverse.best));
  PetscCall(MpmTraceClose(&inverse));
  PetscCall(PetscFree(inverse.above));
  PetscCall(MpmInverseProblemDestroy(&inverse.problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseRun(MpmModel model, int *status)
{
  PetscFunctionBeginUser;
  MpmModelCall(model, Run(model, status));
  PetscFunctionReturn(PETSC_SUCCESS);
}
