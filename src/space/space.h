#pragma once
/*
  The step's discrete space: active nodes, weights, groups of points; and what the sums over points need.
*/
#include "particles/particles.h"

#define MPM_GHOST_FACTOR 1e-2 /* of the ghost penalty; */
#define MPM_GHOST_REST   3e-7 /* in a geostatic stage, with iterative solvers; */
#define MPM_GHOST_SPARSE 1e-1 /* where points are sparse; */
#define MPM_GHOST_RESCUE 1e-1 /* and where a run would give up with less */

/* ---- space.c, active_nodes.c ---- */

/*
  A wall: the plane of a Dirichlet condition on the component along its axis. Domains are clipped there and splines end
  there.
*/
typedef struct {
  PetscInt  axis;
  PetscInt  node;                                   /* the plane, as a node index on the axis */
  PetscInt  side;                                   /* +1: bounds the material above it, -1: below it */
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* where along the other axes, m */
} MpmWall;

/* Walls. */
typedef struct {
  PetscInt count;
  MpmWall *at;
} MpmWalls;

/*
  Points that touch the same nodes, a box of count[a] nodes an axis from first[a]; in order[] they stand side by side.
*/
typedef struct MpmGroup {
  PetscInt  first[MPM_MAX_DIM];
  PetscInt  count[MPM_MAX_DIM];
  PetscInt  node_count;
  PetscInt  node_offset;            /* into group_nodes */
  PetscInt  point_begin, point_end; /* into order */
  PetscInt  cell;                   /* into cells, where the physics has a mean */
  PetscBool holes;                  /* some of its nodes may be inactive: local node -1 */
} MpmGroup;

/* The points over which a mean is taken: those whose centres lie in one cell of the grid, in whole groups. */
typedef struct {
  PetscInt group_begin, group_end;
  PetscInt box; /* into groups: one without points that holds the nodes of them all */
} MpmCell;

/* Most nodes of a face of the ghost penalty on an axis, and in all: cubic splines. */
#define MPM_GHOST_WIDTH 5
#define MPM_GHOST_NODES 80
/* A face of the ghost penalty; its box leaves out the nodes beyond an edge, where first does not. */
typedef struct {
  PetscInt    axis, degree;
  PetscInt    first[MPM_MAX_DIM], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* edges: nodes at which splines end */
  MpmEdgeType edge[MPM_MAX_DIM];
  PetscReal   stiffness;                                             /* gamma E_s, Pa */
  PetscReal   along[MPM_MAX_DIM][MPM_GHOST_WIDTH * MPM_GHOST_WIDTH]; /* the matrix is their Kronecker product */
} MpmFace;

/* Weights of a shape: per point and axis `width` values, from the first node of the point's group on; gradients by x. */
typedef struct {
  PetscReal *weight, *gradient;
} MpmWeights;

/*
  The step's discrete spaces, one for each shape that the physics' fields have: weights of every point, and the active
  nodes. They number their nodes together, so that all unknowns of a node make one block; a node that no point touches
  with a field's shape has no unknown of that field. Local nodes are those that this rank's points touch or that it owns:
  first the owned ones, in lattice order, then ghosts. Unknowns are numbered over active nodes only.
*/
typedef struct MpmSpace {
  PetscInt   dim, width; /* most nodes on an axis */
  PetscInt   point_count;
  PetscInt  *first, *count; /* of the nodes touched with the scene's shape, dim values a point */
  PetscInt   shape_count;
  MpmWeights shape[MPM_MAX_SHAPES];
  PetscInt
    *support;       /* per local node: a bit for each shape with which points touch it; NULL where there is one shape */
  PetscInt  *order; /* points by group */
  PetscInt   group_count;
  PetscInt   face_begin, face_count; /* faces of the ghost penalty: groups without points, behind the others */
  PetscInt   cell_count;             /* cells with a mean, if the physics has one: their boxes come last */
  PetscInt   box_count;              /* groups, faces and cells */
  PetscInt   reach;                  /* no box has more than reach + 1 nodes on an axis, on any rank */
  MpmCell   *cells;
  PetscReal *share; /* of each point in the mean of its cell */
  MpmFace   *faces;
  MpmGroup  *groups;
  PetscInt  *group_nodes;  /* local nodes of each group, x fastest */
  PetscInt   owned, local; /* active nodes owned by this rank, and with ghosts */
  PetscInt  *node;         /* lattice indices of local nodes, dim each */
  PetscInt  *global;       /* number over all ranks, of local nodes */
  PetscInt   global_begin; /* number of the first owned node */
  PetscInt   global_count;
  PetscInt   unknown_count; /* over all ranks */
  PetscSF    sf; /* roots: owned nodes; leaves: ghosts; NULL on one rank */
} MpmSpace;

/* What a space is made by, borrowed from the model. */
typedef struct MpmRules {
  const MpmGrid     *grid;
  MpmShapeType       shape;
  MpmEdgeType        edge;
  const MpmLayout   *layout;
  PetscInt           wall_count;
  const MpmWall     *walls;
  MpmStretch         stretch;
  const MpmMaterial *materials;
  PetscReal          ghost, sparse; /* factor of the ghost penalty, 0: none; at least so much where points are sparse */
  PetscBool          mean;          /* points of one cell stand side by side, for means over it */
} MpmRules;

