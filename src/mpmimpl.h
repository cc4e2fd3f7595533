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
#define MPM_GHOST_RESCUE 1e-2 /* and where a step has failed without */
#define MPM_TOLERANCE    1e-6 /* of a cell: what counts as "on" a region's edge */

/* det of a dim x dim matrix */
static inline PetscReal MpmDeterminant(PetscInt dim, const PetscReal A[])
{
  if (dim == 2) return A[0] * A[3] - A[1] * A[2];
  return A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6]) + A[2] * (A[3] * A[7] - A[4] * A[6]);
}

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
/* The cuts as numbers (free them), and back where they are for as many ranks as there are. */
PetscErrorCode MpmGridGetCut(const MpmGrid *grid, PetscInt *count, PetscInt **numbers);
PetscErrorCode MpmGridSetCut(MpmGrid *grid, PetscInt count, const PetscInt numbers[], PetscBool *set);
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
PetscInt MpmStateComponents(const MpmStateVariable *variable, PetscInt dim);
/* Initial history of a material, after the tables of its law. */
void MpmMaterialStateAtRest(const MpmMaterial *material, PetscInt dim, PetscReal state[]);

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
  PetscReal *mass;      /* kg; where a point's mass is not its density times volume0: initial stress, other materials */
  PetscReal *stress;    /* Cauchy, xx, yy, zz, xy (, yz, xz) */
  PetscReal *state;     /* state_size values */
  PetscReal *value;     /* rate values */
  PetscReal *increment; /* of the last step's displacement, dim values, and its gradient by x, row-major */
} MpmPoints;

/* A field of the swarm, by its name there. */
typedef struct {
  char     *name;
  PetscInt  components;
  PetscBool integer;
} MpmPointField;

typedef struct {
  DM             swarm;
  PetscInt       field_count;
  MpmPointField *fields; /* all of them, id first */
  PetscInt       dim, stress_size, state_size, rates;
  PetscBool      has_half_length, has_increment;
  PetscBool      has_mass; /* set before MpmParticlesCreate() */
  PetscInt64     total;
  PetscReal      imbalance; /* points on the fullest rank over their mean, the most so far */
  PetscInt       rebalances;
  char           lost[192]; /* tells of a point that is lost; empty while all are there */
  PetscBool      gone;      /* it is not merely in a wrong place */
} MpmParticles;

/* Points that are not there yet, or no longer: all their fields, one point after the other. */
typedef struct {
  PetscInt count;
  char    *data;
} MpmParked;

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
/* Takes the points with ids in [first, end) out; `parked` keeps them on this rank, NULL: they are gone. */
PetscErrorCode MpmParticlesRemove(MpmParticles *particles, PetscInt first, PetscInt end, MpmParked *parked);
/* Puts parked points back; MpmParticlesMigrate() then sends them where they belong. */
PetscErrorCode MpmParticlesReturn(MpmParticles *particles, MpmParked *parked);
/* A point's mass, kg. */
static inline PetscReal MpmPointMass(const MpmPoints *points, const MpmMaterial materials[], PetscInt p)
{
  return points->mass ? points->mass[p] : points->volume0[p] * materials[points->material[p]].density;
}
/*
  Moves the partition, not the points, when the fullest rank holds too many and another partition has a good part fewer,
  or `always`; `moved` tells.
*/
PetscErrorCode MpmParticlesRebalance(MpmParticles *particles, MpmGrid *grid, PetscBool always, PetscBool *moved);
/* Both: points at their ranks, ranks about equally full. `why` is NULL, or tells of a lost point. */
PetscErrorCode MpmParticlesDistribute(MpmParticles *particles, MpmGrid *grid, const char **why);

/* ---- pointfile.c ---- */

/*
  A file of points, HDF5 or CSV, of which each rank has `count` rows. Get gives a quantity's components, row by row, to
  be freed; NULL where the file has none and the need is optional. All collective.
*/
typedef struct _p_MpmPointFile *MpmPointFile;
PetscErrorCode MpmPointFileOpen(const MpmOptions *block, PetscInt dim, const char *path, const char *step,
                                MpmPointFile *file);
PetscErrorCode MpmPointFileClose(MpmPointFile *file);
PetscInt       MpmPointFileCount(MpmPointFile file);
PetscErrorCode MpmPointFileGet(MpmPointFile file, const char *quantity, PetscInt components, MpmNeed need,
                               PetscReal **values);

