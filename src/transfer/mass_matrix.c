/*
  The consistent mass matrix: by groups of points into windows of nodes around each node, which are then packed by rows.
*/
#include "particles/point_mass.h"
#include "space/point_loop.h"
#include "transfer/motion.h"

PetscErrorCode MpmMassMatrixReset(MpmMassMatrix *mass)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(mass->start));
  PetscCall(PetscFree3(mass->column, mass->place, mass->value));
  mass->nodes = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values and local nodes in the windows of all local nodes, on their way into rows. */
typedef struct {
  PetscInt   side, size; /* size: of a window */
  PetscReal *value;
  PetscInt  *column; /* or -1 */
} Windows;

#define TOGETHER 8 /* points whose products are summed before they go to the windows */

/* sum_p m_p w_i w_j of `count` points, added to the windows of their nodes; `run` of which stand side by side. */
MPM_INLINE void AddProducts(const PetscInt run, PetscInt runs, const PetscInt offset[], PetscInt count,
                            const PetscReal weight[], const PetscReal by[], PetscReal *restrict value)
{
  const PetscInt n = run * runs;

  for (PetscInt r = 0; r < runs; r++) {
    PetscReal sum[MPM_MAX_WIDTH];

    for (PetscInt k = 0; k < run; k++) sum[k] = by[0] * weight[r * run + k];
    for (PetscInt q = 1; q < count; q++)
      for (PetscInt k = 0; k < run; k++) sum[k] += by[q] * weight[q * n + r * run + k];
    for (PetscInt k = 0; k < run; k++) value[offset[r] + k] += sum[k];
  }
}

/* One group; `weight` has room for those of TOGETHER points. */
MPM_INLINE PetscErrorCode AddGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, PetscReal weight[],
                                   Windows *windows)
{
  const PetscInt  n = known.n, run = known.count[0], side = windows->side, middle = (windows->size - 1) / 2;
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];
  PetscInt offset[MPM_MAX_WIDTH * MPM_MAX_WIDTH]; /* of the runs of nodes along x, in a window from the first one on */

  for (PetscInt r = 0; r * run < n; r++) offset[r] = (r / known.count[1] * side + r % known.count[1]) * side;
  for (PetscInt from = group->point_begin; from < group->point_end; from += TOGETHER) {
    const PetscInt count = PetscMin(TOGETHER, group->point_end - from);
    PetscReal      mass[TOGETHER], by[TOGETHER];

    for (PetscInt q = 0; q < count; q++) {
      const PetscInt p = sum->space->order[from + q];

      mass[q] = MpmPointMass(sum->points, sum->materials, p);
      MpmSpaceFetch(known, sum->space, MpmSumAhead(sum, from + q));
      MpmShapeWeights(known, sum->space, p, &weight[q * n]);
    }
    for (PetscInt i = 0; i < n; i++) {
      PetscReal *value = &windows->value[nodes[i] * windows->size + middle - offset[i / run] - i % run];

      for (PetscInt q = 0; q < count; q++) by[q] = mass[q] * weight[q * n + i];
      if (run == 4) AddProducts(4, n / 4, offset, count, weight, by, value);
      else AddProducts(run, n / run, offset, count, weight, by, value);
    }
  }
  for (PetscInt i = 0; i < n; i++) {
    PetscInt *column = &windows->column[nodes[i] * windows->size + middle - offset[i / run] - i % run];

    for (PetscInt r = 0; r * run < n; r++)
      for (PetscInt k = 0; k < run; k++) column[offset[r] + k] = nodes[r * run + k];
  }
  return PETSC_SUCCESS;
}

/* Windows become rows. */
static PetscErrorCode Pack(const Windows *windows, MpmMassMatrix *mass)
{
  const PetscInt size  = windows->size;
  PetscInt       count = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < mass->nodes * size; k++) count += windows->column[k] >= 0;
  PetscCall(PetscMalloc1((mass->nodes + 1), &mass->start));
  PetscCall(PetscMalloc3(count, &mass->column, count, &mass->place, count, &mass->value));
  count = 0;
  for (PetscInt i = 0; i < mass->nodes; i++) {
    mass->start[i] = count;
    for (PetscInt k = 0; k < size; k++) {
      if (windows->column[i * size + k] < 0) continue;
      mass->column[count]  = windows->column[i * size + k];
      mass->value[count]   = windows->value[i * size + k];
      mass->place[count++] = k;
    }
  }
  mass->start[mass->nodes] = count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMassMatrixSetUp(MpmMassMatrix *mass, const MpmSum *sum)
{
  const MpmSpace *space = sum->space;
  const PetscInt  most  = PetscPowInt(space->width, space->dim);
  Windows         windows;
  PetscReal      *weight;

  PetscFunctionBeginUser;
  PetscCall(MpmMassMatrixReset(mass));
  mass->reach  = space->width - 1;
  mass->nodes  = space->local;
  windows.side = 2 * mass->reach + 1;
  windows.size = PetscPowInt(windows.side, space->dim);
  PetscCall(PetscCalloc1((mass->nodes * windows.size), &windows.value));
  PetscCall(PetscMalloc1((mass->nodes * windows.size), &windows.column));
  PetscCall(PetscMalloc1((TOGETHER * most), &weight));
  for (PetscInt k = 0; k < mass->nodes * windows.size; k++) windows.column[k] = -1;
  for (PetscInt g = 0; g < space->group_count; g++)
    MPM_DISPATCH(sum->layout, &space->groups[g], AddGroup, sum, &space->groups[g], weight, &windows);
  PetscCall(Pack(&windows, mass));
  PetscCall(PetscFree(weight));
  PetscCall(PetscFree(windows.value));
  PetscCall(PetscFree(windows.column));
  PetscFunctionReturn(PETSC_SUCCESS);
}
