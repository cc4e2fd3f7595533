/*
  Derivatives of a step's points, in packs of directions.
*/
#include "point/material.h"
#include "stepmap/point_table.h"
#include "stepmap/rates_end.h"

/* ---- directions ---- */

/* The places of the step's parameters in a law's table, each once. */
static PetscErrorCode FindPlaces(const MpmStepMap *map, PetscInt material, PetscInt *count, PetscInt **place)
{
  PetscFunctionBeginUser;
  *count = 0;
  PetscCall(PetscMalloc1((map->parameters->count + 1), place));
  for (PetscInt k = 0; k < map->parameters->count; k++) {
    const MpmSceneParameter *parameter = &map->parameters->at[k];
    PetscInt                 at        = 0;

    if (parameter->kind != MPM_OF_LAW || parameter->index != material) continue;
    while (at < *count && (*place)[at] != parameter->place) at++;
    (*place)[at] = parameter->place;
    *count       = PetscMax(*count, at + 1);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The fields of this law. */
static PetscErrorCode FindFields(const MpmStepMap *map, PetscInt material, PetscInt *count, PetscInt **field)
{
  const PetscInt all = map->grounds ? map->grounds->count : 0;

  PetscFunctionBeginUser;
  *count = 0;
  PetscCall(PetscMalloc1((all + 1), field));
  for (PetscInt k = 0; k < all; k++)
    if (map->grounds->at[k].material == material) (*field)[(*count)++] = k;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The parameters of the physics that act on this law's points. */
static PetscErrorCode FindPhysics(const MpmStepMap *map, PetscInt material, PetscInt *count, PetscInt **number)
{
  PetscFunctionBeginUser;
  *count = 0;
  PetscCall(PetscMalloc1((map->parameters->count + 1), number));
  for (PetscInt k = 0; k < map->parameters->count; k++)
    if (MpmPhysicsHasParameter(&map->parameters->at[k], material)) (*number)[(*count)++] = k;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The columns of a pack among `count` from `first` on. */
typedef struct {
  PetscInt begin, end;
} Part;

static Part PartOf(PetscInt first, PetscInt count, PetscInt pack)
{
  return (Part){PetscMax(pack * MPM_PACK, first), PetscMin((pack + 1) * MPM_PACK, first + count)};
}

/* Unit directions for `count` numbers from a column on. */
static void Seed(PetscInt first, PetscInt count, PetscInt pack, PetscReal seeds[], const PetscReal **direction)
{
  const Part part = PartOf(first, count, pack);

  for (PetscInt c = part.begin; c < part.end; c++) seeds[(c - first) * MPM_PACK + c % MPM_PACK] = 1.;
  *direction = part.begin < part.end ? seeds : NULL;
}

/* Directions along the parameters and fields of a law. */
static void SeedNumbers(const MpmStepMap *map, const MpmMaterial *material, const MpmPointDirections *columns,
                        PetscInt pack, PetscReal seeds[], const PetscReal **direction)
{
  const Part part = PartOf(columns->parameter, columns->count - columns->parameter, pack);

  for (PetscInt c = part.begin; c < part.end; c++) {
    if (c < columns->ground)
      MpmMaterialDirection(material, columns->place[c - columns->parameter], 1., MPM_PACK, &seeds[c % MPM_PACK]);
    else
      MpmGroundDirections(&map->grounds->at[columns->field[c - columns->ground]], 1., MPM_PACK, &seeds[c % MPM_PACK]);
  }
  *direction = part.begin < part.end ? seeds : NULL;
}

/* Directions along numbers of a rate and parameters of the physics. */
static void SeedRates(const MpmStepMap *map, PetscInt material, const MpmPointDirections *columns, PetscInt pack,
                      PetscReal seeds[])
{
  MpmKernelDirection *direction = &columns->pack[pack];
  const Part          part      = PartOf(columns->physics, columns->parameter - columns->physics, pack);

  for (PetscInt k = 0; k < MPM_RATE_NUMBERS; k++) {
    const PetscInt size = MpmRateSize(map, (MpmRateNumber)k);

    Seed(columns->rate[k], size, pack, seeds, MpmRateMember(direction, (MpmRateNumber)k));
    seeds += size * MPM_PACK;
  }
  for (PetscInt c = part.begin; c < part.end; c++)
    MpmPhysicsDirection(map, &map->parameters->at[columns->number[c - columns->physics]], material,
                        &seeds[c % MPM_PACK]);
  direction->physics_parameter = part.begin < part.end ? seeds : NULL;
}

static PetscErrorCode ColumnsCreate(const MpmStepMap *map, PetscInt inputs, PetscInt material,
                                    MpmPointDirections *columns)
{
  const MpmMaterial *of   = &map->sum->materials[material];
  const PetscInt     F    = map->sum->points->F_size;
  const PetscInt     law  = inputs + F + of->state_size + (PetscInt)of->info.parameter_count;
  const PetscInt     size = law + MpmRateSizes(map) + MpmPhysicsValues(map);
  PetscInt           physics, parameters, fields;

  PetscFunctionBeginUser;
  PetscCall(FindPhysics(map, material, &physics, &columns->number));
  PetscCall(FindPlaces(map, material, &parameters, &columns->place));
  PetscCall(FindFields(map, material, &fields, &columns->field));
  columns->start   = MpmStartKindOf(map->sum, material);
  columns->F       = inputs;
  columns->state   = columns->F + (columns->start == MPM_START_COMPONENTS ? F : columns->start == MPM_START_VOLUME);
  columns->physics = columns->state + of->state_size;
  for (PetscInt k = 0; k < MPM_RATE_NUMBERS; k++) {
    columns->rate[k] = columns->physics;
    columns->physics += MpmRateSize(map, (MpmRateNumber)k);
  }
  columns->parameter = columns->physics + physics;
  columns->ground    = columns->parameter + parameters;
  columns->count     = columns->ground + fields;
  columns->packs     = (columns->count + MPM_PACK - 1) / MPM_PACK;
  columns->size      = size * MPM_PACK;
  PetscCall(PetscCalloc2(columns->packs, &columns->pack, (columns->packs * size * MPM_PACK), &columns->seeds));
  for (PetscInt k = 0; k < columns->packs; k++) {
    MpmKernelDirection *pack  = &columns->pack[k];
    PetscReal          *seeds = &columns->seeds[k * size * MPM_PACK];

    pack->count = MPM_PACK;
    Seed(0, inputs, k, seeds, &pack->input);
    Seed(columns->F, columns->state - columns->F, k, &seeds[inputs * MPM_PACK], &pack->F_n);
    Seed(columns->state, of->state_size, k, &seeds[(inputs + F) * MPM_PACK], &pack->state_n);
    SeedNumbers(map, of, columns, k, &seeds[(inputs + F + of->state_size) * MPM_PACK], &pack->parameter);
    SeedRates(map, material, columns, k, &seeds[law * MPM_PACK]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointTableCreate(const MpmStepMap *map, MpmPointTable **table)
{
  const MpmLayout *layout = map->sum->layout;
  MpmPointTable   *own, *last = *table;
  PetscInt         size;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(table));
  own                 = *table;
  own->inputs         = layout->kernel->inputs;
  own->means          = layout->means ? own->inputs - 1 : 0;
  own->rows           = 1 + own->inputs + (own->means ? 1 + own->means : 0);
  own->end            = own->rows - 1;
  own->material_count = map->rules->material_count;
  PetscCall(PetscCalloc1(own->material_count, &own->columns));
  for (PetscInt m = 0; m < own->material_count; m++) {
    PetscCall(ColumnsCreate(map, own->inputs, m, &own->columns[m]));
    own->widest = PetscMax(own->widest, own->columns[m].packs);
  }
  own->values = own->end + map->sum->points->F_size;
  own->record = own->values + own->widest * own->rows * MPM_PACK;
  size        = map->sum->points->count * own->record + 1;
  if (last && last->room >= size) {
    own->at   = last->at;
    own->room = last->room;
    last->at  = NULL;
  } else {
    own->room = size;
    PetscCall(PetscMalloc1(size, &own->at));
  }
  PetscCall(MpmPointTableDestroy(&last));
  PetscCall(PetscMalloc5((MPM_F_MAX * MPM_PACK), &own->F, (6 * MPM_PACK), &own->stress,
                         ((map->sum->kept.state + 1) * MPM_PACK), &own->state, ((map->sum->kept.own + 1) * MPM_PACK),
                         &own->own, (own->widest * MPM_PACK), &own->totals));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointTableDestroy(MpmPointTable **table)
{
  PetscFunctionBeginUser;
  if (!*table) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt m = 0; m < (*table)->material_count; m++) {
    PetscCall(PetscFree((*table)->columns[m].number));
    PetscCall(PetscFree((*table)->columns[m].place));
    PetscCall(PetscFree((*table)->columns[m].field));
    PetscCall(PetscFree2((*table)->columns[m].pack, (*table)->columns[m].seeds));
  }
  PetscCall(PetscFree5((*table)->F, (*table)->stress, (*table)->state, (*table)->own, (*table)->totals));
  PetscCall(PetscFree((*table)->columns));
  PetscCall(PetscFree((*table)->at));
  PetscCall(PetscFree(*table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- records ---- */

static inline PetscReal *Pack(const MpmPointTable *table, PetscInt p, PetscInt k)
{
  return &table->at[p * table->record + table->values + k * table->rows * MPM_PACK];
}

static inline const MpmPointDirections *Columns(const MpmStepMap *map, PetscInt p)
{
  return &map->table->columns[map->sum->points->material[p]];
}

/* The direction along F_n at point p, where its law has one. */
static void SeedDeformation(const MpmStepMap *map, PetscInt p, const MpmPointDirections *columns)
{
  const MpmPoints *points = map->sum->points;
  const PetscInt   pack = columns->F / MPM_PACK, lane = columns->F % MPM_PACK;
  PetscReal       *seeds;

  if (columns->start != MPM_START_VOLUME) return;
  seeds = &columns->seeds[pack * columns->size + map->table->inputs * MPM_PACK + lane];
  for (PetscInt k = 0; k < points->F_size; k++) seeds[k * MPM_PACK] = MpmPointF(points, p)[k];
}

PetscErrorCode MpmPointTableFill(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                                 const MpmPointVector *end, MpmPointWork *work)
{
  const MpmPointTable      *table   = map->table;
  const MpmPointDirections *columns = Columns(map, p);
  const PetscInt            states  = MpmPointStates(map, p);
  const MpmKernelEnd        slope = {.state = table->state, .own = table->own, .F = table->F, .stress = table->stress};
  PetscReal                *flux = &table->at[p * table->record], rates[MPM_MAX_INPUTS + MPM_PACK] = {0.};

  PetscFunctionBeginUser;
  MpmRatesPullInputs(map, p, work->input, end, rates);
  SeedDeformation(map, p, columns);
  for (PetscInt k = 0; k < columns->packs; k++) {
    PetscReal *bars = Pack(table, p, k);

    PetscCheck(
      !map->sum->layout->kernel->sensitivity(point, work->input, &columns->pack[k], flux, &bars[MPM_PACK], &slope),
      PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no answer at the solution of its step");
    for (PetscInt j = 0; j < MPM_PACK; j++) bars[j] = k * MPM_PACK < table->inputs ? rates[k * MPM_PACK + j] : 0.;
    for (PetscInt c = 0; c < end->F_size; c++) MpmPackAdd(end->F[p * end->F_size + c], &table->F[c * MPM_PACK], bars);
    for (PetscInt c = 0; c < states; c++)
      MpmPackAdd(end->state[p * end->state_size + c], &table->state[c * MPM_PACK], bars);
    for (PetscInt c = 0; c < end->size[MPM_VECTOR_OWN]; c++)
      MpmPackAdd(MpmPointNumbers(end, MPM_VECTOR_OWN, p)[c], &table->own[c * MPM_PACK], bars);
  }
  for (PetscInt k = 0; k < end->F_size; k++) flux[table->end + k] = work->F[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointTableFillMean(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point, MpmPointWork *work)
{
  const MpmPointTable      *table   = map->table;
  const MpmPointDirections *columns = Columns(map, p);
  PetscReal                *own     = &table->at[p * table->record + table->inputs];
  PetscReal                 m[1 + MPM_PACK];

  PetscFunctionBeginUser;
  SeedDeformation(map, p, columns);
  for (PetscInt k = 0; k < columns->packs; k++) {
    PetscReal *rows = Pack(table, p, k) + (1 + table->inputs) * MPM_PACK;

    PetscCheck(
      !map->sum->layout->kernel->mean_sensitivity(point, work->input, &columns->pack[k], m, &own[1], &rows[MPM_PACK]),
      PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no mean at the solution of its step");
    own[0] = m[0];
    PetscCall(PetscArraycpy(rows, &m[1], MPM_PACK));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPointTableTotals(const MpmStepMap *map, PetscInt p, PetscInt packs, const MpmMeanPull *mean, MpmPointWork *work,
                         PetscReal totals[])
{
  const MpmPointTable *table = map->table;
  const PetscReal     *K     = work->other_input;

  for (PetscInt k = 0; k < packs; k++) {
    const PetscReal *row = Pack(table, p, k);
    PetscReal       *sum = &totals[k * MPM_PACK];

    for (PetscInt j = 0; j < MPM_PACK; j++) sum[j] = row[j];
    row += MPM_PACK;
    for (PetscInt c = 0; c < work->known.inputs; c++, row += MPM_PACK) MpmPackAdd(-K[c], row, sum);
    if (!mean) continue;
    MpmPackAdd(-mean->along, row, sum);
    MpmPackAdd(mean->by_mean * mean->share, row + MPM_PACK, sum);
    row += 2 * MPM_PACK;
    for (PetscInt c = 0; c < table->means; c++, row += MPM_PACK) MpmPackAdd(-mean->flux * mean->share * K[c], row, sum);
  }
}

/* The derivatives by F at the step's start. */
static void AddStart(const MpmStepMap *map, PetscInt p, const MpmPointVector *end, const MpmPointWork *work,
                     const PetscReal totals[], MpmPointVector *start)
{
  const MpmPointDirections *columns = Columns(map, p);
  const PetscReal          *flux    = MpmPointTableFlux(map->table, p);
  PetscReal                *by_F    = &start->F[p * start->F_size];

  if (columns->start == MPM_START_ELASTIC)
    MpmStartPullElastic(map->sum, p, work->input, flux, totals, work->other_input, by_F);
  else if (columns->start == MPM_START_VOLUME)
    MpmStartPullVolume(map->sum, p, totals[columns->F], &flux[map->table->end], &end->F[p * end->F_size], by_F);
  else
    for (PetscInt k = 0; k < start->F_size; k++) by_F[k] += totals[columns->F + k];
}

void MpmPointTableAdd(const MpmStepMap *map, PetscInt p, const MpmPointVector *end, const MpmPointWork *work,
                      const PetscReal totals[], MpmPointVector *start, PetscReal gradient[])
{
  const MpmPointDirections *columns = Columns(map, p);

  AddStart(map, p, end, work, totals, start);
  for (PetscInt c = columns->state; c < columns->rate[0]; c++)
    start->state[p * start->state_size + c - columns->state] += totals[c];
  for (PetscInt k = 0; k < MPM_RATE_NUMBERS; k++) {
    const PetscInt size  = MpmRateSize(map, (MpmRateNumber)k);
    PetscReal     *array = MpmRateArray(start, map->stage, (MpmRateNumber)k);

    for (PetscInt c = 0; c < size; c++) array[p * size + c] += totals[columns->rate[k] + c];
  }
  for (PetscInt c = columns->physics; c < columns->parameter; c++)
    gradient[columns->number[c - columns->physics]] += totals[c];
  for (PetscInt c = columns->ground; c < columns->count; c++)
    MpmGroundTakePoint(&map->grounds->at[columns->field[c - columns->ground]], map->sum->points, start->dim, p,
                       totals[c]);
  if (columns->ground == columns->parameter) return;
  for (PetscInt k = 0; k < map->parameters->count; k++) {
    const MpmSceneParameter *parameter = &map->parameters->at[k];
    PetscInt                 at        = 0;

    if (!MpmPointHasParameter(map, parameter, p)) continue;
    while (columns->place[at] != parameter->place) at++;
    gradient[k] += totals[columns->parameter + at];
  }
}
