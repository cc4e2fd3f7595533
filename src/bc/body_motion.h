#pragma once
/*
  Motions: displacement that is prescribed to the points of a body, wherever they go.
*/
#include "base/base.h"
#include "base/types.h"

/* A motion of a body's points, or of those in a region at the start; value times ramp in total, along some axes. */
typedef struct {
  char     *name, *share_field; /* 1 at its points */
  PetscInt  body;
  MpmRegion region;
  PetscInt  component_count, component[MPM_MAX_DIM];
  PetscReal value[MPM_MAX_DIM];
  MpmRamp   ramp;
} MpmBodyMotion;

/* Motions, with the names of their blocks. */
typedef struct MpmBodyMotions {
  PetscInt       count;
  char         **names;
  MpmBodyMotion *at;
} MpmBodyMotions;

PetscErrorCode MpmBodyMotionCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                   const MpmBodies *bodies, MpmBodyMotion *motion);
PetscErrorCode MpmBodyMotionDestroy(MpmBodyMotion *motion);
/* Marks its points in the initial state; all bodies are there. */
PetscErrorCode MpmBodyMotionSelect(const MpmBodyMotion *motion, const MpmBodies *bodies, MpmParticles *particles);
/*
  Nodes that the points of each acting motion touch, from the points of any rank: marks[i*count + m] > 0 for local node
  i and motion m; NULL where none acts. Free it.
*/
PetscErrorCode MpmBodyMotionsTouch(const MpmBodyMotions *motions, const MpmActing *acting, const MpmGrid *grid,
                                   const MpmSpace *space, MpmParticles *particles, PetscReal **marks);
