/*
  Weights with which loads act on the nodes that a point touches: of the centre of a face, or of the ends of its domain.
*/
#include "grid/grid.h"
#include "grid/shape.h"
#include "particles/points.h"
#include "space/point_shape.h"
#include "space/rules.h"
#include "space/space.h"
#include "loads/load_weights.h"

/* The place next to `wanted` in the cell that holds `xi`, both in cells. */
static PetscReal WithinCell(PetscReal xi, PetscReal wanted)
{
  const PetscReal cell = PetscFloorReal(xi);

  return PetscMin(PetscMax(wanted, cell), cell + 1.);
}

/* The point's own weights on each axis, at the group's nodes. */
static void OwnLines(const MpmTouched *at, PetscReal line[][MPM_MAX_WIDTH])
{
  for (PetscInt a = 0; a < at->space->dim; a++) MpmPointLine(at->space, at->point, a, at->group->count[a], 0., line[a]);
}

/* On one axis, the mean of the nodes' functions at `count` places xi, in cells; between edges. */
static void LineAt(const MpmTouched *at, PetscInt axis, PetscInt count, const PetscReal xi[], PetscReal line[])
{
  const PetscInt  dim   = at->space->dim;
  const PetscInt  shift = axis == dim - 1 ? MpmSpaceShift(at->space, at->points->domain.part, at->point) : 0;
  const PetscReal share = 1. / (PetscReal)count;
  PetscReal       weight[MPM_MAX_WIDTH], unused[MPM_MAX_WIDTH];
  MpmShapeLine    there = {.weight = weight, .gradient = unused};
  PetscInt        lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  MpmSpaceEdges(at->rules, &at->points->x[at->point * dim], lower, upper);
  for (PetscInt i = 0; i < at->group->count[axis]; i++) line[i] = 0.;
  for (PetscInt n = 0; n < count; n++) {
    const PetscReal inside = PetscMin(PetscMax(xi[n], (PetscReal)lower[axis]), (PetscReal)upper[axis]);

    MpmShapeEvaluate(MpmShapeSampled(at->rules->shape), at->rules->edge, inside, 0., lower[axis], upper[axis], &there);
    for (PetscInt i = 0; i < at->group->count[axis]; i++) {
      const PetscInt k = at->group->first[axis] + i - there.first - shift;

      if (k >= 0 && k < there.count) line[i] += share * weight[k];
    }
  }
}

/* Places of a line's functions, in cells, and their derivatives by the point's place and half-length. */
typedef struct {
  PetscInt  count;
  PetscReal xi[2], by_place[2], by_length[2];
} Places;

/* On one axis, the derivative of LineAt() with the places; 0 where one lies beyond an edge. */
static void SlopeAt(const MpmTouched *at, PetscInt axis, const Places *places, const PetscReal by[], PetscReal line[])
{
  const PetscInt  dim   = at->space->dim;
  const PetscInt  shift = axis == dim - 1 ? MpmSpaceShift(at->space, at->points->domain.part, at->point) : 0;
  const PetscReal share = 1. / (PetscReal)places->count;
  PetscReal       unused[MPM_MAX_WIDTH], gradient[MPM_MAX_WIDTH];
  MpmShapeLine    there = {.weight = unused, .gradient = gradient};
  PetscInt        lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

  MpmSpaceEdges(at->rules, &at->points->x[at->point * dim], lower, upper);
  for (PetscInt i = 0; i < at->group->count[axis]; i++) line[i] = 0.;
  for (PetscInt n = 0; n < places->count; n++) {
    const PetscReal xi = places->xi[n];

    if (xi < (PetscReal)lower[axis] || xi > (PetscReal)upper[axis]) continue;
    MpmShapeEvaluate(MpmShapeSampled(at->rules->shape), at->rules->edge, xi, 0., lower[axis], upper[axis], &there);
    for (PetscInt i = 0; i < at->group->count[axis]; i++) {
      const PetscInt k = at->group->first[axis] + i - there.first - shift;

      if (k >= 0 && k < there.count) line[i] += share * by[n] * gradient[k];
    }
  }
}

