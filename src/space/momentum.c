/*
  Mass and momentum between points and nodes.

  The affine part of a point's velocity, dim x dim numbers, is the moment

    B_ab = sum_i w_i v_i,a (x_i - x_p)_b ,      C_ab = B_ab / D_b ,    D_b = sum_i w_i (x_i - x_p)_b^2

  for splines of degree 2 and 3, whose D hardly depends on the point's place: the angular momentum that B holds is kept when
  D changes with the point's domain. With linear basis functions D goes from 0 to h^2/4 within a cell; there the gradient C
  itself is carried, and a rotation stays one. D is diagonal, for weights are products and reproduce linear fields.
*/
#include "grid/grid.h"
#include "space/momentum.h"
#include "space/point_loop.h"

const char *const MpmTransferTypes[] = {"apic", "flip", NULL};

/* A second moment below this part of a cell's square is no base for a quotient: points on an edge of the grid. */
#define THIN 1e-2

/* One point's weights at its group's nodes, and where these stand from it along each axis. */
typedef struct {
  PetscReal *weight;                           /* of all nodes, x fastest */
  PetscReal  away[MPM_MAX_DIM][MPM_MAX_WIDTH]; /* m */
  PetscReal  second[MPM_MAX_DIM];              /* D_b, m2 */
  PetscReal  line[MPM_MAX_DIM][MPM_MAX_WIDTH]; /* what takes the weights' place along an axis for the affine part */
} Stencil;

typedef struct {
  const MpmTransfer *transfer;
  PetscReal         *storage, *sums;
  const PetscReal   *v_old, *v_new, *a_new;
  PetscReal         *gathered; /* [c][i], of v_new - v_old, v_new, a_new */
  Stencil            at;
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

MPM_INLINE void EvaluateStencil(const MpmKnown known, const MpmSum *sum, const PetscInt first[], PetscInt p,
                                Stencil *at)
{
  const MpmGrid   *grid = sum->grid;
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *w = &sum->space->shape[0].weight[p * dim * W], *x = &sum->points->x[p * dim];
  PetscReal       *weight = at->weight;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal start = grid->lower[a] + grid->h[a] * (PetscReal)first[a] - x[a];

    at->second[a] = 0.;
    for (PetscInt k = 0; k < known.count[a]; k++) {
      at->away[a][k] = start + grid->h[a] * (PetscReal)k;
      at->second[a] += w[a * W + k] * at->away[a][k] * at->away[a][k];
    }
  }
  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    for (PetscInt j = 0; j < known.count[1]; j++, weight += known.count[0]) {
      const PetscReal row = dim == 2 ? w[W + j] : w[W + j] * w[2 * W + l];

      for (PetscInt k = 0; k < known.count[0]; k++) weight[k] = w[k] * row;
    }
  }
}

/* C, by which the point's velocity varies */
MPM_INLINE void Affine(const MpmKnown known, const MpmSum *sum, const MpmTransfer *transfer, PetscInt p,
                       const PetscReal second[], PetscReal C[])
{
  const PetscInt   dim = known.dim;
  const PetscReal *B   = &sum->points->affine[p * dim * dim];

  for (PetscInt b = 0; b < dim; b++) {
    const PetscReal h2 = PetscSqr(sum->grid->h[b]);
    const PetscReal by = transfer->degree < 2 ? 1. : 1. / PetscMax(second[b], THIN * h2);

    for (PetscInt a = 0; a < dim; a++) C[a * dim + b] = by * B[a * dim + b];
  }
}

