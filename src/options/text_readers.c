/*
  Readers of texts, paths and names (options.h), as those of numbers (readers.c).
*/
#include <ctype.h>
#include <string.h>
#include <sys/stat.h>
#include "options/help.h"
#include "options/item.h"
#include "options/options.h"

/* Free text, or the name of a file. */
static PetscErrorCode ReadText(const MpmOptions *options, const MpmOptionSpec *spec, char **value)
{
  const char *fallback = spec->fallback;
  MpmItem     item;

  PetscFunctionBegin;
  *value = NULL;
  PetscCall(MpmItemRead(options, spec, &item));
  if (item.given && !item.raw && spec->need == MPM_REQUIRED)
    PetscCall(MpmItemRefuse(&item, spec, "a value must follow"));
  if (item.given) PetscCall(PetscStrallocpy(item.raw ? item.raw : "", value));
  else if (fallback) PetscCall(PetscStrallocpy(fallback, value));
  PetscCall(MpmItemDestroy(&item, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsText(const MpmOptions *options, const char *name, const char *help, const char *fallback,
                              MpmNeed need, char **value)
{
  const MpmOptionSpec spec = {
    name, help, NULL, "text", fallback, need, PETSC_TRUE, PETSC_FALSE, MPM_OPTION_TEXT, 1, MPM_RANGE_ANY};

  PetscFunctionBegin;
  PetscCall(ReadText(options, &spec, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Whether there is such a file, and another one than the second. */
static int IsOther(const char path[], const char second[])
{
  struct stat one, two;

  if (stat(path, &one)) return 0;
  return stat(second, &two) || one.st_dev != two.st_dev || one.st_ino != two.st_ino;
}

PetscErrorCode MpmOptionsResolve(const MpmOptions *options, const char *name, char **path)
{
  MpmRecord   record = options->record;
  char       *full, *beside = NULL;
  const char *scene, *slash;
  PetscMPIInt rank;
  int         found = 0;

  PetscFunctionBegin;
  if (!record || !*path || !**path || **path == '/') PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmItemFullName(options, name, &full));
  scene = MpmSourcesFile(record->sources, full);
  slash = scene ? strrchr(scene, '/') : NULL;
  if (slash) {
    PetscCall(MpmTextAppend(&beside, "%.*s%s", (int)(slash - scene) + 1, scene, *path));
    PetscCallMPI(MPI_Comm_rank(options->comm, &rank));
    if (!rank) found = IsOther(beside, *path);
    PetscCallMPI(MPI_Bcast(&found, 1, MPI_INT, 0, options->comm));
  }
  PetscCall(PetscFree(full));
  if (!found) PetscFunctionReturn(PetscFree(beside));
  PetscCall(PetscFree(*path));
  *path = beside;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsPath(const MpmOptions *options, const char *name, const char *help, MpmNeed need, char **value)
{
  const MpmOptionSpec spec = {name, help,         NULL, "text", NULL, need, PETSC_TRUE, PETSC_FALSE, MPM_OPTION_FILE,
                              1,    MPM_RANGE_ANY};
  MpmRecordEntry     *entry;
  char               *full;

  PetscFunctionBegin;
  PetscCall(ReadText(options, &spec, value));
  if (!*value || !options->record || MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmOptionsResolve(options, name, value));
  PetscCall(MpmItemFullName(options, name, &full));
  PetscCall(MpmRecordGet(options->record, full, &entry));
  PetscCall(PetscFree(entry->value));
  PetscCall(PetscStrallocpy(*value, &entry->value));
  PetscCall(PetscFree(full));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Options are looked up case aside, so names that differ in case only would share their block. */
static PetscErrorCode CheckName(const MpmItem *item, const MpmOptionSpec *spec, PetscInt index, char *const names[])
{
  const char *name = names[index];

  PetscFunctionBegin;
  for (const char *c = name; *c; c++) {
    if (!isalnum((unsigned char)*c) && *c != '_')
      PetscCall(MpmItemRefuse(item, spec, "names consist of letters, digits and underscores"));
  }
  if (!*name) PetscCall(MpmItemRefuse(item, spec, "a name is empty"));
  for (PetscInt i = 0; i < index; i++) {
    PetscBool same;

    PetscCall(PetscStrcasecmp(names[i], name, &same));
    if (same) PetscCall(MpmItemRefuse(item, spec, "two names are alike (upper and lower case are not told apart)"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode ReadNames(const MpmOptions *options, const char *name, const char *help, MpmOptionType type,
                                MpmNeed need, PetscInt *count, char ***names)
{
  const char *accepted     = type == MPM_OPTION_BLOCKS ? "names of blocks, comma-separated" : "names, comma-separated";
  const MpmOptionSpec spec = {name, help, NULL, accepted, NULL, need, PETSC_FALSE, PETSC_FALSE, type, 0, MPM_RANGE_ANY};
  MpmItem             item;

  PetscFunctionBegin;
  *count = 0;
  *names = NULL;
  PetscCall(MpmItemRead(options, &spec, &item));
  if (item.given) {
    PetscCall(MpmTextSplit(item.raw ? item.raw : "", count, names));
    if (*count == 0 && need == MPM_REQUIRED) PetscCall(MpmItemRefuse(&item, &spec, "a value must follow"));
    for (PetscInt i = 0; i < *count; i++) PetscCall(CheckName(&item, &spec, i, *names));
    if (*count == 0) PetscCall(PetscFree(*names));
  }
  PetscCall(MpmItemDestroy(&item, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsNames(const MpmOptions *options, const char *name, const char *help, MpmNeed need,
                               PetscInt *count, char ***names)
{
  PetscFunctionBegin;
  PetscCall(ReadNames(options, name, help, MPM_OPTION_NAMES, need, count, names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmOptionsBlocks(const MpmOptions *options, const char *list, const char *help, MpmNeed need,
                                PetscInt *count, char ***names)
{
  PetscFunctionBegin;
  PetscCall(MpmOptionsHeading(options, list));
  PetscCall(ReadNames(options, list, help, MPM_OPTION_BLOCKS, need, count, names));
  if (options->record) {
    MpmRecordEntry *entry;
    char           *full;

    PetscCall(MpmItemFullName(options, list, &full));
    PetscCall(MpmRecordGet(options->record, full, &entry));
    entry->list = PETSC_TRUE;
    PetscCall(PetscFree(full));
  }
  if (*count || !MpmOptionsHelp()) PetscFunctionReturn(PETSC_SUCCESS);
  *count = 1;
  PetscCall(PetscMalloc1(1, names));
  PetscCall(PetscStrallocpy("NAME", *names));
  PetscFunctionReturn(PETSC_SUCCESS);
}
