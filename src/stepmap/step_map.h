#pragma once
/*
  The derivatives of a step's map.

  With decisions frozen (cells, nodes that follow others, branches of laws) a step is r(u; s, p) = 0 and s' = c(u; s,
  p): s the points' state at its start, p parameters, u the displacement of the local nodes. Two operations give its
  derivatives,

    along   dr = dr/du du + dr/ds ds + dr/dp dp ,  ds' likewise
    pull    derivatives of  L = s'bar . c - lam . r  by u, s and p ,

  each a sum over the step's parts: the points, loads. Bars and lam are given, the parameters of a pull are counted.
*/
#include "loads/body_surface.h"
#include "loads/load.h"
#include "query/point_vector.h"
#include "query/scene_parameter.h"
#include "stepmap/ground_parameters.h"

/* Parts of the scene's states that no step changes: displacements begin anew, initial shapes differ. */
typedef struct {
  PetscBool resets, shapes;
} MpmStepConstants;

typedef struct MpmPointTable MpmPointTable;

/*
  Numbers by point beside the state, as directions or derivatives: deviations at the step's start; F, values and
  deviations of the first of two stages. NULL: none.
*/
typedef struct {
  PetscReal *deviation_n, *F, *value, *deviation;
} MpmStageNumbers;

/* A step at its solution, borrowed. */
typedef struct {
  const MpmRules           *rules;
  const MpmSum             *sum;
  const MpmPhysics         *physics;
  MpmParticles             *particles;
  const MpmSceneParameters *parameters;
  const MpmFieldParameters *grounds;
  const PetscReal          *u; /* at the local nodes */
  MpmStepConstants          constants;
  PetscInt                  load_count;
  const MpmLoad            *loads;
  const PetscReal          *factors;  /* of the loads in the step */
  const MpmSurfaceFaces    *surfaces; /* in the step */
  MpmPointTable            *table;    /* of a pull; NULL: of none */
  const MpmStageNumbers    *stage;    /* of a pull, added to; or NULL */
} MpmStepMap;

/* A direction: of the state, of one parameter (-1: none), of the solution (NULL: none). */
typedef struct {
  const MpmPointVector     *start;
  PetscInt                  parameter;
  const PetscReal          *du;
  const MpmGroundDirection *ground; /* of a field; NULL: none */
  const MpmStageNumbers    *stage;  /* NULL: none */
} MpmStepDirection;

/* Up to MPM_PACK directions, dr of each at the local nodes, and ds' of each; NULL: not wanted. */
typedef struct {
  PetscInt                count;
  const MpmStepDirection *of;
  PetscReal *const       *residual;
  MpmPointVector         *end;
} MpmStepDirections;

/* A vector over the states of points, and of the step's points. */
PetscErrorCode MpmStateVectorCreate(const MpmSum *sum, const MpmPoints *points, MpmStepConstants constants,
                                    MpmPointVector *vector);
PetscErrorCode MpmStepVectorCreate(const MpmStepMap *map, MpmPointVector *vector);
/* A vector over the end of the first of two stages; bars of it, if given: of the second stage's numbers. */
PetscErrorCode MpmStageVectorCreate(const MpmStepMap *map, const MpmStageNumbers *bars, MpmPointVector *vector);

/* Adds dr at the local nodes, a rank's part, and sets ds', where they are wanted. */
PetscErrorCode MpmPointsAlong(const MpmStepMap *map, const MpmStepDirections *directions);

/* Derivatives of the points, which PullSolution finds and PullStart uses (point_table.h). Create: that of another step
   or NULL in `table`, whose room goes on. */
PetscErrorCode MpmPointTableCreate(const MpmStepMap *map, MpmPointTable **table);
PetscErrorCode MpmPointTableDestroy(MpmPointTable **table);

/*
  PullSolution adds dL/du at the local nodes, a rank's part. PullStart adds dL/ds to `start` and dL/dp to gradient[p],
  this rank's part. `end` has the bars, and lam is given at the local nodes.
*/
PetscErrorCode MpmPointsPullSolution(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                     PetscReal u[]);
PetscErrorCode MpmPointsPullStart(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                  MpmPointVector *start, PetscReal gradient[]);

/* Loads (load_map.c), likewise. */
PetscErrorCode MpmLoadsAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[]);
PetscErrorCode MpmLoadsPullStart(const MpmStepMap *map, const PetscReal lam[], MpmPointVector *start,
                                 PetscReal gradient[]);

/* The penalty on jumps across faces (ghost_map.c), likewise; its derivatives by the points' state are 0. */
PetscErrorCode MpmGhostAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[]);
PetscErrorCode MpmGhostPullSolution(const MpmStepMap *map, const PetscReal lam[], PetscReal u[]);
PetscErrorCode MpmGhostPullStart(const MpmStepMap *map, const PetscReal lam[], PetscReal gradient[]);

/* Zeros for what a step has beside the state; nothing without a rate. */
PetscErrorCode MpmStageNumbersCreate(const MpmStepMap *map, MpmStageNumbers *stage);
PetscErrorCode MpmStageNumbersDestroy(MpmStageNumbers *stage);
