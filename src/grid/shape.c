/*
  One-dimensional shape functions of material points; grid/shape.h says what they are.

  With B the cardinal B-spline of degree p centred at a node and [x - l, x + l] the point's domain,

    S_i = 1/(2l) int_{x-l}^{x+l} B(r - i) dr,    dS_i/dx = 1/(2l) int_{x-l}^{x+l} B'(r - i) dr.

  The knots of B (integers for odd p, half-integers for even p) split the domain into segments on each of which B is one
  polynomial. A segment of length s about m, a fraction f = s/(2l) of the domain, contributes

    f (B(m - i) + B''(m - i) s^2/24)   and   f B'(m - i),

  which is exact up to p = 2. On each interval the p + 1 polynomials sum to one, their derivatives to zero, and their
  first moment is m, so partition of unity and linear reproduction hold segment by segment.

  Everything is measured from the point, not from the origin: knot distances are then exact to rounding and domains of
  1e-16 cells keep their fractions.

  At an edge the nodes beyond do not exist. Their coefficients extend the others linearly, which makes a quadratic or
  cubic spline's second derivative zero there, or the edge is open: the knot next to it is left out ("not a knot"), and
  the spline is any polynomial of its degree up to the edge.

  Sources: Bardenhagen & Kober (2004), CMES 5, 477 (the domain average); Charlton, Coombs & Augarde (2017), Comput.
  Struct. 190, 108 (contiguous domains); Steffen, Kirby & Berzins (2008), Int. J. Numer. Meth. Eng. 76, 922 (B-splines
  in MPM); de Boor (1978), A Practical Guide to Splines, IV (not a knot).
*/
#include "talus/compat.h"
#include "grid/shape_element.h"

#include <math.h>

const char *const MpmShapeTypes[] = {"linear", "gimp", "bspline2", "bspline3", "gimp_bspline2", NULL};
const char *const MpmEdgeTypes[]  = {"linear", "open", NULL};
const char *const MpmShapeWords[] = {"linear",        "gimp",    "bspline2",     "bspline3",
                                     "gimp_bspline2", "element", "gimp_element", NULL};

/* Properties of a shape. */
typedef struct {
  const char  *name;
  PetscInt     degree, order;
  PetscBool    domain;
  MpmShapeType sampled;
} Shape;
static const Shape shapes[] = {
  [MPM_SHAPE_LINEAR]        = {"linear", 1, 1, PETSC_FALSE, MPM_SHAPE_LINEAR},
  [MPM_SHAPE_GIMP]          = {"gimp", 1, 1, PETSC_TRUE, MPM_SHAPE_LINEAR},
  [MPM_SHAPE_BSPLINE2]      = {"bspline2", 2, 1, PETSC_FALSE, MPM_SHAPE_BSPLINE2},
  [MPM_SHAPE_BSPLINE3]      = {"bspline3", 3, 1, PETSC_FALSE, MPM_SHAPE_BSPLINE3},
  [MPM_SHAPE_GIMP_BSPLINE2] = {"gimp_bspline2", 2, 1, PETSC_TRUE, MPM_SHAPE_BSPLINE2},
  [MPM_SHAPE_ELEMENT2]      = {"element of order 2", 2, 2, PETSC_FALSE, MPM_SHAPE_ELEMENT2},
  [MPM_SHAPE_ELEMENT3]      = {"element of order 3", 3, 3, PETSC_FALSE, MPM_SHAPE_ELEMENT3},
  [MPM_SHAPE_ELEMENT4]      = {"element of order 4", 4, 4, PETSC_FALSE, MPM_SHAPE_ELEMENT4},
  [MPM_SHAPE_GIMP_ELEMENT2] = {"gimp_element of order 2", 2, 2, PETSC_TRUE, MPM_SHAPE_ELEMENT2},
  [MPM_SHAPE_GIMP_ELEMENT3] = {"gimp_element of order 3", 3, 3, PETSC_TRUE, MPM_SHAPE_ELEMENT3},
  [MPM_SHAPE_GIMP_ELEMENT4] = {"gimp_element of order 4", 4, 4, PETSC_TRUE, MPM_SHAPE_ELEMENT4},
};

