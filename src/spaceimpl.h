#pragma once
/*
  What a step's discrete space is made of, from the inside: grid, materials, physics, points, bodies, nodes. Each block
  names the file that implements it. Included by mpmimpl.h.
*/
#include "dense.h"
#include "mpm.h"

#define MPM_MAX_DIM        3
#define MPM_MAX_BLOCK      8                         /* unknowns a node: displacement, pressure, damage, ... */
#define MPM_MAX_INPUTS     24                        /* inputs of a kernel */
#define MPM_GHOST_FACTOR   1e-2                      /* of the ghost penalty; */
#define MPM_GHOST_REST     3e-7                      /* where nothing is to move, with iterative solvers; */
#define MPM_GHOST_SPARSE   1e-1                      /* where points are sparse; */
#define MPM_GHOST_RESCUE   1e-1                      /* and where a run would give up with less */
#define MPM_NU_LOCKS       0.45                      /* Poisson's ratio above which material is nearly incompressible */
#define MPM_INCREMENT(dim) (2 * (dim) * ((dim) + 1)) /* numbers that tell of the last two steps' increments */
#define MPM_TOLERANCE      1e-6                      /* of a cell: what counts as "on" a region's edge */

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
  PetscReal   density, stiffness, nu; /* nu: Poisson's ratio, 0 where the law has none */
  PetscReal   penalty; /* scale of penalties: E where the law has it; a constrained modulus locks as nu goes to 1/2 */
  PetscReal   spacing; /* most cells from point to point on an axis at the start; 0: unknown */
  PetscInt    state_size;
} MpmMaterial;

/* Finds a law by name, as compiled for a form. Returns PETSC_FALSE where there is none. */
PetscBool      MpmLawFind(const char *name, PetscInt dim, MpmForm form, MpmLawInfo *info);
PetscErrorCode MpmMaterialCreate(const MpmOptions *options, const char *name, PetscInt dim, MpmMaterial *material);
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
  PetscReal *mass;   /* kg; where a point's mass is not its density times volume0: initial stress, other materials */
  PetscReal *stress; /* Cauchy, xx, yy, zz, xy (, yz, xz) */
  PetscReal *state;  /* state_size values */
  PetscReal *value;  /* rate values */
  PetscReal
    *increment; /* of the last step's displacement, dim values, and its gradient by x, row-major; the one before */
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
/* Places that DMSwarm keeps free: with none, it reallocates all fields for each point that leaves; it clears them, too. */
#define MPM_PARTICLES_SPARE 16
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
/* About how many points the body has; widens the box of cells [lower, upper) to hold its cells. */
PetscErrorCode MpmBodyEstimate(const MpmBody body, const MpmGrid *grid, PetscInt lower[], PetscInt upper[],
                               PetscReal *points);
/* Fills the particles with the points of all bodies; ids do not depend on the number of ranks. */
PetscErrorCode MpmBodiesGenerate(PetscInt body_count, const MpmBody bodies[], const MpmMaterial materials[],
                                 const MpmGrid *grid, MpmParticles *particles);
/* Where a place is to the region of a body; one from a file has none. */
typedef enum { MPM_HOLD_NONE, MPM_HOLD_EDGE, MPM_HOLD_INSIDE } MpmHold;
MpmHold MpmBodyHolds(MpmBody body, const MpmGrid *grid, const PetscReal x[]);
/* Would both have a point at the same places of a cell? */
PetscBool MpmBodiesShareLattice(MpmBody one, MpmBody other);
/* Of the points' domains, in a body that is not from a file. */
void MpmBodyHalfLengths(MpmBody body, const MpmGrid *grid, PetscReal half[]);
/* Points on an edge that the body shares with one of these are theirs. To be called before the points are made. */
PetscErrorCode MpmBodySetBefore(MpmBody body, PetscInt count, const MpmBody before[]);
/* The ids of a body's points, [first, end); known once the points have been made. */
void      MpmBodyGetIds(MpmBody body, PetscInt *first, PetscInt *end);
PetscBool MpmBodyIsImported(MpmBody body);
/* Most cells from point to point on an axis; 0 for bodies from files. */
PetscReal MpmBodySpacing(MpmBody body);
PetscInt  MpmBodyMaterial(MpmBody body);
/* Which body each point belongs to; ids ascend from body to body. */
void MpmBodiesOfPoints(PetscInt body_count, const MpmBody bodies[], const MpmPoints *points, PetscInt body_of[]);

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
  PetscInt    axis, degree;
  PetscInt    first[MPM_MAX_DIM], lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* edges: nodes at which splines end */
  MpmEdgeType edge[MPM_MAX_DIM];
  PetscReal   stiffness;                                             /* gamma E_s, Pa */
  PetscReal   along[MPM_MAX_DIM][MPM_GHOST_WIDTH * MPM_GHOST_WIDTH]; /* the matrix is their Kronecker product */
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
  MpmEdgeType        edge;
  PetscInt           wall_count;
  const MpmWall     *walls;
  MpmStretch         stretch;
  const MpmMaterial *materials;
  PetscReal          ghost, sparse; /* factor of the ghost penalty, 0: none; at least so much where points are sparse */
  PetscBool          mean;          /* with the cells of a mean */
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
void MpmSpaceEvaluate(const MpmSpace *space, const MpmGroup *group, PetscInt point, MpmBasis *basis);
