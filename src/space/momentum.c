/*
  Mass and momentum between points and nodes.

  The affine velocity of a point, dim x dim numbers, is the moment

    B_ab = sum_i w_i v_i,a (x_i - x_p)_b ,      C_ab = B_ab / D_b ,    D_b = sum_i w_i (x_i - x_p)_b^2

  for splines of degree 2 and 3, whose D hardly depends on the point's place: the angular momentum of B is kept when D
  changes with the point's domain. With linear basis functions D goes from 0 to h^2/4 within a cell; there the gradient
  C itself is carried, and a rotation stays one. D is diagonal, for weights are products and reproduce linear fields.
*/
#include "point/layout.h"
#include "point/material.h"
#include "particles/point_mass.h"
#include "space/momentum.h"
#include "space/motion.h"
#include "space/stencil.h"

const char *const MpmTransferTypes[] = {"apic", "flip", NULL};

/* ---- sums ---- */

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

/*
  ---- return to the points, and explicit transfer to the nodes ----

  The numbers of a node stand side by side in vectors of the processor: a point touches few nodes on an axis, and there
  are as many numbers.
*/
MPM_INLINE Slim Load(PetscInt dim, const PetscReal v[])
{
  return dim == 2 ? (Slim){v[0], v[1], 0., 0.} : (Slim){v[0], v[1], v[2], 0.};
}

/* Of a node in the first pass: momentum, and mass behind it; and force. */
typedef struct {
  Slim moving, force;
} Sums;

/* Stress of a force: V_0 tau, or for a small-strain law with derivatives by the present position. */
MPM_INLINE void PointStress(const MpmKnown known, const MpmSum *sum, PetscInt p, Slim P[])
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = known.dim;
  const PetscReal *F = &points->F[p * dim * dim], *s = &points->stress[p * (dim == 2 ? 4 : 6)];
  const PetscReal  volume   = points->volume0[p];
  const Slim       sigma[3] = {dim == 2 ? (Slim){s[0], s[3], 0., 0.} : (Slim){s[0], s[3], s[5], 0.},
                         dim == 2 ? (Slim){s[3], s[1], 0., 0.} : (Slim){s[3], s[1], s[4], 0.},
                         dim == 2 ? (Slim){0., 0., 0., 0.} : (Slim){s[5], s[4], s[2], 0.}};

  if (sum->materials[points->material[p]].info.traits & MPM_LAW_SMALL_STRAIN) {
    for (PetscInt b = 0; b < dim; b++) {
      P[b] = sigma[0] * (volume * F[b * dim]) + sigma[1] * (volume * F[b * dim + 1]);
      if (dim == 3) P[b] += sigma[2] * (volume * F[b * dim + 2]);
    }
  } else
    for (PetscInt b = 0; b < dim; b++) P[b] = sigma[b] * (volume * MpmDeterminant(dim, F));
}

/* One point's contributions to its nodes: momentum, then mass, their derivatives, and the stress of its force. */
typedef struct {
  Slim momentum, slope[MPM_MAX_DIM], P[MPM_MAX_DIM];
} Carried;

/* A point's weights along x and their products with the distance to the nodes, used by every row of nodes. */
typedef struct {
  PetscReal weight[MPM_MAX_WIDTH], gradient[MPM_MAX_WIDTH], moment[MPM_MAX_WIDTH];
} Row;

/* Mass, momentum and force of one point, added to those of its nodes. */
MPM_INLINE void AddPoint(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmStencil *at, const Carried *of,
                         const PetscInt nodes[], Sums *restrict sums)
{
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *wx = &sum->space->shape[0].weight[p * dim * W], *gx = &sum->space->shape[0].gradient[p * dim * W];
  Row              line;

  for (PetscInt k = 0; k < known.count[0]; k++) {
    line.weight[k]   = wx[k];
    line.gradient[k] = gx[k];
    line.moment[k]   = wx[k] * at->away[0][k];
  }

  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    const PetscReal wz = dim == 2 ? 1. : wx[2 * W + l], gz = dim == 2 ? 0. : gx[2 * W + l];

    for (PetscInt j = 0; j < known.count[1]; j++) {
      const PetscReal w = wx[W + j] * wz, gy = gx[W + j] * wz, g = wx[W + j] * gz;
      Slim            row = of->momentum + of->slope[1] * at->away[1][j], across = of->P[1] * gy;
      const Slim      along = of->P[0] * w, by_away = of->slope[0] * w;

      if (dim == 3) row += of->slope[2] * at->away[2][l];
      if (dim == 3) across += of->P[2] * g;
      row *= w;
      for (PetscInt k = 0; k < known.count[0]; k++) {
        Sums *to = &sums[*nodes++];

        to->moving += row * line.weight[k] + by_away * line.moment[k];
        to->force -= across * line.weight[k] + along * line.gradient[k];
      }
    }
  }
}

