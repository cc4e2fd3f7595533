#pragma once
/*
  The engine's objects from the inside. Each block names the file that implements it.
*/
#include "mpm.h"

#define MPM_MAX_DIM      3
#define MPM_MAX_BLOCK    8    /* unknowns a node: displacement, pressure, damage, ... */
#define MPM_MAX_INPUTS   24   /* inputs of a kernel */
#define MPM_GHOST_AUTO   -1.  /* the factor follows the solver */
#define MPM_GHOST_FACTOR 1e-4 /* the factor for iterative solvers */
#define MPM_GHOST_RESCUE 1e-3 /* and where a step has failed without */
#define MPM_TOLERANCE    1e-6 /* of a cell: what counts as "on" a region's edge */

/* ---- grid.c ---- */

/*
  A plane between nodes: those of the lattice with a smaller index on the axis are below it. Of the layer of nodes right
  above it, those below `row` on another axis are below the cut, too.
*/
typedef struct {
  PetscInt axis, node;
  PetscInt row_axis, row;
} MpmCut;

/*
  The background grid: a regular lattice of cells, never stored. Its nodes belong to the ranks by nested cuts, which
  follow the points.
*/
typedef struct {
  MPI_Comm    comm;
  PetscMPIInt rank, size;
  PetscInt    dim;
  PetscReal   lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], h[MPM_MAX_DIM];
  PetscInt    cells[MPM_MAX_DIM]; /* 1 on unused axes */
  PetscInt    nodes[MPM_MAX_DIM]; /* 1 on unused axes */
  PetscReal   balance;            /* when to look for other cuts: points on the fullest rank over their mean */
  MpmCut     *cuts;               /* size - 1 of them; NULL before the first partition */
} MpmGrid;

PetscErrorCode MpmGridSetFromOptions(MpmGrid *grid, const MpmOptions *options, PetscInt dim);
PetscErrorCode MpmGridDestroy(MpmGrid *grid);
/*
  Cuts the lattice anew for these points (dim coordinates each). The cuts are taken when they are the first ones, or when
  the fullest rank would hold at most `worth` points.
*/
PetscErrorCode MpmGridPartition(MpmGrid *grid, PetscInt count, const PetscReal x[], PetscReal worth, PetscBool *taken);
/* The rank that owns a node, given its index on each axis; any node has an owner. */
PetscMPIInt MpmGridNodeOwner(const MpmGrid *grid, const PetscInt node[]);
/*
  The ranks that own nodes of a box, both corners included, ascending, and few others beside steps in the cuts; returns
  how many. Room for grid->size.
*/
PetscInt MpmGridBoxOwners(const MpmGrid *grid, const PetscInt lower[], const PetscInt upper[], PetscMPIInt owner[]);
/* The cell that holds a place (a point on a face belongs to the upper cell, except at the grid's upper edge). */
void MpmGridFindCell(const MpmGrid *grid, const PetscReal x[], PetscInt cell[]);

/* ---- material.c ---- */

/* One material of the scene: a law, its parameters' values, and the law compiled for each form. */
typedef struct {
  char       *name;
  MpmLawInfo  info;
  double     *parameter;
  MpmFunction law[MPM_FORM_COUNT];
  PetscReal   density, stiffness;
  PetscReal   penalty; /* scale of penalties: E where the law has it; a constrained modulus locks as nu goes to 1/2 */
  PetscInt    state_size;
} MpmMaterial;

/* The laws' list for one compiled instance; finds a law by name. Returns PETSC_FALSE where there is none. */
PetscBool      MpmLawFind(const char *name, PetscInt dim, PetscInt directions, MpmLawInfo *info);
PetscErrorCode MpmMaterialCreate(const MpmOptions *options, const char *name, PetscInt dim, PetscInt inputs,
                                 MpmMaterial *material);
PetscErrorCode MpmMaterialDestroy(MpmMaterial *material);
/* Components of one history variable. */
PetscInt       MpmStateComponents(const MpmStateVariable *variable, PetscInt dim);
PetscErrorCode MpmLawsPrintHelp(MPI_Comm comm);

/* ---- physics.c ---- */

