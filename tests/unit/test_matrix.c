/*
  The Jacobian's values on their two ways into the matrix: blocks and arrays, which PETSc's types on the host take, and
  lists of coordinates and values, which GPU types take. Both must give one matrix; and a type with coordinates alone
  must do.

  Ranks: 1 2 3
*/
#include <petsc/private/matimpl.h>
#include "scene.h"
#include "problem/discretization.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"

static const char *const scenes[] = {
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2 -mpm_grid_cells 6,5 -mpm_body_b_region box -mpm_body_b_lower "
  "0.5,0.4 "
  "-mpm_body_b_upper 2.5,1.6 -mpm_bcs floor,side -mpm_bc_side_region box -mpm_bc_side_lower 0.5,0 -mpm_bc_side_upper "
  "0.5,2 -mpm_bc_side_components x "
  "-mpm_bc_floor_region box -mpm_bc_floor_lower 0,0.4 -mpm_bc_floor_upper "
  "3,0.4 "
  "-mpm_bc_floor_normal -0.3,2 ",
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 2,2,1.2 -mpm_grid_cells 4,4,3 -mpm_body_b_region box "
  "-mpm_body_b_lower 0.5,0.5,0.4 -mpm_body_b_upper 1.5,1.5,0.8 -mpm_bcs floor -mpm_bc_floor_region box "
  "-mpm_bc_floor_lower 0,0,0.4 -mpm_bc_floor_upper 2,2,0.4 -mpm_bc_floor_components x,y,z ",
};
static const char *const common =
  "-mpm_physics solid -mpm_shape gimp -mpm_time_end 1 -mpm_time_step 0.5 -mpm_materials m -mpm_material_m_type hencky "
  "-mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 "
  "-mpm_material_m_density 1000 -mpm_bodies b -mpm_body_b_material m -mpm_body_b_points_per_cell ";
#define COORDINATES_ONLY "coordinates_only"

static PetscErrorCode RefuseValues(Mat mat, PetscInt m, const PetscInt i[], PetscInt n, const PetscInt j[],
                                   const PetscScalar v[], InsertMode mode)
{
  (void)m, (void)i, (void)n, (void)j, (void)v, (void)mode;
  SETERRQ(PetscObjectComm((PetscObject)mat), PETSC_ERR_SUP, "this matrix takes coordinates and values only");
}

/* AIJ takes coordinates under its own name only. */
typedef PetscErrorCode (*Preallocation)(Mat, PetscCount, PetscInt[], PetscInt[]);