/* A point's momentum, its mass behind it, and the derivatives of it that its affine velocity makes. */
MPM_INLINE void Momentum(const MpmKnown known, const MpmSum *sum, const MpmTransfer *transfer, PetscInt p,
                         const MpmStencil *at, Carried *of)
{
  const PetscInt  dim  = known.dim;
  const PetscReal mass = MpmPointMass(sum->points, sum->materials, p), *v = &sum->points->velocity[p * dim];
  PetscReal       C[MPM_MAX_DIM * MPM_MAX_DIM];

  of->momentum =
    dim == 2 ? (Slim){mass * v[0], mass * v[1], mass, 0.} : (Slim){mass * v[0], mass * v[1], mass * v[2], mass};
  if (transfer->type != MPM_TRANSFER_APIC) {
    for (PetscInt b = 0; b < dim; b++) of->slope[b] = (Slim){0.};
    return;
  }
  MpmStencilAffine(known, sum, transfer, p, at->second, C);
  for (PetscInt b = 0; b < dim; b++)
    of->slope[b] = dim == 2 ? (Slim){mass * C[b], mass * C[dim + b], 0., 0.}
                            : (Slim){mass * C[b], mass * C[dim + b], mass * C[2 * dim + b], 0.};
}

MPM_INLINE PetscErrorCode MotionToNodes(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                        const MpmTransfer *transfer, Sums *restrict sums)
{
  PetscInt first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s);
    Carried        of;
    MpmStencil     at;

    MpmSumFetch(known, sum, s);
    MpmFetch(sum->points->x, ahead, known.dim);
    MpmFetch(sum->points->velocity, ahead, known.dim);
    MpmFetch(sum->points->stress, ahead, known.dim == 2 ? 4 : 6);
    if (transfer->type == MPM_TRANSFER_APIC) MpmFetch(sum->points->affine, ahead, known.dim * known.dim);
    MpmStencilPlace(known, sum, first, p, &at);
    Momentum(known, sum, transfer, p, &at, &of);
    PointStress(known, sum, p, of.P);
    AddPoint(known, sum, p, &at, &of, &sum->space->group_nodes[group->node_offset], sums);
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmMotionToNodes(const MpmSum *sum, const MpmTransfer *transfer, PetscReal mass[], PetscReal velocity[],
                                PetscReal force[])
{
  const PetscInt dim = sum->space->dim, local = sum->space->local;
  Sums          *sums;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(local, &sums));
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    MPM_DISPATCH(sum->layout, &sum->space->groups[g], MotionToNodes, sum, &sum->space->groups[g], transfer, sums);
  for (PetscInt i = 0; i < local; i++) sums[i].force += Load(dim, &force[i * dim]);
  PetscCall(MpmSpaceAddToOwners(sum->space, 2 * SLIM, (PetscReal *)sums));
  PetscCall(MpmSpaceToGhosts(sum->space, 2 * SLIM, (PetscReal *)sums));
  for (PetscInt i = 0; i < local; i++) {
    const PetscReal by = sums[i].moving[dim] > 0. ? 1. / sums[i].moving[dim] : 0.;

    mass[i] = sums[i].moving[dim];
    for (PetscInt a = 0; a < dim; a++) velocity[i * dim + a] = by * sums[i].moving[a];
    for (PetscInt a = 0; a < dim; a++) force[i * dim + a] = sums[i].force[a];
  }
  PetscCall(PetscFree(sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- and back ---- */

/* Values at the local nodes, [i][c], and how they go to the points. */
typedef struct {
  const MpmTransfer *transfer;
  Slim              *v_new, *change, *a_new, *again, *affine;
} Gathered;

/* A field at a point, and its moments along the axes where `by` is not NULL. */
MPM_INLINE Slim InterpolateSlim(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmStencil *at,
                                const PetscInt nodes[], const Slim values[], Slim *by)
{
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *wx    = &sum->space->shape[0].weight[p * dim * W];
  Slim             total = {0.}, x = {0.}, y = {0.}, z = {0.};

  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    Slim sheet = {0.}, along = {0.}, across = {0.};

    for (PetscInt j = 0; j < known.count[1]; j++, nodes += known.count[0]) {
      Slim row = values[nodes[0]] * wx[0], moment = {0.};

      for (PetscInt k = 1; k < known.count[0]; k++) row += values[nodes[k]] * wx[k];
      for (PetscInt k = 0; by && k < known.count[0]; k++) moment += values[nodes[k]] * at->line[0][k];
      sheet += row * wx[W + j];
      if (!by) continue;
      along += moment * wx[W + j];
      across += row * at->line[1][j];
    }
    if (dim == 2) {
      total = sheet;
      x     = along;
      y     = across;
    } else {
      total += sheet * wx[2 * W + l];
      x += along * wx[2 * W + l];
      y += across * wx[2 * W + l];
      if (by) z += sheet * at->line[2][l];
    }
  }
  if (by) {
    by[0] = x;
    by[1] = y;
    by[2] = z;
  }
  return total;
}

/* The points' momentum alone, as AddPoint() has it. */
MPM_INLINE void AddAgain(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmStencil *at, const Carried *of,
                         const PetscInt nodes[], Slim *restrict sums)
{
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *wx = &sum->space->shape[0].weight[p * dim * W];
  Row              line;

  for (PetscInt k = 0; k < known.count[0]; k++) {
    line.weight[k] = wx[k];
    line.moment[k] = wx[k] * at->away[0][k];
  }

  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    for (PetscInt j = 0; j < known.count[1]; j++) {
      const PetscReal w       = dim == 2 ? wx[W + j] : wx[W + j] * wx[2 * W + l];
      const Slim      by_away = of->slope[0] * w;
      Slim            row     = of->momentum + of->slope[1] * at->away[1][j];

      if (dim == 3) row += of->slope[2] * at->away[2][l];
      row *= w;
      for (PetscInt k = 0; k < known.count[0]; k++) sums[*nodes++] += row * line.weight[k] + by_away * line.moment[k];
    }
  }
}

