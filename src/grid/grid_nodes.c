/*
  Nodes of the background grid: the vertices of its cells, and for elements of higher order those within cells.
*/
#include "grid/grid.h"

void MpmGridSetOrder(MpmGrid *grid, PetscInt order)
{
  grid->order = order;
  for (PetscInt a = 0; a < grid->dim; a++) grid->nodes[a] = order * grid->cells[a] + 1;
}

const PetscReal *MpmCellNodes(PetscInt order)
{
  /* (1 + x)/2 with x = 0, sqrt(1/5), sqrt(3/7) */
  static const PetscReal place[4][5] = {{0., 1.},
                                        {0., 0.5, 1.},
                                        {0., 0.27639320225002103, 0.72360679774997897, 1.},
                                        {0., 0.17267316464601143, 0.5, 0.82732683535398857, 1.}};

  return place[order - 1];
}

void MpmGridFindPart(const MpmGrid *grid, const PetscReal x[], PetscInt part[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) part[a] = 0;
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal xi = PetscFloorReal((PetscReal)grid->order * ((x[a] - grid->lower[a]) / grid->h[a]));

    part[a] = (PetscInt)PetscMin(PetscMax(xi, 0.), (PetscReal)(grid->order * grid->cells[a] - 1));
  }
}

void MpmGridNodeAtStart(const MpmGrid *grid, const PetscInt node[], PetscReal start[])
{
  for (PetscInt a = 0; a < grid->dim; a++)
    start[a] = grid->start_lower[a] + grid->start_h[a] * MpmGridNodeXi(grid, node[a]);
}

PetscMPIInt MpmGridNodeOwner(const MpmGrid *grid, const PetscInt node[])
{
  PetscInt cell[MPM_MAX_DIM];

  if (grid->order <= 1) return MpmGridCellOwner(grid, node);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) cell[a] = node[a] / grid->order;
  return MpmGridCellOwner(grid, cell);
}
