/*
  Parameters by name: NAME.KEY, a block by its name in its list and a number of it.
*/
#include <string.h>
#include "options/options.h"
#include "point/material.h"
#include "loads/load.h"
#include "query/model.h"
#include "sensitivity/parameters.h"

/* A block's name, with or without the word of its kind in front: soil, material_soil. */
static PetscBool Names(const char text[], size_t length, const char kind[], const char name[])
{
  const size_t head = strlen(kind);

  if (length == strlen(name) && !strncmp(text, name, length)) return PETSC_TRUE;
  return (PetscBool)(length == head + strlen(name) && !strncmp(text, kind, head) &&
                     !strncmp(&text[head], name, length - head));
}

static PetscInt FindBlock(const char of[], size_t length, const char kind[], PetscInt count, char *const names[])
{
  for (PetscInt k = 0; k < count; k++)
    if (Names(of, length, kind, names[k])) return k;
  return -1;
}

/* The parameter table's row of this name, or -1. */
static PetscInt FindRow(const MpmLawInfo *info, const char key[])
{
  for (size_t k = 0; k < info->parameter_count; k++)
    if (!strcmp(info->parameters[k].name, key)) return (PetscInt)k;
  return -1;
}

static PetscErrorCode FindInMaterial(MpmModel model, const char key[], MpmSceneParameter *parameter)
{
  const MpmMaterial *material = &model->scene.materials->at[parameter->index];
  char              *words    = NULL;

  PetscFunctionBeginUser;
  for (size_t k = 0; k < material->info.parameter_count; k++)
    PetscCall(MpmTextAppend(&words, "%s%s", words ? ", " : "", material->info.parameters[k].name));
  parameter->kind  = MPM_OF_LAW;
  parameter->place = FindRow(&material->info, key);
  MpmCheckInput(parameter->place >= 0, "-mpm_parameters %s: material %s has no parameter %s; it has %s",
                parameter->name, material->name, key, words);
  PetscCall(PetscFree(words));
  MpmCheckInput(material->info.parameters[parameter->place].kind <= MPM_STRENGTH_ANGLE,
                "-mpm_parameters %s: is no number of one value: there is no derivative by it yet", parameter->name);
  MpmCheckInput(!material->varies,
                "-mpm_parameters %s: material %s varies from place to place: there is no derivative "
                "by its parameters yet",
                parameter->name, material->name);
  parameter->density = (PetscBool)!strcmp(key, "density");
  parameter->value   = material->parameter[parameter->place];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The block and number of a parameter's name, "soil.E". */
static PetscErrorCode Resolve(MpmModel model, MpmSceneParameter *parameter)
{
  const char    *name = parameter->name, *dot = strrchr(name, '.');
  const size_t   length = dot ? (size_t)(dot - name) : 0;
  const PetscInt material =
    FindBlock(name, length, "material_", model->scene.materials->count, model->scene.materials->names);
  const PetscInt load = FindBlock(name, length, "load_", model->scene.loads->count, model->scene.loads->names);

  PetscFunctionBeginUser;
  MpmCheckInput(dot && length && dot[1], "-mpm_parameters %s: must be NAME.KEY, a block by its name and a number of it",
                name);
  MpmCheckInput(material < 0 || load < 0,
                "-mpm_parameters %s: must be material_%s or load_%s: both blocks have this name", name, name, name);
  MpmCheckInput(material >= 0 || load >= 0,
                "-mpm_parameters %s: no material or load has this name; derivatives by other blocks are not there yet",
                name);
  if (material >= 0) {
    parameter->index = material;
    PetscCall(FindInMaterial(model, &dot[1], parameter));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  MpmCheckInput(!strcmp(&dot[1], "factor"), "-mpm_parameters %s: of a load the only parameter so far is factor", name);
  parameter->kind  = MPM_OF_LOAD;
  parameter->index = load;
  parameter->value = 1.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Add(MpmModel model, const char name[], const char *block, MpmSceneParameters *parameters)
{
  MpmSceneParameter *parameter;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < parameters->count; k++)
    MpmCheckInput(strcmp(parameters->at[k].name, name), "-mpm_parameters %s: is there twice", name);
  PetscCall(PetscRealloc((size_t)(parameters->count + 1) * sizeof(*parameters->at), &parameters->at));
  parameter = &parameters->at[parameters->count++];
  PetscCall(PetscMemzero(parameter, sizeof(*parameter)));
  PetscCall(PetscStrallocpy(name, &parameter->name));
  PetscCall(PetscStrallocpy(block, &parameter->block));
  PetscCall(Resolve(model, parameter));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names at commas, of one block or of the short form. */
static PetscErrorCode AddNames(MpmModel model, const char text[], const char *block, MpmSceneParameters *parameters)
{
  PetscInt count;
  char   **names;

  PetscFunctionBeginUser;
  PetscCall(MpmTextSplit(text, &count, &names));
  for (PetscInt k = 0; k < count; k++) PetscCall(Add(model, names[k], block, parameters));
  PetscCall(MpmNamesDestroy(count, &names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The names of the short form. */
static PetscErrorCode ReadShort(MpmModel model, const MpmOptions *options, MpmSceneParameters *parameters)
{
  const MpmOptions block = {options->comm, "mpm_gradient_", options->record};
  char            *text;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(&block, "parameters",
                           "short form of -mpm_parameters: what results are differentiated by, NAME.KEY,...", NULL,
                           MPM_OPTIONAL, &text));
  if (text && !MpmOptionsHelp()) PetscCall(AddNames(model, text, NULL, parameters));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSceneParametersRead(MpmModel model, const MpmOptions *options, MpmSceneParameters *parameters)
{
  PetscInt count;
  char   **names;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "parameters", "names of the numbers by which results are differentiated",
                             MPM_OPTIONAL, &count, &names));
  for (PetscInt k = 0; k < count; k++) {
    char       prefix[256], *of;
    MpmOptions block = {options->comm, prefix, options->record};

    PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_parameter_%s_", names[k]));
    PetscCall(MpmOptionsHeading(&block, "Parameter"));
    PetscCall(
      MpmOptionsText(&block, "of",
                     "NAME.KEY: a number of a law, soil.E, or the factor of a load, tip.factor; material_soil.E "
                     "where several blocks have the name; several, at commas: one number for all of them",
                     NULL, MPM_REQUIRED, &of));
    if (!MpmOptionsHelp()) PetscCall(AddNames(model, of, names[k], parameters));
    PetscCall(PetscFree(of));
  }
  PetscCall(MpmNamesDestroy(count, &names));
  PetscCall(ReadShort(model, options, parameters));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSceneParametersDestroy(MpmSceneParameters *parameters)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < parameters->count; k++) {
    PetscCall(PetscFree(parameters->at[k].name));
    PetscCall(PetscFree(parameters->at[k].block));
  }
  PetscCall(PetscFree(parameters->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}
