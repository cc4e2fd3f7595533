#pragma once
/*
  The discrete problem of a step, whole.
*/
#include "bc/bc.h"
#include "terms/rigid.h"

typedef struct MpmPattern MpmPattern;
typedef struct MpmTerms   MpmTerms;

/*
  The discrete problem of a step: the points as they are lent to it, its space, what is prescribed, and what the sums over
  points work with. Arrays of nodal values are those of the local nodes, along the axes.
*/
typedef struct MpmDiscretization {
  MpmGrid        grid;
  MpmLayout      layout;
  PetscInt       material_count; /* of the scene's, sum.materials */
  MpmPoints      points;
  MpmSpace       space;
  MpmConstraints constraints;
  MpmPattern    *pattern; /* NULL before the first assembled matrix */
  MpmSum         sum;
  MpmContacts    contacts;
  MpmTerms      *terms;
  MpmTrial       trial;
  PetscReal     *u, *residual, *force;
  PetscReal     *reaction;  /* per condition and component of the block */
  PetscBool      committed; /* do these three tell of the last step that has become the state? */
  PetscReal      diagonal;  /* of prescribed unknowns: a typical stiffness */
  PetscReal      ghost;     /* factor of the ghost penalty, 0: none */
} MpmDiscretization;

/*
  SetUp, once grid and layout are there, makes what stays from step to step; materials and boundaries are borrowed. Destroy leaves the grid alone.
*/
PetscErrorCode MpmDiscretizationSetUp(MpmDiscretization *disc, const MpmMaterials *materials,
                                      const MpmBoundaries *boundaries, PetscInt state_size);
PetscErrorCode MpmDiscretizationDestroy(MpmDiscretization *disc);
/* Frees the arrays. */
PetscErrorCode MpmTrialReset(MpmTrial *trial);
