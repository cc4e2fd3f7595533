#pragma once
/*
  Remedies where a step fails: a table, tried in order (remedies.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* The remedies of one step. */
typedef struct {
  PetscBool seeks;    /* the step belongs to the search of a factor of safety, with F-bar */
  PetscBool dilation; /* F-bar averages dilation in this step alone */
  PetscBool again;    /* the next attempt is a shorter one from an unchanged state */
  PetscBool over;     /* no remedy is left, or the stage has ended */
} MpmRemedies;

/* Before the first attempt of a step. */
void MpmRemediesBegin(const MpmModel model, MpmRemedies *remedies);
/* After an attempt to reach `next` in `dt` that failed. With `over` the outcome is that of the step. */
PetscErrorCode MpmRemediesTry(MpmModel model, PetscReal next, PetscReal dt, MpmRemedies *remedies, MpmOutcome *outcome);
/* After the step has succeeded: ends remedies that serve one step. */
PetscErrorCode MpmRemediesUndo(MpmModel model, const MpmRemedies *remedies);