/* sums[c][i] += w_i m (v_c + C_c. (x_i - x_p)) */
MPM_INLINE void AddMomentum(const MpmKnown known, const PetscReal mass, const PetscReal v[], const PetscReal *C,
                            const Stencil *at, PetscReal sums[])
{
  const PetscInt dim = known.dim;

  for (PetscInt c = 0; c < dim; c++) {
    PetscReal *restrict to = &sums[c * known.n];
    const PetscReal *w     = at->weight;

    for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
      for (PetscInt j = 0; j < known.count[1]; j++, w += known.count[0], to += known.count[0]) {
        PetscReal row = mass * v[c];

        if (C) row += mass * C[c * dim + 1] * at->away[1][j];
        if (C && dim == 3) row += mass * C[c * dim + 2] * at->away[2][l];
        if (C) {
          const PetscReal slope = mass * C[c * dim];

          for (PetscInt k = 0; k < known.count[0]; k++) to[k] += w[k] * (row + slope * at->away[0][k]);
        } else {
          for (PetscInt k = 0; k < known.count[0]; k++) to[k] += w[k] * row;
        }
      }
    }
  }
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
    EvaluateStencil(known, sum, first, p, &work->at);
    if (affine) Affine(known, sum, work->transfer, p, work->at.second, C);
    for (PetscInt i = 0; i < n; i++) work->sums[i] += mass * work->at.weight[i];
    if (numbers > 1) AddMomentum(known, mass, &points->velocity[p * dim], affine ? C : NULL, &work->at, work->sums + n);
    if (numbers > 1 + dim)
      AddMomentum(known, mass, &points->acceleration[p * dim], NULL, &work->at, work->sums + n * (1 + dim));
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

/* What a pass over the nodes sums along each axis beside the weights: a point's affine velocity. */
MPM_INLINE void AffineLines(const MpmKnown known, const MpmSum *sum, PetscInt p, PetscInt degree, Stencil *at)
{
  const PetscInt dim = known.dim, W = sum->space->width;

  for (PetscInt b = 0; b < dim; b++) {
    const PetscReal *w    = &sum->space->shape[0].weight[(p * dim + b) * W];
    const PetscReal *g    = &sum->space->shape[0].gradient[(p * dim + b) * W];
    const PetscBool  thin = (PetscBool)(degree < 2 && at->second[b] < THIN * PetscSqr(sum->grid->h[b]));
    const PetscReal  by   = degree < 2 && !thin ? 1. / at->second[b] : 1.;

    for (PetscInt k = 0; k < known.count[b]; k++) at->line[b][k] = thin ? g[k] : by * w[k] * at->away[b][k];
  }
}

/* One component of the nodes' values at a point, and its affine part where `affine` is not NULL. */
MPM_INLINE PetscReal Interpolate(const MpmKnown known, const MpmSum *sum, PetscInt p, const Stencil *at,
                                 const PetscReal values[], PetscReal *affine)
{
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *w[MPM_MAX_DIM] = {&sum->space->shape[0].weight[p * dim * W], NULL, NULL};
  PetscReal        total = 0., by[MPM_MAX_DIM] = {0.};

  w[1] = w[0] + W;
  w[2] = w[1] + W;
  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    for (PetscInt j = 0; j < known.count[1]; j++, values += known.count[0]) {
      PetscReal row = 0., moment = 0.;

      for (PetscInt k = 0; k < known.count[0]; k++) row += w[0][k] * values[k];
      total += (dim == 2 ? w[1][j] : w[1][j] * w[2][l]) * row;
      if (!affine) continue;
      for (PetscInt k = 0; k < known.count[0]; k++) moment += at->line[0][k] * values[k];
      by[0] += (dim == 2 ? w[1][j] : w[1][j] * w[2][l]) * moment;
      by[1] += (dim == 2 ? at->line[1][j] : at->line[1][j] * w[2][l]) * row;
      if (dim == 3) by[2] += w[1][j] * at->line[2][l] * row;
    }
  }
  for (PetscInt b = 0; affine && b < dim; b++) affine[b] = by[b];
  return total;
}

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
    EvaluateStencil(known, sum, first, p, &work->at);
    if (apic) AffineLines(known, sum, p, work->transfer->degree, &work->at);
    for (PetscInt c = 0; c < dim; c++) {
      PetscReal kept = 0., taken = 0.;

      if (pic < 1.) kept = v[c] + Interpolate(known, sum, p, &work->at, &change[c * n], NULL);
      if (pic > 0.)
        taken =
          Interpolate(known, sum, p, &work->at, &v_new[c * n], apic ? &points->affine[(p * dim + c) * dim] : NULL);
      v[c] = (1. - pic) * kept + pic * taken;
      if (work->a_new) points->acceleration[p * dim + c] = Interpolate(known, sum, p, &work->at, &a_new[c * n], NULL);
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
        Affine(known, sum, transfer, p, work.at.second, C);
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
