/*
  Facets that are faces of points' domains.

  A facet is a face of a point's domain that bounds the material (outer_faces.c). Its place is y = x + F l_a e_a, with
  the outward area a = cof(F) A_a e_a; its area towards a surface of normal n is A = -a . n. Summed over the steps of a
  lattice that was cut at an angle, A is the area of the cut.
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "facets/outer_faces.h"
#include "particles/points.h"
#include "facets/facets.h"

#define FACING 0.2 /* cosine between the normals of a surface and of a face that meets it with an edge */
#define FACING_SIDE \
  0.7 /* cosine, at least, between the normal of a face before any deformation and that of the side that it faces */
#define ASKEW 0.1  /* cosine at which a face that looks past the surface counts by half */
#define NUDGE 1e-3 /* of a cell: so far before a surface lies the cell beside it */

/* Faces of a point that meet a boundary from two sides or more: its edge or corner stands out. */
typedef struct {
  PetscInt  count;
  PetscReal arm[MPM_MAX_DIM], initial[MPM_MAX_DIM], outward[MPM_MAX_DIM], area;
} Corner;

/*
  The edge or corner in which the faces towards the boundary meet, a facet with a patch of its own: where it stands out
  towards the surface it touches long before the faces' middles do. Where the surface cut the lattice there are none:
  each step of the lattice would be one.
*/
static PetscErrorCode CornerFacet(MpmFacets *facets, PetscInt b, PetscReal margin, const MpmPoints *points,
                                  const MpmFacet *start, const Corner *corner)
{
  const MpmPose  still = {.growth = 0.};
  const PetscInt dim = facets->boundaries[b].dim, p = start->point;
  MpmFacet       facet = *start;
  MpmSurface     surface;
  PetscReal      at[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  if (facets->cut[b] || corner->count < 2) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < dim; a++) {
    facet.place[a] = points->x[p * dim + a] + corner->arm[a];
    at[a]          = points->origin[p * dim + a] + corner->initial[a];
  }
  MpmBoundaryDistance(&facets->boundaries[b], &still, at, &surface);
  facet.touches = PetscMin(surface.distance, 0.);
  if (facets->boundaries[b].bilateral && surface.distance > MPM_TOLERANCE * facets->cell)
    PetscFunctionReturn(PETSC_SUCCESS);
  MpmFacetStartDistance(facets, corner->outward, &facet, &surface);
  if (!facets->boundaries[b].bilateral && surface.distance > margin) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < dim; a++) facet.normal[a] = surface.normal[a];
  facet.area       = 0.5 * corner->area;
  facet.key.corner = points->id[p] + 1;
  PetscCall(MpmFacetsAdd(facets, &facet));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The cell whose patch a facet joins: its point's own or, where the point's middle is beyond the surface, that before
  the surface. A patch of its own would push it out in one step, unlike its equally deep neighbours: then it would be
  back in their cell, and so on.
*/
static PetscInt64 PatchCell(const MpmFacets *facets, const MpmGrid *grid, const MpmPoints *points,
                            const MpmFacet *facet, const PetscReal arm[], const MpmSurface *surface)
{
  const PetscReal *x     = &points->x[facet->point * grid->dim];
  PetscReal        depth = -surface->distance, foot[MPM_MAX_DIM];

  for (PetscInt a = 0; a < grid->dim; a++) depth += arm[a] * surface->normal[a];
  if (depth <= 0.) return facet->key.cell;
  for (PetscInt a = 0; a < grid->dim; a++) foot[a] = x[a] + (depth + NUDGE * facets->cell) * surface->normal[a];
  return MpmFacetCell(grid, foot, points->domain.part ? points->domain.part[facet->point] : 0);
}

/*
  Weight of a face nearly perpendicular to the boundary, from 0 to 1. A side that shear has turned slightly has a small
  area towards the surface, but is half a domain away from it: in the mean gap that is more than the depth of a stiff
  contact. The weight grows smoothly with the angle, or forces would jump. The steps of a cut lattice count.
*/
static void RegardFacet(const MpmFacets *facets, PetscReal square, MpmFacet *facet)
{
  const PetscReal t = PetscSqr(facet->area) / (square * PetscSqr(ASKEW));

  if (facets->cut[facet->boundary]) return;
  facet->area *= t / (1. + t);
  facet->askew = (PetscBool)(t < 1.);
}

/* Half of the sides of a face. */
static void FaceSides(PetscInt dim, const MpmPoints *points, PetscInt p, PetscInt face, PetscReal (*sides)[MPM_MAX_DIM])
{
  for (PetscInt b = 0, k = 0; b < dim; b++) {
    if (b == face / 2) continue;
    for (PetscInt a = 0; a < dim; a++)
      sides[k][a] = points->domain.half_length[p * dim + b] * MpmPointF(points, p)[a * dim + b];
    k++;
  }
}

/* A face of a point, with its number, its sides, its outward area, and the square of that. */
typedef struct {
  PetscInt   number;
  PetscReal  arm[MPM_MAX_DIM], area[MPM_MAX_DIM], sides[MPM_MAX_DIM - 1][MPM_MAX_DIM], square;
  MpmSurface surface;
} Face;

