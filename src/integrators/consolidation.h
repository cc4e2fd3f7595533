#pragma once
/*
  Consolidation of a stage: report, and end of the stage (consolidation.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* A line on the length of the stage that begins beside the time of consolidation (consolidation.c). Collective. */
PetscErrorCode MpmWaterTellStage(MpmModel model);
/* Rows of the state (base/rows.h). */
PetscErrorCode MpmConsolidationAddRows(MpmModel model);
/* The column of the degree, where a stage ends at one. */
PetscErrorCode MpmConsolidationAddColumns(MpmModel model, MpmColumns *columns);
/*
  The end of a stage at a degree of consolidation (consolidation.c). Begin, before a stage's first step, finds the
  steady pressure, which points have in a field of this name; Observe follows each accepted step. Collective.
*/
PetscErrorCode           MpmConsolidationBegin(MpmModel model);
PetscErrorCode           MpmConsolidationObserve(MpmModel model);
extern const char *const MpmConsolidationField;
