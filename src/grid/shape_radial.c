/*
  Derivatives by the radius with axial symmetry.

  A domain has more volume the farther out. Averaged by that, the derivative at a point of radius r is

    1/(2 l r) int s N'(s) ds = 1/(2l) int N' ds + ((N(r + l) + N(r - l))/2 - S)/r ,    s from r - l to r + l,

  with S the average of N itself. A uniform stress is then in balance whatever the domains, for the forces s N' + N are
  the derivative of s N; linear fields keep their gradients. All in cells.

  Source: Nairn and Guilkey (2015), Int. J. Numer. Meth. Eng. 101, 127-147, doi:10.1002/nme.4792.
*/
#include "grid/shape.h"

void MpmShapeAverageByVolume(MpmShapeType type, MpmEdgeType edge, const MpmRadialPlace *at, const MpmShapeLine *line)
{
  const MpmShapeType plain = MpmShapeDegree(type) == 1 ? MPM_SHAPE_LINEAR : MPM_SHAPE_BSPLINE2; /* without domains */
  PetscReal          weight[4], gradient[4];

  if (!MpmShapeHasDomain(type) || !(at->half_length > MPM_SHAPE_POINT) || !(at->radius > 0.)) return;
  for (PetscInt i = 0; i < line->count; i++) line->gradient[i] -= line->weight[i] / at->radius;
  for (PetscInt side = -1; side <= 1; side += 2) {
    MpmShapeLine end = {.weight = weight, .gradient = gradient};

    MpmShapeEvaluate(plain, edge, at->xi + (PetscReal)side * at->half_length, 0., at->edge_lower, at->edge_upper, &end);
    for (PetscInt i = 0; i < end.count; i++) {
      const PetscInt place = end.first + i - line->first;

      if (place >= 0 && place < line->count) line->gradient[place] += 0.5 * weight[i] / at->radius;
    }
  }
}
