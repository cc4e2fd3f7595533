#pragma once
/*
  Stiffness of regions of the grid, on their cells and not at points (background.c).
*/
#include "base/base.h"
#include "base/types.h"
#include "assembly/terms.h"
#include "geometry/geometry.h"

extern const MpmTerm MpmTermBackground; /* ctx: MpmBackgrounds */

/* A background of the scene: a region as the grid was read, and Lame's constants, Pa. */
typedef struct {
  MpmRegion region;
  PetscReal lambda, mu;
} MpmBackground;

/* Displacement that a node of the lattice has had so far, m. */
typedef struct {
  PetscInt  node[MPM_MAX_DIM];
  PetscReal u[MPM_MAX_DIM];
} MpmNodeWay;

/* Cells of one background with the same stiffness matrix. */
struct MpmCellKind;

/* Cells of this rank: boxes of nodes among the groups of the space, and the kind of each. */
typedef struct {
  PetscInt begin, count, *kind;
} MpmBackgroundCells;

/* All backgrounds of a scene; cells and values are those of the step under way. */
typedef struct MpmBackgrounds {
  PetscInt            count;
  char              **names;
  MpmBackground      *at;
  PetscInt            way_count;
  MpmNodeWay         *way; /* on the nodes' owners after `prepare` */
  MpmBackgroundCells  cells;
  PetscInt            kind_count;
  struct MpmCellKind *kind;
  PetscReal          *u_n;   /* m, dim values a local node */
  PetscReal          *touch; /* of local nodes: 0 where no point touches them */
} MpmBackgrounds;

/* Cells of this rank in the region of a background, MPM_MAX_DIM indices each; before the first partition those of the
   grid. `cells` may be NULL. */
PetscErrorCode MpmBackgroundCellsList(const MpmBackground *background, const MpmGrid *grid, PetscInt *count,
                                      PetscInt cells[]);
PetscErrorCode MpmBackgroundKindsDestroy(MpmBackgrounds *backgrounds);
/* Reads -mpm_backgrounds and its blocks; NULL stays where there are none. Collective. */
PetscErrorCode MpmBackgroundsRead(const MpmOptions *options, const MpmGrid *grid, MpmBackgrounds **backgrounds);
PetscErrorCode MpmBackgroundsDestroy(MpmBackgrounds **backgrounds);
/* The nodes' displacements of all ranks as bytes on the first rank, for a checkpoint, and back. Collective. */
PetscErrorCode MpmBackgroundsSave(const MpmBackgrounds *backgrounds, MPI_Comm comm, MpmTextFile *bytes);
PetscErrorCode MpmBackgroundsLoad(MpmBackgrounds *backgrounds, MPI_Comm comm, const MpmTextFile *bytes);