/* One point's velocity and acceleration; the stencil's lines are there where it has an affine one. */
MPM_INLINE void MovePoint(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmMotionStep *step,
                          const MpmStencil *at, const PetscInt nodes[], const Gathered *of)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = known.dim;
  const PetscBool  apic   = (PetscBool)(of->transfer->type == MPM_TRANSFER_APIC);
  Slim             by[MPM_MAX_DIM], change, moves;

  if (apic) {
    moves = InterpolateSlim(known, sum, p, at, nodes, of->v_new, by);
    if (of->affine && (at->thin || !step->thin)) (void)InterpolateSlim(known, sum, p, at, nodes, of->affine, by);
    for (PetscInt k = 0; k < dim * dim; k++) points->affine[p * dim * dim + k] = by[k % dim][k / dim];
    for (PetscInt c = 0; c < dim; c++) points->velocity[p * dim + c] = moves[c];
  } else {
    moves  = InterpolateSlim(known, sum, p, at, nodes, of->v_new, NULL);
    change = InterpolateSlim(known, sum, p, at, nodes, of->change, NULL);
    for (PetscInt c = 0; c < dim; c++) {
      PetscReal *v = &points->velocity[p * dim + c];

      *v = (1. - of->transfer->pic) * (*v + change[c]) + of->transfer->pic * moves[c];
    }
  }
  for (PetscInt c = 0; step->moves && c < dim; c++) step->moves[p * dim + c] = moves[c];
  if (!step->a_new) return;
  change = InterpolateSlim(known, sum, p, at, nodes, of->a_new, NULL);
  for (PetscInt c = 0; c < dim; c++) points->acceleration[p * dim + c] = change[c];
}

