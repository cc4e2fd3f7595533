#pragma once
/*
  The relation between the functions of two lattices along one axis: splines, and Lagrange elements.
*/
#include "base/base.h"
#include "grid/shape.h"

/* Most coarse nodes that a fine node's value comes from. */
#define MPM_TWO_SCALE_MOST 8

/* Spline, ends of the two lattices, and how many cells become one. */
typedef struct {
  PetscInt    degree, ratio;
  MpmEdgeType edge;
  PetscInt    fine, coarse; /* last node of each lattice; the first one of both is 0 */
} MpmTwoScale;

/*
  MpmTwoScaleRow - the unknown of a fine node as a sum over coarse nodes

  Input Parameters:
+ relation - of the two lattices
- node     - index of the fine node, from 0 to relation->fine

  Output Parameters:
+ first  - the first coarse node of the sum
- weight - of it and those after it, room for MPM_TWO_SCALE_MOST

  Returns the number of coarse nodes, all of them between 0 and relation->coarse.

  Notes:
  Exact where the knots of the coarse splines are knots of the fine ones: of odd degree with any ratio, of even degree
  with an odd one, and where the lattices end at one place. Splines of even degree take the next odd degree's relation
  with an even ratio.
*/
PetscInt MpmTwoScaleRow(const MpmTwoScale *relation, PetscInt node, PetscInt *first, PetscReal weight[]);

/* Orders of the elements of two lattices, 1 to 4, how many cells become one, and the cells of the fine lattice. */
typedef struct {
  PetscInt fine, coarse, ratio, cells;
} MpmElementScale;

/*
  MpmElementScaleRow - the unknown of a fine node as a sum over coarse nodes: the value of the coarse functions there

  Arguments and result are those of MpmTwoScaleRow().

  Notes:
  Exact where the order does not grow: a polynomial of the coarse cell is one of each fine cell in it.
*/
PetscInt MpmElementScaleRow(const MpmElementScale *relation, PetscInt node, PetscInt *first, PetscReal weight[]);
