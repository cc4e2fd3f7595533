#pragma once
/*
  Discrepancy principle: data are fitted to the level of their noise, and not below.

  With n data of deviations s_i the squares of the residuals r_i/s_i add up to about n where the model is right. An
  analysis with more parameters than data ends where its sum S falls below c n, c the setting `discrepancy`. Between
  this iteration and the one before, parameters with c n (1 - `MPM_NOISE_BAND`) <= S <= c n are found by secants of
  ln S. Source: Morozov (1966), Soviet Math. Dokl. 7, 414-417; Engl, Hanke and Neubauer (1996), section 3.3.
*/
#include "inverse/analysis.h"

#define MPM_NOISE_BAND 0.05

/* An iteration: true where its misfit is at the level or below; otherwise its parameters are kept. */
PetscErrorCode MpmDiscrepancyFind(MpmInverse *inverse, const MpmEvaluation *at, PetscBool *met);
/* Parameters at the level, in the place of those below it, as an iteration of their own. */
PetscErrorCode MpmDiscrepancyReturn(MpmInverse *inverse, MpmEvaluation *at);
