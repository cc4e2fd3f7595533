/*
  Derivatives of the weight of the water that points have taken up (volume/water_weight.c).

  With lam and u at the nodes, l = sum_i phi_i lam_i at the point and J the volume ratio of its own increment, a point's
  part of L = -lam . r is

    L = rho_w V_0 (J - 1) g . l ,    J = J(dF, F_n) ,    dF = I + sum_i u_i (x) grad phi_i .
*/

#include "volume/volume.h"
#include "stepmap/point_work.h"
#include "stepmap/rates_map.h"
#include "watermap/water_map.h"

/* A point: J - 1 with its derivatives by dF and F_n, rho_w, and V_0 g. */
typedef struct {
  MpmPointWork work;
  PetscInt     size;
  PetscReal    taken, density, by[MPM_F_MAX], by_F[MPM_F_MAX], weight[MPM_MAX_DIM];
} Visit;

/* False where the water has no weight. */
static PetscBool Weighs(const MpmStepMap *map)
{
  const MpmSum *sum = map->sum;

  for (PetscInt a = 0; sum->layout->own.taken_up >= 0 && a < sum->space->dim; a++)
    if (sum->step.gravity[a] != 0.) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* dJ/d dF : sum_i v_i (x) grad phi_i */
static PetscReal Contract(const Visit *visit, const MpmBasis *basis, PetscInt dim, const PetscReal values[])
{
  const PetscInt n   = visit->work.known.n;
  PetscReal      sum = 0.;

  for (PetscInt k = 0; k < dim * dim; k++)
    sum += visit->by[k] * MpmBasisDerivative(basis, n, k % dim, &values[k / dim * n]);
  if (visit->size > dim * dim) sum += visit->by[dim * dim] * MpmBasisHoop(basis, n, values);
  return sum;
}

static void Enter(const MpmStepMap *map, PetscInt p, Visit *visit)
{
  const MpmSum  *sum  = map->sum;
  MpmPointWork  *work = &visit->work;
  const PetscInt dim = sum->space->dim, n = work->known.n;
  PetscReal      dF[MPM_F_MAX];

  MpmSumBasis(work->known, sum->space, p, PETSC_TRUE, &work->basis);
  visit->size = sum->points->F_size;
  for (PetscInt k = 0; k < dim * dim; k++)
    dF[k] = (k / dim == k % dim ? 1. : 0.) + MpmBasisDerivative(&work->basis, n, k % dim, &work->u[k / dim * n]);
  if (visit->size > dim * dim) dF[dim * dim] = 1. + MpmBasisHoop(&work->basis, n, work->u);
  visit->taken   = MpmWaterVolume(sum, p, dF, visit->by, visit->by_F) - 1.;
  visit->density = sum->materials[sum->points->material[p]].physics_parameter[sum->layout->own.taken_up];
  for (PetscInt a = 0; a < dim; a++) visit->weight[a] = sum->points->volume0[p] * sum->step.gravity[a];
}

/* The change of the water's density with a parameter. */
static PetscReal DensityBy(const MpmStepMap *map, PetscInt k, PetscInt p)
{
  const MpmSceneParameter *parameter = &map->parameters->at[k];
  const PetscInt           material  = map->sum->points->material[p];

  if (!MpmPhysicsHasParameter(parameter, material)) return 0.;
  return MpmPhysicsSlope(map, parameter, material, map->sum->layout->own.taken_up);
}

/* ---- along ---- */

static PetscErrorCode PointAlong(const MpmStepMap *map, const MpmGroup *group, PetscInt p,
                                 const MpmStepDirection *direction, Visit *visit)
{
  const MpmPointVector *start = direction->start;
  MpmPointWork         *work  = &visit->work;
  const PetscInt        dim = start->dim, n = work->known.n;
  const PetscReal      *dx = &start->x[p * dim], *dF = &start->F[p * start->F_size];
  PetscReal             half[MPM_MAX_DIM], change    = 0.;

  PetscFunctionBeginUser;

  for (PetscInt k = 0; k < visit->size; k++) change += visit->by_F[k] * dF[k];
  if (direction->du) change += Contract(visit, &work->basis, dim, work->other);
  PetscCall(MpmPointSlopesFind(map->rules, map->sum->points, group, p, &work->slopes));
  MpmPointSlopesAlong(&work->slopes, start->F_size, dx, dF, MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p), half);
  for (PetscInt k = 0; k < MPM_BY_COUNT * dim; k++) {
    const PetscReal step = k < dim ? dx[k] : half[k - dim];

    if (step == 0.) continue;
    MpmPointSlopesBasis(&work->slopes, group, (MpmSlopeKind)(k / dim), k % dim, &work->slope);
    change += step * Contract(visit, &work->slope, dim, work->u);
    for (PetscInt a = 0; a < dim; a++)
      MpmBasisAddForce(&work->slope, n, -visit->density * visit->weight[a] * visit->taken * step, &work->force[a * n]);
  }
  change = visit->density * (change + visit->taken * MpmPointNumber(start, MPM_VECTOR_VOLUME, p));
  if (direction->parameter >= 0) change += visit->taken * DensityBy(map, direction->parameter, p);
  for (PetscInt a = 0; a < dim; a++) MpmBasisAddForce(&work->basis, n, -visit->weight[a] * change, &work->force[a * n]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterWeightAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[])
{
  const MpmSpace *space = map->sum->space;
  Visit           visit;

  PetscFunctionBeginUser;
  if (!Weighs(map)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPointWorkCreate(map, &visit.work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, direction->du, &visit.work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      Enter(map, space->order[s], &visit);
      PetscCall(PointAlong(map, group, space->order[s], direction, &visit));
    }
    MpmSumScatter(visit.work.known, map->sum, group, visit.work.force, residual);
  }
  PetscCall(MpmPointWorkDestroy(&visit.work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pull ---- */

/* V_0 g . l */
static PetscReal Power(const Visit *visit, PetscInt dim)
{
  PetscReal sum = 0.;

  for (PetscInt a = 0; a < dim; a++)
    sum += visit->weight[a] *
           MpmBasisValue(&visit->work.basis, visit->work.known.n, &visit->work.other[a * visit->work.known.n]);
  return sum;
}

/* dL/du of the point, added to the force. */
static void PullSolution(const MpmStepMap *map, Visit *visit)
{
  MpmPointWork   *work = &visit->work;
  const PetscInt  dim = map->sum->space->dim, n = work->known.n;
  const PetscReal by = visit->density * Power(visit, dim);

  for (PetscInt k = 0; k < dim * dim; k++)
    MpmBasisAddFlux(&work->basis, n, k % dim, by * visit->by[k], &work->force[k / dim * n]);
  if (visit->size > dim * dim) MpmBasisAddHoop(&work->basis, n, by * visit->by[dim * dim], work->force);
}

/* Factors of the basis functions in L, at the group's nodes. */
static void FindFactors(Visit *visit, PetscInt dim, PetscReal by, PetscReal *factor[])
{
  MpmPointWork  *work = &visit->work;
  const PetscInt n    = work->known.n;

  for (PetscInt b = 0; b < MPM_BASES; b++) {
    factor[b] = work->slope.basis[b];
    for (PetscInt i = 0; i < n; i++) factor[b][i] = 0.;
  }
  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt a = 0; a < dim; a++)
      factor[0][i] += visit->density * visit->taken * visit->weight[a] * work->other[a * n + i];
    for (PetscInt k = 0; k < dim * dim; k++) factor[1 + k % dim][i] += by * visit->by[k] * work->u[k / dim * n + i];
    if (visit->size > dim * dim) factor[MPM_HOOP_BASIS][i] += by * visit->by[dim * dim] * work->u[i];
  }
}

static PetscErrorCode PullStart(const MpmStepMap *map, const MpmGroup *group, PetscInt p, Visit *visit,
                                MpmPointVector *start, PetscReal gradient[])
{
  MpmPointWork   *work  = &visit->work;
  const PetscInt  dim   = start->dim;
  const PetscReal power = Power(visit, dim), by = visit->density * power;
  PetscReal       half[MPM_MAX_DIM] = {0.}, *F = &start->F[p * start->F_size], *factor[MPM_BASES];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < map->parameters->count; k++) gradient[k] += visit->taken * power * DensityBy(map, k, p);
  if (start->size[MPM_VECTOR_VOLUME]) start->at[MPM_VECTOR_VOLUME][p] += by * visit->taken;
  for (PetscInt k = 0; k < visit->size; k++) F[k] += by * visit->by_F[k];
  PetscCall(MpmPointSlopesFind(map->rules, map->sum->points, group, p, &work->slopes));
  FindFactors(visit, dim, by, factor);
  for (PetscInt a = 0; a < dim; a++) {
    start->x[p * dim + a] += MpmPointSlopesSum(&work->slopes, group, MPM_BY_PLACE, a, factor);
    if (work->slopes.domain) half[a] = MpmPointSlopesSum(&work->slopes, group, MPM_BY_LENGTH, a, factor);
  }
  MpmPointSlopesPull(&work->slopes, start->F_size, half, &start->x[p * dim], F,
                     MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Both halves: of the solution with `u`, or else of the start. */
static PetscErrorCode Pull(const MpmStepMap *map, const PetscReal lam[], PetscReal u[], MpmPointVector *start,
                           PetscReal gradient[])
{
  const MpmSpace *space = map->sum->space;
  Visit           visit;

  PetscFunctionBeginUser;
  if (!Weighs(map)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmPointWorkCreate(map, &visit.work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, lam, &visit.work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      Enter(map, space->order[s], &visit);
      if (u) PullSolution(map, &visit);
      else PetscCall(PullStart(map, group, space->order[s], &visit, start, gradient));
    }
    if (u) MpmSumScatter(visit.work.known, map->sum, group, visit.work.force, u);
  }
  PetscCall(MpmPointWorkDestroy(&visit.work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterWeightPullSolution(const MpmStepMap *map, const PetscReal lam[], PetscReal u[])
{
  PetscFunctionBeginUser;
  PetscCall(Pull(map, lam, u, NULL, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmWaterWeightPullStart(const MpmStepMap *map, const PetscReal lam[], MpmPointVector *start,
                                       PetscReal gradient[])
{
  PetscFunctionBeginUser;
  PetscCall(Pull(map, lam, NULL, start, gradient));
  PetscFunctionReturn(PETSC_SUCCESS);
}