/* ---- imported.c ---- */

/* The points of a body that come from a file, this rank's. */
typedef struct _p_MpmImported *MpmImported;
PetscErrorCode MpmImportedCreate(const MpmOptions *block, const MpmGrid *grid, const MpmMaterial *material,
                                 MpmImported *imported);
PetscErrorCode MpmImportedDestroy(MpmImported *imported);
PetscInt       MpmImportedCount(MpmImported imported);
/* Writes them from point `first` on, all but id and material. */
PetscErrorCode MpmImportedFill(MpmImported imported, const MpmGrid *grid, const MpmMaterial *material,
                               PetscInt state_size, PetscInt first, MpmPoints *points);

/* ---- body.c ---- */

typedef struct _p_MpmBody *MpmBody;
PetscErrorCode MpmBodyCreate(const MpmOptions *options, const char *name, const MpmGrid *grid, PetscInt material_count,
                             const MpmMaterial materials[], MpmBody *body);
PetscErrorCode MpmBodyDestroy(MpmBody *body);
/* Fills the particles with the points of all bodies; ids do not depend on the number of ranks. */
/* About how many points the body has; widens the box of cells [lower, upper) to hold its cells. */
PetscErrorCode MpmBodyEstimate(const MpmBody body, const MpmGrid *grid, PetscInt lower[], PetscInt upper[],
                               PetscReal *points);
PetscErrorCode MpmBodiesGenerate(PetscInt body_count, const MpmBody bodies[], const MpmMaterial materials[],
                                 const MpmGrid *grid, MpmParticles *particles);
/* The ids of a body's points, [first, end); known once the points have been made. */
void      MpmBodyGetIds(MpmBody body, PetscInt *first, PetscInt *end);
PetscBool MpmBodyIsImported(MpmBody body);

/* ---- limits.c ---- */

/* Refuses bodies that cannot fit into memory, or whose points PETSc cannot count. */
PetscErrorCode MpmMemoryCheck(const MpmOptions *options, const MpmGrid *grid, PetscInt count, const MpmBody bodies[],
                              char *const names[]);
/* Refuses more steps than can be counted, and steps that are lost in rounding. */
PetscErrorCode MpmStepsCheck(const MpmOptions *block, PetscReal end, PetscReal step, PetscReal step_min);

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
/*
  Half-lengths of a point's domain in cells: the initial ones stretched by the diagonal of U, cut at walls and at the
  grid's edges. The cut is not remembered. PETSC_FALSE where the point has no stretch.
*/
PetscBool MpmSpaceHalfLengths(const MpmRules *rules, const MpmPoints *points, PetscInt point, PetscReal half[]);
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

/* ---- condition.c, frame.c ---- */

/* A Dirichlet condition on nodes: on components of their unknowns, or on the displacement along a normal. */
typedef struct {
  char     *name;
  MpmRegion region;
  PetscBool inclined;            /* it has a normal: value[0] is along it, components are those of the reaction */
  PetscReal normal[MPM_MAX_DIM]; /* of length 1 */
  PetscInt  component_count;
  PetscInt  component[MPM_MAX_BLOCK];
  PetscReal value[MPM_MAX_BLOCK];
  MpmRamp   ramp;
  PetscBool active; /* in this stage; its ramp counts from `start` */
  PetscReal start;
} MpmCondition;

/* The frame of a node that a condition with a normal holds; rows q_r, of which the first `held` are held (frame.c). */
typedef struct {
  PetscInt  held, condition[MPM_MAX_DIM]; /* condition: whose equation it is */
  PetscReal value[MPM_MAX_DIM];
  PetscReal axis[MPM_MAX_DIM][MPM_MAX_DIM];   /* q_r */
  PetscReal factor[MPM_MAX_DIM][MPM_MAX_DIM]; /* L_kr */
} MpmFrame;

/*
  The conditions as they act on the local unknowns of a step. At a node with a frame the unknowns of the displacement are
  its components in the frame.
*/
typedef struct {
  PetscInt  *condition; /* per local unknown: which condition holds it, or -1 */
  PetscReal *value;     /* the value that it takes */
  PetscBool  any;
  PetscInt   dim;
  PetscInt  *frame_of; /* per local node: its frame, or -1; NULL where no condition has a normal */
  MpmFrame  *frames;
} MpmConstraints;

