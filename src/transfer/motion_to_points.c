/*
  Velocities and accelerations from the nodes to the points.
*/
#include "transfer/carry.h"
#include "transfer/motion.h"

/* Values at the local nodes, [i][c], and how they go to the points. */
typedef struct {
  const MpmTransfer *transfer;
  Slim              *v_new, *change, *a_new, *again, *affine;
} Gathered;

/* One point's velocity and acceleration; the stencil's lines are there where it has an affine one. */
MPM_INLINE void MovePoint(const MpmKnown known, const MpmSum *sum, PetscInt p, const MpmMotionStep *step,
                          const MpmStencil *at, const PetscInt nodes[], const Gathered *of)
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim    = known.dim;
  const PetscBool  apic   = (PetscBool)(of->transfer->type == MPM_TRANSFER_APIC);
  Slim             by[MPM_MAX_DIM], change, moves;

  if (apic) {
    moves = MpmSlimInterpolate(known, sum, p, at, nodes, of->v_new, by);
    if (of->affine && (at->thin || !step->thin)) (void)MpmSlimInterpolate(known, sum, p, at, nodes, of->affine, by);
    for (PetscInt k = 0; k < dim * dim; k++) points->motion.affine[p * dim * dim + k] = by[k % dim][k / dim];
    for (PetscInt c = 0; c < dim; c++) points->motion.velocity[p * dim + c] = moves[c];
  } else {
    moves  = MpmSlimInterpolate(known, sum, p, at, nodes, of->v_new, NULL);
    change = MpmSlimInterpolate(known, sum, p, at, nodes, of->change, NULL);
    for (PetscInt c = 0; c < dim; c++) {
      PetscReal *v = &points->motion.velocity[p * dim + c];

      *v = (1. - of->transfer->pic) * (*v + change[c]) + of->transfer->pic * moves[c];
    }
  }
  for (PetscInt c = 0; step->moves && c < dim; c++) step->moves[p * dim + c] = moves[c];
  if (!step->a_new) return;
  change = MpmSlimInterpolate(known, sum, p, at, nodes, of->a_new, NULL);
  for (PetscInt c = 0; c < dim; c++) points->motion.acceleration[p * dim + c] = change[c];
}

MPM_INLINE PetscErrorCode MotionToPoints(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                         const MpmMotionStep *step, const Gathered *at)
{
  const PetscBool apic  = (PetscBool)(at->transfer->type == MPM_TRANSFER_APIC);
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];
  PetscInt        first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    MpmCarried     of;
    MpmStencil     stencil;
    const PetscInt p = MpmStencilNext(known, sum, at->transfer, first, s, &stencil);

    if (apic) MpmStencilLines(known, sum, p, at->transfer->degree, &stencil);
    MovePoint(known, sum, p, step, &stencil, nodes, at);
    if (!step->again) continue;
    MpmCarryMomentum(known, sum, at->transfer, p, &stencil, &of);
    MpmCarriedAdd(known, sum, p, &stencil, &of, nodes, at->again);
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
    at.v_new[i] = MpmSlimLoad(dim, &step->v_new[i * dim]);
    if (flip) at.change[i] = at.v_new[i] - MpmSlimLoad(dim, &step->v_old[i * dim]);
    if (step->a_new) at.a_new[i] = MpmSlimLoad(dim, &step->a_new[i * dim]);
    if (step->again) at.again[i] = (Slim){0.};
    if (step->affine) at.affine[i] = MpmSlimLoad(dim, &step->affine[i * dim]);
  }
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    MPM_DISPATCH(sum->layout, &sum->space->groups[g], MotionToPoints, sum, &sum->space->groups[g], step, &at);
  for (PetscInt i = 0; step->again && i < local; i++)
    for (PetscInt c = 0; c < dim; c++) step->again[i * dim + c] += at.again[i][c];
  PetscCall(PetscFree5(at.v_new, at.change, at.a_new, at.again, at.affine));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One group's part of M a; `a` and `sums` are [i][c], of the local nodes. */
MPM_INLINE PetscErrorCode FeelGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, const Slim a[],
                                    Slim *restrict sums)
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt  p    = sum->space->order[s];
    const PetscReal mass = MpmPointMass(sum->points, sum->materials, p);

    MpmSpaceFetch(known, sum->space, MpmSumAhead(sum, s));
    MpmSlimAdd(known, sum, p, MpmSlimInterpolate(known, sum, p, NULL, nodes, a, NULL) * mass, nodes, sums);
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
    values[i] = MpmSlimLoad(dim, &a[i * dim]);
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
