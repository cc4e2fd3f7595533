/*
  Warnings of a grid that the scene needs finer, or with more points a cell.
*/
#include <string.h>
#include "point/air.h"
#include "point/material.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/body.h"
#include "query/model.h"
#include "observe/results.h"
#include "model/build.h"

static PetscErrorCode WarnFewPoints(MpmModel model)
{
  const MpmShapeType shape = model->scene.shape.type;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; MpmShapeOrder(shape) > 1 && b < model->scene.bodies->count; b++) {
    const PetscReal spacing = MpmBodySpacing(model->scene.bodies->at[b]);
    char            points[MPM_NUMBER_TEXT];

    if (MpmShapeSpacing(shape, spacing) < 1.) continue;
    MpmRealText(1. / spacing, points);
    PetscCall(MpmTerminalWarn(model,
                              "warning: body %s has %s points a cell on an axis, fewer than the %" PetscInt_FMT
                              " that %s needs: the ghost penalty stabilizes it",
                              model->scene.bodies->names[b], points, MpmShapeOrder(shape) + 1, MpmShapeName(shape)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Place of the physics' characteristic length among a material's values; -1: there is none. */
static PetscInt LengthPlace(const MpmPhysics *physics)
{
  PetscInt place = 0;

  for (int k = 0; k < physics->parameter_count; k++) {
    const MpmParameter *parameter = &physics->parameters[k];

    if (!strcmp(parameter->name, "length")) return place;
    place += MpmParameterPlaces(parameter);
  }
  return -1;
}

#define LEAST_CELLS \
  2. /* within a characteristic length: the energy of a crack is then 1 + 3h/(8l) times that asked for */

static PetscErrorCode WarnShortLengths(MpmModel model)
{
  const MpmMaterials *materials = model->scene.materials;
  const PetscInt      place     = LengthPlace(&model->scene.physics);
  PetscReal           h         = 0.;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < model->disc.dim; a++) h = PetscMax(h, model->disc.grid->h[a]);
  for (PetscInt m = 0; place >= 0 && m < materials->count; m++) {
    const PetscReal length = materials->at[m].physics_parameter[place];
    char            text[2][MPM_NUMBER_TEXT];

    if (MpmMaterialIsAir(&materials->at[m]) || length >= LEAST_CELLS * h * (1. - MPM_TOLERANCE)) continue;
    MpmRealText(length, text[0]);
    MpmRealText(h, text[1]);
    PetscCall(MpmTerminalWarn(model,
                              "warning: -mpm_material_%s_length %s is less than two cells of %s m: results depend on "
                              "the grid",
                              materials->names[m], text[0], text[1]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmModelWarnCoarse(MpmModel model)
{
  PetscFunctionBeginUser;
  PetscCall(WarnFewPoints(model));
  PetscCall(WarnShortLengths(model));
  PetscFunctionReturn(PETSC_SUCCESS);
}
