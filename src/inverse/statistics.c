/*
  Statistics of an inverse analysis. Sources: Hill and Tiedeman (2007), doi:10.1002/0470041080, chapters 4 to 8, for
  composite scaled sensitivities, parameter statistics and linear intervals.
*/
#include "inverse/singular.h"
#include "inverse/statistics.h"
#include "inverse/student.h"

#define LARGE_DEGREES 1000000
#define PART          1e-3 /* of a combination's largest share: smaller ones take no part */

static PetscErrorCode Allocate(const MpmInverseProblem *problem, const MpmEvaluation *evaluation,
                               MpmStatistics *statistics)
{
  const PetscInt count = problem->count;

  PetscFunctionBeginUser;
  *statistics =
    (MpmStatistics){.count = count, .rows = evaluation->rows, .degrees = PetscMax(0, evaluation->rows - count)};
  PetscCall(PetscCalloc2((count * count), &statistics->covariance, (count * count), &statistics->correlation));
  PetscCall(PetscCalloc3(count, &statistics->lower, count, &statistics->upper, count, &statistics->sensitivity));
  PetscCall(PetscCalloc3(count, &statistics->singular, (count * count), &statistics->combination,
                         (evaluation->predicted + 1), &statistics->prediction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStatisticsDestroy(MpmStatistics *statistics)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(statistics->covariance, statistics->correlation));
  PetscCall(PetscFree3(statistics->lower, statistics->upper, statistics->sensitivity));
  PetscCall(PetscFree3(statistics->singular, statistics->combination, statistics->prediction));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* p/(dp/dt): of a change by t that by the relative change of p. */
static PetscReal Scale(const MpmInverseProblem *problem, const MpmEvaluation *evaluation, PetscInt k)
{
  const MpmParameterRange *range = &problem->ranges->at[k];
  const PetscReal          value = MpmRangeValue(range, evaluation->t[k]);

  return (value != 0. ? value : 1.) / MpmRangeSlope(range, evaluation->t[k]);
}

/* Derivatives of the first rows by relative changes of the parameters; as many rows as parameters at least. */
static PetscErrorCode Decompose(const MpmInverseProblem *problem, const MpmEvaluation *evaluation, PetscInt rows,
                                MpmSingular *singular)
{
  const PetscInt count = problem->count, all = PetscMax(rows, count);
  PetscReal     *scaled;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((all * count), &scaled));
  for (PetscInt i = 0; i < rows; i++)
    for (PetscInt k = 0; k < count; k++)
      scaled[i * count + k] = evaluation->jacobian[i * count + k] * Scale(problem, evaluation, k);
  PetscCall(MpmSingularCreate(all, count, scaled, singular));
  PetscCall(PetscFree(scaled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The data alone. */
static PetscErrorCode FindSensitivities(const MpmInverseProblem *problem, const MpmEvaluation *evaluation,
                                        MpmStatistics *statistics)
{
  const PetscInt count = problem->count, rows = evaluation->data.count;
  MpmSingular    singular;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < count; k++) {
    PetscReal sum = 0.;

    for (PetscInt i = 0; i < rows; i++)
      sum += PetscSqr(evaluation->jacobian[i * count + k] * Scale(problem, evaluation, k));
    statistics->sensitivity[k] = PetscSqrtReal(sum / (PetscReal)PetscMax(rows, 1));
  }
  PetscCall(Decompose(problem, evaluation, rows, &singular));
  for (PetscInt i = 0; i < count; i++) {
    statistics->singular[i] = singular.value[i];
    if (singular.value[i] <= MPM_NOT_TOLD * singular.value[0]) statistics->untold++;
  }
  PetscCall(PetscArraycpy(statistics->combination, singular.v, (count * count)));
  PetscCall(MpmSingularDestroy(&singular));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmStatisticsTakesPart(const MpmStatistics *statistics, PetscInt i, PetscInt k)
{
  const PetscInt count   = statistics->count;
  PetscReal      largest = 0.;

  for (PetscInt l = 0; l < statistics->count; l++)
    largest = PetscMax(largest, PetscAbsReal(statistics->combination[l * count + i]));
  return (PetscBool)(PetscAbsReal(statistics->combination[k * count + i]) > PART * largest);
}

/* a . (A^T A)^-1 b; infinite where it has a part in a combination that is not told. */
static PetscReal Covariance(const MpmSingular *singular, const PetscReal a[], const PetscReal b[])
{
  PetscReal sum = 0.;

  for (PetscInt i = 0; i < singular->count; i++) {
    PetscReal left = 0., right = 0., size = 0.;

    for (PetscInt k = 0; k < singular->columns; k++) {
      left += a[k] * singular->v[k * singular->count + i];
      right += b[k] * singular->v[k * singular->count + i];
      size += PetscAbsReal(a[k] * b[k]) + PetscSqr(a[k]) + PetscSqr(b[k]);
    }
    if (singular->value[i] > MPM_NOT_TOLD * singular->value[0]) sum += left * right / PetscSqr(singular->value[i]);
    else if (PetscAbsReal(left * right) > PART * PART * size) return PETSC_INFINITY;
  }
  return sum;
}

/* Covariance of the parameters and variance of predictions. */
static PetscErrorCode FindCovariance(const MpmInverseProblem *problem, const MpmEvaluation *evaluation,
                                     MpmStatistics *statistics)
{
  const PetscInt count = problem->count;
  PetscReal     *a, *b;
  MpmSingular    singular;

  PetscFunctionBeginUser;
  PetscCall(Decompose(problem, evaluation, evaluation->rows, &singular));
  PetscCall(PetscCalloc2(count, &a, count, &b));
  for (PetscInt k = 0; k < count; k++) {
    for (PetscInt l = 0; l < count; l++) {
      PetscCall(PetscArrayzero(a, count));
      PetscCall(PetscArrayzero(b, count));
      a[k]                                  = Scale(problem, evaluation, k);
      b[l]                                  = Scale(problem, evaluation, l);
      statistics->covariance[k * count + l] = statistics->variance * Covariance(&singular, a, b);
    }
  }
  for (PetscInt p = 0; p < evaluation->predicted; p++) {
    for (PetscInt k = 0; k < count; k++)
      a[k] = evaluation->prediction_slopes[p * count + k] * Scale(problem, evaluation, k);
    statistics->prediction[p] = PetscSqrtReal(statistics->variance * Covariance(&singular, a, a));
  }
  PetscCall(PetscFree2(a, b));
  PetscCall(MpmSingularDestroy(&singular));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bounds of the parameters, and correlations. */
static void FindIntervals(const MpmInverseProblem *problem, const MpmEvaluation *evaluation, MpmStatistics *statistics)
{
  const PetscInt   count = problem->count;
  const PetscReal *c     = statistics->covariance;

  for (PetscInt k = 0; k < count; k++) {
    const PetscReal          width = statistics->quantile * PetscSqrtReal(c[k * count + k]);
    const MpmParameterRange *range = &problem->ranges->at[k];

    statistics->lower[k] = MpmRangeValue(range, evaluation->t[k] - width);
    statistics->upper[k] = MpmRangeValue(range, evaluation->t[k] + width);
    for (PetscInt l = 0; l < count; l++)
      statistics->correlation[k * count + l] =
        k == l ? 1. : c[k * count + l] / PetscSqrtReal(c[k * count + k] * c[l * count + l]);
  }
}

PetscErrorCode MpmStatisticsCreate(const MpmInverseProblem *problem, const MpmEvaluation *evaluation,
                                   MpmStatistics *statistics)
{
  PetscReal sum = 0.;

  PetscFunctionBeginUser;
  PetscCall(Allocate(problem, evaluation, statistics));
  for (PetscInt i = 0; i < evaluation->rows; i++) sum += PetscSqr(evaluation->residual[i]);
  statistics->variance = statistics->degrees ? sum / (PetscReal)statistics->degrees : 1.;
  statistics->quantile = MpmStudentQuantile(0.975, statistics->degrees ? statistics->degrees : LARGE_DEGREES);
  PetscCall(FindSensitivities(problem, evaluation, statistics));
  PetscCall(FindCovariance(problem, evaluation, statistics));
  FindIntervals(problem, evaluation, statistics);
  PetscFunctionReturn(PETSC_SUCCESS);
}
