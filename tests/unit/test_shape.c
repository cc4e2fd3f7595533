/*
  Shape functions: tabulated values, the identities they must keep, and the definition itself by quadrature.
*/
#include "grid/shape.h"
#include "unit.h"

/* Check writes a line for every assertion; those made millions of times are only reported when they fail. */
#define CHECK_POINT(condition, ...) \
  do { \
    if (!(condition)) ck_abort_msg(__VA_ARGS__); \
  } while (0)

#include <math.h>

#define FAR  1000 /* an edge that does not matter */
#define WIDE 32   /* room for any shape of these tests */

typedef struct {
  PetscInt  first, count;
  PetscReal weight[WIDE], gradient[WIDE];
} Shape;

static MpmEdgeType edge = MPM_EDGE_LINEAR; /* how splines end in Evaluate() */

static Shape Evaluate(MpmShapeType type, PetscReal xi, PetscReal l, PetscInt lower, PetscInt upper)
{
  Shape s;

  for (PetscInt k = 0; k < WIDE; k++) s.weight[k] = s.gradient[k] = 1e300;
  MpmShapeLine line = {.weight = s.weight, .gradient = s.gradient};
  MpmShapeEvaluate(type, edge, xi, l, lower, upper, &line);
  s.first = line.first;
  s.count = line.count;
  CHECK_POINT(s.count >= 1 && s.count <= MpmShapeWidth(type, l), "type %d at %.17g, l %.17g: %d nodes of %d", (int)type,
              xi, l, (int)s.count, (int)MpmShapeWidth(type, l));
  CHECK_POINT(s.first >= lower && s.first + s.count - 1 <= upper, "type %d at %.17g, l %.17g: nodes %d..%d", (int)type,
              xi, l, (int)s.first, (int)(s.first + s.count - 1));
  /* callers have room for the width and no more */
  for (PetscInt k = MpmShapeWidth(type, l); k < WIDE; k++)
    CHECK_POINT(s.weight[k] == 1e300 && s.gradient[k] == 1e300, "type %d at %.17g: wrote beyond its nodes", (int)type,
                xi);
  return s;
}

static PetscReal Weight(const Shape *s, PetscInt node)
{
  return (node < s->first || node >= s->first + s->count) ? 0. : s->weight[node - s->first];
}

static PetscReal Gradient(const Shape *s, PetscInt node)
{
  return (node < s->first || node >= s->first + s->count) ? 0. : s->gradient[node - s->first];
}

static PetscReal Uniform(PetscReal lower, PetscReal upper)
{
  return lower + (upper - lower) * (PetscReal)rand() / (PetscReal)RAND_MAX;
}

/* ----------------------------------------------------------------------------------------------------------- tables */

typedef struct {
  PetscReal s, weight, gradient;
} Row;

static void CheckTable(MpmShapeType type, PetscReal tolerance, PetscInt count, const Row rows[])
{
  const PetscInt node = 10;

  for (PetscInt i = 0; i < count; i++) {
    for (int sign = -1; sign <= 1; sign += 2) {
      const Shape at = Evaluate(type, (PetscReal)node + sign * rows[i].s, 0.25, 0, 20);

      ck_assert_double_eq_tol(Weight(&at, node), rows[i].weight, tolerance);
      ck_assert_double_eq_tol(Gradient(&at, node), sign * rows[i].gradient, tolerance);
    }
  }
}

/* Half-length 1/4, from the six-branch form of Coombs & Augarde (2020), Adv. Eng. Softw. 139, 102748 */
START_TEST(gimp_table)
{
  static const Row rows[] = {
    {0., 0.875, 0.},     {0.1, 0.855, -0.4}, {0.25, 0.75, -1.},   {0.5, 0.5, -1.}, {0.75, 0.25, -1.},
    {0.9, 0.1225, -0.7}, {1., 0.0625, -0.5}, {1.2, 0.0025, -0.1}, {1.25, 0., 0.},
  };

  CheckTable(MPM_SHAPE_GIMP, 1e-14, sizeof(rows) / sizeof(rows[0]), rows);
}
END_TEST