/* The point's knot interval: B-splines are polynomials of `local` while it stays between `offset` and `offset` + 1. */
typedef struct {
  PetscInt  index;        /* interval [index + offset, index + offset + 1] */
  PetscInt  lower, upper; /* first and last interval between the edges */
  PetscReal offset;       /* 0 for knots at the nodes, -1/2 for knots between them */
  PetscReal local;        /* position from node `index` */
  PetscReal touch;        /* overlaps that do not count, as a part of the domain */
} Interval;

PetscBool MpmShapeHasDomain(MpmShapeType type)
{
  return shapes[type].domain;
}

PetscInt MpmShapeDegree(MpmShapeType type)
{
  return shapes[type].degree;
}

PetscInt MpmShapeOrder(MpmShapeType type)
{
  return shapes[type].order;
}

PetscReal MpmShapeSpacing(MpmShapeType type, PetscReal spacing)
{
  const PetscReal scaled = 0.5 * (PetscReal)(shapes[type].order + 1) * spacing;

  if (shapes[type].order == 1) return spacing;
  return scaled > 0.5 * (1. + MPM_TOLERANCE) ? PetscMax(scaled, 1.) : scaled;
}

MpmShapeType MpmShapeSampled(MpmShapeType type)
{
  return shapes[type].sampled;
}

const char *MpmShapeName(MpmShapeType type)
{
  return shapes[type].name;
}

PetscBool MpmShapeWordIsElement(PetscInt word)
{
  return (PetscBool)(word >= MPM_SHAPE_COUNT);
}

MpmShapeType MpmShapeOfWord(PetscInt word, PetscInt order)
{
  const PetscBool domain = (PetscBool)(word > MPM_SHAPE_COUNT);

  if (!MpmShapeWordIsElement(word)) return (MpmShapeType)word;
  if (order == 1) return domain ? MPM_SHAPE_GIMP : MPM_SHAPE_LINEAR;
  return (MpmShapeType)((domain ? MPM_SHAPE_GIMP_ELEMENT2 : MPM_SHAPE_ELEMENT2) + order - 2);
}

MpmShapeType MpmShapeOfDegree(MpmShapeType type, PetscInt degree)
{
  const PetscBool domain = MpmShapeHasDomain(type);

  if (degree == 3) return MPM_SHAPE_BSPLINE3;
  if (degree == 2) return domain ? MPM_SHAPE_GIMP_BSPLINE2 : MPM_SHAPE_BSPLINE2;
  return domain ? MPM_SHAPE_GIMP : MPM_SHAPE_LINEAR;
}

PetscInt MpmShapeWidth(MpmShapeType type, PetscReal half_length)
{
  const PetscInt degree = MpmShapeDegree(type);

  /* A domain of length 2l meets at most ceil(2l) + 1 knot intervals, an interval meets p + 1 nodes, and the next one
     adds one node, or those of a cell. */
  if (!MpmShapeHasDomain(type)) return degree + 1;
  return degree + 1 + MpmShapeOrder(type) * (PetscInt)ceil(2. * half_length);
}

/*
  A point on a knot belongs to the interval above it, except on the upper edge. The interval at an edge is taken to
  reach beyond it: a domain that sticks out by rounding then touches no node that the edge does not already have.
*/
static inline Interval Locate(PetscInt degree, PetscReal xi, PetscInt edge_lower, PetscInt edge_upper)
{
  Interval at;

  at.offset = (degree % 2) ? 0. : -0.5;
  at.lower  = edge_lower;
  at.upper  = (degree % 2) ? edge_upper - 1 : edge_upper;
  at.index  = (PetscInt)floor(xi - at.offset);
  if (at.index < at.lower) at.index = at.lower;
  if (at.index > at.upper) at.index = at.upper;
  at.local = xi - (PetscReal)at.index;
  return at;
}

