/*
  The Jacobian of saturated ground: point by point, by colours and densely it is one matrix; actions, differences and
  the residual's Taylor expansion confirm it. With and without F-bar, at small and large strain, under gravity, free and
  fixed, with variable permeability; fixed ground with water that passes its faces. All numbers are of size one, so that
  no block hides behind another; every scene has moved once.

  Ranks: 1 2
*/
#include "scene.h"

static const char *const scene_2d =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2 -mpm_grid_cells 6,5 -mpm_body_b_region box "
  "-mpm_body_b_lower 0.5,0.4 -mpm_body_b_upper 2.5,1.6 -mpm_material_m_permeability 0.3,0.5 ";
static const char *const scene_3d =
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 2,2,1.2 -mpm_grid_cells 4,4,3 -mpm_body_b_region box "
  "-mpm_body_b_lower 0.5,0.5,0.4 -mpm_body_b_upper 1.5,1.5,0.8 -mpm_body_b_points_per_cell 2,1,2 "
  "-mpm_material_m_permeability 0.3,0.5,0.2 ";
/* a floor that takes part of the body with it, a smooth side, and a surface where the pressure is prescribed */
static const char *const held_2d =
  "-mpm_bcs floor,side,top -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0.4 -mpm_bc_floor_upper 3,0.4 "
  "-mpm_bc_floor_components x,y -mpm_bc_floor_value 0.01,-0.006 -mpm_bc_side_region box "
  "-mpm_bc_side_lower 0.5,0 -mpm_bc_side_upper 0.5,2 -mpm_bc_side_components x -mpm_bc_top_region box "
  "-mpm_bc_top_lower 0,1.6 -mpm_bc_top_upper 3,1.6 -mpm_bc_top_components p -mpm_bc_top_value 0.3 ";
static const char *const held_3d =
  "-mpm_bcs floor,side,top -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0,0.4 -mpm_bc_floor_upper 2,2,0.4 "
  "-mpm_bc_floor_components x,y,z -mpm_bc_floor_value 0.01,-0.006,0.004 -mpm_bc_side_region box "
  "-mpm_bc_side_lower 0.5,0,0 -mpm_bc_side_upper 0.5,2,2 -mpm_bc_side_components x -mpm_bc_top_region box "
  "-mpm_bc_top_lower 0,0,0.8 -mpm_bc_top_upper 2,2,0.8 -mpm_bc_top_components p -mpm_bc_top_value 0.3 ";

static const char *const weight_2d = "-mpm_loads g -mpm_load_g_type gravity -mpm_load_g_value 0.1,-0.5 ";
static const char *const weight_3d = "-mpm_loads g -mpm_load_g_type gravity -mpm_load_g_value 0.1,0.2,-0.5 ";

/* water that passes all faces, and a stress on them */
static const char *const surface =
  "-mpm_surfaces rim -mpm_surface_rim_body b -mpm_surface_rim_side all -mpm_surface_rim_pressure 0.2 ";
static const char *const pressed = "-mpm_surface_rim_normal -3 ";

/* Material of the ground; at small strain all is linear. */
typedef struct {
  const char *name, *options;
  PetscBool   small;
} Ground;
static const Ground grounds[] = {
  {"linear", "-mpm_material_m_type linear_elastic ", PETSC_TRUE},
  {"hencky", "-mpm_material_m_type hencky -mpm_material_m_permeability_law kozeny_carman -mpm_water_modulus 7 ",
   PETSC_FALSE},
  {"neo-Hookean", "-mpm_material_m_type neo_hookean -mpm_material_m_permeability_law uzuoka_borja ", PETSC_FALSE}};

typedef struct {
  PetscInt      dim, shape;
  const Ground *ground;
  PetscBool     held, fbar, weight;
} Case;

