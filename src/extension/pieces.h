#pragma once
/*
  The spline's pieces that material touches, and how far each is filled.
*/
#include "base/base.h"
#include "base/types.h"

/* Fill of a piece that material fills, in the units of MpmPieces: integers, whose sums are equal in any order. */
#define MPM_PIECE_FULL (1 << 26)

/*
  Degree of the polynomials in a piece, and nodes a piece on an axis (MpmShapeOrder()).
*/
typedef struct {
  PetscInt degree, order;
} MpmKnots;

/*
  Pieces between knots on the lattice: the grid's cells, or the cells around nodes for splines of even degree. A part
  of the material has pieces of its own (space.h).
*/
typedef struct {
  MpmKnots knots;
  PetscInt dim, lower[MPM_MAX_DIM], size[MPM_MAX_DIM];
  PetscInt
       *fill;  /* volume of the points' domains within the piece over the piece's, in MPM_PIECE_FULL; 0: not touched */
  char *touch; /* 0: no point does; 1: not all of its nodes; 2: a point touches all of them */
} MpmPieces;

/*
  MpmPiecesCreate - fill of the pieces around this rank's points and nodes, points of all ranks included

  Collective

  Input Parameters:
+ space  - after MpmSpaceBegin(), with the boxes of all terms
. rules  - shape, walls and grid
. points - of this rank
- margin - pieces beyond this rank's nodes that are needed

  Notes:
  The domain of a point of a shape that has none is a cube. A piece of which no point touches all nodes gets no fill.
*/
PetscErrorCode MpmPiecesCreate(const MpmSpace *space, const MpmRules *rules, const MpmPoints *points, PetscInt margin,
                               MpmPieces *pieces);
PetscErrorCode MpmPiecesDestroy(MpmPieces *pieces);

static inline PetscInt MpmPiecesIndex(const MpmPieces *pieces, const PetscInt piece[])
{
  PetscInt i = 0;

  for (PetscInt a = pieces->dim - 1; a >= 0; a--) {
    const PetscInt k = piece[a] - pieces->lower[a];

    if (k < 0 || k >= pieces->size[a]) return -1;
    i = i * pieces->size[a] + k;
  }
  return i;
}
static inline PetscInt MpmPiecesFill(const MpmPieces *pieces, const PetscInt piece[])
{
  const PetscInt i = MpmPiecesIndex(pieces, piece);

  return i < 0 ? 0 : pieces->fill[i];
}
static inline void MpmPiecesAt(const MpmPieces *pieces, PetscInt index, PetscInt piece[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; index /= pieces->size[a], a++)
    piece[a] = pieces->lower[a] + index % pieces->size[a];
}

/* True where knots lie between the vertices. */
static inline PetscBool MpmKnotsBetween(MpmKnots knots)
{
  return (PetscBool)(knots.order == 1 && knots.degree % 2 == 0);
}
/* The first of the p + 1 nodes of a piece along an axis; and the piece above the last knot that is not above a node. */
static inline PetscInt MpmPieceFirstNode(MpmKnots knots, PetscInt piece)
{
  return knots.order > 1 ? piece * knots.order : piece - knots.degree / 2;
}
static inline PetscInt MpmPieceOfNode(MpmKnots knots, PetscInt node)
{
  return knots.order > 1 ? node / knots.order : node;
}
/* Edges about the middle of a piece, in the lattice of its part: vertices. */
void MpmPieceEdges(const MpmSpace *space, const MpmRules *rules, MpmKnots knots, const PetscInt piece[],
                   PetscInt lower[], PetscInt upper[]);

/* Runs over a box on the lattice, the first axis fastest. */
#define MPM_FOR_BOX(lower, count, at) \
  for (at[2] = (lower)[2]; at[2] < (lower)[2] + (count)[2]; at[2]++) \
    for (at[1] = (lower)[1]; at[1] < (lower)[1] + (count)[1]; at[1]++) \
      for (at[0] = (lower)[0]; at[0] < (lower)[0] + (count)[0]; at[0]++)

/* The nodes of a piece along one axis; coefficients of those beyond an edge are combinations of the others. */
typedef struct {
  PetscInt    first;        /* of the degree + 1 nodes of the polynomial */
  PetscInt    low, high;    /* those that exist */
  PetscInt    lower, upper; /* edges, nodes */
  MpmEdgeType edge;
} MpmPieceLine;
#define MPM_PIECE_NODES 8 /* of a piece on an axis, degree 3 with an open edge included */
/* Where a node stands in the piece of its index, cells from the piece's lower face; 0 but for elements. */
PetscReal MpmPiecePlace(MpmKnots knots, PetscInt node);
/* The weights along one axis of the piece's nodes at a node's index there: that node's own where the piece has it. */
void MpmPieceWeights(const MpmPieceLine *line, MpmKnots knots, PetscInt node, PetscReal weight[]);
/* The lines of all axes; PETSC_FALSE where there is no room for the piece between the edges. */
PetscBool MpmPieceLines(const MpmSpace *space, const MpmRules *rules, const MpmPieces *pieces, const PetscInt piece[],
                        MpmPieceLine lines[]);