/*
  Adds fraction f of the domain, of length s about t, to the p + 1 nodes of its interval; t counts from the node the
  interval is named after. A function of the cardinal B-spline's polynomial pieces, see de Boor (1978), A Practical
  Guide to Splines.
*/
MPM_INLINE void AddSegment(PetscInt degree, PetscReal t, PetscReal s, PetscReal f, PetscReal w[], PetscReal g[])
{
  if (degree == 1) {
    w[0] += f * (1. - t);
    w[1] += f * t;
    g[0] -= f;
    g[1] += f;
  } else if (degree == 2) {
    const PetscReal below = 0.5 - t, above = 0.5 + t, bend = s * s / 24.;

    w[0] += f * (0.5 * below * below + bend);
    w[1] += f * (0.75 - t * t - 2. * bend);
    w[2] += f * (0.5 * above * above + bend);
    g[0] -= f * below;
    g[1] -= f * 2. * t;
    g[2] += f * above;
  } else {
    const PetscReal r = 1. - t, tt = t * t, rr = r * r;

    w[0] += f * (rr * r / 6.);
    w[1] += f * ((4. - 6. * tt + 3. * tt * t) / 6.);
    w[2] += f * ((4. - 6. * rr + 3. * rr * r) / 6.);
    w[3] += f * (tt * t / 6.);
    g[0] -= f * 0.5 * rr;
    g[1] += f * (1.5 * tt - 2. * t);
    g[2] += f * (2. * r - 1.5 * rr);
    g[3] += f * 0.5 * tt;
  }
}

/* Adds the means over its whole interval instead. */
static inline void AddPiece(PetscInt degree, PetscReal f, PetscReal w[], PetscReal g[])
{
  static const PetscReal weight[3][4] = {
    {0.5, 0.5}, {1. / 6., 2. / 3., 1. / 6.}, {1. / 24., 11. / 24., 11. / 24., 1. / 24.}};
  static const PetscReal gradient[3][4] = {{-1., 1.}, {-0.5, 0., 0.5}, {-1. / 6., -0.5, 0.5, 1. / 6.}};

  for (PetscInt k = 0; k <= degree; k++) {
    w[k] += f * weight[degree - 1][k];
    g[k] += f * gradient[degree - 1][k];
  }
}

/* Contribution of a segment: of the polynomials there, or, for `whole`, of their means over the interval. */
MPM_INLINE void AddPart(PetscInt degree, PetscBool whole, PetscReal t, PetscReal s, PetscReal f, PetscReal w[],
                        PetscReal g[])
{
  if (whole) AddPiece(degree, f, w, g);
  else AddSegment(degree, t, s, f, w, g);
}

/*
  Averages over [-l, l] about the point; returns the number of nodes from *first on that were filled. An interval that
  the domain enters by less than `touch` of its length does not count: the interval before it is taken to reach
  that far, as at an edge. A body whose faces lie on cell faces would otherwise, by rounding, touch nodes that have no
  stiffness.
*/
MPM_INLINE PetscInt AddDomain(PetscInt degree, PetscBool whole, Interval at, PetscReal l, PetscInt *first,
                              PetscReal w[], PetscReal g[])
{
  const PetscReal inverse = 0.5 / l, reach = l - 2. * l * at.touch;
  const PetscReal knot = at.offset - at.local; /* distance from the point to the lower end of its interval */
  PetscInt        low = 0, high = 0, count;
  PetscReal       from = -l, weight[3] = {0.}, slope[3] = {0.}; /* of the nodes that the next interval meets, too */

  while (at.index + low > at.lower && knot + (PetscReal)low > -reach) low--;
  while (at.index + high < at.upper && knot + (PetscReal)(high + 1) < reach) high++;
  *first = at.index + low - degree / 2;
  count  = high - low + degree + 1;
  for (PetscInt j = low; j <= high; j++) {
    const PetscReal to = (j == high) ? l : knot + (PetscReal)(j + 1);
    const PetscReal t = at.local - (PetscReal)j + 0.5 * (from + to), f = (to - from) * inverse;

    AddPart(degree, whole, t, to - from, f, weight, slope);
    w[j - low] = weight[0];
    g[j - low] = slope[0];
    for (PetscInt i = 0; i < degree; i++) {
      weight[i] = weight[i + 1];
      slope[i]  = slope[i + 1];
    }
    weight[degree] = slope[degree] = 0.;
    from                           = to;
  }
  for (PetscInt i = 0; i < degree; i++) {
    w[count - degree + i] = weight[i];
    g[count - degree + i] = slope[i];
  }
  return count;
}

