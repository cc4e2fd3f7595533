#pragma once
/*
  How sure the parameters of an inverse analysis are.
*/
#include "inverse/problem.h"

/*
  With r the residuals of data and priors, J their derivatives by the transformed parameters t:

    s^2 = r.r/(n - p) ,   C = s^2 (J^T J)^-1 ,   t +- q sqrt(C_kk) ,

  q Student's 97.5 % quantile of n - p degrees of freedom; with no degree of freedom s = 1 and q that of 1 000 000.
  Predictions have the variance g.C g with their derivatives g. Composite scaled sensitivities are root mean squares
  of p dy/dp over the deviations of the data y. Singular values are those of p dy/dp over the deviations: where one is
  below `MPM_NOT_TOLD` of the largest, the data do not tell the combination of its vector.
*/
#define MPM_NOT_TOLD 1e-8

typedef struct {
  PetscInt   count, rows, degrees;
  PetscReal  variance, quantile;
  PetscReal *covariance, *correlation; /* [k * count + l], of t */
  PetscReal *lower, *upper;            /* of p, 95 % */
  PetscReal *sensitivity;              /* composite scaled */
  PetscReal *singular, *combination;   /* [i], [k * count + i]: by relative changes of p */
  PetscInt   untold;                   /* singular values that are not told, the last ones */
  PetscReal *prediction;               /* standard deviation of each */
} MpmStatistics;

PetscErrorCode MpmStatisticsCreate(const MpmInverseProblem *problem, const MpmEvaluation *evaluation,
                                   MpmStatistics *statistics);
PetscErrorCode MpmStatisticsDestroy(MpmStatistics *statistics);
/* True where the parameter has a part in the combination of this singular value. */
PetscBool MpmStatisticsTakesPart(const MpmStatistics *statistics, PetscInt i, PetscInt k);
