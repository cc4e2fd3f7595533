/*
  Parameters by name: NAME.KEY, a block by its name in its list and a number of it.
*/
#include <string.h>
#include "options/options.h"
#include "point/material.h"
#include "loads/load.h"
#include "query/model.h"
#include "query/parameter_range.h"
#include "sensitivity/parameters.h"

/* Blocks whose numbers have derivatives in closed form. */
typedef struct {
  const MpmMaterials *materials;
  const MpmLoads     *loads;
  const MpmPhysics   *physics;
  MpmFieldParameters *grounds; /* fields that are found */
} Places;

/* The parameter table's row of this name, or -1. */
static PetscInt FindRow(const MpmLawInfo *info, const char key[])
{
  for (size_t k = 0; k < info->parameter_count; k++)
    if (!strcmp(info->parameters[k].name, key)) return (PetscInt)k;
  return -1;
}

/* A law's number of one value, of a material that does not vary from place to place. */
static void FindInLaws(const Places *places, const char option[], MpmSceneParameter *parameter)
{
  const MpmMaterials *materials = places->materials;

  for (PetscInt m = 0; m < materials->count; m++) {
    const MpmMaterial *material = &materials->at[m];
    const size_t       length   = strlen(materials->names[m]);
    PetscInt           row;

    if (strncmp(option, materials->names[m], length) || option[length] != '_') continue;
    row = FindRow(&material->info, &option[length + 1]);
    if (row < 0 || material->info.parameters[row].kind > MPM_STRENGTH_ANGLE || MpmMaterialVaries(material, row))
      continue;
    parameter->kind    = MPM_OF_LAW;
    parameter->index   = m;
    parameter->place   = row;
    parameter->density = (PetscBool)!strcmp(&option[length + 1], "density");
    parameter->value   = material->parameter[row];
  }
}

/* True where an option has one number, which stands for all axes. */
static PetscBool IsAlone(const MpmParameterOption *option)
{
  static const char between[] = ",:; \t";
  const char       *text      = option->text + strspn(option->text, between);

  text += strcspn(text, between);
  return (PetscBool)!text[strspn(text, between)];
}

/* A number of the physics that the scene gives for a material. */
static void FindInPhysics(const Places *places, const char option[], MpmSceneParameter *parameter)
{
  for (PetscInt m = 0; m < places->materials->count; m++) {
    const MpmMaterial *material = &places->materials->at[m];
    const size_t       length   = strlen(places->materials->names[m]);
    PetscInt           place    = 0;

    if (strncmp(option, places->materials->names[m], length) || option[length] != '_' || material->varies) continue;
    for (int k = 0; k < places->physics->parameter_count; k++) {
      const MpmParameter *of   = &places->physics->parameters[k];
      const PetscInt      axes = MpmParameterPlaces(of);

      if (of->kind != MPM_WORD && parameter->options[0].given && !strcmp(&option[length + 1], of->name)) {
        parameter->kind   = MPM_OF_PHYSICS;
        parameter->index  = m;
        parameter->place  = place + (axes > 1 ? parameter->options[0].place : 0);
        parameter->places = axes > 1 && IsAlone(&parameter->options[0]) ? axes : 1;
      }
      place += axes;
    }
  }
}

static void FindInMaterials(const Places *places, const char option[], MpmSceneParameter *parameter)
{
  FindInLaws(places, option, parameter);
  if (parameter->kind == MPM_OF_OPTION) FindInPhysics(places, option, parameter);
}

