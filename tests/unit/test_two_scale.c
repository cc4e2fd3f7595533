/*
  Splines and elements of a coarse lattice as sums of those of a fine one: the same values and derivatives at any point,
  for each shape, domain, edge and ratio in which they are nested. The coarse operator at the points then is P^T A P.
*/
#include "grid/shape.h"
#include "levels/two_scale.h"
#include "unit.h"

#include <math.h>

#define WIDE  32
#define CELLS 24 /* of the fine lattice */

/* Values of all nodes of a lattice at a place of the axis, and derivatives by it, in fine cells. */
static void Evaluate(MpmShapeType type, MpmEdgeType edge, PetscReal x, PetscReal half, PetscInt ratio, PetscReal w[],
                     PetscReal g[])
{
  PetscReal    weight[WIDE], gradient[WIDE];
  MpmShapeLine line = {.weight = weight, .gradient = gradient};

  for (PetscInt k = 0; k <= CELLS; k++) w[k] = g[k] = 0.;
  MpmShapeEvaluate(type, edge, x / ratio, half / ratio, 0, CELLS / ratio, &line);
  for (PetscInt k = 0; k < line.count; k++) {
    w[line.first + k] = weight[k];
    g[line.first + k] = gradient[k] / ratio;
  }
}

/* The largest difference of a coarse function from its sum of fine ones, at places over the whole axis. */
static PetscReal Misfit(MpmShapeType type, MpmEdgeType edge, PetscInt ratio)
{
  const MpmTwoScale relation = {MpmShapeDegree(type), ratio, edge, CELLS, CELLS / ratio};
  PetscReal         worst    = 0.;

  for (PetscInt i = 0; i <= 500; i++) {
    const PetscReal half = 0.13 + 0.3 * (i % 7) / 7., x = half + (CELLS - 2. * half) * i / 500.;
    PetscReal       w[CELLS + 1], g[CELLS + 1], W[CELLS + 1], G[CELLS + 1];

    Evaluate(type, edge, x, half, 1, w, g);
    Evaluate(type, edge, x, half, ratio, W, G);
    for (PetscInt node = 0; node <= CELLS; node++) {
      PetscReal      share[MPM_TWO_SCALE_MOST];
      PetscInt       first;
      const PetscInt count = MpmTwoScaleRow(&relation, node, &first, share);

      for (PetscInt k = 0; k < count; k++) {
        W[first + k] -= share[k] * w[node];
        G[first + k] -= share[k] * g[node];
      }
    }
    for (PetscInt node = 0; node <= CELLS / ratio; node++)
      worst = PetscMax(worst, PetscMax(PetscAbsReal(W[node]), PetscAbsReal(G[node])));
  }
  return worst;
}

START_TEST(nested)
{
  for (PetscInt type = MPM_SHAPE_LINEAR; MpmShapeTypes[type]; type++) {
    const PetscInt degree = MpmShapeDegree((MpmShapeType)type);

    for (PetscInt ratio = degree % 2 ? 2 : 3; ratio <= 3; ratio++)
      for (PetscInt edge = MPM_EDGE_LINEAR; edge <= MPM_EDGE_OPEN; edge++)
        ck_assert_msg(Misfit((MpmShapeType)type, (MpmEdgeType)edge, ratio) < 1e-13, "%s edge %d ratio %d: %g",
                      MpmShapeTypes[type], (int)edge, (int)ratio,
                      (double)Misfit((MpmShapeType)type, (MpmEdgeType)edge, ratio));
  }
}
END_TEST

/* Knots of quadratic splines lie between the nodes: by halves they are not nested. */
START_TEST(not_nested)
{
  ck_assert_double_gt(Misfit(MPM_SHAPE_BSPLINE2, MPM_EDGE_LINEAR, 2), 1e-3);
}
END_TEST

/* Lattices that end at different places: constants stay. */
START_TEST(uneven)
{
  for (PetscInt degree = 1; degree <= 3; degree++) {
    for (PetscInt ratio = 2; ratio <= 3; ratio++) {
      const MpmTwoScale relation = {degree, ratio, MPM_EDGE_OPEN, 7, (7 + ratio - 1) / ratio};

      for (PetscInt node = 0; node <= relation.fine; node++) {
        PetscReal      share[MPM_TWO_SCALE_MOST], sum = 0.;
        PetscInt       first;
        const PetscInt count = MpmTwoScaleRow(&relation, node, &first, share);

        ck_assert(first >= 0 && first + count - 1 <= relation.coarse);
        for (PetscInt k = 0; k < count; k++) sum += share[k];
        ck_assert_double_eq_tol(sum, 1., 1e-14);
      }
    }
  }
}
END_TEST

/* Values at a place of the functions of all nodes of elements, in fine cells. */
static void EvaluateElements(PetscInt order, PetscReal x, PetscReal half, PetscInt ratio, PetscReal w[])
{
  PetscReal          weight[WIDE], gradient[WIDE];
  MpmShapeLine       line = {.weight = weight, .gradient = gradient};
  const MpmShapeType type = MpmShapeOfWord(half > 0. ? 6 : 5, order);

  for (PetscInt k = 0; k <= 4 * CELLS; k++) w[k] = 0.;
  MpmShapeEvaluate(type, MPM_EDGE_LINEAR, x / ratio, half / ratio, 0, CELLS / ratio, &line);
  for (PetscInt k = 0; k < line.count; k++) w[line.first + k] = weight[k];
}

/* Elements by lower orders and by larger cells, sampled and averaged over domains. */
START_TEST(elements)
{
  for (PetscInt k = 0; k < 4 * 4 * 3 * 2; k++) {
    const MpmElementScale relation = {k % 4 + 1, k / 4 % 4 + 1, k / 16 % 3 + 1, CELLS};
    PetscReal             worst    = 0.;

    for (PetscInt i = 0; i <= 300 && relation.coarse <= relation.fine; i++) {
      const PetscReal half = k / 48 ? 0.13 + 0.3 * (i % 7) / 7. : 0., x = half + (CELLS - 2. * half) * i / 300.;
      PetscReal       w[4 * CELLS + 1], W[4 * CELLS + 1];

      EvaluateElements(relation.fine, x, half, 1, w);
      EvaluateElements(relation.coarse, x, half, relation.ratio, W);
      for (PetscInt node = 0; node <= relation.fine * CELLS; node++) {
        PetscReal      share[MPM_TWO_SCALE_MOST];
        PetscInt       first;
        const PetscInt count = MpmElementScaleRow(&relation, node, &first, share);

        for (PetscInt j = 0; j < count; j++) W[first + j] -= share[j] * w[node];
      }
      for (PetscInt node = 0; node <= relation.coarse * CELLS / relation.ratio; node++)
        worst = PetscMax(worst, PetscAbsReal(W[node]));
    }
    ck_assert_msg(worst < 1e-13, "order %d by %d, ratio %d: %g", (int)relation.fine, (int)relation.coarse,
                  (int)relation.ratio, (double)worst);
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {nested, not_nested, uneven, elements};

  return UnitRun(&argc, &argv, "two-scale relations", sizeof(tests) / sizeof(tests[0]), tests);
}
