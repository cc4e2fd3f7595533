/*
  Weights of a face at the nodes that its point touches, on each axis: so that a uniform pressure on an even face is
  consistent with uniform stress, in every node.

  Shapes with a domain: the weights of the portion of the domain about the face, the face's middle across, the domain's
  mean along. The corner of a domain that has turned stands out of it, which is along the axes: its displacement goes on
  from the domain's edge with the gradient at the point. Otherwise a turning face would slip there by as much as the
  corner stands out.

  Shapes without one: those of the polynomials of the point's own knot intervals, which are extended where the face
  stands in the next ones.

  On a round surface, off which the face stands, the displacement is that of the point and its gradient, so that the
  force has its moment about the body's middle, and the body rolls over its true radius. Nodes with little mass then
  have little of the force.
*/
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/points.h"
#include "space/rules.h"
#include "space/point_shape.h"
#include "space/space.h"
#include "facets/facets.h"

/* Weights on one axis, and where the nodes that have them lie beside those of the point's group. */
typedef struct {
  PetscReal    weight[MPM_MAX_WIDTH], unused[MPM_MAX_WIDTH];
  PetscInt     lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* walls */
  MpmShapeLine line;
} Axis;

static void SetAxis(const MpmRules *rules, const MpmPoints *points, PetscInt p, Axis *axis)
{
  axis->line = (MpmShapeLine){.weight = axis->weight, .gradient = axis->unused};
  MpmSpaceEdges(rules, &points->x[p * rules->grid->dim], axis->lower, axis->upper);
}

/* The first node of the axis, counted from that of the point's group. */
static PetscInt First(const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet, PetscInt a,
                      const Axis *axis)
{
  const PetscInt shift = a == space->dim - 1 ? MpmSpaceShift(space, points->domain.part, facet->point) : 0;

  return axis->line.first + shift - space->groups[facet->group].first[a];
}

/* The place of a facet on an axis and, `inside` the point's domain, the nearest one; in cells. */
static PetscReal InDomain(const MpmRules *rules, const MpmPoints *points, const MpmFacet *facet, PetscInt a,
                          PetscReal half, PetscReal *inside)
{
  const MpmGrid  *grid  = rules->grid;
  const PetscReal x     = (points->x[facet->point * grid->dim + a] - grid->lower[a]) / grid->h[a];
  const PetscReal place = (facet->place[a] - grid->lower[a]) / grid->h[a];

  *inside = PetscMin(PetscMax(place, x - half), x + half);
  return place;
}

/* Of the domain about the face; `half`: the domain's half-length, cells. */
static void DomainLine(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                       PetscInt a, PetscReal half, PetscReal line[])
{
  const MpmGrid  *grid = rules->grid;
  const PetscInt  p = facet->point, last = space->groups[facet->group].count[a] - 1;
  const PetscReal x = (points->x[p * space->dim + a] - grid->lower[a]) / grid->h[a];
  PetscReal       at, place = InDomain(rules, points, facet, a, half, &at);
  const PetscReal room = PetscMax(half - PetscAbsReal(at - x), 0.),
                  out  = facet->key.corner ? (place - at) * grid->h[a] : 0.;
  Axis axis;

  SetAxis(rules, points, p, &axis);
  MpmShapeEvaluate(rules->shape, rules->edge, at, facet->key.slice ? PetscMin(room, half / MPM_SLICES) : room,
                   axis.lower[a], axis.upper[a], &axis.line);
  for (PetscInt i = 0; i <= last; i++) line[i] = 0.;
  for (PetscInt i = 0; i < axis.line.count; i++) /* rounding may touch a node more than the domain does */
    line[PetscMin(PetscMax(First(space, points, facet, a, &axis) + i, 0), last)] += axis.weight[i];
  if (out != 0.) MpmPointAddSlope(space, p, a, last + 1, out, line);
}

/* Of the point and its gradient. */
static void PointLine(const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet, PetscInt a,
                      PetscReal line[])
{
  MpmPointLine(space, facet->point, a, space->groups[facet->group].count[a],
               facet->place[a] - points->x[facet->point * space->dim + a], line);
}

