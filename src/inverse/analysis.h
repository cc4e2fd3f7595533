#pragma once
/*
  An inverse analysis under way: its iterations, and the best parameters so far.
*/
#include "files/csv_table.h"
#include "io/io.h"
#include "query/inverse_settings.h"
#include "inverse/problem.h"

/* Rows of an earlier analysis that goes on (trace.c). */
typedef struct {
  MpmCsvTable table;
  PetscInt    start, iteration; /* of the last row; -1: there is none */
  PetscReal  *t, *best;         /* parameters of the last row, and of the row with the least objective */
  PetscReal   least;
} MpmEarlierRows;

typedef struct {
  MpmInverseProblem         problem;
  const MpmInverseSettings *settings;
  MpmHistory                trace; /* PREFIX_inverse.csv */
  MpmEarlierRows            earlier;
  PetscInt                  start, iteration; /* of these now */
  PetscInt                  iterations;       /* of the start with the best result */
  const char               *reason;           /* why the last start has ended */
  PetscBool                 converged, interrupted;
  PetscBool                 met;           /* the misfit is at the level of the noise */
  PetscReal                *above;         /* parameters of the last iteration above it; NULL: none */
  PetscReal                 above_squares; /* of their residuals */
  MpmEvaluation             best;
} MpmInverse;

/*
  A method: from t on, whose derivatives are in `at`, to the parameters that `at` has in the end. Each iteration is
  reported; the method ends where `stop` is true then.
*/
typedef PetscErrorCode (*MpmInverseMethodRun)(MpmInverse *inverse, MpmEvaluation *at);
PetscErrorCode MpmGaussNewtonRun(MpmInverse *inverse, MpmEvaluation *at);
PetscErrorCode MpmBlmvmRun(MpmInverse *inverse, MpmEvaluation *at);
PetscErrorCode MpmDescentRun(MpmInverse *inverse, MpmEvaluation *at);

/* A row of the iterations, and a line. */
PetscErrorCode MpmInverseReport(MpmInverse *inverse, PetscInt iteration, const MpmEvaluation *at, PetscBool *stop);
/* Sum of squared residuals of data at which an analysis ends (discrepancy.c); 0: none. */
PetscReal MpmInverseLevel(const MpmInverse *inverse, const MpmEvaluation *at);
/* The iteration from which a method goes on: 0 but for an analysis that was interrupted in this start. */
PetscInt MpmInverseFirst(const MpmInverse *inverse);
/* Size of parameter k for steps: |t| without a transform, 1 otherwise. */
PetscReal MpmInverseSize(const MpmInverse *inverse, const PetscReal t[], PetscInt k);
/* Brings t between the bounds. */
void MpmInverseClip(const MpmInverse *inverse, PetscReal t[]);

/* Rows of PREFIX_inverse.csv, where the analysis goes on from them; they come first in the new file. */
PetscErrorCode MpmTraceRead(MpmInverse *inverse);
PetscErrorCode MpmTraceClose(MpmInverse *inverse);
/* Point k, from 1 on, of a sequence that fills the bounds evenly. */
void MpmInverseStart(const MpmInverse *inverse, PetscInt k, PetscReal t[]);
