#pragma once
/*
  Bodies whose points come from a file.
*/
#include "base/base.h"
#include "base/types.h"

/* The points of a body that come from a file, this rank's. */
typedef struct _p_MpmImported *MpmImported;
PetscErrorCode MpmImportedCreate(const MpmOptions *block, const MpmGrid *grid, const MpmMaterial *material,
                                 MpmImported *imported);
PetscErrorCode MpmImportedDestroy(MpmImported *imported);
PetscInt       MpmImportedCount(MpmImported imported);
/* Writes them from point `first` on, all but id and material. */
PetscErrorCode MpmImportedFill(MpmImported imported, const MpmGrid *grid, const MpmMaterial *material,
                               PetscInt state_size, PetscInt first, MpmPoints *points);
