/*
  Derivatives of a step's points, in packs of directions.
*/
#include "particles/points.h"
#include "point/material.h"
#include "stepmap/point_table.h"

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

/* Directions along the parameters at these places. */
static void SeedParameters(const MpmMaterial *material, const PetscInt place[], PetscInt first, PetscInt count,
                           PetscInt pack, PetscReal seeds[], const PetscReal **direction)
{
  const Part part = PartOf(first, count, pack);

  for (PetscInt c = part.begin; c < part.end; c++)
    MpmMaterialDirection(material, place[c - first], 1., MPM_PACK, &seeds[c % MPM_PACK]);
  *direction = part.begin < part.end ? seeds : NULL;
}

static PetscErrorCode ColumnsCreate(const MpmStepMap *map, PetscInt inputs, PetscInt material,
                                    MpmPointDirections *columns)
{
  const MpmMaterial *of   = &map->sum->materials[material];
  const PetscInt     F    = map->sum->points->F_size;
  const PetscInt     size = inputs + F + of->state_size + (PetscInt)of->info.parameter_count;
  PetscInt           parameters;

  PetscFunctionBeginUser;
  PetscCall(FindPlaces(map, material, &parameters, &columns->place));
  columns->F         = inputs;
  columns->state     = columns->F + F;
  columns->parameter = columns->state + of->state_size;
  columns->count     = columns->parameter + parameters;
  columns->packs     = (columns->count + MPM_PACK - 1) / MPM_PACK;
  PetscCall(PetscCalloc2(columns->packs, &columns->pack, (columns->packs * size * MPM_PACK), &columns->seeds));
  for (PetscInt k = 0; k < columns->packs; k++) {
    MpmKernelDirection *pack  = &columns->pack[k];
    PetscReal          *seeds = &columns->seeds[k * size * MPM_PACK];

    pack->count = MPM_PACK;
    Seed(0, inputs, k, seeds, &pack->input);
    Seed(columns->F, F, k, &seeds[inputs * MPM_PACK], &pack->F_n);
    Seed(columns->state, of->state_size, k, &seeds[(inputs + F) * MPM_PACK], &pack->state_n);
    SeedParameters(of, columns->place, columns->parameter, parameters, k,
                   &seeds[(inputs + F + of->state_size) * MPM_PACK], &pack->parameter);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmStepHasTable(const MpmStepMap *map)
{
  const MpmSum *sum = map->sum;

  for (PetscInt k = 0; k < map->parameters->count; k++) {
    const MpmSceneParameterKind kind = map->parameters->at[k].kind;

    if (kind != MPM_OF_LAW && kind != MPM_OF_LOAD && kind != MPM_OF_OPTION) return PETSC_FALSE;
  }
  if (map->grounds && map->grounds->count) return PETSC_FALSE;
  if (map->constants.shapes || sum->space->cells.spread || sum->layout->kinematics == MPM_AXISYMMETRY)
    return PETSC_FALSE;
  return (PetscBool)(!sum->layout->rate.count && !sum->layout->deviation.count && !sum->kept.own);
}

PetscErrorCode MpmPointTableCreate(const MpmStepMap *map, MpmPointTable **table)
{
  const MpmLayout *layout = map->sum->layout;
  MpmPointTable   *own;

  PetscFunctionBeginUser;
  *table = NULL;
  if (!MpmStepHasTable(map)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(table));
  own                 = *table;
  own->inputs         = layout->kernel->inputs;
  own->means          = layout->means ? own->inputs - 1 : 0;
  own->values         = own->inputs + (own->means ? 1 + own->means : 0);
  own->rows           = 1 + own->values;
  own->material_count = map->rules->material_count;
  PetscCall(PetscCalloc1(own->material_count, &own->columns));
  for (PetscInt m = 0; m < own->material_count; m++) {
    PetscCall(ColumnsCreate(map, own->inputs, m, &own->columns[m]));
    own->widest = PetscMax(own->widest, own->columns[m].packs);
  }
  own->record = own->values + own->widest * own->rows * MPM_PACK;
  PetscCall(PetscMalloc1((map->sum->points->count * own->record + 1), &own->at));
  PetscCall(PetscMalloc4((MPM_F_MAX * MPM_PACK), &own->F, (6 * MPM_PACK), &own->stress,
                         ((map->sum->kept.state + 1) * MPM_PACK), &own->state, (own->widest * MPM_PACK), &own->totals));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointTableDestroy(MpmPointTable **table)
{
  PetscFunctionBeginUser;
  if (!*table) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt m = 0; m < (*table)->material_count; m++) {
    PetscCall(PetscFree((*table)->columns[m].place));
    PetscCall(PetscFree2((*table)->columns[m].pack, (*table)->columns[m].seeds));
  }
  PetscCall(PetscFree4((*table)->F, (*table)->stress, (*table)->state, (*table)->totals));
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

/* sum += factor row */
static inline void AddRow(PetscReal factor, const PetscReal row[], PetscReal sum[])
{
  for (PetscInt j = 0; j < MPM_PACK; j++) sum[j] += factor * row[j];
}

PetscErrorCode MpmPointTableFill(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                                 const MpmPointVector *end, MpmPointWork *work)
{
  const MpmPointTable      *table   = map->table;
  const MpmPointDirections *columns = Columns(map, p);
  const PetscInt            states  = map->sum->materials[map->sum->points->material[p]].state_size;
  const MpmKernelEnd        slope   = {.state = table->state, .F = table->F, .stress = table->stress};
  PetscReal                *flux    = &table->at[p * table->record];

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < columns->packs; k++) {
    PetscReal *bars = Pack(table, p, k);

    PetscCheck(
      !map->sum->layout->kernel->sensitivity(point, work->input, &columns->pack[k], flux, &bars[MPM_PACK], &slope),
      PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no answer at the solution of its step");
    for (PetscInt j = 0; j < MPM_PACK; j++) bars[j] = 0.;
    for (PetscInt c = 0; c < end->F_size; c++) AddRow(end->F[p * end->F_size + c], &table->F[c * MPM_PACK], bars);
    for (PetscInt c = 0; c < states; c++)
      AddRow(end->state[p * end->state_size + c], &table->state[c * MPM_PACK], bars);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointTableFillMean(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point, MpmPointWork *work)
{
  const MpmPointTable      *table   = map->table;
  const MpmPointDirections *columns = Columns(map, p);
  PetscReal                *own     = &table->at[p * table->record + table->inputs];
  PetscReal                 m[1 + MPM_PACK];

  PetscFunctionBeginUser;
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
    for (PetscInt c = 0; c < work->known.inputs; c++, row += MPM_PACK) AddRow(-K[c], row, sum);
    if (!mean) continue;
    AddRow(-mean->along, row, sum);
    AddRow(mean->by_mean * mean->share, row + MPM_PACK, sum);
    row += 2 * MPM_PACK;
    for (PetscInt c = 0; c < table->means; c++, row += MPM_PACK) AddRow(-mean->flux * mean->share * K[c], row, sum);
  }
}

void MpmPointTableAdd(const MpmStepMap *map, PetscInt p, const PetscReal totals[], MpmPointVector *start,
                      PetscReal gradient[])
{
  const MpmPointDirections *columns = Columns(map, p);

  for (PetscInt c = columns->F; c < columns->state; c++) start->F[p * start->F_size + c - columns->F] += totals[c];
  for (PetscInt c = columns->state; c < columns->parameter; c++)
    start->state[p * start->state_size + c - columns->state] += totals[c];
  if (columns->count == columns->parameter) return;
  for (PetscInt k = 0; k < map->parameters->count; k++) {
    const MpmSceneParameter *parameter = &map->parameters->at[k];
    PetscInt                 at        = 0;

    if (!MpmPointHasParameter(map, parameter, p)) continue;
    while (columns->place[at] != parameter->place) at++;
    gradient[k] += totals[columns->parameter + at];
  }
}
