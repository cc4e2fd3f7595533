/*
  The loads' part of a step's derivatives.

  A load's force on node i is the sum over points of b W_i: b the load's vector times the point's share of it, or its
  mass, W_i the point's weight, or that of the centre of a face, or the mean of those of the ends of its domain
  (loads/load_weights.h). With lam at the nodes, their part of L is the sum of b W_i . lam_i.
*/
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/point_shape.h"
#include "space/point_slopes.h"
#include "space/rules.h"
#include "space/sum.h"
#include "loads/load_weights.h"
#include "stepmap/step_map.h"

/* One load, and room for one point. */
typedef struct {
  const MpmStepMap *map;
  const MpmLoad    *load;
  PetscReal         factor;
  PetscReal        *share; /* of the points; NULL: their masses count */
  PetscBool         own;   /* the weights are not the points' */
  MpmTouched        at;
  MpmBasis          basis, slope;
  MpmPointSlopes    slopes;
} Work;

static PetscErrorCode WorkCreate(const MpmStepMap *map, Work *work)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(work, sizeof(*work)));
  work->map = map;
  PetscCall(MpmBasisCreate(map->sum->space, &work->basis));
  PetscCall(MpmBasisCreate(map->sum->space, &work->slope));
  PetscCall(MpmPointSlopesCreate(map->sum->space, &work->slopes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode WorkDestroy(Work *work)
{
  PetscFunctionBeginUser;
  PetscCall(MpmBasisDestroy(&work->basis));
  PetscCall(MpmBasisDestroy(&work->slope));
  PetscCall(MpmPointSlopesDestroy(&work->slopes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A load begins, or ends. */
static PetscErrorCode TakeLoad(Work *work, PetscInt l)
{
  const MpmLoad *load = &work->map->loads[l];

  PetscFunctionBeginUser;
  work->load   = load;
  work->factor = work->map->factors[l];
  work->share  = NULL;
  work->own    = (PetscBool)(load->type == MPM_LOAD_TRACTION || MpmLoadActsAtEnds(load, work->map->rules));
  if (load->share_field) PetscCall(MpmParticlesGetField(work->map->particles, load->share_field, &work->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode LeaveLoad(Work *work)
{
  PetscFunctionBeginUser;
  if (work->share) PetscCall(MpmParticlesRestoreField(work->map->particles, &work->share));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Share of a point, or its mass; 0 where the load does not act on it. */
static PetscReal Amount(const Work *work, PetscInt p)
{
  const MpmSum *sum = work->map->sum;

  return work->share ? work->share[p] : MpmPointMass(sum->points, sum->materials, p);
}

/* The relative change of the amount with the step's start: of a mass of the point's own, or one by its volume. */
static MpmVectorField AmountField(const Work *work)
{
  return work->share ? MPM_VECTOR_FIELDS : work->map->sum->points->mass ? MPM_VECTOR_MASS : MPM_VECTOR_VOLUME;
}

/* The change of factor times amount with a parameter. */
static PetscReal AmountBy(const Work *work, PetscInt k, PetscInt p)
{
  const MpmSceneParameter *parameter = &work->map->parameters->at[k];
  const MpmPoints         *points    = work->map->sum->points;

  if (parameter->kind == MPM_OF_LOAD)
    return work->load == &work->map->loads[parameter->index] ? work->factor / parameter->value * Amount(work, p) : 0.;
  if (!parameter->density || work->share || points->mass || points->material[p] != parameter->index) return 0.;
  return work->factor * points->volume0[p];
}

/* Change with a field of the density, along a direction or (NULL) by 1 at the point. */
static PetscReal AmountByGround(const Work *work, PetscInt k, const PetscReal along[], PetscInt p)
{
  const MpmFieldParameter *ground = &work->map->grounds->at[k];
  const MpmPoints         *points = work->map->sum->points;

  if (!ground->density || work->share) return 0.;
  return work->factor * points->volume0[p] * MpmGroundChange(ground, along, points, work->map->sum->space->dim, p);
}

/* A point's weights into work->basis, and the derivatives that it has. */
static PetscErrorCode Enter(Work *work, const MpmGroup *group, PetscInt p)
{
  const MpmSum *sum    = work->map->sum;
  PetscReal    *weight = MpmBasisWeights(&work->basis);

  PetscFunctionBeginUser;
  work->at = (MpmTouched){work->map->rules, sum->space, sum->points, group, p};
  PetscCall(MpmPointSlopesFind(work->map->rules, sum->points, group, p, &work->slopes));
  if (work->load->type == MPM_LOAD_TRACTION) PetscCall(MpmLoadFaceWeights(work->load, &work->at, weight));
  else if (work->own) PetscCall(MpmLoadEndWeights(work->load, &work->at, weight));
  else MpmSpaceEvaluate(sum->space, group, p, &work->basis);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Their derivative by place or half-length along an axis, into work->slope. */
static PetscErrorCode Slope(Work *work, MpmSlopeKind kind, PetscInt axis)
{
  PetscFunctionBeginUser;
  if (work->own)
    PetscCall(MpmLoadWeightSlopes(work->load, &work->slopes, &work->at, kind, axis, MpmBasisWeights(&work->slope)));
  else MpmPointSlopesBasis(&work->slopes, work->at.group, kind, axis, &work->slope);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The axis on which half-lengths count before they are clipped; -1: none. */
static PetscInt FreeAxis(const Work *work)
{
  return work->load->type == MPM_LOAD_TRACTION ? work->load->face_axis : -1;
}

/* ---- along ---- */

/* The change of a point's force on its nodes, subtracted from the residual. */
static PetscErrorCode PointAlong(Work *work, const MpmStepDirection *direction, PetscReal residual[])
{
  const MpmSum    *sum = work->map->sum;
  const PetscInt   p = work->at.point, dim = sum->space->dim, size = sum->points->F_size, free = FreeAxis(work);
  const PetscReal *dx = &direction->start->x[p * dim], *dF = &direction->start->F[p * size];
  const PetscReal  amount = work->factor * Amount(work, p);
  const PetscReal *length = MpmPointNumbersIf(direction->start, MPM_VECTOR_LENGTH, p);
  PetscReal        half[MPM_MAX_DIM], change = 0.;

  PetscFunctionBeginUser;
  if (AmountField(work) != MPM_VECTOR_FIELDS) change = amount * MpmPointNumber(direction->start, AmountField(work), p);
  if (direction->parameter >= 0) change += AmountBy(work, direction->parameter, p);
  if (direction->ground) change += AmountByGround(work, direction->ground->index, direction->ground->along, p);
  if (change != 0.)
    MpmWeightsAdd(MpmBasisWeights(&work->basis), work->at.group, sum, -change, work->load->value, residual);
  MpmPointSlopesAlong(&work->slopes, size, dx, dF, length, half);
  if (free >= 0) {
    half[free] = length ? work->slopes.stretched[free] * length[free] : 0.;
    for (PetscInt k = 0; k < size; k++) half[free] += work->slopes.stretch_by_F[free][k] * dF[k];
  }
  for (PetscInt k = 0; k < MPM_BY_COUNT * dim; k++) {
    const PetscInt  a    = k % dim;
    const PetscReal step = k / dim == MPM_BY_PLACE ? dx[a] : half[a];

    if (step == 0.) continue;
    PetscCall(Slope(work, (MpmSlopeKind)(k / dim), a));
    MpmWeightsAdd(MpmBasisWeights(&work->slope), work->at.group, sum, -amount * step, work->load->value, residual);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadsAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[])
{
  const MpmSpace *space = map->sum->space;
  Work            work;

  PetscFunctionBeginUser;
  PetscCall(WorkCreate(map, &work));
  for (PetscInt l = 0; l < map->load_count; l++) {
    PetscCall(TakeLoad(&work, l));
    for (PetscInt g = 0; work.factor != 0. && g < space->group_count; g++) {
      for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
        if (Amount(&work, space->order[s]) == 0.) continue;
        PetscCall(Enter(&work, &space->groups[g], space->order[s]));
        PetscCall(PointAlong(&work, direction, residual));
      }
    }
    PetscCall(LeaveLoad(&work));
  }
  PetscCall(WorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pull ---- */

/* sum_i W_i lam_i . value of weights or their derivatives. */
static PetscReal PowerOf(const Work *work, const MpmBasis *basis, const PetscReal lam[])
{
  const MpmSum *sum             = work->map->sum;
  PetscReal     at[MPM_MAX_DIM] = {0.}, total = 0.;

  MpmBasisInterpolate(sum->space, work->at.group, basis, sum->block, lam, sum->space->dim, at);
  for (PetscInt a = 0; a < sum->space->dim; a++) total += at[a] * work->load->value[a];
  return total;
}

static PetscErrorCode PointPull(Work *work, const PetscReal lam[], MpmPointVector *start, PetscReal gradient[])
{
  const PetscInt  p = work->at.point, dim = start->dim, size = start->F_size, free = FreeAxis(work);
  const PetscReal amount            = work->factor * Amount(work, p);
  PetscReal       half[MPM_MAX_DIM] = {0.}, value, *length = MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p);

  PetscFunctionBeginUser;
  value = PowerOf(work, &work->basis, lam);
  for (PetscInt k = 0; k < work->map->parameters->count; k++) gradient[k] += AmountBy(work, k, p) * value;
  if (AmountField(work) != MPM_VECTOR_FIELDS && start->size[AmountField(work)])
    start->at[AmountField(work)][p] += amount * value;
  for (PetscInt k = 0; k < work->map->grounds->count; k++) {
    const PetscReal by = AmountByGround(work, k, NULL, p);

    if (by != 0.) MpmGroundTakePoint(&work->map->grounds->at[k], work->map->sum->points, dim, p, by * value);
  }
  for (PetscInt k = 0; k < MPM_BY_COUNT * dim; k++) {
    const PetscInt a = k % dim;

    PetscCall(Slope(work, (MpmSlopeKind)(k / dim), a));
    value = amount * PowerOf(work, &work->slope, lam);
    if (k / dim == MPM_BY_PLACE) start->x[p * dim + a] += value;
    else half[a] = value;
  }
  if (free >= 0) {
    for (PetscInt k = 0; k < size; k++) start->F[p * size + k] += work->slopes.stretch_by_F[free][k] * half[free];
    if (length) length[free] += work->slopes.stretched[free] * half[free];
    half[free] = 0.;
  }
  MpmPointSlopesPull(&work->slopes, size, half, &start->x[p * dim], &start->F[p * size], length);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadsPullStart(const MpmStepMap *map, const PetscReal lam[], MpmPointVector *start,
                                 PetscReal gradient[])
{
  const MpmSpace *space = map->sum->space;
  Work            work;

  PetscFunctionBeginUser;
  PetscCall(WorkCreate(map, &work));
  for (PetscInt l = 0; l < map->load_count; l++) {
    PetscCall(TakeLoad(&work, l));
    for (PetscInt g = 0; work.factor != 0. && g < space->group_count; g++) {
      for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
        if (Amount(&work, space->order[s]) == 0.) continue;
        PetscCall(Enter(&work, &space->groups[g], space->order[s]));
        PetscCall(PointPull(&work, lam, start, gradient));
      }
    }
    PetscCall(LeaveLoad(&work));
  }
  PetscCall(WorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}
