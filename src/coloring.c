/*
  The Jacobian, column by column: global seeds in dual numbers.

  Nodes that stand a multiple of b = 2w - 1 apart on every axis share no row, w being the most nodes that a point
  touches on an axis. So b^dim seeds, one for each place in a block of b^dim nodes, times the unknowns of a node, give
  all columns: 25 or 125 for GIMP and quadratic B-splines. Source: Zhao, Li, Jiang and Choo (2025), GeoWarp, section
  3.2.

  With one node a colour the same code is the dense, column-by-column differentiation; with differences of the plain
  kernel in place of duals it is the finite-difference Jacobian. Both are for tests and benchmarks.
*/
#include "sum.h"

/* Central differences: the step that balances truncation and rounding for inputs of order one. */
#define FD_STEP 6e-6

typedef struct {
  const MpmSum *sum;
  PetscBool     differences, dense;
  PetscBool     values;
  PetscInt      side; /* nodes of one colour are this far apart */
  PetscReal    *y;    /* one column of every window, by rows */
  MpmWorkspace  work;
} Seeds;

/* Derivative of the flux along dinput, by duals or by central differences. */
static int Direction(const Seeds *seeds, const MpmKernelPoint *point, const PetscReal input[], const PetscReal dinput[],
                     PetscReal dflux[])
{
  const MpmKernelSet *kernel = seeds->sum->layout->kernel;
  const PetscInt      N      = seeds->sum->layout->inputs;
  PetscReal flux[MPM_MAX_INPUTS], forward[MPM_MAX_INPUTS], backward[MPM_MAX_INPUTS], shifted[MPM_MAX_INPUTS], size = 0.;

  if (!seeds->differences) return kernel->direction(point, input, dinput, flux, dflux);
  for (PetscInt k = 0; k < N; k++) size = PetscMax(size, PetscAbsReal(dinput[k]));
  for (PetscInt k = 0; k < N; k++) dflux[k] = 0.;
  if (size == 0.) return 0;
  for (PetscInt k = 0; k < N; k++) shifted[k] = input[k] + FD_STEP * dinput[k] / size;
  if (kernel->residual(point, shifted, forward)) return 1;
  for (PetscInt k = 0; k < N; k++) shifted[k] = input[k] - FD_STEP * dinput[k] / size;
  if (kernel->residual(point, shifted, backward)) return 1;
  for (PetscInt k = 0; k < N; k++) dflux[k] = (forward[k] - backward[k]) * size / (2. * FD_STEP);
  return 0;
}

/* The group's node of this colour (x fastest), or -1: there is at most one. */
static PetscInt NodeOfColor(const Seeds *seeds, const MpmGroup *group, const PetscInt color[])
{
  PetscInt at[MPM_MAX_DIM] = {0, 0, 0};

  for (PetscInt a = 0; a < seeds->sum->space->dim; a++) {
    at[a] = (color[a] - group->first[a]) % seeds->side;
    if (at[a] < 0) at[a] += seeds->side;
    if (at[a] >= group->count[a]) return -1;
  }
  return (at[2] * group->count[1] + at[1]) * group->count[0] + at[0];
}