/*
  A space is set up in two halves, between which others may append boxes of nodes: Begin evaluates the shapes and finds the
  groups, End numbers the nodes. `why` is NULL, or the reason (static text) for which these points have no space; the same
  on all ranks.
*/
PetscErrorCode MpmSpaceBegin(MpmSpace *space, const MpmRules *rules, const MpmPoints *points, const char **why);
PetscErrorCode MpmSpaceEnd(MpmSpace *space, const MpmRules *rules);
PetscErrorCode MpmSpaceReset(MpmSpace *space);
/*
  The weights of all points (weights.c); `box_first` and `box_count`, dim values a point, are the nodes touched with any
  of the shapes. They are the space's own where there is one shape; `why` as above.
*/
PetscErrorCode MpmSpaceEvaluateShapes(MpmSpace *space, const MpmRules *rules, const MpmPoints *points,
                                      PetscInt **box_first, PetscInt **box_count, const char **why);
/* First and last node that bound the material around a place on each axis: the grid's edges, or a wall between. */
void MpmSpaceEdges(const MpmRules *rules, const PetscReal x[], PetscInt lower[], PetscInt upper[]);
/*
  Half-lengths of a point's domain in cells: the initial ones stretched by the diagonal of U, clipped at walls and at the
  grid's edges. The clipping is not kept. PETSC_FALSE where the point has no stretch.
*/
PetscBool MpmSpaceHalfLengths(const MpmRules *rules, const MpmPoints *points, PetscInt point, PetscReal half[]);
/* Room for `count` boxes more, without points, behind the others. */
PetscErrorCode MpmSpaceAppendBoxes(MpmSpace *space, PetscInt count, MpmGroup **boxes);
/* Numbers the nodes that the groups touch and builds the scatter (active_nodes.c). */
PetscErrorCode MpmSpaceNumberNodes(MpmSpace *space, const MpmGrid *grid);
/* Ghost values from their owners, and sums of ghost values to their owners; `block` values a node. */
PetscErrorCode MpmSpaceToGhosts(const MpmSpace *space, PetscInt block, PetscReal local[]);
PetscErrorCode MpmSpaceAddToOwners(const MpmSpace *space, PetscInt block, PetscReal local[]);
/*
  The weights and derivatives of one point at its group's nodes, shape by shape: basis[0] weights, basis[1..dim]
  derivatives by x, y, z; each of node_count values, x fastest.
*/
#define MPM_MAX_WIDTH 16
typedef struct {
  PetscReal *basis[MPM_MAX_SHAPES * MPM_BASES];
} MpmBasis;
/* Basis functions of a space, and their places in `storage`, which has room for so many times `nodes` numbers. */
static inline PetscInt MpmBasisCount(const MpmSpace *space)
{
  return space->shape_count * MPM_BASES;
}
static inline void MpmBasisPlace(const MpmSpace *space, PetscInt nodes, PetscReal storage[], MpmBasis *basis)
{
  for (PetscInt b = 0; b < MpmBasisCount(space); b++) basis->basis[b] = storage + b * nodes;
}
/* Those of the scene's shape alone. */
void MpmSpaceEvaluate(const MpmSpace *space, const MpmGroup *group, PetscInt point, MpmBasis *basis);

/* ---- point_loop.h, point_to_node.c, node_to_point.c ---- */

/* What the points would be at the step's end, F, Cauchy stress and history, at the displacement u last evaluated. */
typedef struct {
  PetscReal *F, *stress, *state, *u;
  PetscBool  made; /* it holds what goes with the model's residual */
} MpmTrial;

/* All that the loops over points need; borrowed for the length of a step. */
typedef struct MpmSum {
  const MpmGrid     *grid;
  const MpmSpace    *space;
  const MpmLayout   *layout;
  const MpmMaterial *materials;
  const MpmPoints   *points;
  PetscInt           state_size;
  PetscReal          dt;
  PetscBool          rest;  /* no motion: stresses are those of the step's start */
  const MpmTrial    *trial; /* where residuals leave the step's end; NULL: nowhere */
} MpmSum;

/*
  A unit is what the Jacobian cannot take apart: a group, or a cell where the physics has a mean. Its groups, and the box
  of their nodes.
*/
static inline PetscInt MpmUnitCount(const MpmSum *sum)
{
  return sum->layout->means ? sum->space->cell_count : sum->space->group_count;
}
static inline MpmCell MpmUnitGroups(const MpmSum *sum, PetscInt unit)
{
  return sum->layout->means ? sum->space->cells[unit] : (MpmCell){unit, unit + 1, unit};
}

/*
  Values of the points at the owned nodes, by the weights of one of the space's shapes, and with their gradients by x where
  `gradient` is not NULL (point_to_node.c). Point p has `components` values from value[p*stride] and components * dim
  derivatives from gradient[p*stride].
*/
typedef struct {
  PetscInt         shape, components, stride;
  const PetscReal *value, *gradient;
} MpmPointValues;
PetscErrorCode MpmProjectToNodes(const MpmSum *sum, const MpmPointValues *values, PetscReal nodal[]);

/* The trial becomes the state: history, F, stress, and positions and rate values that go with u. */
PetscErrorCode MpmCommitLocal(const MpmSum *sum, const PetscReal u[]);
