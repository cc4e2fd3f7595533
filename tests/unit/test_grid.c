/*
  The background grid where it is placed anew: nodes and places go with the lattice, on each axis by itself.
*/
#include "grid/grid.h"
#include "unit.h"

#include <math.h>

/* 4 x 2 cells of 0.5 x 1 from (1, -1). */
static MpmGrid Grid(void)
{
  return (MpmGrid){.dim         = 2,
                   .lower       = {1., -1.},
                   .upper       = {3., 1.},
                   .h           = {0.5, 1., 1.},
                   .cells       = {4, 2, 1},
                   .nodes       = {5, 3, 1},
                   .start_lower = {1., -1.},
                   .start_upper = {3., 1.},
                   .start_h     = {0.5, 1., 1.}};
}

START_TEST(grid_that_stays)
{
  MpmGrid         grid = Grid();
  const PetscReal x[]  = {1.0 / 3.0 + 1., 0.1};
  PetscReal       start[MPM_MAX_DIM];

  MpmGridAtStart(&grid, x, start);
  ck_assert(start[0] == x[0] && start[1] == x[1]);
}
END_TEST

START_TEST(grid_that_moves)
{
  MpmGrid         grid    = Grid();
  const PetscReal lower[] = {1., 9.}, upper[] = {2., 11.}; /* half as long along x, ten further along y */
  const PetscInt  node[] = {3, 1, 0};
  PetscInt        cell[MPM_MAX_DIM];
  PetscReal       start[MPM_MAX_DIM], place[MPM_MAX_DIM];

  MpmGridPlace(&grid, lower, upper);
  ck_assert(grid.h[0] == 0.25 && grid.h[1] == 1.);
  MpmGridNodeAtStart(&grid, node, start);
  ck_assert(start[0] == 2.5 && start[1] == 0.);
  for (PetscInt a = 0; a < 2; a++) place[a] = grid.lower[a] + grid.h[a] * (PetscReal)node[a];
  MpmGridAtStart(&grid, place, start);
  ck_assert(fabs(start[0] - 2.5) < 1e-14 && fabs(start[1]) < 1e-14);
  place[0] = 1.6;
  place[1] = 10.5;
  MpmGridFindCell(&grid, place, cell);
  ck_assert(cell[0] == 2 && cell[1] == 1);
  MpmGridPlace(&grid, grid.start_lower, grid.start_upper); /* and back */
  ck_assert(grid.lower[1] == -1. && grid.upper[0] == 3. && grid.h[0] == 0.5);
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {grid_that_stays, grid_that_moves};

  return UnitRun(&argc, &argv, "grid", sizeof(tests) / sizeof(*tests), tests);
}
