/*
  Facets of bodies in contact with one another.

  A facet is a face of a point's domain that bounds its part of the material (outer_faces.c), with the weights of its
  mean displacement at the nodes. Every rank has the facets of its own points and copies of near ones of other ranks.

  Where the surface of a body's region cut its lattice of points at an angle, faces are steps, which show neither the
  place nor the normal of the surface. Points keep both from the start, normal N and depth D. The material carries both:

    n = F^-T N/|F^-T N| ,   depth = D/|F^-T N| ,

  and the facet stands on that surface, before the middle of its face. Where the region ends straight across an axis,
  but not where the lattice does, the facet keeps that distance from its face.
*/
#include "point/material.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "facets/outer_faces.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "pairs/body_facets.h"
#include "contact/contact.h"
#include "facets/contact_search.h"

#define SLACK 1.01 /* of the distance between points: domains may have been stretched */

/* True for a part in a contact. */
static PetscBool InContact(const MpmPairs *pairs, PetscInt part)
{
  for (PetscInt k = 0; k < pairs->count; k++)
    if (pairs->at[k].part[0] == part || pairs->at[k].part[1] == part) return PETSC_TRUE;
  return PETSC_FALSE;
}

/*
  Normal of the facet, and its area. A face beyond which the surface took the next point of the lattice stands on the
  surface; any other one of a point near it is the step of another.
*/
static void SetSurface(PetscInt dim, const MpmBodies *bodies, const MpmPoints *points, PetscInt p, PetscInt face,
                       const PetscReal arm[], MpmPairFacet *facet)
{
  const MpmBody    body = MpmBodyOfPoint(bodies, points->id[p]);
  const PetscReal *N = &points->domain.cut[p * (dim + 1)], depth = N[dim];
  const PetscReal  along = (face % 2 ? 1. : -1.) * N[face / 2];
  PetscReal        size = 0., known = 0., off = 0., stretch;

  for (PetscInt a = 0; a < dim; a++) {
    size += PetscSqr(facet->area[a]);
    known += PetscAbsReal(N[a]);
  }
  size        = PetscSqrtReal(size);
  facet->size = 0.5 * PetscPowReal(size, 1. / (PetscReal)(dim - 1));
  for (PetscInt a = 0; a < dim; a++) facet->look[a] = facet->area[a] / size;
  facet->seen = known > 0. ? 0. : size;
  if (body && !(known > 0.)) {
    const PetscReal half   = points->domain.drawn[p * dim + face / 2];
    const PetscReal excess = MpmBodyExcess(body, &points->origin[p * dim], face / 2, face % 2, half);

    for (PetscInt a = 0; a < dim; a++) facet->place[a] += excess * facet->look[a];
  }
  if (!(along > 0. && depth < 2. * SLACK * along * points->domain.drawn[p * dim + face / 2])) return;
  stretch = MpmOuterNormal(dim, MpmPointF(points, p), N, facet->look) * MpmPointReference(points, dim, p, face / 2);
  facet->placed = 1;
  for (PetscInt a = 0; a < dim; a++) {
    facet->seen += facet->area[a] * facet->look[a];
    off += arm[a] * facet->look[a];
  }
  for (PetscInt a = 0; a < dim; a++) facet->place[a] += (stretch * depth - off) * facet->look[a];
}

static MpmPairFacet MakeFacet(const MpmPairContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                              const MpmSpace *space, PetscInt group, PetscInt p, PetscInt face)
{
  const PetscInt     dim      = space->dim;
  const MpmGroup    *nodes    = &space->groups[group];
  const MpmMaterial *material = &rules->materials[points->material[p]];
  PetscInt           cell[MPM_MAX_DIM];
  MpmFacet           facet = {.point = p, .group = group};
  PetscReal          arm[MPM_MAX_DIM];
  MpmPairFacet       made = {.part = points->domain.part[p], .id = points->id[p], .face = face, .point = p};

  MpmOuterFace(dim, MpmPointF(points, p), &points->domain.half_length[p * dim], face / 2, face % 2, arm, made.area);
  MpmGridFindPart(rules->grid, &points->x[p * dim], cell);
  for (PetscInt a = 0; a < dim; a++) {
    made.place[a] = facet.place[a] = points->x[p * dim + a] + arm[a];
    made.cell[a]                   = (PetscReal)cell[a];
  }
  for (PetscInt a = 0; a < dim; a++) made.area[a] *= MpmTurn(points->F_size, made.place[0]);
  SetSurface(dim, contacts->bodies, points, p, face, arm, &made);
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    made.first[a] = nodes->first[a];
    made.count[a] = nodes->count[a];
  }
  MpmFacetLines(rules, space, points, &facet, made.line);
  made.material.index   = points->material[p];
  made.material.modulus = MpmMaterialPenalty(material, MpmPointOwn(points, material, p));
  made.material.plastic = material->info.traits & MPM_LAW_PLASTIC ? 1. : 0.;
  made.material.strength =
    MpmMaterialShearStrength(material, MpmPointOwn(points, material, p), points->state + p * contacts->state_size);
  return made;
}

