#pragma once
/*
  The bed of a flow over terrain: its height by place, a plane or a map.

  Order of calls: MpmBedRead(), MpmBedCover(), then heights; MpmBedDestroy().
*/
#include "base/base.h"
#include "base/types.h"
#include "maps/ascii_grid.h"

/* Height z = plane[0] + plane[1] x + plane[2] y, or bilinear between the centres of a map's pixels. */
struct MpmBed {
  PetscReal    plane[3];
  MpmAsciiGrid map; /* without pixels: the plane counts */
  char        *file;
  PetscBool    normal; /* lengths, depth and pressure count along and normal to the bed */
};

/* Reads -mpm_terrain_file, or -mpm_bed, and -mpm_slope. */
PetscErrorCode MpmBedRead(const MpmOptions *options, MpmBed *bed);
PetscErrorCode MpmBedDestroy(MpmBed *bed);
/* Fails where the map does not cover a rectangle, or has no data in it. */
PetscErrorCode MpmBedCover(const MpmBed *bed, const PetscReal lower[], const PetscReal upper[]);
/* Height at a place, m. */
PetscReal MpmBedHeight(const MpmBed *bed, const PetscReal x[]);
