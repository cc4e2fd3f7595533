#pragma once
/*
  Numbers of a run that are differentiated: a column's last value, or its distance from data.
*/
#include "base/base.h"
#include "base/types.h"
#include "io/csv_table.h"
#include "talus/talus.h"

typedef enum { MPM_OBJECTIVE_MISFIT, MPM_OBJECTIVE_VALUE } MpmObjectiveKind;

/*
  One objective. Misfit: 1/2 sum_k ((y(t_k) - d_k)/deviation)^2 over the data, y linear in time between the steps, or
  the same of the last value and a target.
*/
typedef struct {
  char            *name, *column;
  MpmObjectiveKind kind;
  PetscReal        deviation; /* in the column's unit */
  PetscBool        at_end;
  PetscReal        target;
  MpmCsvTable      data;
  PetscInt         time, value; /* columns of the data */
  PetscInt         row, part;   /* of the history's columns */
} MpmObjective;

typedef struct {
  PetscInt      count;
  char        **names;
  MpmObjective *at;
} MpmObjectives;

/* A column's values over a run, at the times of its steps. */
typedef struct {
  PetscInt         count;
  const PetscReal *time, *value;
} MpmCurve;

PetscErrorCode MpmObjectivesRead(MpmModel model, const MpmOptions *options, MpmObjectives *objectives);
PetscErrorCode MpmObjectivesDestroy(MpmObjectives *objectives);
/* The column of each among these; refuses one without derivatives. */
PetscErrorCode MpmObjectivesFind(const MpmColumns *columns, MpmObjectives *objectives);
/* The objective, and its derivatives by the curve's values. */
PetscErrorCode MpmObjectiveEvaluate(const MpmObjective *objective, const MpmCurve *curve, PetscReal *value,
                                    PetscReal weight[]);
