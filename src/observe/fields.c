/*
  The points' fields that are written: the scene's choice, made one at a time while they are written.
*/
#include <string.h>
#include "options/options.h"
#include "point/air.h"
#include "particles/particles.h"
#include "particles/points.h"
#include "query/model.h"
#include "observe/point_columns.h"
#include "observe/results.h"

/* ---- the choice ---- */

static PetscBool IsListed(PetscInt count, char *const names[], const char name[])
{
  for (PetscInt k = 0; k < count; k++)
    if (!strcmp(names[k], name)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Appends the names of the columns. */
static PetscErrorCode AppendNames(const MpmPointColumns *columns, size_t size, char text[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < columns->count; k++) {
    if (text[0]) PetscCall(PetscStrlcat(text, ", ", size));
    PetscCall(PetscStrlcat(text, columns->at[k].name, size));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Registers the derived fields that the scene asks for, in one list or the other. */
static PetscErrorCode AddDerived(MpmModel model, MpmWrittenStates *states)
{
  MpmPointColumns columns    = {0};
  char            known[512] = "", *unknown = NULL;

  PetscFunctionBeginUser;
  PetscCall(MpmDerivedAddColumns(model, &columns));
  PetscCall(AppendNames(&columns, sizeof(known), known));
  if (states->derived_count == 1 && !strcmp(states->derived[0], "all")) {
    PetscCall(MpmNamesDestroy(states->derived_count, &states->derived));
    PetscCall(MpmTextSplit(known, &states->derived_count, &states->derived));
  }
  for (PetscInt k = 0; k < states->derived_count; k++)
    if (!MpmPointColumnsHave(&columns, states->derived[k])) unknown = states->derived[k];
  for (PetscInt k = 0; k < columns.count; k++) {
    const char *name = columns.at[k].name;

    if (IsListed(states->derived_count, states->derived, name) || IsListed(states->chosen_count, states->chosen, name))
      PetscCall(MpmPointColumnsAdd(&states->fields, &columns.at[k]));
  }
  PetscCall(PetscFree(columns.at));
  MpmCheckInput(!unknown, "-mpm_output_derived %s: there is no such field, must be of %s, or all", unknown, known);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldsSetUp(MpmModel model)
{
  MpmWrittenStates      *states      = &model->results->states;
  const MpmPointColumns *added       = &model->results->added.fields;
  char                   known[1024] = "";

  PetscFunctionBeginUser;
  PetscCall(MpmPointsAddColumns(model, &states->fields));
  PetscCall(MpmStatesAddColumns(model, &states->fields));
  PetscCall(MpmTerrainAddFields(model, &states->fields));
  for (PetscInt k = 0; k < added->count; k++) {
    PetscCheck(!MpmPointColumnsHave(&states->fields, added->at[k].name), model->comm, PETSC_ERR_ARG_OUTOFRANGE,
               "the results have a field %s of the scene's", added->at[k].name);
    PetscCall(MpmPointColumnsAdd(&states->fields, &added->at[k]));
  }
  PetscCall(AddDerived(model, states));
  PetscCall(AppendNames(&states->fields, sizeof(known), known));
  for (PetscInt k = 0; k < states->chosen_count; k++)
    MpmCheckInput(MpmPointColumnsHave(&states->fields, states->chosen[k]),
                  "-mpm_output_fields %s: there is no such field, must be of %s", states->chosen[k], known);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the output ---- */

/* A field that is written. */
typedef struct {
  MpmModel              model;
  const MpmPointColumn *column;
  void                 *array; /* of the points, lent; NULL: the field is made */
} Source;

static PetscErrorCode Fill(const void *ctx, PetscReal values[])
{
  const Source *source = (const Source *)ctx;

  PetscFunctionBeginUser;
  PetscCall((*source->column->fill)(source->model, source->column, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a field is chosen; without a choice, all are. */
static PetscBool IsChosen(const MpmWrittenStates *states, const char *name)
{
  return (PetscBool)(!states->chosen_count || IsListed(states->chosen_count, states->chosen, name) ||
                     IsListed(states->derived_count, states->derived, name));
}

/* The dataset of a field; `source` stays while it is written. */
static PetscErrorCode AddDataset(Source *source, MpmDataset *set)
{
  const MpmPointColumn *column    = source->column;
  MpmParticles         *particles = source->model->state.particles;

  PetscFunctionBeginUser;
  *set = (MpmDataset){.name = column->name, .components = column->components};
  if (column->fill) {
    set->fill = Fill;
    set->ctx  = source;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmParticlesGetField(particles, column->name, &source->array));
  for (PetscInt k = 0; k < particles->field_count; k++) {
    if (strcmp(particles->fields[k].name, column->name)) continue;
    if (particles->fields[k].integer) set->integer = (const PetscInt *)source->array;
    else set->real = (const PetscReal *)source->array;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A dataset without the rows of air. */
typedef struct {
  MpmDataset      whole;
  PetscInt        count, kept; /* rows of both */
  const PetscInt *row;         /* of each that is kept */
  PetscInt       *integer;
} Kept;

static PetscErrorCode FillKept(const void *ctx, PetscReal values[])
{
  const Kept      *kept = (const Kept *)ctx;
  const PetscInt   n    = kept->whole.components;
  const PetscReal *from = kept->whole.real;
  PetscReal       *made = NULL;

  PetscFunctionBeginUser;
  if (kept->whole.fill) {
    PetscCall(PetscMalloc1((kept->count * n), &made));
    PetscCall((*kept->whole.fill)(kept->whole.ctx, made));
    from = made;
  }
  for (PetscInt k = 0; k < kept->kept; k++)
    for (PetscInt c = 0; c < n; c++) values[k * n + c] = from[kept->row[k] * n + c];
  PetscCall(PetscFree(made));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The rows that are not air, and the datasets with these alone; integers are copied. */
static PetscErrorCode LeaveAir(const MpmModel model, const MpmPoints *points, PetscInt count, MpmDataset sets[],
                               PetscInt *kept_count, PetscInt **rows, Kept **kept)
{
  PetscInt *row;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(points->count, &row));
  PetscCall(PetscCalloc1(count, kept));
  *kept_count = 0;
  for (PetscInt p = 0; p < points->count; p++)
    if (!MpmMaterialIsAir(&model->scene.materials->at[points->material[p]])) row[(*kept_count)++] = p;
  for (PetscInt i = 0; i < count; i++) {
    Kept          *one = &(*kept)[i];
    const PetscInt n   = sets[i].components;

    *one         = (Kept){sets[i], points->count, *kept_count, row, NULL};
    sets[i].real = NULL;
    if (sets[i].integer) {
      PetscCall(PetscMalloc1((*kept_count * n), &one->integer));
      for (PetscInt k = 0; k < *kept_count * n; k++) one->integer[k] = sets[i].integer[row[k / n] * n + k % n];
      sets[i].integer = one->integer;
      continue;
    }
    sets[i].fill = FillKept;
    sets[i].ctx  = one;
  }
  *rows = row;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Writes the state, without points of air unless they are asked for. */
static PetscErrorCode WriteRows(MpmModel model, const MpmPoints *points, PetscInt count, MpmDataset sets[])
{
  const MpmWrittenStates *states     = &model->results->states;
  PetscBool               air        = PETSC_FALSE;
  PetscInt                kept_count = 0, *rows = NULL, *id;
  Kept                   *kept;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->scene.materials->count && !states->air; m++)
    air = (PetscBool)(air || MpmMaterialIsAir(&model->scene.materials->at[m]));
  if (!air) {
    PetscCall(
      MpmOutputWrite(states->file, model->state.step, model->state.time, points->count, points->id, count, sets));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(LeaveAir(model, points, count, sets, &kept_count, &rows, &kept));
  PetscCall(PetscMalloc1(kept_count, &id));
  for (PetscInt k = 0; k < kept_count; k++) id[k] = points->id[rows[k]];
  PetscCall(MpmOutputWrite(states->file, model->state.step, model->state.time, kept_count, id, count, sets));
  for (PetscInt i = 0; i < count; i++) PetscCall(PetscFree(kept[i].integer));
  PetscCall(PetscFree(kept));
  PetscCall(PetscFree(rows));
  PetscCall(PetscFree(id));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldsWrite(MpmModel model)
{
  const MpmWrittenStates *states    = &model->results->states;
  const MpmPointColumns  *fields    = &states->fields;
  MpmParticles           *particles = model->state.particles;
  PetscInt                count     = 0;
  MpmPoints               points;
  MpmDataset             *sets;
  Source                 *sources;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(particles, &points));
  PetscCall(PetscMalloc1((fields->count + 2), &sets));
  PetscCall(PetscCalloc1(fields->count, &sources));
  sets[count++] = (MpmDataset){.name = "position", .components = particles->dim, .real = points.x};
  if (!MpmOutputStarted(states->file) || model->state.reference_output)
    sets[count++] = (MpmDataset){.name = "position0", .components = particles->dim, .real = points.x0};
  model->state.reference_output = PETSC_FALSE;
  for (PetscInt i = 0; i < fields->count; i++) {
    sources[i] = (Source){model, &fields->at[i], NULL};
    if (IsChosen(states, fields->at[i].name)) PetscCall(AddDataset(&sources[i], &sets[count++]));
  }
  PetscCall(MpmOutputSetBehind(states->file, model->state.scheme.behind));
  PetscCall(WriteRows(model, &points, count, sets));
  for (PetscInt i = 0; i < fields->count; i++)
    if (sources[i].array) PetscCall(MpmParticlesRestoreField(particles, &sources[i].array));
  PetscCall(PetscFree(sources));
  PetscCall(PetscFree(sets));
  PetscCall(MpmParticlesRestoreArrays(particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}
