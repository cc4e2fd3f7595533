#pragma once
/*
  The level of the water in the ground and above it, -mpm_water_level or -mpm_water_table.
*/
#include "base/base.h"
#include "base/types.h"

/* A level along gravity's axis, on which a ramp acts; heights are coordinates up that axis. */
typedef struct MpmWaterTable {
  PetscBool  there;   /* the scene has one */
  PetscBool  suction; /* hydrostatic and negative above it; otherwise 0 */
  PetscInt   axis, up;
  PetscReal  level, weight; /* m; N/m3 */
  PetscInt   count, along;  /* points of a line in place of the level; 0: none; axis of their places */
  PetscReal *line;          /* their place and height in turn, m */
  MpmRamp    ramp;
} MpmWaterTable;

/* Reads level or table, above and ramp; the grid's lower and upper bounds are those of its range. `weight` is the
   density. */
PetscErrorCode MpmWaterTableCreate(const MpmOptions *options, PetscInt dim, const PetscReal bounds[2 * MPM_MAX_DIM],
                                   const MpmLoads *loads, MpmWaterTable *table);
PetscErrorCode MpmWaterTableDestroy(MpmWaterTable *table);
/* How far a place is below the level at a time, m. */
PetscReal MpmWaterTableDepth(const MpmWaterTable *table, PetscReal time, const PetscReal x[]);
