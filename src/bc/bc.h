#pragma once
/*
  Prescribed unknowns: conditions, the constraints that follow from them, and the frames of nodes with a normal.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* ---- dirichlet.c, node_frames.c ---- */

/* Meaning of a condition's value: a displacement, or its first or second derivative by time. */
typedef enum { MPM_DISPLACEMENT, MPM_VELOCITY, MPM_ACCELERATION } MpmQuantity;

/* Values of a condition by place, and their context. */
typedef struct {
  MpmConditionValue function; /* NULL: equal at all nodes */
  void             *ctx;
} MpmValueField;

/* A Dirichlet condition on nodes: on components of their unknowns, or on the displacement along a normal. */
typedef struct {
  char         *name;
  MpmRegion     region;
  PetscBool     inclined;            /* a normal exists: value[0] is along it, components are those of the reaction */
  PetscReal     normal[MPM_MAX_DIM]; /* of length 1 */
  PetscInt      component_count;
  PetscInt      component[MPM_MAX_BLOCK];
  PetscReal     value[MPM_MAX_BLOCK];
  MpmRamp       ramp;
  MpmQuantity   quantity;
  PetscBool     absorbing; /* dashpots at its nodes in place of prescribed values; value is an incoming wave */
  PetscInt      across;    /* the axis across the plane of such a one */
  PetscInt      motion;    /* of its components those below are of the displacement */
  MpmValueField field;     /* of components beyond */
} MpmCondition;

/* Conditions, with the names of their blocks. */
typedef struct MpmConditions {
  PetscInt      count;
  char        **names;
  MpmCondition *at;
} MpmConditions;

/* Activity of a condition in the stage, start of its ramp, and the material that it moves (lost_material.c). */
struct MpmActing {
  PetscBool active;
  PetscReal start;
  PetscInt  first, end;         /* ids of the body with most volume at its nodes as it began to move in the stage */
  PetscReal volume;             /* and how much of it, m3; 0: it has not begun to */
  PetscReal force[MPM_MAX_DIM]; /* the last step's reaction, N, in scenes that keep account of energy */
};

/* Rows of the state (base/rows.h) of conditions that move material. */
PetscErrorCode MpmConditionsAddRows(const MpmConditions *conditions, MpmActing acting[], MpmRows *rows);

/* Conditions and motions as a step from time_n to `time` takes them; `acting` by condition, then by motion. */
typedef struct {
  const MpmConditions  *conditions;
  const MpmBodyMotions *motions;
  const MpmActing      *acting;
  MpmParticles         *particles;
  PetscReal             time_n, time;
  PetscInt              rate;     /* 0: the step's increment; 1, 2: velocities and accelerations at its end instead */
  PetscReal             diagonal; /* a typical stiffness of a node, N/m */
} MpmPrescription;

/*
  The frame of a node with a condition along a normal; rows q_r, of which the first `constrained` are (node_frames.c).
*/
typedef struct {
  PetscInt  constrained, condition[MPM_MAX_DIM]; /* condition: whose equation it is */
  PetscReal value[MPM_MAX_DIM];
  PetscReal axis[MPM_MAX_DIM][MPM_MAX_DIM];   /* q_r */
  PetscReal factor[MPM_MAX_DIM][MPM_MAX_DIM]; /* L_kr */
} MpmFrame;

#define MPM_FREE        (-1) /* an unknown that is solved for */
#define MPM_UNSUPPORTED (-2) /* one of a field whose shape no point touches the node with: zero */
#define MPM_HELD        (-3) /* constrained without a condition: by the water's state, or on the axis of symmetry */

#define MPM_FOLLOWS (-4) /* one that follows others: the space's extension */

/*
  The conditions as they act on the local unknowns of a step. At a node with a frame the unknowns of the displacement
  are its components in the frame.
*/
typedef struct MpmConstraints {
  PetscInt  *condition; /* per local unknown: which condition or, behind them, motion holds it, or one of these two */
  PetscReal *value;     /* the value that it takes, in its unit */
  PetscBool  any;
  PetscInt   dim, block;
  PetscReal  diagonal;            /* of the equations of prescribed unknowns, N/m */
  PetscReal  unit[MPM_MAX_BLOCK]; /* of the solver's unknowns, by component: a power of 2 */
  PetscBool  scaled;              /* some units are not 1 */
  PetscInt  *frame_of;            /* per local node: its frame, or -1; NULL where no condition has a normal */
  MpmFrame  *frames;
} MpmConstraints;

PetscErrorCode MpmConditionCreate(const MpmOptions *options, const char *name, const MpmGrid *grid,
                                  const MpmLayout *layout, MpmCondition *bc);
/* Whether a condition keeps its nodes from moving along an axis. */
PetscBool      MpmConditionFixes(const MpmCondition *bc, PetscInt axis);
PetscErrorCode MpmConditionDestroy(MpmCondition *bc);
/* The walls that a condition makes, `spline` for splines; walls has room for 2*dim. */
PetscErrorCode MpmConditionGetWalls(const MpmCondition *bc, const MpmGrid *grid, PetscBool spline, PetscInt *count,
                                    MpmWall *walls);
/* `contradicts` is a motion that another one, or a condition, contradicts at a node, or -1; the same on all ranks. */
PetscErrorCode MpmConstraintsSetUp(MpmConstraints *constraints, const MpmPrescription *step, const MpmGrid *grid,
                                   const MpmLayout *layout, const MpmSpace *space, PetscInt *contradicts);
