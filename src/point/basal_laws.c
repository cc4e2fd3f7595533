/*
  Laws of the bed: the list of those in basal/, which the build writes.
*/
#include <string.h>
#include "options/options.h"
#include "point/basal_laws.h"
#include "point/parameter.h"

#define MPM_BASAL_NAME(name) extern const MpmBasalLaw MpmBasal_##name;
#include "mpm_basal.h"
#undef MPM_BASAL_NAME

static const MpmBasalLaw *const laws[] = {
#define MPM_BASAL_NAME(name) &MpmBasal_##name,
#include "mpm_basal.h"
#undef MPM_BASAL_NAME
};
#define COUNT PETSC_STATIC_ARRAY_LENGTH(laws)

const MpmBasalLaw *MpmBasalFind(const char *name)
{
  for (size_t k = 0; k < COUNT; k++)
    if (!strcmp(laws[k]->name, name)) return laws[k];
  return NULL;
}

PetscErrorCode MpmBasalNames(const char ***names)
{
  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((COUNT + 1), names));
  for (size_t k = 0; k < COUNT; k++) (*names)[k] = laws[k]->name;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBasalPrintHelp(const MpmOptions *block)
{
  const MpmOptions unrecorded = {block->comm, block->prefix, NULL}; /* laws share parameters: each is printed again */
  char             title[256];

  PetscFunctionBeginUser;
  for (size_t k = 0; k < COUNT; k++) {
    MpmLawTable table;
    double      unused;

    PetscCall(PetscSNPrintf(title, sizeof(title), "Material of type %s: %s", laws[k]->name, laws[k]->summary));
    PetscCall(MpmOptionsHeading(block, title));
    for (size_t i = 0; i < laws[k]->parameter_count; i++) {
      PetscCall(MpmParameterRead(&unrecorded, &laws[k]->parameters[i], &unused, &table));
      PetscCall(PetscFree(table.value));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
