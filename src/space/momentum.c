/*
  Mass and momentum between points and nodes.

  The affine part of a point's velocity, dim x dim numbers, is the moment

    B_ab = sum_i w_i v_i,a (x_i - x_p)_b ,      C_ab = B_ab / D_b ,    D_b = sum_i w_i (x_i - x_p)_b^2

  for splines of degree 2 and 3, whose D hardly depends on the point's place: the angular momentum that B holds is kept when
  D changes with the point's domain. With linear basis functions D goes from 0 to h^2/4 within a cell; there the gradient C
  itself is carried, and a rotation stays one. D is diagonal, for weights are products and reproduce linear fields.
*/
#include "space/momentum.h"
#include "space/stencil.h"

const char *const MpmTransferTypes[] = {"apic", "flip", NULL};

typedef struct {
  const MpmTransfer *transfer;
  PetscReal         *storage, *sums;
  const PetscReal   *v_old, *v_new, *a_new;
  PetscReal         *gathered; /* [c][i], of v_new - v_old, v_new, a_new */
  MpmStencil         at;
} Work;

static PetscErrorCode WorkCreate(const MpmSum *sum, const MpmTransfer *transfer, Work *work)
{
  const PetscInt most = PetscPowInt(sum->space->width, sum->space->dim), dim = sum->space->dim;

  PetscFunctionBeginUser;
  work->transfer = transfer;
  PetscCall(PetscMalloc1((most * (2 + 5 * dim)), &work->storage));
  work->at.weight = work->storage;
  work->sums      = work->at.weight + most;
  work->gathered  = work->sums + most * (1 + 2 * dim);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The sums of one group: [c][i], mass first, then momentum, then mass times acceleration. */
MPM_INLINE PetscErrorCode ToNodes(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, PetscInt numbers,
                                  Work *work, PetscReal nodal[])
{
  const MpmPoints *points = sum->points;
  const PetscInt   n = known.n, dim = known.dim;
  const PetscInt  *nodes  = &sum->space->group_nodes[group->node_offset];
  const PetscBool  affine = (PetscBool)(work->transfer->type == MPM_TRANSFER_APIC);
  PetscInt         first[MPM_MAX_DIM];

  MpmSpaceAt(sum->space, group->first, first);
  for (PetscInt k = 0; k < n * numbers; k++) work->sums[k] = 0.;
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt  p = sum->space->order[s], ahead = MpmSumAhead(sum, s);
    const PetscReal mass = MpmPointMass(points, sum->materials, p);
    PetscReal       C[MPM_MAX_DIM * MPM_MAX_DIM];

    MpmFetch(sum->space->shape[0].weight, ahead, dim * sum->space->width);
    MpmFetch(points->x, ahead, dim);
    MpmFetch(points->velocity, ahead, dim);
    MpmStencilEvaluate(known, sum, first, p, &work->at);
    if (affine) MpmStencilAffine(known, sum, work->transfer, p, work->at.second, C);
    for (PetscInt i = 0; i < n; i++) work->sums[i] += mass * work->at.weight[i];
    if (numbers > 1)
      MpmStencilAddMomentum(known, mass, &points->velocity[p * dim], affine ? C : NULL, &work->at, work->sums + n);
    if (numbers > 1 + dim)
      MpmStencilAddMomentum(known, mass, &points->acceleration[p * dim], NULL, &work->at, work->sums + n * (1 + dim));
  }
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c < numbers; c++) nodal[nodes[i] * numbers + c] += work->sums[c * n + i];
  return PETSC_SUCCESS;
}

