#pragma once
/*
  Material that comes in through a line by a hydrograph: discharge against time.
*/
#include "base/base.h"
#include "base/types.h"

struct MpmHandover;

/* A straight inlet; material comes from its left to its right, at a given velocity or depth. */
typedef struct MpmInlet {
  PetscReal  from[2], along[2], normal[2], width; /* its start, m; directions of the line and of the flow; m */
  PetscReal  velocity, depth;                     /* horizontal, m/s; vertical, m; 0: the other one is given */
  PetscInt   count;                               /* rows of the table */
  PetscReal *time, *discharge, *volume;           /* s, ascending; m3/s, linear between; m3, since the first row */
} MpmInlet;

/*
  MpmHandoverHydrograph - columns of a depth-averaged flow by a hydrograph

  Collective

  Input Parameters:
+ block   - of the body: line, table, velocity or depth, points_per_cell
. grid    - in two dimensions
- density - of the material, kg/m3

  Notes:
  Rows of columns as long as the spacing of points come in when the flow has brought all of them through the line, each
  with the integral of the discharge in between: their sum is that of the whole table to rounding. With a given
  velocity their depth goes with the discharge, with a given depth their velocity. Fails with MPM_ERR_INPUT and one
  line.
@*/
PetscErrorCode MpmHandoverHydrograph(const MpmOptions *block, const MpmGrid *grid, PetscReal density,
                                     struct MpmHandover *handover);
PetscErrorCode MpmInletDestroy(MpmInlet **inlet);
/* Velocity with which material comes in, m/s; 0 where there is no discharge. */
PetscReal MpmInletVelocity(const MpmInlet *inlet, PetscReal time);
/* Its vertical depth, m. */
PetscReal MpmInletDepth(const MpmInlet *inlet, PetscReal time);