/* A number of the physics for the whole scene, of finite value. */
static void FindInCommon(const Places *places, const char option[], MpmSceneParameter *parameter)
{
  const MpmPhysics *physics = places->physics;
  PetscInt          place   = 0;

  for (int k = 0; k < physics->parameter_count; k++) place += MpmParameterPlaces(&physics->parameters[k]);
  for (int k = 0; k < physics->common_count; k++) {
    const MpmCommonParameter *common = &physics->common[k];
    const size_t              length = strlen(common->block);

    if (strncmp(option, common->block, length) || option[length] != '_' ||
        strcmp(&option[length + 1], common->parameter.name))
      continue;
    for (PetscInt m = 0; m < places->materials->count; m++)
      if (places->materials->at[m].varies || !PetscIsNormalReal(places->materials->at[m].physics_parameter[place + k]))
        return;
    parameter->kind   = MPM_OF_PHYSICS;
    parameter->index  = -1;
    parameter->place  = place + k;
    parameter->places = 1;
  }
}

/* A load's magnitude; not that of gravity where water has weight, too. */
static void FindInLoads(const Places *places, const char option[], MpmSceneParameter *parameter)
{
  for (PetscInt l = 0; l < places->loads->count; l++) {
    const MpmLoad *load   = &places->loads->at[l];
    const size_t   length = strlen(load->name);

    if (strncmp(option, load->name, length) || strcmp(&option[length], "_value")) continue;
    if (load->type == MPM_LOAD_GRAVITY && places->physics->taken_up) continue;
    parameter->kind  = MPM_OF_LOAD;
    parameter->index = l;
  }
}

/* k0 of the geostatic stage, which comes first, and a body's initial stress: no step knows them. */
static void FindInStart(const Places *places, const char option[], MpmSceneParameter *parameter)
{
  const char *geostatic = strstr(option, "_geostatic_k0"), *stress = strstr(option, "_initial_stress");

  (void)places;
  if ((geostatic && !strcmp(geostatic, "_geostatic_k0")) || (stress && !strcmp(stress, "_initial_stress")))
    parameter->kind = MPM_OF_START;
}

/* Kinds with derivatives in closed form: the head of their options' names, and who knows such a number. */
static const struct {
  const char *head;
  PetscBool   factor; /* of all numbers of the option */
  void (*find)(const Places *places, const char option[], MpmSceneParameter *parameter);
} closed[] = {
  {"-mpm_material_", PETSC_FALSE, FindInMaterials}, {"-mpm_", PETSC_FALSE, FindInCommon},
  {"-mpm_load_", PETSC_TRUE, FindInLoads},          {"-mpm_stage_", PETSC_FALSE, FindInStart},
  {"-mpm_body_", PETSC_FALSE, FindInStart},
};

