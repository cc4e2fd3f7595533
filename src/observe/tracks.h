#pragma once
/*
  Sets of points that are followed.
*/
#include "base/base.h"
#include "base/types.h"
#include "selection/selection.h"
#include "talus/talus.h"

/* A set of points that is followed; the field holds each point's share of the mean. */
typedef struct {
  char        *name, *share_field;
  MpmSelection where;
  PetscReal    there;      /* share of the points that were there when it was evaluated last */
  PetscBool    gone, told; /* there is none any more, and a note has said so */
} MpmTrack;

PetscErrorCode MpmTrackDestroy(MpmTrack *track);
PetscErrorCode MpmTrackSelect(MpmTrack *track, const MpmGrid *grid, const MpmMaterials *materials,
                              MpmParticles *particles);
/*
  Mean over the present points; nan once none is left. `waiting`: some points may not have joined a stage yet. `fewer`:
  points have gone since the last call.
*/
PetscErrorCode MpmTrackEvaluate(MpmTrack *track, MpmParticles *particles, PetscBool waiting, PetscReal displacement[],
                                PetscBool *fewer);

/* Their mean velocity, in scenes with a dynamic stage; after Evaluate. Collective, like it. */
PetscErrorCode MpmTrackVelocity(const MpmTrack *track, MpmParticles *particles, PetscReal velocity[]);

/* Sets of points that are followed, with the names of their blocks. */
typedef struct {
  PetscInt  count;
  char    **names;
  MpmTrack *at;
} MpmTracks;

/* Reads the tracks of a scene. */
PetscErrorCode MpmTracksRead(MpmModel model, const MpmOptions *options);
/* Columns of the history: displacements, and velocities in scenes with a dynamic stage. */
PetscErrorCode MpmTracksAddColumns(MpmModel model, MpmColumns *columns);
PetscErrorCode MpmTracksAddVelocities(MpmModel model, MpmColumns *columns);
