/*
  A step as a minimisation: the objective's derivative is the residual, for each law that has an energy, each shape and
  integrator, in a body that has moved before; without a potential there is no objective.

  Ranks: 1 2 3
*/
#include "step/integrator.h"
#include "scene.h"

static const char *const scene_2d =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2 -mpm_grid_cells 6,5 -mpm_body_b_region box "
  "-mpm_body_b_lower 0.5,0.4 -mpm_body_b_upper 2.5,1.6 -mpm_bcs floor,edge -mpm_bc_floor_region box "
  "-mpm_bc_floor_lower 0,0.4 "
  "-mpm_bc_floor_upper 3,0.4 -mpm_bc_floor_components x,y -mpm_bc_floor_value 0.01,-0.006 -mpm_bc_edge_region box "
  "-mpm_bc_edge_lower 2.5,0.6 "
  "-mpm_bc_edge_upper 2.5,2 -mpm_bc_edge_normal 1,0.4 -mpm_loads weight,pull -mpm_load_weight_type gravity "
  "-mpm_load_weight_value 1,-9 "
  "-mpm_load_pull_type traction -mpm_load_pull_value 20,30 -mpm_load_pull_region box -mpm_load_pull_lower 0.5,1.5 "
  "-mpm_load_pull_upper 2.5,1.6 "
  "-mpm_load_pull_face +y ";
static const char *const scene_3d =
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 2,2,1.2 -mpm_grid_cells 4,4,3 -mpm_body_b_region box "
  "-mpm_body_b_lower 0.5,0.5,0.4 -mpm_body_b_upper 1.5,1.5,0.8 -mpm_body_b_points_per_cell 2,1,2 -mpm_bcs floor "
  "-mpm_bc_floor_region box "
  "-mpm_bc_floor_lower 0,0,0.4 -mpm_bc_floor_upper 2,2,0.4 -mpm_bc_floor_components x,y,z -mpm_bc_floor_value "
  "0.01,-0.006,0.004 "
  "-mpm_loads weight -mpm_load_weight_type gravity -mpm_load_weight_value 1,2,-9 ";
static const char *const common = "-mpm_materials m -mpm_bodies b -mpm_body_b_material m -mpm_material_m_density 10 "
                                  "-mpm_time_step 0.1 -mpm_time_end 1 -mpm_output_prefix "
                                  "/tmp/talus_potential -mpm_stabilization_fbar false -mpm_quiet ";

static const char *const laws[] = {
  "-mpm_material_m_type neo_hookean -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 ",
  "-mpm_material_m_type neo_hookean -mpm_material_m_E 1e3 -mpm_material_m_nu 0.4 -mpm_material_m_shear isochoric ",
  "-mpm_material_m_type ogden -mpm_material_m_terms -2:-100,2:400 -mpm_material_m_nu 0.4 ",
  "-mpm_material_m_type hencky -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 ",
  "-mpm_material_m_type linear_elastic -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 "};
static const char *const times[] = {
  "", "-mpm_time_integrator backward_euler ", "-mpm_time_integrator newmark -mpm_time_mass lumped ",
  "-mpm_time_integrator newmark -mpm_time_transfer flip ", "-mpm_time_integrator generalized_alpha "};

static PetscErrorCode Create(PetscInt dim, const char *shape, const char *law, const char *more, MpmModel *model)
{
  char options[4096];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(options, sizeof(options), "%s%s%s%s -mpm_shape %s", dim == 2 ? scene_2d : scene_3d, common,
                          law, more, shape));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A step with the scene's integrator, up to Newton. */
static PetscErrorCode Begin(MpmModel model)
{
  MpmOutcome outcome;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesMigrate(model->state.particles, model->disc.grid));
  PetscCall(model->state.scheme.integrator->begin(model, model->state.time + 0.1, 0.1, PETSC_FALSE, &outcome));
  PetscCheck(!outcome.code, PETSC_COMM_WORLD, PETSC_ERR_PLIB, "%s", outcome.text);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The objective at x + s v. */
static PetscErrorCode At(MpmModel model, Vec x, PetscReal s, Vec v, PetscReal *value)
{
  Vec w;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(x, &w));
  PetscCall(VecWAXPY(w, s, v, x));
  PetscCall(SNESComputeObjective(model->solver.snes, w, value));
  PetscCall(VecDestroy(&w));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Differences of fourth order against the residual, over what that is; along the residual, and along what comes. */
