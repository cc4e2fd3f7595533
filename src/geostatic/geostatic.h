#pragma once
/*
  Geostatic stages (geostatic.c, k0_balance.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* The points of a geostatic stage (geostatic.c): their state to return to, and data of the report. */
typedef struct {
  PetscInt   n;
  PetscReal *x, *volume, *domain;          /* position, volume, half lengths of the domain */
  PetscReal *mass;                         /* with the water taken up */
  PetscReal *value, *value_gradient, *own; /* of the water, which stays */
  PetscReal *F;                            /* before the step under way */
  PetscReal *start;                        /* the stress that k0 gave, or NULL */
  PetscReal  height;
  PetscBool *stateful; /* per material */
  PetscReal  moved;    /* largest displacement of the last step */
  PetscReal  correction, largest;
  PetscInt64 outside; /* points that the yield surface moved */
} MpmRest;

/* One step under `scale` times the loads; stress and history stay, and the points go back to where they were. */
PetscErrorCode MpmRestSettle(MpmModel model, MpmRest *rest, PetscReal scale, MpmOutcome *outcome);
/* After a change of volume0 and F: restores the points' masses. */
PetscErrorCode MpmRestKeepMass(MpmModel model, const MpmRest *rest);
/* Gives all points the stage's stress of k0, and F and history with it (k0_balance.c). */
PetscErrorCode MpmRestSetK0(MpmModel model, MpmRest *rest);
/* Rows of the state (base/rows.h). */
PetscErrorCode MpmGeostaticAddRows(MpmModel model);
/* The whole of a geostatic stage (geostatic.c). */
PetscErrorCode MpmGeostaticRun(MpmModel model, MpmOutcome *outcome);
