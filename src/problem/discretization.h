#pragma once
/*
  The discrete problem of a step, whole.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/point/tables.h"

/* Values of the local nodes, along the axes, `block` a node, and those of the last committed step. */
typedef struct {
  PetscReal *u, *residual, *force;
  PetscReal *reaction;  /* per condition or, behind them, motion, and component of the block */
  PetscBool  committed; /* u, residual and force belong to the last committed step */
} MpmNodalValues;

/* Contexts of the table of terms: data that terms keep from step to step. */
typedef struct {
  MpmContacts     *contacts;
  MpmPairContacts *pairs;    /* of bodies */
  MpmSurfaceFaces *surfaces; /* of bodies */
  MpmInertia      *inertia;
  MpmDamping      *damping;
  MpmBedFlow      *bed; /* of columns; NULL: they are none */
} MpmTermContexts;

/*
  The discrete problem of a step: the points as lent to it, its space, prescribed values, and data of the sums over
  points.
*/
typedef struct MpmDiscretization {
  MPI_Comm        comm;
  PetscInt        dim, block;     /* directions, and unknowns a node */
  PetscReal       h[MPM_MAX_DIM]; /* of a cell as the grid was read, m */
  MpmGrid        *grid;
  MpmLayout      *layout;
  MpmPoints      *points;
  MpmSpace       *space;
  MpmConstraints *constraints;
  MpmSum         *set; /* own; changed by the three functions below alone */
  const MpmSum   *sum; /* data of sums over the points in the present step: `set` */
  MpmTerms       *terms;
  MpmTermContexts context;
  MpmTrial       *trial;
  MpmSections    *sections; /* NULL: none */
  MpmNodalValues  nodal;
  struct {
    MpmPattern *pattern;  /* NULL before the first assembled matrix */
    PetscReal   diagonal; /* of prescribed unknowns: a typical stiffness */
    PetscReal   ghost;    /* factor of the ghost penalty, 0: none */
  } matrix;
  struct {
    PetscInt count; /* of the scene's materials, sum->materials */
    PetscInt parts; /* of the material, with nodes of their own; 1: all bodies share them */
  } material;
} MpmDiscretization;

/*
  Create makes the members, empty; grid and layout are borrowed. Size takes over their contents. SetUp, after it, makes
  data that stay from step to step; materials, boundaries and the places of free ones are borrowed.
*/
PetscErrorCode MpmDiscretizationCreate(MPI_Comm comm, MpmGrid *grid, MpmLayout *layout, MpmDiscretization *disc);
PetscErrorCode MpmDiscretizationSize(MpmDiscretization *disc);
PetscErrorCode MpmDiscretizationSetUp(MpmDiscretization *disc, const MpmMaterials *materials,
                                      const MpmBoundaries *boundaries, const MpmBodies *bodies, const MpmPairs *pairs,
                                      MpmPlacement *placements, PetscInt state_size);
/* Surfaces, their active loads, by surface, and the physics' kernel without means over cells are borrowed. After
   SetUp. */
PetscErrorCode MpmDiscretizationAddSurfaces(MpmDiscretization *disc, const MpmBodySurfaces *surfaces,
                                            MpmLoadActing *acting, const MpmKernelSet *kernel);
/* Terms from outside the tree, which are borrowed. After SetUp. */
PetscErrorCode MpmDiscretizationAddTerms(MpmDiscretization *disc, MpmAddedTerms *added);
/*
  Data of sums over the points: the step's, the deviations of the points at its start, and water at rest, whose arrays
  pass to the problem.
*/
void           MpmDiscretizationSetStep(MpmDiscretization *disc, const MpmSumStep *step);
void           MpmDiscretizationSetAlternate(MpmDiscretization *disc, PetscBool alternate);
PetscErrorCode MpmDiscretizationSetDeviations(MpmDiscretization *disc, PetscReal deviation_n[]);
PetscErrorCode MpmDiscretizationSetWater(MpmDiscretization *disc, const MpmWaterAtRest *still);
PetscErrorCode MpmDiscretizationDestroy(MpmDiscretization *disc);
/* Numbers of local and owned nodes, and of those of all ranks; true for a node of the grid, false for one of a body's
   or of another unknown's own. */
PetscInt  MpmNodesLocal(const MpmDiscretization *disc);
PetscInt  MpmNodesOwned(const MpmDiscretization *disc);
PetscInt  MpmNodesTotal(const MpmDiscretization *disc);
PetscBool MpmNodeInGrid(const MpmDiscretization *disc, PetscInt node);
/* Ghost values from their owners, and sums of ghost values to their owners; `block` values a node. */
PetscErrorCode MpmNodesToGhosts(const MpmDiscretization *disc, PetscInt block, PetscReal local[]);
PetscErrorCode MpmNodesToOwners(const MpmDiscretization *disc, PetscInt block, PetscReal local[]);
/* Where a local node is, m. */
void MpmNodePosition(const MpmDiscretization *disc, PetscInt node, PetscReal x[]);
/* Lattice indices of the nodes that this rank owns, dim each, and their number. */
const PetscInt *MpmOwnedNodes(const MpmDiscretization *disc, PetscInt *count);
/* Stiffness of a node in material of a modulus, Pa: N/m, at the grid's outer edge with axial symmetry. */
PetscReal MpmNodeStiffness(const MpmDiscretization *disc, PetscReal modulus);