/* Half-length 1/4, evaluated from the truncated powers of the quadratic B-spline's antiderivative */
START_TEST(gimp_bspline2_table)
{
  static const Row rows[] = {
    {0., 0.729166667, 0.},      {0.1, 0.719166667, -0.2}, {0.25, 0.666666667, -0.5},  {0.5, 0.494791667, -0.8125},
    {0.75, 0.291666667, -0.75}, {1., 0.135416667, -0.5},  {1.25, 0.041666667, -0.25}, {1.5, 0.005208333, -0.0625},
    {1.6, 0.001125, -0.0225},   {1.75, 0., 0.},
  };

  CheckTable(MPM_SHAPE_GIMP_BSPLINE2, 5.1e-10, sizeof(rows) / sizeof(rows[0]), rows);
}
END_TEST

static void CheckNodes(const Shape *s, PetscInt first, PetscInt count, const PetscReal weight[],
                       const PetscReal gradient[], PetscReal tolerance)
{
  ck_assert_int_eq(s->first, first);
  ck_assert_int_eq(s->count, count);
  for (PetscInt k = 0; k < count; k++) {
    ck_assert_double_eq_tol(s->weight[k], weight[k], tolerance);
    ck_assert_double_eq_tol(s->gradient[k], gradient[k], tolerance);
  }
}

START_TEST(edge_values)
{
  static const PetscReal half_w[] = {0.505208333, 0.489583333, 0.005208333}, half_g[] = {-0.9375, 0.875, 0.0625};
  static const PetscReal quarter_w[] = {0.75, 0.25}, quarter_g[] = {-1., 1.};
  Shape                  s;

  s = Evaluate(MPM_SHAPE_GIMP_BSPLINE2, 0.5, 0.25, 0, FAR);
  CheckNodes(&s, 0, 3, half_w, half_g, 5.1e-10);
  s = Evaluate(MPM_SHAPE_GIMP_BSPLINE2, 0.25, 0.25, 0, FAR);
  CheckNodes(&s, 0, 2, quarter_w, quarter_g, 1e-15);
  for (PetscInt p = 0; p < 3; p++) { /* from the upper edge, mirrored */
    s = Evaluate(MPM_SHAPE_GIMP_BSPLINE2, 9.5, 0.25, 0, 10);
    ck_assert_double_eq_tol(Weight(&s, 10 - p), half_w[p], 5.1e-10);
    ck_assert_double_eq_tol(Gradient(&s, 10 - p), -half_g[p], 5.1e-10);
  }
}
END_TEST

/* A point wholly inside a cell, on a face, on a knot: no more nodes than it touches. */
START_TEST(node_counts)
{
  static const PetscReal at_node_w[] = {1., 0.}, step[] = {-1., 1.}, middle_w[] = {0.5, 0.5},
                         knot_w[] = {1. / 6., 4. / 6., 1. / 6.};
  static const PetscReal knot_g[] = {-0.5, 0., 0.5};
  Shape                  s;

  s = Evaluate(MPM_SHAPE_LINEAR, 3., 0., 0, 10);
  CheckNodes(&s, 3, 2, at_node_w, step, 3e-16);
  s = Evaluate(MPM_SHAPE_GIMP, 3.5, 0.25, 0, 10);
  CheckNodes(&s, 3, 2, middle_w, step, 1e-15);
  s = Evaluate(MPM_SHAPE_GIMP, 3.5, 0.5, 0, 10); /* fills its cell: touches the faces, not the cells behind them */
  CheckNodes(&s, 3, 2, middle_w, step, 1e-15);
  s = Evaluate(MPM_SHAPE_BSPLINE2, 3.5, 0., 0, 10);
  CheckNodes(&s, 3, 2, middle_w, step, 1e-15);
  s = Evaluate(MPM_SHAPE_BSPLINE3, 3., 0., 0, 10);
  CheckNodes(&s, 2, 3, knot_w, knot_g, 1e-15);
  s = Evaluate(MPM_SHAPE_GIMP, 3.5, 0.6, 0, 10); /* longer than a cell: the fourth node must not be lost */
  ck_assert_int_eq(s.count, 4);
  ck_assert_double_eq_tol(s.weight[0], 0.00417, 5e-6);
}
END_TEST