/* Extents of the faces of each part: lower corners, upper ones times -1; longest arm from point to face, times -1. */
typedef struct {
  PetscInt   dim, parts;
  PetscReal *least, reach;
} Extents;

/* Calls for each outer face of points in contact; stays in this file. */
#define FOR_FACES(contacts, points, dim, p, face) \
  for (PetscInt p = 0; p < (points)->count; p++) \
    for (PetscInt face = 0; \
         (points)->domain.faces[p] && InContact((contacts)->pairs, (points)->domain.part[p]) && face < 2 * (dim); \
         face++) \
      if ((points)->domain.faces[p] & MpmFaceBit(face / 2, face % 2))

/*
  Faces so far from all of the other side's part that they cannot lie across from one, nor be in the cell of one that
  does: search, a cell, and arms at both ends, which may end elsewhere on the surface that cut the lattice. Collective.
*/
static PetscErrorCode FindExtents(const MpmPairContacts *contacts, const MpmGrid *grid, const MpmPoints *points,
                                  Extents *extents)
{
  const PetscInt dim = grid->dim, count = 2 * dim * extents->parts + 1;
  PetscReal     *longest, h             = 0.;

  PetscFunctionBeginUser;
  extents->dim = dim;
  PetscCall(PetscMalloc1(count, &extents->least));
  for (PetscInt k = 0; k < count; k++) extents->least[k] = PETSC_INFINITY;
  longest = &extents->least[count - 1];
  FOR_FACES(contacts, points, dim, p, face)
  {
    PetscReal *least = &extents->least[2 * dim * points->domain.part[p]], arm[MPM_MAX_DIM], area[MPM_MAX_DIM],
              square = 0.;

    MpmOuterFace(dim, MpmPointF(points, p), &points->domain.half_length[p * dim], face / 2, face % 2, arm, area);
    for (PetscInt a = 0; a < dim; a++) {
      const PetscReal place = points->x[p * dim + a] + arm[a];

      least[a]       = PetscMin(least[a], place);
      least[dim + a] = PetscMin(least[dim + a], -place);
      square += PetscSqr(arm[a]);
    }
    *longest = PetscMin(*longest, -PetscSqrtReal(square));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, extents->least, (PetscMPIInt)count, MPIU_REAL, MPIU_MIN, contacts->comm));
  for (PetscInt a = 0; a < dim; a++) h = PetscMax(h, grid->h[a]);
  extents->reach = MPM_PAIR_SEARCH * contacts->cell + h - 4. * (*longest < 0. ? *longest : 0.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a place of a part is within reach of the faces of another part in contact with it. */
static PetscBool IsNear(const Extents *extents, const MpmPairs *pairs, PetscInt part, const PetscReal x[])
{
  for (PetscInt k = 0; k < 2 * pairs->count; k++) {
    const PetscReal *least = &extents->least[2 * extents->dim * pairs->at[k / 2].part[1 - k % 2]];
    PetscBool        near  = (PetscBool)(pairs->at[k / 2].part[k % 2] == part);

    for (PetscInt a = 0; a < extents->dim; a++)
      near = (PetscBool)(near && x[a] > least[a] - extents->reach && -x[a] > least[extents->dim + a] - extents->reach);
    if (near) return PETSC_TRUE;
  }
  return PETSC_FALSE;
}

static PetscErrorCode OwnFacets(MpmPairContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                                const MpmSpace *space)
{
  PetscInt capacity = 0;
  Extents  extents  = {.parts = contacts->bodies->parts};

  PetscFunctionBeginUser;
  contacts->facets.count = 0;
  PetscCall(FindExtents(contacts, rules->grid, points, &extents));
  for (PetscInt g = 0; g < space->group_count; g++) {
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      const PetscInt p = space->order[s];

      if (!points->domain.faces[p] ||
          !IsNear(&extents, contacts->pairs, points->domain.part[p], &points->x[p * space->dim]))
        continue;
      for (PetscInt face = 0; face < 2 * space->dim; face++) {
        if (!(points->domain.faces[p] & MpmFaceBit(face / 2, face % 2))) continue;
        if (contacts->facets.count == capacity) {
          capacity = 2 * capacity + 64;
          PetscCall(PetscRealloc((size_t)capacity * sizeof(MpmPairFacet), &contacts->facets.at));
        }
        contacts->facets.at[contacts->facets.count++] = MakeFacet(contacts, rules, points, space, g, p, face);
      }
    }
  }
  PetscCall(PetscFree(extents.least));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmPairFacetCells(const MpmGrid *grid, const MpmPairFacet *facet, PetscReal reach, PetscInt lower[],
                       PetscInt upper[])
{
  const PetscInt more = (PetscInt)ceil((PetscReal)grid->order * reach) + 1;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const PetscInt cell = a < grid->dim ? (PetscInt)facet->cell[a] : 0;

    lower[a] = a < grid->dim ? PetscMax(cell - more, 0) : 0;
    upper[a] = a < grid->dim ? PetscMin(cell + more, grid->order * grid->cells[a] - 1) : 0;
  }
}

