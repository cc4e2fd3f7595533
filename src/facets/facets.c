/*
  The facets of a step: faces of points (face_facets.c), slices of those at an edge (edge_facets.c), places on round
  surfaces (round_facets.c), points of material that flows (flow_facets.c), and pieces of a boundary's own surface
  (surface_shares.c, surface_pieces.c).
*/
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "facets/contact_search.h"
#include "facets/facets.h"

#define TOUCH 1e-12 /* of a cell: rounding of a face that stands on the boundary */

PetscErrorCode MpmFacetsCreate(PetscInt count, const MpmBoundary boundaries[], MpmFacets *facets)
{
  PetscFunctionBeginUser;
  facets->boundary_count = count;
  facets->boundaries     = boundaries;
  PetscCall(PetscCalloc3(count, &facets->before, count, &facets->after, count, &facets->drawn));
  if (count) PetscCall(MpmFaceBoxesCreate(&facets->boxes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFacetsDestroy(MpmFacets *facets)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree3(facets->before, facets->after, facets->drawn));
  PetscCall(PetscFree(facets->cut));
  PetscCall(PetscFree(facets->bodies));
  PetscCall(PetscFree(facets->at));
  PetscCall(PetscFree(facets->pieces.at));
  PetscCall(MpmFaceBoxesDestroy(&facets->boxes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFacetsBegin(MpmFacets *facets, const MpmGrid *grid, const MpmPoints *points)
{
  PetscFunctionBeginUser;
  facets->cell = PETSC_INFINITY;
  for (PetscInt a = 0; a < grid->dim; a++) facets->cell = PetscMin(facets->cell, grid->h[a]);
  facets->touch = TOUCH * facets->cell;
  if (!facets->cut) PetscCall(MpmFacetsFindCuts(facets, grid, points));
  PetscCall(MpmFaceBoxesBegin(facets, points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FacetsOfBoundary(MpmFacets *facets, PetscInt b, const MpmRules *rules, const MpmSpace *space,
                                       const MpmPoints *points)
{
  const MpmGrid *grid = rules->grid;
  const PetscInt dim  = grid->dim;
  PetscBool      far, flows = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(MpmFacetsFindDrawn(facets, b, grid, points));
  if (facets->drawn[b]) {
    PetscCall(MpmFacetsAddShares(facets, b, rules, space, points));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MpmFacetsAddFlowing(facets, b, rules, points, space, &flows));
  if (flows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MpmFaceBoxesFind(facets, b, grid, points, &far));
  if (far) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscLogEventBegin(facets->boxes->search, 0, 0, 0, 0));
  for (PetscInt g = 0; g < space->group_count; g++) {
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      const PetscInt p     = space->order[s];
      MpmFacet       facet = {.boundary = b, .point = p, .group = g};
      PetscReal      margin;

      if (!points->domain.faces[p] || MpmFaceBoxIsFar(facets, b, p) || MpmFacetsFlow(rules, points, p) ||
          !MpmRegionContains(facets->boundaries[b].region, &points->origin[p * dim]))
        continue;
      margin = MpmFacetsMargin(facets, grid, b, &points->x[p * dim]);
      if (!facets->boundaries[b].bilateral && MpmFacetsAreFar(facets, b, margin, points, p)) continue;
      facet.key.cell = MpmFacetCell(grid, &points->x[p * dim], points->domain.part ? points->domain.part[p] : 0);
      PetscCall(MpmFacetsAddFaces(facets, margin, grid, points, &facet));
    }
  }
  PetscCall(PetscLogEventEnd(facets->boxes->search, 0, 0, 0, 0));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFacetsFind(MpmFacets *facets, const MpmRules *rules, const MpmPoints *points, const MpmSpace *space)
{
  PetscFunctionBeginUser;
  facets->count = 0;
  for (PetscInt b = 0; b < facets->boundary_count; b++) PetscCall(FacetsOfBoundary(facets, b, rules, space, points));
  PetscCall(MpmPiecesSpread(facets, rules, points, space));
  PetscFunctionReturn(PETSC_SUCCESS);
}
