#pragma once
/*
  Numbers of the data beside those of a run, and their derivatives by the run's curves.
*/
#include "sensitivity/objective.h"

/* Derivative by the value of a curve after a step. */
typedef struct {
  PetscInt  curve, row;
  PetscReal slope;
} MpmCurveSlope;

/* One number. Its part of the objective is 1/2 ((computed - measured)/deviation)^2. */
typedef struct {
  PetscInt      objective;
  PetscReal     place; /* abscissa: time or the column that the data are over */
  PetscReal     measured, computed, deviation;
  PetscInt      count;
  MpmCurveSlope by[4]; /* derivatives of what is computed */
} MpmMeasurement;

typedef struct {
  PetscInt        count;
  MpmMeasurement *at;
} MpmMeasurements;

/* Those of all objectives with data or a target; refuses data outside of the run. */
PetscErrorCode MpmMeasurementsFind(const MpmObjectives *objectives, const MpmCurves *curves,
                                   MpmMeasurements *measurements);
PetscErrorCode MpmMeasurementsDestroy(MpmMeasurements *measurements);
/* The sum of the objectives, and its derivatives by the curves' values: weights[o*rows + n]. */
PetscErrorCode MpmObjectivesEvaluate(const MpmObjectives *objectives, const MpmCurves *curves, PetscReal *sum,
                                     PetscReal weights[]);
