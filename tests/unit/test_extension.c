/*
  Aggregation of small-cut nodes: followers have what linear fields have there, the same nodes follow on any number
  of ranks, and the iterations of a plain Krylov method are bounded as a body moves over a cell.

  Ranks: 1 2 3
*/
#include "scene.h"
#include "extension/extension.h"
#include "assembly/terms.h"

static const char *const shapes[] = {"linear", "gimp", "bspline2", "bspline3", "gimp_bspline2"};

/* holds the lower part of the body in 2D */
static const char *const floor_2d = "-mpm_bcs floor -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0 "
                                    "-mpm_bc_floor_upper 12,5 -mpm_bc_floor_components x,y";

static PetscErrorCode Create(PetscInt dim, const char *shape, const char *filled, PetscBool held, MpmModel *model)
{
  char options[2048];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "-mpm_dim %d -mpm_grid_lower %s -mpm_grid_upper %s -mpm_grid_cells %s -mpm_shape %s -mpm_materials m "
    "-mpm_material_m_type hencky -mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 -mpm_bodies b -mpm_body_b_material m "
    "-mpm_body_b_region box -mpm_body_b_lower %s -mpm_body_b_upper %s %s -mpm_time_step 0.25 -pc_type jacobi "
    "-mpm_stabilization_filled %s",
    (int)dim, dim == 2 ? "0,0" : "0,0,0", dim == 2 ? "12,12" : "8,8,8", dim == 2 ? "12,12" : "8,8,8", shape,
    dim == 2 ? "3,3" : "2,2,2", dim == 2 ? "9,9" : "5,5,5", held ? floor_2d : "", filled));
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

/* Largest error of the followers' values where all others have coefficients of sum_a x_a^degree; followers on all
   ranks. */
static PetscErrorCode Extend(MpmModel model, PetscInt degree, PetscReal *error, PetscInt *followers)
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  bs = model->disc.block, dim = model->disc.dim, n = space->local * bs;
  PetscReal      *u, *value;

  PetscFunctionBeginUser;
  *error     = 0.;
  *followers = 0;
  PetscCall(PetscMalloc2(n, &u, n, &value));
  for (PetscInt k = 0; k < n; k++) {
    const PetscInt *node = &space->node[k / bs * dim];

    value[k] = 0.;
    for (PetscInt a = 0; a < dim; a++) value[k] += Coefficient(model, node[a], model->disc.grid->cells[a], degree);
    u[k] = model->disc.constraints->condition[k] == MPM_FOLLOWS ? 1e30 : value[k];
  }
  MpmConstraintsExtend(model->disc.constraints, space, u);
  for (PetscInt k = 0; k < n; k++) *error = PetscMax(*error, PetscAbsReal(u[k] - value[k]));
  for (PetscInt k = 0; k < space->owned * bs; k++) *followers += model->disc.constraints->condition[k] == MPM_FOLLOWS;
  PetscCall(PetscFree2(u, value));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, error, 1, MPIU_REAL, MPIU_MAX, model->comm));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, followers, 1, MPIU_INT, MPI_SUM, model->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Numbers of unknowns that follow, by shape, in 2D and 3D. Linear, GIMP: the cells of the upper faces are filled by 0.3;
  the 7 nodes behind each of them in 2D and the corner, less shared ones. The others as one rank has them.
*/
static const PetscInt expected[2][5] = {{30, 30, 0, 38, 34}, {186, 186, 0, 384, 273}};

START_TEST(polynomials)
{
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(shapes); s++) {
      MpmModel  model;
      PetscReal error;
      PetscInt  followers, degree;

      SCENE_CALL(Create(dim, shapes[s], "0.45", PETSC_FALSE, &model));
      SCENE_CALL(Shift(model, 0.3));
      SCENE_CALL(SceneBegin(model, 0.25));
      degree = 1;
      SCENE_CALL(Extend(model, degree, &error, &followers));
      printf("%dD %s: %d unknowns follow, error %g\n", (int)dim, shapes[s], (int)followers, (double)error);
      ck_assert_int_eq(followers, expected[dim - 2][s]);
      ck_assert_msg(error <= 1e-12, "%dD %s: polynomials of degree %d are off by %g", (int)dim, shapes[s], (int)degree,
                    (double)error);
      SCENE_CALL(SceneDestroy(&model));
    }
  }
}
END_TEST

/* Iterations of CG with the diagonal as preconditioner for a random right-hand side. */
static PetscErrorCode Iterations(MpmModel model, PetscInt *iterations)
{
  PetscReal amplitude[MPM_MAX_DIM] = {1., 1., 1.};
  Vec       b;
  KSP       ksp;
  PC        pc;
  Mat       J;

  PetscFunctionBeginUser;
  PetscCall(SceneBegin(model, 0.25));
  PetscCall(VecZeroEntries(model->solver.x));
  PetscCall(SceneJacobian(model, MPM_JACOBIAN_LOCAL, model->solver.x, &J));
  PetscCall(VecDuplicate(model->solver.x, &b));
  PetscCall(SceneFill(model, 1, amplitude, PETSC_TRUE, b));
  PetscCall(KSPCreate(model->comm, &ksp));
  PetscCall(KSPSetOperators(ksp, J, J));
  PetscCall(KSPSetType(ksp, KSPCG));
  PetscCall(KSPSetTolerances(ksp, 1e-8, PETSC_DEFAULT, PETSC_DEFAULT, 20000));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCJACOBI));
  PetscCall(KSPSolve(ksp, b, model->solver.x));
  PetscCall(KSPGetIterationNumber(ksp, iterations));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(VecDestroy(&b));
  PetscCall(MatDestroy(&J));
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define POSITIONS 25

/* Worst over best number of iterations over the positions in a cell. */
static PetscErrorCode Slide(PetscInt dim, const char *shape, const char *filled, PetscReal *ratio)
{
  PetscInt worst = 0, best = PETSC_INT_MAX;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < POSITIONS; k++) {
    MpmModel model;
    PetscInt iterations;

    PetscCall(Create(dim, shape, filled, PETSC_TRUE, &model));
    PetscCall(Shift(model, ((PetscReal)k + 1e-3) / POSITIONS));
    PetscCall(Iterations(model, &iterations));
    worst = PetscMax(worst, iterations);
    best  = PetscMin(best, iterations);
    PetscCall(SceneDestroy(&model));
  }
  *ratio = (PetscReal)worst / (PetscReal)best;
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(sliding)
{
  for (size_t s = 0; s < PETSC_STATIC_ARRAY_LENGTH(shapes); s++) {
    PetscReal with = 0., without = 0.;

    SCENE_CALL(Slide(2, shapes[s], "0.45", &with));
    SCENE_CALL(Slide(2, shapes[s], "0", &without));
    printf("2D %s: worst over best iterations %.2f with aggregation, %.2f without\n", shapes[s], (double)with,
           (double)without);
    ck_assert_msg(with <= 3.5, "2D %s: iterations vary by a factor of %g", shapes[s], (double)with);
    ck_assert_msg(without >= 1.05 * with, "2D %s: %g without aggregation, %g with", shapes[s], (double)without,
                  (double)with);
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {polynomials, sliding};

  return UnitRun(&argc, &argv, "aggregation", sizeof(tests) / sizeof(tests[0]), tests);
}