/* Of the polynomials in the point's knot interval. */
static void IntervalLine(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                         PetscInt a, PetscReal line[])
{
  const MpmGrid  *grid = rules->grid;
  const PetscInt  p = facet->point, count = space->groups[facet->group].count[a];
  const PetscReal x      = points->x[p * space->dim + a];
  PetscBool       inside = PETSC_TRUE;
  Axis            axis;

  SetAxis(rules, points, p, &axis);
  MpmShapeExtend(rules->shape, rules->edge, (x - grid->lower[a]) / grid->h[a], (facet->place[a] - x) / grid->h[a],
                 axis.lower[a], axis.upper[a], &axis.line);
  for (PetscInt i = 0; i < count; i++) line[i] = 0.;
  for (PetscInt i = 0; i < axis.line.count; i++) {
    const PetscInt k = First(space, points, facet, a, &axis) + i;

    if (k >= 0 && k < count) line[k] = axis.weight[i];
    else inside = PETSC_FALSE;
  }
  if (!inside)
    PointLine(space, points, facet, a, line); /* a point on a knot touches a node less than its interval has */
}

void MpmFacetLines(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                   PetscReal (*line)[MPM_MAX_WIDTH])
{
  const PetscBool domain = MpmShapeHasDomain(rules->shape);
  PetscReal       half[MPM_MAX_DIM];

  if (domain) (void)MpmSpaceHalfLengths(rules, points, facet->point, half);
  for (PetscInt a = 0; a < space->dim; a++) {
    if (facet->key.round) PointLine(space, points, facet, a, line[a]);
    else if (domain) DomainLine(rules, space, points, facet, a, half[a], line[a]);
    else IntervalLine(rules, space, points, facet, a, line[a]);
  }
}

#define NO_ROOM 1e-9 /* half-length below which a portion of a domain is a place, cells */

void MpmFacetLineSlopes(const MpmRules *rules, const MpmSpace *space, const MpmPoints *points, const MpmFacet *facet,
                        MpmFacetSlopes *slopes)
{
  const MpmGrid *grid = rules->grid;
  const PetscInt p    = facet->point;
  PetscReal      half[MPM_MAX_DIM];

  (void)MpmSpaceHalfLengths(rules, points, p, half);
  (void)PetscMemzero(slopes, sizeof(*slopes));
  for (PetscInt a = 0; a < space->dim; a++) {
    const PetscInt  last = space->groups[facet->group].count[a] - 1;
    const PetscReal x    = (points->x[p * space->dim + a] - grid->lower[a]) / grid->h[a];
    PetscReal       at, place = InDomain(rules, points, facet, a, half[a], &at);
    const PetscReal sign = at < x ? -1. : 1., room = PetscMax(half[a] - PetscAbsReal(at - x), 0.);
    PetscReal       bend[MPM_MAX_WIDTH], by_length[MPM_MAX_WIDTH], unused[MPM_MAX_WIDTH];
    Axis            axis;

    SetAxis(rules, points, p, &axis);
    MpmShapeEvaluate(rules->shape, rules->edge, at, room, axis.lower[a], axis.upper[a], &axis.line);
    MpmShapeDifferentiate(rules->shape, rules->edge, &(MpmShapePlace){at, room, axis.lower[a], axis.upper[a]},
                          &axis.line, &(MpmShapeSlopes){bend, by_length, unused});
    for (PetscInt i = 0; i < axis.line.count; i++) {
      const PetscInt  k = PetscMin(PetscMax(First(space, points, facet, a, &axis) + i, 0), last);
      const PetscReal g = axis.line.gradient[i], by_room = at != place || room < NO_ROOM ? 0. : by_length[i];

      slopes->by_place[a][k] += at != place ? 0. : g - sign * by_room;
      slopes->by_point[a][k] += at != place ? g : sign * by_room;
      slopes->by_length[a][k] += at != place ? sign * g : by_room;
    }
  }
}

void MpmFacetBoxWeights(const MpmFacets *facets, const MpmRules *rules, const MpmSpace *space, const MpmPoints *points,
                        const MpmFacet *facet, const MpmGroup *box, PetscReal weight[])
{
  const MpmGroup  group = MpmFacetBox(facets, space, facet);
  const MpmPiece *piece = facet->piece ? &facets->pieces.at[facet->piece - 1] : NULL;
  PetscReal       line[MPM_MAX_DIM][MPM_MAX_WIDTH];
  const PetscReal(*lines)[MPM_MAX_WIDTH] = (const PetscReal(*)[MPM_MAX_WIDTH])(piece ? piece->line : line);

  if (!piece) MpmFacetLines(rules, space, points, facet, line);
  for (PetscInt i = 0; i < box->node_count; i++) {
    const PetscInt row             = i / box->count[0];
    const PetscInt at[MPM_MAX_DIM] = {i % box->count[0], row % box->count[1], row / box->count[1]};

    weight[i] = 1.;
    for (PetscInt a = 0; a < space->dim; a++) {
      const PetscInt k = at[a] + box->first[a] - group.first[a];

      weight[i] *= k >= 0 && k < group.count[a] ? lines[a][k] : 0.;
    }
  }
}
