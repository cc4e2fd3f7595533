#pragma once
/*
  A lattice of voxels with labels, from a file, and the names that labels stand for (voxels.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "voxels/labels.h"

typedef struct MpmVoxels {
  PetscInt  dim, size[MPM_MAX_DIM];                 /* voxels, x fastest */
  PetscReal lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* of all of them, m */
  MpmLabels labels;
  PetscInt  count;
  int      *label; /* of each voxel; once read its place among the ranges */
} MpmVoxels;

/*
  MpmVoxelsRead - options `file`, `labels`, `lower`, `upper`, `size` of a block of region voxels

  Collective; rank 0 reads the file

  Fails with MPM_ERR_INPUT and one line where the file has another size, or a label that no name has.
*/
PetscErrorCode MpmVoxelsRead(const MpmOptions *options, PetscInt dim, MpmVoxels **voxels);
PetscErrorCode MpmVoxelsDestroy(MpmVoxels **voxels);
/* The voxel's range at a place within the lattice. */
const MpmLabelRange *MpmVoxelsAt(const MpmVoxels *voxels, const PetscReal x[]);
/* Labels of a file on this rank, and their numbers by axis (voxels_file.c); a fault goes into `message`. */
PetscErrorCode MpmVoxelsReadFile(const char path[], PetscInt dim, PetscInt size[], PetscInt *count, int **label,
                                 char message[512]);