/*
  The layout that follows from a physics' fields: block size, and which basis function and component each kernel input
  takes.
*/
typedef struct {
  PetscInt  dim, block, inputs, rates;
  PetscInt  component_first[MPM_MAX_BLOCK + 1]; /* inputs of component c: [component_first[c], component_first[c+1]) */
  PetscInt  basis_first[MPM_MAX_BLOCK];         /* their basis functions start here: 0 weight, 1.. derivatives */
  PetscInt  component_of[MPM_MAX_INPUTS], basis_of[MPM_MAX_INPUTS];
  PetscInt  rate_component[MPM_MAX_BLOCK]; /* the nodal component of each value with a rate */
  PetscInt  means;                         /* 1: the kernel has one input more, the mean over the cell; otherwise 0 */
  PetscBool increment[MPM_MAX_BLOCK];
  const char         *component_name[MPM_MAX_BLOCK];
  PetscBool           solid; /* the displacement's gradient is all that the kernel sees */
  const MpmKernelSet *kernel;
} MpmLayout;

/* A built-in physics with its compiled kernels. */
PetscErrorCode MpmPhysicsCreate(const char *name, MpmPhysics *physics, PetscBool *found);
PetscErrorCode MpmLayoutCreate(const MpmPhysics *physics, PetscInt dim, MpmLayout *layout);
typedef int (*MpmStretch)(const double *F, double *diagonal);
/* The function that gives the diagonal of U = sqrt(F^T F). */
MpmStretch MpmStretchFind(PetscInt dim);

/* ---- particles.c ---- */

/* The points' fields, lent by MpmParticlesGetArrays(); NULL where a field is not registered. */
typedef struct {
  PetscInt   count;
  PetscInt  *id, *material;
  PetscReal *x, *x0;      /* position now and at the start, m */
  PetscReal *F;           /* dim x dim, row-major */
  PetscReal *half_length; /* of the initial domain, m; shapes with a domain and tractions only */
  PetscReal *volume0;
  PetscReal *stress;    /* Cauchy, xx, yy, zz, xy (, yz, xz) */
  PetscReal *state;     /* state_size values */
  PetscReal *value;     /* rate values */
  PetscReal *increment; /* of the last step's displacement, dim values, and its gradient by x, row-major */
} MpmPoints;

typedef struct {
  DM         swarm;
  PetscInt   dim, stress_size, state_size, rates;
  PetscBool  has_half_length, has_increment;
  PetscInt64 total;
  PetscReal  imbalance; /* points on the fullest rank over their mean, the most so far */
  PetscInt   rebalances;
  char       lost[192]; /* tells of a point that is lost; empty while all are there */
  PetscBool  gone;      /* it is not merely in a wrong place */
} MpmParticles;

PetscErrorCode MpmParticlesCreate(MpmGrid *grid, PetscInt state_size, PetscInt rates, PetscBool half_length,
                                  PetscBool increment, PetscInt extra_count, char *const extra[],
                                  MpmParticles *particles);
PetscErrorCode MpmParticlesDestroy(MpmParticles *particles);
PetscErrorCode MpmParticlesGetArrays(MpmParticles *particles, MpmPoints *points);
PetscErrorCode MpmParticlesRestoreArrays(MpmParticles *particles, MpmPoints *points);
/*
  Sends every point to the rank that owns its cell, however far. Points are counted before and after; one that is missing
  or not in the grid is told of in particles->lost, the same text on all ranks.
*/
PetscErrorCode MpmParticlesMigrate(MpmParticles *particles, MpmGrid *grid);
/*
  Moves the partition, not the points, when the fullest rank holds too many and another partition has a good part fewer,
  or `always`; `moved` tells.
*/
PetscErrorCode MpmParticlesRebalance(MpmParticles *particles, MpmGrid *grid, PetscBool always, PetscBool *moved);
/* Both: points at their ranks, ranks about equally full. `why` is NULL, or tells of a lost point. */
PetscErrorCode MpmParticlesDistribute(MpmParticles *particles, MpmGrid *grid, const char **why);

/* ---- body.c ---- */

typedef struct _p_MpmBody *MpmBody;
PetscErrorCode MpmBodyCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, PetscInt material_count,
                             const MpmMaterial materials[], MpmBody *body);
PetscErrorCode MpmBodyDestroy(MpmBody *body);
/* Fills the particles with the points of all bodies; ids do not depend on the number of ranks. */
PetscErrorCode MpmBodiesGenerate(PetscInt body_count, const MpmBody bodies[], const MpmMaterial materials[],
                                 const MpmGrid *grid, MpmParticles *particles);

/* ---- space.c, nodes.c ---- */

