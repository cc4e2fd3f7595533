/*
  The materials of a scene.
*/
#include "options/options.h"
#include "ground/ground.h"
#include "point/basal_laws.h"
#include "point/basal_map.h"
#include "point/air.h"
#include "point/material.h"
#include "point/variation.h"
#include "point/wave_speed.h"
#include "point/parameter.h"
#include "point/registry.h"

PetscInt MpmStateComponents(const MpmStateVariable *variable, PetscInt dim)
{
  if (variable->kind == MPM_STATE_VECTOR) return dim;
  return variable->kind == MPM_STATE_SCALAR ? 1 : MpmSymSize(dim);
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

void MpmMaterialDirection(const MpmMaterial *material, PetscInt place, PetscReal value, PetscInt stride,
                          double direction[])
{
  const MpmParameter *parameters = material->info.parameters;

  direction[place * stride] = value;
  for (size_t k = 0; k < material->info.parameter_count; k++)
    if (parameters[k].same_as && !material->set[k] && !strcmp(parameters[k].same_as, parameters[place].name))
      MpmMaterialDirection(material, (PetscInt)k, value, stride, direction);
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

static double Reduced(MpmParameterKind kind, double given, PetscReal factor)
{
  const PetscReal degree = PETSC_PI / 180.;

  if (kind == MPM_STRENGTH) return given / factor;
  if (kind != MPM_STRENGTH_ANGLE || factor == 1.) return given;
  return PetscAtanReal(PetscTanReal(given * degree) / factor) / degree;
}

void MpmMaterialReduce(MpmMaterial *material, PetscReal factor)
{
  for (size_t i = 0; i < material->info.parameter_count; i++) {
    const MpmParameterKind kind = material->info.parameters[i].kind;

    if (kind == MPM_STRENGTH || kind == MPM_STRENGTH_ANGLE)
      material->parameter[i] = Reduced(kind, material->given[i], factor);
  }
  if (material->varies) material->varies->factor = factor;
}

/* ---- parameters that vary ---- */

PetscInt MpmMaterialOwnSize(const MpmMaterial *material)
{
  const MpmVariations *varies = material->varies;
  PetscInt             size   = (PetscInt)material->info.parameter_count;

  if (!varies) return 0;
  return size + (varies->physics ? MPM_MAX_DIM * varies->physics->parameter_count + varies->physics->common_count : 0);
}

void MpmMaterialOwn(const MpmMaterial *material, const MpmPlace *place, double own[])
{
  const MpmVariations *varies = material->varies;
  const PetscInt       of_law = (PetscInt)material->info.parameter_count, size = MpmMaterialOwnSize(material);

  for (PetscInt k = 0; k < of_law; k++) own[k] = material->parameter[k];
  for (PetscInt k = of_law; k < size; k++) own[k] = varies->physics_given[k - of_law];
  for (PetscInt v = 0; v < varies->count; v++) {
    const MpmVariation *variation = &varies->at[v];
    const PetscReal     value     = MpmVariationEvaluate(variation, place);

    for (PetscInt k = variation->place; k < variation->place + variation->places; k++)
      own[k] = k < of_law ? Reduced(material->info.parameters[k].kind, value, varies->factor) : value;
  }
  if (varies->physics && varies->physics->prepare) {
    const MpmPhysicsMaterial of = MpmMaterialForPhysics(material, own, varies->dim);

    (void)varies->physics->prepare(&of, varies->gravity, own + of_law); /* whether values go together is known by now */
  }
}

/* A variation of the material: the first makes the list. Its largest value becomes the material's. */
static PetscErrorCode AddVariation(MpmMaterial *material, PetscInt place, PetscInt places, MpmVariation *variation,
                                   double value[])
{
  MpmVariations *varies = material->varies;
  PetscReal      least, most;

  PetscFunctionBeginUser;
  if (!varies) {
    PetscCall(PetscNew(&varies));
    varies->factor   = 1.;
    material->varies = varies;
  }
  PetscCall(PetscRealloc((size_t)(varies->count + 1) * sizeof(*varies->at), &varies->at));
  variation->place            = place;
  variation->places           = places;
  varies->at[varies->count++] = *variation;
  MpmVariationBounds(variation, &least, &most);
  for (PetscInt k = 0; k < places; k++) value[k] = most;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const MpmVariation *FindVariation(const MpmMaterial *material, PetscInt place)
{
  for (PetscInt v = 0; material->varies && v < material->varies->count; v++)
    if (material->varies->at[v].place == place) return &material->varies->at[v];
  return NULL;
}

PetscBool MpmMaterialVaries(const MpmMaterial *material, PetscInt place)
{
  return (PetscBool)(FindVariation(material, place) != NULL);
}

/* Bounds of a parameter of the law, whether it varies or not */
static void ParameterBounds(const MpmMaterial *material, PetscInt k, PetscReal *least, PetscReal *most)
{
  const MpmVariation *variation = FindVariation(material, k);

  *least = *most = material->parameter[k];
  if (variation) MpmVariationBounds(variation, least, most);
}

PetscErrorCode MpmMaterialVaryingText(const MpmMaterial *material, char **text)
{
  const PetscInt of_law = (PetscInt)material->info.parameter_count;

  PetscFunctionBeginUser;
  for (PetscInt v = 0; v < material->varies->count; v++) {
    const MpmVariation *variation = &material->varies->at[v];
    const char         *name      = variation->place < of_law ? material->info.parameters[variation->place].name : NULL;
    PetscInt            place     = of_law;

    for (int k = 0; !name && k < material->varies->physics->parameter_count; k++) {
      if (place == variation->place) name = material->varies->physics->parameters[k].name;
      place += MpmParameterPlaces(&material->varies->physics->parameters[k]);
    }
    PetscCall(MpmTextAppend(text, "%s%s", v ? ", " : "", name));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Parameters at the rows of all variations, before and behind a jump: none may contradict another, and the material is
  symmetric where the law is at each. At rows of one kind those of other kinds have their largest values.
*/
static PetscErrorCode CheckVariations(MpmMaterial *material)
{
  const MpmVariations *varies    = material->varies;
  const PetscInt       of_law    = (PetscInt)material->info.parameter_count;
  double              *given     = material->parameter, *own;
  PetscBool            symmetric = PETSC_TRUE;

  PetscFunctionBeginUser;
  if (!varies || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(of_law, &own));
  for (PetscInt r = 0; r < varies->count; r++) {
    const MpmVariation *rows = &varies->at[r];

    for (PetscInt k = 0; k < 2 * rows->count; k++) {
      const MpmPlace at = {rows->dim || rows->ground ? 0. : nextafter(rows->at[k / 2], k % 2 ? HUGE_VAL : -HUGE_VAL),
                           rows->dim ? &rows->at[k / 2 * MPM_MAX_DIM] : NULL, 0};

      PetscCall(PetscArraycpy(own, given, of_law));
      for (PetscInt v = 0; v < varies->count; v++)
        if (varies->at[v].place < of_law && !varies->at[v].dim == !rows->dim && varies->at[v].ground == rows->ground)
          own[varies->at[v].place] =
            rows->ground ? rows->ground->value[k / 2] : MpmVariationEvaluate(&varies->at[v], &at);
      material->parameter = own;
      PetscCall(CheckParameters(material));
      if (material->info.symmetric && !material->info.symmetric(own, material->table)) symmetric = PETSC_FALSE;
    }
  }
  material->parameter = given;
  PetscCall(PetscFree(own));
  if (!symmetric) material->info.traits &= ~(unsigned)MPM_LAW_SYMMETRIC;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- a material of the scene ---- */

/* A number, word, table or data of the law, or a number that varies; one left out varies as its default does. */
static PetscErrorCode ReadParameter(const MpmOptions *block, PetscInt dim, const MpmGrounds *grounds, PetscInt k,
                                    MpmMaterial *material)
{
  const MpmParameter  parameter = WithDefault(material, (size_t)k);
  const MpmVariation *same      = NULL;
  MpmGround          *ground    = MpmGroundsFind(grounds, material->name, parameter.name);
  MpmVariation        variation = {0};
  PetscReal           least, most;
  PetscBool           has, mapped = PETSC_FALSE;

  PetscFunctionBeginUser;
  if (MpmBasalFind(material->info.name) && k >= MPM_BASAL_OWN)
    PetscCall(MpmBasalMapLeast(block, &parameter, &material->parameter[k], &mapped));
  if (mapped) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsHas(block, parameter.name, &has));
  material->set[k] = (int)(has || ground);
  if (parameter.kind < MPM_WORD) PetscCall(MpmVariationRead(block, ground, &parameter, dim, &variation));
  for (PetscInt i = 0; parameter.same_as && !material->set[k] && i < k; i++)
    if (!strcmp(material->info.parameters[i].name, parameter.same_as)) same = FindVariation(material, i);
  if (same) PetscCall(MpmVariationCopy(same, &variation));
  if (variation.count) PetscCall(AddVariation(material, k, 1, &variation, &material->parameter[k]));
  else PetscCall(MpmParameterRead(block, &parameter, &material->parameter[k], &material->table[k]));
  ParameterBounds(material, k, &least, &most);
  if (!strcmp(parameter.name, "density")) material->density = least;
  if (!strcmp(parameter.name, "E")) material->moduli.penalty = most;
  if (!strcmp(parameter.name, "nu")) material->moduli.nu = most;
  if (!strcmp(parameter.name, "dilation")) {
    material->dilation.least = least;
    material->dilation.most  = most;
  }
  if (!strcmp(parameter.name, "dilation_residual")) {
    material->dilation.least = PetscMin(material->dilation.least, least);
    material->dilation.most  = PetscMax(material->dilation.most, most);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A material whose law is one of these names, which are freed. */
static PetscErrorCode Create(const MpmOptions *options, const char *name, PetscInt kinematics, const char **names,
                             const MpmGrounds *grounds, MpmMaterial *material)
{
  const PetscInt dim = MpmKinematicsDim((int)kinematics);
  char           prefix[256];
  MpmOptions     block = {options->comm, prefix, options->record};
  PetscInt       type  = 0;
  PetscBool      given;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(material, sizeof(*material)));
  material->kinematics = (int)kinematics;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_material_%s_", name));
  PetscCall(PetscStrallocpy(name, &material->name));
  PetscCall(MpmOptionsHeading(&block, "Material"));
  PetscCall(MpmOptionsWord(&block, "type", "constitutive law", names, MPM_REQUIRED, &type, &given));
  PetscCheck(MpmLawFindAll(names[type], kinematics, material->law, &material->info), options->comm, PETSC_ERR_PLIB,
             "law %s is not compiled", names[type]);
  PetscCall(PetscFree(names));
  PetscCall(PetscCalloc1(material->info.parameter_count, &material->parameter));
  PetscCall(PetscCalloc1(material->info.parameter_count, &material->given));
  PetscCall(PetscCalloc1(material->info.parameter_count, &material->table));
  PetscCall(PetscCalloc1(material->info.parameter_count, &material->set));
  if (!given) PetscCall(MpmLawPrintHelp(&block));
  for (size_t i = 0; given && i < material->info.parameter_count; i++)
    PetscCall(ReadParameter(&block, dim, grounds, (PetscInt)i, material));
  PetscCall(PetscArraycpy(material->given, material->parameter, material->info.parameter_count));
  if (!material->varies) PetscCall(CheckParameters(material));
  if (material->info.symmetric) {
    const PetscBool symmetric = (PetscBool)(material->info.symmetric(material->parameter, material->table) != 0);

    material->info.traits =
      (material->info.traits & ~(unsigned)MPM_LAW_SYMMETRIC) | (symmetric ? MPM_LAW_SYMMETRIC : 0);
  }
  PetscCall(CheckVariations(material));
  material->moduli.stiffness = MpmMaterialStiffness(material, NULL, NULL, NULL);
  if (material->info.shear_modulus && material->info.traits & MPM_LAW_FIXED_MODULI)
    material->moduli.shear = material->info.shear_modulus(material->parameter, material->table, NULL, NULL);
  if (material->moduli.penalty == 0.) material->moduli.penalty = material->moduli.stiffness;
  for (size_t i = 0; i < material->info.state_count; i++)
    material->state_size += MpmStateComponents(&material->info.states[i], dim);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialCreate(const MpmOptions *options, const char *name, PetscInt kinematics,
                                 const MpmGrounds *grounds, MpmMaterial *material)
{
  const char **names;

  PetscFunctionBeginUser;
  PetscCall(MpmLawNames(&names));
  PetscCall(Create(options, name, kinematics, names, grounds, material));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmMaterialCreateColumn(const MpmOptions *options, const char *name, const MpmGrounds *grounds,
                                       MpmMaterial *material)
{
  const char **names;

  PetscFunctionBeginUser;
  PetscCall(MpmBasalNames(&names));
  PetscCall(Create(options, name, MPM_PLANE_STRAIN, names, grounds, material));
  material->basal = MpmBasalFind(material->info.name);
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
                                      const MpmGrounds *grounds, MpmMaterial *material)
{
  char           prefix[256], title[128];
  MpmOptions     block = {options->comm, prefix, options->record};
  MpmLawTable    unused;
  const PetscInt size  = MPM_MAX_DIM * physics->parameter_count + physics->common_count;
  PetscInt       place = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_material_%s_", material->name));
  PetscCall(PetscCalloc1(size, &material->physics_parameter));
  PetscCall(PetscSNPrintf(title, sizeof(title), "Material with physics %s", physics->name));
  if (physics->parameter_count) PetscCall(MpmOptionsHeading(&block, title));
  for (int k = 0; k < physics->parameter_count; k++) {
    const MpmParameter *parameter = &physics->parameters[k];
    MpmVariation        variation = {0};

    PetscCheck(parameter->kind <= MPM_WORD || parameter->kind == MPM_AXES, options->comm, PETSC_ERR_SUP,
               "physics %s: its parameter %s must be a number or a word", physics->name, parameter->name);
    if (parameter->kind != MPM_WORD)
      PetscCall(
        MpmVariationRead(&block, MpmGroundsFind(grounds, material->name, parameter->name), parameter, dim, &variation));
    if (variation.count)
      PetscCall(AddVariation(material, (PetscInt)material->info.parameter_count + place, MpmParameterPlaces(parameter),
                             &variation, &material->physics_parameter[place]));
    else if (parameter->kind == MPM_AXES)
      PetscCall(ReadAxes(&block, dim, parameter, &material->physics_parameter[place]));
    else PetscCall(MpmParameterRead(&block, parameter, &material->physics_parameter[place], &unused));
    place += MpmParameterPlaces(parameter);
  }
  for (int k = 0; k < physics->common_count; k++) {
    PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_%s_", physics->common[k].block));
    PetscCall(MpmOptionsHeading(&block, physics->common[k].block));
    PetscCall(MpmParameterRead(&block, &physics->common[k].parameter, &material->physics_parameter[place++], &unused));
  }
  if (!material->varies) PetscFunctionReturn(PETSC_SUCCESS);
  material->varies->physics = physics;
  PetscCall(PetscMalloc1(size, &material->varies->physics_given));
  PetscCall(PetscArraycpy(material->varies->physics_given, material->physics_parameter, size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

MpmPhysicsMaterial MpmMaterialForPhysics(const MpmMaterial *material, const double own[], PetscInt dim)
{
  return (MpmPhysicsMaterial){&material->info, own ? own : material->parameter, material->set, material->table,
                              (int)dim};
}

PetscErrorCode MpmMaterialPrepare(const MpmPhysics *physics, PetscInt dim, PetscReal gravity, MpmMaterial *material)
{
  const MpmPhysicsMaterial of = MpmMaterialForPhysics(material, NULL, dim);
  const char              *why;

  PetscFunctionBeginUser;
  if (material->varies) {
    material->varies->dim     = dim;
    material->varies->gravity = gravity;
  }
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
  for (PetscInt v = 0; material->varies && v < material->varies->count; v++)
    PetscCall(MpmVariationDestroy(&material->varies->at[v]));
  if (material->varies) {
    PetscCall(PetscFree(material->varies->at));
    PetscCall(PetscFree(material->varies->physics_given));
  }
  PetscCall(PetscFree(material->varies));
  PetscCall(MpmTablesDestroy(material->info.parameter_count, &material->table));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const double *Parameters(const MpmMaterial *material, const double own[])
{
  return own ? own : material->parameter;
}

/* The number of this name in a row, or `otherwise` where the law has none. */
static PetscReal OwnNumber(const MpmMaterial *material, const double own[], const char name[], PetscReal otherwise)
{
  for (size_t k = 0; own && k < material->info.parameter_count; k++)
    if (!strcmp(material->info.parameters[k].name, name)) return own[k];
  return otherwise;
}

PetscReal MpmMaterialDensity(const MpmMaterial *material, const double own[])
{
  return OwnNumber(material, own, "density", material->density);
}

PetscReal MpmMaterialPenalty(const MpmMaterial *material, const double own[])
{
  const PetscReal E = OwnNumber(material, own, "E", 0.);

  if (!own || E > 0.) return own ? E : material->moduli.penalty;
  return MpmMaterialStiffness(material, own, NULL, NULL);
}

PetscReal MpmMaterialShearStrength(const MpmMaterial *material, const double own[], const PetscReal state[])
{
  if (!material->info.shear_strength) return PETSC_INFINITY;
  return material->info.shear_strength(Parameters(material, own), state);
}

PetscReal MpmMaterialStiffness(const MpmMaterial *material, const double own[], const PetscReal state[],
                               const PetscReal F[])
{
  return material->info.stiffness(Parameters(material, own), material->table, state, F);
}

PetscReal MpmMaterialShearModulus(const MpmMaterial *material, const double own[], const PetscReal state[],
                                  const PetscReal F[])
{
  if (!material->info.shear_modulus) return 0.;
  return material->info.shear_modulus(Parameters(material, own), material->table, state, F);
}

PetscReal MpmMaterialWaveSpeed(const MpmMaterial *material, const double own[], PetscInt dim, const PetscReal state[],
                               const PetscReal F[], const PetscReal stress[])
{
  const PetscReal modulus = MpmMaterialStiffness(material, own, state, F), density = MpmMaterialDensity(material, own);

  if (!stress) return PetscSqrtReal(modulus / density);
  return MpmWaveSpeed(dim, modulus, density, F ? MpmDeterminant(MpmKinematicsF(material->kinematics), F) : 1., stress);
}

PetscReal MpmMaterialViscosity(const MpmMaterial *material, const double own[])
{
  return material->info.viscosity ? material->info.viscosity(Parameters(material, own), material->table) : 0.;
}

int MpmMaterialSensitivity(const MpmMaterial *material, const MpmLawInput *input, const MpmLawInput *direction,
                           const MpmLawOutput *value, const MpmLawOutput *derivative)
{
  const MpmSensitivity sensitivity = (MpmSensitivity)material->law[MPM_FORM_SENSITIVITY];
  MpmLawInput          full        = *input;

  full.parameter = Parameters(material, input->parameter);
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

PetscErrorCode MpmMaterialReadAir(const MpmOptions *options, MpmMaterial *material)
{
  MpmOptions block  = {options->comm, NULL, options->record};
  char      *prefix = NULL;
  PetscBool  air    = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(MpmTextAppend(&prefix, "mpm_material_%s_", material->name));
  block.prefix = prefix;
  PetscCall(MpmOptionsBool(&block, "air",
                           "a soft material in place of void: without loads, surfaces, boundaries, contacts and "
                           "tracks, and written with -mpm_output_air alone",
                           &air, NULL));
  if (air) material->info.traits |= MPM_MATERIAL_AIR;
  PetscCall(PetscFree(prefix));
  PetscFunctionReturn(PETSC_SUCCESS);
}