/*
  Coefficients at a not-a-knot end of the nodes one beyond it and on it, from the edge's value and the p nodes after it:
  the (p + 1)-th difference over the nodes from the one beyond vanishes, which removes the knot next to the edge, and
  the edge node has the spline's value there. By p - 2, then beyond and on.
*/
static const PetscReal open_edge[2][2][4] = {
  {{8. / 3., -7. / 3., 2. / 3.}, {8. / 9., 2. / 9., -1. / 9.}},
  {{3., -3.5, 2., -0.5}, {0.75, 0.625, -0.5, 0.125}},
};

/*
  Gives `outer`, what the node beyond an edge has, and at a not-a-knot end what the edge's node has, to the edge's node,
  at[0], and those after it, at[step], ...
*/
static inline void FoldEdge(PetscInt degree, MpmEdgeType edge, PetscInt step, PetscReal outer, PetscReal at[])
{
  const PetscReal on = at[0];

  if (edge == MPM_EDGE_LINEAR) {
    at[0] += 2. * outer;
    at[step] -= outer;
    return;
  }
  at[0] = 0.;
  for (PetscInt k = 0; k <= degree; k++)
    at[step * k] += open_edge[degree - 2][0][k] * outer + open_edge[degree - 2][1][k] * on;
}

/*
  Both edges; each has at most one node beyond it, since every interval between them has. On an axis of a single cell
  the node that takes the linear extension's -1 is the other edge.
*/
static inline void FoldEdges(PetscInt degree, MpmEdgeType edge, PetscInt edge_lower, PetscInt edge_upper,
                             MpmShapeLine *line)
{
  PetscReal     *w = line->weight, *g = line->gradient;
  const PetscInt from  = edge == MPM_EDGE_OPEN ? 0 : 1; /* nodes beyond from which on there is something to do */
  const PetscInt below = edge_lower - line->first;

  if (below >= from) {
    const PetscReal w_outer = below ? w[0] : 0., g_outer = below ? g[0] : 0.;

    line->first += below;
    line->count -= below;
    for (PetscInt k = 0; below && k < line->count; k++) {
      w[k] = w[k + 1];
      g[k] = g[k + 1];
    }
    if (edge == MPM_EDGE_OPEN && line->count == degree) {
      w[degree] = g[degree] = 0.;
      line->count++;
    }
    FoldEdge(degree, edge, 1, w_outer, w);
    FoldEdge(degree, edge, 1, g_outer, g);
  }
  const PetscInt above = line->first + line->count - 1 - edge_upper;

  if (above >= from) {
    const PetscReal w_outer = above ? w[line->count - 1] : 0., g_outer = above ? g[line->count - 1] : 0.;

    line->count -= above;
    if (edge == MPM_EDGE_OPEN && line->count == degree) {
      for (PetscInt k = degree; k > 0; k--) {
        w[k] = w[k - 1];
        g[k] = g[k - 1];
      }
      w[0] = g[0] = 0.;
      line->first--;
      line->count++;
    }
    FoldEdge(degree, edge, -1, w_outer, &w[line->count - 1]);
    FoldEdge(degree, edge, -1, g_outer, &g[line->count - 1]);
  }
}

/* Drops nodes at the ends that a point does not touch at all: a quadratic spline on its knot has two nodes, not three.
   */
