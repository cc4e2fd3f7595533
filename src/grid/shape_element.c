/*
  One-dimensional functions of Lagrange elements, sampled at the point or averaged over its domain.

  An element of order p has p + 1 nodes in each cell, at the Gauss-Lobatto points (grid/grid.h). With t the place from
  the middle of the cell, in cells, node i has

    N_i(t) = sum_j c_ij t^j ,    j = 0 to p.

  A segment of a domain of length s about m, a fraction f of the domain, adds f times the means of powers over it,

    1,  m,  m^2 + s^2/12,  m^3 + m s^2/4,  m^4 + m^2 s^2/2 + s^4/80 ,

  summed with c_ij for the weight, and with c_ij and the derivatives of the powers for the gradient. Both are exact, for
  any s, without a difference of nearly equal numbers. A domain that several cells share has a segment in each. Sampled
  functions have m = t and s = 0.

  Source of the elements: Karniadakis and Sherwin (2005), Spectral/hp Element Methods, 2.3; the mean over domains as in
  shape.c.
*/
#include "talus/compat.h"
#include "grid/shape_element.h"

#include <math.h>

#define MOST 4 /* order */

/* c_ij by order - 2; x^2 = 1/5 and 3/7 at the inner nodes of orders 3 and 4, in half cells. */
#define ROOT5  2.23606797749978969641
#define ROOT21 4.58257569495584000659
static const PetscReal coefficient[MOST - 1][MOST + 1][MOST + 1] = {
  {{0., -1., 2.}, {1., 0., -4.}, {0., 1., 2.}},
  {{-0.125, 0.25, 2.5, -5.},
   {0.625, -1.25 * ROOT5, -2.5, 5. * ROOT5},
   {0.625, 1.25 * ROOT5, -2.5, -5. * ROOT5},
   {-0.125, -0.25, 2.5, 5.}},
  {{0., 0.75, -1.5, -7., 14.},
   {0., -7. * ROOT21 / 12., 49. / 6., 7. * ROOT21 / 3., -98. / 3.},
   {1., 0., -40. / 3., 0., 112. / 3.},
   {0., 7. * ROOT21 / 12., 49. / 6., -7. * ROOT21 / 3., -98. / 3.},
   {0., -0.75, -1.5, 7., 14.}},
};

/* Means of the powers 0 to 4 of t over a segment of length s about m. */
MPM_INLINE void Powers(PetscReal m, PetscReal s, PetscReal power[])
{
  const PetscReal mm = m * m, ss = s * s;

  power[0] = 1.;
  power[1] = m;
  power[2] = mm + ss / 12.;
  power[3] = m * (mm + 0.25 * ss);
  power[4] = mm * (mm + 0.5 * ss) + ss * ss / 80.;
}

/* Adds fraction f of the domain, a segment of length s about t, to the nodes of its cell. */
MPM_INLINE void AddSegment(PetscInt order, PetscReal t, PetscReal s, PetscReal f, PetscReal w[], PetscReal g[])
{
  PetscReal power[MOST + 1];

  Powers(t, s, power);
  for (PetscInt i = 0; i <= order; i++) {
    const PetscReal *c      = coefficient[order - 2][i];
    PetscReal        weight = c[0], gradient = 0.;

    for (PetscInt j = 1; j <= order; j++) {
      weight += c[j] * power[j];
      gradient += c[j] * (PetscReal)j * power[j - 1];
    }
    w[i] += f * weight;
    g[i] += f * gradient;
  }
}

/* The cell of a place; one on a face belongs to the cell above, except on the upper edge. */
static inline PetscInt CellOf(PetscReal xi, PetscInt lower, PetscInt upper)
{
  return PetscClipInterval((PetscInt)floor(xi), lower, upper - 1);
}

/* Place from the middle of the cell, away from faces by a rounding error: no node has a gradient without a weight. */
static inline PetscReal Inside(PetscReal t, PetscBool lower, PetscBool upper)
{
  if (lower) t = PetscMax(t, MPM_SHAPE_INSIDE - 0.5);
  if (upper) t = PetscMin(t, 0.5 - MPM_SHAPE_INSIDE);
  return t;
}

/* A cell with a point at t from its middle, and the edges about it, vertices. */
typedef struct {
  PetscInt  cell, lower, upper;
  PetscReal t, touch; /* touch: overlaps that do not count, as a part of the domain */
} Place;

