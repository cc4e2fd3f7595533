#pragma once
/*
  Forces in cuts and stresses along lines, in the history and in files of their own.
*/
#include "base/base.h"
#include "base/types.h"
#include "io/io.h"
#include "observe/profile.h"
#include "talus/talus.h"

/* Profiles with the names of their blocks, and the files: of the sections with a row of cuts, then of the profiles. */
typedef struct {
  PetscInt    profile_count;
  char      **profile_names;
  MpmProfile *profiles;
  PetscInt    file_count;
  MpmHistory *files;
} MpmLines;

/* Reads the sections and the profiles of a scene. */
PetscErrorCode MpmLinesRead(MpmModel model, const MpmOptions *options);
PetscErrorCode MpmLinesDestroy(MpmModel model);
/* How many fields of the particles they need at most, and their names, appended. */
PetscInt MpmLinesFieldCount(const MpmModel model);
void     MpmLinesAddFields(const MpmModel model, const char *fields[], PetscInt *count);
/* Finds their points, in the initial state. */
PetscErrorCode MpmLinesSelect(MpmModel model);
/* Columns of the history: forces in single cuts, means of profiles. */
PetscErrorCode MpmLinesAddColumns(MpmModel model, MpmColumns *columns);
/* The files: opened, or taken up again where a run goes on; the rows of the present state; where they stand. */
PetscErrorCode MpmLinesOpen(MpmModel model);
PetscErrorCode MpmLinesWrite(MpmModel model);
PetscErrorCode MpmLinesMark(MpmModel model, MpmTextFile *places);
