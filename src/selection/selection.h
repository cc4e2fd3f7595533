#pragma once
/*
  Points picked in the initial state, by place or by region. Points of air are none of them (point/air.h).
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
  Each point's share in the selection, 0 outside and for air: 1/nearest, or the point's fraction of the volume of all
  points in the region. Of points that are equally far those with the smaller ids are taken. Errors name the option
  -mpm_<prefix>_<name>_at, _nearest or _region.
*/
PetscErrorCode MpmSelectionShare(const MpmSelection *selection, const MpmGrid *grid, const MpmPoints *points,
                                 const MpmMaterials *materials, const char *prefix, const char *name,
                                 PetscReal share[]);

/* Reads -<prefix>body, the name of a body; its number, or -1 where none is given. */
PetscErrorCode MpmBodyNameRead(const MpmOptions *block, const char *help, const MpmBodies *bodies, PetscInt *body);
/*
  Sets a field of the particles to 1 at the points of a body (-1: of any) that lie in a region (NULL: anywhere) in the
  initial state, and to 0 at the others; `chosen` is how many they are. The bodies' points have been made.
*/
PetscErrorCode MpmPointsChoose(const MpmBodies *bodies, PetscInt body, MpmRegion region, const char *field,
                               MpmParticles *particles, PetscInt64 *chosen);
