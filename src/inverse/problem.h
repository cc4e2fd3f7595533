#pragma once
/*
  The problem of an inverse analysis: parameters, and runs of the scene with any of their values.
*/
#include "sensitivity/measurement.h"
#include "sensitivity/penalty.h"
#include "query/parameter_range.h"
#include "talus/talus.h"

/* Derivatives that an evaluation is asked for. */
typedef enum { MPM_NO_SLOPES, MPM_GRADIENT_ONLY, MPM_JACOBIAN } MpmEvaluationSlopes;

typedef struct {
  MpmModel                  scene; /* as it was read; it is not run */
  MPI_Comm                  comm;
  const char               *prefix; /* of its results */
  PetscBool                 shows;  /* progress on the terminal */
  const MpmObjectives      *objectives;
  const MpmParameterRanges *ranges; /* of its parameters */
  PetscInt                  count;
  PetscInt                  evaluations; /* runs so far */
  PetscInt                  penalties;   /* regularizations */
  MpmPenalty               *penalty;
} MpmInverseProblem;

/*
  A run with the parameters t, transformed. Residuals are those of the data, over their deviations, then those of the
  priors and of the regularizations; the objective is half the sum of the data's and priors' squares, the
  regularizations, and the objectives of kind `value`.
*/
typedef struct {
  PetscBool       failed;               /* the objective is infinite */
  PetscBool       refused, interrupted; /* failed: values refused; ended by a signal */
  char            why[512];
  PetscReal      *t;
  PetscReal       objective;
  MpmMeasurements data;
  PetscInt        rows;
  PetscReal      *residual; /* `rows` */
  PetscReal      *gradient; /* of the objective; NULL: not asked for */
  PetscReal      *jacobian; /* [row * count + k], of the residuals; NULL: not asked for */
  PetscInt        predicted;
  PetscReal      *prediction, *prediction_slopes; /* [p], [p * count + k] */
} MpmEvaluation;

PetscErrorCode MpmInverseProblemCreate(MpmModel scene, MpmInverseProblem *problem);
PetscErrorCode MpmInverseProblemDestroy(MpmInverseProblem *problem);
/* Field f of the parameters. */
const MpmGround *MpmInverseField(const MpmInverseProblem *problem, PetscInt f);
/* Sum of the squares of the data's residuals. */
PetscReal MpmInverseSquares(const MpmEvaluation *evaluation);
/*
  Runs the scene with the parameters t. Derivatives are found where the objective is below `limit`. Collective, with
  equal t on all ranks. `evaluation` starts from zeros and holds one result at a time.
*/
PetscErrorCode MpmInverseEvaluate(MpmInverseProblem *problem, const PetscReal t[], MpmEvaluationSlopes slopes,
                                  PetscReal limit, MpmEvaluation *evaluation);
PetscErrorCode MpmEvaluationDestroy(MpmEvaluation *evaluation);
/* Sets the options of all parameters to those of t, in the database in force; fields have their values there. */
PetscErrorCode MpmInverseSetOptions(const MpmInverseProblem *problem, const PetscReal t[]);
/* A model of the scene with the options in force. */
PetscErrorCode MpmInverseModelCreate(const MpmInverseProblem *problem, MpmModel *model);
