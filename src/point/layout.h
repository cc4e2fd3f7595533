#pragma once
/*
  The layout of a physics' unknowns and of its kernel's inputs.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/talus.h"

/* A shape that fields share: 0 and 1 in the first one, which is the scene's. */
typedef struct {
  PetscInt degree;  /* of its splines; 0: the scene's shape */
  PetscInt spacing; /* of its nodes, in cells */
} MpmFieldShape;

/* Inputs of component c: input[first[c]] up to, not including, input[first[c + 1]]. */
typedef struct {
  PetscInt first[MPM_MAX_BLOCK + 1], input[MPM_MAX_INPUTS];
} MpmComponentInputs;

/*
  The layout that follows from a physics' fields: block size, their shapes, and which basis function and component each
  kernel input takes.
*/
typedef struct MpmLayout {
  PetscInt           dim, block, inputs, rates;
  MpmKinematics      kinematics;
  PetscInt           field_count, field_of[MPM_MAX_BLOCK]; /* of each component */
  PetscInt           shape_count;
  MpmFieldShape      shape[MPM_MAX_SHAPES];
  PetscInt           shape_of[MPM_MAX_BLOCK];
  MpmComponentInputs by_component;
  PetscInt           component_of[MPM_MAX_INPUTS];
  /* shape * MPM_BASES, + 0 weight, + 1.. derivatives, + dim + 1 deviation, + MPM_HOOP_BASIS weight over radius */
  PetscInt    basis_of[MPM_MAX_INPUTS];
  PetscInt    rate_component[MPM_MAX_BLOCK]; /* the nodal component of each value with a rate */
  PetscInt    deviations;
  PetscInt    deviation_component[MPM_MAX_BLOCK]; /* and of each deviation */
  PetscInt    means; /* 1: the kernel has one input more, the mean over the cell; otherwise 0 */
  PetscBool   increment[MPM_MAX_BLOCK];
  PetscBool   negative[MPM_MAX_BLOCK];                                         /* equations are taken times -1 */
  const char *component_name[MPM_MAX_BLOCK], *component_symbol[MPM_MAX_BLOCK]; /* symbol: NULL where it has none */
  MpmNearNull near_null[MPM_MAX_BLOCK];                                        /* of the field of each component */
  MpmScale    scale[MPM_MAX_BLOCK];
  PetscInt    own_size; /* numbers that the physics keeps of a point */
  PetscInt    taken_up; /* place, among the physics' values, of the density of water taken up; -1: none */
  PetscBool   saddle;   /* the Jacobian is that of a saddle point */
  PetscBool   solid;    /* the displacement's gradient is all that the kernel sees */
  PetscBool   biot;     /* MPM_PHYSICS_BIOT */
  double (*ghost)(const MpmPhysicsMaterial *material, const double *value, double dt,
                  double h); /* as the physics has it */
  const MpmKernelSet *kernel;
} MpmLayout;

PetscErrorCode MpmLayoutCreate(const MpmPhysics *physics, PetscInt kinematics, MpmLayout *layout);
/* True where any of the kernel's inputs needs the weights, not only their derivatives. */
PetscBool MpmLayoutUsesValues(const MpmLayout *layout);
/* True where any of them needs the deviations of a shape. */
PetscBool MpmLayoutUsesDeviation(const MpmLayout *layout, PetscInt shape);
/* The unknown of a node that is the pressure of water, or -1: a field with a rate and a gradient, of the scene's
   shape. */
PetscInt MpmPressureComponent(const MpmLayout *layout);
