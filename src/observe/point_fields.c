/*
  The fields of the points that are written, made one at a time while they are.
*/
#include "point/layout.h"
#include "point/material.h"
#include "point/strain_measure.h"
#include "grid/shape.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "volume/inertia.h"
#include "query/model.h"
#include "observe/results.h"

/* One field: data of the functions below. */
typedef struct {
  MpmModel         model;
  const MpmPoints *points;
  const char      *state; /* a history variable's or a parameter's name */
  PetscInt         first; /* of its own states, where the physics has it */
  PetscInt         rate;  /* which value with a rate */
  PetscInt         components;
} Source;

/* Symmetric tensors are written with six components: xx, yy, zz, xy, yz, xz. */
static void CopySym(PetscInt dim, const PetscReal from[], PetscReal to[])
{
  for (PetscInt c = 0; c < 6; c++) to[c] = c < MpmSymSize(dim) ? from[c] : 0.;
}

/* In plane strain the third axis does not stretch. */
static void CopyF(PetscInt dim, const MpmPoints *points, PetscInt p, PetscReal to[])
{
  const PetscReal *from = MpmPointF(points, p);

  for (PetscInt a = 0; a < 3; a++)
    for (PetscInt b = 0; b < 3; b++) to[3 * a + b] = a < dim && b < dim ? from[a * dim + b] : a == b ? 1. : 0.;
  if (points->F_size > dim * dim) to[8] = from[dim * dim];
}