/*
  A wall: the plane of a Dirichlet condition on the component along its axis. Domains are cut there and splines end
  there.
*/
typedef struct {
  PetscInt  axis;
  PetscInt  node;                                   /* the plane, as a node index on the axis */
  PetscInt  side;                                   /* +1: bounds the material above it, -1: below it */
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* where along the other axes, m */
} MpmWall;

/*
  Points that touch the same nodes, a box of count[a] nodes an axis from first[a]; in order[] they stand side by side.
*/
typedef struct {
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
  PetscInt  axis, degree;
  PetscInt  first[MPM_MAX_DIM], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* edges: nodes at which splines end */
  PetscReal stiffness;                                                  /* Pa */
} MpmFace;

/*
  The step's discrete space: weights of every point, and the active nodes. Local nodes are those that this rank's points
  touch or that it owns: first the owned ones, in lattice order, then ghosts. Unknowns are numbered over active nodes
  only.
*/
typedef struct {
  PetscInt   dim, width; /* most nodes on an axis */
  PetscInt   point_count;
  PetscInt  *first, *count;     /* dim values a point */
  PetscReal *weight, *gradient; /* per point and axis, `width` values; gradients by x */
  PetscInt  *order;             /* points by group */
  PetscInt   group_count;
  PetscInt   face_count; /* faces of the ghost penalty: groups without points, behind the others */
  PetscInt   cell_count; /* cells with a mean, if the physics has one: their boxes come last */
  PetscInt   box_count;  /* groups, faces and cells */
  PetscInt   reach;      /* no box has more than reach + 1 nodes on an axis, on any rank */
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
  PetscSF    sf; /* roots: owned nodes; leaves: ghosts; NULL on one rank */
} MpmSpace;

/* What a space is made by, borrowed from the model. */
typedef struct {
  const MpmGrid     *grid;
  MpmShapeType       shape;
  PetscInt           wall_count;
  const MpmWall     *walls;
  MpmStretch         stretch;
  const MpmMaterial *materials;
  PetscBool          ghost; /* with the faces of the ghost penalty */
  PetscBool          mean;  /* with the cells of a mean */
} MpmRules;

/* `why` is NULL, or the reason (static text) for which these points have no space; the same on all ranks. */
PetscErrorCode MpmSpaceSetUp(MpmSpace *space, const MpmRules *rules, const MpmPoints *points, const char **why);
PetscErrorCode MpmSpaceReset(MpmSpace *space);
/* First and last node that bound the material around a place on each axis: the grid's edges, or a wall between. */
void MpmSpaceEdges(const MpmRules *rules, const PetscReal x[], PetscInt lower[], PetscInt upper[]);
/* Room for `count` boxes more, without points, behind the others. */
PetscErrorCode MpmSpaceAppendBoxes(MpmSpace *space, PetscInt count, MpmGroup **boxes);
/* Numbers the nodes that the groups touch and builds the scatter (nodes.c). */
PetscErrorCode MpmSpaceNumberNodes(MpmSpace *space, const MpmGrid *grid);
/* Ghost values from their owners, and sums of ghost values to their owners; `block` values a node. */
PetscErrorCode MpmSpaceToGhosts(const MpmSpace *space, PetscInt block, PetscReal local[]);
PetscErrorCode MpmSpaceAddToOwners(const MpmSpace *space, PetscInt block, PetscReal local[]);

/*
  Sends a list of integers to each of some ranks and receives likewise (nodes.c). Received data: from[k] sent
  data[offset[k] .. offset[k+1]).
*/
typedef struct {
  PetscInt     count;
  PetscMPIInt *rank;
  PetscInt    *offset; /* count + 1 */
  PetscInt    *data;
} MpmLists;
PetscErrorCode MpmListsExchange(MPI_Comm comm, const MpmLists *sent, MpmLists *received);
PetscErrorCode MpmListsDestroy(MpmLists *lists);

/*
  The weights and derivatives of one point at its group's nodes: basis[0] weights, basis[1..dim] derivatives by x, y, z;
  each of node_count values, x fastest.
*/
#define MPM_MAX_WIDTH 16
typedef struct {
  PetscReal *basis[MPM_MAX_DIM + 1];
} MpmBasis;
/*
  Values of the points, and their gradients by x where `gradient` is not NULL, at the owned nodes (project.c). Point p has
  `components` values from value[p*stride] and components * dim derivatives from gradient[p*stride].
*/
PetscErrorCode MpmProjectToNodes(const MpmSpace *space, const MpmGrid *grid, const MpmPoints *points,
                                 PetscInt components, PetscInt stride, const PetscReal value[],
                                 const PetscReal gradient[], PetscReal nodal[]);