PetscErrorCode MpmConditionCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                  const MpmLayout *layout, MpmCondition *bc);
PetscErrorCode MpmConditionDestroy(MpmCondition *bc);
/* The walls that a condition makes; walls has room for 2*dim. */
PetscErrorCode MpmConditionGetWalls(const MpmCondition *bc, const MpmGrid *grid, PetscInt degree, PetscInt *count,
                                    MpmWall walls[]);
PetscErrorCode MpmConstraintsSetUp(MpmConstraints *constraints, PetscInt bc_count, const MpmCondition bcs[],
                                   const MpmGrid *grid, const MpmLayout *layout, const MpmSpace *space,
                                   PetscReal time_n, PetscReal time);
PetscErrorCode MpmConstraintsReset(MpmConstraints *constraints);
/*
  Adds the forces of the supports on the body, those that the owned nodes' residual lacks in balance; reaction[b*block + c]
  for condition b and component c.
*/
void MpmConstraintsAddReactions(const MpmConstraints *constraints, PetscInt block, PetscInt owned,
                                const PetscReal residual[], PetscReal reaction[]);

static inline const MpmFrame *MpmConstraintsFrame(const MpmConstraints *constraints, PetscInt node)
{
  return constraints->frame_of && constraints->frame_of[node] >= 0 ? &constraints->frames[constraints->frame_of[node]]
                                                                   : NULL;
}
/* Adds the equation a . u = g, |a| = 1, unless it depends on those there are; then makes the frame whole. */
void MpmFrameAdd(MpmFrame *frame, PetscInt dim, const PetscReal a[], PetscReal g, PetscInt condition);
void MpmFrameComplete(MpmFrame *frame, PetscInt dim);
/* The force along the vector of each equation into which the supports' force on the node falls. */
void MpmFrameForces(const MpmFrame *frame, PetscInt dim, const PetscReal force[], PetscReal amount[]);
/*
  Turns the values (`bs` a node) of the first `nodes` local nodes from components along the axes into those that the solver
  works with, and back; element blocks [i][c][d][j] and the diagonal blocks of nodes likewise. Where no node has a frame
  nothing is done.
*/
void MpmFramesToUnknowns(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscReal values[]);
void MpmFramesToAxes(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscReal values[]);
void MpmFramesRotateElement(const MpmConstraints *constraints, PetscInt bs, PetscInt n, const PetscInt nodes[],
                            PetscReal element[]);
void MpmFramesRotateBlocks(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscReal blocks[]);

/* ---- boundary.c, contact.c ---- */

typedef enum { MPM_BOUNDARY_PLANE, MPM_BOUNDARY_SPHERE, MPM_BOUNDARY_CYLINDER, MPM_BOUNDARY_POLYGON } MpmBoundaryType;

/* A surface that holds the material by a penalty. */
typedef struct {
  char           *name, *slip_field[MPM_MAX_DIM]; /* fields of the particles, with stick only */
  MpmBoundaryType type;
  PetscInt        dim;
  PetscReal  point[MPM_MAX_DIM], direction[MPM_MAX_DIM], radius; /* direction: a plane's normal, a cylinder's axis */
  PetscReal  side;                                               /* 1: the material is outside, -1: inside */
  PetscInt   vertex_count;
  PetscReal *vertices, penalty, motion[MPM_MAX_DIM];
  PetscBool  stick, bilateral;
  MpmRegion  region; /* of the points concerned, at the start */
  MpmRamp    ramp;
} MpmBoundary;

/* Distance from a boundary, positive where the material is, its gradient and its second derivative. */
typedef struct {
  PetscReal distance, normal[MPM_MAX_DIM], second[MPM_MAX_DIM][MPM_MAX_DIM];
} MpmSurface;

/* A point that may touch a boundary in this step. */
typedef struct {
  PetscInt  point, group, boundary, weight; /* weight: where the face's weights at the group's nodes stand */
  PetscReal face[MPM_MAX_DIM], normal[MPM_MAX_DIM], slip[MPM_MAX_DIM]; /* at the step's start */
  PetscReal stiffness;                                                 /* N/m */
} MpmContact;

