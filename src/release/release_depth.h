#pragma once
/*
  Depths of a release.
*/
#include "grid/grid.h"
#include "maps/bed.h"
#include "maps/outline.h"

/* A map, or a number for each feature where it has no pixels. Start from zeros. */
typedef struct {
  MpmMap     map;
  PetscReal *number; /* [feature], m */
} MpmReleaseDepth;

/*
  Reads -<prefix>depth, a number, a map or an attribute of the outline, or fraction, of the bed's height, or the maps
  before and after, with -help too. Without an outline, pixels without data have no depth.
*/
PetscErrorCode MpmReleaseDepthRead(const MpmOptions *block, const MpmGrid *grid, const MpmBed *bed,
                                   const MpmOutline *outline, MpmReleaseDepth *depth);
PetscErrorCode MpmReleaseDepthDestroy(MpmReleaseDepth *depth);