/* y += the column of component c of the coloured node, for one group's points. */
static PetscErrorCode AddColumn(Seeds *seeds, const MpmGroup *group, const PetscReal u[], PetscInt j, PetscInt c,
                                PetscInt *failed)
{
  const MpmSum    *sum    = seeds->sum;
  const MpmLayout *layout = sum->layout;
  const MpmKnown   known  = KnownGeneral(layout, group);
  const PetscInt   n = group->node_count, bs = layout->block;
  const PetscInt  *nodes = &sum->space->group_nodes[group->node_offset];

  PetscFunctionBeginUser;
  MpmSumGather(known, sum, group, u, seeds->work.values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    MpmKernelPoint point;
    PetscReal      input[MPM_MAX_INPUTS], dinput[MPM_MAX_INPUTS], dflux[MPM_MAX_INPUTS];

    MpmSumBasis(known, sum->space, sum->space->order[s], seeds->values, &seeds->work.basis);
    MpmSumInputs(known, layout, seeds->work.values, &seeds->work.basis, input);
    for (PetscInt k = 0; k < layout->inputs; k++) {
      dinput[k] = j >= 0 && layout->component_of[k] == c ? seeds->work.basis.basis[layout->basis_of[k]][j] : 0.;
    }
    MpmSumPoint(sum, sum->space->order[s], &point);
    if (Direction(seeds, &point, input, dinput, dflux)) {
      (*failed)++;
      continue;
    }
    for (PetscInt k = 0; k < layout->inputs; k++) {
      const PetscReal *phi = seeds->work.basis.basis[layout->basis_of[k]];

      for (PetscInt i = 0; i < n; i++) seeds->y[nodes[i] * bs + layout->component_of[k]] += phi[i] * dflux[k];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves y into the matrix values: row i holds the column of the one node of this colour in its window. */
static void TakeColumn(const Seeds *seeds, const PetscInt color[], PetscInt c, MpmPattern *pattern)
{
  const MpmSpace       *space       = seeds->sum->space;
  const MpmConstraints *constraints = seeds->sum->constraints;
  const PetscInt        bs = pattern->block, dim = pattern->dim, side = 2 * pattern->reach + 1;

  for (PetscInt i = 0; i < pattern->local; i++) {
    PetscInt       w = 0, stride = 1, slot;
    const PetscInt count = pattern->row[i + 1] - pattern->row[i];

    for (PetscInt a = 0; a < dim && w >= 0; a++, stride *= side) {
      PetscInt d = (color[a] - (space->node[i * dim + a] - pattern->reach)) % seeds->side;

      if (d < 0) d += seeds->side;
      w = d < side ? w + d * stride : -1;
    }
    slot = w >= 0 ? pattern->slot[i * pattern->window + w] : -1;
    for (PetscInt r = 0; r < bs; r++) {
      if (slot >= 0 && constraints->condition[i * bs + r] < 0) {
        pattern->value[pattern->row[i] * bs * bs + (r * count + slot) * bs + c] += seeds->y[i * bs + r];
      }
      seeds->y[i * bs + r] = 0.;
    }
  }
}

/* Is component c constrained at a local node? Its column is then left out. */
static PetscBool ColumnHeld(const MpmSum *sum, const MpmGroup *group, PetscInt j, PetscInt c)
{
  const PetscInt node = sum->space->group_nodes[group->node_offset + j];

  return (PetscBool)(sum->constraints->condition[node * sum->layout->block + c] >= 0);
}

/* The colours: block places, or, one node a colour, the places in the box of all nodes. */
static PetscErrorCode ColorBox(const MpmSum *sum, const MpmPattern *pattern, PetscBool dense, PetscInt lower[],
                               PetscInt upper[], PetscInt *side)
{
  PetscInt bound[2 * MPM_MAX_DIM], longest = 1;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = 0;
    upper[a] = a < pattern->dim ? 2 * pattern->reach + 1 : 1;
  }
  *side = 2 * pattern->reach + 1;
  if (!dense) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2 * MPM_MAX_DIM; k++) bound[k] = PETSC_INT_MAX;
  for (PetscInt k = 0; k < pattern->local * pattern->dim; k++) {
    const PetscInt a = k % pattern->dim, node = sum->space->node[k];

    bound[a]               = PetscMin(bound[a], node);
    bound[MPM_MAX_DIM + a] = PetscMin(bound[MPM_MAX_DIM + a], -node);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, bound, 2 * MPM_MAX_DIM, MPIU_INT, MPI_MIN, sum->grid->comm));
  for (PetscInt a = 0; a < pattern->dim; a++) {
    lower[a] = bound[a];
    upper[a] = -bound[MPM_MAX_DIM + a] + 1;
    longest  = PetscMax(longest, upper[a] - lower[a]);
  }
  *side = longest + 2 * pattern->reach + 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmJacobianColoring(const MpmSum *sum, MpmJacobianType type, const PetscReal u[], MpmPattern *pattern,
                                   PetscInt *failed)
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs    = sum->layout->block;
  Seeds           seeds = {.sum = sum};
  PetscInt        lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], color[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  *failed           = 0;
  seeds.differences = (PetscBool)(type == MPM_JACOBIAN_FD);
  seeds.dense       = (PetscBool)(type == MPM_JACOBIAN_DENSE);
  seeds.values      = MpmLayoutUsesValues(sum->layout);
  PetscCall(ColorBox(sum, pattern, seeds.dense, lower, upper, &seeds.side));
  PetscCall(PetscArrayzero(pattern->value, pattern->row[pattern->local] * bs * bs));
  PetscCall(MpmWorkspaceCreate(sum, &seeds.work));
  PetscCall(PetscCalloc1((pattern->local * bs), &seeds.y));
  for (color[2] = lower[2]; color[2] < upper[2]; color[2]++) {
    for (color[1] = lower[1]; color[1] < upper[1]; color[1]++) {
      for (color[0] = lower[0]; color[0] < upper[0]; color[0]++) {
        for (PetscInt c = 0; c < bs; c++) {
          for (PetscInt g = 0; g < space->group_count; g++) {
            const PetscInt j = NodeOfColor(&seeds, &space->groups[g], color);

            /* dense differentiation is kept honest: it evaluates every point for every column */
            if (!seeds.dense && (j < 0 || ColumnHeld(sum, &space->groups[g], j, c))) continue;
            PetscCall(AddColumn(&seeds, &space->groups[g], u,
                                j >= 0 && ColumnHeld(sum, &space->groups[g], j, c) ? -1 : j, c, failed));
          }
          TakeColumn(&seeds, color, c, pattern);
        }
      }
    }
  }
  PetscCall(MpmGhostJacobian(sum, pattern));
  PetscCall(PetscFree(seeds.work.storage));
  PetscCall(PetscFree(seeds.y));
  PetscFunctionReturn(PETSC_SUCCESS);
}