void           MpmSpaceEvaluate(const MpmSpace *space, const MpmGroup *group, PetscInt point, MpmBasis *basis);

/* ---- condition.c ---- */

/* A Dirichlet condition on nodes. */
typedef struct {
  char     *name;
  MpmRegion region;
  PetscInt  component_count;
  PetscInt  component[MPM_MAX_BLOCK];
  PetscReal value[MPM_MAX_BLOCK];
  MpmRamp   ramp;
} MpmCondition;

/* The conditions as they act on the local unknowns of a step. */
typedef struct {
  PetscInt  *condition; /* per local unknown: which condition holds it, or -1 */
  PetscReal *value;     /* the value that it takes */
  PetscBool  any;
} MpmConstraints;

PetscErrorCode MpmConditionCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                  const MpmLayout *layout, MpmCondition *bc);
PetscErrorCode MpmConditionDestroy(MpmCondition *bc);
/* The walls that a condition makes; walls has room for 2*dim. */
PetscErrorCode MpmConditionGetWalls(const MpmCondition *bc, const MpmGrid *grid, PetscInt *count, MpmWall walls[]);
PetscErrorCode MpmConstraintsSetUp(MpmConstraints *constraints, PetscInt bc_count, const MpmCondition bcs[],
                                   const MpmGrid *grid, const MpmLayout *layout, const MpmSpace *space,
                                   PetscReal time_n, PetscReal time);
PetscErrorCode MpmConstraintsReset(MpmConstraints *constraints);

/* ---- load.c ---- */

typedef enum { MPM_LOAD_FORCE, MPM_LOAD_GRAVITY, MPM_LOAD_TRACTION } MpmLoadType;

/* A load on the material. Forces and tractions keep each point's share in a field of the particles. */
typedef struct {
  char       *name, *share_field;
  MpmLoadType type;
  PetscReal   value[MPM_MAX_DIM];
  PetscReal   at[MPM_MAX_DIM];
  PetscInt    nearest; /* 0: by region */
  MpmRegion   region;
  PetscInt    face_axis, face_side; /* traction: the face of the points' domains it acts on */
  PetscBool   face_given;
  MpmRamp     ramp;
} MpmLoad;

/* A set of points that is followed; the field holds each point's share of the mean. */
typedef struct {
  char     *name, *share_field;
  PetscReal at[MPM_MAX_DIM];
  PetscInt  nearest;
  MpmRegion region;
} MpmTrack;

PetscErrorCode MpmLoadCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, MpmLoad *load);
PetscErrorCode MpmLoadDestroy(MpmLoad *load);
/* Finds the points that carry the load, in the initial state. */
PetscErrorCode MpmLoadSelect(MpmLoad *load, const MpmGrid *grid, MpmParticles *particles);
PetscErrorCode MpmTrackCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, MpmTrack *track);
PetscErrorCode MpmTrackDestroy(MpmTrack *track);
PetscErrorCode MpmTrackSelect(MpmTrack *track, const MpmGrid *grid, MpmParticles *particles);
PetscErrorCode MpmTrackEvaluate(const MpmTrack *track, MpmParticles *particles, PetscReal displacement[]);

/* ---- assemble.c, mean.c, jacobian.c, action.c, coloring.c, pattern.c ---- */

/* Means over cells at the displacement that was last evaluated, and the sums of the fluxes conjugate to them. */
typedef struct {
  PetscReal *value, *flux; /* one a cell */
} MpmMean;

/* All that the sums over points need; borrowed from the model for the length of a step. */
typedef struct {
  const MpmGrid        *grid;
  const MpmSpace       *space;
  const MpmLayout      *layout;
  const MpmMaterial    *materials;
  const MpmPoints      *points;
  const MpmConstraints *constraints;
  const double         *physics_parameter;
  PetscInt              state_size;
  PetscReal             dt;
  PetscReal             ghost; /* factor of the ghost penalty */
  PetscBool             rest;  /* nothing moves: stresses are those of the step's start */
  MpmMean               mean;
} MpmSum;

