/*
  Mass and momentum between points and nodes.

  The affine velocity of a point, dim x dim numbers, is the moment

    B_ab = sum_i w_i v_i,a (x_i - x_p)_b ,      C_ab = B_ab / D_b ,    D_b = sum_i w_i (x_i - x_p)_b^2

  for splines of degree 2 and 3, whose D hardly depends on the point's place: the angular momentum of B is kept when D
  changes with the point's domain. With linear basis functions D goes from 0 to h^2/4 within a cell; there the gradient
  C itself is carried, and a rotation stays one. D is diagonal, for weights are products and reproduce linear fields.
*/
#include "transfer/carry.h"
#include "transfer/momentum.h"
#include "transfer/motion.h"

const char *const MpmTransferTypes[] = {"apic", "flip", NULL};

/* Adds m x v, and the moment m sum_b eps_cab B_ab of the affine part. */
MPM_INLINE void AddAngular(PetscInt dim, PetscReal mass, const PetscReal x[], const PetscReal v[], const PetscReal *B,
                           PetscReal angular[])
{
  for (PetscInt c = 0; c < 3; c++) {
    const PetscInt a = (c + 1) % 3, b = (c + 2) % 3;

    if (a >= dim || b >= dim) continue;
    angular[c] += mass * (x[a] * v[b] - x[b] * v[a] + (B ? B[b * dim + a] - B[a * dim + b] : 0.));
  }
}

MPM_INLINE PetscErrorCode SumGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                   const MpmTransfer *transfer, MpmMotionSums *sums)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = known.dim;
  const PetscBool  affine = (PetscBool)(transfer->type == MPM_TRANSFER_APIC);
  PetscInt         first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt  p    = sum->space->order[s];
    const PetscReal mass = MpmPointMass(points, sum->materials, p), *v = &points->motion.velocity[p * dim];
    PetscReal       C[MPM_MAX_DIM * MPM_MAX_DIM], B[MPM_MAX_DIM * MPM_MAX_DIM];
    PetscReal       square = 0.; /* of the velocity, over the point */
    MpmStencil      at;

    sums->mass += mass;
    for (PetscInt a = 0; a < dim; a++) {
      sums->momentum[a] += mass * v[a];
      square += v[a] * v[a];
    }
    if (affine) {
      MpmStencilPlace(known, sum, first, p, &at);
      MpmPointAffine(known, sum, transfer, p, at.second, C);
      for (PetscInt k = 0; k < dim * dim; k++) {
        B[k] = C[k] * at.second[k % dim];
        square += C[k] * B[k];
      }
    }
    sums->kinetic += 0.5 * mass * square;
    AddAngular(dim, mass, &points->x[p * dim], v, affine ? B : NULL, sums->angular);
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmMotionSum(const MpmSum *sum, const MpmTransfer *transfer, MpmMotionSums *sums)
{
  MpmMotionSums total = {.mass = 0.}; /* in registers */

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    MPM_DISPATCH(sum->layout, &sum->space->groups[g], SumGroup, sum, &sum->space->groups[g], transfer, &total);
  *sums = total;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpinAtPoint(const MpmSum *sum, PetscInt group, PetscInt point, const PetscReal v[], PetscReal W[])
{
  const MpmGroup *of    = &sum->space->groups[group];
  const PetscInt *nodes = &sum->space->group_nodes[of->node_offset], dim = sum->space->dim, n = of->node_count;
  PetscReal      *values;
  MpmBasis        basis;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((n * dim), &values));
  PetscCall(MpmBasisCreate(sum->space, &basis));
  MpmSpaceEvaluate(sum->space, of, point, &basis);
  for (PetscInt k = 0; k < n * dim; k++) values[k] = v[nodes[k % n] * dim + k / n];
  for (PetscInt a = 0; a < dim; a++)
    for (PetscInt b = 0; b < dim; b++)
      W[a * dim + b] =
        0.5 * (MpmBasisDerivative(&basis, n, b, &values[a * n]) - MpmBasisDerivative(&basis, n, a, &values[b * n]));
  PetscCall(MpmBasisDestroy(&basis));
  PetscCall(PetscFree(values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStiffnessRows(const MpmSum *sum, PetscReal rows[])
{
  const MpmSpace  *space  = sum->space;
  const MpmPoints *points = sum->points;
  const PetscInt   dim = space->dim, most = PetscPowInt(space->width, dim);
  PetscReal       *size;
  MpmBasis         basis;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(rows, space->local));
  PetscCall(PetscMalloc1(most, &size));
  PetscCall(MpmBasisCreate(space, &basis));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const PetscInt *nodes = &space->group_nodes[group->node_offset];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt     p        = space->order[s];
      const MpmMaterial *material = &sum->materials[points->material[p]];
      const PetscReal    speed    = MpmMaterialWaveSpeed(material, MpmPointOwn(points, material, p), dim,
                                                   points->state ? &points->state[p * sum->kept.state] : NULL,
                                                         MpmPointF(points, p), &points->stress[p * MpmSymSize(dim)]);
      PetscReal          total;

      MpmSpaceEvaluate(space, group, p, &basis);
      total = MpmBasisGradients(space, group, &basis, size) * MpmPointMass(points, sum->materials, p) * speed * speed;
      for (PetscInt i = 0; i < group->node_count; i++) rows[nodes[i]] += total * size[i];
    }
  }
  PetscCall(MpmBasisDestroy(&basis));
  PetscCall(PetscFree(size));
  PetscCall(MpmSpaceAddToOwners(space, 1, rows));
  PetscCall(MpmSpaceToGhosts(space, 1, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}
