#pragma once
/*
  A level on its way to the next coarser one, for level.c and interpolation.c.
*/
#include "levels/level.h"
#include "levels/two_scale.h"

#define NUMBERS (MPM_MAX_DIM + 1)          /* of a node: three indices, and its part */
#define NOWHERE (-1)                       /* in place of the part: a node without a place */
#define HELD    MPM_MAX_BLOCK              /* of a node's bits: from here on those of prescribed components */
#define PRESENT (1 << (2 * MPM_MAX_BLOCK)) /* some fine node names it */

/* A box of lattice nodes of all parts with a number each. */
typedef struct {
  PetscInt  lower[NUMBERS], size[NUMBERS];
  PetscInt *value;
} Map;

/* For each index of an axis of the fine lattice: the coarse nodes and their shares, and the one in its place, or -1. */
typedef struct {
  PetscInt   lower; /* fine index of the first entry */
  PetscInt  *first, *count, *same;
  PetscReal *weight; /* MPM_TWO_SCALE_MOST an entry */
} Axis;

typedef struct {
  const MpmLevelRules *rules;
  const MpmLevel      *fine;
  MpmLevel            *coarse;
  PetscInt             step[MPM_MAX_DIM]; /* cells that become one, by axis */
  Axis                 axis[MPM_MAX_DIM];
  Map                  named, own; /* coarse nodes named by this rank, and its own */
} Coarsening;

static inline PetscInt *MapAt(const Map *map, const PetscInt at[])
{
  PetscInt place = 0;

  for (PetscInt a = MPM_MAX_DIM; a >= 0; a--) place = place * map->size[a] + at[a] - map->lower[a];
  return &map->value[place];
}

static inline PetscBool HasPlace(const MpmLevel *level, PetscInt i)
{
  return (PetscBool)(level->at[i * NUMBERS + MPM_MAX_DIM] != NOWHERE);
}

/* The coarse nodes of fine node i: a box of `count` from `first` on, and their shares along the axes. */
typedef struct {
  PetscInt         first[NUMBERS], count[MPM_MAX_DIM], total;
  const PetscReal *weight[MPM_MAX_DIM];
} Parents;

static inline Parents ParentsOf(const Coarsening *to, PetscInt i)
{
  const PetscInt *at = &to->fine->at[i * NUMBERS];
  Parents         of = {.total = 1};

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const Axis    *axis = &to->axis[a];
    const PetscInt k    = at[a] - axis->lower;

    of.first[a]  = axis->first[k];
    of.count[a]  = axis->count[k];
    of.weight[a] = &axis->weight[k * MPM_TWO_SCALE_MOST];
    of.total *= of.count[a];
  }
  of.first[MPM_MAX_DIM] = at[MPM_MAX_DIM];
  return of;
}

/* The k-th of them; returns its share. */
static inline PetscReal ParentAt(const Parents *of, PetscInt k, PetscInt at[])
{
  PetscReal share = 1.;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const PetscInt j = k % of->count[a];

    at[a] = of->first[a] + j;
    share *= of->weight[a][j];
    k /= of->count[a];
  }
  at[MPM_MAX_DIM] = of->first[MPM_MAX_DIM];
  return share;
}

/* The interpolation, and the rows of local nodes of the finest level (interpolation.c). */
PetscErrorCode MpmMakeInterpolation(const Coarsening *to, const MpmConstraints *constraints, Mat *interpolation);
PetscErrorCode MpmMakeLocalRows(const Coarsening *to, const MpmFinest *finest);
