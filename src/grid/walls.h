#pragma once
/*
  Walls, which bound the material inside of the grid.
*/
#include "base/base.h"

/* A wall: the plane of a Dirichlet condition on the component along its axis, where domains and splines end. */
typedef struct MpmWall {
  PetscInt  axis;
  PetscInt  node;                                   /* the plane, as a vertex of cells on the axis */
  PetscInt  side;                                   /* +1: bounds the material above it, -1: below it */
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* where along the other axes, m, in the grid as it was read */
} MpmWall;