/* Do any of the kernel's inputs need the weights, not only their derivatives? */
PetscBool MpmLayoutUsesValues(const MpmLayout *layout);
/* Adds the load at `time` to the external force at the local nodes. */
PetscErrorCode MpmLoadApply(const MpmLoad *load, PetscReal time, const MpmRules *rules, const MpmSum *sum,
                            MpmParticles *particles, PetscReal force[]);
/* Adds a body force that is a function of the initial position. */
PetscErrorCode MpmBodyForceApply(MpmBodyForce function, void *ctx, PetscReal time, const MpmSum *sum,
                                 PetscReal force[]);

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

/* Finds the cells that means are taken over, after the groups (mean.c). */
PetscErrorCode MpmMeanCells(MpmSpace *space, const MpmPoints *points);
/* Means and their fluxes for a displacement; does nothing where the physics has none. */
PetscErrorCode MpmMeanEvaluate(const MpmSum *sum, const PetscReal u[], PetscInt *failed);
/* Local residual += sum over points of phi flux(u). `failed` counts points without an answer on this rank. */
PetscErrorCode MpmResidualLocal(const MpmSum *sum, const PetscReal u[], PetscReal residual[], PetscInt *failed);
/* Like it, and writes history, F, stress, positions and rate values of the converged step. */
PetscErrorCode MpmCommitLocal(const MpmSum *sum, const PetscReal u[], PetscReal residual[], PetscInt *failed);

/*
  The sparsity pattern, in node blocks, and where this rank's contributions go: rows of owned nodes hold what any rank
  adds to them; rows of ghosts hold this rank's part only. Columns are global node numbers, ascending. A row stands in
  the matrix's own array, or, where its columns are not all this rank's, in a buffer with the same order.
*/
typedef struct {
  PetscInt     block, dim, window, reach; /* a row's columns lie in a window of (2*reach + 1)^dim nodes around it */
  PetscInt     local, owned;
  PetscInt    *row;    /* local + 1: where each row's columns start */
  PetscInt    *column; /* global node numbers */
  PetscInt    *slot;   /* local * window: position in the row, or -1 */
  PetscReal  **value;  /* per row, row-major: value[i][(c * columns_i + k)*block + c'] */
  PetscReal   *buffer;
  PetscInt64   buffer_size;
  PetscScalar *array; /* the matrix's, lent between Begin and End; NULL: all rows are in the buffer */
} MpmPattern;

PetscErrorCode MpmPatternSetUp(MpmPattern *pattern, const MpmSpace *space, MPI_Comm comm, PetscInt block,
                               PetscBool *changed);
PetscErrorCode MpmPatternReset(MpmPattern *pattern);
PetscErrorCode MpmPatternCreateMat(const MpmPattern *pattern, const MpmSpace *space, MPI_Comm comm, MatType type,
                                   Mat *mat);
/* Between these two, blocks are added. Begin zeroes the matrix; End puts `diagonal` on constrained rows and assembles. */
PetscErrorCode MpmPatternBegin(MpmPattern *pattern, const MpmSpace *space, Mat mat);
PetscErrorCode MpmPatternEnd(MpmPattern *pattern, const MpmSpace *space, const MpmConstraints *constraints,
                             PetscReal diagonal, Mat mat);
/*
  Adds a box's element block, stored [i][c][c'][j]; rows and columns of constrained unknowns, and those of holes, are left
  out.
*/
void MpmPatternAddBlock(MpmPattern *pattern, const MpmSpace *space, const MpmGroup *group,
                        const MpmConstraints *constraints, PetscReal element[]);

/* The ghost penalty (ghost.c). Faces become groups of the space, before its nodes are numbered. */
PetscErrorCode MpmGhostFaces(MpmSpace *space, const MpmRules *rules, const MpmPoints *points);
/* The face's matrix, the same for every component; returns its number of nodes. */
PetscInt       MpmGhostMatrix(const MpmSpace *space, const MpmGrid *grid, PetscReal factor, PetscInt face,
                              PetscReal matrix[]);
PetscErrorCode MpmGhostResidual(const MpmSum *sum, const PetscReal u[], PetscReal residual[]);
/* Adds to the pattern's values; linear, so it is the same in every form of the Jacobian. */
PetscErrorCode MpmGhostJacobian(const MpmSum *sum, MpmPattern *pattern);
/* Adds to the diagonal blocks of the local nodes. */
PetscErrorCode MpmGhostDiagonal(const MpmSum *sum, PetscReal blocks[]);

