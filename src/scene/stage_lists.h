#pragma once
/*
  The lists of names that stages have.
*/
#include "base/base.h"
#include "base/types.h"
#include "query/scene.h"

/* Names of all blocks of one kind; with `grows` others join them. */
typedef struct {
  PetscInt *count;
  char   ***names;
  PetscBool grows;
} MpmNameList;

/* The place of a name in a list, or -1. */
PetscInt MpmStageFindName(PetscInt count, char *const names[], const char *name);
/*
  The model's names in a stage's list, as marks to be freed; new names join where the model's list grows. `given` is
  false where the stage has no such list. The word `none` is an empty list.
*/
PetscErrorCode MpmStageMarkList(const MpmOptions *block, const char *list, const char *help, MpmNameList all,
                                PetscBool **marks, PetscBool *given);
/* The names of the stages, and the conditions, motions, loads and surfaces that only they name. */
PetscErrorCode MpmStagesReadLists(MpmScene *scene, const MpmOptions *options);
