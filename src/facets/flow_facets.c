/*
  Facets of material that flows, in explicit steps: points near a surface, whatever faces they had at the start.

  Points of a fluid change neighbours: whichever has come to the surface touches it, and its first faces say nothing any
  more. A facet is the middle of the side of a point's domain towards the surface, at the distance d - r, with d the
  distance of the point and r the reach of its domain,

    r = |n . M e_a| ,  M = F diag(l) ,  a the axis with the largest (n . M e_a) (n . M^-T e_a) .

  These products add up to 1. A domain that the flow has sheared along the surface keeps the a and the r with which it
  began. The area is that of the volume over 2 r. A facet counts in a step at whose end its point, with its velocity,
  would be nearer than r: a patch is the mean of facets that touch.
*/
#include "point/material.h"
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/space.h"
#include "facets/outer_faces.h"
#include "facets/contact_search.h"
#include "facets/facets.h"

#define LEAST 1e-3 /* of a cell: least reach for the area */

PetscBool MpmFacetsFlow(const MpmRules *rules, const MpmPoints *points, PetscInt p)
{
  return (PetscBool)(rules->longest > 0. && rules->materials[points->material[p]].info.traits & MPM_LAW_VISCOUS);
}

/* True where some material flows in this step, and `all` where all of them do. */
static PetscBool AnyFlows(const MpmRules *rules, PetscBool *all)
{
  PetscBool any = PETSC_FALSE;

  *all = (PetscBool)(rules->longest > 0.);
  for (PetscInt m = 0; rules->longest > 0. && m < rules->material_count; m++) {
    const PetscBool flows = (PetscBool)((rules->materials[m].info.traits & MPM_LAW_VISCOUS) != 0);

    any  = (PetscBool)(any || flows);
    *all = (PetscBool)(*all && flows);
  }
  return any;
}

/* How far a point's domain reaches towards a surface of normal n, m. */
static PetscReal Reach(const MpmPoints *points, PetscInt dim, PetscInt p, const PetscReal n[])
{
  const PetscReal *half = &points->domain.half_length[p * dim];
  PetscReal        best = -1., reach = 0.;

  for (PetscInt axis = 0; axis < dim; axis++) {
    PetscReal arm[MPM_MAX_DIM], area[MPM_MAX_DIM], along = 0., seen = 0.;

    MpmOuterFace(dim, MpmPointF(points, p), half, axis, 1, arm, area);
    for (PetscInt a = 0; a < dim; a++) {
      along += n[a] * arm[a];
      seen += n[a] * area[a];
    }
    if (along * seen <= best) continue;
    best  = along * seen;
    reach = PetscAbsReal(along);
  }
  return reach;
}

/* The flat side of a boundary at rest that has this normal there, or 0. */
static PetscInt Side(const MpmFacets *facets, PetscInt b, const PetscReal n[])
{
  const MpmPose rest                = {.growth = 0.};
  PetscReal     normal[MPM_MAX_DIM] = {0., 0., 0.};
  PetscInt      axis                = 0;

  if (!MpmSolidHasFaces(&facets->boundaries[b].solid)) return 0;
  MpmPoseTurn(facets->boundaries[b].dim, &facets->before[b], &rest, n, normal);
  for (PetscInt a = 1; a < facets->boundaries[b].dim; a++)
    if (PetscAbsReal(normal[a]) > PetscAbsReal(normal[axis]) * (1. + MPM_ALIGNED)) axis = a;
  return 2 * axis + (normal[axis] > 0. ? 2 : 1);
}

static PetscErrorCode AddPoint(MpmFacets *facets, PetscInt b, const MpmRules *rules, const MpmPoints *points,
                               PetscInt g, PetscInt p)
{
  const PetscInt   dim = rules->grid->dim;
  const PetscReal *x = &points->x[p * dim], *v = &points->motion.velocity[p * dim];
  const PetscReal  dt    = rules->time.end - rules->time.start;
  MpmFacet         facet = {.boundary = b, .point = p, .group = g, .key.flows = 1};
  PetscReal        reach, gap, y[MPM_MAX_DIM] = {0., 0., 0.};
  MpmSurface       surface;

  PetscFunctionBeginUser;
  MpmFacetsDistance(facets, b, x, &surface);
  if (surface.distance > facets->cell * MPM_SPRAY_HALF_LENGTH) PetscFunctionReturn(PETSC_SUCCESS);
  reach = Reach(points, dim, p, surface.normal);
  gap   = surface.distance - reach;
  MpmPoseCarry(dim, &facets->before[b], &facets->after[b], x, y);
  facet.distance = gap;
  for (PetscInt a = 0; a < dim; a++) gap += surface.normal[a] * (dt * v[a] - (y[a] - x[a]));
  if (gap > facets->touch) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt a = 0; a < dim; a++) {
    facet.normal[a] = surface.normal[a];
    facet.place[a]  = x[a] - reach * surface.normal[a];
  }
  facet.area     = 0.5 * MpmPointExtent(points, dim, p) / PetscMax(reach, LEAST * facets->cell);
  facet.key.side = Side(facets, b, surface.normal);
  facet.key.cell = MpmFacetCell(rules->grid, x, points->domain.part ? points->domain.part[p] : 0);
  PetscCall(MpmFacetsAdd(facets, &facet));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where no point of a group, which stands in a cell, or in halves of two, can touch in this step. */
static PetscBool IsFar(const MpmFacets *facets, PetscInt b, const MpmGrid *grid, const MpmPoints *points, PetscInt p)
{
  PetscReal  margin = MpmFacetsMargin(facets, grid, b, &points->x[p * grid->dim]);
  MpmSurface surface;

  for (PetscInt a = 0; a < grid->dim; a++) margin += grid->h[a];
  MpmFacetsDistance(facets, b, &points->x[p * grid->dim], &surface);
  return (PetscBool)(surface.distance > margin);
}

PetscErrorCode MpmFacetsAddFlowing(MpmFacets *facets, PetscInt b, const MpmRules *rules, const MpmPoints *points,
                                   const MpmSpace *space, PetscBool *all)
{
  PetscFunctionBeginUser;
  if (!AnyFlows(rules, all)) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    if (group->point_begin == group->point_end ||
        IsFar(facets, b, rules->grid, points, space->order[group->point_begin]))
      continue;
    for (PetscInt s = group->point_begin; s < group->point_end; s++)
      if (MpmFacetsFlow(rules, points, space->order[s]) &&
          MpmRegionContains(facets->boundaries[b].region, &points->origin[space->order[s] * rules->grid->dim]))
        PetscCall(AddPoint(facets, b, rules, points, g, space->order[s]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
