/*
  Fields of the points at the nodes: means weighted by shape function and volume.

    u_i = sum_p w_p (u_p + grad u_p (x_i - x_p)) / sum_p w_p ,   w_p = |phi_i(x_p)| V_p

  With the gradient a linear field comes out exactly, at the edges of the material too.
*/
#include "grid/grid.h"
#include "space/point_loop.h"

/* The points' values, and sums over the points of one group. */
typedef struct {
  const MpmPointValues *of;
  PetscReal            *sums;   /* [c][i], weights last */
  PetscReal            *weight; /* of one point at the group's nodes */
  PetscReal            *place;  /* [a][i]: of the nodes, from the first one */
} Projection;

static void PlaceNodes(const MpmGrid *grid, const MpmSpace *space, const MpmGroup *group, PetscReal place[])
{
  const PetscInt n = group->node_count;
  PetscInt       first[MPM_MAX_DIM];

  MpmSpaceGroupAt(space, group, first);
  for (PetscInt i = 0; i < n; i++) {
    PetscInt k = i;

    for (PetscInt a = 0; a < grid->dim; a++) {
      place[a * n + i] = grid->h[a] * MpmGridNodeStep(grid, first[a], k % group->count[a]);
      k /= group->count[a];
    }
  }
}

/* sums_i += w_i (value + gradient (x_i - x_p)), one component; `start` is its value at the first node */
MPM_INLINE void AddComponent(const MpmKnown known, const PetscReal weight[], PetscReal start,
                             const PetscReal gradient[], const PetscReal place[], PetscReal *restrict sums)
{
  const PetscInt n = known.n;

  for (PetscInt i = 0; i < n; i++) {
    PetscReal value = start;

    for (PetscInt a = 0; a < known.dim; a++) value += gradient[a] * place[a * n + i];
    sums[i] += weight[i] * value;
  }
}

/* `along`: the shape's weights of all points */
MPM_INLINE void WeighNodes(const MpmKnown known, const MpmSpace *space, const PetscReal along[], PetscInt p,
                           PetscReal volume, PetscReal weight[])
{
  const MpmLines w = MpmPointLines(known.dim, space, along, p, &MpmLineOne);

  for (PetscInt l = 0; l < known.count[2]; l++) {
    for (PetscInt j = 0; j < known.count[1]; j++, weight += known.count[0]) {
      const PetscReal factor = volume * w.along[1][j] * w.along[2][l];

      for (PetscInt k = 0; k < known.count[0]; k++) weight[k] = PetscAbsReal(w.along[0][k] * factor);
    }
  }
}

/* The sums of one group, added to those at its nodes: the components and, last, the weights of each node. */
MPM_INLINE PetscErrorCode ProjectGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                       const Projection *project, PetscReal nodal[])
{
  static const PetscReal flat[MPM_MAX_DIM] = {0.};
  const MpmSpace        *space             = sum->space;
  const MpmGrid         *grid              = sum->grid;
  const MpmPoints       *points            = sum->points;
  const MpmPointValues  *of                = project->of;
  const PetscReal       *along             = space->shapes.at[of->shape].weight;
  const PetscInt         n = known.n, dim = known.dim, components = of->components;
  const PetscInt        *nodes = &space->group_nodes[group->node_offset];
  PetscInt               first[MPM_MAX_DIM];

  MpmSpaceGroupAt(space, group, first);
  for (PetscInt k = 0; k < n * (components + 1); k++) project->sums[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt   p = space->order[s], ahead = MpmSumAhead(sum, s);
    const PetscReal *x = &points->x[p * dim];

    MpmFetch(along, ahead, dim * space->width);
    MpmFetch(of->value, ahead, of->stride);
    MpmFetch(points->x, ahead, dim);
    MpmFetch(points->volume0, ahead, 1);
    WeighNodes(known, space, along, p, points->volume0[p], project->weight);
    for (PetscInt c = 0; c < components; c++) {
      const PetscReal *gradient = of->gradient ? &of->gradient[p * of->gradient_stride + c * dim] : flat;
      PetscReal        start    = of->value[p * of->stride + c];

      for (PetscInt a = 0; a < dim; a++) start += gradient[a] * (MpmGridNodeAt(grid, a, first[a]) - x[a]);
      AddComponent(known, project->weight, start, gradient, project->place, &project->sums[c * n]);
    }
    for (PetscInt i = 0; i < n; i++) project->sums[components * n + i] += project->weight[i];
  }
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c <= components; c++) nodal[nodes[i] * (components + 1) + c] += project->sums[c * n + i];
  return PETSC_SUCCESS;
}

PetscErrorCode MpmProjectToNodes(const MpmSum *sum, const MpmPointValues *values, PetscReal nodal[])
{
  const MpmSpace *space      = sum->space;
  const PetscInt  components = values->components, most = PetscPowInt(space->width, space->dim), n = components + 1;
  Projection      project = {.of = values};
  PetscReal      *sums;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((space->local * n), &sums));
  PetscCall(PetscMalloc3((most * n), &project.sums, most, &project.weight, (most * space->dim), &project.place));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    PlaceNodes(sum->grid, space, group, project.place);
    MPM_DISPATCH(sum->layout, group, ProjectGroup, sum, group, &project, sums);
  }
  PetscCall(MpmSpaceAddToOwners(space, n, sums));
  for (PetscInt k = 0; k < space->owned * components; k++) {
    const PetscReal *at = &sums[k / components * n];

    nodal[k] = at[components] > 0. ? at[k % components] / at[components] : 0.;
  }
  PetscCall(PetscFree3(project.sums, project.weight, project.place));
  PetscCall(PetscFree(sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}