/* A face that meets an edge of the boundary, in slices of its area; they touch where the face does. */
static PetscErrorCode SlicesOfFace(MpmFacets *facets, PetscReal margin, PetscInt count, Face *face,
                                   const MpmFacet *whole)
{
  const PetscInt dim               = facets->boundaries[whole->boundary].dim;
  PetscReal      area[MPM_MAX_DIM] = {0., 0., 0.};

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < dim; a++) area[a] = face->area[a] / (PetscReal)count;
  for (PetscInt k = 0; k < count; k++) {
    MpmFacet   slice  = *whole;
    PetscReal  square = 0.;
    MpmSurface surface;

    slice.key.slice = 1 + k;
    slice.area      = 0.;
    MpmFacetSlicePlace(dim, face->sides, &slice);
    MpmFacetStartDistance(facets, area, &slice, &surface);
    for (PetscInt a = 0; a < dim; a++) {
      slice.normal[a] = surface.normal[a];
      slice.area -= area[a] * surface.normal[a];
      square += PetscSqr(area[a]);
    }
    if (!(slice.area > 0.) || surface.distance > margin) continue;
    slice.facing =
      (PetscBool)(slice.key.side && (face->number % 2 ? -1. : 1.) * slice.normal[face->number / 2] > FACING_SIDE);
    RegardFacet(facets, square, &slice);
    PetscCall(MpmFacetsAdd(facets, &slice));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void AddToCorner(PetscInt dim, const PetscReal arm[], const PetscReal outward[], PetscReal area, Corner *corner)
{
  corner->count++;
  corner->area += area;
  for (PetscInt a = 0; a < dim; a++) {
    corner->arm[a] += arm[a];
    corner->outward[a] += outward[a];
  }
}

/* Puts a face of the facet's point into the facet. */
static void PlaceFace(const MpmFacets *facets, const MpmPoints *points, PetscInt number, MpmFacet *facet, Face *face)
{
  const PetscInt dim = facets->boundaries[facet->boundary].dim, p = facet->point;

  face->number = number;
  face->square = 0.;
  MpmOuterFace(dim, MpmPointF(points, p), &points->domain.half_length[p * dim], number / 2, number % 2, face->arm,
               face->area);
  FaceSides(dim, points, p, number, face->sides);
  for (PetscInt a = 0; a < dim; a++) facet->place[a] = points->x[p * dim + a] + face->arm[a];
  MpmFacetStartDistance(facets, face->area, facet, &face->surface);
  for (PetscInt a = 0; a < dim; a++) {
    facet->normal[a] = face->surface.normal[a];
    facet->area -= face->area[a] * face->surface.normal[a];
    face->square += PetscSqr(face->area[a]);
  }
}

/* Adds the facet of a face that counts towards the boundary, or of its slices. */
static PetscErrorCode AddFace(MpmFacets *facets, PetscReal margin, const MpmGrid *grid, const MpmPoints *points,
                              PetscInt slices, Face *face, MpmFacet *facet)
{
  PetscFunctionBeginUser;
  if (slices) {
    PetscCall(SlicesOfFace(facets, margin, slices, face, facet));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  facet->key.cell = PatchCell(facets, grid, points, facet, face->arm, &face->surface);
  PetscCall(MpmFacetsAdd(facets, facet));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFacetsAddFaces(MpmFacets *facets, PetscReal margin, const MpmGrid *grid, const MpmPoints *points,
                                 const MpmFacet *start)
{
  const PetscInt  dim = grid->dim, p = start->point, b = start->boundary;
  const PetscBool bilateral = facets->boundaries[b].bilateral;
  Corner          corner    = {0};
  PetscInt        count     = 0, slices;
  PetscReal       kept[2 * MPM_MAX_DIM];
  PetscBool       cut = PETSC_FALSE, touched;

  PetscFunctionBeginUser;
  for (PetscInt number = 0; number < 2 * dim; number++) {
    MpmFacet facet = *start;
    Face     face;

    if (!(points->domain.faces[p] & MpmFaceBit(number / 2, number % 2))) continue;
    if (MpmFacetsSeeRound(facets, points, b, p, number)) {
      PetscCall(MpmFacetsAddRound(facets, margin, points, number, start));
      continue;
    }
    PlaceFace(facets, points, number, &facet, &face);
    slices = face.surface.distance > margin ? 0 : MpmFacetAtEdge(facets, grid->h, face.sides, &face.surface, &facet);
    if (!(facet.area > 0.) && !slices) continue;
    if (facet.area > FACING * PetscSqrtReal(face.square)) {
      AddToCorner(dim, face.arm, face.area, facet.area, &corner);
      corner.initial[number / 2] = (number % 2 ? 1. : -1.) * points->domain.drawn[p * dim + number / 2];
    }
    if (!bilateral && face.surface.distance > margin) continue;
    touched = MpmFaceTouchedAtStart(facets, b, points, p, number, &kept[count]);
    if (touched) facet.touches = kept[count];
    else if (bilateral) continue;
    if (!slices && !touched) RegardFacet(facets, face.square, &facet);
    if (!slices && !(facet.area > 0.)) continue;
    PetscCall(AddFace(facets, margin, grid, points, slices, &face, &facet));
    if (slices) continue;
    cut = (PetscBool)(cut || (touched && facets->cut[b]));
    count++;
  }
  /* cut domains do not fill the space: some of their faces bound nothing, and keep their distance, too */

  for (PetscInt k = 0; k < count && cut; k++) facets->at[facets->count - count + k].touches = kept[k];
  PetscCall(CornerFacet(facets, b, margin, points, start, &corner));
  PetscFunctionReturn(PETSC_SUCCESS);
}
