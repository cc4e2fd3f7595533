#pragma once
/*
  Shared by the files of the object: release.c, release_boxes.c.
*/
#include "maps/polygon_part.h"
#include "release/release.h"
#include "release/release_depth.h"

/* Boxes of points. */
typedef struct {
  PetscReal lower[2], spacing[2]; /* m */
  PetscInt  count[2];
} MpmReleaseLattice;

/* Weights of pixels in the integral of a map over an interval: those of interval k from begin[k] to begin[k + 1]. */
typedef struct {
  PetscInt  *begin, *pixel; /* first pixel of each interval */
  PetscReal *weight;        /* m */
  PetscReal *row;           /* room for those of a row of boxes */
} MpmReleaseWeights;

/* Places of a given number of points: on a lattice, or as parts of equal mass, of the bed's area, or the depth's. */
typedef enum { MPM_SPREAD_EVEN, MPM_SPREAD_MASS, MPM_SPREAD_BED, MPM_SPREAD_DEPTH } MpmReleaseSpread;

struct _p_MpmRelease {
  const MpmGrid    *grid;
  MpmReleaseDepth   depth;
  PetscInt          features;
  MpmRings         *rings; /* [feature], of its polygon */
  MpmReleaseLattice lattice;
  MpmReleaseWeights across;           /* of the boxes' columns */
  PetscInt          rows[2], kept[2]; /* [first, end) of this rank's rows, and of those with their neighbours */
  PetscInt         *box;              /* of kept rows: 0 none, -1 - f within feature f, else 1 + place in cut */
  PetscInt          cuts, room;
  MpmPart          *cut;
  PetscInt64        count, total; /* points of this rank, of all */
  PetscReal         exact, sum;   /* volumes over all ranks, m3 */
  struct {
    PetscBool        on; /* the points of this rank are these, in place of the lattice's */
    PetscInt64       count;
    MpmReleasePoint *point;
  } parts;
  PetscBool overlap; /* features overlap */
};

/* Sorts the boxes of the lattice into none, whole and cut ones, and counts points (release_boxes.c). */
PetscErrorCode MpmReleaseSort(MpmRelease release);
PetscErrorCode MpmReleaseForget(MpmRelease release);
/*
  Puts a number of points in place of the lattice's (release_tree.c); those of a surface are denser by its slope times
  `steep`.
*/
PetscErrorCode MpmReleaseDivide(MpmRelease release, const MpmBed *bed, PetscInt64 number, MpmReleaseSpread spread,
                                PetscReal steep);
/* Counts the points and adds their volumes. Collective. */
PetscErrorCode MpmReleaseSum(MpmRelease release);
/* Least rectangle about all rings. */
void MpmReleaseBounds(MpmRelease release, PetscReal lower[2], PetscReal upper[2]);
/* Integral of a map over a rectangle, m3. */
PetscErrorCode MpmReleaseRectangle(const MpmMap *map, const PetscReal lower[2], const PetscReal upper[2],
                                   PetscReal *volume);
/* Volume of a whole box, m3. */
PetscReal MpmReleaseWhole(MpmRelease release, PetscInt feature, PetscInt i, PetscInt j);
