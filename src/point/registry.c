/*
  Laws that were compiled in, and laws and physics that callers and plugins add.

  The registry is the process', as PETSc's own registries of types are: with the types of terms (term_types.c) and the
  note of a signal the only data of the engine that no model owns. Entries are only added, until PetscFinalize(), and
  models use the registry only while they read their scene.
*/
#include <dlfcn.h>
#include "talus/plugin.h"
#include "options/options.h"
#include "point/basal_laws.h"
#include "point/parameter.h"
#include "point/registry.h"

static struct {
  PetscInt        law_count, physics_count, plugin_count;
  MpmLawInstance *laws;
  MpmPhysics     *physics;
  void          **plugins; /* handles of the files that have been loaded: they stay */
} registry;

static PetscErrorCode Forget(void)
{
  PetscFunctionBegin;
  PetscCall(PetscFree(registry.laws));
  PetscCall(PetscFree(registry.physics));
  PetscCall(PetscFree(registry.plugins));
  registry.law_count = registry.physics_count = registry.plugin_count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Makes room for `more` entries behind `count`. */
static PetscErrorCode Grow(size_t entry, PetscInt count, PetscInt more, void *array)
{
  PetscFunctionBegin;
  if (!registry.law_count && !registry.physics_count && !registry.plugin_count)
    PetscCall(PetscRegisterFinalize(Forget));
  PetscCall(PetscRealloc(entry * (size_t)(count + more), (void **)array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ---- laws ----

  The build scans materials/ and lists the constructor of every law, once per kernel instance, in mpm_laws.h.
*/

const MpmLawInstance *MpmLawRegistered(PetscInt k)
{
  return k < registry.law_count ? &registry.laws[k] : NULL;
}

static const MpmLawInstance *FindInstance(PetscInt count, const MpmLawInstance list[], const char *name, int kinematics,
                                          MpmForm form)
{
  for (PetscInt k = 0; k < count; k++)
    if (list[k].kinematics == kinematics && list[k].form == form && !strcmp(list[k].name, name)) return &list[k];
  return NULL;
}

/* All forms must be there, and the name must be free; `known`: it has been registered before, just so. */
static PetscErrorCode CheckLaw(PetscInt count, const MpmLawInstance list[], const MpmLawInstance *law, PetscBool *known)
{
  const MpmLawInstance *other = FindInstance(registry.law_count, registry.laws, law->name, law->kinematics, law->form);
  MpmLawInfo            info;

  PetscFunctionBegin;
  *known = (PetscBool)(other && other->create == law->create);
  if (*known) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!MpmLawFind(law->name, 2, MPM_FORM_RESIDUAL, &info), "law %s: there is one of this name already",
                law->name);
  for (int kinematics = MPM_PLANE_STRAIN; kinematics < MPM_KINEMATICS_COUNT; kinematics++) {
    for (PetscInt form = 0; form < MPM_FORM_COUNT; form++) {
      MpmCheckInput(FindInstance(count, list, law->name, kinematics, (MpmForm)form),
                    "law %s: it is not compiled for %s in the form %d", law->name, MpmKinematicsName(kinematics),
                    (int)form);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLawRegister(PetscInt count, const MpmLawInstance instances[])
{
  PetscBool *known;
  PetscInt   added = 0;

  PetscFunctionBegin;
  PetscCall(PetscMalloc1(count, &known));
  for (PetscInt k = 0; k < count; k++) {
    PetscCall(CheckLaw(count, instances, &instances[k], &known[k]));
    added += known[k] ? 0 : 1;
  }
  PetscCall(Grow(sizeof(*registry.laws), registry.law_count, added, &registry.laws));
  for (PetscInt k = 0; k < count; k++)
    if (!known[k]) registry.laws[registry.law_count++] = instances[k];
  PetscCall(PetscFree(known));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- physics ---- */

const MpmPhysics *MpmPhysicsRegistered(PetscInt k)
{
  return k < registry.physics_count ? &registry.physics[k] : NULL;
}

PetscErrorCode MpmPhysicsRegister(const MpmPhysics *physics)
{
  MpmPhysics other;
  PetscBool  found;

  PetscFunctionBegin;
  MpmCheckInput(physics->name && physics->name[0], "a physics without a name cannot be registered");
  PetscCall(MpmPhysicsCreate(physics->name, &other, &found));
  if (found && other.kernels[2].residual == physics->kernels[2].residual) PetscFunctionReturn(PETSC_SUCCESS);
  MpmCheckInput(!found, "physics %s: there is one of this name already", physics->name);
  PetscCall(Grow(sizeof(*registry.physics), registry.physics_count, 1, &registry.physics));
  registry.physics[registry.physics_count++] = *physics;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- plugins ---- */

typedef PetscErrorCode (*Register)(const MpmPluginHost *host);

/* Opens the file on this rank; `fault` is the reason of a failure, and otherwise empty. */
static PetscErrorCode Open(const char path[], void **handle, char fault[], size_t size)
{
  const char *version;
  char       *name = NULL;

  PetscFunctionBegin;
  fault[0] = '\0';
  PetscCall(MpmTextAppend(&name, "%s%s", strchr(path, '/') ? "" : "./", path)); /* or it is looked for elsewhere */
  *handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
  PetscCall(PetscFree(name));
  if (!*handle) {
    PetscCall(PetscSNPrintf(fault, size, "cannot be loaded: %s", dlerror()));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  version = (const char *)dlsym(*handle, "MpmPluginVersion");
  if (!version || !dlsym(*handle, "MpmPluginRegister"))
    PetscCall(PetscSNPrintf(fault, size, "is no plugin: it has no MpmPluginVersion and MpmPluginRegister"));
  else if (strcmp(version, MPM_VERSION))
    PetscCall(PetscSNPrintf(fault, size, "is for Talus %.32s, this is " MPM_VERSION, version));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Load(MPI_Comm comm, const char path[])
{
  const MpmPluginHost host = {MpmLawRegister, MpmPhysicsRegister, MpmTermRegister, MpmContactBodyRegister};
  char                fault[512];
  void               *handle = NULL, *symbol;
  Register            entry;
  PetscMPIInt         rank, size, first;

  PetscFunctionBegin;
  PetscCall(Open(path, &handle, fault, sizeof(fault)));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &size));
  first = fault[0] ? rank : size;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, comm));
  if (first < size) PetscCallMPI(MPI_Bcast(fault, (PetscMPIInt)sizeof(fault), MPI_CHAR, first, comm));
  MpmCheckInput(first == size, "-mpm_plugin %s: %s", path, fault);
  for (PetscInt k = 0; k < registry.plugin_count; k++)
    if (registry.plugins[k] == handle) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(Grow(sizeof(*registry.plugins), registry.plugin_count, 1, &registry.plugins));
  registry.plugins[registry.plugin_count++] = handle;
  symbol                                    = dlsym(handle, "MpmPluginRegister");
  PetscCall(PetscMemcpy(&entry, &symbol, sizeof(entry)));
  PetscCall((*entry)(&host));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPluginsLoad(const MpmOptions *options)
{
  char    *text, **paths;
  PetscInt count;

  PetscFunctionBegin;
  PetscCall(MpmOptionsText(
    options, "plugin",
    "files with laws, physics, terms and bodies in contact that were compiled outside the program, separated by commas",
    NULL, MPM_OPTIONAL, &text));
  if (!text) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmTextSplit(text, &count, &paths));
  for (PetscInt k = 0; k < count; k++) {
    PetscCall(MpmOptionsResolve(options, "plugin", &paths[k]));
    PetscCall(Load(options->comm, paths[k]));
  }
  PetscCall(MpmNamesDestroy(count, &paths));
  PetscCall(PetscFree(text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  ---- laws ----

  The build scans materials/ and lists the constructor of every law, once per kernel instance, in mpm_laws.h.
*/

#define MPM_LAW_INSTANCE(name, kinematics, kind, instance, form) \
  void MpmMaterialCreate_##name##_##kind##_##instance(MpmLawInfo *info);
#include "mpm_laws.h"
#undef MPM_LAW_INSTANCE

static const MpmLawInstance compiled[] = {
#define MPM_LAW_INSTANCE(name, kinematics, kind, instance, form) \
  {#name, kinematics, form, MpmMaterialCreate_##name##_##kind##_##instance},
#include "mpm_laws.h"
#undef MPM_LAW_INSTANCE
};

/* All instances, those compiled in and those registered; NULL behind the last. */
static const MpmLawInstance *Instance(PetscInt k)
{
  const PetscInt own = (PetscInt)PETSC_STATIC_ARRAY_LENGTH(compiled);

  return k < own ? &compiled[k] : MpmLawRegistered(k - own);
}

/* The next law from `k` on, one instance for each. */
static const MpmLawInstance *NextLaw(PetscInt *k)
{
  for (const MpmLawInstance *law = Instance((*k)++); law; law = Instance((*k)++))
    if (law->kinematics == MPM_SPATIAL && law->form == MPM_FORM_RESIDUAL) return law;
  return NULL;
}

/* A law of the bed: the column's, with the parameters of that. */
static PetscBool FindBasal(const char *name, PetscInt kinematics, MpmForm form, MpmLawInfo *info)
{
  const MpmBasalLaw *basal = MpmBasalFind(name);

  if (!basal || !MpmLawFind("column_law", kinematics, form, info)) return PETSC_FALSE;
  info->name            = basal->name;
  info->summary         = basal->summary;
  info->parameters      = basal->parameters;
  info->parameter_count = basal->parameter_count;
  info->check           = basal->check;
  return PETSC_TRUE;
}

PetscBool MpmLawFind(const char *name, PetscInt kinematics, MpmForm form, MpmLawInfo *info)
{
  const MpmLawInstance *law;

  for (PetscInt k = 0; (law = Instance(k)); k++) {
    if (law->kinematics == kinematics && law->form == form && !strcmp(law->name, name)) {
      law->create(info);
      return PETSC_TRUE;
    }
  }
  return FindBasal(name, kinematics, form, info);
}

PetscBool MpmLawFindAll(const char *name, PetscInt kinematics, MpmFunction law[], MpmLawInfo *info)
{
  MpmDilatancySensitivity dilatancy = NULL;
  MpmModuliSensitivity    moduli    = NULL;

  for (PetscInt form = 0; form < MPM_FORM_COUNT; form++) {
    if (!MpmLawFind(name, kinematics, (MpmForm)form, info)) return PETSC_FALSE;
    law[form] = info->law;
    if (form != MPM_FORM_SENSITIVITY) continue;
    dilatancy = info->dilatancy_sensitivity;
    moduli    = info->moduli_sensitivity;
  }
  if (!MpmLawFind(name, kinematics, MPM_FORM_RESIDUAL, info)) return PETSC_FALSE;
  info->dilatancy_sensitivity = dilatancy;
  info->moduli_sensitivity    = moduli;
  return PETSC_TRUE;
}

PetscErrorCode MpmLawNames(const char ***names)
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

PetscErrorCode MpmLawPrintHelp(const MpmOptions *block)
{
  const MpmOptions unrecorded = {block->comm, block->prefix, NULL}; /* laws share parameters: each is printed again */
  const MpmOptions body       = {block->comm, "mpm_body_NAME_", NULL};
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
    for (size_t v = 0; v < info.state_count; v++) {
      char *text = NULL;

      if (info.states[v].kind == MPM_STATE_SCALAR) PetscCall(MpmStateReadInitial(&body, &info.states[v], &text));
      PetscCall(PetscFree(text));
    }
  }
  PetscCall(MpmBasalPrintHelp(block));
  PetscFunctionReturn(PETSC_SUCCESS);
}