START_TEST(widths)
{
  ck_assert_int_eq(MpmShapeWidth(MPM_SHAPE_LINEAR, 3.), 2);
  ck_assert_int_eq(MpmShapeWidth(MPM_SHAPE_BSPLINE2, 3.), 3);
  ck_assert_int_eq(MpmShapeWidth(MPM_SHAPE_BSPLINE3, 3.), 4);
  ck_assert_int_eq(MpmShapeWidth(MPM_SHAPE_GIMP, 0.25), 3);
  ck_assert_int_eq(MpmShapeWidth(MPM_SHAPE_GIMP, 0.5), 3);
  ck_assert_int_eq(MpmShapeWidth(MPM_SHAPE_GIMP, 0.6), 4);
  ck_assert_int_eq(MpmShapeWidth(MPM_SHAPE_GIMP_BSPLINE2, 0.5), 4);
  ck_assert_int_eq(MpmShapeWidth(MPM_SHAPE_GIMP_BSPLINE2, 0.6), 5);
  for (int type = 0; type < MPM_SHAPE_COUNT; type++) {
    ck_assert_ptr_nonnull(MpmShapeTypes[type]);
    ck_assert_int_eq(MpmShapeHasDomain((MpmShapeType)type), type == MPM_SHAPE_GIMP || type == MPM_SHAPE_GIMP_BSPLINE2);
  }
  ck_assert_ptr_null(MpmShapeTypes[MPM_SHAPE_COUNT]);
}
END_TEST

/* ------------------------------------------------------------------------------------------------------- identities */

/* Awkward places first, then random ones; l is cut at the edges as the points' owner does. */
static void SamplePoint(PetscInt i, PetscInt cells, PetscReal *xi, PetscReal *l)
{
  static const PetscReal lengths[] = {0., 1e-300, 1e-16, 1e-12, 1e-8, 0.25, 0.5, 0.8, 1., 1.5, 3.};
  static const PetscReal nudges[]  = {0., 1e-17, -1e-17, 1e-16, -1e-16, 1e-15, -1e-15, 1e-12, -1e-12};
  const PetscInt length_count = sizeof(lengths) / sizeof(lengths[0]), nudge_count = sizeof(nudges) / sizeof(nudges[0]);

  *l  = i % 3 ? lengths[(i / 3) % length_count] : Uniform(0., 3.);
  *xi = i % 2 ? 0.5 * floor(Uniform(0., 2. * (PetscReal)cells + 1.)) + nudges[(i / 2) % nudge_count]
              : Uniform(0., (PetscReal)cells);
  *xi = PetscMin(PetscMax(*xi, 0.), (PetscReal)cells);
  *l  = PetscMin(*l, PetscMin(*xi, (PetscReal)cells - *xi));
}

/* Rounding of the average of a gradient over a tiny domain is relative to the gradient, not to the domain. */
static void CheckIdentities(MpmShapeType type, PetscReal xi, PetscReal l, PetscInt cells)
{
  const Shape s   = Evaluate(type, xi, l, 0, cells);
  PetscReal   sum = 0., sum_gradient = 0., position = 0., slope = 0.;

  for (PetscInt k = 0; k < s.count; k++) {
    const PetscReal x = (PetscReal)(s.first + k);

    sum += s.weight[k];
    sum_gradient += s.gradient[k];
    position += s.weight[k] * x;
    slope += s.gradient[k] * x;
    if (type == MPM_SHAPE_LINEAR || type == MPM_SHAPE_GIMP) {
      CHECK_POINT(s.weight[k] >= 0., "type %d at %.17g, l %.17g: weight %g", (int)type, xi, l, s.weight[k]);
    }
  }
  CHECK_POINT(fabs(sum - 1.) < 4e-15, "type %d at %.17g, l %.17g of %d: weights sum to 1 + %g", (int)type, xi, l,
              (int)cells, sum - 1.);
  CHECK_POINT(fabs(sum_gradient) < 1e-14, "type %d at %.17g, l %.17g: gradients sum to %g", (int)type, xi, l,
              sum_gradient);
  CHECK_POINT(fabs(position - xi) < 2e-14, "type %d at %.17g, l %.17g: position is off by %g", (int)type, xi, l,
              position - xi);
  CHECK_POINT(fabs(slope - 1.) < 4e-14, "type %d at %.17g, l %.17g: slope is off by %g", (int)type, xi, l, slope - 1.);
}

