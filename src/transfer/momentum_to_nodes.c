/*
  Mass and momentum of the points at the nodes: with their force in one pass, an explicit step's first half; and with
  mass times acceleration.
*/
#include "transfer/carry.h"
#include "transfer/momentum.h"
#include "transfer/motion.h"

/* Of a node in the first pass: momentum, and mass behind it; and force. */
typedef struct {
  Slim moving, force;
} Sums;

/* Stress of a force: V_0 tau, or for a small-strain law with derivatives by the present position. */
MPM_INLINE void PointStress(const MpmKnown known, const MpmSum *sum, PetscInt p, Slim P[])
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = known.dim;
  const PetscReal *F = MpmPointF(points, p), *s = &points->stress[p * (dim == 2 ? 4 : 6)];
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
    for (PetscInt b = 0; b < dim; b++) P[b] = sigma[b] * (volume * MpmDeterminant(points->F_size, F));
}

/* Pull of the hoop stress towards the axis, N; 0 without axial symmetry. */
MPM_INLINE PetscReal HoopForce(const MpmSum *sum, PetscInt p)
{
  const MpmPoints *points = sum->points;
  PetscReal        ratio;

  if (!sum->space->shape[0].hoop) return 0.;
  ratio = sum->materials[points->material[p]].info.traits & MPM_LAW_SMALL_STRAIN ? MpmPointF(points, p)[4]
                                                                                 : MpmPointJ(points, p);
  return points->volume0[p] * ratio * points->stress[4 * p + 2] * sum->space->shape[0].hoop[p];
}

/* Mass, momentum and force of one point, added to those of its nodes. */
MPM_INLINE void AddPoint(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmStencil *at,
                         const MpmCarried *of, const PetscInt nodes[], Sums *restrict sums)
{
  const PetscInt   dim = known.dim, W = sum->space->width;
  const PetscReal *wx = &sum->space->shape[0].weight[p * dim * W], *gx = &sum->space->shape[0].gradient[p * dim * W];
  MpmWeightRow     line;

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
      if (!known.solid) across += of->hoop * w;
      row *= w;
      for (PetscInt k = 0; k < known.count[0]; k++) {
        Sums *to = &sums[*nodes++];

        to->moving += row * line.weight[k] + by_away * line.moment[k];
        to->force -= across * line.weight[k] + along * line.gradient[k];
      }
    }
  }
}

MPM_INLINE PetscErrorCode MotionToNodes(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                        const MpmTransfer *transfer, Sums *restrict sums)
{
  PetscInt first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s);
    MpmCarried     of;
    MpmStencil     at;

    MpmSumFetch(known, sum, s);
    MpmFetch(sum->points->x, ahead, known.dim);
    MpmFetch(sum->points->velocity, ahead, known.dim);
    MpmFetch(sum->points->stress, ahead, known.dim == 2 ? 4 : 6);
    if (transfer->type == MPM_TRANSFER_APIC) MpmFetch(sum->points->affine, ahead, known.dim * known.dim);
    MpmStencilPlace(known, sum, first, p, &at);
    MpmCarryMomentum(known, sum, transfer, p, &at, &of);
    PointStress(known, sum, p, of.P);
    of.hoop = (Slim){HoopForce(sum, p), 0., 0., 0.};
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
  for (PetscInt i = 0; i < local; i++) sums[i].force += MpmSlimLoad(dim, &force[i * dim]);
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

/* MpmCarryMomentum of one group's points, mass behind it; and mass times acceleration, or NULL. */
MPM_INLINE PetscErrorCode ToNodes(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                  const MpmTransfer *transfer, Slim *restrict moving, Slim *restrict accelerated)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = known.dim;
  const PetscInt  *nodes  = &sum->space->group_nodes[group->node_offset];
  PetscInt         first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    MpmCarried     of;
    MpmStencil     at;
    const PetscInt p = MpmStencilNext(known, sum, transfer, first, s, &at);

    MpmCarryMomentum(known, sum, transfer, p, &at, &of);
    MpmCarriedAdd(known, sum, p, &at, &of, nodes, moving);
    if (accelerated)
      MpmSlimAdd(known, sum, p,
                 MpmSlimLoad(dim, &points->acceleration[p * dim]) * MpmPointMass(points, sum->materials, p), nodes,
                 accelerated);
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
