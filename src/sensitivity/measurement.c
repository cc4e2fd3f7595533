/*
  Measurements: a curve of the run at the places of the data, linear between the steps.

  Between rows n and n + 1 of abscissa a and value y the value at the place x is

    y(x) = (1 - s) y_n + s y_{n+1} ,   s = (x - a_n)/(a_{n+1} - a_n) ,

  with derivatives by all four. The abscissa is the time, or a column that depends on the parameters itself.
*/
#include "sensitivity/measurement.h"

#define SLACK 1e-9 /* of the abscissa's range: distance outside of it that is rounding */

static PetscReal Value(const MpmCurves *curves, PetscInt curve, PetscInt row)
{
  return curve < 0 ? curves->time[row] : curves->value[row * curves->count + curve];
}

/* The first interval from `from` on that contains the place; -1: none. */
static PetscInt FindInterval(const MpmCurves *curves, PetscInt abscissa, PetscInt from, PetscReal place)
{
  const PetscReal slack = SLACK * PetscAbsReal(Value(curves, abscissa, curves->rows - 1) - Value(curves, abscissa, 0));

  for (PetscInt n = from; n + 1 < curves->rows; n++) {
    const PetscReal a = Value(curves, abscissa, n), b = Value(curves, abscissa, n + 1);

    if (a != b && place >= PetscMin(a, b) - slack && place <= PetscMax(a, b) + slack) return n;
  }
  return -1;
}

/* The curve at a place of the interval. */
static void Interpolate(const MpmObjective *objective, PetscInt curve, const MpmCurves *curves, PetscInt n,
                        MpmMeasurement *measurement)
{
  const PetscReal a = Value(curves, objective->over_curve, n), b = Value(curves, objective->over_curve, n + 1);
  const PetscReal low = Value(curves, curve, n), high = Value(curves, curve, n + 1);
  const PetscReal part = PetscClipInterval((measurement->place - a) / (b - a), 0., 1.);

  measurement->computed = (1. - part) * low + part * high;
  measurement->by[0]    = (MpmCurveSlope){curve, n, 1. - part};
  measurement->by[1]    = (MpmCurveSlope){curve, n + 1, part};
  measurement->count    = 2;
  if (objective->over_curve < 0) return;
  measurement->by[2] = (MpmCurveSlope){objective->over_curve, n, -(1. - part) * (high - low) / (b - a)};
  measurement->by[3] = (MpmCurveSlope){objective->over_curve, n + 1, -part * (high - low) / (b - a)};
  measurement->count = 4;
}

/* The rows of an objective's data. */
static PetscErrorCode FindData(const MpmObjective *objective, PetscInt curve, const MpmCurves *curves,
                               MpmMeasurement at[])
{
  const MpmCsvTable *data = &objective->data;
  PetscInt           from = 0;

  PetscFunctionBeginUser;
  for (PetscInt64 k = 0; k < data->rows; k++) {
    const PetscReal *row   = &data->value[k * data->columns];
    const PetscReal  place = row[objective->place], spread = objective->spread >= 0 ? row[objective->spread] : 0.;
    const PetscInt   n = FindInterval(curves, objective->over_curve, from, place);

    MpmCheckInput(n >= 0, "-mpm_objective_%s_data: %s %g lies outside of the run's steps, %g to %g", objective->name,
                  objective->over ? objective->over : "time", (double)place,
                  (double)Value(curves, objective->over_curve, 0),
                  (double)Value(curves, objective->over_curve, curves->rows - 1));
    at[k] = (MpmMeasurement){.place     = place,
                             .measured  = row[objective->value],
                             .deviation = objective->spread >= 0 ? spread : objective->deviation};
    Interpolate(objective, curve, curves, n, &at[k]);
    from = n;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscInt CountOf(const MpmObjective *objective)
{
  if (objective->kind != MPM_OBJECTIVE_MISFIT) return 0;
  return objective->data.value ? (PetscInt)objective->data.rows : 1;
}

PetscErrorCode MpmMeasurementsFind(const MpmObjectives *objectives, const MpmCurves *curves,
                                   MpmMeasurements *measurements)
{
  const PetscInt last = curves->rows - 1;

  PetscFunctionBeginUser;
  measurements->count = 0;
  for (PetscInt o = 0; o < objectives->count; o++) measurements->count += CountOf(&objectives->at[o]);
  PetscCall(PetscCalloc1(measurements->count + 1, &measurements->at));
  for (PetscInt o = 0, first = 0; o < objectives->count; o++) {
    const MpmObjective *objective = &objectives->at[o];
    MpmMeasurement     *at        = &measurements->at[first];

    if (!CountOf(objective)) continue;
    if (objective->data.value) PetscCall(FindData(objective, o, curves, at));
    else
      *at = (MpmMeasurement){.place     = curves->time[last],
                             .measured  = objective->target,
                             .computed  = Value(curves, o, last),
                             .deviation = objective->deviation,
                             .count     = 1,
                             .by        = {{o, last, 1.}}};
    for (PetscInt k = 0; k < CountOf(objective); k++) at[k].objective = o;
    first += CountOf(objective);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMeasurementsDestroy(MpmMeasurements *measurements)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(measurements->at));
  measurements->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmObjectivesEvaluate(const MpmObjectives *objectives, const MpmCurves *curves, PetscReal *sum,
                                     PetscReal weights[])
{
  MpmMeasurements measurements = {0};
  const PetscInt  last         = curves->rows - 1;

  PetscFunctionBeginUser;
  *sum = 0.;
  for (PetscInt k = 0; k < objectives->count * curves->rows; k++) weights[k] = 0.;
  for (PetscInt o = 0; o < objectives->count; o++) {
    if (objectives->at[o].kind != MPM_OBJECTIVE_VALUE) continue;
    *sum += Value(curves, o, last);
    weights[o * curves->rows + last] = 1.;
  }
  PetscCall(MpmMeasurementsFind(objectives, curves, &measurements));
  for (PetscInt k = 0; k < measurements.count; k++) {
    const MpmMeasurement *at  = &measurements.at[k];
    const PetscReal       gap = (at->computed - at->measured) / at->deviation;

    *sum += 0.5 * gap * gap;
    for (PetscInt i = 0; i < at->count; i++)
      weights[at->by[i].curve * curves->rows + at->by[i].row] += gap / at->deviation * at->by[i].slope;
  }
  PetscCall(MpmMeasurementsDestroy(&measurements));
  PetscFunctionReturn(PETSC_SUCCESS);
}
