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

/* One unknown of a node, with the data of its field. */
typedef struct {
  PetscInt    field, shape;
  PetscBool   increment;
  PetscBool   negative;      /* equations are taken times -1 */
  const char *name, *symbol; /* symbol: NULL where it has none */
  MpmNearNull near_null;     /* of the field */
  MpmScale    scale;
} MpmComponent;

/* Basis function and component of each kernel input. */
typedef struct {
  PetscInt           count;
  MpmComponentInputs by_component;
  PetscInt           component[MPM_MAX_INPUTS];
  /* shape * MPM_BASES, + 0 weight, + 1.. derivatives, + dim + 1 deviation, + MPM_HOOP_BASIS weight over radius */
  PetscInt basis[MPM_MAX_INPUTS];
} MpmLayoutInputs;

/* Components that points keep a number of: values with a rate, or deviations. */
typedef struct {
  PetscInt count, component[MPM_MAX_BLOCK];
} MpmKeptComponents;

/* The layout that follows from a physics' fields: unknowns of a node, their shapes, and inputs of the kernel. */
typedef struct MpmLayout {
  MpmKinematics     kinematics;
  PetscInt          dim, block;
  PetscInt          motion; /* components of the displacement, the first ones: dim; 0: the points stay in place */
  MpmComponent      component[MPM_MAX_BLOCK];
  PetscInt          field_count, shape_count;
  MpmFieldShape     shape[MPM_MAX_SHAPES];
  MpmLayoutInputs   input;
  MpmKeptComponents rate, deviation;
  PetscInt          means; /* 1: the kernel has one input more, the mean over the cell; otherwise 0 */
  struct {
    PetscInt size;     /* numbers that the physics keeps of a point */
    PetscInt taken_up; /* place, among the physics' values, of the density of water taken up; -1: none */
  } own;
  struct {
    PetscBool saddle;    /* the Jacobian is that of a saddle point */
    PetscBool solid;     /* the displacement's gradient is all that the kernel sees */
    PetscBool biot;      /* MPM_PHYSICS_BIOT */
    PetscBool alternate; /* MPM_PHYSICS_ALTERNATE */
  } traits;
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
   shape, that is measured in a stress. */
PetscInt MpmPressureComponent(const MpmLayout *layout);
