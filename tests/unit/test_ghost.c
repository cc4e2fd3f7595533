/*
  The ghost penalty vanishes for polynomials in the shapes' space. On all faces it leaves pressures alone and resists
  increments that alternate from cell to cell.

  Ranks: 1 2
*/
#include "volume/volume.h"
#include "scene.h"
#include "assembly/terms.h"

static const char *const shapes[] = {"linear", "gimp", "bspline2", "bspline3", "gimp_bspline2"};

#define FACTOR "1e-2"

static PetscErrorCode Create(PetscInt dim, const char *shape, const char *ghost, MpmModel *model)
{
  char options[2048];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "-mpm_dim %d -mpm_grid_lower %s -mpm_grid_upper %s -mpm_grid_cells %s -mpm_shape %s -mpm_materials m "
    "-mpm_material_m_type hencky -mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 -mpm_bodies b -mpm_body_b_material m "
    "-mpm_body_b_region box -mpm_body_b_lower %s -mpm_body_b_upper %s -mpm_time_step 0.25 -pc_type jacobi "
    "-mpm_stabilization_ghost %s",
    (int)dim, dim == 2 ? "0,0" : "0,0,0", dim == 2 ? "12,12" : "8,8,8", dim == 2 ? "12,12" : "8,8,8", shape,
    dim == 2 ? "3,3" : "2,2,2", dim == 2 ? "9,9" : "5,5,5", ghost));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A scene of saturated ground, with a step and a permeability for which both terms of the pressure's factor count. */
static PetscErrorCode CreatePoro(PetscInt dim, const char *shape, const char *ghost, MpmModel *model)
{
  char options[2048];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "-mpm_dim %d -mpm_physics poro -mpm_grid_lower %s -mpm_grid_upper %s -mpm_grid_cells %s -mpm_shape %s "
    "-mpm_materials m "
    "-mpm_material_m_type linear_elastic -mpm_material_m_E 1e6 -mpm_material_m_nu 0.25 -mpm_material_m_porosity 0.4 "
    "-mpm_material_m_permeability 1e-9 -mpm_bodies b -mpm_body_b_material m -mpm_body_b_region box -mpm_body_b_lower "
    "%s "
    "-mpm_body_b_upper %s -mpm_time_step 0.25 -mpm_stabilization_ghost %s",
    (int)dim, dim == 2 ? "0,0" : "0,0,0", dim == 2 ? "12,12" : "8,8,8", dim == 2 ? "12,12" : "8,8,8", shape,
    dim == 2 ? "3,3" : "2,2,2", dim == 2 ? "9,9" : "5,5,5", ghost));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* All points move by the same part of a cell. */
static PetscErrorCode Shift(MpmModel model, PetscReal part)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt k = 0; k < points.count * model->disc.dim; k++)
    points.x[k] += part * model->disc.h[k % model->disc.dim];
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Power(PetscInt node, PetscInt power)
{
  return PetscPowRealInt(0.2 * ((PetscReal)node - 6.), power);
}

/* Coefficient of a node on one axis in a spline whose coefficients are those powers; at a not-a-knot end the spline's
   value. */
static PetscReal Coefficient(MpmModel model, PetscInt node, PetscInt cells, PetscInt power)
{
  const PetscInt degree = MpmShapeDegree(model->scene.shape.type);

  if (model->scene.shape.edge == MPM_EDGE_LINEAR || degree == 1 || (node > 0 && node < cells))
    return Power(node, power);
  if (degree == 2) return (Power(node - 1, power) + 6. * Power(node, power) + Power(node + 1, power)) / 8.;
  return (Power(node - 1, power) + 4. * Power(node, power) + Power(node + 1, power)) / 6.;
}

