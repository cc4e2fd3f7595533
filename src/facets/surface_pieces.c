/*
  Pieces of a boundary's surface (surface_shares.c) along which material slides, spread over the nodes of the grid.

  A patch is one node I here: of a piece of area A_q at y_q it has A_q N_I(y_q), N_I the linear functions on the grid.
  Gaps, slips and tractions are continuous along the surface then, and stay so as pieces move from cell to cell. A
  sliver that is alone in its cell would otherwise have a pressure of its own, five times its neighbours', and lose it
  when it leaves.

  Where a cell has three points an axis or more, the surface touches, not the point's domain: its displacement is the
  grid's at y_q, no further out than the nodes that the point touches. With fewer points these nodes have too little
  material: a smooth pipe lost 14 % of its resistance. Points away from it or behind it return by a fraction of that
  distance in each step, as the surface moves. Without that, those before a body keep their first distance, and the body
  seems larger than it is.

  Pieces of neighbouring ranks take part in the means of a node, and only their own ranks add their forces.
*/
#include "geometry/geometry.h"
#include "point/material.h"
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/particles.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/terms.h"
#include "facets/facets.h"

#define FINE   0.4 /* of a cell: domains no longer than this leave it to the surface to touch */
#define AROUND 4   /* cells about a piece's place, in which ranks learn of it */
#define BACK   2.5 /* of the way back, for a movement of the surface by a cell, */
#define MOST   0.5 /* and no more in a step */

PetscBool MpmFacetsAreSpread(const MpmFacets *facets, PetscInt boundary)
{
  return (PetscBool)(facets->drawn[boundary] && !facets->boundaries[boundary].stick &&
                     !MpmFacetsBody(facets, boundary));
}

/* ---- pieces ---- */

/* Weights on one axis, of shapes with a domain: the linear ones at the surface, at the nodes of the point's group. */
static void SurfaceLine(const MpmRules *rules, const MpmFacet *facet, PetscInt a, PetscInt shift, MpmPiece *piece)
{
  const PetscInt  last  = piece->count[a] - 1;
  const PetscReal at    = (facet->place[a] - rules->grid->lower[a]) / rules->grid->h[a];
  const PetscReal along = PetscMin(PetscMax(at - (PetscReal)(piece->first[a] - shift), 0.), (PetscReal)last);
  const PetscInt  k     = PetscMin((PetscInt)along, PetscMax(last - 1, 0));

  for (PetscInt i = 0; i <= last; i++) piece->line[a][i] = 0.;
  piece->line[a][k] = 1. - (along - (PetscReal)k);
  if (k < last) piece->line[a][k + 1] = along - (PetscReal)k;
}

/* How far a point is from where it should be beside the surface: within its half-length of it, and not behind. */
static PetscReal Astray(const MpmFacets *facets, const MpmPoints *points, const MpmFacet *facet)
{
  const PetscInt dim = facets->boundaries[facet->boundary].dim, p = facet->point;
  PetscReal      half = 0.;
  MpmSurface     surface;

  MpmFacetsDistance(facets, facet->boundary, &points->x[p * dim], &surface);
  for (PetscInt a = 0; a < dim; a++) half += PetscAbsReal(surface.normal[a]) * MpmPointHalfWhole(points, dim, p, a);
  return surface.distance > half ? surface.distance - half : PetscMin(surface.distance, 0.);
}

/* The part of it that comes back in this step. */
static PetscReal Back(const MpmFacets *facets, const MpmFacet *facet)
{
  const MpmPose *before = &facets->before[facet->boundary], *after = &facets->after[facet->boundary];
  const PetscInt dim = facets->boundaries[facet->boundary].dim;
  PetscReal      y[MPM_MAX_DIM], way = 0.;

  MpmPoseCarry(dim, before, after, facet->place, y);
  for (PetscInt a = 0; a < dim; a++) way += PetscSqr(y[a] - facet->place[a]);
  way = PetscSqrtReal(way) + PetscAbsReal(after->growth - before->growth);
  return PetscMin(MOST, BACK * way / facets->cell);
}