static PetscErrorCode Compare(MpmModel model, PetscInt dim, PetscReal *error)
{
  const PetscReal amplitude[] = {0.02, 0.02, 0.02};
  const PetscReal length      = 1e-3;
  Vec             x, f, v;
  PetscScalar     slope;
  PetscReal       value[4], norm[2];

  PetscFunctionBeginUser;
  (void)dim;
  PetscCall(VecDuplicate(model->solver.x, &x));
  PetscCall(VecDuplicate(x, &f));
  PetscCall(VecDuplicate(x, &v));
  PetscCall(SceneFill(model, 1, amplitude, PETSC_FALSE, x));
  PetscCall(SNESComputeFunction(model->solver.snes, x, f));
  PetscCall(SceneFill(model, 2, amplitude, PETSC_TRUE, v));
  PetscCall(VecNorm(f, NORM_2, &norm[0]));
  PetscCall(VecNorm(v, NORM_2, &norm[1]));
  PetscCall(VecAXPY(v, norm[1] / norm[0], f)); /* constrained unknowns have no residual */
  PetscCall(VecDot(f, v, &slope));
  for (PetscInt k = 0; k < 4; k++) PetscCall(At(model, x, length * (PetscReal[]){-2., -1., 1., 2.}[k], v, &value[k]));
  *error =
    PetscAbsReal((8. * (value[2] - value[1]) - (value[3] - value[0])) / (12. * length) / PetscRealPart(slope) - 1.);
  PetscCall(VecDestroy(&x));
  PetscCall(VecDestroy(&f));
  PetscCall(VecDestroy(&v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Look(PetscInt dim, const char *shape, const char *law, const char *time, PetscReal *error)
{
  const PetscReal amplitude[] = {0.02, 0.02, 0.02};
  MpmModel        model;
  Vec             x;

  PetscFunctionBeginUser;
  PetscCall(Create(dim, shape, law, time, &model));
  ck_assert(model->solver.cache.minimisation.on);
  PetscCall(SceneBegin(model, 0.1));
  PetscCall(VecDuplicate(model->solver.x, &x));
  PetscCall(SceneFill(model, 3, amplitude, PETSC_FALSE, x));
  PetscCall(SceneCommit(model, x));
  PetscCall(VecDestroy(&x));
  PetscCall(Begin(model));
  PetscCall(Compare(model, dim, error));
  PetscCall(SceneDestroy(&model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(derivative)
{
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (PetscInt shape = 0; shape < MPM_SHAPE_COUNT; shape++) {
      for (size_t l = 0; l < PETSC_STATIC_ARRAY_LENGTH(laws); l++) {
        for (size_t t = 0; t < PETSC_STATIC_ARRAY_LENGTH(times); t++) {
          PetscReal error;

          if (l && t && (PetscInt)(l + t) % MPM_SHAPE_COUNT != shape)
            continue; /* law and integrator know nothing of one another */
          SCENE_CALL(Look(dim, MpmShapeTypes[shape], laws[l], times[t], &error));
          ck_assert_msg(error < 1e-8, "%dD %s %s%s: %g", (int)dim, MpmShapeTypes[shape], laws[l], times[t],
                        (double)error);
        }
      }
    }
  }
}
END_TEST

/* A history, F-bar, smoothed strains, damping, boundaries: no objective. */
START_TEST(none)
{
  static const char *const without[] = {
    "-mpm_material_m_type j2 -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 -mpm_material_m_yield_stress 10 ",
    "-mpm_material_m_type jaumann_elastic -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 ",
    "-mpm_material_m_type hencky -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 -mpm_stabilization_fbar true ",
    "-mpm_material_m_type hencky -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 -mpm_stabilization_smooth 0.5 ",
    "-mpm_material_m_type hencky -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 -mpm_time_integrator newmark "
    "-mpm_time_damping_mass 0.1 ",
    "-mpm_material_m_type hencky -mpm_material_m_E 1e3 -mpm_material_m_nu 0.3 -mpm_boundaries wall "
    "-mpm_boundary_wall_type plane "
    "-mpm_boundary_wall_point 3,0 -mpm_boundary_wall_normal -1,0 "};

  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(without); k++) {
    MpmModel model;

    SCENE_CALL(Create(2, "linear", without[k], "", &model));
    ck_assert_msg(!model->solver.cache.minimisation.on, "%s", without[k]);
    SCENE_CALL(SceneDestroy(&model));
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {derivative, none};

  return UnitRun(&argc, &argv, "potential", sizeof(tests) / sizeof(tests[0]), tests);
}