MPM_INLINE PetscErrorCode MotionToPoints(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                         const MpmMotionStep *step, const Gathered *at)
{
  const PetscInt  dim   = known.dim;
  const PetscBool apic  = (PetscBool)(at->transfer->type == MPM_TRANSFER_APIC);
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];
  PetscInt        first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s);
    Carried        of;
    MpmStencil     stencil;

    MpmFetch(sum->space->shape[0].weight, ahead, dim * sum->space->width);
    MpmFetch(sum->points->x, ahead, dim);
    MpmFetch(sum->points->velocity, ahead, dim);
    if (apic) MpmFetch(sum->points->affine, ahead, dim * dim);
    MpmStencilPlace(known, sum, first, p, &stencil);
    if (apic) MpmStencilLines(known, sum, p, at->transfer->degree, &stencil);
    MovePoint(known, sum, p, step, &stencil, nodes, at);
    if (!step->again) continue;
    Momentum(known, sum, at->transfer, p, &stencil, &of);
    AddAgain(known, sum, p, &stencil, &of, nodes, at->again);
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmMotionToPoints(const MpmSum *sum, const MpmTransfer *transfer, const MpmMotionStep *step)
{
  const PetscInt  dim = sum->space->dim, local = sum->space->local;
  const PetscBool flip = (PetscBool)(transfer->type != MPM_TRANSFER_APIC);
  Gathered        at   = {.transfer = transfer};

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc5(local, &at.v_new, (flip ? local : 0), &at.change, (step->a_new ? local : 0), &at.a_new,
                         (step->again ? local : 0), &at.again, (step->affine ? local : 0), &at.affine));
  if (!step->affine) at.affine = NULL;
  for (PetscInt i = 0; i < local; i++) {
    at.v_new[i] = Load(dim, &step->v_new[i * dim]);
    if (flip) at.change[i] = at.v_new[i] - Load(dim, &step->v_old[i * dim]);
    if (step->a_new) at.a_new[i] = Load(dim, &step->a_new[i * dim]);
    if (step->again) at.again[i] = (Slim){0.};
    if (step->affine) at.affine[i] = Load(dim, &step->affine[i * dim]);
  }
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    MPM_DISPATCH(sum->layout, &sum->space->groups[g], MotionToPoints, sum, &sum->space->groups[g], step, &at);
  for (PetscInt i = 0; step->again && i < local; i++)
    for (PetscInt c = 0; c < dim; c++) step->again[i * dim + c] += at.again[i][c];
  PetscCall(PetscFree5(at.v_new, at.change, at.a_new, at.again, at.affine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- momentum and mass alone ---- */

/* sums_i += w_i value at the nodes of one point */
MPM_INLINE void AddValue(const MpmKnown known, const MpmSum *sum, PetscInt p, const Slim value, const PetscInt nodes[],
                         Slim *restrict sums)
{
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *wx = &sum->space->shape[0].weight[p * dim * W];

  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    for (PetscInt j = 0; j < known.count[1]; j++, nodes += known.count[0]) {
      const Slim row = value * (dim == 2 ? wx[W + j] : wx[W + j] * wx[2 * W + l]);

      for (PetscInt k = 0; k < known.count[0]; k++) sums[nodes[k]] += row * wx[k];
    }
  }
}

/* Momentum of one group's points, mass behind it; and mass times acceleration, or NULL. */
MPM_INLINE PetscErrorCode ToNodes(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                  const MpmTransfer *transfer, Slim *restrict moving, Slim *restrict accelerated)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = known.dim;
  const PetscInt  *nodes  = &sum->space->group_nodes[group->node_offset];
  PetscInt         first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s);
    Carried        of;
    MpmStencil     at;

    MpmFetch(sum->space->shape[0].weight, ahead, dim * sum->space->width);
    MpmFetch(points->x, ahead, dim);
    MpmFetch(points->velocity, ahead, dim);
    MpmStencilPlace(known, sum, first, p, &at);
    Momentum(known, sum, transfer, p, &at, &of);
    AddAgain(known, sum, p, &at, &of, nodes, moving);
    if (accelerated)
      AddValue(known, sum, p, Load(dim, &points->acceleration[p * dim]) * MpmPointMass(points, sum->materials, p),
               nodes, accelerated);
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmMomentumToNodes(const MpmSum *sum, const MpmTransfer *transfer, PetscReal mass[],
                                  PetscReal velocity[], PetscReal acceleration[])
{
  const MpmSpace *space = sum->space;
  const PetscInt  dim = space->dim, local = space->local;
  Slim           *moving, *accelerated    = NULL;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(local, &moving));
  if (acceleration) PetscCall(PetscCalloc1(local, &accelerated));
  for (PetscInt g = 0; g < space->group_count; g++)
    MPM_DISPATCH(sum->layout, &space->groups[g], ToNodes, sum, &space->groups[g], transfer, moving, accelerated);
  PetscCall(MpmSpaceAddToOwners(space, SLIM, (PetscReal *)moving));
  PetscCall(MpmSpaceToGhosts(space, SLIM, (PetscReal *)moving));
  if (acceleration) PetscCall(MpmSpaceAddToOwners(space, SLIM, (PetscReal *)accelerated));
  if (acceleration) PetscCall(MpmSpaceToGhosts(space, SLIM, (PetscReal *)accelerated));
  for (PetscInt i = 0; i < local; i++) {
    const PetscReal by = moving[i][dim] > 0. ? 1. / moving[i][dim] : 0.;

    mass[i] = moving[i][dim];
    for (PetscInt a = 0; a < dim; a++) velocity[i * dim + a] = by * moving[i][a];
    for (PetscInt a = 0; acceleration && a < dim; a++) acceleration[i * dim + a] = by * accelerated[i][a];
  }
  PetscCall(PetscFree(moving));
  PetscCall(PetscFree(accelerated));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a field as the points resolve it ---- */

