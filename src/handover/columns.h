#pragma once
/*
  Columns of a depth-averaged flow, from a run's file or from maps.
*/
#include "options/options.h"
#include "base/base.h"
#include "base/types.h"
#include "maps/bed.h"

typedef struct {
  PetscInt  id;
  PetscReal x[2], half[2];             /* centre and half-lengths of the base, m */
  PetscReal depth, bed, slope[2];      /* vertical depth and height of the bed, m; its slopes */
  PetscReal volume, mass, velocity[2]; /* m3, kg, m/s */
  PetscReal gradient[4];               /* of the velocity, row-major, 1/s */
  PetscReal entry;                     /* time at which it comes in, s */
} MpmFlowColumn;

/* This rank's columns, in the order of their ids over all ranks. */
typedef struct {
  PetscInt       count;
  MpmFlowColumn *at;
  PetscReal      time; /* of the state, s */
} MpmFlowColumns;

/*
  Of the step of a file, "latest" or a number. With `bed` heights and slopes are the bed's, from which the file's may
  differ by 0.1 m; without it (NULL) the file's. Collective.
*/
PetscErrorCode MpmColumnsReadFile(const MpmOptions *block, const char *path, const char *step, const MpmBed *bed,
                                  MpmFlowColumns *columns);
/*
  Time of a step, s, and the steps after it, ascending, to be freed; `count` of them. 0 and none where the file has no
  group /points/<step>. Collective.
*/
PetscErrorCode MpmColumnsSteps(MPI_Comm comm, const char *path, const char *step, PetscReal *time, PetscInt *count,
                               PetscInt **steps);
/* Reads -<prefix>depth, velocity and columns_per_cell: on a lattice in the grid's cells. Collective. */
PetscErrorCode MpmColumnsReadMaps(const MpmOptions *block, const MpmGrid *grid, const MpmBed *bed, PetscReal density,
                                  MpmFlowColumns *columns);