static PetscErrorCode FillDisplacement(const void *ctx, PetscReal values[])
{
  const MpmPoints *points = ((const Source *)ctx)->points;
  const PetscInt   dim    = ((const Source *)ctx)->model->disc.dim;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < points->count * dim; k++) values[k] = points->x[k] - points->x0[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillStress(const void *ctx, PetscReal values[])
{
  const Source *source = (const Source *)ctx;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < source->points->count; p++) {
    CopySym(source->model->disc.dim, &source->points->stress[p * source->model->state.particles->stress_size],
            &values[6 * p]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* In saturated ground the volume of the water's balance: of laws of small strain 1 + tr(F - I), the change of which is
   the flow. */
static PetscErrorCode FillVolume(const void *ctx, PetscReal values[])
{
  const MpmPoints *points = ((const Source *)ctx)->points;
  const MpmModel   model  = ((const Source *)ctx)->model;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal *F = MpmPointF(points, p);

    values[p] = points->volume0[p] * (model->disc.layout->own.taken_up < 0
                                        ? MpmPointJ(points, p)
                                        : MpmPointVolumeRatio(&model->scene.materials->at[points->material[p]], F));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillMass(const void *ctx, PetscReal values[])
{
  const MpmPoints   *points    = ((const Source *)ctx)->points;
  const MpmMaterial *materials = ((const Source *)ctx)->model->scene.materials->at;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++)
    values[p] = MpmPointMassNow(points, materials, ((const Source *)ctx)->model->disc.layout, p);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillF(const void *ctx, PetscReal values[])
{
  const MpmPoints *points = ((const Source *)ctx)->points;
  const PetscInt   dim    = ((const Source *)ctx)->model->disc.dim;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++) CopyF(dim, points, p, &values[9 * p]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ln V in the plane, V V = F F^T */
static void PlaneLogStrain(const PetscReal F[4], PetscReal strain[6])
{
  const PetscReal xx = F[0] * F[0] + F[1] * F[1], yy = F[2] * F[2] + F[3] * F[3], xy = F[0] * F[2] + F[1] * F[3],
                  J = F[0] * F[3] - F[1] * F[2], mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy);
  const PetscReal radius = PetscSqrtReal(half * half + xy * xy), large = PetscLogReal(mean + radius);
  const PetscReal volume = PetscLogReal(J),
                  shear  = 0.5 * large - 0.5 * volume; /* half of the principal strains' difference */
  const PetscReal by     = radius > PETSC_SQRT_MACHINE_EPSILON * mean ? shear / radius : 0.5 / mean;

  for (PetscInt k = 0; k < 6; k++) strain[k] = 0.;
  strain[0] = 0.5 * volume + by * half;
  strain[1] = 0.5 * volume - by * half;
  strain[3] = by * xy;
}

/* The total strain: ln V, or of laws of small strain sym(F) - I. */
static PetscErrorCode FillStrain(const void *ctx, PetscReal values[])
{
  const MpmPoints *points = ((const Source *)ctx)->points;
  const MpmModel   model  = ((const Source *)ctx)->model;
  const PetscInt   dim    = model->disc.dim;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++) {
    const unsigned traits = model->scene.materials->at[points->material[p]].info.traits;
    PetscReal      F[9];

    if (dim == 2 && !(traits & MPM_LAW_SMALL_STRAIN)) {
      PlaneLogStrain(MpmPointF(points, p), &values[6 * p]);
      if (points->F_size == 5) values[6 * p + 2] = PetscLogReal(MpmPointF(points, p)[4]);
      continue;
    }
    CopyF(dim, points, p, F);
    PetscCall(MpmStrainFromDeformation(traits & MPM_LAW_SMALL_STRAIN ? MPM_STRAIN_ENGINEERING : MPM_STRAIN_LOG, F,
                                       &values[6 * p]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A history variable: zero where a point's law has none of this name. */
static PetscErrorCode FillState(const void *ctx, PetscReal values[])
{
  const Source    *source = (const Source *)ctx;
  const MpmPoints *points = source->points;
  const MpmModel   model  = source->model;

  PetscFunctionBeginUser;
  PetscCall(PetscArrayzero(values, points->count * source->components));
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    const MpmLawInfo *info  = &model->scene.materials->at[m].info;
    PetscInt          first = 0;
    size_t            v     = 0;

    while (v < info->state_count && strcmp(info->states[v].name, source->state))
      first += MpmStateComponents(&info->states[v++], model->disc.dim);
    for (PetscInt p = 0; p < points->count && v < info->state_count; p++) {
      const PetscReal *state = &points->state[p * model->state.particles->state_size + first];

      if (points->material[p] != m) continue;
      if (source->components == 6) CopySym(model->disc.dim, state, &values[6 * p]);
      else values[p] = state[0];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A parameter of laws that varies: zero where a point's law has none of this name. */
static PetscErrorCode FillParameter(const void *ctx, PetscReal values[])
{
  const Source    *source = (const Source *)ctx;
  const MpmPoints *points = source->points;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < points->count; p++) {
    const MpmMaterial *material = &source->model->scene.materials->at[points->material[p]];
    const double      *own      = MpmPointOwn(points, material, p);
    size_t             k        = 0;

    while (k < material->info.parameter_count && strcmp(material->info.parameters[k].name, source->state)) k++;
    values[p] = k == material->info.parameter_count ? 0. : own ? own[k] : material->parameter[k];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A state of the physics' own. */
static PetscErrorCode FillOwn(const void *ctx, PetscReal values[])
{
  const Source    *source = (const Source *)ctx;
  const PetscInt   dim = source->model->disc.dim, size = source->model->disc.layout->own.size;
  const PetscReal *own = source->points->own;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < source->points->count; p++) {
    const PetscReal *from = &own[p * size + source->first];

    if (source->components == 6) CopySym(dim, from, &values[6 * p]);
    else
      for (PetscInt c = 0; c < source->components; c++) values[source->components * p + c] = from[c];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillRate(const void *ctx, PetscReal values[])
{
  const Source  *source = (const Source *)ctx;
  const PetscInt rates  = source->model->disc.layout->rate.count;

  PetscFunctionBeginUser;
  for (PetscInt p = 0; p < source->points->count; p++) values[p] = source->points->value[p * rates + source->rate];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the list ---- */

/* All fields of a model that may be chosen. Points may be NULL for names alone. */
typedef struct {
  PetscInt    count;
  MpmDataset *set;
  Source     *source;
} Fields;

static void Add(Fields *fields, const MpmDataset *set, const Source *source)
{
  for (PetscInt k = 0; k < fields->count; k++)
    if (!strcmp(fields->set[k].name, set->name)) return; /* several laws have it */
  fields->source[fields->count]            = *source;
  fields->source[fields->count].components = set->components;
  fields->set[fields->count]               = *set;
  if (set->fill) fields->set[fields->count].ctx = &fields->source[fields->count];
  fields->count++;
}

/* Parameters of laws that vary, as they are in force. */
static void AddParameters(MpmModel model, Source source, Fields *fields)
{
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    const MpmMaterial *material = &model->scene.materials->at[m];

    for (PetscInt v = 0; material->varies && v < material->varies->count; v++) {
      const PetscInt place = material->varies->at[v].place;

      if (place >= (PetscInt)material->info.parameter_count) continue;
      source.state = material->info.parameters[place].name;
      Add(fields, &(MpmDataset){.name = source.state, .components = 1, .fill = FillParameter}, &source);
    }
  }
}

static PetscErrorCode FieldsCreate(MpmModel model, const MpmPoints *points, Fields *fields)
{
  const PetscInt   dim      = model->disc.dim;
  Source           source   = {.model = model, .points = points};
  const MpmDataset always[] = {
    {.name = "material", .components = 1, .integer = points ? points->material : NULL},
    {.name = "displacement", .components = dim, .fill = FillDisplacement},
    {.name = "stress", .components = 6, .fill = FillStress},
    {.name = "strain", .components = 6, .fill = FillStrain},
    {.name = "volume", .components = 1, .fill = FillVolume},
    {.name = "mass", .components = 1, .fill = FillMass},
    {.name = "F", .components = 9, .fill = FillF},
    {.name = "half_length", .components = dim, .real = points ? points->half_length : NULL},
  };
  const size_t known    = PETSC_STATIC_ARRAY_LENGTH(always) - (MpmShapeHasDomain(model->scene.shape) ? 0 : 1);
  PetscInt     capacity = (PetscInt)known + 1 + model->disc.layout->rate.count + model->scene.physics.state_count;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < model->scene.materials->count; m++)
    capacity +=
      (PetscInt)(model->scene.materials->at[m].info.state_count + model->scene.materials->at[m].info.parameter_count);
  fields->count = 0;
  PetscCall(PetscMalloc2(capacity, &fields->set, capacity, &fields->source));
  for (size_t k = 0; k < known; k++) Add(fields, &always[k], &source);
  if (model->disc.context.inertia->dynamic)
    Add(fields, &(MpmDataset){.name = "velocity", .components = dim, .real = points ? points->velocity : NULL},
        &source);
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    for (size_t v = 0; v < model->scene.materials->at[m].info.state_count; v++) {
      const MpmStateVariable *variable = &model->scene.materials->at[m].info.states[v];
      const MpmDataset        set      = {
                    .name = variable->name, .components = variable->kind == MPM_STATE_SYM ? 6 : 1, .fill = FillState};

      source.state = variable->name;
      Add(fields, &set, &source);
    }
  }
  for (PetscInt s = 0; s < model->scene.physics.state_count; s++) {
    const MpmStateVariable *variable = &model->scene.physics.states[s];
    const PetscInt          size     = MpmStateComponents(variable, dim);
    const MpmDataset        set      = {
                  .name = variable->name, .components = variable->kind == MPM_STATE_SYM ? 6 : size, .fill = FillOwn};

    Add(fields, &set, &source);
    source.first += MpmStateComponents(variable, dim);
  }
  for (source.rate = 0; source.rate < model->disc.layout->rate.count; source.rate++) {
    const MpmDataset set = {.name = model->disc.layout->component[model->disc.layout->rate.component[source.rate]].name,
                            .components = 1,
                            .fill       = FillRate};

    Add(fields, &set, &source);
  }
  AddParameters(model, source, fields);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FieldsDestroy(Fields *fields)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(fields->set, fields->source));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a field is chosen; without a choice, all are. */
static PetscBool IsChosen(MpmModel model, const char *name)
{
  for (PetscInt k = 0; k < model->results->output_field_count; k++)
    if (!strcmp(model->results->output_fields[k], name)) return PETSC_TRUE;
  return (PetscBool)(!model->results->output_field_count);
}

PetscErrorCode MpmFieldsCheck(MpmModel model)
{
  Fields fields;
  char   known[1024] = "";

  PetscFunctionBeginUser;
  PetscCall(FieldsCreate(model, NULL, &fields));
  for (PetscInt i = 0; i < fields.count; i++) {
    if (i) PetscCall(PetscStrlcat(known, ", ", sizeof(known)));
    PetscCall(PetscStrlcat(known, fields.set[i].name, sizeof(known)));
  }
  for (PetscInt k = 0; k < model->results->output_field_count; k++) {
    PetscBool found = PETSC_FALSE;

    for (PetscInt i = 0; i < fields.count; i++)
      if (!strcmp(fields.set[i].name, model->results->output_fields[k])) found = PETSC_TRUE;
    MpmCheckInput(found, "-mpm_output_fields %s: there is no such field, must be of %s",
                  model->results->output_fields[k], known);
  }
  PetscCall(FieldsDestroy(&fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFieldsWrite(MpmModel model)
{
  const PetscInt dim   = model->disc.dim;
  PetscInt       count = 0;
  MpmPoints      points;
  MpmDataset    *sets;
  Fields         fields;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(FieldsCreate(model, &points, &fields));
  PetscCall(PetscMalloc1((fields.count + 2), &sets));
  sets[count++] = (MpmDataset){.name = "position", .components = dim, .real = points.x};
  if (!MpmOutputStarted(model->results->output) || model->state.reference_output)
    sets[count++] = (MpmDataset){.name = "position0", .components = dim, .real = points.x0};
  model->state.reference_output = PETSC_FALSE;
  for (PetscInt i = 0; i < fields.count; i++)
    if (IsChosen(model, fields.set[i].name)) sets[count++] = fields.set[i];
  PetscCall(MpmOutputSetBehind(model->results->output, model->state.scheme.behind));
  PetscCall(
    MpmOutputWrite(model->results->output, model->state.step, model->state.time, points.count, points.id, count, sets));
  PetscCall(PetscFree(sets));
  PetscCall(FieldsDestroy(&fields));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}
