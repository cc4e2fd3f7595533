/*
  Fields of the points at the nodes: means weighted by shape function and volume.

    u_i = sum_p w_p (u_p + grad u_p (x_i - x_p)) / sum_p w_p ,   w_p = |phi_i(x_p)| V_p

  With the gradient a linear field comes out exactly, at the edges of the material too.
*/
#include "mpmimpl.h"

/* Adds one point's part: `sums` holds the components and, last, the weights of each local node. */
static void AddPoint(const MpmSpace *space, const MpmGrid *grid, const MpmGroup *group, const MpmPoints *points,
                     PetscInt p, const MpmBasis *basis, PetscInt components, const PetscReal value[],
                     const PetscReal gradient[], PetscReal sums[])
{
  const PetscInt  dim   = space->dim;
  const PetscInt *nodes = &space->group_nodes[group->node_offset];

  for (PetscInt i = 0; i < group->node_count; i++) {
    const PetscReal weight = PetscAbsReal(basis->basis[0][i]) * points->volume0[p];
    const PetscInt *node   = &space->node[nodes[i] * dim];
    PetscReal      *to     = &sums[nodes[i] * (components + 1)];

    for (PetscInt c = 0; c < components; c++) {
      PetscReal at_node = value[c];

      for (PetscInt b = 0; gradient && b < dim; b++)
        at_node += gradient[c * dim + b] * (grid->lower[b] + grid->h[b] * (PetscReal)node[b] - points->x[p * dim + b]);
      to[c] += weight * at_node;
    }
    to[components] += weight;
  }
}

PetscErrorCode MpmProjectToNodes(const MpmSpace *space, const MpmGrid *grid, const MpmPoints *points,
                                 PetscInt components, PetscInt stride, const PetscReal value[],
                                 const PetscReal gradient[], PetscReal nodal[])
{
  const PetscInt most = PetscPowInt(space->width, space->dim), n = components + 1;
  PetscReal     *sums, *storage;
  MpmBasis       basis;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((space->local * n), &sums));
  PetscCall(PetscMalloc1((most * (MPM_MAX_DIM + 1)), &storage));
  for (PetscInt b = 0; b <= MPM_MAX_DIM; b++) basis.basis[b] = storage + most * b;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s];

      MpmSpaceEvaluate(space, group, p, &basis);
      AddPoint(space, grid, group, points, p, &basis, components, &value[p * stride],
               gradient ? &gradient[p * stride] : NULL, sums);
    }
  }
  PetscCall(MpmSpaceAddToOwners(space, n, sums));
  for (PetscInt k = 0; k < space->owned * components; k++) {
    const PetscReal *sum = &sums[k / components * n];

    nodal[k] = sum[components] > 0. ? sum[k % components] / sum[components] : 0.;
  }
  PetscCall(PetscFree(storage));
  PetscCall(PetscFree(sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}
