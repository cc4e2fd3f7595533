#pragma once
/*
  Settings of an inverse analysis, which finds parameters from data.
*/
#include "base/base.h"
#include "base/types.h"

typedef enum { MPM_GAUSS_NEWTON, MPM_BLMVM, MPM_DESCENT } MpmInverseMethod;

typedef struct MpmInverseSettings {
  PetscBool        on; /* the task is an inverse analysis */
  MpmInverseMethod method;
  PetscInt         iterations, starts;
  PetscReal        tolerance; /* change of the parameters, relative */
  PetscReal        rate;      /* of descent: step over gradient */
  PetscBool        restart;
  PetscReal discrepancy; /* of the squared residuals' sum over the number of data, where it ends; 0: it does not */
} MpmInverseSettings;

/* Reads the block -mpm_inverse_; of descent the rate must be there where the task is an inverse analysis. */
PetscErrorCode MpmInverseSettingsRead(const MpmOptions *options, MpmInverseSettings *settings);
