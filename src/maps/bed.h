#pragma once
/*
  The bed of a flow over terrain: its height by place, a plane or a map.

  Order of calls: MpmBedRead(), then heights; MpmBedDestroy().
*/
#include "base/base.h"
#include "base/types.h"
#include "maps/map.h"

/* Curvature of paths: left out; in the motion, which keeps its speed along the bed; in the pressure, too. */
typedef enum { MPM_BED_STRAIGHT, MPM_BED_PATH, MPM_BED_PRESSURE } MpmBedCurvature;

/* Dams: name, and the height by which each has raised the bed, m, on a window of the pixels that has all of it. */
typedef struct {
  PetscInt count;
  char   **name;
  MpmMap  *height;
} MpmBedDams;

/* Height z = plane[0] + plane[1] x + plane[2] y, or bilinear between the centres of a map's pixels. */
struct MpmBed {
  PetscReal       plane[3];
  MpmMap          map;    /* without pixels: the plane counts */
  MpmMap          change; /* height added since the start, m, at the grid's nodes; without pixels: none */
  char           *file, *project;
  MpmBedCurvature curvature;
  PetscReal       viscosity; /* factor of lateral friction (terrain/bed_mixing.c) */
  PetscBool       normal;    /* lengths, depth and pressure count along and normal to the bed */
  PetscBool       outflow;   /* material on pixels without data has left; otherwise it ends the run */
  MpmBedDams      dams;
  char           *missing; /* of each pixel: it has no data, and a value from beside; NULL: there is none */
};

/*
  Reads -mpm_terrain_file, or -mpm_bed, -mpm_slope, and -mpm_terrain_viscosity. The map must cover the rectangle.
*/
PetscErrorCode MpmBedRead(const MpmOptions *options, const PetscReal lower[], const PetscReal upper[], MpmBed *bed);
/* Reads the rectangle between the centres of the outer pixels of the terrain's map, before the grid is known. */
PetscErrorCode MpmBedExtent(const MpmOptions *options, PetscReal lower[2], PetscReal upper[2]);
PetscErrorCode MpmBedDestroy(MpmBed *bed);
/* True where the pixel of a place has no data. */
PetscBool MpmBedIsMissing(const MpmBed *bed, const PetscReal x[]);
/* Height at a place, m. */
PetscReal MpmBedHeight(const MpmBed *bed, const PetscReal x[]);
/*
  The bilinear patch of the bed at a place: with r = (x, y) - at, its height is z + slope.r + twist r_x r_y. Height and
  slope are those at the place; not-a-number beside pixels without data. Beyond the outer centres it goes on level.
*/
typedef struct {
  PetscReal at[2], z, slope[2], twist; /* m, m, -, 1/m */
} MpmBedPatch;
void MpmBedPatchAt(const MpmBed *bed, const PetscReal x[], MpmBedPatch *patch);
/*
  Distance of a place in space from the bilinear patch below it, positive above, its gradient, and its second
  derivative, which is left as it is where the patch is flat. Infinite beside pixels without data.
*/
void MpmBedDistance(const MpmBed *bed, const PetscReal x[], PetscReal *distance, PetscReal normal[MPM_MAX_DIM],
                    PetscReal second[MPM_MAX_DIM][MPM_MAX_DIM]);
