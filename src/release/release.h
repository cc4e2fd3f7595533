#pragma once
/*
  Points of material that is released on a bed: columns over an outline, or over what a map of depths covers.

  A lattice of boxes covers the outline. Boxes that its edge passes through are cut, so that the points' volume is the
  integral of the depth over the outline; parts of less than a quarter of a box go to the box beside it that has most.
*/
#include "grid/grid.h"
#include "maps/bed.h"
#include "maps/outline.h"

typedef struct _p_MpmRelease *MpmRelease;

/* A column: its place, half of its box, and area and volume, m, m2, m3. */
typedef struct {
  PetscReal x[2], half[2], area, volume;
} MpmReleasePoint;

/*
  Reads the depth and number of points of a block, whose region is a raster. `outline` is borrowed while this is called;
  NULL: none. Points stand in cells of the grid, `per_cell` an axis, unless their number is given. Collective.
*/
PetscErrorCode MpmReleaseCreate(const MpmOptions *block, const MpmGrid *grid, const MpmBed *bed,
                                const MpmOutline *outline, const PetscInt per_cell[], MpmRelease *release);
PetscErrorCode MpmReleaseDestroy(MpmRelease *release);
/* Points of this rank; those of all ranks in order do not depend on their number. */
PetscInt MpmReleaseCount(MpmRelease release);
/* Points of all ranks. */
PetscInt64 MpmReleaseTotal(MpmRelease release);
/* Most cells from point to point on an axis. */
PetscReal MpmReleaseSpacing(MpmRelease release);
/* The next point after a cursor that starts at 0; PETSC_FALSE after the last one. */
PetscBool MpmReleaseNext(MpmRelease release, PetscInt64 *cursor, MpmReleasePoint *point);
/* Volume by the integral of the depth over the outline, and the sum over all points, m3. */
void MpmReleaseVolume(MpmRelease release, PetscReal *exact, PetscReal *points);