/* With `residual` not NULL it does what MpmResidualLocal() does too, at little cost. */
PetscErrorCode MpmJacobianLocal(const MpmSum *sum, const PetscReal u[], MpmPattern *pattern, PetscReal residual[],
                                PetscInt *failed);
PetscErrorCode MpmJacobianColoring(const MpmSum *sum, MpmJacobianType type, const PetscReal u[], MpmPattern *pattern,
                                   PetscInt *failed);
/* This rank's part of the diagonal blocks, block^2 values for each local node; constraints are the caller's. */
PetscErrorCode MpmJacobianDiagonal(const MpmSum *sum, const PetscReal u[], PetscReal blocks[], PetscInt *failed);

/*
  The Jacobian's action without a matrix. With `stored` each point keeps its tangent; otherwise one dual direction makes
  the product anew each time. With `differences` the plain kernel is differenced in place of duals.
*/
typedef struct {
  const MpmSum *sum;
  PetscBool     differences;
  PetscReal    *u;       /* at the local nodes: where the derivative is taken */
  PetscReal    *tangent; /* per place in the points' order, or NULL */
  PetscReal    *values, *dvalues, *force, *storage;
  MpmBasis      basis;
} MpmAction;
PetscErrorCode MpmActionCreate(const MpmSum *sum, PetscBool stored, MpmAction *action);
PetscErrorCode MpmActionSetState(MpmAction *action, const PetscReal u[], PetscInt *failed);
/* y += J du at the local nodes, of one unit or of everything, the ghost penalty included. */
PetscErrorCode MpmActionApplyUnit(MpmAction *action, PetscInt unit, const PetscReal du[], PetscReal y[],
                                  PetscInt *failed);
PetscErrorCode MpmActionApply(MpmAction *action, const PetscReal du[], PetscReal y[], PetscInt *failed);
PetscErrorCode MpmActionDestroy(MpmAction *action);

/* ---- newton.c, solver.c, step.c, model.c ---- */

struct _p_MpmModel {
  MPI_Comm        comm;
  PetscMPIInt     rank, size;
  MpmRecord       record;
  char           *title, *prefix;
  MpmPhysics      physics;
  MpmLayout       layout;
  MpmStretch      stretch;
  MpmGrid         grid;
  MpmShapeType    shape;
  MpmJacobianType jacobian_type;
  char           *solver, *solver_why; /* the preset; why `auto` took it, or NULL */
  PetscInt        material_count, body_count, bc_count, load_count, track_count, wall_count;
  char          **material_names, **body_names, **bc_names, **load_names, **track_names;
  MpmMaterial    *materials;
  MpmBody        *bodies;
  MpmCondition   *bcs;
  MpmLoad        *loads;
  MpmTrack       *tracks;
  MpmWall        *walls;
  MpmParticles    particles;
  MpmBodyForce    body_force;
  void           *body_force_ctx;
  PetscBool       fbar;
  PetscReal       ghost;        /* factor of the ghost penalty, 0: none */
  PetscBool       ghost_rescue; /* switch it on when a step fails */
  PetscBool       symmetric;

  /* time */
  PetscReal time, time_end, dt_nominal, dt_min, dt_max, growth;
  PetscBool adaptive;
  PetscInt  step, cuts, cuts_total;

  /* the step being solved */
  MpmPoints      points;
  MpmSpace       space;
  MpmConstraints constraints;
  MpmPattern     pattern;
  MpmSum         sum;
  MpmMean        mean;
  PetscReal     *u, *residual, *force; /* local nodes */
  PetscBool      committed;            /* do these three tell of the last step that has become the state? */
  PetscReal      diagonal;             /* of held unknowns: a typical stiffness */
  char           mat_type[64], vec_type[64];
  PetscBool      may_be_indefinite; /* CG was `auto`'s choice: GMRES takes over where the Jacobian loses definiteness */
  PetscBool      indefinite;        /* it has */
  PetscBool      factorises;        /* the preconditioner is a direct solver */
  SNES           snes;
  Mat            jacobian;      /* assembled; NULL when the preconditioner does without it */
  Mat            shell;         /* its action alone, with MPM_JACOBIAN_MATFREE */
  PetscBool      matrix_unused; /* the shell is preconditioner matrix too */
  PetscBool      keep_tangents;
  Vec            x, f;
  char           lost[128]; /* tells of a point that left the grid */
  PetscBool      predict;   /* start from the last step's increment */
  PetscReal      dt_last;   /* of the last step, 0 before the first */
  PetscReal      reference; /* residual of the step in which nothing moves */
  PetscBool      lag;       /* may a Jacobian serve for more than one iteration? */
  PetscBool      solving;   /* SNES is at work: others who ask for a Jacobian get a new one */
  PetscBool      lagged;    /* has the last one? */
  PetscReal      fnorm_last;
  PetscBool      ahead;           /* a Jacobian at the same place will follow the next residual: both in one pass */
  PetscBool      made;            /* it has been made with the last residual and waits to be assembled */
  PetscBool      overwritten;     /* the matrix no longer holds the Jacobian of the last solve */
  PetscInt       made_count;      /* Jacobians of this solution, */
  PetscInt       made_count_last; /* and of the last one */
  PetscInt       newton, linear;
  PetscInt64     newton_total, linear_total, active_dofs_max;

