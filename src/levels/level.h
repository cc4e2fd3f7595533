#pragma once
/*
  Levels of multigrid: nodes of coarser lattices under the active nodes of a step, and the interpolation between them.
*/
#include "base/base.h"
#include "base/types.h"
#include "grid/shape.h"

/* Shapes and coarsening that all levels have. */
typedef struct {
  MPI_Comm       comm;
  const MpmGrid *grid;   /* the finest level's, which says who owns a place */
  PetscInt block, extra; /* unknowns of a node that matrices have, and nodes without a place, which all levels have */
  PetscInt degree;       /* of nodes at vertices */
  MpmEdgeType edge;
  PetscInt    coarsen; /* cells an axis that become one */
} MpmLevelRules;

/* The nodes of a level that this rank owns, last those without a place; of the finest one, its ghosts behind them. */
typedef struct {
  PetscInt order;                      /* nodes a cell, 1: vertices alone */
  PetscInt ratio[MPM_MAX_DIM];         /* cells of the finest level in one, by axis */
  PetscInt last[MPM_MAX_DIM];          /* index of the last node on each axis; 0 on unused axes */
  PetscInt local, owned, begin, count; /* own nodes with ghosts and without, the first one's number, all ranks' nodes */
  PetscInt *at;                        /* indices on the three axes, and the part, by node */
  PetscInt *free, *held;               /* a bit for each component that is solved for, and that is prescribed */
} MpmLevel;

/* Displacements of local nodes of the finest level, along the axes, by coarse nodes: the share of component d there in
   component c here at share[(entry * block + c) * block + d]. */
typedef struct {
  PetscInt   block, entries;
  PetscInt  *begin, *node; /* local + 1; global numbers of coarse nodes */
  PetscReal *share;
} MpmLocalRows;
PetscErrorCode MpmLocalRowsDestroy(MpmLocalRows *rows);

/* The finest level: `rows` are made, unless NULL. */
typedef struct {
  const MpmSpace       *space;
  const MpmConstraints *constraints;
  MpmLocalRows         *rows;
} MpmFinest;

/* Nodes, and what is solved for, of a step's space. */
PetscErrorCode MpmLevelOfSpace(const MpmSpace *space, const MpmConstraints *constraints, const MpmGrid *grid,
                               MpmLevel *level);
/*
  MpmLevelCoarsen - the next coarser level, and the interpolation from it

  Collective

  Input Parameters:
+ rules       - of all levels
. fine        - the level
. finest      - of the finest level, NULL for others
- order       - of the coarse level: where it is lower than the fine one's the cells stay, otherwise they become larger

  Output Parameters:
+ coarse        - nodes of the coarser lattice that any unknown of the fine level depends on
- interpolation - fine unknowns by coarse ones; zero for unknowns that are not solved for on either level

  Notes:
  A coarse unknown is not solved for where the fine one at its place is prescribed, or where no fine unknown that is
  solved for depends on it. The matrix has entries for all components of all nodes: products with it have a diagonal.
*/
PetscErrorCode MpmLevelCoarsen(const MpmLevelRules *rules, const MpmLevel *fine, const MpmFinest *finest,
                               PetscInt order, MpmLevel *coarse, Mat *interpolation);
PetscErrorCode MpmLevelDestroy(MpmLevel *level);
