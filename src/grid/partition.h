#pragma once
/*
  The grid's partition over the ranks.
*/
#include "base/base.h"
#include "base/types.h"

/*
  A plane between vertices of cells: those with a smaller index on the axis are below it. Of the layer of vertices right
  above it, those below `row` on another axis are below the split, too.
*/
typedef struct MpmSplit {
  PetscInt axis, node;
  PetscInt row_axis, row;
} MpmSplit;

/*
  A new partition of the lattice for these points (dim coordinates each). The splits are accepted when they are the
  first ones, or when the fullest rank would have at most `worth` points.
*/
PetscErrorCode MpmGridPartition(MpmGrid *grid, PetscInt count, const PetscReal x[], PetscReal worth, PetscBool *taken);
/* The splits as numbers (free them), and back where they are for as many ranks as there are. */
PetscErrorCode MpmGridGetPartition(const MpmGrid *grid, PetscInt *count, PetscInt **numbers);
PetscErrorCode MpmGridSetPartition(MpmGrid *grid, PetscInt count, const PetscInt numbers[], PetscBool *set);
