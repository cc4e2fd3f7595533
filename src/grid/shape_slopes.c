/*
  Derivatives of one-dimensional shape functions by the place x and the half-length l of the point's domain.

  With N the spline's functions and [x - l, x + l] the domain, S = 1/(2l) int N dr and its gradient G = 1/(2l) int N' dr
  = (N(x + l) - N(x - l))/(2l) have

    dG/dx = (N'(x + l) - N'(x - l))/(2l),    dS/dl = (N(x + l) + N(x - l))/(2l) - S/l,
    dG/dl = (N'(x + l) + N'(x - l))/(2l) - G/l.

  Without a domain G = N' of a spline is a polynomial of degree 2 at most, whose derivative the difference over a cell
  gives exactly; elements have their own formula.
*/
#include "talus/compat.h"
#include "grid/shape_element.h"

#include <math.h>

/* Shape, ends, and edges of a line. */
typedef struct {
  MpmShapeType type;
  MpmEdgeType  edge;
  PetscInt     lower, upper;
} Axis;

/* Middle of the first knot interval, and number of intervals between the edges. */
static PetscReal FirstMiddle(const Axis *axis, PetscInt *count)
{
  const PetscBool even = (PetscBool)(MpmShapeIsSpline(axis->type) && MpmShapeDegree(axis->type) % 2 == 0);

  *count = axis->upper - axis->lower + (even ? 1 : 0);
  return (PetscReal)axis->lower + (even ? 0. : 0.5);
}

/* The polynomials of the interval about `middle`, and their derivatives, at a place. */
static void Extend(const Axis *axis, PetscReal middle, PetscReal place, MpmShapeLine *there)
{
  if (MpmShapeDegree(axis->type) != 1) {
    MpmShapeExtend(axis->type, axis->edge, middle, place - middle, axis->lower, axis->upper, there);
    return;
  }
  there->first       = (PetscInt)floor(middle);
  there->count       = 2;
  there->weight[1]   = place - (PetscReal)there->first;
  there->weight[0]   = 1. - there->weight[1];
  there->gradient[0] = -1.;
  there->gradient[1] = 1.;
}

/* Adds a factor times values of one line to those of another. */
static void Add(const MpmShapeLine *there, const PetscReal values[], PetscReal factor, const MpmShapeLine *line,
                PetscReal sum[])
{
  for (PetscInt k = 0; k < there->count; k++) {
    const PetscInt i = there->first + k - line->first;

    if (i >= 0 && i < line->count) sum[i] += factor * values[k];
  }
}

void MpmShapeDifferentiate(MpmShapeType type, MpmEdgeType edge, const MpmShapePlace *at, const MpmShapeLine *line,
                           const MpmShapeSlopes *slopes)
{
  const Axis      axis = {type, edge, at->edge_lower, at->edge_upper};
  const PetscReal l = MpmShapeHasDomain(type) ? at->half_length : 0., xi = at->xi,
                  reach = l * (1. - 2. * MPM_SHAPE_TOUCH);
  PetscInt        count;
  const PetscReal start = FirstMiddle(&axis, &count);
  const PetscInt  here  = PetscClipInterval((PetscInt)floor(xi - start + 0.5), 0, count - 1);
  PetscInt        low = here, high = here;
  PetscReal       weight[MPM_MAX_WIDTH], gradient[MPM_MAX_WIDTH];
  MpmShapeLine    there = {.weight = weight, .gradient = gradient};

  for (PetscInt i = 0; i < line->count; i++)
    slopes->bend[i] = slopes->weight_by_length[i] = slopes->gradient_by_length[i] = 0.;
  if (l <= MPM_SHAPE_POINT && MpmShapeOrder(type) > 1) {
    MpmElementBend(MpmShapeOrder(type), xi, at->edge_lower, at->edge_upper, slopes->bend);
    return;
  }
  if (l <= MPM_SHAPE_POINT) {
    for (PetscInt end = -1; end <= 1; end += 2) {
      Extend(&axis, start + (PetscReal)here, xi + 0.5 * (PetscReal)end, &there);
      Add(&there, gradient, (PetscReal)end, line, slopes->bend);
    }
    return;
  }
  while (low > 0 && start + (PetscReal)low - 0.5 > xi - reach) low--;
  while (high < count - 1 && start + (PetscReal)high + 0.5 < xi + reach) high++;
  for (PetscInt end = -1; end <= 1; end += 2) {
    const PetscReal middle = start + (PetscReal)(end < 0 ? low : high), part = 0.5 / l;

    Extend(&axis, middle, xi + (PetscReal)end * l, &there);
    Add(&there, gradient, (PetscReal)end * part, line, slopes->bend);
    Add(&there, weight, part, line, slopes->weight_by_length);
    Add(&there, gradient, part, line, slopes->gradient_by_length);
  }
  for (PetscInt i = 0; i < line->count; i++) {
    slopes->weight_by_length[i] -= line->weight[i] / l;
    slopes->gradient_by_length[i] -= line->gradient[i] / l;
  }
}
