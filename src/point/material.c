/*
  The materials of a scene, and the registry of the constitutive laws that were compiled in: the build scans materials/
  and lists every law's constructor, once per kernel instance, in mpm_laws.h.
*/
#include "options/options.h"
#include "point/material.h"
#include "point/wave_speed.h"
#include "point/parameter.h"
#include "point/registry.h"

#define MPM_LAW_INSTANCE(name, dim, instance, form) \
  void MpmMaterialCreate_##name##_##dim##d_##instance(MpmLawInfo *info);
#include "mpm_laws.h"
#undef MPM_LAW_INSTANCE

static const MpmLawInstance laws[] = {
#define MPM_LAW_INSTANCE(name, dim, instance, form) {#name, dim, form, MpmMaterialCreate_##name##_##dim##d_##instance},
#include "mpm_laws.h"
#undef MPM_LAW_INSTANCE
};

/* All instances, those compiled in and those registered; NULL behind the last. */
static const MpmLawInstance *Instance(PetscInt k)
{
  const PetscInt own = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(laws);

  return k < own ? &laws[k] : MpmLawRegistered(k - own);
}

/* The next law from `k` on, one instance for each. */
static const MpmLawInstance *NextLaw(PetscInt *k)
{
  for (const MpmLawInstance *law = Instance((*k)++); law; law = Instance((*k)++))
    if (law->dim == 3 && law->form == MPM_FORM_RESIDUAL) return law;
  return NULL;
}

PetscBool MpmLawFind(const char *name, PetscInt dim, MpmForm form, MpmLawInfo *info)
{
  const MpmLawInstance *law;

  for (PetscInt k = 0; (law = Instance(k)); k++) {
    if (law->dim == dim && law->form == form && !strcmp(law->name, name)) {
      law->create(info);
      return PETSC_TRUE;
    }
  }
  return PETSC_FALSE;
}

PetscBool MpmLawFindAll(const char *name, PetscInt dim, MpmFunction law[], MpmLawInfo *info)
{
  for (PetscInt form = 0; form < MPM_FORM_COUNT; form++) {
    if (!MpmLawFind(name, dim, (MpmForm)form, info)) return PETSC_FALSE;
    law[form] = info->law;
  }
  return MpmLawFind(name, dim, MPM_FORM_RESIDUAL, info);
}

PetscInt MpmStateComponents(const MpmStateVariable *variable, PetscInt dim)
{
  if (variable->kind == MPM_STATE_VECTOR) return dim;
  return variable->kind == MPM_STATE_SCALAR ? 1 : MpmSymSize(dim);
}

