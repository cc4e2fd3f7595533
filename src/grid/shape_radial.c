/*
  Derivatives by the radius with axial symmetry.

  A domain has more volume the farther out. Averaged by that, the derivative at a point of radius r is

    1/(2 l r) int s N'(s) ds = 1/(2l) int N' ds + ((N(r + l) + N(r - l))/2 - S)/r ,    s from r - l to r + l,

  with S the average of N itself. A uniform stress is then in balance whatever the domains, for the forces s N' + N are
  the derivative of s N; linear fields keep their gradients. All in cells.

  Source: Nairn and Guilkey (2015), Int. J. Numer. Meth. Eng. 101, 127-147, doi:10.1002/nme.4792.
*/
#include "grid/shape.h"

/* True where the derivative differs from that over the length. */
static PetscBool IsAveraged(MpmShapeType type, const MpmRadialPlace *at)
{
  return (PetscBool)(MpmShapeHasDomain(type) && at->half_length > MPM_SHAPE_POINT && at->radius > 0.);
}

/* Adds factors times N and N' at one end of the domain, -1 or 1, over the radius. */
static void AddEnd(MpmShapeType type, MpmEdgeType edge, const MpmRadialPlace *at, PetscInt side,
                   const PetscReal factor[2], const MpmShapeLine *line, PetscReal sum[])
{
  PetscReal    weight[MPM_MAX_WIDTH], gradient[MPM_MAX_WIDTH];
  MpmShapeLine end = {.weight = weight, .gradient = gradient};

  MpmShapeEvaluate(MpmShapeSampled(type), edge, at->xi + (PetscReal)side * at->half_length, 0., at->edge_lower,
                   at->edge_upper, &end);
  for (PetscInt i = 0; i < end.count; i++) {
    const PetscInt place = end.first + i - line->first;

    if (place >= 0 && place < line->count) sum[place] += (factor[0] * weight[i] + factor[1] * gradient[i]) / at->radius;
  }
}

/* Adds the part that comes with the volume, times a factor, to gradients. */
static void Add(MpmShapeType type, MpmEdgeType edge, const MpmRadialPlace *at, PetscReal factor,
                const MpmShapeLine *line)
{
  for (PetscInt i = 0; i < line->count; i++) line->gradient[i] -= factor * line->weight[i] / at->radius;
  for (PetscInt side = -1; side <= 1; side += 2)
    AddEnd(type, edge, at, side, (PetscReal[]){0.5 * factor, 0.}, line, line->gradient);
}

void MpmShapeAverageByVolume(MpmShapeType type, MpmEdgeType edge, const MpmRadialPlace *at, const MpmShapeLine *line)
{
  if (IsAveraged(type, at)) Add(type, edge, at, 1., line);
}

void MpmShapeAverageByLength(MpmShapeType type, MpmEdgeType edge, const MpmRadialPlace *at, const MpmShapeLine *line)
{
  if (IsAveraged(type, at)) Add(type, edge, at, -1., line);
}

/*
  With r the radius and G = S' the gradient over the length, ((N+ + N-)/2 - S)/r has the derivatives

    by r    ((N+' + N-')/2 - G)/r - ((N+ + N-)/2 - S)/r^2
    by l    ((N+' - N-')/2 - dS/dl)/r
*/
void MpmShapeVolumeSlopes(MpmShapeType type, MpmEdgeType edge, const MpmRadialPlace *at, const MpmShapeLine *line,
                          const MpmShapeSlopes *slopes)
{
  if (!IsAveraged(type, at)) return;
  for (PetscInt i = 0; i < line->count; i++) {
    slopes->bend[i] -= (line->gradient[i] - line->weight[i] / at->radius) / at->radius;
    slopes->gradient_by_length[i] -= slopes->weight_by_length[i] / at->radius;
  }
  for (PetscInt side = -1; side <= 1; side += 2) {
    AddEnd(type, edge, at, side, (PetscReal[]){-0.5 / at->radius, 0.5}, line, slopes->bend);
    AddEnd(type, edge, at, side, (PetscReal[]){0., 0.5 * (PetscReal)side}, line, slopes->gradient_by_length);
  }
}
