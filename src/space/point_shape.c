/*
  The scene's shape functions of one point, for those who act on single points: loads, and facets in contact.
*/
#include "space/point_shape.h"
#include "space/sum.h"

void MpmPointLine(const MpmSpace *space, PetscInt p, PetscInt a, PetscInt count, PetscReal way, PetscReal line[])
{
  const PetscReal *weight   = &space->shapes.at[0].weight[(p * space->dim + a) * space->width];
  const PetscReal *gradient = &space->shapes.at[0].gradient[(p * space->dim + a) * space->width];

  for (PetscInt i = 0; i < count; i++) line[i] = weight[i] + way * gradient[i];
}

void MpmPointAddSlope(const MpmSpace *space, PetscInt p, PetscInt a, PetscInt count, PetscReal way, PetscReal line[])
{
  const PetscReal *gradient = &space->shapes.at[0].gradient[(p * space->dim + a) * space->width];

  for (PetscInt i = 0; i < count; i++) line[i] += way * gradient[i];
}

void MpmLinesMultiply(PetscInt dim, const MpmGroup *group, PetscReal (*line)[MPM_MAX_WIDTH], PetscReal weight[])
{
  for (PetscInt a = dim; a < MPM_MAX_DIM; a++)
    for (PetscInt i = 0; i < group->count[a]; i++) line[a][i] = 1.;
  for (PetscInt k = 0; k < group->count[2]; k++)
    for (PetscInt j = 0; j < group->count[1]; j++)
      for (PetscInt i = 0; i < group->count[0]; i++) *weight++ = line[0][i] * line[1][j] * line[2][k];
}

void MpmBasisGradient(const MpmBasis *basis, const MpmGroup *group, const MpmSum *sum, const PetscReal u[],
                      PetscReal gradient[3][3])
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset], dim = sum->space->dim;

  for (PetscInt c = 0; c < 3; c++) {
    for (PetscInt d = 0; d < 3; d++) {
      gradient[c][d] = 0.;
      for (PetscInt i = 0; c < dim && d < dim && i < group->node_count; i++)
        gradient[c][d] += basis->basis[1 + d][i] * u[nodes[i] * sum->block + c];
    }
  }
}

PetscReal MpmBasisSlope(const MpmBasis *basis, PetscInt dim, PetscInt i, const PetscReal along[])
{
  PetscReal slope = 0.;

  for (PetscInt l = 0; l < dim; l++) slope += along[l] * basis->basis[1 + l][i];
  return slope;
}

void MpmWeightsAdd(const PetscReal weight[], const MpmGroup *group, const MpmSum *sum, PetscReal factor,
                   const PetscReal value[], PetscReal y[])
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset], axes = PetscMin(sum->space->dim, sum->block);

  for (PetscInt i = 0; i < group->node_count; i++)
    for (PetscInt a = 0; a < axes; a++) y[nodes[i] * sum->block + a] += factor * weight[i] * value[a];
}

void MpmPointAddForce(const MpmSum *sum, const MpmBasis *basis, const MpmGroup *group, PetscInt p,
                      const MpmPointForce *force, PetscReal y[])
{
  static const PetscInt pair[6][2] = {{0, 0}, {1, 1}, {0, 1}, {2, 2}, {1, 2}, {0, 2}}; /* axes of the stress */
  const PetscInt        dim        = sum->space->dim;
  const PetscInt       *nodes      = &sum->space->group_nodes[group->node_offset];
  const PetscReal       hoop       = MpmSpaceHoop(sum->space, p);

  for (PetscInt i = 0; i < group->node_count; i++) {
    PetscReal *at = &y[nodes[i] * sum->block];

    for (PetscInt a = 0; a < dim; a++) at[a] += force->body[a] * basis->basis[0][i];
    for (PetscInt c = 0; c < dim * (dim + 1) / 2; c++) {
      const PetscInt a = pair[c][0], b = pair[c][1];

      at[a] -= force->volume * force->stress[c] * basis->basis[1 + b][i];
      if (a != b) at[b] -= force->volume * force->stress[c] * basis->basis[1 + a][i];
    }
    if (hoop > 0.) at[0] -= force->volume * force->stress[3] * hoop * basis->basis[0][i];
  }
}
