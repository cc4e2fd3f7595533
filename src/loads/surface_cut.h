#pragma once
/*
  Faces of points at cut edges (surface_cut.c).
*/
#include "loads/body_surface.h"
#include "space/basis.h"

/* Finds which bodies have points, for the two below. Collective. */
PetscErrorCode MpmSurfaceCutPresent(MpmSurfaceFaces *faces, const MpmPoints *points, MPI_Comm comm);
/* The pieces of the true surface that a point at a cut edge has; NULL where its faces are those of its domain, without
   those of `outer` beyond which others stand for the material (surface_cut.c). */
PetscErrorCode MpmSurfaceCutPoint(const MpmBodySurface *surface, MpmEdgePieces *pieces, const MpmGrid *grid,
                                  const MpmPoints *points, PetscInt p, PetscInt *outer, const MpmEdgePoint **cut);
/* The area that the surface has of a piece, as drawn; PETSC_FALSE where it has none. */
PetscBool MpmSurfacePieceArea(const MpmBodySurface *surface, const MpmEdgePiece *piece, PetscInt dim, PetscInt outer,
                              PetscReal area[]);
/* Sets place and area of the face of a piece, without axial symmetry; PETSC_FALSE where it is none of the surface's.
   `outer`: bits of the point's faces that bound the material. */
PetscBool MpmSurfaceCutFace(const MpmSurfaceFaces *faces, const MpmEdgePiece *piece, const MpmPoints *points,
                            PetscInt dim, PetscInt outer, MpmSurfaceFace *face);
/* Where faces are: the step's points and their space, and room for the functions of one. */
typedef struct {
  const MpmRules  *rules;
  const MpmSpace  *space;
  const MpmPoints *points;
  MpmBasis        *basis;
} MpmFaceSpace;
/* The face's weights at the nodes of its group. */
void MpmSurfaceCutWeights(const MpmFaceSpace *at, const MpmSurfaceFace *face, PetscReal weight[]);
/* Areas at the nodes of the group, dim a node, that bear the face's stress too, for `loaded` of the point's surface,
   behind the weights; PETSC_FALSE where there are none. There is room for a number a node behind them. */
PetscBool MpmSurfaceCutInner(const MpmFaceSpace *at, const MpmEdgePieces *pieces, const MpmEdgePoint *cut,
                             PetscReal loaded, const MpmSurfaceFace *face, PetscReal area[]);
