#pragma once
/*
  Bodies whose points come from a file.
*/
#include "base/base.h"
#include "base/types.h"
#include "geometry/geometry.h"

/* The points of a body that come from a file, this rank's. */
typedef struct _p_MpmImported *MpmImported;
struct MpmRowChoice; /* voxels/row_labels.h */
/* Fields of the physics that a file may have. */
typedef struct {
  const char *name; /* borrowed for as long as the points are */
  PetscInt    components;
} MpmFileField;
PetscErrorCode MpmImportedCreate(const MpmOptions *block, const MpmGrid *grid, const struct MpmRowChoice *choice,
                                 const MpmMaterial *materials, PetscInt field_count, const MpmFileField fields[],
                                 MpmImported *imported);
/* Of region columns, depth or hydrograph (handover/handover.h, handover/hydrograph.h). */
PetscErrorCode MpmImportedHandover(const MpmOptions *block, MpmRegionType region, const MpmGrid *grid,
                                   const MpmMaterial *material, MpmImported *imported);
/* NULL: the points come from a file as they are. */
const struct MpmHandover *MpmImportedGetHandover(MpmImported imported);
PetscErrorCode            MpmImportedDestroy(MpmImported *imported);
PetscInt                  MpmImportedCount(MpmImported imported);
/* Materials row by row, or NULL where all are the body's. */
const PetscInt *MpmImportedMaterial(MpmImported imported);
/* Row by row, or NULL where the file has none. */
const PetscReal *MpmImportedVelocity(MpmImported imported);
/* Values of one of the fields. */
const PetscReal *MpmImportedField(MpmImported imported, const char *name);
PetscBool        MpmImportedHasMass(MpmImported imported);
/* The file's name, and whether another run has written it. */
const char *MpmImportedPath(MpmImported imported, PetscBool *run);
/* Writes their positions from point `first` on. */
PetscErrorCode MpmImportedPlace(MpmImported imported, PetscInt dim, PetscInt first, MpmPoints *points);
/*
  Writes them from point `first` on, all but id and material, which are there. History that the file does not have is
  left as it stands, unless it follows from the stress.
*/
PetscErrorCode MpmImportedFill(MpmImported imported, const MpmGrid *grid, const MpmMaterial *materials,
                               PetscInt state_size, PetscInt first, MpmPoints *points);
