/*
  Results of an inverse analysis: a block of the summary, tables, lines on the terminal.
*/
#include <math.h>
#include "inverse/output.h"

/* ---- JSON ---- */

/* A number, null where it is infinite or none. */
static PetscErrorCode Number(char **text, const char before[], PetscReal value)
{
  PetscFunctionBeginUser;
  if (isfinite(value)) PetscCall(MpmTextAppend(text, "%s%.17g", before, (double)value));
  else PetscCall(MpmTextAppend(text, "%snull", before));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode List(char **text, const char key[], PetscInt count, const PetscReal values[])
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(text, ", \"%s\": [", key));
  for (PetscInt k = 0; k < count; k++) PetscCall(Number(text, k ? ", " : "", values[k]));
  PetscCall(MpmTextAppend(text, "]"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Square(char **text, const char key[], PetscInt count, const PetscReal values[])
{
  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(text, ", \"%s\": [", key));
  for (PetscInt k = 0; k < count; k++) {
    for (PetscInt l = 0; l < count; l++) PetscCall(Number(text, l ? ", " : k ? ", [" : "[", values[k * count + l]));
    PetscCall(MpmTextAppend(text, "]"));
  }
  PetscCall(MpmTextAppend(text, "]"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names of the parameters that take part in a combination. */
static PetscErrorCode Combination(const MpmInverse *inverse, const MpmStatistics *statistics, PetscInt i,
                                  const char quote[], char **text)
{
  PetscBool any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < statistics->count; k++) {
    if (!MpmStatisticsTakesPart(statistics, i, k)) continue;
    PetscCall(MpmTextAppend(text, "%s%s%s%s", any ? ", " : "", quote, inverse->problem.ranges->at[k].name, quote));
    any = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendParameters(const MpmInverse *inverse, char **text)
{
  const MpmInverseProblem *problem = &inverse->problem;

  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(text, ", \"parameters\": ["));
  for (PetscInt k = 0; k < problem->count; k++)
    PetscCall(MpmTextAppend(text, "%s\"%s\"", k ? ", " : "", problem->ranges->at[k].name));
  PetscCall(MpmTextAppend(text, "], \"values\": ["));
  for (PetscInt k = 0; k < problem->count; k++)
    PetscCall(Number(text, k ? ", " : "", MpmRangeValue(&problem->ranges->at[k], inverse->best.t[k])));
  PetscCall(MpmTextAppend(text, "]"));
  PetscCall(List(text, "transformed", problem->count, inverse->best.t));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Statistics of the residuals of the data. */
static PetscErrorCode AppendResiduals(const MpmInverse *inverse, char **text)
{
  const MpmEvaluation *best    = &inverse->best;
  const PetscInt       count   = best->data.count;
  PetscReal            squares = 0., mean = 0., largest = 0.;
  PetscInt             at = 0;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < count; i++) {
    squares += PetscSqr(best->residual[i]);
    mean += best->residual[i] / (PetscReal)count;
    if (PetscAbsReal(best->residual[i]) > largest) at = i;
    largest = PetscMax(largest, PetscAbsReal(best->residual[i]));
  }
  PetscCall(MpmTextAppend(text, ", \"residuals\": {\"count\": %d", (int)count));
  PetscCall(Number(text, ", \"sum_of_squares\": ", squares));
  PetscCall(Number(text, ", \"mean\": ", mean));
  PetscCall(Number(text, ", \"largest\": ", largest));
  if (count)
    PetscCall(MpmTextAppend(text, ", \"largest_of\": \"%s\"",
                            inverse->problem.objectives->at[best->data.at[at].objective].name));
  PetscCall(MpmTextAppend(text, "}"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendPredictions(const MpmInverse *inverse, const MpmStatistics *statistics, char **text)
{
  const MpmObjectives *objectives = inverse->problem.objectives;

  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(text, ", \"predictions\": {"));
  for (PetscInt p = 0; p < inverse->best.predicted; p++) {
    const PetscReal value = inverse->best.prediction[p], width = statistics->quantile * statistics->prediction[p];

    PetscCall(MpmTextAppend(text, "%s\"%s\": {", p ? ", " : "", objectives->predictions[p]));
    PetscCall(Number(text, "\"value\": ", value));
    PetscCall(Number(text, ", \"deviation\": ", statistics->prediction[p]));
    PetscCall(Number(text, ", \"lower\": ", value - width));
    PetscCall(Number(text, ", \"upper\": ", value + width));
    PetscCall(MpmTextAppend(text, "}"));
  }
  PetscCall(MpmTextAppend(text, "}"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AppendStatistics(const MpmInverse *inverse, const MpmStatistics *statistics, char **text)
{
  const PetscInt count = statistics->count;

  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(text, ", \"degrees_of_freedom\": %d", (int)statistics->degrees));
  PetscCall(Number(text, ", \"variance\": ", statistics->variance));
  PetscCall(List(text, "lower", count, statistics->lower));
  PetscCall(List(text, "upper", count, statistics->upper));
  PetscCall(Square(text, "covariance", count, statistics->covariance));
  PetscCall(Square(text, "correlation", count, statistics->correlation));
  PetscCall(List(text, "sensitivities", count, statistics->sensitivity));
  PetscCall(List(text, "singular_values", count, statistics->singular));
  PetscCall(MpmTextAppend(text, ", \"not_told_apart\": ["));
  for (PetscInt i = count - statistics->untold; i < count; i++) {
    PetscCall(MpmTextAppend(text, "%s[", i > count - statistics->untold ? ", " : ""));
    PetscCall(Combination(inverse, statistics, i, "\"", text));
    PetscCall(MpmTextAppend(text, "]"));
  }
  PetscCall(MpmTextAppend(text, "]"));
  PetscCall(AppendPredictions(inverse, statistics, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseText(const MpmInverse *inverse, const MpmStatistics *statistics, char **text)
{
  static const char *const methods[] = {"gauss_newton", "blmvm", "descent"};

  PetscFunctionBeginUser;
  *text = NULL;
  PetscCall(MpmTextAppend(text, "{\"method\": \"%s\", \"iterations\": %d, \"evaluations\": %d, \"converged\": %s",
                          methods[inverse->settings->method], (int)inverse->iterations,
                          (int)inverse->problem.evaluations, inverse->converged ? "true" : "false"));
  PetscCall(MpmTextAppend(text, ", \"reason\": \"%s\"", inverse->reason));
  PetscCall(Number(text, ", \"objective\": ", inverse->best.objective));
  PetscCall(AppendParameters(inverse, text));
  PetscCall(MpmInverseAppendFields(inverse, text));
  PetscCall(AppendResiduals(inverse, text));
  if (statistics) PetscCall(AppendStatistics(inverse, statistics, text));
  PetscCall(MpmTextAppend(text, "}"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- tables ---- */

/* The file PREFIX_NAME.csv. */
static PetscErrorCode Write(const MpmInverse *inverse, const char name[], MpmTextFile *text)
{
  const MpmTextFile *texts[] = {text};
  char               path[PETSC_MAX_PATH_LEN];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(path, sizeof(path), "%s_%s.csv", inverse->problem.prefix, name));
  PetscCall(MpmTextFileWrite(inverse->problem.comm, path, 1, texts));
  PetscCall(MpmTextFileDestroy(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Number of a datum within its objective, from 1 on. */
static PetscInt Rank(const MpmMeasurements *data, PetscInt i)
{
  PetscInt first = i;

  while (first && data->at[first - 1].objective == data->at[i].objective) first--;
  return i - first + 1;
}

PetscErrorCode MpmInverseWriteJacobian(const MpmInverse *inverse)
{
  const MpmInverseProblem *problem    = &inverse->problem;
  const MpmEvaluation     *best       = &inverse->best;
  const MpmObjectives     *objectives = problem->objectives;
  MpmTextFile              text       = MPM_TEXT_FILE_EMPTY;

  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(&text, "data"));
  for (PetscInt k = 0; k < problem->count; k++) PetscCall(MpmTextFileAppend(&text, ",%s", problem->ranges->at[k].name));
  PetscCall(MpmTextFileAppend(&text, "\n"));
  for (PetscInt i = 0; i < best->data.count; i++) {
    const MpmMeasurement *at = &best->data.at[i];

    PetscCall(MpmTextFileAppend(&text, "%s_%d", objectives->at[at->objective].name, (int)Rank(&best->data, i)));
    for (PetscInt k = 0; k < problem->count; k++)
      PetscCall(MpmTextFileAppend(&text, ",%.17g",
                                  (double)(best->jacobian[i * problem->count + k] * at->deviation /
                                           MpmRangeSlope(&problem->ranges->at[k], best->t[k]))));
    PetscCall(MpmTextFileAppend(&text, "\n"));
  }
  PetscCall(Write(inverse, "jacobian", &text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInverseWriteResiduals(const MpmInverse *inverse)
{
  const MpmEvaluation *best       = &inverse->best;
  const MpmObjectives *objectives = inverse->problem.objectives;
  MpmTextFile          text       = MPM_TEXT_FILE_EMPTY;

  PetscFunctionBeginUser;
  PetscCall(MpmTextFileAppend(&text, "data,objective,place,measured,computed,deviation,residual\n"));
  for (PetscInt i = 0; i < best->data.count; i++) {
    const MpmMeasurement *at   = &best->data.at[i];
    const char           *name = objectives->at[at->objective].name;

    PetscCall(MpmTextFileAppend(&text, "%s_%d,%s,%.17g,%.17g,%.17g,%.17g,%.17g\n", name, (int)Rank(&best->data, i),
                                name, (double)at->place, (double)at->measured, (double)at->computed,
                                (double)at->deviation, (double)best->residual[i]));
  }
  PetscCall(Write(inverse, "residuals", &text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the terminal ---- */

static PetscErrorCode PrintParameter(const MpmInverse *inverse, const MpmStatistics *statistics, PetscInt k)
{
  const MpmParameterRange *range = &inverse->problem.ranges->at[k];
  const MPI_Comm           comm  = inverse->problem.comm;

  PetscFunctionBeginUser;
  PetscCall(PetscPrintf(comm, "  %-24s %.8g", range->name, (double)MpmRangeValue(range, inverse->best.t[k])));
  if (statistics)
    PetscCall(PetscPrintf(comm, ", 95 %% within %.4g to %.4g, composite scaled sensitivity %.3g",
                          (double)statistics->lower[k], (double)statistics->upper[k],
                          (double)statistics->sensitivity[k]));
  PetscCall(PetscPrintf(comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmInversePrint(const MpmInverse *inverse, const MpmStatistics *statistics)
{
  const MPI_Comm comm = inverse->problem.comm;

  PetscFunctionBeginUser;
  if (!inverse->problem.shows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPrintf(comm, "inverse analysis, %d iterations and %d runs: %s; objective %.6g\n",
                        (int)inverse->iterations, (int)inverse->problem.evaluations, inverse->reason,
                        (double)inverse->best.objective));
  for (PetscInt k = 0; k < inverse->problem.ranges->numbers; k++) PetscCall(PrintParameter(inverse, statistics, k));
  PetscCall(MpmInversePrintFields(inverse));
  for (PetscInt i = statistics ? statistics->count - statistics->untold : 0; statistics && i < statistics->count; i++) {
    char *text = NULL;

    PetscCall(Combination(inverse, statistics, i, "", &text));
    PetscCall(PetscPrintf(comm, "  not told apart: %s\n", text));
    PetscCall(PetscFree(text));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
