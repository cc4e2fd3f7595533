/*
  The rectangle of a grid, and its cells.
*/
#include "options/options.h"
#include "grid/extent.h"
#include "maps/bed.h"

/* The map's rectangle for the corners that are not given. */
static PetscErrorCode TakeTerrain(const MpmOptions *options, const PetscBool given[2], MpmGrid *grid)
{
  PetscReal lower[2], upper[2];

  PetscFunctionBeginUser;
  MpmCheckInput(grid->dim < 3, "-mpm_grid_terrain: -mpm_dim must be 2");
  PetscCall(MpmBedExtent(options, lower, upper));
  for (PetscInt a = 0; a < 2; a++) {
    if (!given[0]) grid->lower[a] = lower[a];
    if (!given[1]) grid->upper[a] = upper[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whole cells of a length from the lower corner on; without the map's rectangle the upper corner must be one's end. */
static PetscErrorCode FindCells(PetscReal cell, PetscBool whole, MpmGrid *grid)
{
  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal count = (grid->upper[a] - grid->lower[a]) / cell, near = PetscFloorReal(count + 0.5);
    const PetscBool good = (PetscBool)(PetscAbsReal(count - near) <= MPM_TOLERANCE * PetscMax(near, 1.));

    MpmCheckInput(count >= 1. - MPM_TOLERANCE && count < 1e9 && (good || !whole),
                  "-mpm_grid_cell %g: %.10g to %.10g on axis %c must be a whole number of cells, 1 at least",
                  (double)cell, (double)grid->lower[a], (double)grid->upper[a], "xyz"[a]);
    grid->cells[a] = (PetscInt)(good ? near : PetscFloorReal(count));
    if (!good) grid->upper[a] = grid->lower[a] + cell * (PetscReal)grid->cells[a];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGridReadExtent(const MpmOptions *block, const MpmOptions *options, MpmGrid *grid)
{
  PetscBool terrain = PETSC_FALSE, given[2], by_length, counted;
  PetscReal cell    = 0.;
  MpmNeed   need;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBool(block, "terrain", "the grid covers the map of the terrain, but for corners that are given",
                           &terrain, NULL));
  need = terrain ? MPM_OPTIONAL : MPM_REQUIRED;
  PetscCall(
    MpmOptionsReals(block, "lower", "m", "lower corner", MPM_RANGE_ANY, need, grid->dim, grid->lower, &given[0]));
  PetscCall(
    MpmOptionsReals(block, "upper", "m", "upper corner", MPM_RANGE_ANY, need, grid->dim, grid->upper, &given[1]));
  PetscCall(MpmOptionsHas(&(MpmOptions){block->comm, block->prefix, NULL}, "cell", &by_length));
  PetscCall(MpmOptionsInts(block, "cells", "cells per axis", 1, 999999999, by_length ? MPM_OPTIONAL : MPM_REQUIRED,
                           grid->dim, grid->cells, &counted));
  PetscCall(MpmOptionsReal(block, "cell", "m", "length of a cell, instead of cells", MPM_RANGE_POSITIVE, MPM_OPTIONAL,
                           &cell, &by_length));
  if (MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!counted || !by_length, "-mpm_grid_cell: -mpm_grid_cells is given, too");
  if (terrain) PetscCall(TakeTerrain(options, given, grid));
  if (by_length) PetscCall(FindCells(cell, (PetscBool)!terrain, grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}