/* One group's part of M a; `a` and `sums` are [i][c], of the local nodes. */
MPM_INLINE PetscErrorCode FeelGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, const Slim a[],
                                    Slim *restrict sums)
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt  p    = sum->space->order[s];
    const PetscReal mass = MpmPointMass(sum->points, sum->materials, p);

    MpmFetch(sum->space->shape[0].weight, MpmSumAhead(sum, s), known.dim * sum->space->width);
    AddValue(known, sum, p, InterpolateSlim(known, sum, p, NULL, nodes, a, NULL) * mass, nodes, sums);
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmMotionFeel(const MpmSum *sum, const PetscReal a[], PetscReal y[])
{
  const PetscInt dim = sum->space->dim, local = sum->space->local;
  Slim          *values, *sums;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(local, &values, local, &sums));
  for (PetscInt i = 0; i < local; i++) {
    values[i] = Load(dim, &a[i * dim]);
    sums[i]   = (Slim){0.};
  }
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    MPM_DISPATCH(sum->layout, &sum->space->groups[g], FeelGroup, sum, &sum->space->groups[g], values, sums);
  PetscCall(MpmSpaceAddToOwners(sum->space, SLIM, (PetscReal *)sums));
  for (PetscInt i = 0; i < sum->space->owned; i++)
    for (PetscInt c = 0; c < dim; c++) y[i * dim + c] = sums[i][c];
  PetscCall(PetscFree2(values, sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ---- consistent mass ----

  By groups of points into windows of nodes around each node, which are then packed by rows.
*/

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

/* A point's weights at its group's nodes, x fastest. */
MPM_INLINE void FindWeights(const MpmKnown known, const MpmSpace *space, PetscInt p, PetscReal weight[])
{
  const PetscInt   dim = known.dim, W = space->width;
  const PetscReal *w = &space->shape[0].weight[p * dim * W];

  for (PetscInt l = 0; l < (dim == 2 ? 1 : known.count[2]); l++) {
    for (PetscInt j = 0; j < known.count[1]; j++, weight += known.count[0]) {
      const PetscReal row = dim == 2 ? w[W + j] : w[W + j] * w[2 * W + l];

      for (PetscInt k = 0; k < known.count[0]; k++) weight[k] = w[k] * row;
    }
  }
}

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
      MpmFetch(sum->space->shape[0].weight, MpmSumAhead(sum, from + q), known.dim * sum->space->width);
      FindWeights(known, sum->space, p, &weight[q * n]);
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

/* ---- at a point ---- */

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

/* ---- stiffness ---- */

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
                                                         &points->F[p * dim * dim], &points->stress[p * MpmSymSize(dim)]);
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
