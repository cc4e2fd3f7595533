/*
  One point of a step's derivatives.
*/
#include "stepmap/point_work.h"

PetscErrorCode MpmPointWorkCreate(const MpmStepMap *map, MpmPointWork *work)
{
  const MpmSum  *sum = map->sum;
  const PetscInt n = PetscPowInt(sum->space->width, sum->space->dim), bs = sum->block;
  PetscInt       parameters = 1;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(work, sizeof(*work)));
  for (PetscInt m = 0; m < map->rules->material_count; m++)
    parameters = PetscMax(parameters, (PetscInt)sum->materials[m].info.parameter_count);
  PetscCall(MpmPointSlopesCreate(sum->space, &work->slopes));
  PetscCall(MpmBasisCreate(sum->space, &work->basis));
  PetscCall(MpmBasisCreate(sum->space, &work->slope));
  PetscCall(MpmBasisCreate(sum->space, &work->part));
  PetscCall(
    PetscCalloc4((n * bs), &work->u, (n * bs), &work->other, (n * bs), &work->force, parameters, &work->parameter));
  PetscCall(PetscCalloc4((sum->kept.state + 1), &work->state[0], (sum->kept.state + 1), &work->state[1],
                         (sum->kept.own + 1), &work->own[0], (sum->kept.own + 1), &work->own[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointWorkDestroy(MpmPointWork *work)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPointSlopesDestroy(&work->slopes));
  PetscCall(MpmBasisDestroy(&work->basis));
  PetscCall(MpmBasisDestroy(&work->slope));
  PetscCall(MpmBasisDestroy(&work->part));
  PetscCall(PetscFree4(work->u, work->other, work->force, work->parameter));
  PetscCall(PetscFree4(work->state[0], work->state[1], work->own[0], work->own[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPointEnter(const MpmStepMap *map, PetscInt p, PetscBool other, MpmPointWork *work, MpmKernelPoint *point)
{
  const MpmSum *sum = map->sum;

  MpmSumBasis(work->known, sum->space, p, PETSC_TRUE, &work->basis);
  MpmSumInputs(work->known, sum->layout, work->u, &work->basis, work->input);
  if (other) MpmSumInputs(work->known, sum->layout, work->other, &work->basis, work->other_input);
  MpmPointMake(map, p, work, point);
}

void MpmPointMake(const MpmStepMap *map, PetscInt p, MpmPointWork *work, MpmKernelPoint *point)
{
  const MpmSum *sum = map->sum;

  MpmSumPoint(sum, p, point);
  point->end.state  = sum->materials[sum->points->material[p]].state_size ? work->state[0] : NULL;
  point->end.own    = sum->kept.own ? work->own[0] : NULL;
  point->end.F      = work->F[0];
  point->end.stress = work->stress[0];
}

PetscErrorCode MpmPointDifferentiate(const MpmStepMap *map, const MpmKernelPoint *point,
                                     const MpmKernelDirection *direction, MpmPointWork *work)
{
  const MpmKernelEnd derivative = {.state  = point->end.state ? work->state[1] : NULL,
                                   .own    = point->end.own ? work->own[1] : NULL,
                                   .F      = work->F[1],
                                   .stress = work->stress[1]};

  PetscFunctionBeginUser;
  PetscCheck(
    !map->sum->layout->kernel->sensitivity(point, work->input, direction, work->flux, work->dflux, &derivative),
    PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no answer at the solution of its step");
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPointVolumeAlong(const MpmPointVector *start, PetscInt p, MpmPointWork *work)
{
  const PetscReal change = MpmPointNumber(start, MPM_VECTOR_VOLUME, p);

  for (PetscInt k = 0; change != 0. && k < work->known.inputs + 1; k++) work->dflux[k] += change * work->flux[k];
}

void MpmPointPullVolume(const PetscReal flux[], PetscInt p, const MpmPointWork *work, MpmPointVector *start)
{
  for (PetscInt k = 0; start->size[MPM_VECTOR_VOLUME] && k < work->known.inputs; k++)
    start->at[MPM_VECTOR_VOLUME][p] -= flux[k] * work->other_input[k];
}

void MpmPointSetDirection(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscReal value,
                          MpmPointWork *work)
{
  MpmMaterialDirection(&map->sum->materials[parameter->index], parameter->place, value, 1, work->parameter);
}

PetscBool MpmPointHasParameter(const MpmStepMap *map, const MpmSceneParameter *parameter, PetscInt p)
{
  return (PetscBool)(parameter->kind == MPM_OF_LAW && parameter->index == map->sum->points->material[p]);
}

PetscBool MpmPointGroundEnter(const MpmStepMap *map, const MpmGroundDirection *direction, PetscInt p,
                              MpmPointWork *work)
{
  return MpmGroundEnter(&map->grounds->at[direction->index], direction->along, map->sum->points, map->sum->space->dim,
                        p, work->parameter);
}

void MpmPointGroundForget(const MpmStepMap *map, const MpmGroundDirection *direction, MpmPointWork *work)
{
  MpmGroundForget(&map->grounds->at[direction->index], work->parameter);
}

void MpmPointWorkGather(const MpmStepMap *map, const MpmGroup *group, const PetscReal other[], MpmPointWork *work)
{
  work->known = KnownGeneral(map->sum->layout, group);
  MpmSumGather(work->known, map->sum, group, map->u, work->u);
  if (other) MpmSumGather(work->known, map->sum, group, other, work->other);
  for (PetscInt k = 0; k < work->known.n * work->known.block; k++) work->force[k] = 0.;
}

PetscErrorCode MpmPointWeightsAlong(const MpmStepMap *map, const MpmGroup *group, PetscInt p,
                                    const MpmPointVector *start, MpmPointWork *work)
{
  const PetscInt   dim = map->sum->space->dim, n = group->node_count;
  const PetscReal *dx = &start->x[p * start->dim], *dF = &start->F[p * start->F_size];
  MpmBasis        *part = &work->part;
  PetscReal        half[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(MpmPointSlopesFind(map->rules, map->sum->points, group, p, &work->slopes));
  MpmPointSlopesAlong(&work->slopes, map->sum->points->F_size, dx, dF, MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p),
                      half);
  MpmBasisZero(&work->slope, dim, n);
  for (PetscInt a = 0; a < dim; a++) {
    MpmPointSlopesBasis(&work->slopes, group, MPM_BY_PLACE, a, part);
    MpmBasisAdd(dx[a], part, dim, n, &work->slope);
    if (half[a] == 0.) continue;
    MpmPointSlopesBasis(&work->slopes, group, MPM_BY_LENGTH, a, part);
    MpmBasisAdd(half[a], part, dim, n, &work->slope);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPointEndAlong(const MpmStepMap *map, PetscInt p, const MpmStepDirection *direction, const MpmPointWork *work,
                      MpmPointVector *end)
{
  const PetscInt dim = end->dim, n = work->known.n,
                 states = map->sum->materials[map->sum->points->material[p]].state_size;

  for (PetscInt a = 0; a < dim; a++) {
    end->x[p * dim + a] = direction->start->x[p * dim + a] + MpmBasisValue(&work->slope, n, &work->u[a * n]);
    if (direction->du) end->x[p * dim + a] += MpmBasisValue(&work->basis, n, &work->other[a * n]);
  }
  for (PetscInt k = 0; k < end->F_size; k++) end->F[p * end->F_size + k] = work->F[1][k];
  for (PetscInt k = 0; k < states; k++) end->state[p * end->state_size + k] = work->state[1][k];
}

PetscReal MpmPointContract(const MpmStepMap *map, PetscInt p, const MpmPointVector *end, const MpmPointWork *work)
{
  const PetscInt states = map->sum->materials[map->sum->points->material[p]].state_size;
  PetscReal      sum    = 0.;

  for (PetscInt k = 0; k < end->F_size; k++) sum += end->F[p * end->F_size + k] * work->F[1][k];
  for (PetscInt k = 0; k < states; k++) sum += end->state[p * end->state_size + k] * work->state[1][k];
  for (PetscInt k = 0; k < work->known.inputs; k++) sum -= work->other_input[k] * work->dflux[k];
  return sum;
}

/* dL along a direction of the kernel's arguments: the point's own part, and by the mean m_bar of its cell. */
static PetscErrorCode Total(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point, const MpmPointPull *pull,
                            const MpmKernelDirection *direction, PetscReal *total, MpmPointWork *work)
{
  const MpmMeanPull *mean = pull->mean;
  const PetscInt     N    = work->known.inputs;
  PetscReal          m[2], dm[MPM_MAX_INPUTS], ddm[MPM_MAX_INPUTS];

  PetscFunctionBeginUser;
  PetscCall(MpmPointDifferentiate(map, point, direction, work));
  *total = MpmPointContract(map, p, pull->end, work);
  if (!mean) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(!map->sum->layout->kernel->mean_sensitivity(point, work->input, direction, m, dm, ddm), PETSC_COMM_SELF,
             PETSC_ERR_FP, "a point has no mean at the solution of its step");
  *total += mean->by_mean * mean->share * m[1] - work->dflux[N] * mean->along;
  for (PetscInt k = 0; k < N; k++) *total -= mean->flux * mean->share * ddm[k] * work->other_input[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointPullInputs(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                                  const MpmPointPull *pull, PetscReal by_input[], MpmPointWork *work)
{
  PetscReal unit[MPM_MAX_INPUTS] = {0.};

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < work->known.inputs; k++) {
    unit[k] = 1.;
    PetscCall(Total(map, p, point, pull, &(MpmKernelDirection){.input = unit}, &by_input[k], work));
    unit[k] = 0.;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Derivatives by the fields' numbers at the point. */
static PetscErrorCode PullGrounds(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                                  const MpmPointPull *pull, MpmPointWork *work)
{
  const MpmPoints *points = map->sum->points;
  const PetscInt   dim    = map->sum->space->dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < map->grounds->count; k++) {
    const MpmFieldParameter *ground = &map->grounds->at[k];
    PetscReal                total;

    if (!MpmGroundEnter(ground, NULL, points, dim, p, work->parameter)) continue;
    PetscCall(Total(map, p, point, pull, &(MpmKernelDirection){.parameter = work->parameter}, &total, work));
    MpmGroundForget(ground, work->parameter);
    MpmGroundTakePoint(ground, points, dim, p, total);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointPullKernel(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                                  const MpmPointPull *pull, MpmPointVector *start, PetscReal gradient[],
                                  MpmPointWork *work)
{
  const PetscInt states = map->sum->materials[map->sum->points->material[p]].state_size;
  PetscReal     *unit, total;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((PetscMax(states, start->F_size) + 1), &unit));
  for (PetscInt k = 0; k < start->F_size; k++) {
    unit[k] = 1.;
    PetscCall(Total(map, p, point, pull, &(MpmKernelDirection){.F_n = unit}, &total, work));
    unit[k] = 0.;
    start->F[p * start->F_size + k] += total;
  }
  for (PetscInt k = 0; k < states; k++) {
    unit[k] = 1.;
    PetscCall(Total(map, p, point, pull, &(MpmKernelDirection){.state_n = unit}, &total, work));
    unit[k] = 0.;
    start->state[p * start->state_size + k] += total;
  }
  PetscCall(PetscFree(unit));
  for (PetscInt k = 0; k < map->parameters->count; k++) {
    const MpmSceneParameter *parameter = &map->parameters->at[k];

    if (!MpmPointHasParameter(map, parameter, p)) continue;
    MpmPointSetDirection(map, parameter, 1., work);
    PetscCall(Total(map, p, point, pull, &(MpmKernelDirection){.parameter = work->parameter}, &total, work));
    MpmPointSetDirection(map, parameter, 0., work);
    gradient[k] += total;
  }
  PetscCall(PullGrounds(map, p, point, pull, work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointPullWeights(const MpmStepMap *map, const MpmGroup *group, PetscInt p, const MpmPointVector *end,
                                   const PetscReal by_input[], MpmPointVector *start, MpmPointWork *work)
{
  const PetscInt dim = start->dim, n = work->known.n;
  PetscReal      by[MPM_BY_COUNT][MPM_MAX_DIM], inputs[MPM_MAX_INPUTS], others[MPM_MAX_INPUTS];

  PetscFunctionBeginUser;
  PetscCall(MpmPointSlopesFind(map->rules, map->sum->points, group, p, &work->slopes));
  for (PetscInt k = 0; k < MPM_BY_COUNT * dim; k++) {
    const PetscInt a   = k % dim;
    PetscReal      sum = 0.;

    MpmPointSlopesBasis(&work->slopes, group, (MpmSlopeKind)(k / dim), a, &work->slope);
    MpmSumInputs(work->known, map->sum->layout, work->u, &work->slope, inputs);
    MpmSumInputs(work->known, map->sum->layout, work->other, &work->slope, others);
    for (PetscInt i = 0; i < work->known.inputs; i++) sum += by_input[i] * inputs[i] - work->flux[i] * others[i];
    for (PetscInt c = 0; c < dim; c++) { sum += end->x[p * dim + c] * MpmBasisValue(&work->slope, n, &work->u[c * n]); }
    by[k / dim][a] = sum;
  }
  for (PetscInt a = 0; a < dim; a++) start->x[p * dim + a] += end->x[p * dim + a] + by[MPM_BY_PLACE][a];
  MpmPointSlopesPull(&work->slopes, start->F_size, by[MPM_BY_LENGTH], &start->x[p * dim], &start->F[p * start->F_size],
                     MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}
