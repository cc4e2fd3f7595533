/*
  Where options were given. PETSc's database holds the last value of each and forgets where it came from; but a list
  that is given later than a block leaves the block out on purpose, and a file that a scene names stands beside the
  scene.
*/
#include "options/database.h"

#include <string.h>
#include <strings.h>

typedef struct {
  char    *name;
  PetscInt source;
} Given;

struct _p_MpmSources {
  PetscInt count, capacity, path_count;
  Given   *given;
  char   **path; /* of each source, NULL for none */
};

PetscErrorCode MpmSourcesCreate(MpmSources *sources)
{
  PetscFunctionBegin;
  PetscCall(PetscNew(sources));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSourcesDestroy(MpmSources *sources)
{
  PetscFunctionBegin;
  if (!*sources) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < (*sources)->count; k++) PetscCall(PetscFree((*sources)->given[k].name));
  PetscCall(PetscFree((*sources)->given));
  PetscCall(MpmNamesDestroy((*sources)->path_count, &(*sources)->path));
  PetscCall(PetscFree(*sources));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const Given *Find(MpmSources sources, const char name[])
{
  for (PetscInt k = sources ? sources->count - 1 : -1; k >= 0; k--)
    if (!strcasecmp(sources->given[k].name, name)) return &sources->given[k];
  return NULL;
}

PetscErrorCode MpmSourcesAdd(MpmSources sources, const char path[], PetscOptions options)
{
  PetscInt count;
  char   **names, **values;

  PetscFunctionBegin;
  PetscCall(PetscRealloc(sizeof(*sources->path) * (size_t)(sources->path_count + 1), &sources->path));
  sources->path[sources->path_count] = NULL;
  if (path) PetscCall(PetscStrallocpy(path, &sources->path[sources->path_count]));
  sources->path_count++;
  PetscCall(PetscOptionsLeftGet(options, &count, &names, &values)); /* all: none has been used */
  if (sources->count + count > sources->capacity) {
    sources->capacity = 2 * sources->capacity + count;
    PetscCall(PetscRealloc(sizeof(*sources->given) * (size_t)sources->capacity, &sources->given));
  }
  for (PetscInt k = 0; k < count; k++) {
    Given *given = &sources->given[sources->count++];

    PetscCall(PetscStrallocpy(names[k], &given->name));
    given->source = sources->path_count;
  }
  PetscCall(PetscOptionsLeftRestore(options, &count, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSourcesInsertFile(MpmSources sources, MPI_Comm comm, PetscOptions options, const char path[],
                                    PetscBool yaml)
{
  PetscOptions alone, both[2];

  PetscFunctionBegin;
  PetscCall(PetscOptionsCreate(&alone));
  both[0] = options;
  both[1] = alone;
  for (size_t k = 0; k < 2; k++) {
    if (yaml) PetscCall(PetscOptionsInsertFileYAML(comm, both[k], path, PETSC_TRUE));
    /* by every rank: with the whole communicator, PETSc stops on the first one and leaves the others waiting */
    else PetscCall(PetscOptionsInsertFile(PETSC_COMM_SELF, both[k], path, PETSC_TRUE));
  }
  PetscCall(MpmSourcesAdd(sources, path, alone));
  PetscCall(PetscOptionsDestroy(&alone));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmSourcesOrder(MpmSources sources, const char name[])
{
  const Given *given = Find(sources, name);

  return given ? given->source : 0;
}

const char *MpmSourcesFile(MpmSources sources, const char name[])
{
  const Given *given = Find(sources, name);

  return given ? sources->path[given->source - 1] : NULL;
}
