/*
  Options of a scene's parameters.
*/
#include "point/material.h"
#include "loads/load.h"
#include "query/model.h"
#include "inverse/inverse.h"
#include "inverse/parameter_option.h"

PetscErrorCode MpmSceneParameterSetOption(const MpmModel model, const MpmSceneParameter *parameter, PetscReal number)
{
  char name[PETSC_MAX_OPTION_NAME], value[512];

  PetscFunctionBeginUser;
  if (parameter->kind == MPM_OF_LAW) {
    const MpmMaterial *material = &model->scene.materials->at[parameter->index];

    PetscCall(PetscSNPrintf(name, sizeof(name), "-mpm_material_%s_%s", model->scene.materials->names[parameter->index],
                            material->info.parameters[parameter->place].name));
    PetscCall(PetscSNPrintf(value, sizeof(value), "%.17g", (double)number));
  } else {
    const MpmLoad *load   = &model->scene.loads->at[parameter->index];
    size_t         length = 0;

    PetscCall(PetscSNPrintf(name, sizeof(name), "-mpm_load_%s_value", load->name));
    for (PetscInt a = 0; a < model->disc.dim; a++) {
      PetscCall(PetscSNPrintf(&value[length], sizeof(value) - length, "%s%.17g", a ? "," : "",
                              (double)(number * load->value[a])));
      PetscCall(PetscStrlen(value, &length));
    }
  }
  PetscCall(PetscOptionsSetValue(NULL, name, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmParameterSet(MpmModel model, const MpmSceneParameter *parameter, PetscReal factor)
{
  PetscFunctionBeginUser;
  PetscCall(MpmSceneParameterSetOption(model, parameter, factor * parameter->value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
