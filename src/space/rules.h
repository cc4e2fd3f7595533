#pragma once
/*
  Rules of a space: shapes, walls, the ghost penalty.
*/
#include "base/base.h"
#include "base/types.h"
#include "grid/shape.h"

/* Share of the fullest piece beside it, or of a whole one, from which on a piece is well filled (extension/). */
#define MPM_FILLED 0.35

/* Factor of the ghost penalty where points are sparse. */
#define MPM_GHOST_SPARSE 1e-1

/* Cells over which domains are drawn before points are divided, beside bilateral boundaries. */
#define MPM_DIVIDE 0.6

/*
  Half-length, in cells, beyond which a domain of an explicit step grows no more: sixteen times that of 2 x 2 points a
  cell. Flying grains are stretched without a force, and their domains would span the grid. A bound of 2 is too small:
  the sheet that runs ahead of a collapsed column then separates while it still rubs on the floor, and goes 5 % further.
*/
#define MPM_SPRAY_HALF_LENGTH 4.

/* Walls between which the material stands. */
typedef struct {
  PetscInt       count;
  const MpmWall *at;
} MpmWallList;

/* Factors of the ghost penalty, 0: none: everywhere; at least so much where points are sparse; on the displacement's
   jumps over all faces. */
typedef struct {
  PetscReal ghost, sparse, interior;
} MpmPenalty;

/* The step's start and end, s, and the part of loads that acts by their value at its start. */
typedef struct {
  PetscReal start, end, load_at_start;
} MpmInterval;

/* Means of the physics: none; over the points whose centres lie in a cell; by shares of the points' domains. */
typedef enum { MPM_MEANS_NONE, MPM_MEANS_CELL, MPM_MEANS_SPREAD } MpmMeansType;

/* Half-length of a domain, in cells, beyond which an implicit step has no spread means. */
#define MPM_SPREAD_HALF_LENGTH 1.5

/* Rules of a space, borrowed from the model. */
typedef struct MpmRules {
  const MpmGrid     *grid;
  MpmShapeType       shape;
  MpmEdgeType        edge;
  const MpmLayout   *layout;
  MpmWallList        walls;
  MpmStretch         stretch;
  PetscReal          touch;   /* of a domain: overlaps with a cell that do not count */
  PetscReal          longest; /* half-length of a domain, cells: material drawn further separates; 0: any */
  const MpmMaterial *materials;
  PetscInt           material_count;
  MpmPenalty         penalty;
  PetscReal          filled; /* MPM_FILLED, another share, or 0: no node follows others */
  PetscReal          smooth; /* share of means over pieces in derivatives (grid/shape.h); where there is one shape */
  MpmMeansType       means;  /* of cells: their points stand side by side */
  MpmInterval        time;
  PetscBool          put_back;             /* the points were restored after the last step, which kept their stress */
  PetscBool          dynamic;              /* a step with inertia that is solved for */
  PetscReal          gravity[MPM_MAX_DIM]; /* m/s2 */
  PetscInt           parts;                /* of the material, with nodes of their own; 0 or 1: none */
} MpmRules;

/* First and last vertex that bound the material around a place on each axis: the grid's edges, or a wall between. */
void MpmSpaceEdges(const MpmRules *rules, const PetscReal x[], PetscInt lower[], PetscInt upper[]);
/*
  Half-lengths of a point's domain in cells: initial ones stretched by the diagonal of U, no longer than the rules'
  longest, clipped at walls and at the grid's edges, without memory. PETSC_FALSE where the point has no stretch.
*/
PetscBool MpmSpaceHalfLengths(const MpmRules *rules, const MpmPoints *points, PetscInt point, PetscReal half[]);
