/*
  Means of shape functions over cells.

    mean_i = sum_c f_c (1/h) int_c N_i dx ,   f_c the fraction of the point's domain in cell c

  A spline of degree 3 at most, with knots at the ends or in the middle of a cell, is integrated exactly by two Gauss
  points in each half; elements have their own formula.
*/
#include <math.h>
#include "grid/shape_element.h"

/*
  Adds a node's share. Nodes that the point does not touch have the value that those which it does touch extend to
  linearly: no node gets an unknown by its mean alone, and means of linear fields stay what they are.
*/
static void AddNode(const MpmShapeLine *line, PetscInt node, PetscReal share)
{
  PetscReal     *mean = line->mean;
  const PetscInt k = node - line->first, last = line->count - 1;

  if (k >= 0 && k <= last) mean[k] += share;
  else if (!last) mean[0] += share;
  else if (k < 0) {
    mean[0] += share * (1. - (PetscReal)k);
    mean[1] += share * (PetscReal)k;
  } else {
    mean[last] += share * (1. + (PetscReal)(k - last));
    mean[last - 1] -= share * (PetscReal)(k - last);
  }
}

void MpmShapeCells(PetscReal xi, PetscReal half_length, PetscInt edge_lower, PetscInt edge_upper, PetscInt *low,
                   PetscInt *high)
{
  const PetscReal reach = half_length * (1. - 2. * MPM_SHAPE_TOUCH);

  *low  = PetscClipInterval((PetscInt)floor(xi - reach), edge_lower, edge_upper - 1);
  *high = PetscClipInterval((PetscInt)ceil(xi + reach) - 1, *low, edge_upper - 1);
  if (half_length <= MPM_SHAPE_POINT) *high = *low;
}

/* A shape, ends and edges of its line. */
typedef struct {
  MpmShapeType type;
  MpmEdgeType  edge;
  PetscInt     lower, upper;
} Axis;

/* Adds `part` times the means over cell c. */
static void AddCell(const Axis *axis, PetscInt c, PetscReal part, const MpmShapeLine *line)
{
  const PetscInt  degree = MpmShapeDegree(axis->type), order = MpmShapeOrder(axis->type);
  const PetscReal gauss = 0.25 / PetscSqrtReal(3.);

  if (degree == 1) {
    AddNode(line, c, 0.5 * part);
    AddNode(line, c + 1, 0.5 * part);
    return;
  }
  if (order > 1) {
    PetscReal mean[MPM_MAX_WIDTH];

    MpmElementMean(order, mean);
    for (PetscInt k = 0; k <= order; k++) AddNode(line, c * order + k, part * mean[k]);
    return;
  }
  for (PetscInt q = 0; q < 4; q++) {
    const PetscReal at = (PetscReal)c + (q < 2 ? 0.25 : 0.75) + (q % 2 ? gauss : -gauss);
    PetscReal       weight[4], unused[4];
    MpmShapeLine    here = {.weight = weight, .gradient = unused};

    MpmShapeEvaluate(MpmShapeSampled(axis->type), axis->edge, at, 0., axis->lower, axis->upper, &here);
    for (PetscInt k = 0; k < here.count; k++) AddNode(line, here.first + k, 0.25 * part * weight[k]);
  }
}

void MpmShapeMean(MpmShapeType type, MpmEdgeType edge, PetscReal xi, PetscReal half_length, PetscInt edge_lower,
                  PetscInt edge_upper, const MpmShapeLine *line)
{
  const Axis      axis = {type, edge, edge_lower, edge_upper};
  const PetscReal l    = MpmShapeHasDomain(type) ? half_length : 0.;
  PetscInt        low, high;

  MpmShapeCells(xi, l, edge_lower, edge_upper, &low, &high);
  for (PetscInt k = 0; k < line->count; k++) line->mean[k] = 0.;
  for (PetscInt c = low; c <= high; c++) AddCell(&axis, c, MpmShapePart(c, low, high, xi, l, NULL), line);
}

void MpmShapeMeanSlopes(MpmShapeType type, MpmEdgeType edge, const MpmShapePlace *at, const MpmShapeLine *line,
                        PetscReal by_place[], PetscReal by_length[])
{
  const Axis      axis = {type, edge, at->edge_lower, at->edge_upper};
  const PetscReal l    = MpmShapeHasDomain(type) ? at->half_length : 0.;
  MpmShapeLine    by[] = {*line, *line};
  PetscInt        low, high;

  by[0].mean = by_place;
  by[1].mean = by_length;
  MpmShapeCells(at->xi, l, at->edge_lower, at->edge_upper, &low, &high);
  for (PetscInt k = 0; k < line->count; k++) by_place[k] = by_length[k] = 0.;
  for (PetscInt c = low; c <= high; c++) {
    PetscReal slope[2];

    (void)MpmShapePart(c, low, high, at->xi, l, slope);
    for (int k = 0; k < 2; k++) AddCell(&axis, c, slope[k], &by[k]);
  }
}
