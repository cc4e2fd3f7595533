#pragma once
/*
  Passage between columns of a depth-averaged flow and points in three dimensions.

  Order of calls: MpmHandoverColumns() or MpmHandoverDepth(), use of the arrays, MpmHandoverDestroy().
*/
#include "options/options.h"
#include "base/base.h"
#include "base/types.h"

/* The points of a body that have been made from another run's, this rank's, row by row. */
typedef struct MpmHandover {
  PetscInt         count;
  PetscReal       *position, *half_length, *velocity; /* m, m, m/s: dim values */
  PetscReal       *volume, *mass;                     /* m3, kg */
  PetscReal       *gradient; /* of the velocity, dim x dim, 1/s: [a][b] is the derivative of v_a by x_b; or NULL */
  PetscReal       *stress;   /* Cauchy, xx, yy, zz, xy, yz, xz, Pa; or NULL */
  PetscReal       *depth;    /* vertical, of columns, m; or NULL */
  PetscReal       *entry;    /* time at which they come in, s: 0 at once; or NULL */
  PetscBool        later;    /* some, over all ranks, come in later */
  char            *path;     /* of the run's file; NULL: from maps */
  char            *line;     /* for the log */
  char            *entries;  /* for the summary, JSON */
  struct MpmInlet *inlet;    /* of region hydrograph (handover/hydrograph.h), or NULL */
} MpmHandover;

/*
  MpmHandoverColumns - points of a 3D body from the columns of a depth-averaged flow

  Collective

  Input Parameters:
+ block   - of the body: file, step, spacing, lower, upper, inflow, stress, gravity; or from maps: depth, velocity_x
. grid    - in three dimensions
- density - of the material, kg/m3, for columns from maps

  Notes:
  A column of depth h over the bed Z becomes M = max(1, round(h/spacing)) points at z_i = Z + (i - 1/2) h/M with equal
  shares of its volume, mass and momentum; v_z = v . grad Z. Their domains fill the column: half-lengths of the base as
  the flow has deformed it, at most two cells long, and h/(2 M). A column whose centre lies outside of the window
  is left out, and its mass is reported. Fails with MPM_ERR_INPUT and one line.
  Source: Fois et al. (2024), Algorithm 2, with cells of equal height about the points.
@*/
PetscErrorCode MpmHandoverColumns(const MpmOptions *block, const MpmGrid *grid, PetscReal density,
                                  MpmHandover *handover);
/*
  MpmHandoverDepth - columns of a depth-averaged flow from the points of a 3D run

  Collective

  Input Parameters:
+ block - of the body: file, step, columns_per_cell
- grid  - in two dimensions

  Notes:
  Points are collected in the cells of a lattice, columns_per_cell to a grid cell and axis. A column stands at the
  centroid of its points and has their volume, mass and horizontal momentum; its depth is the volume over the area.
  Points with one x and y, and no others in their cell, keep the base of their domains; others fill their cell.
@*/
PetscErrorCode MpmHandoverDepth(const MpmOptions *block, const MpmGrid *grid, MpmHandover *handover);
PetscErrorCode MpmHandoverDestroy(MpmHandover *handover);
