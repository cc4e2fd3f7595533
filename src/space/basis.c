/*
  Sums with the basis functions of a point, outside of the loops over all points.
*/
#include "space/basis.h"
#include "space/point_loop.h"

PetscErrorCode MpmBasisCreate(const MpmSpace *space, MpmBasis *basis)
{
  const PetscInt n = PetscPowInt(space->width, space->dim);
  PetscReal     *storage;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((n * MpmBasisCount(space)), &storage));
  MpmBasisPlace(space, n, storage, basis);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBasisDestroy(MpmBasis *basis)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(basis->basis[0]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmSpaceSmoothBasis(const MpmSpace *space, const PetscInt count[], PetscInt shape, PetscInt point,
                         PetscReal *const basis[])
{
  const MpmWeights *const of  = &space->shapes.at[shape];
  const PetscInt          dim = space->dim;
  const MpmLines          w   = MpmPointLines(dim, space, of->weight, point, &MpmLineOne);
  const MpmLines          c   = MpmPointLines(dim, space, of->cross, point, &MpmLineOne);
  const MpmLines          d   = MpmPointLines(dim, space, of->slope, point, &MpmLineZero);
  PetscInt                n   = 0;

  for (PetscInt l = 0; l < count[2]; l++) {
    for (PetscInt j = 0; j < count[1]; j++) {
      for (PetscInt k = 0; k < count[0]; k++, n++) {
        basis[0][n] = w.along[0][k] * w.along[1][j] * w.along[2][l];
        basis[1][n] = d.along[0][k] * c.along[1][j] * c.along[2][l];
        basis[2][n] = c.along[0][k] * d.along[1][j] * c.along[2][l];
        if (dim == MPM_MAX_DIM) basis[3][n] = c.along[0][k] * c.along[1][j] * d.along[2][l];
      }
    }
  }
}

/* Nothing but the nodes of a group. */
static MpmKnown NodesOf(const MpmSpace *space, const MpmGroup *group)
{
  return (MpmKnown){
    .dim = space->dim, .count = {group->count[0], group->count[1], group->count[2]}, .n = group->node_count};
}

void MpmSpaceEvaluate(const MpmSpace *space, const MpmGroup *group, PetscInt point, MpmBasis *basis)
{
  MpmShapeBasis(NodesOf(space, group), space, 0, point, PETSC_TRUE, basis->basis);
}

void MpmBasisInterpolate(const MpmSpace *space, const MpmGroup *group, const MpmBasis *basis, PetscInt stride,
                         const PetscReal u[], PetscInt components, PetscReal value[])
{
  const PetscInt *nodes = &space->group_nodes[group->node_offset];

  for (PetscInt c = 0; c < components; c++)
    for (PetscInt i = 0; i < group->node_count; i++) value[c] += basis->basis[0][i] * u[nodes[i] * stride + c];
}

PetscReal MpmBasisMarked(const MpmSpace *space, const MpmGroup *group, const MpmBasis *basis, const PetscBool mark[])
{
  const PetscInt *nodes = &space->group_nodes[group->node_offset];
  PetscReal       sum   = 0.;

  for (PetscInt i = 0; i < group->node_count; i++)
    if (nodes[i] >= 0 && mark[nodes[i]]) sum += basis->basis[0][i];
  return sum;
}

PetscReal MpmBasisGradients(const MpmSpace *space, const MpmGroup *group, const MpmBasis *basis, PetscReal size[])
{
  PetscReal total = 0.;

  for (PetscInt i = 0; i < group->node_count; i++) {
    size[i] = 0.;
    for (PetscInt a = 0; a < space->dim; a++) size[i] += PetscSqr(basis->basis[1 + a][i]);
    size[i] = PetscSqrtReal(size[i]);
    total += size[i];
  }
  return total;
}

void MpmBasisList(const MpmLayout *layout, const MpmBasis *basis, MpmBases list)
{
  for (PetscInt c = 0; c < layout->block; c++)
    for (PetscInt k = 0; k <= layout->dim; k++)
      list[c * (layout->dim + 1) + k] = basis->basis[layout->component[c].shape * MPM_BASES + k];
}

/* Places of node i of a group along the axes. */
static void NodeAt(const MpmGroup *group, PetscInt i, PetscInt at[MPM_MAX_DIM])
{
  at[0] = i % group->count[0];
  at[1] = i / group->count[0] % group->count[1];
  at[2] = i / (group->count[0] * group->count[1]);
}

PetscReal MpmSpaceWeightAcross(const MpmSpace *space, const MpmGroup *group, PetscInt point, PetscInt axis, PetscInt i)
{
  PetscInt  at[MPM_MAX_DIM];
  PetscReal weight = 1.;

  NodeAt(group, i, at);
  for (PetscInt a = 0; a < space->dim; a++)
    if (a != axis) weight *= space->shapes.at[0].weight[(point * space->dim + a) * space->width + at[a]];
  return weight;
}

PetscBool MpmSpaceTouches(const MpmSpace *space, const MpmGroup *group, PetscInt point, PetscInt i, const PetscReal h[],
                          PetscReal graze)
{
  PetscInt at[MPM_MAX_DIM];

  NodeAt(group, i, at);
  for (PetscInt a = 0; a < space->dim; a++) {
    const PetscInt k = (point * space->dim + a) * space->width + at[a];

    if (PetscAbsReal(space->shapes.at[0].weight[k]) <= graze &&
        PetscAbsReal(space->shapes.at[0].gradient[k]) * h[a] <= graze)
      return PETSC_FALSE;
  }
  return PETSC_TRUE;
}
