/*
  Mass and momentum of the points at the nodes: with their force in one pass, an explicit step's first half; and with
  mass times acceleration.
*/
#include "transfer/carry.h"
#include "transfer/momentum.h"
#include "transfer/motion.h"

/* Place of component bc of a symmetric tensor at a point: xx, yy, zz, xy, yz, xz. */
MPM_INLINE PetscInt SymPlace(PetscInt b, PetscInt c)
{
  return b == c ? b : b + c == 1 ? 3 : b + c == 3 ? 4 : 5;
}

/* Stress of a force: V_0 tau, or for a small-strain law with derivatives by the present position. */
MPM_INLINE void PointStress(const MpmKnown known, const MpmSum *sum, PetscInt p, Slim P[])
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = known.dim;
  const PetscReal *F = MpmPointF(points, p), *s = &points->stress[p * MpmSymSize(dim)];
  const PetscReal  volume = points->volume0[p];
  Slim             sigma[MPM_MAX_DIM];

  for (PetscInt b = 0; b < dim; b++) {
    PetscReal row[MPM_MAX_DIM] = {0., 0., 0.};

    for (PetscInt c = 0; c < dim; c++) row[c] = s[SymPlace(b, c)];
    sigma[b] = MpmSlimLoad(dim, row);
  }
  if (sum->materials[points->material[p]].info.traits & MPM_LAW_SMALL_STRAIN) {
    for (PetscInt b = 0; b < dim; b++) {
      P[b] = sigma[0] * (volume * F[b * dim]);
      for (PetscInt c = 1; c < dim; c++) P[b] += sigma[c] * (volume * F[b * dim + c]);
    }
  } else
    for (PetscInt b = 0; b < dim; b++) P[b] = sigma[b] * (volume * MpmDeterminant(points->F_size, F));
}

/* Pull of the hoop stress towards the axis, N; 0 without axial symmetry. */
MPM_INLINE PetscReal HoopForce(const MpmSum *sum, PetscInt p)
{
  const MpmPoints *points = sum->points;
  const PetscReal  hoop   = MpmSpaceHoop(sum->space, p);
  PetscReal        ratio;

  if (hoop == 0.) return 0.;
  ratio = sum->materials[points->material[p]].info.traits & MPM_LAW_SMALL_STRAIN ? MpmPointF(points, p)[4]
                                                                                 : MpmPointJ(points, p);
  return points->volume0[p] * ratio * points->stress[4 * p + 2] * hoop;
}

MPM_INLINE PetscErrorCode MotionToNodes(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                        const MpmTransfer *transfer, MpmCarriedSums *restrict sums)
{
  PetscInt first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s);
    MpmCarried     of;
    MpmStencil     at;

    MpmSumFetch(known, sum, s);
    MpmFetch(sum->points->x, ahead, known.dim);
    MpmFetch(sum->points->motion.velocity, ahead, known.dim);
    MpmFetch(sum->points->stress, ahead, MpmSymSize(known.dim));
    if (transfer->type == MPM_TRANSFER_APIC) MpmFetch(sum->points->motion.affine, ahead, known.dim * known.dim);
    MpmStencilPlace(known, sum, first, p, &at);
    MpmCarryMomentum(known, sum, transfer, p, &at, &of);
    PointStress(known, sum, p, of.P);
    of.hoop = (Slim){HoopForce(sum, p), 0., 0., 0.};
    MpmCarriedAddForce(known, sum, p, &at, &of, &sum->space->group_nodes[group->node_offset], sums);
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmMotionToNodes(const MpmSum *sum, const MpmTransfer *transfer, PetscReal mass[], PetscReal velocity[],
                                PetscReal force[])
{
  const PetscInt  dim = sum->space->dim, local = sum->space->local;
  MpmCarriedSums *sums;

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
                 MpmSlimLoad(dim, &points->motion.acceleration[p * dim]) * MpmPointMass(points, sum->materials, p),
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
    const PetscReal by = sum->grid->order > 1 ? 1. : moving[i][dim] > 0. ? 1. / moving[i][dim] : 0.;

    mass[i] = moving[i][dim];
    for (PetscInt a = 0; a < dim; a++) velocity[i * dim + a] = by * moving[i][a];
    for (PetscInt a = 0; acceleration && a < dim; a++) acceleration[i * dim + a] = by * accelerated[i][a];
  }
  PetscCall(PetscFree(moving));
  PetscCall(PetscFree(accelerated));
  PetscFunctionReturn(PETSC_SUCCESS);
}
