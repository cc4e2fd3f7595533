#pragma once
/*
  Faces of the ghost penalty between two pieces of the spline that hold material: their nodes and their matrices.
*/
#include "base/base.h"
#include "base/types.h"
#include "extension/pieces.h"
#include "grid/shape.h"

/* Most nodes of a face of the ghost penalty on an axis, and in all: cubic splines 5 and 80; elements of order 4. */
#define MPM_FACE_WIDTH 9
#define MPM_FACE_NODES 225

/* A face of the ghost penalty; its box leaves out the nodes beyond an edge, where first does not. */
struct MpmFace {
  MpmKnots    knots;
  PetscInt    axis;
  PetscInt    first[MPM_MAX_DIM], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* edges: nodes at which splines end */
  MpmEdgeType edge[MPM_MAX_DIM];
  PetscReal   stiffness;   /* gamma E_s, Pa */
  PetscReal   gamma;       /* of components other than displacement: 0 where the face has only the interior penalty */
  PetscInt    material[2]; /* on its two sides */
  PetscReal  *along[MPM_MAX_DIM]; /* the matrix is the Kronecker product of these, count x count by axis */
};

/*
  MpmGhostFaces - sets space->boxes.faces, with a box of nodes for each

  Collective

  Input Parameters:
+ space  - after MpmSpaceBegin()
. rules  - factors of the penalty, shape, walls, grid and materials
- points - of this rank
*/
PetscErrorCode MpmGhostFaces(const MpmRules *rules, const MpmPoints *points, MpmSpace *space);
