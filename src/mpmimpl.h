#pragma once
/*
  The engine's objects from the inside: conditions, loads, sums over points, and the model that owns them. Each block names
  the file that implements it; what they stand on is in spaceimpl.h.
*/
#include "spaceimpl.h"

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
/* Values [i][c] of the nodes of a box. */
void MpmFramesRotateVector(const MpmConstraints *constraints, PetscInt bs, PetscInt n, const PetscInt nodes[],
                           PetscReal values[]);
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

/* What a run does at an equilibrium that is not stable. */
typedef enum { MPM_UNSTABLE_AUTO, MPM_UNSTABLE_STOP, MPM_UNSTABLE_FOLLOW } MpmUnstable;

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

/* What the points would be at the step's end, F, Cauchy stress and history, at the displacement u last evaluated. */
typedef struct {
  PetscReal *F, *stress, *state, *u;
  PetscBool  made; /* it holds what goes with the model's residual */
} MpmTrial;

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
  PetscBool             rest; /* nothing moves: stresses are those of the step's start */
  const MpmContacts    *contacts;
  const MpmTrial       *trial; /* where residuals leave the step's end; NULL: nowhere */
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

/*
  Values of the points, and their gradients by x where `gradient` is not NULL, at the owned nodes (project.c). Point p has
  `components` values from value[p*stride] and components * dim derivatives from gradient[p*stride].
*/
PetscErrorCode MpmProjectToNodes(const MpmSum *sum, PetscInt components, PetscInt stride, const PetscReal value[],
                                 const PetscReal gradient[], PetscReal nodal[]);

/* Finds the cells that means are taken over, after the groups (mean.c). */
PetscErrorCode MpmMeanCells(MpmSpace *space, const MpmPoints *points);
/*
  Derivatives of a point's fluxes, in one row of numbers, as the kernel gives them; N inputs without the mean m_bar. All but
  the first are there with means only.
*/
typedef struct {
  PetscReal *by_input; /* N x N */
  PetscReal *by_mean;  /* of the N fluxes by m_bar */
  PetscReal *of_mean;  /* of the flux conjugate to m_bar by the N inputs */
  PetscReal *second;   /* of that flux by m_bar */
  PetscReal *dm;       /* of m_bar by the N inputs */
} MpmTangent;
static inline PetscInt MpmTangentSize(const MpmLayout *layout)
{
  return layout->inputs * layout->inputs + layout->means * (3 * layout->inputs + 1);
}
static inline MpmTangent MpmTangentAt(PetscInt N, PetscReal row[])
{
  return (MpmTangent){row, row + N * N, row + N * (N + 1), row + N * (N + 2), row + N * (N + 2) + 1};
}
/* What the passes over a cell with a mean keep of one of its points. */
typedef struct {
  MpmKernelPoint point;
  MpmBasis       basis;
  PetscReal     *input, *dinput; /* of the kernel, and their change: the mean last */
  PetscReal     *flux;           /* conjugate to them */
  PetscReal     *ddm;            /* second derivatives of the point's own m: N x N */
  MpmTangent     tangent;
} MpmCellPoint;
/* Room for the points of one cell, and the cell's sums: m_bar and the flux conjugate to it. */
typedef struct {
  MpmCellPoint *point;
  PetscInt      begin; /* where the cell's points begin in the points' order */
  PetscReal    *storage, *values, *dvalues, *force;
  PetscReal     mean, mean_flux;
} MpmCellWork;
PetscErrorCode MpmCellWorkCreate(const MpmSum *sum, MpmCellWork *work);
PetscErrorCode MpmCellWorkDestroy(MpmCellWork *work);
/* The cell's points in the points' order, [begin, end). */
static inline PetscInt MpmCellBegin(const MpmSum *sum, const MpmCell *cell)
{
  return sum->space->groups[cell->group_begin].point_begin;
}
static inline PetscInt MpmCellEnd(const MpmSum *sum, const MpmCell *cell)
{
  return sum->space->groups[cell->group_end - 1].point_end;
}
/* Basis functions, inputs from the nodal values u, and their change from du; either may be NULL. */
PetscErrorCode MpmCellInputs(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], const PetscReal du[],
                             MpmCellWork *work);
