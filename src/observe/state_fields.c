/*
  Fields of the points' histories, parameters and values in the results: of the laws, and of the physics.
*/
#include <string.h>
#include "point/layout.h"
#include "point/material.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "query/model.h"
#include "observe/point_columns.h"

/* Numbers of a variable at a point, and of its field. */
static void Copy(const MpmPointColumn *column, const MpmStateVariable *variable, PetscInt dim, const PetscReal from[],
                 PetscReal to[])
{
  if (variable->kind == MPM_STATE_SYM) MpmSymToSpace(MpmSymSize(dim), from, to);
  else
    for (PetscInt c = 0; c < column->components; c++) to[c] = from[c];
}

/* Components of a field: symmetric tensors are written with six. */
static PetscInt Components(const MpmStateVariable *variable, PetscInt dim)
{
  return variable->kind == MPM_STATE_SYM ? 6 : MpmStateComponents(variable, dim);
}

/* A history variable: zero where a point's law has none of this name. */
static PetscErrorCode FillHistory(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  const PetscInt dim = model->disc.dim;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(PetscArrayzero(values, points.count * column->components));
  for (PetscInt m = 0; m < model->scene.materials->count; m++) {
    const MpmLawInfo *info  = &model->scene.materials->at[m].info;
    PetscInt          first = 0;
    size_t            v     = 0;

    while (v < info->state_count && strcmp(info->states[v].name, column->name))
      first += MpmStateComponents(&info->states[v++], dim);
    for (PetscInt p = 0; p < points.count && v < info->state_count; p++)
      if (points.material[p] == m)
        Copy(column, &info->states[v], dim, &points.state[p * model->state.particles->state_size + first],
             &values[column->components * p]);
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A parameter of laws that varies: zero where a point's law has none of this name. */
static PetscErrorCode FillParameter(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    const MpmMaterial *material = &model->scene.materials->at[points.material[p]];
    const double      *own      = MpmPointOwn(&points, material, p);
    size_t             k        = 0;

    while (k < material->info.parameter_count && strcmp(material->info.parameters[k].name, column->name)) k++;
    values[p] = k == material->info.parameter_count ? 0. : own ? own[k] : material->parameter[k];
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A state of the physics' own. */
static PetscErrorCode FillOwn(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  const MpmStateVariable *variable = &model->scene.physics.states[column->index];
  const PetscInt          dim = model->disc.dim, size = model->disc.layout->own.size;
  PetscInt                first = 0;
  MpmPoints               points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt s = 0; s < column->index; s++) first += MpmStateComponents(&model->scene.physics.states[s], dim);
  for (PetscInt p = 0; p < points.count; p++)
    Copy(column, variable, dim, &points.physics.own[p * size + first], &values[column->components * p]);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The value of a field with a rate. */
static PetscErrorCode FillValue(MpmModel model, const MpmPointColumn *column, PetscReal values[])
{
  const PetscInt rates = model->disc.layout->rate.count;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) values[p] = points.physics.value[p * rates + column->index];
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Histories of the laws, and parameters that vary, as they are in force. */
static PetscErrorCode AddHistories(const MpmMaterial *material, PetscInt dim, MpmPointColumns *columns)
{
  PetscFunctionBeginUser;
  for (size_t v = 0; v < material->info.state_count; v++) {
    const MpmStateVariable *variable = &material->info.states[v];
    const MpmPointColumn    row = {variable->name, variable->unit, Components(variable, dim), FillHistory, NULL, 0};

    PetscCall(MpmPointColumnsAdd(columns, &row));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddParameters(const MpmMaterial *material, MpmPointColumns *columns)
{
  PetscFunctionBeginUser;
  for (PetscInt v = 0; material->varies && v < material->varies->count; v++) {
    const PetscInt place = material->varies->at[v].place;

    if (place < (PetscInt)material->info.parameter_count) {
      const MpmParameter  *parameter = &material->info.parameters[place];
      const MpmPointColumn row       = {parameter->name, parameter->unit, 1, FillParameter, NULL, 0};

      PetscCall(MpmPointColumnsAdd(columns, &row));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStatesAddColumns(MpmModel model, MpmPointColumns *columns)
{
  const MpmMaterials *materials = model->scene.materials;
  const MpmPhysics   *physics   = &model->scene.physics;
  const MpmLayout    *layout    = model->disc.layout;

  PetscFunctionBeginUser;
  for (PetscInt m = 0; m < materials->count; m++) PetscCall(AddHistories(&materials->at[m], model->disc.dim, columns));
  for (PetscInt s = 0; s < physics->state_count; s++) {
    const MpmStateVariable *variable = &physics->states[s];
    const MpmPointColumn    row      = {variable->name, variable->unit, Components(variable, model->disc.dim),
                                        FillOwn,        NULL,           s};

    PetscCall(MpmPointColumnsAdd(columns, &row));
  }
  for (PetscInt r = 0; r < layout->rate.count; r++) {
    const PetscInt       component = layout->rate.component[r];
    const MpmPointColumn row       = {layout->component[component].name,
                                      physics->fields[layout->component[component].field].unit,
                                      1,
                                      FillValue,
                                      NULL,
                                      r};

    PetscCall(MpmPointColumnsAdd(columns, &row));
  }
  for (PetscInt m = 0; m < materials->count; m++) PetscCall(AddParameters(&materials->at[m], columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}