static PetscErrorCode PreallocateCoordinates(Mat mat, PetscCount n, PetscInt i[], PetscInt j[])
{
  Preallocation of_aij;
  PetscMPIInt   size;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm((PetscObject)mat), &size));
  PetscCall(PetscObjectQueryFunction((PetscObject)mat, "aij_coordinates", &of_aij));
  PetscCall(PetscObjectChangeTypeName((PetscObject)mat, size > 1 ? MATMPIAIJ : MATSEQAIJ));
  PetscCall(of_aij(mat, n, i, j));
  PetscCall(PetscObjectChangeTypeName((PetscObject)mat, COORDINATES_ONLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AIJ inside, but by its name nobody knows, and blocks of values are refused. */
static PetscErrorCode CreateCoordinatesOnly(Mat mat)
{
  Preallocation of_aij;

  PetscFunctionBeginUser;
  PetscCall(MatSetType(mat, MATAIJ));
  PetscCall(PetscObjectQueryFunction((PetscObject)mat, "MatSetPreallocationCOO_C", &of_aij));
  PetscCall(PetscObjectComposeFunction((PetscObject)mat, "aij_coordinates", of_aij));
  PetscCall(PetscObjectComposeFunction((PetscObject)mat, "MatSetPreallocationCOO_C", PreallocateCoordinates));
  mat->ops->setvalues = RefuseValues;
  PetscCall(PetscObjectChangeTypeName((PetscObject)mat, COORDINATES_ONLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Create(size_t k, const char *more, MpmModel *model)
{
  char options[4096];

  PetscFunctionBeginUser;
  PetscCall(MatRegister(COORDINATES_ONLY, CreateCoordinatesOnly));
  PetscCall(PetscSNPrintf(options, sizeof(options), "%s%s%s %s", scenes[k], common, k ? "2,1,2" : "2,2", more));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The Jacobian at x in a matrix of that type, whose values come as coordinates. */
static PetscErrorCode ByCoordinates(MpmModel model, Mat *mat)
{
  MpmDiscretization *disc = &model->disc;
  PetscInt           failed;

  PetscFunctionBeginUser;
  PetscCall(MpmPatternCreateMat(disc->matrix.pattern, disc->space, model->comm, COORDINATES_ONLY, mat));
  ck_assert(disc->matrix.pattern->coordinates);
  PetscCall(MpmGatherSolution(&model->solver, model->solver.x));
  for (PetscInt again = 0; again < 2; again++) { /* a second time in the same matrix */
    PetscCall(MpmPatternBegin(disc->matrix.pattern, disc->space, disc->constraints, *mat));
    PetscCall(MpmTermsTangent(disc->terms, disc->sum, disc->nodal.u, disc->matrix.pattern, NULL, &failed));
    PetscCall(MpmPatternEnd(disc->matrix.pattern, disc->space, *mat));
  }
  disc->matrix.pattern->coordinates = PETSC_FALSE;
  PetscCall(PetscObjectChangeTypeName((PetscObject)*mat, model->size > 1 ? MATMPIAIJ : MATSEQAIJ));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(test_same_matrix)
{
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(scenes); k++) {
    for (PetscInt fbar = 0; fbar < 2; fbar++) {
      const PetscReal amplitude[] = {0.02, 0.02, 0.02};
      MpmModel        model;
      Mat             direct, coordinates;
      PetscReal       difference;

      SCENE_CALL(Create(k, fbar ? "-mpm_stabilization_fbar true" : "-mpm_stabilization_fbar false", &model));
      SCENE_CALL(SceneBegin(model, 0.25));
      SCENE_CALL(SceneFill(model, 1, amplitude, PETSC_FALSE, model->solver.x));
      SCENE_CALL(SceneJacobian(model, MPM_JACOBIAN_LOCAL, model->solver.x, &direct));
      SCENE_CALL(ByCoordinates(model, &coordinates));
      SCENE_CALL(SceneDifference(direct, &coordinates, &difference));
      ck_assert_msg(SceneAll((PetscBool)(difference <= (model->size > 1 ? 1e-15 : 0.))), "%dD, F-bar %d: %g",
                    (int)model->disc.dim, (int)fbar, (double)difference);
      SCENE_CALL(MatDestroy(&direct));
      SCENE_CALL(SceneDestroy(&model));
    }
  }
}
END_TEST

START_TEST(test_run)
{
  const char *const load = "-mpm_loads w -mpm_load_w_type gravity -mpm_load_w_value 0,-9.81%s "
                           "-mpm_solver pbjacobi -ksp_rtol 1e-13 -snes_rtol 1e-12 -mpm_mat_type %s";

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(scenes); k++) {
    MpmModel  model[2];
    PetscReal difference = 0.;

    for (int m = 0; m < 2; m++) {
      char options[1024];

      snprintf(options, sizeof(options), load, k ? ",0" : "", m ? COORDINATES_ONLY : MATAIJ);
      SCENE_CALL(Create(k, options, &model[m]));
      SCENE_CALL(SceneRun(model[m]));
    }
    SCENE_CALL(SceneFieldDifference(model[0], model[1], model[0]->disc.dim, "position", "position0", &difference));
    ck_assert_msg(SceneAll((PetscBool)(difference <= 1e-10)), "%dD: %g", (int)model[0]->disc.dim, (double)difference);
    for (int m = 0; m < 2; m++) SCENE_CALL(SceneDestroy(&model[m]));
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {test_same_matrix, test_run};

  return UnitRun(&argc, &argv, "matrix", sizeof(tests) / sizeof(tests[0]), tests);
}