/* m_bar from the inputs, and its derivatives; those of m of second order where they are asked for. */
PetscErrorCode MpmCellMean(const MpmSum *sum, const MpmCell *cell, PetscBool second, MpmCellWork *work,
                           PetscInt *failed);
/* All of that at u, and the whole fluxes, the mean's part included; with the step's end where the sum has room for it. */
PetscErrorCode MpmCellResidual(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], MpmCellWork *work,
                               PetscInt *failed);
/* The same with tangents in place of the step's end. */
PetscErrorCode MpmCellTangent(const MpmSum *sum, const MpmCell *cell, const PetscReal u[], MpmCellWork *work,
                              PetscInt *failed);
/* Fluxes to nodal forces. */
PetscErrorCode MpmCellScatter(const MpmSum *sum, const MpmCell *cell, const MpmCellWork *work, PetscReal force[]);
/* Local residual += sum over points of phi flux(u). `failed` counts points without an answer on this rank. */
PetscErrorCode MpmResidualLocal(const MpmSum *sum, const PetscReal u[], PetscReal residual[], PetscInt *failed);
/* The trial becomes the state: history, F, stress, and positions and rate values that go with u. */
PetscErrorCode MpmCommitLocal(const MpmSum *sum, const PetscReal u[]);

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
/* Adds a b^T + b c^T to a box, of vectors stored [i][c], likewise; the vectors are changed. */
void MpmPatternAddPair(MpmPattern *pattern, const MpmSpace *space, const MpmGroup *box,
                       const MpmConstraints *constraints, PetscReal a[], PetscReal b[], PetscReal c[]);

/* The ghost penalty (ghost.c). Faces become groups of the space, before its nodes are numbered. */
PetscErrorCode MpmGhostFaces(MpmSpace *space, const MpmRules *rules, const MpmPoints *points);
/* Adds the force of the increment u at the local nodes to their residual. */
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
  PetscReal    *u;         /* at the local nodes: where the derivative is taken */
  PetscReal    *tangent;   /* per place in the points' order, or NULL */
  PetscReal    *mean_flux; /* per cell */
  PetscReal    *values, *dvalues, *force, *storage;
  MpmBasis      basis;
  MpmCellWork   cell;
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