/* Those of this rank's points, and what they do. */
typedef struct {
  PetscInt           boundary_count;
  const MpmBoundary *boundaries;
  PetscReal (*before)[MPM_MAX_DIM], (*after)[MPM_MAX_DIM]; /* the boundaries' motions at the step's start and end */
  PetscReal (*reaction)[MPM_MAX_DIM], *depth; /* of the last step: forces on the body; deepest places behind, m */
  PetscReal   unit, touch;                    /* 1/h; a face that is no further away touches */
  PetscInt    count, capacity;
  MpmContact *contact;
  PetscReal  *weight;
} MpmContacts;

PetscErrorCode MpmBoundaryCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                 MpmBoundary *boundary);
PetscErrorCode MpmBoundaryDestroy(MpmBoundary *boundary);
/* Do the scene's points suit it? */
PetscErrorCode MpmBoundaryCheck(const MpmBoundary *boundary, const MpmGrid *grid, MpmParticles *particles);
void           MpmBoundaryMotion(const MpmBoundary *boundary, PetscReal time, PetscReal motion[]);
void           MpmBoundaryDistance(const MpmBoundary *boundary, const PetscReal motion[], const PetscReal x[],
                                   MpmSurface *surface);
/* Room for the boundaries' motions and reactions; the boundaries are borrowed. */
PetscErrorCode MpmContactsCreate(PetscInt count, const MpmBoundary boundaries[], MpmContacts *contacts);
PetscErrorCode MpmContactsDestroy(MpmContacts *contacts);
/* Finds the contacts of the step from time_n to `time`. */
PetscErrorCode MpmContactsSetUp(MpmContacts *contacts, const MpmRules *rules, const MpmSpace *space,
                                const MpmPoints *points, MpmParticles *particles, PetscReal time_n, PetscReal time);

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
  PetscBool   active; /* in this stage; its ramp counts from `start` */
  PetscReal   start;
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
  const MpmContacts    *contacts;
  MpmMean               mean;
} MpmSum;

