/*
  Elements of order 2 to 4: polynomials of their degree, derivatives, and the ghost penalty of all normal derivatives.

  Ranks: 1 3
*/
#include "scene.h"
#include "block.h"
#include "grid/shape_element.h"
#include "volume/volume.h"
#include "assembly/terms.h"
#include "extension/extension.h"
#include "space/sum.h"

#include <math.h>

#define WIDE 32

static PetscReal Uniform(PetscReal lower, PetscReal upper)
{
  return lower + (upper - lower) * (PetscReal)rand() / (PetscReal)RAND_MAX;
}

static const MpmShapeType types[2][4] = {
  {MPM_SHAPE_LINEAR, MPM_SHAPE_ELEMENT2, MPM_SHAPE_ELEMENT3, MPM_SHAPE_ELEMENT4},
  {MPM_SHAPE_GIMP, MPM_SHAPE_GIMP_ELEMENT2, MPM_SHAPE_GIMP_ELEMENT3, MPM_SHAPE_GIMP_ELEMENT4},
};

typedef struct {
  PetscInt     first, count;
  PetscReal    weight[WIDE], gradient[WIDE], mean[WIDE];
  MpmShapeLine line;
} Shape;

static void Evaluate(MpmShapeType type, PetscReal xi, PetscReal l, PetscInt cells, Shape *s)
{
  s->line = (MpmShapeLine){.weight = s->weight, .gradient = s->gradient, .mean = s->mean};
  MpmShapeEvaluate(type, MPM_EDGE_LINEAR, xi, l, 0, cells, &s->line);
  s->first = s->line.first;
  s->count = s->line.count;
  ck_assert_int_le(s->count, MpmShapeWidth(type, l));
}

/* Where a node stands, cells. */
static PetscReal Place(PetscInt order, PetscInt node)
{
  return (PetscReal)(node / order) + MpmCellNodes(order)[node % order];
}

/* Powers up to the order about a place are reproduced, in value and gradient, with the mean over any domain. */
START_TEST(powers)
{
  for (PetscInt k = 0; k < (UNIT_SANITIZED ? 800 : 8000); k++) {
    const PetscInt  domain = k % 2, order = 1 + k / 2 % 4, cells = 1 + k % 6, q = k / 8 % (order + 1);
    const PetscReal xi = Uniform(0., (PetscReal)cells), room = PetscMin(xi, (PetscReal)cells - xi),
                    l = domain ? PetscMin(k % 3 ? Uniform(0., 1.6) : 1e-12, room) : 0., about = Uniform(0., 1.) + xi;
    PetscReal value = 0., slope = 0., mean = PetscPowRealInt(xi - about, q),
              steep = q ? (PetscReal)q * PetscPowRealInt(xi - about, q - 1) : 0.;
    Shape s;

    Evaluate(types[domain][order - 1], xi, l, cells, &s);
    for (PetscInt i = 0; i < s.count; i++) {
      const PetscReal power = PetscPowRealInt(Place(order, s.first + i) - about, q);

      value += s.weight[i] * power;
      slope += s.gradient[i] * power;
    }
    if (l > 1e-3) {
      const PetscReal low = xi - l - about, high = xi + l - about;

      mean  = (PetscPowRealInt(high, q + 1) - PetscPowRealInt(low, q + 1)) / ((PetscReal)(q + 1) * 2. * l);
      steep = (PetscPowRealInt(high, q) - PetscPowRealInt(low, q)) / (2. * l);
    }
    ck_assert_double_eq_tol(value, mean, 1e-12 * PetscMax(1., PetscAbsReal(mean)) + (l > 0. && l <= 1e-3 ? 1e-11 : 0.));
    ck_assert_double_eq_tol(slope, steep,
                            1e-11 * PetscMax(1., PetscAbsReal(steep)) + (l > 0. && l <= 1e-3 ? 1e-11 : 0.));
  }
}
END_TEST