static void CheckAllIdentities(PetscInt points)
{
  static const PetscInt cells[] = {1, 2, 3, 4, 9};

  for (int type = 0; type < MPM_SHAPE_COUNT; type++) {
    for (PetscInt i = 0; i < points; i++) {
      const PetscInt n = cells[i % 5];
      PetscReal      xi, l;

      SamplePoint(i / 5, n, &xi, &l);
      CheckIdentities((MpmShapeType)type, xi, l, n);
    }
  }
}

START_TEST(identities)
{
  CheckAllIdentities(100000);
}
END_TEST

/* Smoothed weights and gradients: linear fields keep their gradients, and with the means alone all places of a knot
   span are alike. */
static void CheckSmoothed(MpmShapeType type, PetscReal xi, PetscReal l, PetscInt cells)
{
  PetscReal    weight[WIDE], gradient[WIDE], cross[WIDE], slope[WIDE], sum = 0., moment[2] = {0., 0.}, total = 0.;
  MpmShapeLine line  = {.weight = weight, .gradient = gradient, .smooth = 0.7, .cross = cross, .slope = slope};
  const Shape  plain = Evaluate(type, xi, l, 0, cells);

  MpmShapeEvaluate(type, edge, xi, l, 0, cells, &line);
  CHECK_POINT(line.count >= plain.count && line.count <= MpmShapeWidth(type, l), "type %d at %.17g: %d nodes",
              (int)type, xi, (int)line.count);
  for (PetscInt k = 0; k < line.count; k++) {
    sum += cross[k];
    moment[0] += slope[k];
    moment[1] += slope[k] * (PetscReal)(line.first + k);
    total += PetscAbsReal(weight[k] - Weight(&plain, line.first + k));
  }
  CHECK_POINT(fabs(sum - 1.) < 4e-15, "type %d at %.17g, l %.17g: smoothed weights sum to %g", (int)type, xi, l, sum);
  CHECK_POINT(fabs(moment[0]) < 1e-14 && fabs(moment[1] - 1.) < 4e-14, "type %d at %.17g, l %.17g: slope is off by %g",
              (int)type, xi, l, moment[1] - 1.);
  CHECK_POINT(total == 0., "type %d at %.17g, l %.17g: weights are off by %g", (int)type, xi, l, total);
}

START_TEST(smoothed)
{
  for (int type = 0; type < MPM_SHAPE_COUNT; type++) {
    for (PetscInt i = 0; i < 20000; i++) {
      const PetscInt n = 1 + i % 5;
      PetscReal      xi, l;

      SamplePoint(i / 5, n, &xi, &l);
      CheckSmoothed((MpmShapeType)type, xi, l, n);
    }
    /* half a piece apart, far from edges */
    const PetscReal offset = MpmShapeDegree((MpmShapeType)type) == 2 ? 0.5 : 0.;
    PetscReal       weight[WIDE], gradient[WIDE], cross[2][WIDE], slope[2][WIDE];
    MpmShapeLine    line[2];

    for (PetscInt s = 0; s < 2; s++) {
      line[s] =
        (MpmShapeLine){.weight = weight, .gradient = gradient, .smooth = 1., .cross = cross[s], .slope = slope[s]};
      MpmShapeEvaluate((MpmShapeType)type, edge, 4. + offset + (s ? 0.2 : 0.7), 0.1, 0, 9, &line[s]);
    }
    ck_assert_int_eq(line[0].first, line[1].first);
    ck_assert_int_eq(line[0].count, line[1].count);
    for (PetscInt k = 0; k < line[0].count; k++) {
      ck_assert_double_eq_tol(cross[0][k], cross[1][k], 1e-15);
      ck_assert_double_eq_tol(slope[0][k], slope[1][k], 1e-15);
    }
  }
}
END_TEST