/*
  Weights of the face's centre instead of the point's: a traction does its work at the face. Shapes without a domain
  take the point, or the place next to the face's centre between the point's own nodes, which have its mass.
*/
static PetscErrorCode FacePlace(const MpmLoad *load, const MpmTouched *at, Places *places)
{
  const MpmGrid   *grid   = at->rules->grid;
  const MpmPoints *points = at->points;
  const PetscInt   axis = load->face_axis, k = at->point * grid->dim + axis;
  const PetscReal  centre = (points->x[k] - grid->lower[axis]) / grid->h[axis], side = (PetscReal)load->face_side;
  PetscReal        U[MPM_MAX_DIM], wanted;

  PetscFunctionBeginUser;
  PetscCheck(!at->rules->stretch(MpmPointF(points, at->point), U), PETSC_COMM_SELF, PETSC_ERR_FP,
             "point %" PetscInt_FMT " has no stretch", points->id[at->point]);
  wanted        = (points->x[k] - grid->lower[axis] + side * points->domain.half_length[k] * U[axis]) / grid->h[axis];
  places->count = 1;
  places->xi[0] = MpmShapeHasDomain(at->rules->shape) ? wanted : WithinCell(centre, wanted);
  places->by_place[0]  = places->xi[0] == wanted ? 1. / grid->h[axis] : 0.;
  places->by_length[0] = places->xi[0] == wanted ? side : 0.;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where a traction acts at the face's centre, not at the point. */
static PetscBool ActsAtFace(const MpmLoad *load, const MpmTouched *at)
{
  return (PetscBool)(MpmShapeHasDomain(at->rules->shape) || load->at_face);
}

PetscErrorCode MpmLoadFaceWeights(const MpmLoad *load, const MpmTouched *at, PetscReal weight[])
{
  PetscReal line[MPM_MAX_DIM][MPM_MAX_WIDTH];
  Places    places;

  PetscFunctionBeginUser;
  OwnLines(at, line);
  if (ActsAtFace(load, at)) {
    PetscCall(FacePlace(load, at, &places));
    LineAt(at, load->face_axis, places.count, places.xi, line[load->face_axis]);
  }
  MpmLinesMultiply(at->space->dim, at->group, line, weight);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* True where gravity acts on the points by EndWeights(). */
PetscBool MpmLoadActsAtEnds(const MpmLoad *load, const MpmRules *rules)
{
  return (PetscBool)(load->at_ends && !rules->dynamic);
}

/*
  On the axis most nearly along gravity, the mean of the functions at both ends of the point's domain, instead of that
  over it.

  The force of a stress sigma_p over a domain of the length 2l on a node is sigma_p (w(y + l) - w(y - l)) times the area
  across. Summed by parts over a column of domains with a stress linear in y, that is the trapezoidal rule for the
  integral of w d sigma/dy. With this rule for the weight, too, ground at rest, or with water that rises steadily, has
  exactly linear stress at its points. The mean over the domain is the integral itself, less by l^2/12 of w's slope at
  the material's ends: a pair of forces there, which bends the stress of the last rows. (For domains of `gimp` that lie
  in one cell both agree.)

  In motion mass and weight must agree, so that material falls as one. Scenes with inertia in any stage have the mean
  over the domain in all of them: ground at rest would move as its weight changed its nodes.
*/
static PetscErrorCode EndPlaces(const MpmLoad *load, const MpmTouched *at, PetscInt *axis, Places *places)
{
  const MpmGrid *grid = at->rules->grid;
  const PetscInt dim  = grid->dim;
  PetscReal      half[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCheck(MpmSpaceHalfLengths(at->rules, at->points, at->point, half), PETSC_COMM_SELF, PETSC_ERR_FP,
             "point %" PetscInt_FMT " has no stretch", at->points->id[at->point]);
  *axis = 0;
  for (PetscInt a = 1; a < dim; a++)
    if (PetscAbsReal(load->value[a]) > PetscAbsReal(load->value[*axis])) *axis = a;
  places->count = 2;
  for (PetscInt s = 0; s < 2; s++) {
    places->by_place[s]  = 1. / grid->h[*axis];
    places->by_length[s] = s ? 1. : -1.;
    places->xi[s] =
      (at->points->x[at->point * dim + *axis] - grid->lower[*axis]) / grid->h[*axis] + (s ? half[*axis] : -half[*axis]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadEndWeights(const MpmLoad *load, const MpmTouched *at, PetscReal weight[])
{
  PetscReal line[MPM_MAX_DIM][MPM_MAX_WIDTH];
  Places    places;
  PetscInt  axis;

  PetscFunctionBeginUser;
  PetscCall(EndPlaces(load, at, &axis, &places));
  OwnLines(at, line);
  LineAt(at, axis, places.count, places.xi, line[axis]);
  MpmLinesMultiply(at->space->dim, at->group, line, weight);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLoadWeightSlopes(const MpmLoad *load, const MpmPointSlopes *slopes, const MpmTouched *at,
                                   MpmSlopeKind kind, PetscInt along, PetscReal weight[])
{
  const PetscInt count = at->group->count[along];
  PetscReal      line[MPM_MAX_DIM][MPM_MAX_WIDTH];
  Places         places = {0};
  PetscInt       axis   = load->face_axis;

  PetscFunctionBeginUser;
  OwnLines(at, line);
  if (load->type != MPM_LOAD_TRACTION) PetscCall(EndPlaces(load, at, &axis, &places));
  else if (ActsAtFace(load, at)) PetscCall(FacePlace(load, at, &places));
  if (places.count && along != axis) LineAt(at, axis, places.count, places.xi, line[axis]);
  if (places.count && along == axis)
    SlopeAt(at, axis, &places, kind == MPM_BY_PLACE ? places.by_place : places.by_length, line[along]);
  else {
    for (PetscInt i = 0; i < count; i++) line[along][i] = MpmPointSlopesWeight(slopes, along, i, kind);
  }
  MpmLinesMultiply(at->space->dim, at->group, line, weight);
  PetscFunctionReturn(PETSC_SUCCESS);
}