  /* results */
  PetscInt   output_every;
  PetscBool  output_grid, output_single;
  PetscInt   output_field_count; /* 0: all */
  char     **output_fields;
  MpmOutput  output;
  MpmHistory history;
  PetscReal *history_row;
  PetscInt   history_columns;
  PetscReal *reaction; /* per condition and component of the block */
  PetscReal  seconds[MPM_TIME_COUNT], start;
  PetscBool  quiet;
};

/* Stops the clock of one task: adds the seconds since `since` to it. */
static inline void MpmClock(MpmModel model, MpmTimer timer, PetscLogDouble since)
{
  PetscLogDouble now;

  (void)PetscTime(&now);
  model->seconds[timer] += now - since;
}

/*
  The Jacobian of the model's present step as a shell matrix, with or without tangents kept (matfree.c). It must not
  outlive the step's space.
*/
PetscErrorCode MpmMatfreeCreate(MpmModel model, PetscBool stored, Mat *J);
PetscErrorCode MpmMatfreeSetState(Mat J, Vec x);
/* Residual, Jacobian, convergence test and line search, handed to SNES (newton.c). */
PetscErrorCode MpmNewtonAttach(MpmModel model);
PetscErrorCode MpmNewtonSetMats(MpmModel model);
/* Brings the solution vector to the local nodes, ghosts included. */
PetscErrorCode MpmGatherSolution(MpmModel model, Vec x);
/* Presets, PETSc's solver objects and their options (solver.c). */
PetscErrorCode MpmSolverSetFromOptions(MpmModel model, const MpmOptions *options);
/* Settles `auto` once the points are there, and applies the preset. */
PetscErrorCode MpmSolverChoose(MpmModel model);
PetscErrorCode MpmSolverSetUp(MpmModel model);
PetscErrorCode MpmSolverSetNearNullSpace(MpmModel model);
PetscErrorCode MpmSolverSolve(MpmModel model, SNESConvergedReason *reason);
PetscErrorCode MpmSolverDestroy(MpmModel model);
/*
  Everything before Newton: space, conditions, loads, initial guess, for a step from model->time to `time`, dt later.
  `again`: the points have not moved since the last call, the space stands.
*/
PetscErrorCode MpmStepPrepare(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why);
/*
  One step from model->time to `time`, dt later; `again` as above. `why` is NULL when it converged, otherwise the
  reason (static text); `hopeless`: a shorter step would not help.
*/
PetscErrorCode MpmStep(MpmModel model, PetscReal time, PetscReal dt, PetscBool again, const char **why,
                       PetscBool *hopeless);
/* The space of the points where they are now, without a step. */
PetscErrorCode MpmStepSpace(MpmModel model, const char **why);
/* The points' fields that the scene asks for (fields.c): do they exist? Into the output. */
PetscErrorCode MpmFieldsCheck(MpmModel model);
PetscErrorCode MpmFieldsWrite(MpmModel model);
/* Active nodes and cells into the output (lattice.c). */
PetscErrorCode MpmLatticeWrite(MpmModel model);
/* Results (results.c). */
PetscErrorCode MpmOutputSetFromOptions(MpmModel model, const MpmOptions *block);
PetscErrorCode MpmModelWriteOutput(MpmModel model);
PetscErrorCode MpmModelCreateHistory(MpmModel model);
PetscErrorCode MpmModelWriteHistory(MpmModel model, PetscReal dt);
PetscErrorCode MpmModelWriteSummary(MpmModel model, const char *status);