PetscErrorCode MpmMomentumToNodes(const MpmSum *sum, const MpmTransfer *transfer, PetscReal mass[],
                                  PetscReal velocity[], PetscReal acceleration[])
{
  const MpmSpace *space   = sum->space;
  const PetscInt  dim     = space->dim;
  const PetscInt  numbers = 1 + (velocity ? dim : 0) + (acceleration ? dim : 0);
  PetscReal      *nodal;
  Work            work;

  PetscFunctionBeginUser;
  PetscCall(WorkCreate(sum, transfer, &work));
  PetscCall(PetscCalloc1((space->local * numbers), &nodal));
  for (PetscInt g = 0; g < space->group_count; g++)
    MPM_DISPATCH(sum->layout, &space->groups[g], ToNodes, sum, &space->groups[g], numbers, &work, nodal);
  PetscCall(MpmSpaceAddToOwners(space, numbers, nodal));
  PetscCall(MpmSpaceToGhosts(space, numbers, nodal));
  for (PetscInt i = 0; i < space->local; i++) {
    const PetscReal *at = &nodal[i * numbers], by = at[0] > 0. ? 1. / at[0] : 0.;

    mass[i] = at[0];
    for (PetscInt a = 0; velocity && a < dim; a++) velocity[i * dim + a] = by * at[1 + a];
    for (PetscInt a = 0; acceleration && a < dim; a++) acceleration[i * dim + a] = by * at[1 + dim + a];
  }
  PetscCall(PetscFree(nodal));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- and back ---- */

MPM_INLINE PetscErrorCode ToPoints(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, Work *work)
{
  const MpmPoints *points = sum->points;
  const PetscInt   n = known.n, dim = known.dim;
  const PetscInt  *nodes  = &sum->space->group_nodes[group->node_offset];
  const PetscBool  apic   = (PetscBool)(work->transfer->type == MPM_TRANSFER_APIC);
  const PetscReal  pic    = apic ? 1. : work->transfer->pic;
  PetscReal       *change = work->gathered, *v_new = change + n * dim, *a_new = v_new + n * dim;
  PetscInt         first[MPM_MAX_DIM];

  MpmSpaceAt(sum->space, group->first, first);
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt c = 0; c < dim; c++) {
      const PetscInt k = nodes[i] * dim + c;

      v_new[c * n + i]  = work->v_new[k];
      change[c * n + i] = work->v_new[k] - work->v_old[k];
      if (work->a_new) a_new[c * n + i] = work->a_new[k];
    }
  }
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s);
    PetscReal     *v = &points->velocity[p * dim];

    MpmFetch(sum->space->shape[0].weight, ahead, dim * sum->space->width);
    MpmFetch(points->velocity, ahead, dim);
    MpmStencilEvaluate(known, sum, first, p, &work->at);
    if (apic) MpmStencilLines(known, sum, p, work->transfer->degree, &work->at);
    for (PetscInt c = 0; c < dim; c++) {
      PetscReal kept = 0., taken = 0.;

      if (pic < 1.) kept = v[c] + MpmStencilInterpolate(known, sum, p, &work->at, &change[c * n], NULL);
      if (pic > 0.)
        taken = MpmStencilInterpolate(known, sum, p, &work->at, &v_new[c * n],
                                      apic ? &points->affine[(p * dim + c) * dim] : NULL);
      v[c] = (1. - pic) * kept + pic * taken;
      if (work->a_new)
        points->acceleration[p * dim + c] = MpmStencilInterpolate(known, sum, p, &work->at, &a_new[c * n], NULL);
    }
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmMomentumToPoints(const MpmSum *sum, const MpmTransfer *transfer, const PetscReal v_old[],
                                   const PetscReal v_new[], const PetscReal a_new[])
{
  Work work;

  PetscFunctionBeginUser;
  PetscCall(WorkCreate(sum, transfer, &work));
  work.v_old = v_old;
  work.v_new = v_new;
  work.a_new = a_new;
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    MPM_DISPATCH(sum->layout, &sum->space->groups[g], ToPoints, sum, &sum->space->groups[g], &work);
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- sums ---- */

/* Adds m x v, and the moment m sum_b eps_cab B_ab of the affine part. */
static void AddAngular(PetscInt dim, PetscReal mass, const PetscReal x[], const PetscReal v[], const PetscReal *B,
                       PetscReal angular[])
{
  for (PetscInt c = dim == 2 ? 2 : 0; c < 3; c++) {
    const PetscInt a = (c + 1) % 3, b = (c + 2) % 3;

    angular[c] += mass * (x[a] * v[b] - x[b] * v[a]);
    if (B) angular[c] += mass * (B[b * dim + a] - B[a * dim + b]);
  }
}

/* D_b alone */
static void SecondMoments(const MpmSum *sum, const MpmGroup *group, const PetscInt first[], PetscInt p,
                          PetscReal second[])
{
  const PetscInt dim = sum->space->dim, W = sum->space->width;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal *w     = &sum->space->shape[0].weight[(p * dim + a) * W];
    const PetscReal  start = sum->grid->lower[a] + sum->grid->h[a] * (PetscReal)first[a] - sum->points->x[p * dim + a];

    second[a] = 0.;
    for (PetscInt k = 0; k < group->count[a]; k++) second[a] += w[k] * PetscSqr(start + sum->grid->h[a] * (PetscReal)k);
  }
}

PetscErrorCode MpmMotionSum(const MpmSum *sum, const MpmTransfer *transfer, MpmMotionSums *sums)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = sum->space->dim;
  const PetscBool  affine = (PetscBool)(transfer->type == MPM_TRANSFER_APIC);
  Work             work;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(sums, sizeof(*sums)));
  PetscCall(WorkCreate(sum, transfer, &work));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    PetscInt        first[MPM_MAX_DIM];

    MpmSpaceAt(sum->space, group->first, first);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt  p    = sum->space->order[s];
      const PetscReal mass = MpmPointMass(points, sum->materials, p), *v = &points->velocity[p * dim];
      PetscReal       C[MPM_MAX_DIM * MPM_MAX_DIM], B[MPM_MAX_DIM * MPM_MAX_DIM];

      sums->mass += mass;
      for (PetscInt a = 0; a < dim; a++) {
        sums->momentum[a] += mass * v[a];
        sums->kinetic += 0.5 * mass * v[a] * v[a];
      }
      if (affine) {
        const MpmKnown known = KnownGeneral(sum->layout, group);

        SecondMoments(sum, group, first, p, work.at.second);
        MpmStencilAffine(known, sum, transfer, p, work.at.second, C);
        for (PetscInt k = 0; k < dim * dim; k++) {
          B[k] = C[k] * work.at.second[k % dim];
          sums->kinetic += 0.5 * mass * C[k] * B[k];
        }
      }
      AddAngular(dim, mass, &points->x[p * dim], v, affine ? B : NULL, sums->angular);
    }
  }
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
