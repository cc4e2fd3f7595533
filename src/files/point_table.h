#pragma once
/*
  A file of points, HDF5 or CSV, of which each rank has `count` rows. Get gives a quantity's components, row by row, to
  be freed; NULL where the file has none and the need is optional. All collective.
*/
#include "options/options.h"

typedef struct _p_MpmPointFile *MpmPointFile;
PetscErrorCode MpmPointFileOpen(const MpmOptions *block, PetscInt dim, const char *path, const char *step,
                                MpmPointFile *file);
PetscErrorCode MpmPointFileClose(MpmPointFile *file);
PetscInt       MpmPointFileCount(MpmPointFile file);
PetscErrorCode MpmPointFileGet(MpmPointFile file, const char *quantity, PetscInt components, MpmNeed need,
                               PetscReal **values);
/*
  The column `material`, row by row, to be freed; NULL where the file has none. In a table its cells are words: values
  are places among the `count` words, which all ranks have, lent until the file closes. In HDF5 they are numbers, and
  `count` is 0.
*/
PetscErrorCode MpmPointFileGetMaterial(MpmPointFile file, PetscInt *count, char ***word, PetscReal **values);
/* True for a file of a run, with a group /points. */
PetscBool MpmPointFileIsRun(MpmPointFile file);
/*
  After all Gets: refuses an unused column, or an unused dataset of a file that is no run's, with the nearest name.
  Fields that a run writes and no point starts with (id, material, displacement, position0) are allowed.
*/
PetscErrorCode MpmPointFileCheck(MpmPointFile file);