/* The penalty's force on nodal values sum_a x_a^degree (centred), and the same for random values of that size. */
static PetscErrorCode Forces(MpmModel model, PetscInt degree, PetscReal *polynomial, PetscReal *random)
{
  const PetscInt bs = model->disc.block, dim = model->disc.dim, n = model->disc.space->local * bs;
  PetscReal     *u, *f, norm[2];
  PetscInt       failed;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(n, &u, n, &f));
  for (PetscInt kind = 0; kind < 2; kind++) {
    norm[kind] = 0.;
    for (PetscInt k = 0; k < n; k++) {
      const PetscInt *node  = &model->disc.space->node[k / bs * dim];
      PetscReal       value = 0.;

      for (PetscInt a = 0; a < dim; a++) value += Coefficient(model, node[a], model->disc.grid->cells[a], degree);
      u[k] = kind ? SceneRandom(1, (node[0] * 100 + node[1]) * 100 + (dim > 2 ? node[2] : 0), k % bs) : value;
      f[k] = 0.;
    }
    PetscCall(MpmTermGhost.residual(NULL, model->disc.sum, u, f, &failed));
    PetscCall(MpmSpaceAddToOwners(model->disc.space, bs, f));
    for (PetscInt k = 0; k < model->disc.space->owned * bs; k++) norm[kind] = PetscMax(norm[kind], PetscAbsReal(f[k]));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, norm, 2, MPIU_REAL, MPIU_MAX, model->comm));
  *polynomial = norm[0];
  *random     = norm[1];
  PetscCall(PetscFree2(u, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Up to its own degree a spline has no jump; one degree further it has. `factor` is by dimension; further options may
   follow it. */
static void CheckPolynomials(const char *const factor[])
{
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(shapes); s++) {
      MpmModel  model;
      PetscInt  degree;
      PetscReal polynomial, random;

      SCENE_CALL(Create(dim, shapes[s], factor[dim - 2], &model));
      SCENE_CALL(Shift(model, 0.3));
      SCENE_CALL(SceneBegin(model, 0.25));
      degree = MpmShapeDegree(model->scene.shape.type);
      ck_assert_msg(SceneAll((PetscBool)(model->disc.space->boxes.faces.count > 0 || model->size > 1)),
                    "%s has no faces", shapes[s]);
      SCENE_CALL(Forces(model, degree, &polynomial, &random));
      ck_assert_msg(random > 0., "%dD %s: no penalty", (int)dim, shapes[s]);
      ck_assert_msg(polynomial <= 1e-12 * random, "%dD %s: force %g on a polynomial, %g on noise", (int)dim, shapes[s],
                    (double)polynomial, (double)random);
      SCENE_CALL(Forces(model, degree + 1, &polynomial, &random));
      ck_assert_msg(polynomial >= 1e-6 * random, "%dD %s: no force one degree further", (int)dim, shapes[s]);
      SCENE_CALL(SceneDestroy(&model));
    }
  }
}

START_TEST(polynomials)
{
  static const char *const factor[] = {"1", "1"};

  CheckPolynomials(factor);
}
END_TEST

START_TEST(interior_polynomials)
{
  static const char *const factor[] = {"off -mpm_stabilization_interior 1", "0.1 -mpm_stabilization_interior 1"};

  CheckPolynomials(factor);
}
END_TEST

/* Polynomials up to the grid's edges, with splines that reproduce all of them there. */
START_TEST(polynomials_at_open_edges)
{
  static const char *const factor[] = {"1 -mpm_shape_edge open -mpm_body_b_lower 0,0 -mpm_body_b_upper 11,3",
                                       "1 -mpm_shape_edge open -mpm_body_b_lower 0,0,0 -mpm_body_b_upper 7,3,3"};

  CheckPolynomials(factor);
}
END_TEST

/* The penalty on a pressure is that on a displacement, times minus dt m + S/(1 + 50 dt m/S) over E, S = h^2/(2 mu);
   the sum of its water vanishes. */
