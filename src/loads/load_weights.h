#pragma once
/*
  Weights with which loads act on the nodes that a point touches (load_weights.c).
*/
#include "loads/load.h"

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
