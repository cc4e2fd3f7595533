/*
  Names of PETSc's options: a slip in one ends the run before anything is written.

  PETSc asks for most options late, some when it ends, and only where the solver at hand has them; an option that is
  unused is therefore no slip. A name that PETSc does not contain is one. The build takes all names out of PETSc's
  libraries (cmake/petsc_options.cmake). A solver within a solver asks with a prefix of PETSc's before the name, like
  mg_levels_1_ or fieldsplit_u_. Without libraries to read at the build there is no check.
*/
#include "options/options.h"
#include "options/record.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

#define MOST_EDITS 2 /* of a slip that a name is suggested for */

/* The last entry is the end: a library may yield none. */
static const char *const names[] = {
#include "mpm_petsc_options.h"
  NULL};

/* Of the gradient's solver, the inverse analysis, and solvers within solvers, with a level's number or a field's name
   behind. */
static const char *const prefixes[] = {
  "coarse_",     "deflation_", "esteig_", "fas_coarse_",   "fas_levels_", "gradient_",  "inverse_",
  "fieldsplit_", "galerkin_",  "inner_",  "ksp_",          "levels_",     "lsc_",       "mg_coarse_",
  "mg_fine_",    "mg_levels_", "mpi_",    "npc_",          "pc_bddc_",    "pc_hpddm_",  "redundant_",
  "sub_",        "telescope_", "upper_",  "redistribute_", "hmg_",        "linesearch_"};

/* True where the name is that of the list, in which % is a number. */
static PetscBool IsAlike(const char listed[], const char name[])
{
  for (; *listed; listed++) {
    if (*listed == '%') {
      if (!isdigit((unsigned char)*name)) return PETSC_FALSE;
      while (isdigit((unsigned char)*name)) name++;
    } else if (tolower((unsigned char)*listed) != tolower((unsigned char)*name++)) return PETSC_FALSE;
  }
  return (PetscBool) !*name;
}

static PetscBool IsListed(const char name[])
{
  for (size_t k = 0; names[k]; k++)
    if (IsAlike(names[k], name)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* The prefix of the table that a name begins with: its length, or 0. */
static size_t PrefixLength(const char name[])
{
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(prefixes); k++)
    if (!strncasecmp(name, prefixes[k], strlen(prefixes[k]))) return strlen(prefixes[k]);
  return 0;
}

/* True where PETSc has the option, with prefixes or without. */
static PetscBool IsKnown(const char name[])
{
  const size_t length = PrefixLength(name);

  if (IsListed(name)) return PETSC_TRUE;
  if (!strncasecmp(name, "device_", 7)) return PETSC_TRUE; /* PETSc puts them together from the types of devices */
  if (!length) return PETSC_FALSE;
  for (const char *rest = &name[length]; rest; rest = strchr(rest, '_') ? strchr(rest, '_') + 1 : NULL)
    if (*rest && IsKnown(rest)) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* The nearest name, of the whole or behind the prefixes, which `length` counts; NULL where all need many edits. */
static const char *Nearest(const char name[], size_t *length)
{
  const char *nearest = NULL;
  PetscInt    best    = MOST_EDITS + 1;
  size_t      first   = 0;

  while (name[first]) {
    const PetscInt most = PetscMin(best, (PetscInt)strlen(&name[first]) / 2 + 1);

    for (size_t k = 0; names[k]; k++) {
      const PetscInt distance = MpmTextDistance(&name[first], names[k]);

      if (distance >= PetscMin(best, most)) continue;
      best    = distance;
      nearest = names[k];
      *length = first;
    }
    if (!PrefixLength(name)) break;
    first += strcspn(&name[first], "_");
    first += strspn(&name[first], "_");
  }
  return nearest;
}

PetscErrorCode MpmForeignOptionsCheckNames(MpmRecord record)
{
  MpmDatabaseOption *options;
  PetscInt           count;
  char              *text, *unknown = NULL;

  PetscFunctionBegin;
  PetscCall(MpmDatabaseGetForeign(&count, &options, &text));
  for (PetscInt i = 0; names[0] && i < count && !unknown; i++) {
    const char     *name = options[i].name, *nearest;
    char            ours[PETSC_MAX_OPTION_NAME];
    MpmRecordEntry *entry;
    size_t          length = 0;

    if (IsKnown(name)) continue;
    nearest = Nearest(name, &length);
    PetscCall(PetscSNPrintf(ours, sizeof(ours), "mpm_%s", name));
    PetscCall(MpmRecordFind(record, ours, &entry));
    PetscCall(MpmTextAppend(&unknown, "-%.200s: unknown option", name));
    if (entry) PetscCall(MpmTextAppend(&unknown, "; did you mean -%s?", ours));
    else if (nearest) PetscCall(MpmTextAppend(&unknown, "; did you mean -%.*s%s?", (int)length, name, nearest));
  }
  PetscCall(PetscFree(options));
  PetscCall(PetscFree(text));
  MpmCheckInput(!unknown, "%s", unknown);
  PetscFunctionReturn(PETSC_SUCCESS);
}
