#pragma once
/*
  A window of a depth-averaged flow: columns in it are handed over, others left.
*/
#include "options/options.h"
#include "base/base.h"
#include "handover/columns.h"

enum { MPM_WINDOW_INSIDE, MPM_WINDOW_OUTSIDE, MPM_WINDOW_LATER, MPM_WINDOW_MASSES };

typedef struct {
  PetscReal lower[2], upper[2]; /* m */
  PetscReal
    mass[MPM_WINDOW_MASSES]; /* kg over all ranks: in it, outside of it, and of the latter what comes in later */
  PetscReal time;            /* of the state, s */
  PetscInt  ids;
  char     *known; /* of each id: its column has been in the window; with inflow only */
} MpmWindow;

/* Drops columns whose centres lie outside. Collective. */
PetscErrorCode MpmWindowCut(MPI_Comm comm, MpmWindow *window, MpmFlowColumns *columns);
/* Appends those that come in in the states of the file after a step, with their times of entry. Collective. */
PetscErrorCode MpmWindowFollow(const MpmOptions *block, const char *path, const char *step, const MpmBed *bed,
                               MpmWindow *window, MpmFlowColumns *columns);
PetscErrorCode MpmWindowDestroy(MpmWindow *window);
