#pragma once
/*
  Data of the sums over points, and transfers between points and nodes outside of the residual (point_to_node.c,
  node_to_point.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "base/version.h"
#include "space/mode.h"
#include "talus/point/tables.h"

/* Candidate of the points' state at the step's end: F, Cauchy stress and history. */
typedef struct MpmTrial {
  PetscReal *F, *stress, *state, *own;
  PetscReal *u;  /* displacement of the local nodes that explicit steps take it at */
  MpmVersion of; /* unknowns that it belongs to, with the residual of the problem */
} MpmTrial;

/* Water at rest below its level (step/water_state.c), allocated by PetscMalloc3(); NULL without one. */
struct MpmWaterAtRest {
  PetscReal *pressure; /* at the local nodes, Pa */
  PetscBool *bent;     /* nodes where the pressure is not hydrostatic */
  PetscReal *gravity;  /* driving the water of each point, m/s2 */
};

/* Numbers kept of a point's history: the law's, and the physics' own. */
typedef struct {
  PetscInt state, own;
} MpmKeptSizes;

/* A step as sums over its points take it. */
typedef struct MpmSumStep {
  PetscReal dt;   /* in which something flows, s: the step's length, with two stages a part of it */
  PetscReal span; /* from the step's start to the time that is solved for, s */
  PetscReal part; /* of the points' forces in the balance: 1, or less where some of it is the step's start's */
  PetscReal gravity[MPM_MAX_DIM]; /* at the step's end, m/s2 */
  PetscBool drained;              /* the pressure of the water is that of a steady flow */
  PetscBool alternate;            /* tangents have MPM_POINT_ALTERNATE */
  const MpmKernelStage *first;    /* of each point, in the second of two stages (sdirk.c); or NULL */
} MpmSumStep;

/*
  All that the loops over points need; arrays are borrowed. A problem has one for the present step, which its own
  functions set (problem/discretization.h); a sum of another kind takes a copy.
*/
typedef struct MpmSum {
  const MpmGrid     *grid;
  const PetscReal   *cell; /* the grid's, m */
  const MpmSpace    *space;
  const MpmLayout   *layout;
  const MpmMaterial *materials;
  const MpmPoints   *points;
  PetscInt           block; /* values a node has */
  MpmKeptSizes       kept;
  MpmSumStep         step;
  MpmWaterAtRest     still;
  PetscReal         *deviation_n; /* of the points, at the step's start (at_points.c); NULL: no field has one */
  MpmMode            mode;
} MpmSum;

/*
  Values of the points at the owned nodes, by the weights of one of the space's shapes, and with their gradients by x
  where `gradient` is not NULL (point_to_node.c). Point p has `components` values from value[p*stride] and components *
  dim derivatives from gradient[p*gradient_stride].
*/
typedef struct {
  PetscInt         shape, components, stride;
  const PetscReal *value, *gradient;
  PetscInt         gradient_stride;
} MpmPointValues;
PetscErrorCode MpmProjectToNodes(const MpmSum *sum, const MpmPointValues *values, PetscReal nodal[]);

/*
  The deviations at the points of all fields that have one, from values at the local nodes, `layout->block` a node; and
  the values of those with a rate.
*/
PetscErrorCode MpmDeviationsAtPoints(const MpmSum *sum, const PetscReal u[], PetscReal deviation[]);
PetscErrorCode MpmRatesAtPoints(const MpmSum *sum, const PetscReal u[], PetscReal value[]);
/* One number a local node with the first shape at the points, and its gradient by x; `value` may be NULL. */
PetscErrorCode MpmScalarAtPoints(const MpmSum *sum, const PetscReal nodal[], PetscReal value[], PetscReal gradient[]);
/* The points' displacements, `dim` a point. */
PetscErrorCode MpmDisplacementsAtPoints(const MpmSum *sum, const PetscReal u[], PetscReal displacement[]);
/*
  The first of this rank's points that the displacement u of local nodes would carry out of a grid, -1: none; and its
  destination. `next` is sum->grid itself, or the next grid where it moves.
*/
PetscErrorCode MpmFindOutside(const MpmSum *sum, const MpmGrid *next, const PetscReal u[], PetscInt *point,
                              PetscReal x[]);

/* The trial becomes the state: history, F, stress, and positions and rate values that go with u. */
PetscErrorCode MpmCommitLocal(const MpmSum *sum, const MpmTrial *trial, const PetscReal u[]);
/* The commit where the points' own velocities are known, and no field has a rate. */
PetscErrorCode MpmCommitMoves(const MpmSum *sum, const MpmTrial *trial, PetscReal dt, const PetscReal moves[]);