static PetscErrorCode LookAtPressure(MpmModel model, PetscReal *ratio, PetscReal *apart, PetscReal *sum)
{
  const PetscInt bs = model->disc.block, dim = model->disc.dim, n = model->disc.space->local * bs;
  PetscReal     *u, *f, numbers[4] = {0.}, most = 0.;
  PetscInt       failed;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2(n, &u, n, &f));
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt *node = &model->disc.space->node[k / bs * dim];

    u[k] = SceneRandom(1, (node[0] * 100 + node[1]) * 100 + (dim > 2 ? node[2] : 0), 0); /* of all components alike */
    f[k] = 0.;
  }
  PetscCall(MpmTermGhost.residual(NULL, model->disc.sum, u, f, &failed));
  PetscCall(MpmSpaceAddToOwners(model->disc.space, bs, f));
  for (PetscInt i = 0; i < model->disc.space->owned; i++) {
    numbers[0] += f[i * bs] * f[i * bs + dim];
    numbers[1] += PetscSqr(f[i * bs]);
    numbers[2] += PetscSqr(f[i * bs + dim]);
    numbers[3] += f[i * bs + dim];
    most = PetscMax(most, PetscAbsReal(f[i * bs + dim]));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, numbers, 4, MPIU_REAL, MPIU_SUM, model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPIU_MAX, model->comm));
  *ratio = numbers[0] / numbers[1];
  *apart = 1. - PetscSqr(numbers[0]) / (numbers[1] * numbers[2]);
  *sum   = PetscAbsReal(numbers[3]) / most;
  PetscCall(PetscFree2(u, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(pressure)
{
  const PetscReal E = 1e6, mu = E / (2. * 1.25), mobility = 1e-9 / 1e-3, dt = 0.25;
  const PetscReal storage  = 1. / (2. * mu),
                  expected = -(dt * mobility + storage / (1. + 50. * dt * mobility / storage)) / E;

  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(shapes); s++) {
      MpmModel  model;
      PetscReal ratio, apart, sum;

      SCENE_CALL(CreatePoro(dim, shapes[s], FACTOR, &model));
      SCENE_CALL(Shift(model, 0.3));
      SCENE_CALL(SceneBegin(model, dt));
      SCENE_CALL(LookAtPressure(model, &ratio, &apart, &sum));
      ck_assert_msg(PetscAbsReal(ratio / expected - 1.) <= 1e-12, "%dD %s: factor %g, expected %g", (int)dim, shapes[s],
                    (double)ratio, (double)expected);
      ck_assert_msg(PetscAbsReal(apart) <= 1e-12, "%dD %s: another form by %g", (int)dim, shapes[s], (double)apart);
      ck_assert_msg(sum <= 1e-11, "%dD %s: rows sum to %g", (int)dim, shapes[s], (double)sum);
      SCENE_CALL(SceneDestroy(&model));
    }
  }
}
END_TEST

/* The penalty's energy of a displacement along x that alternates along y, 1 and -1, and the largest force on the
   pressure at a node. */
static PetscErrorCode Alternate(MpmModel model, PetscReal *energy, PetscReal *water)
{
  const PetscInt bs = model->disc.block, dim = model->disc.dim, n = model->disc.space->local * bs;
  PetscReal     *u, *f;
  PetscInt       failed;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(n, &u, n, &f));
  for (PetscInt i = 0; i < model->disc.space->local; i++) {
    u[i * bs] = model->disc.space->node[i * dim + 1] % 2 ? -1. : 1.;
    if (bs > dim) u[i * bs + dim] = u[i * bs];
  }
  PetscCall(MpmTermGhost.residual(NULL, model->disc.sum, u, f, &failed));
  *energy = *water = 0.;
  for (PetscInt i = 0; i < model->disc.space->local; i++) {
    *energy += u[i * bs] * f[i * bs] / 2.;
    if (bs > dim) *water = PetscMax(*water, PetscAbsReal(f[i * bs + dim]));
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, energy, 1, MPIU_REAL, MPIU_SUM, model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, water, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscCall(PetscFree2(u, f));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Where the penalty is on all faces, one of normal y between 6 x 6 cells costs (gamma/2) E h^-1 (1 + 2 + 1)^2 (per h of
  length, h = 1): there are 5 rows of 6. The faces of edge cells alone are fewer: all but 3 x 4. Only the latter act on
  pressures.
*/
START_TEST(interior)
{
  static const char *const factor[] = {"0.01 -mpm_stabilization_interior 0", "off -mpm_stabilization_interior 0.01",
                                       "0.01 -mpm_stabilization_interior 0.01"};
  static const PetscReal   faces[]  = {18., 30., 30.};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(factor); k++) {
    const PetscReal expected = faces[k] * 0.5 * 0.01 * 1e6 * 16.;
    MpmModel        model;
    PetscReal       energy, water;

    SCENE_CALL(CreatePoro(2, "linear", factor[k], &model));
    SCENE_CALL(SceneBegin(model, 0.25));
    SCENE_CALL(Alternate(model, &energy, &water));
    ck_assert_msg(PetscAbsReal(energy / expected - 1.) <= 1e-12, "%s: energy %g, expected %g", factor[k],
                  (double)energy, (double)expected);
    ck_assert_msg((k == 1) == (water == 0.), "%s: force %g on the pressure", factor[k], (double)water);
    SCENE_CALL(SceneDestroy(&model));
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {polynomials, interior_polynomials, interior, polynomials_at_open_edges, pressure};

  return UnitRun(&argc, &argv, "ghost", sizeof(tests) / sizeof(tests[0]), tests);
}
