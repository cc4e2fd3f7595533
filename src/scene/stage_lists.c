/*
  The lists of names that stages have: which conditions, motions and loads act in each, and which bodies change.
*/
#include <stddef.h>
#include "options/options.h"
#include "bc/bc.h"
#include "bc/body_motion.h"
#include "loads/body_surface.h"
#include "loads/load.h"
#include "scene/stage_lists.h"

PetscInt MpmStageFindName(PetscInt count, char *const names[], const char *name)
{
  for (PetscInt k = 0; k < count; k++)
    if (!strcmp(names[k], name)) return k;
  return -1;
}

/* A stage's list; `given` is false where it has none. The word `none` is an empty list. */
static PetscErrorCode ReadList(const MpmOptions *block, const char *list, const char *help, PetscInt *count,
                               char ***names, PetscBool *given)
{
  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(block, list, given));
  PetscCall(MpmOptionsNames(block, list, help, MPM_OPTIONAL, count, names));
  MpmCheckInput(!*given || *count || MpmOptionsHelp(), "-%s%s: the list is empty; an empty one is `none`",
                block->prefix, list);
  if (*count == 1 && !strcmp((*names)[0], "none")) {
    PetscCall(MpmNamesDestroy(*count, names));
    *count = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStageMarkList(const MpmOptions *block, const char *list, const char *help, MpmNameList all,
                                PetscBool **marks, PetscBool *given)
{
  PetscInt own;
  char   **own_names;

  PetscFunctionBeginUser;
  PetscCall(ReadList(block, list, help, &own, &own_names, given));
  PetscCall(PetscCalloc1((*all.count + own + 1), marks));
  for (PetscInt k = 0; k < own; k++) {
    PetscInt found = MpmStageFindName(*all.count, *all.names, own_names[k]);

    MpmCheckInput(found >= 0 || all.grows || MpmOptionsHelp(), "-%s%s %s: there is no such body in -mpm_bodies",
                  block->prefix, list, own_names[k]);
    if (found < 0 && !all.grows) continue;
    if (found < 0) {
      found = (*all.count)++;
      PetscCall(PetscRealloc(sizeof(**all.names) * (size_t)*all.count, all.names));
      PetscCall(PetscStrallocpy(own_names[k], &(*all.names)[found]));
    }
    (*marks)[found] = PETSC_TRUE;
  }
  PetscCall(MpmNamesDestroy(own, &own_names));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Marks for `count` names out of fewer; without a list of its own the stage has the scene's first `scene` names. */
static PetscErrorCode WidenMarks(PetscInt had, PetscInt count, PetscInt scene, PetscBool given, PetscBool **marks)
{
  PetscBool *wide;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((count + 1), &wide));
  for (PetscInt k = 0; k < count; k++) wide[k] = (PetscBool)(given ? k < had && (*marks)[k] : k < scene);
  PetscCall(PetscFree(*marks));
  *marks = wide;
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define LISTS 4

/* The lists of a stage's active blocks: their names, the model's names, and the stage's marks. */
typedef struct {
  const char *name, *help;
  MpmNameList all;
  PetscInt    scene; /* names that the scene itself lists */
  size_t      marks; /* where they stand in a stage */
} ActiveList;

static PetscBool **Marks(MpmStage *stage, const ActiveList *list)
{
  return (PetscBool **)((char *)stage + list->marks);
}

/* Conditions, motions, loads and surfaces of all stages; `had` is the number of names known when each stage's list was
   read. */
static PetscErrorCode ReadActive(MpmScene *scene, const MpmOptions *options)
{
  ActiveList list[LISTS] = {{"bcs",
                             "conditions on nodes that act; default: -mpm_bcs; none",
                             {&scene->bcs->count, &scene->bcs->names, PETSC_TRUE},
                             scene->bcs->count,
                             offsetof(MpmStage, bcs)},
                            {"motions",
                             "motions that act; default: -mpm_motions; none",
                             {&scene->motions->count, &scene->motions->names, PETSC_TRUE},
                             scene->motions->count,
                             offsetof(MpmStage, motions)},
                            {"loads",
                             "loads that act; default: -mpm_loads; none",
                             {&scene->loads->count, &scene->loads->names, PETSC_TRUE},
                             scene->loads->count,
                             offsetof(MpmStage, loads)},
                            {"surfaces",
                             "surfaces of bodies on which something acts; default: -mpm_surfaces; none",
                             {&scene->surfaces->count, &scene->surfaces->names, PETSC_TRUE},
                             scene->surfaces->count,
                             offsetof(MpmStage, surfaces)}};
  PetscInt  *had;
  PetscBool *given;
  char       prefix[256];

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2((LISTS * scene->stages.count), &had, (LISTS * scene->stages.count), &given));
  for (PetscInt k = 0; k < scene->stages.count; k++) {
    const MpmOptions block = {options->comm, prefix, options->record};
    MpmStage        *stage = &scene->stages.at[k];

    if (stage->name) {
      PetscCall(PetscSNPrintf(prefix, sizeof(prefix), "mpm_stage_%s_", stage->name));
      PetscCall(MpmOptionsHeading(&block, "Stage"));
    }
    for (PetscInt l = 0; l < LISTS; l++) {
      if (stage->name)
        PetscCall(MpmStageMarkList(&block, list[l].name, list[l].help, list[l].all, Marks(stage, &list[l]),
                                   &given[LISTS * k + l]));
      had[LISTS * k + l] = *list[l].all.count;
    }
  }
  for (PetscInt k = 0; k < LISTS * scene->stages.count; k++)
    PetscCall(WidenMarks(had[k], *list[k % LISTS].all.count, list[k % LISTS].scene, given[k],
                         Marks(&scene->stages.at[k / LISTS], &list[k % LISTS])));
  PetscCall(PetscFree2(had, given));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStagesReadLists(MpmScene *scene, const MpmOptions *options)
{
  PetscInt  count;
  char    **names;
  PetscBool given;

  PetscFunctionBeginUser;
  PetscCall(MpmOptionsHas(options, "stages", &given));
  PetscCall(MpmOptionsBlocks(options, "stages", "names of the stages, in their order", MPM_OPTIONAL, &count, &names));
  MpmCheckInput(!given || count || MpmOptionsHelp(), "-mpm_stages: the list is empty; a scene without stages has none");
  scene->stages.count = PetscMax(count, 1);
  PetscCall(PetscCalloc1(scene->stages.count, &scene->stages.at));
  for (PetscInt k = 0; k < count; k++) PetscCall(PetscStrallocpy(names[k], &scene->stages.at[k].name));
  PetscCall(MpmNamesDestroy(count, &names));
  PetscCall(ReadActive(scene, options));
  PetscFunctionReturn(PETSC_SUCCESS);
}
