/*
  Fields at the points, their deviations from means over cells, and destinations of the points.
*/
#include "grid/grid.h"
#include "space/point_loop.h"

/* `count` components at the points by one of the basis functions of their shapes. */
static PetscErrorCode AtPoints(const MpmSum *sum, const PetscReal u[], PetscInt count, const PetscInt component[],
                               PetscInt basis, PetscReal value[])
{
  const MpmLayout *layout = sum->layout;
  MpmWorkspace     work;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    const MpmKnown  known = KnownGeneral(layout, group);

    MpmSumGather(known, sum, group, u, work.values);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = sum->space->order[s];

      MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work.basis);
      for (PetscInt k = 0; k < count; k++) {
        const PetscInt   c   = component[k];
        const PetscReal *phi = work.basis.basis[layout->component[c].shape * MPM_BASES + basis];
        PetscReal        d   = 0.;

        for (PetscInt i = 0; i < known.n; i++) d += phi[i] * work.values[c * known.n + i];
        value[p * count + k] = d;
      }
    }
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDeviationsAtPoints(const MpmSum *sum, const PetscReal u[], PetscReal deviation[])
{
  const MpmLayout *layout = sum->layout;

  PetscFunctionBeginUser;
  PetscCall(
    AtPoints(sum, u, layout->deviation.count, layout->deviation.component, MPM_DEVIATION(layout->dim), deviation));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmRatesAtPoints(const MpmSum *sum, const PetscReal u[], PetscReal value[])
{
  PetscFunctionBeginUser;
  PetscCall(AtPoints(sum, u, sum->layout->rate.count, sum->layout->rate.component, 0, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmScalarAtPoints(const MpmSum *sum, const PetscReal nodal[], PetscReal value[], PetscReal gradient[])
{
  MpmWorkspace work;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    const MpmKnown  known = KnownGeneral(sum->layout, group);
    const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = sum->space->order[s];

      MpmSumBasis(known, sum->space, p, PETSC_TRUE, &work.basis);
      for (PetscInt k = value ? 0 : 1; k <= known.dim; k++) {
        PetscReal d = 0.;

        for (PetscInt i = 0; i < known.n; i++) d += work.basis.basis[k][i] * nodal[nodes[i]];
        if (k) gradient[p * known.dim + k - 1] = d;
        else value[p] = d;
      }
    }
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDisplacementsAtPoints(const MpmSum *sum, const PetscReal u[], PetscReal displacement[])
{
  const PetscInt axis[MPM_MAX_DIM] = {0, 1, 2};

  PetscFunctionBeginUser;
  PetscCall(AtPoints(sum, u, sum->layout->dim, axis, 0, displacement));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a place is in the grid, but for rounding at the edge. */
static PetscBool IsInside(const MpmGrid *grid, const PetscReal x[])
{
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal slack = MPM_GRID_SLACK * grid->h[a];

    if (!(x[a] >= grid->lower[a] - slack && x[a] <= grid->upper[a] + slack)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

/* The longest displacement of any local node along each axis, m; infinite where one is no number. */
static void FindLongest(const MpmSum *sum, const PetscReal displacement[], PetscReal longest[])
{
  const PetscInt dim = sum->space->dim, bs = sum->block;

  for (PetscInt a = 0; a < dim; a++) longest[a] = 0.;
  for (PetscInt i = 0; i < sum->space->local; i++)
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal u = PetscAbsReal(displacement[i * bs + a]);

      if (!(u <= longest[a])) longest[a] = u <= PETSC_MAX_REAL ? u : PETSC_INFINITY;
    }
}

#define FURTHER 3. /* than any node that it touches no point moves further, times this, by any shape */

/*
  True where no point of a group can reach the grid's edge. Points lie between the group's nodes. `longest` bounds the
  motion of any node along each axis; `reach` becomes the bound of the group's own nodes, or 0 along axes on which its
  points are too far from an edge.
*/
static PetscBool GroupIsFar(const MpmSum *sum, const MpmGroup *group, const PetscReal u[], const PetscReal longest[],
                            PetscReal reach[])
{
  const MpmGrid *grid = sum->grid;
  const PetscInt bs = sum->block, *nodes = &sum->space->group_nodes[group->node_offset];
  PetscBool      far = PETSC_TRUE;
  PetscInt       first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscReal low = MpmGridNodeXi(grid, first[a]), high = MpmGridNodeXi(grid, first[a] + group->count[a] - 1);
    const PetscReal room = PetscMin(low, (PetscReal)grid->cells[a] - high);
    PetscReal       here = 0.;

    reach[a] = 0.;
    if (FURTHER / grid->h[a] * longest[a] < room) continue;
    for (PetscInt i = 0; i < group->node_count; i++) {
      const PetscReal way = PetscAbsReal(u[nodes[i] * bs + a]);

      if (!(way <= here)) here = way <= PETSC_MAX_REAL ? way : PETSC_INFINITY;
    }
    if (FURTHER / grid->h[a] * here < room) continue;
    reach[a] = here;
    far      = PETSC_FALSE;
  }
  return far;
}

/* GroupIsFar() of a point. */
static PetscBool PointIsFar(const MpmGrid *grid, const PetscReal x[], const PetscReal reach[])
{
  for (PetscInt a = 0; a < grid->dim; a++)
    if (!(x[a] - grid->lower[a] >= FURTHER * reach[a] && grid->upper[a] - x[a] >= FURTHER * reach[a]))
      return PETSC_FALSE;
  return PETSC_TRUE;
}

PetscErrorCode MpmFindOutside(const MpmSum *sum, const MpmGrid *next, const PetscReal u[], PetscInt *point,
                              PetscReal x[])
{
  const MpmSpace *space = sum->space;
  const PetscInt  dim   = space->dim;
  PetscReal       longest[MPM_MAX_DIM], reach[MPM_MAX_DIM];
  MpmBasis        basis;

  PetscFunctionBeginUser;
  *point = -1;
  if (!sum->layout->motion) PetscFunctionReturn(PETSC_SUCCESS);
  FindLongest(sum, u, longest);
  for (PetscInt a = 0; a < dim; a++) reach[a] = longest[a];
  PetscCall(MpmBasisCreate(space, &basis));
  for (PetscInt g = 0; g < space->group_count && *point < 0; g++) {
    const MpmGroup *group = &space->groups[g];

    if (next == sum->grid && GroupIsFar(sum, group, u, longest, reach)) continue;
    for (PetscInt s = group->point_begin; s < group->point_end && *point < 0; s++) {
      const PetscInt p = space->order[s];

      if (PointIsFar(next, &sum->points->x[p * dim], reach)) continue;
      MpmSpaceEvaluate(space, group, p, &basis);
      for (PetscInt a = 0; a < dim; a++) x[a] = sum->points->x[p * dim + a];
      MpmBasisInterpolate(space, group, &basis, sum->block, u, dim, x);
      if (!IsInside(next, x)) *point = p;
    }
  }
  PetscCall(MpmBasisDestroy(&basis));
  PetscFunctionReturn(PETSC_SUCCESS);
}