/* The edge node carries the edge's value to rounding, or prescribed values would not be met. */
START_TEST(edge_interpolates)
{
  for (int type = 0; type < MPM_SHAPE_COUNT; type++) {
    for (PetscInt cells = 1; cells < 6; cells++) {
      const Shape lower = Evaluate((MpmShapeType)type, 0., 0., 0, cells),
                  upper = Evaluate((MpmShapeType)type, (PetscReal)cells, 0., 0, cells);

      for (PetscInt node = 0; node <= cells; node++) {
        ck_assert_double_eq_tol(Weight(&lower, node), node == 0 ? 1. : 0., 3e-16);
        ck_assert_double_eq_tol(Weight(&upper, node), node == cells ? 1. : 0., 3e-16);
      }
    }
  }
}
END_TEST

/* A wall inside the grid acts as an edge: node numbers shift, values do not. */
START_TEST(shifted_edge)
{
  for (int type = 0; type < MPM_SHAPE_COUNT; type++) {
    for (PetscInt i = 0; i <= 64; i++) {
      const PetscReal xi = (PetscReal)i / 32., l = PetscMin(0.25, PetscMin(xi, 2. - xi));
      const Shape a = Evaluate((MpmShapeType)type, xi, l, 0, 2), b = Evaluate((MpmShapeType)type, xi - 7., l, -7, -5);

      ck_assert_int_eq(a.first - 7, b.first);
      CheckNodes(&b, a.first - 7, a.count, a.weight, a.gradient, 1e-15);
    }
  }
}
END_TEST

/* ---- not-a-knot ends ---- */

/* Coefficients of x^power on the cardinal B-splines of degree p: means of products of a node's inner knots. */
static PetscReal Blossom(PetscInt p, PetscInt power, PetscReal node)
{
  if (power < 2) return power ? node : 1.;
  if (p == 2) return node * node - 0.25;
  return power == 2 ? node * node - 1. / 3. : node * (node * node - 1.);
}

/* Up to its own degree a polynomial comes out exactly, up to the edges, where the coefficient is its value. */
static void CheckPolynomial(MpmShapeType type, PetscInt power, PetscReal xi, PetscReal l, PetscInt cells)
{
  const PetscInt  p     = MpmShapeDegree(type);
  const Shape     s     = Evaluate(type, xi, l, 0, cells);
  const PetscReal size  = PetscPowRealInt((PetscReal)cells, power);
  PetscReal       value = 0., slope = 0., exact = PetscPowRealInt(xi, power);

  if (power == 2 && MpmShapeHasDomain(type)) exact += l * l / 3.;
  for (PetscInt k = 0; k < s.count; k++) {
    const PetscInt  node = s.first + k;
    const PetscReal coefficient =
      node == 0 || node == cells ? PetscPowRealInt((PetscReal)node, power) : Blossom(p, power, (PetscReal)node);

    value += s.weight[k] * coefficient;
    slope += s.gradient[k] * coefficient;
  }
  CHECK_POINT(fabs(value - exact) < 1e-14 * size, "type %d at %.17g, l %.17g of %d: x^%d is off by %g", (int)type, xi,
              l, (int)cells, (int)power, value - exact);
  CHECK_POINT(fabs(slope - (PetscReal)power * PetscPowRealInt(xi, power - 1)) < 2e-14 * size,
              "type %d at %.17g, l %.17g of %d: slope of x^%d is off", (int)type, xi, l, (int)cells, (int)power);
}