/* The functions from Chebyshev polynomials through the nodes, T_n and T_n' = n U_{n-1}, by Gaussian elimination. */
START_TEST(chebyshev)
{
  for (PetscInt k = 0; k < 2000; k++) {
    const PetscInt  order = 2 + k % 3, n = order + 1;
    const PetscReal xi = Uniform(0., 3.), x = 2. * (xi - floor(xi)) - 1.;
    PetscReal       A[5][7], T[5], U[5];
    Shape           s;

    Evaluate(types[0][order - 1], xi, 0., 3, &s);
    for (PetscInt j = 0; j < n; j++) {
      T[j] = cos((PetscReal)j * acos(x));
      U[j] = j ? (PetscReal)j * sin((PetscReal)j * acos(x)) / sin(acos(x)) : 0.;
    }
    for (PetscInt j = 0; j < n; j++) { /* sum_i T_j(x_i) N_i = T_j */
      for (PetscInt i = 0; i < n; i++) A[j][i] = cos((PetscReal)j * acos(2. * MpmCellNodes(order)[i] - 1.));
      A[j][n]     = T[j];
      A[j][n + 1] = 2. * U[j];
    }
    for (PetscInt c = 0; c < n; c++) {
      PetscInt pivot = c;

      for (PetscInt r = c; r < n; r++)
        if (PetscAbsReal(A[r][c]) > PetscAbsReal(A[pivot][c])) pivot = r;
      for (PetscInt m = 0; m < n + 2; m++) {
        const PetscReal swapped = A[c][m];

        A[c][m]     = A[pivot][m];
        A[pivot][m] = swapped;
      }
      for (PetscInt r = 0; r < n; r++) {
        const PetscReal factor = r == c ? 0. : A[r][c] / A[c][c];

        for (PetscInt m = c; factor != 0. && m < n + 2; m++) A[r][m] -= factor * A[c][m];
      }
    }
    for (PetscInt i = 0; i < n; i++) {
      ck_assert_double_eq_tol(s.weight[i], A[i][n] / A[i][i], 1e-13);
      ck_assert_double_eq_tol(s.gradient[i], A[i][n + 1] / A[i][i], 1e-11); /* arccos near the faces */
    }
  }
}
END_TEST

/* Derivatives by the place and the half-length, those of means over cells too, are what central differences give. */
START_TEST(derivatives)
{
  const PetscReal eps = 1e-6;

  for (PetscInt k = 0; k < 3000; k++) {
    const PetscInt     domain = k % 2, order = 2 + k / 2 % 3;
    const MpmShapeType type = types[domain][order - 1];
    const PetscReal    xi   = Uniform(0.1, 5.9),
                    l       = domain ? PetscMin(Uniform(0.05, 1.4), PetscMin(xi, 6. - xi) - 4. * eps) : 0.,
                    reach   = 1e-6 * (l > 0. ? 1. / (l * l) : 1.);
    const PetscReal ends[2] = {xi - l, xi + l};
    PetscReal       by[3][WIDE], mean[2][WIDE];
    Shape           s, at[4];

    if (fabs(ends[0] - round(ends[0])) < 3. * eps || fabs(ends[1] - round(ends[1])) < 3. * eps) continue;
    Evaluate(type, xi, l, 6, &s);
    for (PetscInt m = 0; m < 4; m++) {
      const PetscReal x = xi + (m < 2 ? (m ? eps : -eps) : 0.), half = domain ? l + (m < 2    ? 0.
                                                                                     : m == 3 ? eps
                                                                                              : -eps)
                                                                              : 0.;

      Evaluate(type, x, half, 6, &at[m]);
      MpmShapeMean(type, MPM_EDGE_LINEAR, x, half, 0, 6, &at[m].line);
    }
    const MpmShapePlace  place  = {xi, l, 0, 6};
    const MpmShapeSlopes slopes = {by[0], by[1], by[2]};

    MpmShapeDifferentiate(type, MPM_EDGE_LINEAR, &place, &s.line, &slopes);
    MpmShapeMeanSlopes(type, MPM_EDGE_LINEAR, &place, &s.line, mean[0], mean[1]);
    for (PetscInt i = 0; i < s.count; i++) {
      ck_assert_double_eq_tol((at[1].gradient[i] - at[0].gradient[i]) / (2. * eps), by[0][i], 30. * reach);
      ck_assert_double_eq_tol((at[1].mean[i] - at[0].mean[i]) / (2. * eps), mean[0][i], reach);
      ck_assert_double_eq_tol((at[3].weight[i] - at[2].weight[i]) / (2. * eps), by[1][i], 30. * reach);
      ck_assert_double_eq_tol((at[3].gradient[i] - at[2].gradient[i]) / (2. * eps), by[2][i], 30. * reach);
      ck_assert_double_eq_tol((at[3].mean[i] - at[2].mean[i]) / (2. * eps), mean[1][i], reach);
    }
  }
}
END_TEST

/* ---- in a scene ---- */

static const char *const elements[] = {"element -mpm_order 2",      "element -mpm_order 3",
                                       "element -mpm_order 4",      "gimp_element -mpm_order 2",
                                       "gimp_element -mpm_order 3", "gimp_element -mpm_order 4"};
#define ELEMENTS PETSC_STATIC_ARRAY_LENGTH(elements)

/* A polynomial with all mixed terms of this degree on each axis. */
static PetscReal Polynomial(PetscInt dim, PetscInt degree, const PetscReal x[])
{
  PetscReal value = 1.;

  for (PetscInt a = 0; a < dim; a++) {
    PetscReal sum = 0.;

    for (PetscInt q = 0; q <= degree; q++) sum += PetscPowRealInt(0.2 * (x[a] - 6.), q) / (PetscReal)(q + a + 1);
    value *= sum;
  }
  return value;
}