static PetscErrorCode MakePiece(const MpmFacets *facets, const MpmRules *rules, const MpmSpace *space,
                                const MpmPoints *points, const MpmFacet *facet, MpmPiece *piece)
{
  const MpmGroup *group = &space->groups[facet->group];
  const PetscInt  dim = space->dim, p = facet->point;
  PetscBool       fine = PETSC_TRUE;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(piece, sizeof(*piece)));
  piece->boundary = facet->boundary;
  piece->point    = p;
  piece->part     = points->domain.part ? points->domain.part[p] : 0;
  piece->material = points->material[p];
  piece->modulus =
    MpmMaterialPenalty(&rules->materials[piece->material], MpmPointOwn(points, &rules->materials[piece->material], p));
  piece->area = facet->area;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    piece->first[a] = group->first[a];
    piece->count[a] = group->count[a];
  }
  for (PetscInt a = 0; a < dim; a++) {
    piece->place[a]  = facet->place[a];
    piece->normal[a] = facet->normal[a];
  }
  if (!MpmShapeHasDomain(rules->shape)) {
    MpmFacetLines(rules, space, points, facet, piece->line);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  for (PetscInt a = 0; a < dim; a++)
    fine = (PetscBool)(fine && 2. * MpmPointHalfWhole(points, dim, p, a) <= FINE * rules->grid->h[a]);
  if (!fine) MpmFacetLines(rules, space, points, facet, piece->line);
  for (PetscInt a = 0; fine && a < dim; a++)
    SurfaceLine(rules, facet, a, a == dim - 1 ? MpmSpaceShift(space, points->domain.part, p) : 0, piece);
  piece->astray = Astray(facets, points, facet);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The facets that are to be spread become this rank's pieces; others stay. */
static PetscErrorCode TakeFacets(MpmFacets *facets, const MpmRules *rules, const MpmSpace *space,
                                 const MpmPoints *points)
{
  PetscInt kept = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscRealloc((size_t)(facets->count + 1) * sizeof(MpmPiece), &facets->pieces.at));
  for (PetscInt f = 0; f < facets->count; f++) {
    const MpmFacet facet = facets->at[f];

    if (MpmFacetsAreSpread(facets, facet.boundary))
      PetscCall(MakePiece(facets, rules, space, points, &facet, &facets->pieces.at[facets->pieces.count++]));
    else facets->at[kept++] = facet;
  }
  facets->count      = kept;
  facets->pieces.own = facets->pieces.count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The neighbours' pieces behind the own ones, as they are there now. Collective. */
static PetscErrorCode ShareWithNeighbours(MpmFacets *facets, const MpmGrid *grid)
{
  PetscInt *boxes, cell[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  facets->pieces.count = facets->pieces.own;
  PetscCall(PetscCalloc1((2 * MPM_MAX_DIM * facets->pieces.own), &boxes));
  for (PetscInt k = 0; k < facets->pieces.own; k++) {
    PetscInt *box = &boxes[2 * MPM_MAX_DIM * k];

    MpmGridFindCell(grid, facets->pieces.at[k].place, cell);
    for (PetscInt a = 0; a < grid->dim; a++) {
      box[a]               = PetscMax(cell[a] - AROUND, 0);
      box[MPM_MAX_DIM + a] = PetscMin(cell[a] + 1 + AROUND, grid->cells[a]);
    }
  }
  PetscCall(MpmGridShare(grid, sizeof(MpmPiece), boxes, &facets->pieces.count, (void **)&facets->pieces.at));
  for (PetscInt k = facets->pieces.own; k < facets->pieces.count; k++) facets->pieces.at[k].point = -1;
  PetscCall(PetscFree(boxes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- nodes ---- */

typedef struct {
  PetscInt   boundary;
  PetscInt64 number;
} Place;

static int ComparePlaces(const void *a, const void *b)
{
  const Place *p = (const Place *)a, *q = (const Place *)b;

  if (p->boundary != q->boundary) return p->boundary < q->boundary ? -1 : 1;
  return p->number < q->number ? -1 : p->number > q->number;
}

/* Corner k of the cell in which a piece's place lies: its node's number, and its function there. */
static PetscReal Corner(const MpmGrid *grid, const MpmPiece *piece, PetscInt k, Place *node)
{
  PetscInt  cell[MPM_MAX_DIM];
  PetscReal value = 1.;

  MpmGridFindCell(grid, piece->place, cell);
  *node = (Place){.boundary = piece->boundary, .number = piece->part};
  for (PetscInt a = grid->dim - 1; a >= 0; a--) {
    const PetscInt  upper = k >> a & 1;
    const PetscReal along = (piece->place[a] - grid->lower[a]) / grid->h[a] - (PetscReal)cell[a];

    node->number = node->number * (grid->cells[a] + 1) + cell[a] + upper;
    value *= upper ? along : 1. - along;
  }
  return value;
}

/* Facets of a piece, one a node, with its portion of the area. Neighbours' pieces only at nodes of own ones. */
static PetscErrorCode SpreadPiece(MpmFacets *facets, const MpmGrid *grid, PetscInt k, PetscInt count, Place own[])
{
  const MpmPiece *piece = &facets->pieces.at[k];

  PetscFunctionBeginUser;
  for (PetscInt c = 0; c < PetscPowInt(2, grid->dim); c++) {
    MpmFacet facet = {.boundary = piece->boundary, .point = piece->point, .piece = k + 1};
    Place    node;

    facet.portion  = Corner(grid, piece, c, &node);
    facet.key.cell = node.number;
    facet.area     = facet.portion * piece->area;
    if (!(facet.area > 0.)) continue;
    if (piece->point < 0 && !bsearch(&node, own, (size_t)count, sizeof(node), ComparePlaces)) continue;
    for (PetscInt a = 0; a < grid->dim; a++) {
      facet.place[a]  = piece->place[a];
      facet.normal[a] = piece->normal[a];
    }
    PetscCall(MpmFacetsAdd(facets, &facet));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPiecesSpread(MpmFacets *facets, const MpmRules *rules, const MpmPoints *points, const MpmSpace *space)
{
  const PetscInt corners = PetscPowInt(2, space->dim);
  PetscBool      any     = PETSC_FALSE;
  Place         *own;

  PetscFunctionBeginUser;
  facets->pieces.count = facets->pieces.own = 0;
  for (PetscInt b = 0; b < facets->boundary_count; b++) any = (PetscBool)(any || MpmFacetsAreSpread(facets, b));
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(TakeFacets(facets, rules, space, points));
  PetscCall(ShareWithNeighbours(facets, rules->grid));
  PetscCall(PetscMalloc1((facets->pieces.own * corners), &own));
  for (PetscInt k = 0; k < facets->pieces.own * corners; k++)
    (void)Corner(rules->grid, &facets->pieces.at[k / corners], k % corners, &own[k]);
  qsort(own, (size_t)(facets->pieces.own * corners), sizeof(Place), ComparePlaces);
  for (PetscInt k = 0; k < facets->pieces.count; k++)
    PetscCall(SpreadPiece(facets, rules->grid, k, facets->pieces.own * corners, own));
  PetscCall(PetscFree(own));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static MpmGroup BoxOf(const MpmPiece *piece)
{
  MpmGroup box = {.node_count = 1};

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    box.first[a] = piece->first[a];
    box.count[a] = piece->count[a];
    box.node_count *= piece->count[a];
  }
  return box;
}

MpmGroup MpmFacetBox(const MpmFacets *facets, const MpmSpace *space, const MpmFacet *facet)
{
  return facet->piece ? BoxOf(&facets->pieces.at[facet->piece - 1]) : space->groups[facet->group];
}

PetscErrorCode MpmPiecesAppendBoxes(const MpmFacets *facets, MpmSpace *space)
{
  MpmGroup *boxes;

  PetscFunctionBeginUser;
  if (facets->pieces.count == facets->pieces.own) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmSpaceAppendBoxes(space, facets->pieces.count - facets->pieces.own, &boxes));
  for (PetscInt k = facets->pieces.own; k < facets->pieces.count; k++)
    boxes[k - facets->pieces.own] = BoxOf(&facets->pieces.at[k]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- kept values of the points ---- */

/* Of the own pieces, component `slot` of the kept values. */
static PetscErrorCode LoadField(MpmFacets *facets, PetscInt b, const char *field, MpmPieceSlot slot,
                                MpmParticles *particles)
{
  PetscReal *kept;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetField(particles, field, &kept));
  for (PetscInt k = 0; k < facets->pieces.own; k++)
    if (facets->pieces.at[k].boundary == b) facets->pieces.at[k].kept[slot] = kept[facets->pieces.at[k].point];
  PetscCall(MpmParticlesRestoreField(particles, &kept));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPiecesLoad(MpmFacets *facets, const MpmTermStep *step)
{
  const MpmSum *sum = step->sum;
  PetscBool     any = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < facets->boundary_count; b++) {
    const MpmBoundary *boundary = &facets->boundaries[b];

    if (!MpmFacetsAreSpread(facets, b)) continue;
    any = PETSC_TRUE;
    PetscCall(LoadField(facets, b, boundary->fields.gap, MPM_PIECE_GAP, step->particles));
    for (PetscInt a = 0; boundary->tangential && a < sum->space->dim; a++)
      PetscCall(LoadField(facets, b, boundary->fields.slip[a], (MpmPieceSlot)(MPM_PIECE_SLIP + a), step->particles));
    if (boundary->augmented)
      PetscCall(LoadField(facets, b, boundary->fields.pressure, MPM_PIECE_PRESSURE, step->particles));
  }
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < facets->pieces.own; k++) {
    const PetscInt     p        = facets->pieces.at[k].point;
    const MpmMaterial *material = &sum->materials[sum->points->material[p]];

    facets->pieces.at[k].kept[MPM_PIECE_STRENGTH] = MpmMaterialShearStrength(
      material, MpmPointOwn(sum->points, material, p), sum->points->state + p * sum->kept.state);
  }
  PetscCall(ShareWithNeighbours(facets, sum->grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmPieceWayBack(const MpmFacets *facets, const MpmFacet *facet)
{
  if (!facet->piece) return 0.;
  return Back(facets, facet) * facets->pieces.at[facet->piece - 1].astray;
}