START_TEST(open_edges)
{
  static const MpmShapeType types[] = {MPM_SHAPE_BSPLINE2, MPM_SHAPE_BSPLINE3, MPM_SHAPE_GIMP_BSPLINE2};

  edge = MPM_EDGE_OPEN;
  CheckAllIdentities(20000);
  for (size_t t = 0; t < sizeof(types) / sizeof(types[0]); t++) {
    const PetscInt p = MpmShapeDegree(types[t]);

    for (PetscInt i = 0; i < 20000; i++) {
      const PetscInt cells = p + 1 + i % 6;
      PetscReal      xi, l;

      SamplePoint(i / 6, cells, &xi, &l);
      for (PetscInt power = 1; power <= p; power++) CheckPolynomial(types[t], power, xi, l, cells);
    }
    for (PetscInt cells = 1; cells < 9; cells++) {
      const Shape lower = Evaluate(types[t], 0., 0., 0, cells),
                  upper = Evaluate(types[t], (PetscReal)cells, 0., 0, cells);

      for (PetscInt node = 0; node <= cells; node++) {
        ck_assert_double_eq_tol(Weight(&lower, node), node == 0 ? 1. : 0., 1e-15);
        ck_assert_double_eq_tol(Weight(&upper, node), node == cells ? 1. : 0., 1e-15);
      }
    }
  }
  edge = MPM_EDGE_LINEAR;
}
END_TEST

/* Away from the edges, and between edges that are too near each other, a not-a-knot end changes nothing; nor do linear
   basis functions have it. */
START_TEST(where_open_edges_end)
{
  for (int type = 0; type < MPM_SHAPE_COUNT; type++) {
    const PetscInt p = MpmShapeDegree((MpmShapeType)type);

    for (PetscInt i = 0; i < 4000; i++) {
      const PetscInt  cells = p == 1 || i % 2 ? 1 + i % 9 : 1 + i % p;
      const PetscBool far   = (PetscBool)(p > 1 && cells > p);
      const PetscReal l     = MpmShapeHasDomain((MpmShapeType)type) ? Uniform(0., 0.5) : 0.;
      const PetscReal from  = far ? 0.5 * (PetscReal)(p + 1) + l : l;
      PetscReal       xi;
      Shape           linear, open;

      if ((PetscReal)cells - from < from) continue;
      xi     = Uniform(from, (PetscReal)cells - from);
      linear = Evaluate((MpmShapeType)type, xi, l, 0, cells);
      edge   = MPM_EDGE_OPEN;
      open   = Evaluate((MpmShapeType)type, xi, l, 0, cells);
      edge   = MPM_EDGE_LINEAR;
      CheckNodes(&open, linear.first, linear.count, linear.weight, linear.gradient, 1e-300);
    }
  }
}
END_TEST

/* --------------------------------------------------------------------------------------------------- the definition */

/* Cardinal B-spline of degree p by the recurrence of Cox and de Boor: slow, and nothing like the code under test. */
static PetscReal Spline(PetscInt p, PetscReal t)
{
  const PetscReal half = 0.5 * (PetscReal)(p + 1);

  if (p == 0) return (t >= -0.5 && t < 0.5) ? 1. : 0.;
  return ((half + t) * Spline(p - 1, t + 0.5) + (half - t) * Spline(p - 1, t - 0.5)) / (PetscReal)p;
}

static PetscReal SplineSlope(PetscInt p, PetscReal t)
{
  return Spline(p - 1, t + 0.5) - Spline(p - 1, t - 0.5);
}

/* The spline of a node with the spline of a missing node folded in: u_{-k} = 2 u_0 - u_k, again until all nodes exist.
   */
static PetscReal FoldedSpline(PetscInt p, PetscReal x, PetscInt node, PetscInt cells,
                              PetscReal (*spline)(PetscInt, PetscReal))
{
  PetscReal value = spline(p, x - (PetscReal)node);

  for (PetscInt k = 1; k <= p / 2; k++) {
    if (node == 0) value += 2. * spline(p, x + (PetscReal)k);
    if (node == k) value -= spline(p, x + (PetscReal)k);
    if (node == cells) value += 2. * spline(p, x - (PetscReal)(cells + k));
    if (node == cells - k) value -= spline(p, x - (PetscReal)(cells + k));
  }
  return value;
}