/* The polynomial at the local nodes, in all components. */
static void SetNodes(MpmModel model, PetscInt degree, PetscInt block, PetscReal u[])
{
  for (PetscInt i = 0; i < model->disc.space->local; i++) {
    PetscReal x[MPM_MAX_DIM];

    MpmNodePosition(&model->disc, i, x);
    for (PetscInt c = 0; c < block; c++) u[i * block + c] = Polynomial(model->disc.dim, degree, x);
  }
}

static PetscErrorCode Scatter(MpmModel model)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt k = 0; k < points.count * model->disc.dim; k++) points.x[k] += Uniform(-0.8, 0.8);
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Largest error at the points of a polynomial of this degree. */
static PetscErrorCode AtPoints(MpmModel model, PetscInt degree, PetscReal *error)
{
  MpmPoints  points;
  PetscReal *u, *value, *gradient;

  PetscFunctionBeginUser;
  *error = 0.;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  PetscCall(
    PetscMalloc3(model->disc.space->local, &u, points.count, &value, (points.count * model->disc.dim), &gradient));
  SetNodes(model, degree, 1, u);
  PetscCall(MpmScalarAtPoints(model->disc.sum, u, value, gradient));
  for (PetscInt p = 0; p < points.count; p++)
    *error =
      PetscMax(*error, PetscAbsReal(value[p] - Polynomial(model->disc.dim, degree, &points.x[p * model->disc.dim])));
  PetscCall(PetscFree3(u, value, gradient));
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, error, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(random_points)
{
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (PetscInt order = 1; order <= 4; order++) {
      char      shape[64];
      MpmModel  model;
      PetscReal error;

      snprintf(shape, sizeof(shape), "element -mpm_order %d", (int)order);
      SCENE_CALL(BlockCreate(dim, shape, BLOCK_DRY, "-mpm_stabilization_filled 0 -mpm_jacobian matfree", &model));
      SCENE_CALL(Scatter(model));
      SCENE_CALL(SceneBegin(model, 0.25));
      SCENE_CALL(AtPoints(model, order, &error));
      ck_assert_msg(error <= 1e-12, "%dD %s: error %g", (int)dim, shape, (double)error);
      SCENE_CALL(AtPoints(model, order + 1, &error));
      ck_assert_msg(error >= 1e-9, "%dD %s: no error one degree further", (int)dim, shape);
      SCENE_CALL(SceneDestroy(&model));
    }
  }
}
END_TEST

/* The penalty's largest force on a polynomial, and on noise. */
static PetscErrorCode Forces(MpmModel model, PetscInt degree, PetscReal norm[2])
{
  const PetscInt bs = model->disc.block, dim = model->disc.dim, n = model->disc.space->local * bs;
  PetscReal     *u, *f;
  PetscInt       failed;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(n, &u, n, &f));
  for (PetscInt kind = 0; kind < 2; kind++) {
    norm[kind] = 0.;
    SetNodes(model, degree, bs, u);
    for (PetscInt k = 0; k < n; k++) {
      const PetscInt *node = &model->disc.space->node[k / bs * dim];

      if (kind) u[k] = SceneRandom(1, (node[0] * 100 + node[1]) * 100 + (dim > 2 ? node[2] : 0), k % bs);
      f[k] = 0.;
    }
    PetscCall(MpmTermGhost.residual(NULL, model->disc.sum, u, f, &failed));
    PetscCall(MpmSpaceAddToOwners(model->disc.space, bs, f));
    for (PetscInt k = 0; k < model->disc.space->owned * bs; k++) norm[kind] = PetscMax(norm[kind], PetscAbsReal(f[k]));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, norm, 2, MPIU_REAL, MPIU_MAX, model->comm));
  PetscCall(PetscFree2(u, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(ghost_penalty)
{
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (size_t s = 0; s < ELEMENTS; s++) {
      MpmModel  model;
      PetscReal norm[2];
      PetscInt  order;

      SCENE_CALL(BlockCreate(dim, elements[s], BLOCK_DRY, "-mpm_stabilization_ghost 1 -mpm_jacobian matfree", &model));
      SCENE_CALL(BlockShift(model, 0.3));
      SCENE_CALL(SceneBegin(model, 0.25));
      order = MpmShapeOrder(model->scene.shape.type);
      SCENE_CALL(Forces(model, order, norm));
      ck_assert_msg(norm[1] > 0., "%dD %s: no penalty", (int)dim, elements[s]);
      ck_assert_msg(norm[0] <= 1e-11 * norm[1], "%dD %s: force %g on a polynomial, %g on noise", (int)dim, elements[s],
                    (double)norm[0], (double)norm[1]);
      SCENE_CALL(SceneDestroy(&model));
    }
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {powers, chebyshev, derivatives, random_points, ghost_penalty};

  return UnitRun(&argc, &argv, "element", sizeof(tests) / sizeof(tests[0]), tests);
}
