#pragma once
/*
  MpmNearest - of many things in boxes of their own, the one nearest to a place: a tree of boxes, by Embree.

  The tree works in single precision and only rules out things that are certainly further away; what counts are the
  caller's distances. Of things at the same distance the first one is found, so that the answer depends on nothing else.
*/
#include "base/base.h"

typedef struct _p_MpmNearest *MpmNearest;

/* The square of a thing's distance from x. */
typedef PetscReal (*MpmNearestSquare)(const void *ctx, PetscInt thing, const PetscReal x[MPM_MAX_DIM]);

/* True where this build has Embree. */
PetscBool MpmNearestSupported(void);
/* Boxes: lower and upper corner, six numbers each. Not collective. */
PetscErrorCode MpmNearestCreate(PetscInt count, const PetscReal boxes[], MpmNearest *nearest);
PetscErrorCode MpmNearestDestroy(MpmNearest *nearest);
/* -1 where x is not finite. */
PetscInt MpmNearestFind(MpmNearest nearest, MpmNearestSquare square, const void *ctx, const PetscReal x[MPM_MAX_DIM]);
