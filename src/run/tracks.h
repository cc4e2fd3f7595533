#pragma once
/*
  Sets of points that are followed.
*/
#include "base/base.h"
#include "base/types.h"
#include "particles/selection.h"

/* A set of points that is followed; the field holds each point's share of the mean. */
typedef struct {
  char        *name, *share_field;
  MpmSelection where;
} MpmTrack;

PetscErrorCode MpmTrackCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, MpmTrack *track);
PetscErrorCode MpmTrackDestroy(MpmTrack *track);
PetscErrorCode MpmTrackSelect(MpmTrack *track, const MpmGrid *grid, MpmParticles *particles);
PetscErrorCode MpmTrackEvaluate(const MpmTrack *track, MpmParticles *particles, PetscReal displacement[]);

/* Their mean velocity, in scenes with a dynamic stage. Collective, like Evaluate. */
PetscErrorCode MpmTrackVelocity(const MpmTrack *track, MpmParticles *particles, PetscReal velocity[]);

/* Sets of points that are followed, with the names of their blocks. */
typedef struct {
  PetscInt  count;
  char    **names;
  MpmTrack *at;
} MpmTracks;
