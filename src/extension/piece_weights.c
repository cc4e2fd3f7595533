/*
  Extension of a piece's polynomial to nodes beyond it (extension.c has the equations).
*/
#include "grid/grid.h"
#include "grid/shape.h"
#include "grid/shape_element.h"
#include "extension/pieces.h"

PetscReal MpmPiecePlace(MpmKnots knots, PetscInt node)
{
  return knots.order > 1 ? MpmCellNodes(knots.order)[node % knots.order] : 0.;
}

/*
  MpmPieceWeights() in an element beyond which a node stands `away` cells from the lower face: the parabola through the
  vertices and the middle up to a cell beyond, and the line through the vertices further away.
*/
static void ElementWeights(PetscInt order, PetscReal away, PetscReal weight[])
{
  const PetscBool near = (PetscBool)(away >= -1. && away <= 2.);
  const PetscReal bend = near ? 4. * away * (1. - away) : 0.; /* 1 in the middle, 0 at the vertices */

  if (near) MpmElementDerivatives(order, 0, 0., weight); /* values in the middle */
  for (PetscInt k = 0; k <= order; k++) weight[k] *= bend;
  weight[0] += 1. - away - 0.5 * bend;
  weight[order] += away - 0.5 * bend;
}

void MpmPieceWeights(const MpmPieceLine *line, MpmKnots knots, PetscInt node, PetscReal weight[])
{
  const PetscInt degree = knots.degree;
  const PetscInt inside = line->edge == MPM_EDGE_OPEN ? 1 : 0; /* the first node that stands for itself */

  for (PetscInt k = 0; k <= line->high - line->low; k++) weight[k] = 0.;
  if (node >= line->low && node <= line->high) {
    weight[node - line->low] = 1.;
    return;
  }
  if (knots.order > 1) {
    ElementWeights(knots.order,
                   (PetscReal)(MpmPieceOfNode(knots, node) - MpmPieceOfNode(knots, line->first)) +
                     MpmPiecePlace(knots, node),
                   weight);
    return;
  }
  for (PetscInt k = 0; k <= degree; k++) {
    const PetscInt  at   = line->first + k;
    const PetscInt  step = at < line->lower + inside ? 1 : at > line->upper - inside ? -1 : 0;
    const PetscInt  edge = step > 0 ? line->lower : line->upper;
    const PetscInt  from = node < line->low ? 0 : degree - 1; /* of the two nodes that the extension takes */
    const PetscInt  away = node - line->first - from;
    const PetscReal L    = k == from ? 1. - (PetscReal)away : k == from + 1 ? (PetscReal)away : 0.;

    if (!step) weight[at - line->low] += L;
    for (PetscInt j = 0; step && j <= degree; j++) {
      const PetscReal part = MpmEdgeCoefficient(line->edge, degree, PetscAbsInt(edge - at), j);

      if (part != 0.) weight[edge + step * j - line->low] += part * L;
    }
  }
}
