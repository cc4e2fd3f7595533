#pragma once
/*
  Numbers of a run that are differentiated: a column's last value, or its distance from data.
*/
#include "base/base.h"
#include "base/types.h"
#include "files/csv_table.h"
#include "sensitivity/regularization.h"
#include "talus/talus.h"

typedef enum {
  MPM_OBJECTIVE_MISFIT,
  MPM_OBJECTIVE_VALUE,
  MPM_OBJECTIVE_PREDICTION, /* last value of a column, no part of the objective */
  MPM_OBJECTIVE_ABSCISSA    /* column that data of another objective are over, no part of the objective */
} MpmObjectiveKind;

/*
  One objective. Misfit: 1/2 sum_k ((y(x_k) - d_k)/deviation)^2 over the data, y linear between the steps, x the time or
  another column; or the same of the last value and a target.
*/
typedef struct {
  char            *name, *column;
  MpmObjectiveKind kind;
  PetscReal        deviation; /* in the column's unit */
  PetscBool        at_end;
  PetscReal        target;
  char            *over;       /* column of the abscissa; NULL: the time */
  PetscInt         over_curve; /* its place among the objectives, -1: the time */
  MpmCsvTable      data;
  PetscInt         place, value, spread; /* columns of the data: abscissa, value, deviation a row or -1 */
  PetscInt         row, part;            /* of the history's columns */
} MpmObjective;

/* Those asked for, then predictions and abscissae; regularizations have no column. */
typedef struct {
  PetscInt           count, asked, predicted;
  PetscInt           name_count; /* of the list: those asked for, and regularizations */
  char             **names, **predictions;
  MpmObjective      *at;
  PetscInt           regular_count;
  MpmRegularization *regular;
} MpmObjectives;

/* The objectives' columns over a run, after each step, the start first. */
typedef struct {
  PetscInt         rows, count;
  const PetscReal *time, *value; /* value[row*count + o] */
} MpmCurves;

/* `end`: time of the run's, which data do not pass; 0: not known yet. */
PetscErrorCode MpmObjectivesRead(const MpmOptions *options, PetscReal end, MpmObjectives *objectives);
PetscErrorCode MpmObjectivesDestroy(MpmObjectives *objectives);
/* The column of each among these; refuses one without derivatives. */
PetscErrorCode MpmObjectivesFind(const MpmColumns *columns, MpmObjectives *objectives);