/* Average over the domain by the midpoint rule, error O(panel^2) with kinks inside panels included. */
static PetscReal Average(PetscInt p, PetscReal x, PetscReal l, PetscInt node, PetscInt cells,
                         PetscReal (*spline)(PetscInt, PetscReal))
{
  const PetscInt panels = 20000;
  PetscReal      sum    = 0.;

  if (l == 0.) return FoldedSpline(p, x, node, cells, spline);
  for (PetscInt i = 0; i < panels; i++) {
    sum += FoldedSpline(p, x - l + 2. * l * ((PetscReal)i + 0.5) / (PetscReal)panels, node, cells, spline);
  }
  return sum / (PetscReal)panels;
}

START_TEST(against_quadrature)
{
  static const PetscInt degree[] = {1, 1, 2, 3, 2};

  for (int type = 0; type < MPM_SHAPE_COUNT; type++) {
    for (PetscInt i = 0; i < 60; i++) {
      const PetscInt  cells = 1 + i % 7;
      const PetscReal xi    = Uniform(0., (PetscReal)cells),
                      most  = MpmShapeHasDomain((MpmShapeType)type) ? Uniform(0., 3.) : 0.;
      const PetscReal l     = PetscMin(most, PetscMin(xi, (PetscReal)cells - xi));
      const Shape     s     = Evaluate((MpmShapeType)type, xi, l, 0, cells);

      for (PetscInt node = 0; node <= cells; node++) {
        const PetscReal w = Average(degree[type], xi, l, node, cells, Spline),
                        g = Average(degree[type], xi, l, node, cells, SplineSlope);

        CHECK_POINT(fabs(Weight(&s, node) - w) < 1e-7, "type %d at %.17g, l %.17g of %d: node %d has %.9g, not %.9g",
                    type, xi, l, (int)cells, (int)node, Weight(&s, node), w);
        CHECK_POINT(fabs(Gradient(&s, node) - g) < 3e-4, "type %d at %.17g: gradient", (int)type,
                    xi); /* the linear basis function's slope jumps: half a panel */
      }
    }
  }
}
END_TEST

/* The gradient is the derivative of the weight at fixed domain; away from kinks, central differences see it to second
   order. */
static void CheckGradients(void)
{
  const PetscReal eps = 1e-6;

  for (int type = 0; type < MPM_SHAPE_COUNT; type++) {
    for (PetscInt i = 0; i < (UNIT_SANITIZED ? 2000 : 20000); i++) {
      const PetscReal xi = Uniform(0.01, 5.99), most = Uniform(0.001, 3.),
                      l = PetscMin(most, PetscMin(xi, 6. - xi) - 2. * eps);
      const Shape s     = Evaluate((MpmShapeType)type, xi, l, 0, 6);
      const Shape a     = Evaluate((MpmShapeType)type, xi - eps, l, 0, 6),
                  b     = Evaluate((MpmShapeType)type, xi + eps, l, 0, 6);

      if (type == MPM_SHAPE_LINEAR && fabs(xi - round(xi)) <= 2. * eps) continue;
      for (PetscInt node = 0; node <= 6; node++) {
        /* averaging linear basis functions leaves a second derivative up to 1/l, which jumps */
        ck_assert_double_eq_tol((Weight(&b, node) - Weight(&a, node)) / (2. * eps), Gradient(&s, node),
                                1e-9 + eps * (2. + 1. / l));
      }
    }
  }
}

START_TEST(gradient_by_differences)
{
  CheckGradients();
  edge = MPM_EDGE_OPEN;
  CheckGradients();
  edge = MPM_EDGE_LINEAR;
}
END_TEST

