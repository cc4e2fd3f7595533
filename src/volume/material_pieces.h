#pragma once
/*
  Pieces of the spline that hold material, with the stiffest material of each and a flag for sparse points: the ghost
  penalty acts between them.
*/
#include "base/base.h"
#include "base/types.h"
#include "extension/pieces.h"

/* Smallest spacing of a material's points, in cells, at which stretch may make them sparse. */
#define MPM_SPARSE_LEAST 0.3

/*
  Marks of the pieces around this rank's nodes, 0: no material. Layers across the last axis, which separates the bodies'
  parts, are empty until a piece in them is marked.
*/
typedef struct {
  const MpmSpace *space;
  MpmKnots        knots;
  PetscInt        dim, lower[MPM_MAX_DIM], size[MPM_MAX_DIM];
  PetscInt       *mark;
  PetscBool      *used; /* layers; marks of others are not set */
} MpmMaterialPieces;

/*
  MpmMaterialPiecesCreate - marks of the pieces that points of any rank may touch

  Collective

  Input Parameters:
+ space  - after MpmSpaceBegin()
. rules  - shape, walls, grid and materials
- points - of this rank

  Output Parameter:
. map - this rank's own pieces and those within two of them
*/
PetscErrorCode MpmMaterialPiecesCreate(const MpmSpace *space, const MpmRules *rules, const MpmPoints *points,
                                       MpmMaterialPieces *map);
PetscErrorCode MpmMaterialPiecesDestroy(MpmMaterialPieces *map);
/* Writes the places of this rank's own material pieces into `pieces`, of the map's size, and returns their number. */
PetscInt MpmMaterialPiecesOwned(const MpmMaterialPieces *map, const MpmGrid *grid, PetscInt pieces[]);
/* The piece at a place in the map. */
void MpmMaterialPieceAt(const MpmMaterialPieces *map, PetscInt place, PetscInt piece[]);
/* The mark of a piece; 0 outside of the map. */
PetscInt MpmMaterialPieceMark(const MpmMaterialPieces *map, const PetscInt piece[]);
/* True where a neighbour within the grid and the walls holds no material. */
PetscBool MpmMaterialPieceIsEdge(const MpmMaterialPieces *map, const MpmRules *rules, const PetscInt piece[]);

/* A mark is 1 + 2 times the stiffest material, one more where points are sparse. */
static inline PetscInt MpmMarkMaterial(PetscInt mark)
{
  return (mark - 1) / 2;
}
static inline PetscBool MpmMarkIsSparse(PetscInt mark)
{
  return (PetscBool)((mark - 1) % 2);
}
