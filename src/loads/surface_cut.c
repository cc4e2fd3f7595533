/*
  Faces of bodies whose edge cuts the boxes of their points (`edge: cut`, particles/body_edge.c).

  A point stands for the parts of boxes at their centroid X. The pieces of the true surface in these boxes
  (edge_pieces.c), of the area A about the place Y, are faces of the point: of the area a = cof(F) A, with the weights

    w_i(y) + b . grad w_i(y) ,   b = F (Y - X)

  and the work of their load in a uniform strain is exact. A surface on one side has what faces there of the pieces
  within a box, as projected to that side, and sides of the box itself. Pieces bound the material where the lattice of
  points ends on a side that they face.
*/
#include "grid/grid.h"
#include "grid/shape.h"
#include "facets/outer_faces.h"
#include "particles/body.h"
#include "particles/points.h"
#include "space/point_shape.h"
#include "space/rules.h"
#include "space/space.h"
#include "loads/load.h"
#include "loads/surface_cut.h"

#define FACING 1e-3  /* of a piece's area, to a side that it faces */
#define LEAST  1e-12 /* a weight that is none */

PetscErrorCode MpmSurfaceCutPoint(const MpmBodySurface *surface, MpmEdgePieces *pieces, const MpmGrid *grid,
                                  const MpmPoints *points, PetscInt p, PetscInt *outer, const MpmEdgePoint **cut)
{
  const MpmEdgeAsked asked     = {surface->cut, surface->body, surface->region, surface->held};
  PetscInt           divisions = 0;

  PetscFunctionBeginUser;
  *cut = NULL;
  for (PetscInt a = 0; a < grid->dim && surface->cut; a++) divisions += MpmPointDivisions(points, p, a);
  if (!surface->cut || divisions) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmEdgePiecesGet(pieces, &asked, grid, points, p, cut));
  if (!(*cut)->whole) PetscFunctionReturn(PETSC_SUCCESS);
  *outer &= ~(*cut)->given;
  *cut = NULL;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSurfaceCutPresent(MpmSurfaceFaces *faces, const MpmPoints *points, MPI_Comm comm)
{
  const MpmBodies *bodies = NULL;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < faces->surfaces->count; k++)
    if (faces->surfaces->at[k].cut && faces->acting[k].active) bodies = faces->surfaces->at[k].cut;
  if (!bodies || bodies->count < 2) PetscFunctionReturn(PETSC_SUCCESS);
  if (!faces->drawn.present) PetscCall(PetscMalloc1(bodies->count, &faces->drawn.present));
  for (PetscInt b = 0; b < bodies->count; b++) {
    PetscInt first, end;

    MpmBodyGetIds(bodies->at[b], &first, &end);
    faces->drawn.present[b] = PETSC_FALSE;
    for (PetscInt p = 0; p < points->count && !faces->drawn.present[b]; p++)
      faces->drawn.present[b] = (PetscBool)(points->id[p] >= first && points->id[p] < end);
  }
  PetscCall(
    MPIU_Allreduce(MPI_IN_PLACE, faces->drawn.present, (PetscMPIInt)bodies->count, MPM_MPI_BOOL, MPI_LOR, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where another body of the same part stands behind a piece. */
static PetscBool IsCovered(const MpmSurfaceFaces *faces, const MpmBodySurface *surface, const MpmEdgePiece *piece)
{
  return (PetscBool)(piece->behind >= 0 && faces->drawn.present[piece->behind] &&
                     (!surface->cut->part || surface->cut->part[piece->behind] == surface->cut->part[surface->body]));
}

PetscBool MpmSurfacePieceArea(const MpmBodySurface *surface, const MpmEdgePiece *piece, PetscInt dim, PetscInt outer,
                              PetscReal area[])
{
  const PetscInt  all = (1 << (2 * dim)) - 1, bounds = outer & surface->faces;
  PetscReal       sum = 0., square = 0.;
  const PetscBool bent = (PetscBool)(surface->loaded && surface->normal == 0.);

  for (PetscInt a = 0; a < dim; a++) area[a] = 0.;
  if (piece->inner || (piece->side >= 0 && !(bounds & (1 << piece->side)))) return PETSC_FALSE;
  for (PetscInt f = 0; f < 2 * dim; f++)
    if (bounds & (1 << f)) sum += piece->onto[f];
  if (!(sum > FACING * piece->size)) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++) {
    if (surface->faces == all) area[a] = piece->area[a];
    else
      for (PetscInt side = 0; side < 2; side++)
        if (surface->faces & MpmFaceBit(a, side)) area[a] += (side ? 1. : -1.) * piece->onto[2 * a + side];
    square += PetscSqr(area[a]);
  }
  for (PetscInt a = 0; a < dim && bent && surface->faces == all && square > 0.; a++)
    area[a] *= piece->size / PetscSqrtReal(square);
  return (PetscBool)(square > 0.);
}

/* Where a place that was drawn beside a point is. */
static void PlaceOf(const MpmPoints *points, PetscInt dim, PetscInt p, const PetscReal drawn[], PetscReal place[])
{
  const PetscReal *F = MpmPointF(points, p);

  for (PetscInt a = 0; a < dim; a++) {
    place[a] = points->x[p * dim + a];
    for (PetscInt b = 0; b < dim; b++) place[a] += F[a * dim + b] * (drawn[b] - points->origin[p * dim + b]);
  }
}

/* cof(F) A */
static void AreaOf(const MpmPoints *points, PetscInt dim, PetscInt p, const PetscReal drawn[], PetscReal area[])
{
  const PetscReal half[MPM_MAX_DIM] = {0.5, 0.5, 0.5};

  for (PetscInt a = 0; a < dim; a++) area[a] = 0.;
  for (PetscInt axis = 0; axis < dim; axis++) {
    PetscReal arm[MPM_MAX_DIM], one[MPM_MAX_DIM] = {0., 0., 0.};

    MpmOuterFace(dim, MpmPointF(points, p), half, axis, 1, arm, one);
    for (PetscInt a = 0; a < dim; a++) area[a] += drawn[axis] * one[a];
  }
}

PetscBool MpmSurfaceCutFace(const MpmSurfaceFaces *faces, const MpmEdgePiece *piece, const MpmPoints *points,
                            PetscInt dim, PetscInt outer, MpmSurfaceFace *face)
{
  const MpmBodySurface *surface = &faces->surfaces->at[face->surface];
  PetscReal             drawn[MPM_MAX_DIM];

  if (IsCovered(faces, surface, piece) || !MpmSurfacePieceArea(surface, piece, dim, outer, drawn)) return PETSC_FALSE;
  PlaceOf(points, dim, face->point, piece->place, face->place);
  AreaOf(points, dim, face->point, drawn, face->area);
  return PETSC_TRUE;
}

void MpmSurfaceCutWeights(const MpmFaceSpace *at, const MpmSurfaceFace *face, PetscReal weight[])
{
  const PetscInt  dim               = at->space->dim;
  const MpmGroup *group             = &at->space->groups[face->group];
  PetscReal       away[MPM_MAX_DIM] = {0., 0., 0.};

  MpmSpaceEvaluate(at->space, group, face->point, at->basis);
  for (PetscInt a = 0; a < dim; a++) away[a] = face->place[a] - at->points->x[face->point * dim + a];
  for (PetscInt i = 0; i < group->node_count; i++)
    weight[i] = MpmBasisWeights(at->basis)[i] + MpmBasisSlope(at->basis, dim, i, away);
}

/* ---- sides with material beyond ---- */

/* Weights of a side's part at the group's nodes, as those of a domain that has it as its face: of its place across and
   its mean along; PETSC_FALSE where other nodes have one, too. */
static PetscBool SideWeights(const MpmFaceSpace *where, const MpmEdgePiece *piece, const MpmSurfaceFace *face,
                             const PetscReal place[], PetscReal weight[])
{
  const MpmRules  *rules  = where->rules;
  const MpmPoints *points = where->points;
  const MpmSpace  *space  = where->space;
  const MpmGrid   *grid   = rules->grid;
  const MpmGroup  *group  = &space->groups[face->group];
  const PetscInt   dim = space->dim, p                                 = face->point;
  PetscReal        line[MPM_MAX_DIM][MPM_MAX_WIDTH], half[MPM_MAX_DIM] = {0., 0., 0.}, full = 1.;
  PetscInt         lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  if (MpmShapeHasDomain(rules->shape) && !MpmSpaceHalfLengths(rules, points, p, half)) return PETSC_FALSE;
  for (PetscInt a = 0; a < dim; a++)
    if (a != piece->side / 2) full *= 2. * points->domain.drawn[p * dim + a];
  MpmSpaceEdges(rules, &points->x[p * dim], lower, upper);
  for (PetscInt a = 0; a < dim; a++) {
    const PetscInt  shift = a == dim - 1 ? MpmSpaceShift(space, points->domain.part, p) : 0;
    const PetscReal xi    = (place[a] - grid->lower[a]) / grid->h[a];
    const PetscReal part  = PetscPowReal(piece->size / full, 1. / (PetscReal)(dim - 1));
    PetscReal       there[MPM_MAX_WIDTH], unused[MPM_MAX_WIDTH];
    MpmShapeLine    at = {.weight = there, .gradient = unused};

    if (xi < (PetscReal)lower[a] || xi > (PetscReal)upper[a]) return PETSC_FALSE;
    MpmShapeEvaluate(rules->shape, rules->edge, xi, a == piece->side / 2 ? 0. : part * half[a], lower[a], upper[a],
                     &at);
    for (PetscInt i = 0; i < group->count[a]; i++) line[a][i] = 0.;
    for (PetscInt i = 0; i < at.count; i++) {
      const PetscInt k = at.first + shift + i - group->first[a];

      if (k >= 0 && k < group->count[a]) line[a][k] = there[i];
      else if (PetscAbsReal(there[i]) > LEAST) return PETSC_FALSE;
    }
  }
  MpmLinesMultiply(dim, group, line, weight);
  return PETSC_TRUE;
}

PetscBool MpmSurfaceCutInner(const MpmFaceSpace *at, const MpmEdgePieces *pieces, const MpmEdgePoint *cut,
                             PetscReal loaded, const MpmSurfaceFace *face, PetscReal area[])
{
  const MpmPoints *points = at->points;
  const PetscInt   dim = at->space->dim, p = face->point, nodes = at->space->groups[face->group].node_count;
  PetscReal       *weight = &area[nodes * dim];
  PetscBool        any    = PETSC_FALSE;

  for (PetscInt i = 0; i < nodes * dim; i++) area[i] = 0.;
  for (PetscInt k = cut->first; k < cut->first + cut->count && loaded > 0.; k++) {
    const MpmEdgePiece *piece  = &pieces->at[k];
    PetscReal own[MPM_MAX_DIM] = {0., 0., 0.}, place[MPM_MAX_DIM] = {0., 0., 0.}, away[MPM_MAX_DIM] = {0., 0., 0.};

    if (!piece->inner) continue;
    PlaceOf(points, dim, p, piece->place, place);
    AreaOf(points, dim, p, piece->area, own);
    for (PetscInt a = 0; a < dim; a++) away[a] = place[a] - points->x[p * dim + a];
    if (!SideWeights(at, piece, face, place, weight)) continue;
    any = PETSC_TRUE;
    for (PetscInt i = 0; i < nodes; i++) {
      const PetscReal more = MpmBasisAt(at->basis, 0, i) + MpmBasisSlope(at->basis, dim, i, away) - weight[i];

      for (PetscInt a = 0; a < dim; a++)
        area[i * dim + a] += loaded / cut->size * more * MpmTurn(points->F_size, place[0]) * own[a];
    }
  }
  return any;
}
