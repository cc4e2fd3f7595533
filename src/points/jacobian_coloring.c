/*
  The Jacobian, column by column: global seeds in dual numbers.

  Nodes that stand a multiple of b = 2w - 1 apart on every axis share no row, w being the most nodes that a point
  touches on an axis. Therefore b^dim seeds, one for each place in a block of b^dim nodes, times the unknowns of a node,
  give all columns: 25 or 125 for GIMP and quadratic B-splines. Source: Zhao, Li, Jiang and Choo (2025), GeoWarp,
  section 3.2.

  With one node a colour this code is the dense, column-by-column differentiation; with differences of the plain
  kernel in place of duals it is the finite-difference Jacobian. Both are for tests and benchmarks.
*/
#include "grid/grid.h"
#include "space/unit.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "points/action.h"
#include "points/jacobian_coloring.h"

typedef struct {
  const MpmSum         *sum;
  const MpmConstraints *constraints;
  PetscBool             dense;
  PetscInt              side;   /* nodes of one colour are this far apart */
  PetscReal            *du, *y; /* the seeds, and one column of every window, by rows */
  MpmAction             action;
} Seeds;

/* A box's node of this colour (x fastest), or -1: there is at most one. */
static PetscInt NodeOfColor(const Seeds *seeds, const MpmGroup *box, const PetscInt color[])
{
  PetscInt at[MPM_MAX_DIM] = {0, 0, 0};

  for (PetscInt a = 0; a < seeds->sum->space->dim; a++) {
    at[a] = (color[a] - box->first[a]) % seeds->side;
    if (at[a] < 0) at[a] += seeds->side;
    if (at[a] >= box->count[a]) return -1;
  }
  return (at[2] * box->count[1] + at[1]) * box->count[0] + at[0];
}

/* True where a local node has this colour. */
static PetscBool HasColor(const Seeds *seeds, PetscInt node, const PetscInt color[])
{
  const PetscInt dim = seeds->sum->space->dim;

  for (PetscInt a = 0; a < dim; a++)
    if ((color[a] - seeds->sum->space->node[node * dim + a]) % seeds->side) return PETSC_FALSE;
  return PETSC_TRUE;
}

/* The seeds of component c: one at every node of the colour that is not constrained there. */
static void PlantSeeds(const Seeds *seeds, const PetscInt color[], PetscInt c)
{
  const PetscInt bs = seeds->sum->block;

  for (PetscInt i = 0; i < seeds->sum->space->local; i++) {
    for (PetscInt k = 0; k < bs; k++) seeds->du[i * bs + k] = 0.;
    if (HasColor(seeds, i, color) && MpmConstraintsCounts(seeds->constraints, i * bs + c)) seeds->du[i * bs + c] = 1.;
  }
  MpmFramesToAxes(seeds->constraints, bs, seeds->sum->space->local, seeds->du);
}

/* Moves y into the matrix values: row i holds the column of the one node of this colour in its window. */
static void TakeColumn(const Seeds *seeds, const PetscInt color[], PetscInt c, MpmPattern *pattern)
{
  const MpmSpace       *space       = seeds->sum->space;
  const MpmConstraints *constraints = seeds->constraints;
  const PetscInt        bs = pattern->block, dim = pattern->dim, side = 2 * pattern->reach + 1;

  MpmFramesToUnknowns(constraints, bs, pattern->local, seeds->y);
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
      if (slot >= 0 && MpmConstraintsCounts(constraints, i * bs + r)) {
        pattern->value[i][(r * count + slot) * bs + c] += seeds->y[i * bs + r];
      }
      seeds->y[i * bs + r] = 0.;
    }
  }
}

/* y += the columns of component c of this colour's nodes. */
static PetscErrorCode AddColumns(Seeds *seeds, const PetscInt color[], PetscInt c, PetscInt *failed)
{
  const MpmSum   *sum   = seeds->sum;
  const MpmSpace *space = sum->space;

  PetscFunctionBeginUser;
  PlantSeeds(seeds, color, c);
  if (space->cells.spread) {
    PetscCall(MpmActionApplyPoints(&seeds->action, seeds->du, seeds->y, failed));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt unit = 0; unit < MpmUnitCount(sum); unit++) {
    const MpmGroup *box = &space->groups[MpmUnitGroups(sum, unit).box];
    const PetscInt  j = NodeOfColor(seeds, box, color), node = j < 0 ? -1 : space->group_nodes[box->node_offset + j];

    /* dense differentiation is kept honest: it evaluates every point for every column */
    if (!seeds->dense && (node < 0 || !MpmConstraintsCounts(seeds->constraints, node * sum->block + c))) continue;
    PetscCall(MpmActionApplyUnit(&seeds->action, unit, seeds->du, seeds->y, failed));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
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

PetscErrorCode MpmJacobianColoring(const MpmTerms *terms, const MpmSum *sum, MpmJacobianType type, const PetscReal u[],
                                   MpmPattern *pattern, PetscInt *failed)
{
  const PetscInt bs = sum->block;
  Seeds    seeds = {.sum = sum, .constraints = pattern->constraints, .dense = (PetscBool)(type == MPM_JACOBIAN_DENSE)};
  PetscInt lower[MPM_MAX_DIM], upper[MPM_MAX_DIM], color[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(ColorBox(sum, pattern, seeds.dense, lower, upper, &seeds.side));
  PetscCall(MpmActionCreate(terms, sum, PETSC_FALSE, PETSC_FALSE, &seeds.action));
  seeds.action.differences = (PetscBool)(type == MPM_JACOBIAN_FD);
  PetscCall(MpmActionSetState(&seeds.action, u, failed));
  PetscCall(PetscCalloc1((pattern->local * bs), &seeds.y));
  PetscCall(PetscMalloc1((pattern->local * bs), &seeds.du));
  for (color[2] = lower[2]; color[2] < upper[2]; color[2]++) {
    for (color[1] = lower[1]; color[1] < upper[1]; color[1]++) {
      for (color[0] = lower[0]; color[0] < upper[0]; color[0]++) {
        for (PetscInt c = 0; c < bs; c++) {
          PetscCall(AddColumns(&seeds, color, c, failed));
          TakeColumn(&seeds, color, c, pattern);
        }
      }
    }
  }
  PetscCall(MpmTermsTangentRest(terms, sum, u, pattern, failed));
  PetscCall(MpmActionDestroy(&seeds.action));
  PetscCall(PetscFree(seeds.y));
  PetscCall(PetscFree(seeds.du));
  PetscFunctionReturn(PETSC_SUCCESS);
}