/* Do any of the kernel's inputs need the weights, not only their derivatives? */
PetscBool MpmLayoutUsesValues(const MpmLayout *layout);
/* Adds `factor` times the load to the external force at the local nodes. */
PetscErrorCode MpmLoadApply(const MpmLoad *load, PetscReal factor, const MpmRules *rules, const MpmSum *sum,
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

/* The contacts' part of residual, Jacobian, action and diagonal blocks, in every form of the Jacobian (contact.c). */
void           MpmContactsResidual(const MpmSum *sum, const PetscReal u[], PetscReal residual[]);
void           MpmContactsApply(const MpmSum *sum, const PetscReal u[], const PetscReal du[], PetscReal y[]);
void           MpmContactsDiagonal(const MpmSum *sum, const PetscReal u[], PetscReal blocks[]);
PetscErrorCode MpmContactsJacobian(const MpmSum *sum, const PetscReal u[], MpmPattern *pattern);
/* Reactions and depths of the converged step; keeps the slips. */
PetscErrorCode MpmContactsCommit(MpmContacts *contacts, const MpmSum *sum, const PetscReal u[],
                                 MpmParticles *particles);

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

/* ---- checkpoint.c, restart.c, scalars.c, signals.c ---- */

/* A checkpoint that a run goes on from (restart.c). */
typedef struct _p_MpmRestart *MpmRestart;

/* When checkpoints are written, and the one that the run has started from. */
typedef struct {
  PetscInt    every, keep;
  PetscReal   wall;       /* s between them, 0: not by wall time */
  PetscReal   collective; /* bytes from which all ranks read and write together */
  char       *from;       /* the option -mpm_restart, or NULL */
  PetscInt64  run;        /* a number of its own for each run; it stays the same over restarts */
  PetscInt    step;       /* of the last one, -1: none yet */
  PetscReal   since;      /* wall time of the last one, or of the start */
  MpmTextFile options;    /* rank 0: those that continue the run */
  PetscBool   options_written;
  MpmRestart  restart; /* NULL: the run starts at the beginning */
} MpmCheckpoint;

/* The model's numbers by name, as they stand in a checkpoint (scalars.c). */
typedef struct {
  PetscInt     count;
  const char **name;
  PetscBool   *real, *there; /* a real number or an integer; is it in the checkpoint? */
  PetscReal   *value;
  PetscInt64  *number;
} MpmScalars;
PetscErrorCode MpmScalarsCreate(MpmModel model, MpmScalars *scalars);
PetscErrorCode MpmScalarsRestore(const MpmScalars *scalars, MpmModel model);
PetscErrorCode MpmScalarsDestroy(MpmScalars *scalars);

PetscErrorCode MpmCheckpointSetFromOptions(MpmModel model, const MpmOptions *options);
/* The text of all options that define the scene and must be the same when a run goes on, a line each; or of those given. */
PetscErrorCode MpmCheckpointScene(MpmModel model, PetscBool given, MpmTextFile *scene);
/* Keeps the options that continue the run, before presets have added theirs. */
PetscErrorCode MpmCheckpointKeepOptions(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmCheckpointWrite(MpmModel model);
/* To be called after each step: writes what is due; `stop`: a signal asks for the end of the run. */
PetscErrorCode MpmCheckpointStep(MpmModel model, PetscBool *stop);
PetscErrorCode MpmCheckpointDestroy(MpmCheckpoint *checkpoint);

/*
  Going on, in this order: Open finds the checkpoint and checks it against the scene, ReadPoints fills the particles in
  place of the bodies, Apply sets the model's numbers once the solver is chosen, Results takes up the result files.
*/
PetscErrorCode MpmRestartOpen(MpmModel model);
PetscErrorCode MpmRestartReadPoints(MpmModel model);
PetscErrorCode MpmRestartApply(MpmModel model);
PetscErrorCode MpmRestartHistory(MpmModel model, const char *path, const char *const names[]);
/* Without `apply` it only looks whether the file can be continued. */
PetscErrorCode MpmRestartOutput(MpmModel model, PetscBool apply);
PetscErrorCode MpmRestartDestroy(MpmRestart *restart);

/* From Catch to Release, SIGTERM and SIGUSR1 only leave a note. */
PetscErrorCode MpmSignalsCatch(void);
PetscErrorCode MpmSignalsRelease(void);
PetscBool      MpmSignalsCaught(void);

/* ---- terminal.c ---- */

/* What the line of a step needs to know of the steps before. */
typedef struct {
  PetscLogDouble since;             /* the end of the step before */
  PetscReal      seconds, progress; /* wall time and time of the run, fading */
  PetscInt       lines;
} MpmTerminal;

/* Header, line of a step, and a line between two steps; nothing with -mpm_quiet. */
PetscErrorCode MpmTerminalBegin(MpmModel model);
PetscErrorCode MpmTerminalStep(MpmModel model, PetscReal dt);
PetscErrorCode MpmTerminalNote(MpmModel model, const char format[], ...) PETSC_ATTRIBUTE_FORMAT(2, 3);
/* "0:02:05", "4 d 4 h" */
#define MPM_DURATION_TEXT 32
void MpmTerminalDuration(PetscReal seconds, char text[MPM_DURATION_TEXT]);

/* ---- stage.c ---- */

/* How time is cut into steps. */
typedef struct {
  PetscReal end, step, step_min, step_max, growth;
  PetscBool adaptive;
} MpmTimeControl;

typedef enum { MPM_GEOSTATIC_NONE, MPM_GEOSTATIC_GRAVITY, MPM_GEOSTATIC_K0 } MpmGeostaticMethod;

/* The search for a state of stress in which nothing moves. */
typedef struct {
  MpmGeostaticMethod method;
  PetscReal          k0;
  PetscReal          tolerance; /* largest displacement that remains, in heights of the material */
  PetscInt           iterations;
} MpmGeostatic;

/*
  One stage of a scene: which conditions and loads act, how time runs, and what happens to the bodies at its start. A
  scene without stages is one stage without a name.
*/
typedef struct {
  char          *name;
  MpmTimeControl time;
  PetscBool     *bcs, *loads;    /* by the model's lists: does it act? */
  PetscBool     *removed, *adds; /* by the model's bodies */
  PetscInt      *material;       /* by the model's bodies: of its points from here on, or -1 */
  PetscBool      reset;          /* displacements start at zero again */
  MpmGeostatic   geostatic;
} MpmStage;

/* ---- initial.c ---- */

/*
  States of one material with a wanted stress. Where the law's stress follows from its history alone (`remembers`), F
  stays the identity and all six components are met; otherwise F carries the stress, in plane strain without the
  component across the plane.
*/
typedef struct {
  const MpmMaterial *material;
  MpmKernelSet       kernel;
  MpmFunction        law[MPM_FORM_COUNT];
  PetscInt           dim, model_dim; /* of the kernel, and of the model */
  PetscBool          remembers;
} MpmInitial;

#define MPM_INITIAL_STATE 64 /* most values of a history in 3D */
PetscErrorCode MpmInitialCreate(const MpmMaterial *material, PetscInt dim, MpmInitial *initial);
/*
  F and state with the Cauchy stress `stress` (xx, yy, zz, xy (, yz, xz); on exit the stress of that state), from the
  history state_n on. Returns 0; 1 where the stress is outside the yield surface and the law's return has moved it; 2
  where there is no such state.
*/
int MpmInitialFind(const MpmInitial *initial, const PetscReal state_n[], PetscReal stress[], PetscReal F[],
                   PetscReal state[]);

/* ---- overburden.c ---- */

/*
  The weight above each point per area of its domain: the integral of the weight density over the vertical column above
  the point's centre, through all domains, averaged over the domain's width. `axis` is the vertical one, `up` +1 or -1
  along it, gravity in m/s2.
*/
typedef struct {
  PetscInt  axis, up;
  PetscReal gravity;
} MpmVertical;
PetscErrorCode MpmOverburden(const MpmGrid *grid, const MpmPoints *points, const MpmVertical *vertical,
                             const PetscReal half_length[], PetscReal pressure[]);

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
  PetscInt        material_count, body_count, bc_count, boundary_count, load_count, track_count, wall_count;
  char          **material_names, **body_names, **bc_names, **boundary_names, **load_names, **track_names;
  MpmMaterial    *materials;
  MpmBody        *bodies;
  MpmCondition   *bcs;
  MpmBoundary    *boundaries;
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
  PetscReal dt_wanted; /* of the next step */
  PetscBool adaptive;
  PetscInt  step, cuts, cuts_total;

  /* stages */
  PetscInt   stage_count, stage; /* how many, and the one under way */
  MpmStage  *stages;
  MpmParked *parked;     /* per body: points that a later stage adds */
  PetscReal  time_start; /* of the stage under way; time_end is its end */
  PetscReal  run_end;
  PetscReal  load_scale;       /* what a geostatic stage applies of its loads; otherwise 1 */
  PetscBool  reference_output; /* position0 goes into the next state that is written */

  /* the step being solved */
  MpmPoints      points;
  MpmSpace       space;
  MpmConstraints constraints;
  MpmPattern     pattern;
  MpmSum         sum;
  MpmMean        mean;
  MpmContacts    contacts;
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
  PetscInt   output_step; /* of the last written state */
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

  MpmCheckpoint checkpoint;
  MpmTerminal   terminal;
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
/*
  Stages (stage.c): their names, and the conditions and loads that only they name; then, when the scene is known, the
  rest.
*/
PetscErrorCode MpmStagesReadLists(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmStagesRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmStagesDestroy(MpmModel model);
/* Does any stage change what a point weighs per stress-free volume? */
PetscBool MpmStagesKeepMass(const MpmModel model);
PetscBool MpmStagesAreGeostatic(const MpmModel model);
/* Once the points are there: finds those that carry loads, and puts those aside that later stages add. */
PetscErrorCode MpmStagesSelect(MpmModel model);
/* What a stage's bodies are made of from here on: stress, mass and shape stay (rematerial.c). */
PetscErrorCode MpmMaterialsChange(MpmModel model, const MpmStage *stage);
/* Makes a stage the one under way: bodies, materials, conditions, loads, time. */
PetscErrorCode MpmStageBegin(MpmModel model, PetscInt stage);
/* For a run that goes on in model->stage at model->time: time control, and what acts; the points are as they were. */
PetscErrorCode MpmStageResume(MpmModel model);
/* The factor of a load at a time, 0 where it does not act. */
PetscReal MpmModelLoadFactor(const MpmModel model, PetscInt load, PetscReal time);
/* The whole of a geostatic stage (geostatic.c); `why` is NULL, or the reason why it was given up. */
PetscErrorCode MpmGeostaticRun(MpmModel model, const char **why);
/* For lists of blocks: with -help, a list that the scene does not give becomes one block called NAME. */
PetscErrorCode MpmModelReadNames(const MpmOptions *options, const char *list, const char *help, MpmNeed need,
                                 PetscInt *count, char ***names);
/* After a step has failed: the ghost penalty on, and the same step again. */
PetscErrorCode MpmModelSwitchGhostOn(MpmModel model, const char *why);
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