/* Copies of the facets to the ranks that own cells near them; those received stand behind the own ones. */
static PetscErrorCode ShareFacets(MpmPairContacts *contacts, const MpmGrid *grid)
{
  const PetscInt own = contacts->facets.count;
  PetscInt      *boxes;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((2 * MPM_MAX_DIM * own), &boxes));
  for (PetscInt k = 0; k < own; k++) {
    PetscInt *box = &boxes[2 * MPM_MAX_DIM * k];

    MpmPairFacetCells(grid, &contacts->facets.at[k], 2. * MPM_PAIR_SEARCH, box, box + MPM_MAX_DIM);
    for (PetscInt a = 0; a < 2 * MPM_MAX_DIM; a++) box[a] /= grid->order;
  }
  PetscCall(MpmGridShare(grid, sizeof(MpmPairFacet), boxes, &contacts->facets.count, (void **)&contacts->facets.at));
  for (PetscInt k = own; k < contacts->facets.count; k++) contacts->facets.at[k].point = -1;
  PetscCall(PetscFree(boxes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* By cell, then by id and face: one order, whatever the ranks. */
static int CompareFacets(const void *a, const void *b)
{
  const MpmPairFacet *f = (const MpmPairFacet *)a, *g = (const MpmPairFacet *)b;

  for (PetscInt k = MPM_MAX_DIM - 1; k >= 0; k--)
    if (f->cell[k] != g->cell[k]) return f->cell[k] < g->cell[k] ? -1 : 1;
  if (f->id != g->id) return f->id < g->id ? -1 : 1;
  return f->face < g->face ? -1 : f->face > g->face;
}

/* The first facet of a cell in the sorted list. */
static PetscInt FirstOfCell(const MpmPairContacts *contacts, const PetscInt cell[])
{
  MpmPairFacet wanted = {.id = -1};
  PetscInt     lower = 0, upper = contacts->facets.count;

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) wanted.cell[a] = (PetscReal)cell[a];
  while (lower < upper) {
    const PetscInt middle = (lower + upper) / 2;

    if (CompareFacets(&contacts->facets.at[middle], &wanted) < 0) lower = middle + 1;
    else upper = middle;
  }
  return lower;
}

void MpmPairFacetsOfCell(const MpmPairContacts *contacts, const PetscInt cell[], PetscInt *first, PetscInt *end)
{
  *first = *end = FirstOfCell(contacts, cell);
  for (; *end < contacts->facets.count; (*end)++)
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
      if (contacts->facets.at[*end].cell[a] != (PetscReal)cell[a]) return;
}

/* Boxes around each part's points with outer faces, enlarged by the allowance of FindExtents(): true where those of
   any pair meet. Collective. */
static PetscErrorCode AnyNear(const MpmPairContacts *contacts, const MpmGrid *grid, const MpmPoints *points,
                              PetscBool *near)
{
  const PetscInt dim = grid->dim, parts = contacts->bodies->parts, stride = 2 * dim + 1;
  MpmFaceBox    *box;
  PetscReal     *least, h = 0.;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(parts, &box, (parts * stride), &least));
  MpmFaceBoxesOfParts(dim, parts, points, box);
  for (PetscInt k = 0; k < parts; k++) {
    for (PetscInt a = 0; a < dim; a++) {
      least[k * stride + a]       = box[k].lower[a];
      least[k * stride + dim + a] = -box[k].upper[a];
    }
    /* upper bound of the arms of faces, times -1 */
    least[k * stride + 2 * dim] = -PetscSqrtReal(box[k].square);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, least, (PetscMPIInt)(parts * stride), MPIU_REAL, MPIU_MIN, contacts->comm));
  for (PetscInt a = 0; a < dim; a++) h = PetscMax(h, grid->h[a]);
  *near = PETSC_FALSE;
  for (PetscInt k = 0; k < contacts->pairs->count; k++) {
    const PetscReal *one   = &least[contacts->pairs->at[k].part[0] * stride],
                    *other = &least[contacts->pairs->at[k].part[1] * stride];
    const PetscReal reach  = MPM_PAIR_SEARCH * contacts->cell + h - 6. * PetscMin(one[2 * dim], other[2 * dim]);
    PetscBool       meet   = PETSC_TRUE;

    for (PetscInt a = 0; a < dim; a++)
      if (!(one[a] <= reach - other[dim + a] && other[a] <= reach - one[dim + a])) meet = PETSC_FALSE;
    *near = (PetscBool)(*near || meet);
  }
  PetscCall(PetscFree2(box, least));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPairFacetsFind(MpmPairContacts *contacts, const MpmRules *rules, const MpmPoints *points,
                                 const MpmSpace *space)
{
  PetscBool near = PETSC_FALSE;

  PetscFunctionBeginUser;
  contacts->facets.count = 0;
  PetscCall(AnyNear(contacts, rules->grid, points, &near));
  if (!near) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(contacts->facets.search, 0, 0, 0, 0));
  PetscCall(OwnFacets(contacts, rules, points, space));
  PetscCall(ShareFacets(contacts, rules->grid));
  qsort(contacts->facets.at, (size_t)contacts->facets.count, sizeof(MpmPairFacet), CompareFacets);
  PetscCall(PetscLogEventEnd(contacts->facets.search, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}
