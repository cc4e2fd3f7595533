#pragma once
/*
  Results of an inverse analysis.
*/
#include "inverse/analysis.h"
#include "inverse/statistics.h"

/* The block `inverse` of the summary, as JSON text to be freed; `statistics` may be NULL. */
PetscErrorCode MpmInverseText(const MpmInverse *inverse, const MpmStatistics *statistics, char **text);
/* PREFIX_jacobian.csv and PREFIX_residuals.csv, rank 0. */
PetscErrorCode MpmInverseWriteJacobian(const MpmInverse *inverse);
PetscErrorCode MpmInverseWriteResiduals(const MpmInverse *inverse);
/* PREFIX_field_NAME.csv of all fields, rank 0, and these as their files in the options in force (field_results.c). */
PetscErrorCode MpmInverseWriteFields(const MpmInverse *inverse);
PetscErrorCode MpmInverseSetFieldFiles(const MpmInverse *inverse);
/* Fields in the block of the summary, and on the terminal. */
PetscErrorCode MpmInverseAppendFields(const MpmInverse *inverse, char **text);
PetscErrorCode MpmInversePrintFields(const MpmInverse *inverse);
/* Parameters, intervals and combinations that are not told, on the terminal. */
PetscErrorCode MpmInversePrint(const MpmInverse *inverse, const MpmStatistics *statistics);