static inline void TrimEnds(MpmShapeLine *line)
{
  PetscReal *w = line->weight, *g = line->gradient;
  PetscInt   lead = 0;

  while (line->count > 1 && w[line->count - 1] == 0. && g[line->count - 1] == 0.) line->count--;
  while (lead < line->count - 1 && w[lead] == 0. && g[lead] == 0.) lead++;
  if (lead == 0) return;
  for (PetscInt k = lead; k < line->count; k++) {
    w[k - lead] = w[k];
    g[k - lead] = g[k];
  }
  line->first += lead;
  line->count -= lead;
}

/*
  A point's place in its interval. On an edge, and for points without a domain with linear functions on any knot, a node
  has a gradient and no weight: a share in the strain, and no mass to move with the point. Points there lie inside the
  interval by a rounding error: the mean velocity of such a node is that of its points, as in the limit from inside.
*/
static inline PetscReal Inside(PetscInt degree, Interval at, PetscReal l)
{
  PetscReal local = at.local;

  if (at.index == at.lower || (degree == 1 && !(l > MPM_SHAPE_POINT))) local = PetscMax(local, MPM_SHAPE_INSIDE);
  if (at.index == at.upper) local = PetscMin(local, (PetscReal)(degree % 2) - MPM_SHAPE_INSIDE);
  return local;
}

/*
  The weights, or with `whole` their means over knot spans, of all nodes of the intervals that the domain touches.
  Inlined with a constant degree, so that each shape gets its own straight-line code.
*/
MPM_INLINE void Touch(PetscInt degree, PetscBool whole, MpmEdgeType edge, Interval at, PetscReal l, MpmShapeLine *line)
{
  const PetscInt edge_lower = at.lower, edge_upper = degree % 2 ? at.upper + 1 : at.upper;

  at.local = Inside(degree, at, l);
  if (l > MPM_SHAPE_POINT) {
    line->count = AddDomain(degree, whole, at, l, &line->first, line->weight, line->gradient);
  } else {
    line->first = at.index - degree / 2;
    line->count = degree + 1;
    for (PetscInt k = 0; k <= degree; k++) line->weight[k] = line->gradient[k] = 0.;
    AddPart(degree, whole, at.local, 0., 1., line->weight, line->gradient);
  }
  if (degree > 1) FoldEdges(degree, MpmEdgeOf(edge, degree, edge_upper - edge_lower), edge_lower, edge_upper, line);
}

/* A line, and its smoothed weights: all nodes of the intervals stay, for a piece's mean is 0 in none. */
static void EvaluateSmooth(PetscInt degree, MpmEdgeType edge, Interval at, PetscReal l, MpmShapeLine *line)
{
  MpmShapeLine mean = {.weight = line->cross, .gradient = line->slope};

  Touch(degree, PETSC_FALSE, edge, at, l, line);
  Touch(degree, PETSC_TRUE, edge, at, l, &mean);
  for (PetscInt k = 0; k < line->count; k++) {
    line->cross[k] = line->weight[k] + line->smooth * (line->cross[k] - line->weight[k]);
    line->slope[k] = line->gradient[k] + line->smooth * (line->slope[k] - line->gradient[k]);
  }
}

/* The smoothed weights of the k-th point and axis of an array. */
static void EvaluateSmoothLine(PetscInt degree, MpmEdgeType edge, Interval at, PetscReal l, PetscInt k,
                               const MpmShapeLines *lines)
{
  const PetscInt from = k * lines->width;
  MpmShapeLine   line = {.weight   = &lines->weight[from],
                         .gradient = &lines->gradient[from],
                         .smooth   = lines->smooth,
                         .cross    = &lines->cross[from],
                         .slope    = &lines->slope[from]};

  EvaluateSmooth(degree, edge, at, l, &line);
  for (PetscInt i = line.count; i < lines->width; i++) line.gradient[i] = line.slope[i] = 0.;
  lines->first[k] = line.first;
  lines->count[k] = line.count;
}

MpmEdgeType MpmEdgeOf(MpmEdgeType edge, PetscInt degree, PetscInt cells)
{
  return degree > 1 && cells > degree ? edge : MPM_EDGE_LINEAR;
}

