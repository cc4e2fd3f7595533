#pragma once
/*
  Weights with which loads act on the nodes that a point touches (load_weights.c).
*/
#include "loads/load.h"
#include "space/point_slopes.h"

/* A point, and the nodes that it touches. */
typedef struct {
  const MpmRules  *rules;
  const MpmSpace  *space;
  const MpmPoints *points;
  const MpmGroup  *group;
  PetscInt         point;
} MpmTouched;

/* Weights of the centre of the face under a traction. */
PetscErrorCode MpmLoadFaceWeights(const MpmLoad *load, const MpmTouched *at, PetscReal weight[]);
/* Weights of gravity, the mean of both ends of the point's domain; and whether it acts so. */
PetscErrorCode MpmLoadEndWeights(const MpmLoad *load, const MpmTouched *at, PetscReal weight[]);
PetscBool      MpmLoadActsAtEnds(const MpmLoad *load, const MpmRules *rules);
/*
  Derivatives of the weights of either kind by the point's place along an axis, 1/m, or by the half-length of its domain
  there, 1/cell; on the axis of a traction by that half-length before it is clipped.
*/
PetscErrorCode MpmLoadWeightSlopes(const MpmLoad *load, const MpmPointSlopes *slopes, const MpmTouched *at,
                                   MpmSlopeKind kind, PetscInt along, PetscReal weight[]);