static PetscErrorCode Create(const Case *c, MpmModel *model)
{
  const PetscBool presses = (PetscBool)(c->held && c->weight && !c->ground->small); /* which is not linear */
  char            options[4096];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "%s%s%s%s%s%s-mpm_physics poro -mpm_shape %s -mpm_materials m -mpm_material_m_E 10 -mpm_material_m_nu 0.3 "
    "-mpm_material_m_density 2 -mpm_material_m_porosity 0.45 -mpm_water_density 0.8 -mpm_water_viscosity 0.7 "
    "-mpm_bodies b -mpm_body_b_material m -mpm_time_step 0.25 -mpm_stabilization_ghost %s -mpm_stabilization_fbar %s",
    c->dim == 2 ? scene_2d : scene_3d,
    !c->held      ? ""
    : c->dim == 2 ? held_2d
                  : held_3d,
    !c->weight    ? ""
    : c->dim == 2 ? weight_2d
                  : weight_3d,
    c->held ? surface : "", presses ? pressed : "", c->ground->options, MpmShapeTypes[c->shape],
    c->held ? "0.05" : "off", c->fbar ? "true" : "false"));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Look(MpmModel model, SceneVerdict *verdict)
{
  const PetscInt dim = model->disc.dim;
  PetscReal      amplitude[MPM_MAX_BLOCK];
  Vec            v;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < dim; a++) amplitude[a] = 0.04 * model->disc.h[a];
  amplitude[dim] = 0.5;
  PetscCall(SceneBegin(model, 0.25));
  PetscCall(SceneFill(model, 1, amplitude, PETSC_FALSE, model->solver.x));
  PetscCall(SceneCommit(model, model->solver.x));
  PetscCall(SceneBegin(model, 0.25));
  PetscCall(VecDuplicate(model->solver.x, &v));
  PetscCall(SceneFill(model, 2, amplitude, PETSC_FALSE, model->solver.x));
  PetscCall(SceneFill(model, 3, amplitude, PETSC_TRUE, v));
  PetscCall(SceneCompare(model, model->solver.x, v, verdict));
  PetscCall(VecDestroy(&v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Check(const Case *c, const SceneVerdict *verdict)
{
  char name[200];

  snprintf(name, sizeof(name), "%dD %s, %s, %s%s%s", (int)c->dim, MpmShapeTypes[c->shape], c->ground->name,
           c->held ? "held" : "free", c->fbar ? ", F-bar" : "", c->weight ? ", gravity" : "");
  ck_assert_msg(verdict->norm > 0., "%s: the Jacobian is empty", name);
  ck_assert_msg(verdict->coloring <= 1e-14, "%s: local and coloured differ by %g", name, (double)verdict->coloring);
  ck_assert_msg(verdict->dense <= 1e-14, "%s: local and dense differ by %g", name, (double)verdict->dense);
  ck_assert_msg(verdict->fd <= 1e-7, "%s: local and differences differ by %g", name, (double)verdict->fd);
  ck_assert_msg(c->held || UNIT_SANITIZED || (verdict->petsc > 0. && verdict->petsc <= 1e-4),
                "%s: PETSc's colouring and differences differ by %g", name, (double)verdict->petsc);
  for (int k = 0; k < 2; k++)
    ck_assert_msg(verdict->action[k] <= 1e-13, "%s: action %d differs by %g", name, k, (double)verdict->action[k]);
  /* a weak node's is lifted by 1e-11 in the matrix */
  ck_assert_msg(verdict->diagonal <= 2e-12, "%s: diagonals differ by %g", name, (double)verdict->diagonal);
  ck_assert_msg(verdict->blocks <= 1e-8, "%s: inverted diagonal blocks are wrong by %g", name, (double)verdict->blocks);
  if (!c->ground->small) {
    ck_assert_msg(verdict->slope >= 1.95, "%s: the Taylor remainder has order %g", name, (double)verdict->slope);
    return;
  }
  ck_assert_msg(verdict->remainder <= 1e-10, "%s: not linear, by %g", name, (double)verdict->remainder);
  /* the weight of water goes with the volume, and no force with it */
  ck_assert_msg((verdict->asymmetry <= 1e-13) == !c->weight, "%s: unsymmetric by %g", name, (double)verdict->asymmetry);
}

static void CheckAll(PetscInt dim)
{
  for (PetscInt k = 0; k < MPM_SHAPE_COUNT * 3 * 8; k++) {
    const Case c = {
      dim, k / 24, &grounds[k / 8 % 3], (PetscBool)(k & 1), (PetscBool)(k / 2 & 1), (PetscBool)(k / 4 & 1)};
    MpmModel     model;
    SceneVerdict verdict;

    if (dim == 3 && k % 8 != 7 && k % 8 != (k / 8 % 3 ? 5 : 3)) continue; /* in space two of the eight */
    /* two of eight, opposite ones, and one of two */
    if (UnitFew() && dim == 2 && k % 8 != (k / 8) % 4 && k % 8 != 7 - (k / 8) % 4) continue;
    if (UnitFew() && dim == 3 && (k % 8 == 7) != (k / 8 % 2)) continue;
    SCENE_CALL(Create(&c, &model));
    ck_assert_int_eq((int)model->disc.layout->means, c.fbar);
    SCENE_CALL(Look(model, &verdict));
    Check(&c, &verdict);
    SCENE_CALL(SceneDestroy(&model));
  }
}

START_TEST(plane)
{
  CheckAll(2);
}
END_TEST

START_TEST(space)
{
  CheckAll(3);
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {plane, space};

  return UnitRun(&argc, &argv, "jacobian of saturated ground", sizeof(tests) / sizeof(tests[0]), tests);
}