/* The names of all laws, NULL-terminated; free the array only. */
static PetscErrorCode LawNames(const char ***names)
{
  const MpmLawInstance *law;
  PetscInt              count = 0, k = 0;

  PetscFunctionBeginUser;
  while (NextLaw(&k)) count++;
  PetscCall(PetscCalloc1((count + 1), names));
  count = k = 0;
  while ((law = NextLaw(&k))) {
    MpmLawInfo info;

    law->create(&info);
    if (!(info.traits & MPM_LAW_INTERNAL)) (*names)[count++] = law->name;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* For -help: every law with its own parameters. */
static PetscErrorCode PrintLaws(const MpmOptions *block)
{
  const MpmOptions unrecorded = {block->comm, block->prefix, NULL}; /* laws share parameters: each is printed again */
  const MpmLawInstance *law;
  PetscInt              k = 0;
  char                  title[256];

  PetscFunctionBeginUser;
  while ((law = NextLaw(&k))) {
    MpmLawInfo  info;
    MpmLawTable table;
    double      unused;

    law->create(&info);
    if (info.traits & MPM_LAW_INTERNAL) continue;
    PetscCall(PetscSNPrintf(title, sizeof(title), "Material of type %s: %s", info.name, info.summary));
    PetscCall(MpmOptionsHeading(block, title));
    for (size_t i = 0; i < info.parameter_count; i++) {
      PetscCall(MpmParameterRead(&unrecorded, &info.parameters[i], &unused, &table));
      PetscCall(PetscFree(table.value));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A parameter whose default may be the value of one that has been read */
static MpmParameter WithDefault(const MpmMaterial *material, size_t k)
{
  MpmParameter parameter = material->info.parameters[k];

  for (size_t i = 0; parameter.same_as && i < k; i++)
    if (!strcmp(material->info.parameters[i].name, parameter.same_as)) parameter.fallback = material->parameter[i];
  return parameter;
}

/* The parameter that is at fault, with the range that it must keep to, as text. */
static void FaultText(const MpmMaterial *material, const MpmLawFault *fault, char why[MPM_FAULT_TEXT])
{
  const MpmParameter *parameter = &material->info.parameters[fault->parameter];
  char                range[MPM_RANGE_TEXT], value[MPM_NUMBER_TEXT], must[MPM_MUST_TEXT];

  MpmRangeText((MpmRange){fault->lower, fault->upper, (PetscBool)(fault->open != 0)}, range);
  MpmRealText(material->parameter[fault->parameter], value);
  if (!range[0]) { /* any value would do by itself */
    snprintf(why, MPM_FAULT_TEXT, "%s %s: %s", parameter->name, value, fault->why ? fault->why : "contradicts another");
    return;
  }
  MpmMustText(range, parameter->unit, must);
  snprintf(why, MPM_FAULT_TEXT, "%s %s: %s%s%s", parameter->name, value, must, fault->why ? ": " : "",
           fault->why ? fault->why : "");
}

/* Parameters that contradict each other end the run. */
static PetscErrorCode CheckParameters(const MpmMaterial *material)
{
  MpmLawFault fault = {-1, PETSC_NINFINITY, PETSC_INFINITY, 0, "contradictory parameters"};
  char        why[MPM_FAULT_TEXT];

  PetscFunctionBeginUser;
  if (!material->info.check || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  if (material->info.check(material->parameter, material->table, &fault)) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(fault.parameter >= 0, "-mpm_material_%s: %s", material->name, fault.why);
  FaultText(material, &fault, why);
  MpmCheckInput(PETSC_FALSE, "-mpm_material_%s_%s", material->name, why);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscBool MpmMaterialIsFaulty(const MpmMaterial *material, char why[MPM_FAULT_TEXT])
{
  MpmLawFault fault = {-1, PETSC_NINFINITY, PETSC_INFINITY, 0, "contradictory parameters"};

  for (size_t i = 0; i < material->info.parameter_count; i++) {
    const MpmParameter *parameter = &material->info.parameters[i];
    const MpmRange      range     = {parameter->lower, parameter->upper, (PetscBool)(parameter->open != 0)};

    if (parameter->kind >= MPM_WORD || MpmRangeHolds(range, material->parameter[i])) continue;
    if (material->parameter[i] == parameter->fallback) continue; /* left out: it may stand outside */
    FaultText(material, &(MpmLawFault){(int)i, parameter->lower, parameter->upper, parameter->open, NULL}, why);
    return PETSC_TRUE;
  }
  if (!material->info.check || material->info.check(material->parameter, material->table, &fault)) return PETSC_FALSE;
  if (fault.parameter >= 0) FaultText(material, &fault, why);
  else snprintf(why, MPM_FAULT_TEXT, "%s", fault.why);
  return PETSC_TRUE;
}

PetscBool MpmMaterialIsFaultyWith(const MpmMaterial *material, const char *parameter, PetscReal value,
                                  char why[MPM_FAULT_TEXT])
{
  const size_t count = material->info.parameter_count;
  PetscBool    faulty;

  for (size_t i = 0; i < count; i++) {
    const double before = material->parameter[i];

    if (material->info.parameters[i].kind >= MPM_WORD || strcmp(material->info.parameters[i].name, parameter)) continue;
    material->parameter[i] = value;
    faulty                 = MpmMaterialIsFaulty(material, why);
    material->parameter[i] = before;
    return faulty;
  }
  return PETSC_FALSE;
}

/* ---- strength ---- */

PetscBool MpmMaterialHasStrength(const MpmMaterial *material)
{
  for (size_t i = 0; i < material->info.parameter_count; i++) {
    const MpmParameterKind kind = material->info.parameters[i].kind;

    if (kind != MPM_STRENGTH && kind != MPM_STRENGTH_ANGLE) continue;
    if (material->given[i] > 0. && material->given[i] <= PETSC_MAX_REAL) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

void MpmMaterialReduce(MpmMaterial *material, PetscReal factor)
{
  const PetscReal degree = PETSC_PI / 180.;

  for (size_t i = 0; i < material->info.parameter_count; i++) {
    const MpmParameterKind kind  = material->info.parameters[i].kind;
    const double           given = material->given[i];

    if (kind == MPM_STRENGTH) material->parameter[i] = given / factor;
    else if (kind == MPM_STRENGTH_ANGLE && factor == 1.) material->parameter[i] = given;
    else if (kind == MPM_STRENGTH_ANGLE)
      material->parameter[i] = PetscAtanReal(PetscTanReal(given * degree) / factor) / degree;
  }
}

/* ---- a material of the scene ---- */

PetscErrorCode MpmMaterialCreate(const MpmOptions *options, const char *name, PetscInt dim, MpmMaterial *material)
{
  char         prefix[256];
  MpmOptions   block = {options->comm, prefix, options->record};
  const char **names;
  PetscInt     type = 0;
  PetscBool    given, has;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(material, sizeof(*material)));
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_material_%s_", name));
  PetscCall(PetscStrallocpy(name, &material->name));
  PetscCall(MpmOptionsHeading(&block, "Material"));
  PetscCall(LawNames(&names));
  PetscCall(MpmOptionsWord(&block, "type", "constitutive law", names, MPM_REQUIRED, &type, &given));
  PetscCheck(MpmLawFindAll(names[type], dim, material->law, &material->info), options->comm, PETSC_ERR_PLIB,
             "law %s is not compiled", names[type]);
  PetscCall(PetscFree(names));
  PetscCall(PetscCalloc1(material->info.parameter_count, &material->parameter));
  PetscCall(PetscCalloc1(material->info.parameter_count, &material->given));
  PetscCall(PetscCalloc1(material->info.parameter_count, &material->table));
  PetscCall(PetscCalloc1(material->info.parameter_count, &material->set));
  if (!given) PetscCall(PrintLaws(&block));
  for (size_t i = 0; given && i < material->info.parameter_count; i++) {
    const MpmParameter parameter = WithDefault(material, i);

    PetscCall(MpmOptionsHas(&block, parameter.name, &has));
    material->set[i] = has;
    PetscCall(MpmParameterRead(&block, &parameter, &material->parameter[i], &material->table[i]));
    if (!strcmp(material->info.parameters[i].name, "density")) material->density = material->parameter[i];
    if (!strcmp(material->info.parameters[i].name, "E")) material->penalty = material->parameter[i];
    if (!strcmp(material->info.parameters[i].name, "nu")) material->nu = material->parameter[i];
    if (!strcmp(material->info.parameters[i].name, "dilation"))
      material->dilation.least = material->dilation.most = material->parameter[i];
    if (!strcmp(material->info.parameters[i].name, "dilation_residual")) {
      material->dilation.least = PetscMin(material->dilation.least, material->parameter[i]);
      material->dilation.most  = PetscMax(material->dilation.most, material->parameter[i]);
    }
  }
  PetscCall(PetscArraycpy(material->given, material->parameter, material->info.parameter_count));
  PetscCall(CheckParameters(material));
  if (material->info.symmetric) {
    const PetscBool symmetric = (PetscBool)(material->info.symmetric(material->parameter, material->table) != 0);

    material->info.traits =
      (material->info.traits & ~(unsigned)MPM_LAW_SYMMETRIC) | (symmetric ? MPM_LAW_SYMMETRIC : 0);
  }
  material->stiffness = MpmMaterialStiffness(material, NULL, NULL);
  if (material->info.shear_modulus && material->info.traits & MPM_LAW_FIXED_MODULI)
    material->shear_modulus = material->info.shear_modulus(material->parameter, material->table, NULL, NULL);
  if (material->penalty == 0.) material->penalty = material->stiffness;
  for (size_t i = 0; i < material->info.state_count; i++)
    material->state_size += MpmStateComponents(&material->info.states[i], dim);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmParameterPlaces(const MpmParameter *parameter)
{
  return parameter->kind == MPM_AXES ? MPM_MAX_DIM : 1;
}

/* One number, or one an axis, into three places; left out: the fallback. */
static PetscErrorCode ReadAxes(const MpmOptions *block, PetscInt dim, const MpmParameter *parameter, double value[])
{
  const MpmRange range = {parameter->lower, parameter->upper, (PetscBool)(parameter->open != 0)};
  char           text[MPM_RANGE_TEXT], number[MPM_NUMBER_TEXT];
  PetscReal     *given;
  PetscInt       count;

  PetscFunctionBeginUser;
  MpmRangeText(range, text);
  PetscCall(MpmOptionsRealList(block, parameter->name, parameter->unit, parameter->help, MPM_OPTIONAL, &count, &given));
  MpmCheckInput(count <= 1 || count == dim, "-%s%s has %" PetscInt_FMT " numbers: must be one, or one an axis",
                block->prefix, parameter->name, count);
  for (PetscInt a = 0; a < count; a++) {
    MpmRealText(given[a], number);
    MpmCheckInput(MpmRangeHolds(range, given[a]), "-%s%s %s: must be %s", block->prefix, parameter->name, number, text);
  }
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) value[a] = count ? given[PetscMin(a, count - 1)] : parameter->fallback;
  PetscCall(PetscFree(given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialReadPhysics(const MpmOptions *options, const MpmPhysics *physics, PetscInt dim,
                                      MpmMaterial *material)
{
  char        prefix[256];
  MpmOptions  block = {options->comm, prefix, options->record};
  MpmLawTable unused;
  PetscInt    place = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_material_%s_", material->name));
  PetscCall(
    PetscCalloc1((MPM_MAX_DIM * physics->parameter_count + physics->common_count), &material->physics_parameter));
  for (int k = 0; k < physics->parameter_count; k++) {
    const MpmParameter *parameter = &physics->parameters[k];

    PetscCheck(parameter->kind <= MPM_WORD || parameter->kind == MPM_AXES, options->comm, PETSC_ERR_SUP,
               "physics %s: its parameter %s must be a number or a word", physics->name, parameter->name);
    if (parameter->kind == MPM_AXES) PetscCall(ReadAxes(&block, dim, parameter, &material->physics_parameter[place]));
    else PetscCall(MpmParameterRead(&block, parameter, &material->physics_parameter[place], &unused));
    place += MpmParameterPlaces(parameter);
  }
  for (int k = 0; k < physics->common_count; k++) {
    PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_%s_", physics->common[k].block));
    PetscCall(MpmParameterRead(&block, &physics->common[k].parameter, &material->physics_parameter[place++], &unused));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmPhysicsMaterial MpmMaterialForPhysics(const MpmMaterial *material, PetscInt dim)
{
  return (MpmPhysicsMaterial){&material->info, material->parameter, material->set, material->table, (int)dim};
}

PetscErrorCode MpmMaterialPrepare(const MpmPhysics *physics, PetscInt dim, PetscReal gravity, MpmMaterial *material)
{
  const MpmPhysicsMaterial of = MpmMaterialForPhysics(material, dim);
  const char              *why;

  PetscFunctionBeginUser;
  if (!physics->prepare || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  why = physics->prepare(&of, gravity, material->physics_parameter);
  MpmCheckInput(!why, "-mpm_material_%s_%s", material->name, why);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialDestroy(MpmMaterial *material)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(material->name));
  PetscCall(PetscFree(material->parameter));
  PetscCall(PetscFree(material->given));
  PetscCall(PetscFree(material->physics_parameter));
  PetscCall(PetscFree(material->set));
  PetscCall(MpmTablesDestroy(material->info.parameter_count, &material->table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmMaterialShearStrength(const MpmMaterial *material, const PetscReal state[])
{
  if (!material->info.shear_strength) return PETSC_INFINITY;
  return material->info.shear_strength(material->parameter, state);
}

PetscReal MpmMaterialStiffness(const MpmMaterial *material, const PetscReal state[], const PetscReal F[])
{
  return material->info.stiffness(material->parameter, material->table, state, F);
}

PetscReal MpmMaterialWaveSpeed(const MpmMaterial *material, PetscInt dim, const PetscReal state[], const PetscReal F[],
                               const PetscReal stress[])
{
  const PetscReal modulus = MpmMaterialStiffness(material, state, F);

  if (!stress) return PetscSqrtReal(modulus / material->density);
  return MpmWaveSpeed(dim, modulus, material->density, F ? MpmDeterminant(dim, F) : 1., stress);
}

PetscReal MpmMaterialViscosity(const MpmMaterial *material)
{
  return material->info.viscosity ? material->info.viscosity(material->parameter, material->table) : 0.;
}

int MpmMaterialSensitivity(const MpmMaterial *material, const MpmLawInput *input, const MpmLawInput *direction,
                           const MpmLawOutput *value, const MpmLawOutput *derivative)
{
  const MpmSensitivity sensitivity = (MpmSensitivity)material->law[MPM_FORM_SENSITIVITY];
  MpmLawInput          full        = *input;

  full.parameter = material->parameter;
  full.table     = material->table;
  return sensitivity(&full, direction, value, derivative);
}

void MpmStatesAtRest(size_t count, const MpmStateVariable variables[], PetscInt dim, PetscReal state[])
{
  for (size_t i = 0; i < count; i++)
    for (PetscInt c = 0; c < MpmStateComponents(&variables[i], dim); c++) *state++ = c < 3 ? variables[i].initial : 0.;
}

void MpmMaterialStateAtRest(const MpmMaterial *material, PetscInt dim, PetscReal state[])
{
  MpmStatesAtRest(material->info.state_count, material->info.states, dim, state);
}