/* The block and number of a parameter's name, "soil.E". */
static PetscErrorCode Resolve(const MpmOptions *options, const Places *places, MpmSceneParameter *parameter)
{
  PetscFunctionBeginUser;
  PetscCall(MpmParameterFindOptions(options->record, places->loads, parameter));
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(closed) && parameter->option_count == 1; k++) {
    const MpmParameterOption *option = &parameter->options[0];
    const size_t              head   = strlen(closed[k].head);

    if (!strncmp(option->name, closed[k].head, head) && closed[k].factor == (PetscBool)(option->place < 0))
      (*closed[k].find)(places, &option->name[head], parameter);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Add(const MpmOptions *options, const Places *places, const char name[], const char *block,
                          MpmSceneParameters *parameters)
{
  MpmSceneParameter *parameter;

  PetscFunctionBeginUser;
  if (!strncmp(name, "field_", 6) && !strchr(name, '.'))
    PetscFunctionReturn(MpmFieldParameterAdd(places->materials, &name[6], block, places->grounds));
  for (PetscInt k = 0; k < parameters->count; k++)
    MpmCheckInput(strcmp(parameters->at[k].name, name), "-mpm_parameters %s: is there twice", name);
  PetscCall(PetscRealloc((size_t)(parameters->count + 1) * sizeof(*parameters->at), &parameters->at));
  parameter = &parameters->at[parameters->count++];
  PetscCall(PetscMemzero(parameter, sizeof(*parameter)));
  PetscCall(PetscStrallocpy(name, &parameter->name));
  PetscCall(PetscStrallocpy(block, &parameter->block));
  PetscCall(Resolve(options, places, parameter));
  for (PetscInt k = 0; k + 1 < parameters->count; k++)
    MpmCheckInput(!MpmSceneParametersMeet(&parameters->at[k], parameter),
                  "-mpm_parameters %s: is a number of %s already: %s; one of them may stay", name,
                  parameter->options[0].name, parameters->at[k].name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Names at commas, of one block or of the short form. */
static PetscErrorCode AddNames(const MpmOptions *options, const Places *places, const char text[], const char *block,
                               MpmSceneParameters *parameters)
{
  PetscInt count;
  char   **names;

  PetscFunctionBeginUser;
  PetscCall(MpmTextSplit(text, &count, &names));
  for (PetscInt k = 0; k < count; k++) PetscCall(Add(options, places, names[k], block, parameters));
  PetscCall(MpmNamesDestroy(count, &names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The names of the short form. */
static PetscErrorCode ReadShort(const MpmOptions *options, const Places *places, MpmSceneParameters *parameters)
{
  const MpmOptions block = {options->comm, "mpm_gradient_", options->record};
  char            *text;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsText(&block, "parameters",
                           "short form of -mpm_parameters: what results are differentiated by, NAME.KEY,...", NULL,
                           MPM_OPTIONAL, &text));
  if (text && !MpmOptionsHelp()) PetscCall(AddNames(options, places, text, NULL, parameters));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSceneParametersRead(const MpmOptions *options, const MpmScene *scene, MpmFieldParameters *grounds,
                                      MpmSceneParameters *parameters)
{
  const Places places[] = {{scene->materials, scene->loads, &scene->physics, grounds}};
  PetscInt     count;
  char       **names;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsBlocks(options, "parameters", "names of the numbers by which results are differentiated",
                             MPM_OPTIONAL, &count, &names));
  for (PetscInt k = 0; k < count; k++) {
    char       prefix[256], *of, *field;
    MpmOptions block = {options->comm, prefix, options->record};

    PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_parameter_%s_", names[k]));
    PetscCall(MpmOptionsHeading(&block, "Parameter"));
    PetscCall(MpmOptionsText(&block, "field", "instead of `of`: all values of a field of -mpm_fields", NULL,
                             MPM_OPTIONAL, &field));
    PetscCall(
      MpmOptionsText(&block, "of",
                     "NAME.KEY: a number of a block, soil.E, or the factor of its magnitudes, tip.factor; KEY:2 or "
                     "KEY:y of several numbers; material_soil.E where several blocks have the name; several, at "
                     "commas: one number for all of them",
                     NULL, field ? MPM_OPTIONAL : MPM_REQUIRED, &of));
    if (MpmOptionsHelp()) PetscCall(MpmParameterRangePrintHelp(&block));
    MpmCheckInput(!of || !field || MpmOptionsHelp(), "-%sfield %s: must be alone: of is given, too", prefix, field);
    if (field && !MpmOptionsHelp()) PetscCall(MpmFieldParameterAdd(scene->materials, field, names[k], grounds));
    PetscCall(PetscFree(field));
    if (of && !MpmOptionsHelp()) PetscCall(AddNames(options, places, of, names[k], parameters));
    PetscCall(PetscFree(of));
  }
  PetscCall(MpmNamesDestroy(count, &names));
  PetscCall(ReadShort(options, places, parameters));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSceneParametersDestroy(MpmSceneParameters *parameters)
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < parameters->count; k++) {
    MpmSceneParameter *parameter = &parameters->at[k];

    for (PetscInt i = 0; i < parameter->option_count; i++) {
      PetscCall(PetscFree(parameter->options[i].name));
      PetscCall(PetscFree(parameter->options[i].text));
    }
    PetscCall(PetscFree(parameter->options));
    PetscCall(PetscFree(parameter->name));
    PetscCall(PetscFree(parameter->block));
  }
  PetscCall(PetscFree(parameters->at));
  PetscFunctionReturn(PETSC_SUCCESS);
}