/* From Catch to Release, SIGTERM, SIGUSR1 and a first SIGINT only leave a note. */
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
  MpmEdgeType     edge;
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
  PetscBool       fbar, fbar_auto;
  MpmUnstable     unstable;                 /* what to do where the tangent loses definiteness */
  PetscBool       told_unstable;            /* it has, and that was said */
  const char     *fbar_why;                 /* what `auto` went by, or NULL */
  PetscReal       ghost;                    /* factor of the ghost penalty, 0: none */
  PetscBool       ghost_auto, ghost_rescue; /* nobody has set it; raise it before giving up */
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
  MpmContacts    contacts;
  MpmTrial       trial;
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
  char           lost[256]; /* tells of a point that left the grid, or of what nothing holds */
  PetscBool      predict;   /* start from the last step's increment */
  PetscReal      dt_last;   /* of the last step, 0 before the first; */
  PetscReal      dt_before; /* of the one before */
  PetscReal      reference; /* residual of the step in which nothing moves */
  PetscBool      lag;       /* may a Jacobian serve for more than one iteration? */
  PetscBool      lagged;    /* has the last one? */
  PetscBool      solving;   /* SNES is at work: others who ask for a Jacobian get a new one */
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
/* Sums the residual of model->u over the points, force included, and leaves it with the nodes' owners, along the axes. */
PetscErrorCode MpmSumResidual(MpmModel model, PetscInt *failed);
/* Brings the solution vector to the local nodes, ghosts included. */
PetscErrorCode MpmGatherSolution(MpmModel model, Vec x);
/* Presets, PETSc's solver objects and their options (solver.c). */
PetscErrorCode MpmSolverSetFromOptions(MpmModel model, const MpmOptions *options);
/* Settles `auto` once the points are there, and applies the preset. */
PetscErrorCode MpmSolverChoose(MpmModel model);
PetscErrorCode MpmSolverSetUp(MpmModel model);
PetscErrorCode MpmSolverSetNearNullSpace(MpmModel model);
PetscErrorCode MpmSolverSolve(MpmModel model, SNESConvergedReason *reason);
/* A new solver after a linear solve has failed, with GMRES where CG met an indefinite Jacobian. */
PetscErrorCode MpmSolverRenew(MpmModel model);
PetscErrorCode MpmSolverDestroy(MpmModel model);
/*
  Loss of definiteness (stability.c). Check: is the equilibrium just found a stable one? If not, `why` says so and where,
  unless the scene wants to follow it. Explain: adds to the reason for which a step has failed, where that is one.
*/
PetscErrorCode MpmStabilityRead(MpmModel model, const MpmOptions *options);
PetscBool      MpmStabilityWanted(const MpmModel model);
PetscErrorCode MpmStabilityCheck(MpmModel model, const char **why);
PetscErrorCode MpmStabilityExplain(MpmModel model, const char **why);
/* Frees the arrays. */
PetscErrorCode MpmTrialReset(MpmTrial *trial);
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
/*
  Bodies side by side (overlap.c): points on edges that two of them share are made once; and a scene in which two
  overlap that are there at the same time is refused, once the points are with their ranks.
*/
PetscErrorCode MpmBodiesShareEdges(MpmModel model);
PetscErrorCode MpmBodiesCheckOverlap(MpmModel model);
/*
  After a failed step (held.c): where nothing holds the material, or a piece of it, `why` says so; `hopeless` where the
  loads push along such a motion and no boundary may catch it.
*/
PetscErrorCode MpmHeldExplain(MpmModel model, const char **why, PetscBool *hopeless);
/* A line of the run's header where bodies share nodes (weld.c). */
PetscErrorCode MpmWeldsPrint(MpmModel model);
/* What a stage's bodies are made of from here on: stress, mass and shape stay (rematerial.c). */
PetscErrorCode MpmMaterialsChange(MpmModel model, const MpmStage *stage);
/* Makes a stage the one under way: bodies, materials, conditions, loads, time. */
PetscErrorCode MpmStageBegin(MpmModel model, PetscInt stage);
/* For a run that goes on in model->stage at model->time: time control, and what acts; the points are as they were. */
PetscErrorCode MpmStageResume(MpmModel model);
/* The factor of a load at a time, 0 where it does not act. */
PetscReal MpmModelLoadFactor(const MpmModel model, PetscInt load, PetscReal time);

/* The points of a geostatic stage (geostatic.c): what they return to, and what the report needs. */
typedef struct {
  PetscInt   n;
  PetscReal *x, *volume, *domain; /* position, volume, half lengths of the domain */
  PetscReal *F;                   /* before the step under way */
  PetscReal *start;               /* the stress that k0 gave, or NULL */
  PetscReal  height;
  PetscBool *remembers; /* per material */
  PetscReal  moved;     /* largest displacement of the last step */
  PetscReal  correction, largest;
  PetscInt64 outside; /* points that the yield surface moved */
} MpmRest;

/* One step under `scale` times the loads; stress and history stay, and the points go back to where they were. */
PetscErrorCode MpmRestSettle(MpmModel model, MpmRest *rest, PetscReal scale, const char **why, PetscBool *hopeless);
/* Gives all points the stage's stress of k0, and F and history with it (k0.c). */
PetscErrorCode MpmRestSetK0(MpmModel model, MpmRest *rest);
/* The whole of a geostatic stage (geostatic.c); `why` is NULL, or the reason why it was given up. */
PetscErrorCode MpmGeostaticRun(MpmModel model, const char **why);
/* For lists of blocks: with -help, a list that the scene does not give becomes one block called NAME. */
PetscErrorCode MpmModelReadNames(const MpmOptions *options, const char *list, const char *help, MpmNeed need,
                                 PetscInt *count, char ***names);
/*
  Ghost penalty and F-bar (stabilization.c): Read takes the options, Settle makes the choice of `auto` once materials,
  bodies, conditions and stages are known. RaiseGhost: where a run would give up, once, a firmer penalty from here on.
*/
PetscErrorCode MpmStabilizationRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmStabilizationSettle(MpmModel model);
PetscErrorCode MpmStabilizationRaiseGhost(MpmModel model, const char *why);
PetscErrorCode MpmStabilizationText(const MpmModel model, size_t length, char text[]);
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
