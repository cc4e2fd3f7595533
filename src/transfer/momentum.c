/*
  Mass and momentum between points and nodes.

  The affine velocity of a point, dim x dim numbers, is the moment

    B_ab = sum_i w_i v_i,a (x_i - x_p)_b ,      C_ab = B_ab / D_b ,    D_b = sum_i w_i (x_i - x_p)_b^2

  for splines of degree 2 and 3, whose D hardly depends on the point's place: the angular momentum of B is kept when D
  changes with the point's domain. With linear basis functions D goes from 0 to h^2/4 within a cell; there the gradient
  C itself is carried, and a rotation stays one. D is diagonal, for weights are products and reproduce linear fields.
*/
#include "point/material.h"
#include "particles/point_mass.h"
#include "transfer/momentum.h"
#include "transfer/motion.h"
#include "transfer/stencil.h"

const char *const MpmTransferTypes[] = {"apic", "flip", NULL};

/* Adds m x v, and the moment m sum_b eps_cab B_ab of the affine part. */
MPM_INLINE void AddAngular(PetscInt dim, PetscReal mass, const PetscReal x[], const PetscReal v[], const PetscReal *B,
                           PetscReal angular[])
{
  for (PetscInt c = dim == 2 ? 2 : 0; c < 3; c++) {
    const PetscInt a = (c + 1) % 3, b = (c + 2) % 3;

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
    const PetscReal mass = MpmPointMass(points, sum->materials, p), *v = &points->velocity[p * dim];
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
      MpmStencilAffine(known, sum, transfer, p, at.second, C);
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
  const MpmKnown  known = KnownGeneral(sum->layout, of);
  const PetscInt *nodes = &sum->space->group_nodes[of->node_offset], dim = known.dim, n = known.n;
  PetscReal      *storage, *basis[1 + MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((n * (1 + MPM_MAX_DIM)), &storage));
  for (PetscInt b = 0; b <= MPM_MAX_DIM; b++) basis[b] = &storage[b * n];
  MpmShapeBasis(known, sum->space, 0, point, PETSC_FALSE, basis);
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim; b++) {
      W[a * dim + b] = 0.;
      for (PetscInt i = 0; i < n; i++)
        W[a * dim + b] += 0.5 * (v[nodes[i] * dim + a] * basis[1 + b][i] - v[nodes[i] * dim + b] * basis[1 + a][i]);
    }
  }
  PetscCall(PetscFree(storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStiffnessRows(const MpmSum *sum, PetscReal rows[])
{
  const MpmSpace  *space  = sum->space;
  const MpmPoints *points = sum->points;
  const PetscInt   dim = space->dim, most = PetscPowInt(space->width, dim);
  PetscReal       *storage, *basis[1 + MPM_MAX_DIM], *size;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(rows, space->local));
  PetscCall(PetscMalloc1((most * (2 + MPM_MAX_DIM)), &storage));
  for (PetscInt b = 0; b <= MPM_MAX_DIM; b++) basis[b] = &storage[b * most];
  size = &storage[(1 + MPM_MAX_DIM) * most];
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const MpmKnown  known = KnownGeneral(sum->layout, group);
    const PetscInt *nodes = &space->group_nodes[group->node_offset];

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt     p        = space->order[s];
      const MpmMaterial *material = &sum->materials[points->material[p]];
      const PetscReal    speed    = MpmMaterialWaveSpeed(material, MpmPointOwn(points, material, p), dim,
                                                   points->state ? &points->state[p * sum->state_size] : NULL,
                                                         MpmPointF(points, p), &points->stress[p * MpmSymSize(dim)]);
      PetscReal          total    = 0.;

      MpmShapeBasis(known, space, 0, p, PETSC_FALSE, basis);
      for (PetscInt i = 0; i < known.n; i++) {
        size[i] = 0.;
        for (PetscInt a = 0; a < dim; a++) size[i] += PetscSqr(basis[1 + a][i]);
        size[i] = PetscSqrtReal(size[i]);
        total += size[i];
      }
      total *= MpmPointMass(points, sum->materials, p) * speed * speed;
      for (PetscInt i = 0; i < known.n; i++) rows[nodes[i]] += total * size[i];
    }
  }
  PetscCall(PetscFree(storage));
  PetscCall(MpmSpaceAddToOwners(space, 1, rows));
  PetscCall(MpmSpaceToGhosts(space, 1, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}
