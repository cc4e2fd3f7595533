#pragma once
/*
  The background grid.
*/
#include "base/base.h"
#include "base/types.h"
#include "talus/point/dense.h"

#define MPM_GRID_SLACK 1e-9 /* of a cell: by so much a point may be outside of the grid, from rounding */

/*
  The background grid: a regular lattice of cells, never stored. Nested splits, which follow the points, distribute its
  nodes to the ranks. The lattice may be placed anew between steps; conditions on nodes and walls go with it.
*/
typedef struct MpmGrid {
  MPI_Comm    comm;
  PetscMPIInt rank, size;
  PetscInt    dim;
  PetscBool   axial; /* x is the radius, y the axis */
  PetscReal   lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], h[MPM_MAX_DIM];
  PetscInt    cells[MPM_MAX_DIM]; /* 1 on unused axes */
  PetscInt    order;              /* nodes a cell, 1 to 4; 1: vertices alone */
  PetscInt    nodes[MPM_MAX_DIM]; /* 1 on unused axes */
  PetscReal   start_lower[MPM_MAX_DIM], start_upper[MPM_MAX_DIM], start_h[MPM_MAX_DIM]; /* as they were read */
  PetscBool   outflow; /* in explicit steps points may leave it, and are gone */
  PetscBool   moved;   /* other than those */
  PetscReal   balance; /* when to look for other splits: points on the fullest rank over their mean */
  MpmSplit   *splits;  /* size - 1 of them; NULL before the first partition */
} MpmGrid;

/* Components of a deformation gradient (MpmKinematicsF()). */
static inline PetscInt MpmGridF(const MpmGrid *grid)
{
  return grid->axial ? 5 : grid->dim * grid->dim;
}
/* How much of space a unit of the plane at radius r stands for: the circumference, m; 1 without axial symmetry. */
static inline PetscReal MpmGridTurn(const MpmGrid *grid, PetscReal r)
{
  return MpmTurn(MpmGridF(grid), r);
}
PetscErrorCode MpmGridSetFromOptions(MpmGrid *grid, const MpmOptions *options, PetscInt dim);
PetscErrorCode MpmGridDestroy(MpmGrid *grid);
/* Puts the lattice elsewhere: the same cells, of other size; `lower` below `upper` on each axis. */
void MpmGridPlace(MpmGrid *grid, const PetscReal lower[], const PetscReal upper[]);
/* Where a place that moves with the grid was as the grid was read; and where a node was. */
void MpmGridAtStart(const MpmGrid *grid, const PetscReal x[], PetscReal start[]);
void MpmGridNodeAtStart(const MpmGrid *grid, const PetscInt node[], PetscReal start[]);
/*
  MpmGridSetOrder - places nodes within cells, at the Gauss-Lobatto points of an order

  Node i of an axis lies in cell i / order, and at a vertex where order divides i. Source of the points: Abramowitz and
  Stegun (1964), 25.4.32.
*/
void MpmGridSetOrder(MpmGrid *grid, PetscInt order);
/* Places of the nodes of a cell from its lower vertex, cells: order + 1 of them. */
const PetscReal *MpmCellNodes(PetscInt order);
/* Where a node stands along an axis, cells from the grid's lower corner. */
static inline PetscReal MpmGridNodeXi(const MpmGrid *grid, PetscInt node)
{
  if (grid->order <= 1) return (PetscReal)node;
  return (PetscReal)(node / grid->order) + MpmCellNodes(grid->order)[node % grid->order];
}
/* Distance of a node from the one `count` before it along an axis, cells. */
static inline PetscReal MpmGridNodeStep(const MpmGrid *grid, PetscInt from, PetscInt count)
{
  return grid->order <= 1 ? (PetscReal)count : MpmGridNodeXi(grid, from + count) - MpmGridNodeXi(grid, from);
}
/* Where a node stands along axis a, m. */
static inline PetscReal MpmGridNodeAt(const MpmGrid *grid, PetscInt a, PetscInt node)
{
  return grid->lower[a] + grid->h[a] * MpmGridNodeXi(grid, node);
}
/* The rank that owns a node, given its index on each axis, and that of a cell; any of them has an owner. */
PetscMPIInt MpmGridNodeOwner(const MpmGrid *grid, const PetscInt node[]);
PetscMPIInt MpmGridCellOwner(const MpmGrid *grid, const PetscInt cell[]);
/*
  The ranks that own vertices of a box of cells, both corners included, ascending, and few others beside steps in the
  splits; returns their number. Room for grid->size.
*/
PetscInt MpmGridBoxOwners(const MpmGrid *grid, const PetscInt lower[], const PetscInt upper[], PetscMPIInt owner[]);
/* The cell that holds a place (a point on a face belongs to the upper cell, except at the grid's upper edge). */
void MpmGridFindCell(const MpmGrid *grid, const PetscReal x[], PetscInt cell[]);
/* The part of a cell, one of order^dim equal ones, that holds a place; counted over all cells on each axis. */
void MpmGridFindPart(const MpmGrid *grid, const PetscReal x[], PetscInt part[]);
/*
  Appends copies of other ranks' records to the own ones. boxes[k] has the lower and the upper vertex, three indices
  each, of the box about record k, which goes to all ranks that own vertices of it. Records are of `size` bytes, whole
  integers, and are reallocated. Collective.
*/
PetscErrorCode MpmGridShare(const MpmGrid *grid, size_t size, const PetscInt boxes[], PetscInt *count, void **records);
