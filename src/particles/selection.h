#pragma once
/*
  Points picked in the initial state, by place or by region.
*/
#include "base/base.h"
#include "base/types.h"

/* Some of the points: those in a region, or, without one, those nearest to a place. */
typedef struct {
  MpmRegion region;
  PetscReal at[MPM_MAX_DIM];
  PetscInt  nearest; /* how many; 0: by region */
} MpmSelection;

/* Reads `at` and `nearest`, or a region; exactly one of the two ways. */
PetscErrorCode MpmSelectionRead(const MpmOptions *block, const MpmGrid *grid, MpmSelection *selection);
/*
  Each point's share in the selection, 0 outside: 1/nearest, or the point's part of the volume of all points in the region.
  `total` points are there; errors name the option -mpm_<prefix>_<name>_nearest or _region.
*/
PetscErrorCode MpmSelectionShare(const MpmSelection *selection, const MpmGrid *grid, const MpmPoints *points,
                                 PetscInt64 total, const char *prefix, const char *name, PetscReal share[]);
