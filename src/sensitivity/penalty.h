#pragma once
/*
  Regularizations of a field as residuals (sensitivity/regularization.h has their equations).

  tikhonov   a residual for each pair of neighbours, (t_i - t_j)/s
  prior      L^-1 (t - m)/s, C = L L^T
  total_variation   residuals of the quadratic form with its gradient and a Hessian that is positive: those of tikhonov
                    over sqrt(v), v = sqrt(sum_j (t_i - t_j)^2 + e^2)/s, "lagged diffusivity"; their squares are not
                    the value. Source: Vogel and Oman (1996), doi:10.1137/0917016.
*/
#include "base/base.h"
#include "query/parameter_range.h"
#include "sensitivity/regularization.h"

typedef struct {
  const MpmRegularization *regular;
  PetscInt                 first, count; /* of its values among the parameters */
  PetscInt                 rows;
  PetscInt                *pair;   /* 2 a row: values, from `first` on; rows of one cell follow each other */
  PetscReal               *mean;   /* of a prior, transformed */
  PetscReal               *factor; /* of a prior: L, by columns, lower */
} MpmPenalty;

/* `ranges`: of the field's values. */
PetscErrorCode MpmPenaltyCreate(const MpmRegularization *regular, const MpmGround *ground, PetscInt first,
                                const MpmParameterRange ranges[], MpmPenalty *penalty);
PetscErrorCode MpmPenaltyDestroy(MpmPenalty *penalty);
/* Its part of the objective at the parameters t, and its residuals, `rows` of them. */
PetscErrorCode MpmPenaltyEvaluate(const MpmPenalty *penalty, const PetscReal t[], PetscReal *value,
                                  PetscReal residual[]);
/* Adds the derivatives by all parameters: J^T r. */
PetscErrorCode MpmPenaltyPull(const MpmPenalty *penalty, const PetscReal t[], const PetscReal residual[],
                              PetscReal gradient[]);
/* J, rows of `columns` numbers that begin as 0. */
PetscErrorCode MpmPenaltyFillJacobian(const MpmPenalty *penalty, const PetscReal t[], PetscInt columns,
                                      PetscReal jacobian[]);
/* Of a prior: z becomes s L z, or s L^T z; `count` numbers. */
PetscErrorCode MpmPenaltySpread(const MpmPenalty *penalty, PetscBool transposed, PetscReal z[]);