/*
  Increment of the ramp of condition or motion b in the step, or its factor at the step's end for unknowns that are
  totals.
*/
PetscReal MpmStepFactor(const MpmPrescription *step, PetscInt b, PetscBool increment);
/* True where condition b acts at a node, which is given by its place in the grid as it was read. */
PetscBool MpmConditionHolds(const MpmPrescription *step, PetscInt b, const PetscReal x[]);
/* True where the condition prescribes a displacement other than zero at any time, along one of `dim` axes. */
PetscBool MpmConditionMoves(const MpmCondition *bc, PetscInt dim);
/*
  Checks that each condition that moves the material in the step still has the body that it began to move, and notes
  that body in `acting`. `lost` is the first without, or -1, and `left` the remaining fraction of the volume then; 0
  where no such condition acts on any node. Equal on all ranks.
*/
PetscErrorCode MpmConditionsFindLost(const MpmPrescription *step, MpmActing *acting, const MpmBodies *bodies,
                                     const MpmSum *sum, PetscInt *lost, PetscReal *left);
PetscErrorCode MpmConstraintsReset(MpmConstraints *constraints);
/* True where the local unknown is solved for. */
static inline PetscBool MpmConstraintsFree(const MpmConstraints *constraints, PetscInt unknown)
{
  return (PetscBool)(constraints->condition[unknown] == MPM_FREE);
}
/* True where its row and column are summed: it is solved for, or follows such ones. */
static inline PetscBool MpmConstraintsCounts(const MpmConstraints *constraints, PetscInt unknown)
{
  return (PetscBool)(constraints->condition[unknown] == MPM_FREE || constraints->condition[unknown] == MPM_FOLLOWS);
}
/*
  Unknowns of small-cut nodes that nothing prescribes follow those of the space's extension, components with the
  scene's shape; nodes with a frame keep theirs. Extend: values of local nodes, along the axes, from those of the
  others. Gather: their forces, a rank's part, to the others.
*/
void MpmConstraintsFollow(MpmConstraints *constraints, const MpmLayout *layout, const MpmSpace *space);
void MpmConstraintsExtend(const MpmConstraints *constraints, const MpmSpace *space, PetscReal values[]);
void MpmConstraintsGather(const MpmConstraints *constraints, const MpmSpace *space, PetscReal forces[]);
/* Prescribes an unknown that was free. */
void MpmConstraintsHold(MpmConstraints *constraints, PetscInt unknown, PetscReal value);
/* Of the first `count` local unknowns: constrained ones take their prescribed values, */
void MpmConstraintsPrescribe(const MpmConstraints *constraints, PetscInt count, PetscScalar x[]);
/* zero, */
void MpmConstraintsZero(const MpmConstraints *constraints, PetscInt count, PetscScalar x[]);
/* the diagonal times their entries of `x`: their rows of the Jacobian; */
void MpmConstraintsMultiply(const MpmConstraints *constraints, PetscInt count, const PetscScalar x[], PetscScalar y[]);
/* or the diagonal times the distance of `x` from the prescribed values: their rows of the residual. */
void MpmConstraintsResidual(const MpmConstraints *constraints, PetscInt count, const PetscScalar x[],
                            PetscScalar residual[]);
/*
  Rows and columns of unknowns that are not free in the first diagonal blocks of `nodes` nodes become the diagonal's.
*/
void MpmConstraintsBlocks(const MpmConstraints *constraints, PetscInt nodes, PetscReal blocks[]);
/*
  Adds the forces of the supports on the body, those that the owned nodes' residual lacks in balance; reaction[b*block
  + c] for condition b and component c.
*/
void MpmConstraintsAddReactions(const MpmConstraints *constraints, PetscInt block, PetscInt owned,
                                const PetscReal residual[], PetscReal reaction[]);

/*
  The solver works with unknowns in units that make all equations forces: a pressure in K/h, K a typical stiffness and
  h a cell, so that the unknown is a length and its volume balance, times K/h, a force. Times: values of the first
  `count` local unknowns from these units to the physics', or of their equations the other way; Over: the reverse. The
  second kind is for blocks c, d of the Jacobian: nothing is done where all units are 1.
*/
void MpmUnitsTimes(const MpmConstraints *constraints, PetscInt count, PetscReal values[]);
void MpmUnitsOver(const MpmConstraints *constraints, PetscInt count, PetscReal values[]);
/* `width` blocks side by side of one node's rows: row c has bs * width numbers. */
void MpmUnitsTimesRows(const MpmConstraints *constraints, PetscInt width, PetscReal rows[]);

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
  Turns the values (`bs` a node) of the first `nodes` local nodes from components along the axes into those that the
  solver works with, and back; element blocks [i][c][d][j] and the diagonal blocks of nodes likewise. Where no node
  has a frame nothing is done.
*/
void MpmFramesToUnknowns(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscReal values[]);
void MpmFramesToAxes(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscReal values[]);
/* Values [i][c] of the nodes of a box. */
void MpmFramesRotateVector(const MpmConstraints *constraints, PetscInt bs, PetscInt n, const PetscInt nodes[],
                           PetscReal values[]);
void MpmFramesRotateElement(const MpmConstraints *constraints, PetscInt bs, PetscInt n, const PetscInt nodes[],
                            PetscReal element[]);
void MpmFramesRotateBlocks(const MpmConstraints *constraints, PetscInt bs, PetscInt nodes, PetscReal blocks[]);