/* Averages over [-l, l] about a point; cells that the domain only grazes do not count (shape.c). Returns the nodes. */
MPM_INLINE PetscInt AddDomain(PetscInt order, Place at, PetscReal l, PetscInt *first, PetscReal w[], PetscReal g[])
{
  const PetscReal inverse = 0.5 / l, reach = l - 2. * l * at.touch, face = -0.5 - at.t; /* lower face, from the point */
  PetscInt        low = 0, high = 0, count;
  PetscReal       from = -l;

  while (at.cell + low > at.lower && face + (PetscReal)low > -reach) low--;
  while (at.cell + high < at.upper - 1 && face + (PetscReal)(high + 1) < reach) high++;
  *first = (at.cell + low) * order;
  count  = (high - low + 1) * order + 1;
  for (PetscInt k = 0; k < count; k++) w[k] = g[k] = 0.;
  for (PetscInt j = low; j <= high; j++) {
    const PetscReal to = j == high ? l : face + (PetscReal)(j + 1);

    AddSegment(order, at.t - (PetscReal)j + 0.5 * (from + to), to - from, (to - from) * inverse, &w[(j - low) * order],
               &g[(j - low) * order]);
    from = to;
  }
  return count;
}

/* Of one order, which is a constant here. */
MPM_INLINE void EvaluateAll(PetscInt order, PetscBool domain, PetscInt count, const MpmShapePlaces *at,
                            const MpmShapeLines *lines)
{
  const PetscInt width = lines->width;

  for (PetscInt k = 0; k < count; k++) {
    const PetscInt  lower = at->edge_lower[k], upper = at->edge_upper[k], c = CellOf(at->xi[k], lower, upper);
    const PetscReal l     = domain ? at->half_length[k] : 0.;
    const PetscBool point = (PetscBool) !(l > MPM_SHAPE_POINT);
    const PetscReal t =
      Inside(at->xi[k] - (PetscReal)c - 0.5, (PetscBool)(point || c == lower), (PetscBool)(c == upper - 1));
    const Place here = {c, lower, upper, t, at->touch};
    PetscReal  *w = &lines->weight[k * width], *g = &lines->gradient[k * width];

    if (point) {
      lines->first[k] = c * order;
      lines->count[k] = order + 1;
      for (PetscInt i = 0; i <= order; i++) w[i] = g[i] = 0.;
      AddSegment(order, here.t, 0., 1., w, g);
    } else lines->count[k] = AddDomain(order, here, l, &lines->first[k], w, g);
    for (PetscInt i = lines->count[k]; i < width; i++) g[i] = 0.;
  }
}

void MpmElementEvaluateAll(PetscInt order, PetscBool domain, PetscInt count, const MpmShapePlaces *at,
                           const MpmShapeLines *lines)
{
  if (order == 2) EvaluateAll(2, domain, count, at, lines);
  else if (order == 3) EvaluateAll(3, domain, count, at, lines);
  else EvaluateAll(4, domain, count, at, lines);
}

void MpmElementExtend(PetscInt order, PetscReal xi, PetscReal by, PetscInt edge_lower, PetscInt edge_upper,
                      MpmShapeLine *line)
{
  const PetscInt c = CellOf(xi, edge_lower, edge_upper);

  line->first = c * order;
  line->count = order + 1;
  for (PetscInt i = 0; i <= order; i++) line->weight[i] = line->gradient[i] = 0.;
  AddSegment(order, xi - (PetscReal)c - 0.5 + by, 0., 1., line->weight, line->gradient);
}

void MpmElementBend(PetscInt order, PetscReal xi, PetscInt edge_lower, PetscInt edge_upper, PetscReal bend[])
{
  PetscReal power[MOST + 1];

  Powers(xi - (PetscReal)CellOf(xi, edge_lower, edge_upper) - 0.5, 0., power);
  for (PetscInt i = 0; i <= order; i++) {
    bend[i] = 0.;
    for (PetscInt j = 2; j <= order; j++)
      bend[i] += coefficient[order - 2][i][j] * (PetscReal)(j * (j - 1)) * power[j - 2];
  }
}

void MpmElementMean(PetscInt order, PetscReal weight[])
{
  PetscReal unused[MOST + 1] = {0.};

  for (PetscInt i = 0; i <= order; i++) weight[i] = 0.;
  AddSegment(order, 0., 1., 1., weight, unused);
}

void MpmElementDerivatives(PetscInt order, PetscInt k, PetscReal t, PetscReal value[])
{
  for (PetscInt i = 0; i <= order; i++) {
    PetscReal power = 1.;

    value[i] = 0.;
    for (PetscInt j = k; j <= order; j++, power *= t) {
      PetscReal factor = 1.;

      for (PetscInt m = 0; m < k; m++) factor *= (PetscReal)(j - m);
      value[i] += coefficient[order - 2][i][j] * factor * power;
    }
  }
}

void MpmElementMass(PetscInt order, PetscReal mass[])
{
  for (PetscInt k = 0; k < (order + 1) * (order + 1); k++) {
    const PetscReal *a = coefficient[order - 2][k / (order + 1)], *b = coefficient[order - 2][k % (order + 1)];

    mass[k] = 0.;
    for (PetscInt i = 0; i <= order; i++) /* the mean of t^m is 0, or 2^-m/(m + 1) for even m */
      for (PetscInt j = i % 2; j <= order; j += 2)
        mass[k] += a[i] * b[j] / ((PetscReal)(i + j + 1) * (PetscReal)(1 << (i + j)));
  }
}
