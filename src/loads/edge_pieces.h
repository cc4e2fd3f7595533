#pragma once
/*
  The true surface of a body whose edge cuts the boxes of its points, as it was drawn.
*/
#include "base/base.h"
#include "base/types.h"

/* A piece of it in a box of the lattice. */
typedef struct {
  PetscInt  behind;                /* the other body that was drawn beyond, -1: none */
  PetscInt  side;                  /* of the box that it lies on, 2 axis + side; -1: within the box */
  PetscBool inner;                 /* of that side, with material beyond: no surface */
  PetscReal area[MPM_MAX_DIM];     /* outward, m^(dim-1) */
  PetscReal size;                  /* its area: larger than that of the vector where it is bent */
  PetscReal onto[2 * MPM_MAX_DIM]; /* the area of its projection onto each side's plane, of what faces there */
  PetscReal place[MPM_MAX_DIM];    /* of its middle, m */
} MpmEdgePiece;

/* Those of a point: `at[first]` to `at[first + count - 1]`; `whole`: its box is, and all its surface is in its sides.
   `given`: bits of sides beyond which other points have parts of boxes without one. */
typedef struct {
  PetscInt  id, first, count, given;
  PetscBool whole;
  PetscReal size; /* of all its surface, in the region or not, m^(dim-1) */
} MpmEdgePoint;

/* By ids of points in a table with gaps (id -1); found as points are asked for. */
typedef struct {
  PetscInt      points, capacity, pieces, room;
  MpmEdgePoint *point;
  MpmEdgePiece *at;
} MpmEdgePieces;

/* Whose pieces, as far as they lie in the region, NULL: all of them. `all_or_none`: of a piece that lies in it by half
   or more. */
typedef struct {
  const MpmBodies *bodies;
  PetscInt         body;
  MpmRegion        region;
  PetscBool        all_or_none;
} MpmEdgeAsked;
/* Those of a point. The pointer is good until the next call. */
PetscErrorCode MpmEdgePiecesGet(MpmEdgePieces *pieces, const MpmEdgeAsked *asked, const MpmGrid *grid,
                                const MpmPoints *points, PetscInt p, const MpmEdgePoint **point);
PetscErrorCode MpmEdgePiecesDestroy(MpmEdgePieces *pieces);
/* The part of a flat piece x + s u + t v, |s|, |t| <= 1, in a region, and the middle of that part in place of x; in 2D
   without t v. */
PetscReal MpmFlatPart(MpmRegion region, PetscInt dim, const PetscReal u[], const PetscReal v[], PetscReal x[]);
