/*
  One evaluation of an inverse analysis: a fresh model in memory, its data and their derivatives.

  By the transformed parameter t of p, which stands for the numbers p_m of the scene, a result y changes by

    dy/dt = dp/dt sum_m dy/dp_m .
*/
#include "observe/results.h"
#include "observe/signals.h"
#include "sensitivity/gradient.h"
#include "model/build.h"
#include "inverse/inverse.h"
#include "inverse/problem.h"

PetscErrorCode MpmEvaluationDestroy(MpmEvaluation *evaluation)
{
  PetscFunctionBeginUser;
  PetscCall(MpmMeasurementsDestroy(&evaluation->data));
  PetscCall(PetscFree(evaluation->t));
  PetscCall(PetscFree(evaluation->residual));
  PetscCall(PetscFree(evaluation->gradient));
  PetscCall(PetscFree(evaluation->jacobian));
  PetscCall(PetscFree(evaluation->prediction));
  PetscCall(PetscFree(evaluation->prediction_slopes));
  *evaluation = (MpmEvaluation){0};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the run ---- */

/* All steps, recorded; the model's outcome says where they end early. */
static PetscErrorCode TakeSteps(MpmModel model, PetscBool *interrupted)
{
  MpmStatus status = MPM_RUNNING;

  PetscFunctionBeginUser;
  PetscCall(MpmModelSetUp(model));
  PetscCall(MpmGradientAddColumns(model, &model->results->columns));
  MpmModelCall(model, MpmGradientBegin(model));
  PetscCall(MpmGradientCollect(model));
  while (status == MPM_RUNNING) {
    PetscCall(MpmModelStep(model, &status));
    if (status == MPM_GAVE_UP) break;
    MpmModelCall(model, MpmGradientRecord(model));
    *interrupted = MpmSignalsCaught();
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, interrupted, 1, MPM_MPI_BOOL, MPI_LOR, model->comm));
    if (model->caller.outcome.code || *interrupted) break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Data, residuals and objective of a run. */
static PetscErrorCode FindResiduals(const MpmInverseProblem *problem, const MpmModel model, MpmEvaluation *evaluation)
{
  const MpmGradient *gradient = model->gradient;
  const MpmCurves    curves   = MpmGradientCurves(gradient);
  PetscReal          sum;
  PetscInt           n = 0, rows = 0;

  PetscFunctionBeginUser;
  PetscCall(MpmMeasurementsFind(&gradient->objectives, &curves, &evaluation->data));
  PetscCall(MpmGradientEvaluate(model, &sum));
  for (PetscInt i = 0; i < problem->penalties; i++) rows += problem->penalty[i].rows;
  PetscCall(PetscCalloc1((evaluation->data.count + problem->count + rows + 1), &evaluation->residual));
  for (; n < evaluation->data.count; n++) {
    const MpmMeasurement *at = &evaluation->data.at[n];

    evaluation->residual[n] = (at->computed - at->measured) / at->deviation;
  }
  for (PetscInt k = 0; k < problem->count; k++) {
    const MpmParameterRange *range = &problem->ranges->at[k];

    if (!range->has_prior) continue;
    evaluation->residual[n] = (evaluation->t[k] - MpmRangeTransform(range, range->prior)) / range->deviation;
    sum += 0.5 * evaluation->residual[n] * evaluation->residual[n];
    n++;
  }
  for (PetscInt i = 0; i < problem->penalties; i++) {
    PetscReal part;

    PetscCall(MpmPenaltyEvaluate(&problem->penalty[i], evaluation->t, &part, &evaluation->residual[n]));
    sum += part;
    n += problem->penalty[i].rows;
  }
  evaluation->rows      = n;
  evaluation->objective = PetscIsInfOrNanReal(sum) ? PETSC_INFINITY : sum;
  evaluation->predicted = gradient->objectives.predicted;
  PetscCall(PetscCalloc1(evaluation->predicted + 1, &evaluation->prediction));
  for (PetscInt p = 0; p < evaluation->predicted; p++)
    evaluation->prediction[p] = curves.value[(curves.rows - 1) * curves.count + gradient->objectives.asked + p];
  PetscCallMPI(MPI_Bcast(&evaluation->objective, 1, MPIU_REAL, 0, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- derivatives ---- */

/*
  dp_m/dt of the i-th number that parameter `range` stands for, m its place among all derivatives: numbers of the scene,
  then values of fields. A factor is one of the run's own load: its derivative is over the factor.
*/
static PetscReal SlopeOf(const MpmGradient *gradient, const MpmParameterRange *range, PetscInt i, PetscReal t,
                         PetscInt *m)
{
  const PetscReal value = MpmRangeValue(range, t);
  PetscReal       present;

  if (range->field >= 0) {
    *m = gradient->parameters.count + gradient->grounds.at[range->field].first + range->place;
    return MpmRangeSlope(range, t);
  }
  *m      = range->of[i];
  present = gradient->parameters.at[*m].value;
  return MpmRangeSlope(range, t) * (present == value || value == 0. ? 1. : present / value);
}

/* Numbers that a parameter stands for. */
static PetscInt NumbersOf(const MpmParameterRange *range)
{
  return range->field >= 0 ? 1 : range->count;
}

/* Derivative by parameter k of a curve's value after a step. */
static PetscReal CurveSlope(const MpmInverseProblem *problem, const MpmGradient *gradient, const PetscReal t[],
                            PetscInt k, const MpmCurveSlope *by)
{
  const MpmParameterRange *range = &problem->ranges->at[k];
  PetscReal                sum   = 0.;

  for (PetscInt i = 0; i < NumbersOf(range); i++) {
    PetscInt        m;
    const PetscReal slope = SlopeOf(gradient, range, i, t[k], &m);

    sum += slope * gradient->slopes[(m * gradient->rows + by->row) * gradient->objectives.count + by->curve];
  }
  return sum * by->slope;
}

static PetscErrorCode FindJacobian(const MpmInverseProblem *problem, const MpmModel model, MpmEvaluation *evaluation)
{
  const MpmGradient *gradient = model->gradient;
  const PetscInt     count    = problem->count;
  PetscInt           n        = evaluation->data.count;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(((evaluation->rows + 1) * count), &evaluation->jacobian));
  PetscCall(PetscCalloc1(((evaluation->predicted + 1) * count), &evaluation->prediction_slopes));
  for (PetscInt k = 0; k < count; k++) {
    for (PetscInt i = 0; i < evaluation->data.count; i++) {
      const MpmMeasurement *at = &evaluation->data.at[i];

      for (PetscInt j = 0; j < at->count; j++)
        evaluation->jacobian[i * count + k] +=
          CurveSlope(problem, gradient, evaluation->t, k, &at->by[j]) / at->deviation;
    }
    for (PetscInt p = 0; p < evaluation->predicted; p++) {
      const MpmCurveSlope by = {gradient->objectives.asked + p, gradient->rows - 1, 1.};

      evaluation->prediction_slopes[p * count + k] = CurveSlope(problem, gradient, evaluation->t, k, &by);
    }
    if (problem->ranges->at[k].has_prior) evaluation->jacobian[n++ * count + k] = 1. / problem->ranges->at[k].deviation;
  }
  for (PetscInt i = 0; i < problem->penalties; n += problem->penalty[i++].rows)
    PetscCall(MpmPenaltyFillJacobian(&problem->penalty[i], evaluation->t, count, &evaluation->jacobian[n * count]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FindGradient(const MpmInverseProblem *problem, const MpmModel model, MpmEvaluation *evaluation)
{
  const PetscReal *found = model->results->derivatives.gradient;
  PetscInt         n     = evaluation->data.count;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(problem->count, &evaluation->gradient));
  for (PetscInt k = 0; k < problem->count; k++) {
    const MpmParameterRange *range = &problem->ranges->at[k];

    for (PetscInt i = 0; i < NumbersOf(range); i++) {
      PetscInt        m;
      const PetscReal slope = SlopeOf(model->gradient, range, i, evaluation->t[k], &m);

      evaluation->gradient[k] += found[m] * slope;
    }
    if (range->has_prior) evaluation->gradient[k] += evaluation->residual[n++] / range->deviation;
  }
  for (PetscInt i = 0; i < problem->penalties; n += problem->penalty[i++].rows)
    PetscCall(MpmPenaltyPull(&problem->penalty[i], evaluation->t, &evaluation->residual[n], evaluation->gradient));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Differentiate(MpmInverseProblem *problem, MpmModel model, MpmEvaluationSlopes slopes,
                                    MpmEvaluation *evaluation)
{
  PetscFunctionBeginUser;
  if (slopes == MPM_JACOBIAN && model->gradient->method != MPM_GRADIENT_TWINS)
    model->gradient->method = MPM_GRADIENT_TANGENT;
  MpmModelCall(model, MpmDifferentiate(model));
  if (model->caller.outcome.code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(FindGradient(problem, model, evaluation));
  if (slopes == MPM_JACOBIAN) PetscCall(FindJacobian(problem, model, evaluation));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- failures ---- */

static void Fail(MpmEvaluation *evaluation, const char why[])
{
  evaluation->failed    = PETSC_TRUE;
  evaluation->objective = PETSC_INFINITY;
  (void)PetscStrncpy(evaluation->why, why, sizeof(evaluation->why));
}

/* Refusals are kept for the analysis; anything else is a fault of the program. */
static PetscErrorCode HandleError(MPI_Comm comm, int line, const char *function, const char *file, PetscErrorCode code,
                                  PetscErrorType type, const char *message, void *ctx)
{
  if (code != MPM_ERR_INPUT) return PetscTraceBackErrorHandler(comm, line, function, file, code, type, message, NULL);
  if (type == PETSC_ERROR_INITIAL) Fail((MpmEvaluation *)ctx, message ? message : "");
  return code;
}

/* ---- all of it ---- */

/* A load of no magnitude has lost its direction, and its run has no derivative by the factor. */
static PetscErrorCode CheckFactors(const MpmInverseProblem *problem, const PetscReal t[])
{
  const MpmSceneParameter *parameters = problem->scene->gradient->parameters.at;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < problem->count; k++) {
    const MpmParameterRange *range = &problem->ranges->at[k];

    for (PetscInt i = 0; i < range->count; i++)
      MpmCheckInput(parameters[range->of[i]].kind != MPM_OF_LOAD || MpmRangeValue(range, t[k]) != 0.,
                    "-mpm_parameter_%s_start 0: must not be 0, where there is no derivative by the factor of a load",
                    range->name);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Evaluate(MpmInverseProblem *problem, MpmModel model, MpmEvaluationSlopes slopes, PetscReal limit,
                               MpmEvaluation *evaluation)
{
  PetscFunctionBeginUser;
  PetscCall(MpmModelSetFromOptions(model));
  if (slopes != MPM_NO_SLOPES) PetscCall(CheckFactors(problem, evaluation->t));
  PetscCall(TakeSteps(model, &evaluation->interrupted));
  if (evaluation->interrupted) Fail(evaluation, "interrupted");
  else if (!model->caller.outcome.code) {
    PetscCall(FindResiduals(problem, model, evaluation));
    if (slopes != MPM_NO_SLOPES && evaluation->objective < limit)
      PetscCall(Differentiate(problem, model, slopes, evaluation));
  }
  if (model->caller.outcome.code) Fail(evaluation, model->caller.outcome.text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseEvaluate(MpmInverseProblem *problem, const PetscReal t[], MpmEvaluationSlopes slopes,
                                  PetscReal limit, MpmEvaluation *evaluation)
{
  MpmModel       model;
  PetscErrorCode error;

  PetscFunctionBeginUser;
  PetscCall(MpmEvaluationDestroy(evaluation));
  PetscCall(PetscMalloc1(problem->count, &evaluation->t));
  PetscCall(PetscArraycpy(evaluation->t, t, problem->count));
  PetscCallMPI(MPI_Bcast(evaluation->t, (PetscMPIInt)problem->count, MPIU_REAL, 0, problem->scene->comm));
  PetscCall(MpmInverseSetOptions(problem, evaluation->t));
  PetscCall(MpmInverseModelCreate(problem, &model));
  PetscCall(PetscPushErrorHandler(HandleError, evaluation));
  error = Evaluate(problem, model, slopes, limit, evaluation);
  PetscCall(PetscPopErrorHandler());
  if (error && error != MPM_ERR_INPUT) PetscCall(error);
  evaluation->refused = (PetscBool)(error != 0);
  PetscCall(MpmModelDestroy(&model));
  problem->evaluations++;
  PetscFunctionReturn(PETSC_SUCCESS);
}
