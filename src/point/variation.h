#pragma once
/*
  Parameters of a material that vary from place to place: by height up gravity's axis, or by a field over the axes, at
  places of the initial state.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* Where a point began: `height` up gravity's axis, m. */
struct MpmPlace {
  PetscReal        height;
  const PetscReal *x;
  PetscInt         id;
};

/* One parameter. Start from zeros: it does not vary. */
typedef struct {
  PetscInt   place, places;      /* first of its numbers in a point's row, and their count */
  PetscInt   dim;                /* axes of the field; 0: by height */
  PetscInt   count;              /* rows; 0: a number */
  PetscInt   nodes[MPM_MAX_DIM]; /* of a field on a lattice, by axis; 0: scattered places */
  PetscReal *line[MPM_MAX_DIM];  /* coordinates of the lattice's nodes by axis, ascending, m */
  PetscReal *at;                 /* heights, or places by ascending x, m */
  PetscReal *value;              /* by row; of a lattice x fastest */
  MpmGround *ground;             /* field of the scene's that has the values, borrowed; or NULL */
} MpmVariation;

/* All parameters of one material that vary, and the source of a point's row. */
typedef struct MpmVariations {
  PetscInt          count;
  MpmVariation     *at;
  PetscInt          stride;        /* numbers from point to point */
  PetscReal         factor;        /* in force that divides strengths */
  double           *physics_given; /* values of the physics before its `prepare` */
  const MpmPhysics *physics;
  PetscReal         gravity; /* m/s2 */
  PetscInt          dim;
} MpmVariations;

/*
  Reads height:value pairs, or a file with columns height, value or x, y (, z), value, where the option is one of these;
  a number is left to other readers. A field of the scene, or NULL, replaces the option. Collective.
*/
PetscErrorCode MpmVariationRead(const MpmOptions *block, MpmGround *ground, const MpmParameter *parameter, PetscInt dim,
                                MpmVariation *variation);
PetscErrorCode MpmVariationCopy(const MpmVariation *from, MpmVariation *to);
PetscErrorCode MpmVariationDestroy(MpmVariation *variation);
/* Least and largest value. */
void MpmVariationBounds(const MpmVariation *variation, PetscReal *least, PetscReal *most);
/* The value at a place: linear between heights or nodes of a lattice, that of the nearest scattered place, constant
   beyond. */
PetscReal MpmVariationEvaluate(const MpmVariation *variation, const MpmPlace *place);