/* True where a point's ends, or the point, lie so close to a knot that differences meet two intervals. */
static PetscBool NearKnot(MpmShapeType type, PetscReal xi, PetscReal l, PetscReal close)
{
  const PetscReal offset   = MpmShapeDegree(type) % 2 ? 0. : 0.5;
  const PetscReal places[] = {xi - (MpmShapeHasDomain(type) ? l : 0.), xi + (MpmShapeHasDomain(type) ? l : 0.)};

  for (int k = 0; k < 2; k++)
    if (fabs(places[k] - offset - round(places[k] - offset)) < close) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Derivatives of weights and gradients by the place and the half-length are what central differences give. */
static void CheckSlopes(void)
{
  const PetscReal eps = 1e-6;

  for (int k = 0; k < MPM_SHAPE_COUNT * (UNIT_SANITIZED ? 500 : 5000); k++) {
    const MpmShapeType type = (MpmShapeType)(k % MPM_SHAPE_COUNT);
    const PetscReal    xi = Uniform(0.1, 5.9), l = PetscMin(Uniform(0.05, 2.), PetscMin(xi, 6. - xi) - 4. * eps),
                    reach = 1e-7 / (l * l);
    PetscReal            slope[3][WIDE];
    Shape                s     = Evaluate(type, xi, l, 0, 6);
    const MpmShapeLine   line  = {.first = s.first, .count = s.count, .weight = s.weight, .gradient = s.gradient};
    const MpmShapeSlopes by    = {slope[0], slope[1], slope[2]};
    const Shape          at[4] = {Evaluate(type, xi - eps, l, 0, 6), Evaluate(type, xi + eps, l, 0, 6),
                                  Evaluate(type, xi, l - eps, 0, 6), Evaluate(type, xi, l + eps, 0, 6)};

    if (NearKnot(type, xi, l, 3. * eps)) continue;
    MpmShapeDifferentiate(type, edge, &(MpmShapePlace){xi, l, 0, 6}, &line, &by);
    for (PetscInt i = 0; i < s.count; i++) {
      const PetscInt node = s.first + i;

      CHECK_POINT(fabs((Gradient(&at[1], node) - Gradient(&at[0], node)) / (2. * eps) - slope[0][i]) < reach &&
                    fabs((Weight(&at[3], node) - Weight(&at[2], node)) / (2. * eps) - slope[1][i]) < reach &&
                    fabs((Gradient(&at[3], node) - Gradient(&at[2], node)) / (2. * eps) - slope[2][i]) < reach,
                  "type %d at %.17g, l %.17g, node %d: %g %g %g", (int)type, xi, l, (int)node, slope[0][i], slope[1][i],
                  slope[2][i]);
    }
  }
}

START_TEST(slopes_by_differences)
{
  CheckSlopes();
  edge = MPM_EDGE_OPEN;
  CheckSlopes();
  edge = MPM_EDGE_LINEAR;
}
END_TEST

/* Tiny domains: the weights tend to the point's, and a domain centred on a node has no preferred side. */
START_TEST(tiny_domains)
{
  static const PetscReal lengths[] = {1e-6, 1e-9, 1e-12, 1e-16, 1e-50};

  for (size_t i = 0; i < sizeof(lengths) / sizeof(lengths[0]); i++) {
    const PetscReal l = lengths[i];
    Shape           s = Evaluate(MPM_SHAPE_GIMP, 4., l, 0, 9);

    ck_assert_int_eq(s.count, 3);
    ck_assert_double_eq_tol(s.weight[1], 1. - 0.5 * l, 1e-15);
    ck_assert_double_eq_tol(s.gradient[0], -0.5, 1e-15);
    ck_assert_double_eq_tol(s.gradient[1], 0., 1e-15);
    ck_assert_double_eq_tol(s.gradient[2], 0.5, 1e-15);
    s = Evaluate(MPM_SHAPE_GIMP_BSPLINE2, 4.5, l, 0, 9);
    ck_assert_double_eq_tol(Weight(&s, 4), 0.5, l);
    ck_assert_double_eq_tol(Gradient(&s, 5), 1., l);
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {
    gimp_table,         gimp_bspline2_table,     edge_values,  node_counts, widths,
    identities,         edge_interpolates,       shifted_edge, open_edges,  where_open_edges_end,
    against_quadrature, gradient_by_differences, tiny_domains, smoothed,    slopes_by_differences};

  return UnitRun(&argc, &argv, "shape", sizeof(tests) / sizeof(tests[0]), tests);
}
