/*
  One point along several directions.
*/
#include "point/material.h"
#include "stepmap/point_along.h"
#include "stepmap/rates_end.h"

PetscErrorCode MpmAlongWorkCreate(const MpmStepMap *map, MpmAlongWork *work)
{
  const MpmSum  *sum = map->sum;
  const PetscInt n = PetscPowInt(sum->space->width, sum->space->dim) * sum->block, states = sum->kept.state + 1;
  PetscInt       parameters = 1;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(work, sizeof(*work)));
  PetscCall(MpmPointWorkCreate(map, &work->point));
  for (PetscInt k = 0; k < MPM_BY_COUNT * sum->space->dim; k++) PetscCall(MpmBasisCreate(sum->space, &work->part[k]));
  for (PetscInt m = 0; m < map->rules->material_count; m++)
    parameters = PetscMax(parameters, (PetscInt)sum->materials[m].info.parameter_count);
  PetscCall(PetscCalloc3(states * MPM_PACK, &work->dstate, states * MPM_PACK, &work->state, parameters * MPM_PACK,
                         &work->parameter));
  PetscCall(PetscCalloc2((sum->kept.own + 1) * MPM_PACK, &work->own,
                         (MpmRateSizes(map) + MpmPhysicsValues(map) + 1) * MPM_PACK, &work->rates));
  PetscCall(PetscCalloc3(n * MPM_PACK, &work->du, n * MPM_PACK, &work->force, n, &work->by_argument));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmAlongWorkDestroy(MpmAlongWork *work)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < MPM_ARGUMENTS; k++) PetscCall(MpmBasisDestroy(&work->part[k]));
  PetscCall(PetscFree3(work->dstate, work->state, work->parameter));
  PetscCall(PetscFree2(work->own, work->rates));
  PetscCall(PetscFree3(work->du, work->force, work->by_argument));
  PetscCall(MpmPointWorkDestroy(&work->point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmAlongGather(const MpmStepMap *map, const MpmStepDirections *directions, const MpmGroup *group,
                    MpmAlongWork *work)
{
  PetscInt size;

  MpmPointWorkGather(map, group, NULL, &work->point);
  size = work->point.known.n * work->point.known.block;
  for (PetscInt j = 0; j < directions->count; j++)
    if (directions->of[j].du)
      MpmSumGather(work->point.known, map->sum, group, directions->of[j].du, &work->du[j * size]);
  for (PetscInt k = 0; k < size * directions->count; k++) work->force[k] = 0.;
}

void MpmAlongScatter(const MpmStepMap *map, const MpmStepDirections *directions, const MpmGroup *group,
                     const MpmAlongWork *work)
{
  const PetscInt size = work->point.known.n * work->point.known.block;

  for (PetscInt j = 0; j < directions->count; j++)
    MpmSumScatter(work->point.known, map->sum, group, &work->force[j * size], directions->residual[j]);
}

/* Numbers of a point's state in all directions, as rows. */
static void Rows(const MpmStepDirections *directions, MpmVectorField field, PetscInt p, PetscInt count,
                 PetscReal rows[])
{
  for (PetscInt j = 0; j < directions->count; j++) {
    const PetscReal *numbers = MpmPointNumbers(directions->of[j].start, field, p);

    for (PetscInt k = 0; k < count; k++) rows[k * MPM_PACK + j] = numbers[k];
  }
}

PetscErrorCode MpmAlongArguments(const MpmStepMap *map, const MpmStepDirections *directions, const MpmGroup *group,
                                 PetscInt p, MpmAlongWork *work)
{
  MpmPointWork  *point = &work->point;
  const PetscInt dim   = map->sum->space->dim;

  PetscFunctionBeginUser;
  PetscCall(MpmPointSlopesFind(map->rules, map->sum->points, group, p, &point->slopes));
  PetscCall(PetscArrayzero(work->moves, MPM_ARGUMENTS));
  for (PetscInt j = 0; j < directions->count; j++) {
    const MpmPointVector *start = directions->of[j].start;
    const PetscReal      *dx    = MpmPointNumbers(start, MPM_VECTOR_X, p);
    PetscReal             half[MPM_MAX_DIM];

    MpmPointSlopesAlong(&point->slopes, start->F_size, dx, MpmPointNumbers(start, MPM_VECTOR_F, p),
                        MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p), half);
    for (PetscInt k = 0; k < MPM_BY_COUNT * dim; k++) {
      const PetscReal change = k < dim ? dx[k] : half[k - dim];

      work->argument[k * MPM_PACK + j] = change;
      if (change != 0.) work->moves[k] = PETSC_TRUE;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Changes of inputs and of the point's displacement by these arguments. */
static void WeightsAlong(const MpmStepMap *map, const MpmGroup *group, MpmAlongWork *work)
{
  MpmPointWork  *point = &work->point;
  const PetscInt dim = map->sum->space->dim, n = point->known.n;

  for (PetscInt k = 0; k < MPM_BY_COUNT * dim; k++) {
    PetscReal inputs[MPM_MAX_INPUTS];

    if (!work->moves[k]) continue;
    MpmPointSlopesBasis(&point->slopes, group, (MpmSlopeKind)(k / dim), k % dim, &work->part[k]);
    MpmSumInputs(point->known, map->sum->layout, point->u, &work->part[k], inputs);
    for (PetscInt i = 0; i < point->known.inputs; i++)
      MpmPackAdd(inputs[i], &work->argument[k * MPM_PACK], &work->dinput[i * MPM_PACK]);
    for (PetscInt a = 0; a < dim; a++) work->place[k][a] = MpmBasisValue(&work->part[k], n, &point->u[a * n]);
  }
}

PetscErrorCode MpmAlongEnter(const MpmStepMap *map, const MpmStepDirections *directions, const MpmGroup *group,
                             PetscInt p, MpmAlongWork *work, MpmKernelPoint *at)
{
  MpmPointWork  *point = &work->point;
  const PetscInt size  = point->known.n * point->known.block;

  PetscFunctionBeginUser;
  MpmPointEnter(map, p, PETSC_FALSE, point, at);
  PetscCall(PetscArrayzero(work->dinput, (point->known.inputs + map->sum->layout->means) * MPM_PACK));
  PetscCall(MpmAlongArguments(map, directions, group, p, work));
  WeightsAlong(map, group, work);
  for (PetscInt j = 0; j < directions->count; j++) {
    if (!directions->of[j].du) continue;
    MpmSumInputs(point->known, map->sum->layout, &work->du[j * size], &point->basis, point->other_input);
    for (PetscInt k = 0; k < point->known.inputs; k++) work->dinput[k * MPM_PACK + j] += point->other_input[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The change of the law's numbers in a direction; false: none. */
static PetscBool Numbers(const MpmStepMap *map, const MpmStepDirection *direction, PetscInt p, double numbers[])
{
  const MpmSceneParameter *parameter = direction->parameter < 0 ? NULL : &map->parameters->at[direction->parameter];
  const MpmFieldParameter *field     = direction->ground ? &map->grounds->at[direction->ground->index] : NULL;

  if (field && field->material == map->sum->points->material[p]) {
    MpmGroundDirections(field,
                        MpmGroundChange(field, direction->ground->along, map->sum->points, map->sum->space->dim, p),
                        MPM_PACK, numbers);
    return PETSC_TRUE;
  }
  if (!parameter || !MpmPointHasParameter(map, parameter, p)) return PETSC_FALSE;
  MpmMaterialDirection(&map->sum->materials[parameter->index], parameter->place, 1., MPM_PACK, numbers);
  return PETSC_TRUE;
}

/* The change of what a physics with a rate takes. */
static void RatesAlong(const MpmStepMap *map, const MpmStepDirections *directions, PetscInt p, MpmAlongWork *work,
                       MpmKernelDirection *along)
{
  const PetscInt material = map->sum->points->material[p];
  PetscReal     *rows     = work->rates;

  for (PetscInt k = 0; k < MPM_RATE_NUMBERS; k++) {
    const PetscInt size = MpmRateSize(map, (MpmRateNumber)k);

    for (PetscInt j = 0; j < directions->count; j++) {
      const MpmStepDirection *of    = &directions->of[j];
      const PetscReal        *array = MpmRateArray(of->start, of->stage, (MpmRateNumber)k);

      for (PetscInt c = 0; c < size; c++) rows[c * MPM_PACK + j] = array[p * size + c];
    }
    if (size) *MpmRateMember(along, (MpmRateNumber)k) = rows;
    rows += size * MPM_PACK;
  }
  for (PetscInt k = 0; k < MpmPhysicsValues(map) * MPM_PACK; k++) rows[k] = 0.;
  for (PetscInt j = 0; j < directions->count; j++) {
    const PetscInt k = directions->of[j].parameter;

    if (k < 0 || !MpmPhysicsHasParameter(&map->parameters->at[k], material)) continue;
    MpmPhysicsDirection(map, &map->parameters->at[k], material, &rows[j]);
    along->physics_parameter = rows;
  }
}

MpmKernelDirection MpmAlongDirection(const MpmStepMap *map, const MpmStepDirections *directions, PetscInt p,
                                     MpmAlongWork *work)
{
  const MpmMaterial *material  = &map->sum->materials[map->sum->points->material[p]];
  MpmKernelDirection direction = {.input = work->dinput, .F_n = work->dF, .state_n = work->dstate, .count = MPM_PACK};

  Rows(directions, MPM_VECTOR_F, p, map->sum->points->F_size, work->dF);
  Rows(directions, MPM_VECTOR_STATE, p, material->state_size, work->dstate);
  for (size_t k = 0; k < material->info.parameter_count * MPM_PACK; k++) work->parameter[k] = 0.;
  for (PetscInt j = 0; j < directions->count; j++)
    if (Numbers(map, &directions->of[j], p, &work->parameter[j])) direction.parameter = work->parameter;
  RatesAlong(map, directions, p, work, &direction);
  return direction;
}

void MpmAlongPlace(const MpmStepMap *map, const MpmStepDirections *directions, PetscInt p, const MpmAlongWork *work)
{
  const MpmPointWork *point = &work->point;
  const PetscInt      dim = map->sum->space->dim, n = point->known.n;

  for (PetscInt j = 0; directions->end && j < directions->count; j++) {
    MpmPointVector  *end = &directions->end[j];
    PetscReal       *x   = MpmPointNumbers(end, MPM_VECTOR_X, p);
    const PetscReal *dx  = MpmPointNumbers(directions->of[j].start, MPM_VECTOR_X, p);

    for (PetscInt a = 0; a < dim; a++) {
      x[a] = dx[a];
      for (PetscInt k = 0; k < MPM_BY_COUNT * dim; k++)
        if (work->moves[k]) x[a] += work->argument[k * MPM_PACK + j] * work->place[k][a];
      if (directions->of[j].du) x[a] += MpmBasisValue(&point->basis, n, &work->du[(j * point->known.block + a) * n]);
    }
  }
}

PetscErrorCode MpmAlongDifferentiate(const MpmStepMap *map, const MpmStepDirections *directions, PetscInt p,
                                     const MpmKernelPoint *point, MpmAlongWork *work)
{
  const MpmKernelEnd       slope     = {.state = work->state, .own = work->own, .F = work->F, .stress = work->stress};
  const MpmKernelDirection direction = MpmAlongDirection(map, directions, p, work);
  const PetscInt           states    = MpmPointStates(map, p);

  PetscFunctionBeginUser;
  PetscCheck(
    !map->sum->layout->kernel->sensitivity(point, work->point.input, &direction, work->point.flux, work->dflux, &slope),
    PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no answer at the solution of its step");
  for (PetscInt j = 0; j < directions->count; j++) { /* fluxes are in proportion to the initial volume */
    const PetscReal change = MpmPointNumber(directions->of[j].start, MPM_VECTOR_VOLUME, p);

    for (PetscInt k = 0; change != 0. && k < map->sum->layout->kernel->inputs; k++)
      work->dflux[k * MPM_PACK + j] += change * work->point.flux[k];
  }
  for (PetscInt j = 0; directions->end && j < directions->count; j++) {
    MpmPointVector *end = &directions->end[j];

    for (PetscInt k = 0; k < end->F_size; k++) end->F[p * end->F_size + k] = work->F[k * MPM_PACK + j];
    for (PetscInt k = 0; k < states; k++) end->state[p * end->state_size + k] = work->state[k * MPM_PACK + j];
    for (PetscInt k = 0; k < end->size[MPM_VECTOR_OWN]; k++)
      MpmPointNumbers(end, MPM_VECTOR_OWN, p)[k] = work->own[k * MPM_PACK + j];
    MpmRatesEndAlong(map, p, work->point.input, &work->dinput[j], end);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmAlongForces(const MpmStepMap *map, const MpmStepDirections *directions, const PetscReal flux[],
                    const PetscReal dflux[], MpmAlongWork *work)
{
  const MpmPointWork *point = &work->point;
  const PetscInt      size  = point->known.n * point->known.block;

  for (PetscInt k = 0; k < MPM_BY_COUNT * map->sum->space->dim; k++) {
    if (!work->moves[k]) continue;
    for (PetscInt i = 0; i < size; i++) work->by_argument[i] = 0.;
    MpmSumAddFlux(point->known, map->sum->layout, &work->part[k], flux, work->by_argument);
    for (PetscInt j = 0; j < directions->count; j++)
      for (PetscInt i = 0; i < size; i++)
        work->force[j * size + i] += work->argument[k * MPM_PACK + j] * work->by_argument[i];
  }
  for (PetscInt j = 0; j < directions->count; j++) {
    PetscReal column[MPM_MAX_INPUTS];

    for (PetscInt k = 0; k < point->known.inputs; k++) column[k] = dflux[k * MPM_PACK + j];
    MpmSumAddFlux(point->known, map->sum->layout, &point->basis, column, &work->force[j * size]);
  }
}