PetscReal MpmEdgeCoefficient(MpmEdgeType edge, PetscInt degree, PetscInt beyond, PetscInt k)
{
  if (edge == MPM_EDGE_OPEN) return open_edge[degree - 2][1 - beyond][k];
  if (!beyond) return k ? 0. : 1.;
  return k == 0 ? 2. : k == 1 ? -1. : 0.;
}

/* Of one shape, which is a constant here. */
MPM_INLINE void EvaluateAll(PetscInt degree, PetscBool domain, MpmEdgeType edge, PetscInt count,
                            const MpmShapePlaces *at, const MpmShapeLines *lines)
{
  const PetscInt width = lines->width;

  for (PetscInt k = 0; k < count; k++) {
    Interval        here = Locate(degree, at->xi[k], at->edge_lower[k], at->edge_upper[k]);
    const PetscReal l    = domain ? at->half_length[k] : 0.;
    MpmShapeLine    line = {.weight = &lines->weight[k * width], .gradient = &lines->gradient[k * width]};

    here.touch = at->touch;
    if (lines->smooth > 0.) {
      EvaluateSmoothLine(degree, edge, here, l, k, lines);
      continue;
    }
    Touch(degree, PETSC_FALSE, edge, here, l, &line);
    TrimEnds(&line);
    for (PetscInt i = line.count; i < width; i++) line.gradient[i] = 0.;
    lines->first[k] = line.first;
    lines->count[k] = line.count;
  }
}

void MpmShapeEvaluateAll(MpmShapeType type, MpmEdgeType edge, PetscInt count, const MpmShapePlaces *at,
                         const MpmShapeLines *lines)
{
  switch (type) {
  case MPM_SHAPE_GIMP:
    EvaluateAll(1, PETSC_TRUE, edge, count, at, lines);
    break;
  case MPM_SHAPE_BSPLINE2:
    EvaluateAll(2, PETSC_FALSE, edge, count, at, lines);
    break;
  case MPM_SHAPE_BSPLINE3:
    EvaluateAll(3, PETSC_FALSE, edge, count, at, lines);
    break;
  case MPM_SHAPE_GIMP_BSPLINE2:
    EvaluateAll(2, PETSC_TRUE, edge, count, at, lines);
    break;
  case MPM_SHAPE_LINEAR:
    EvaluateAll(1, PETSC_FALSE, edge, count, at, lines);
    break;
  default:
    MpmElementEvaluateAll(shapes[type].order, shapes[type].domain, count, at, lines);
  }
}

void MpmShapeEvaluate(MpmShapeType type, MpmEdgeType edge, PetscReal xi, PetscReal half_length, PetscInt edge_lower,
                      PetscInt edge_upper, MpmShapeLine *line)
{
  const MpmShapeLines lines = {.first    = &line->first,
                               .count    = &line->count,
                               .weight   = line->weight,
                               .gradient = line->gradient,
                               .smooth   = line->smooth,
                               .cross    = line->cross,
                               .slope    = line->slope};

  MpmShapeEvaluateAll(type, edge, 1, &(MpmShapePlaces){&xi, &half_length, &edge_lower, &edge_upper, MPM_SHAPE_TOUCH},
                      &lines);
}

void MpmShapeExtend(MpmShapeType type, MpmEdgeType edge, PetscReal xi, PetscReal by, PetscInt edge_lower,
                    PetscInt edge_upper, MpmShapeLine *line)
{
  const PetscInt degree = MpmShapeDegree(type);
  const Interval at     = Locate(degree, xi, edge_lower, edge_upper);

  if (shapes[type].order > 1) {
    MpmElementExtend(degree, xi, by, edge_lower, edge_upper, line);
    return;
  }
  line->first = at.index - degree / 2;
  line->count = degree + 1;
  for (PetscInt k = 0; k <= degree; k++) line->weight[k] = line->gradient[k] = 0.;
  AddSegment(degree, at.local + by, 0., 1., line->weight, line->gradient);
  if (degree > 1) FoldEdges(degree, MpmEdgeOf(edge, degree, edge_upper - edge_lower), edge_lower, edge_upper, line);
  TrimEnds(line);
}
