/*
  Boundaries whose place is solved for: the forms of the Jacobian agree with each other and with the residual's Taylor
  expansion, bodies included, and with several ranks; rotations compose exactly; and the matrix has their equations.

  Ranks: 1 2 3
*/
#include "contact/rigid_body.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "scene.h"

static const char *const scene_2d =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2 -mpm_grid_cells 6,5 -mpm_body_b_region box "
  "-mpm_body_b_lower 0.5,0.4 -mpm_body_b_upper 2.5,1.6 -mpm_bcs edge -mpm_bc_edge_region box -mpm_bc_edge_lower 2.5,0 "
  "-mpm_bc_edge_upper 2.5,2 -mpm_bc_edge_normal 1,0.4 -mpm_boundaries lid,disc,wedge,floor "
  "-mpm_boundary_lid_type polygon -mpm_boundary_lid_vertices 0.3,1.6,2.7,1.6,2.7,1.8,0.3,1.8 "
  "-mpm_boundary_lid_friction "
  "stick -mpm_boundary_lid_free x,y,rz -mpm_boundary_lid_load 100,-2000 -mpm_boundary_lid_moment 300 "
  "-mpm_boundary_disc_type sphere -mpm_boundary_disc_center 0.2,1 -mpm_boundary_disc_radius 0.3 "
  "-mpm_boundary_disc_free "
  "x,rz -mpm_boundary_disc_load 500,0 -mpm_boundary_disc_motion 0,0.03 "
  "-mpm_boundary_wedge_type polygon -mpm_boundary_wedge_vertices 1.2,0.2,1.8,0.2,1.8,0.4,1.2,0.4 "
  "-mpm_boundary_wedge_free "
  "y -mpm_boundary_wedge_load 0,300 -mpm_boundary_wedge_rotation 5 -mpm_boundary_wedge_motion 0.02,0 "
  "-mpm_boundary_floor_type plane -mpm_boundary_floor_point 0.5,0.4 -mpm_boundary_floor_normal 0,1 "
  "-mpm_boundary_floor_motion 0.03,0.02 -mpm_boundary_floor_ramp 0:1 ";
static const char *const scene_3d =
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 2,2,1.2 -mpm_grid_cells 4,4,3 -mpm_body_b_region box "
  "-mpm_body_b_lower 0.5,0.5,0.4 -mpm_body_b_upper 1.5,1.5,0.8 -mpm_body_b_points_per_cell 2,1,2 -mpm_bcs edge "
  "-mpm_bc_edge_region box -mpm_bc_edge_lower 0,0.5,0 -mpm_bc_edge_upper 2,0.5,2 -mpm_bc_edge_normal 0.1,1,0.4 "
  "-mpm_boundaries ball,lid -mpm_boundary_ball_type sphere -mpm_boundary_ball_center 1,1.1,-0.6 "
  "-mpm_boundary_ball_radius 1 "
  "-mpm_boundary_ball_free x,y,z,rx,ry,rz -mpm_boundary_ball_friction stick -mpm_boundary_ball_load 50,20,900 "
  "-mpm_boundary_lid_type plane -mpm_boundary_lid_point 1,1,0.8 -mpm_boundary_lid_normal 0,0,-1 -mpm_boundary_lid_free "
  "z,rx,ry -mpm_boundary_lid_load 0,0,-900 -mpm_boundary_lid_motion 0.03,0,0 -mpm_boundary_lid_pivot 1.1,0.9,0.8 ";
static const char *const moments = "-mpm_boundary_lid_moment 40,-70,0 -mpm_boundary_ball_moment 10,20,30 ";
/* About two of three axes the moment that holds the third keeps out of the rows, but not out of the columns. */
static const char *const one_axis = "-mpm_boundary_lid_free z,rx ";

static PetscErrorCode Create(PetscInt dim, const char *shape, PetscBool fbar, const char *more, MpmModel *model)
{
  char options[4096];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(options, sizeof(options),
                          "%s%s-mpm_shape %s -mpm_materials m -mpm_material_m_type neo_hookean -mpm_material_m_E 1e6 "
                          "-mpm_material_m_nu 0.3 -mpm_bodies b -mpm_body_b_material m -mpm_time_step 0.25 -pc_type "
                          "jacobi -mpm_stabilization_ghost 0.05 -mpm_stabilization_fbar %s",
                          dim == 2 ? scene_2d : scene_3d, more, shape, fbar ? "true" : "false"));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Puts the free bodies into the material, turned. */
static void Press(MpmModel model)
{
  static const PetscReal into_2d[][3] = {{0.01, -0.05}, {0.06, 0.}, {0., 0.05}, {0.}};
  static const PetscReal into_3d[][3] = {{0.01, 0.02, 0.06}, {0., 0., -0.05}};
  const PetscReal        turn[3]      = {0.01, -0.014, 0.008};

  for (PetscInt b = 0; b < model->scene.boundaries->count; b++) {
    MpmPlacement     *placement = &model->state.placements[b];
    MpmRigidIncrement q         = {.scale = 2.};

    for (PetscInt a = 0; a < 3; a++) q.shift[a] = model->disc.dim == 2 ? into_2d[b][a] : into_3d[b][a];
    for (PetscInt a = model->disc.dim == 2 ? 2 : 0; a < 3; a++) q.r[a] = turn[a];
    if (model->scene.boundaries->at[b].freedom) MpmRigidMove(&q, placement);
  }
}

/* A place of the nodes by chance, and near it one of the bodies. */
static PetscErrorCode Fill(MpmModel model, PetscInt seed, PetscReal cells, PetscBool direction, Vec x)
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  bs    = model->disc.block;
  PetscReal       amplitude[MPM_MAX_DIM];
  PetscScalar    *values;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < model->disc.dim; a++) amplitude[a] = cells * model->disc.h[a];
  PetscCall(SceneFill(model, seed, amplitude, direction, x));
  PetscCall(VecGetArray(x, &values));
  for (PetscInt i = space->extra.begin; i < PetscMin(space->owned, space->extra.begin + space->extra.count); i++)
    for (PetscInt c = 0; c < bs; c++)
      if (MpmConstraintsFree(model->disc.constraints, i * bs + c))
        values[i * bs + c] = 0.3 * amplitude[c] * SceneRandom(seed + 7, i - space->extra.begin, c);
  PetscCall(VecRestoreArray(x, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Check(const char *name, const SceneVerdict *verdict, PetscBool symmetric)
{
  ck_assert_msg(verdict->coloring <= 1e-14, "%s: local and coloured Jacobian differ by %g", name,
                (double)verdict->coloring);
  ck_assert_msg(verdict->dense <= 1e-14, "%s: local and dense Jacobian differ by %g", name, (double)verdict->dense);
  ck_assert_msg(verdict->fd <= 1e-7, "%s: local and finite-difference Jacobian differ by %g", name,
                (double)verdict->fd);
  for (int k = 0; k < 2; k++)
    ck_assert_msg(verdict->action[k] <= 1e-13, "%s: local Jacobian and action %s tangents differ by %g", name,
                  k ? "without" : "with", (double)verdict->action[k]);
  ck_assert_msg(verdict->diagonal <= 1e-13, "%s: diagonals differ by %g", name, (double)verdict->diagonal);
  ck_assert_msg(verdict->blocks <= 1e-8, "%s: inverted diagonal blocks are wrong by %g", name, (double)verdict->blocks);
  ck_assert_msg(verdict->slope >= 1.95, "%s: the Taylor remainder has order %g", name, (double)verdict->slope);
  if (symmetric) ck_assert_msg(verdict->asymmetry <= 1e-13, "%s: unsymmetric by %g", name, (double)verdict->asymmetry);
  else ck_assert_msg(verdict->asymmetry > 1e-12, "%s: symmetric", name);
}

/* Every body touches, and its equations are in the matrix. */
static void CheckTouch(MpmModel model)
{
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++) {
    SCENE_CALL(MpmTermsCommit(model->disc.terms, model->disc.sum, model->disc.nodal.u, model->state.particles));
    ck_assert_msg(model->disc.context.contacts->depth[b] > 0.01 * model->disc.h[0], "boundary %s has a depth of %g",
                  model->scene.boundaries->names[b], (double)model->disc.context.contacts->depth[b]);
  }
}

static void Compare(PetscInt dim, PetscInt shape, PetscBool fbar, const char *more)
{
  MpmModel     model;
  SceneVerdict verdict;
  Vec          v;
  char         name[200];

  snprintf(name, sizeof(name), "%dD %s%s %s", (int)dim, MpmShapeTypes[shape], fbar ? " F-bar" : "",
           more[0] ? more : "");
  SCENE_CALL(Create(dim, MpmShapeTypes[shape], fbar, more, &model));
  Press(model);
  SCENE_CALL(SceneBegin(model, 0.25));
  ck_assert_int_eq(model->disc.space->extra.count, dim == 2 ? 6 : 4);
  SCENE_CALL(VecDuplicate(model->solver.x, &v));
  SCENE_CALL(Fill(model, 3, 0.01, PETSC_FALSE, model->solver.x));
  SCENE_CALL(Fill(model, 4, 0.01, PETSC_TRUE, v));
  SCENE_CALL(SceneCompare(model, model->solver.x, v, &verdict));
  Check(name, &verdict, (PetscBool)(dim == 2 ? !more[0] : more == one_axis));
  ck_assert_int_eq(model->solver.definite.symmetric,
                   0); /* sticking contact may open, and its traction vanishes with its pressure */
  SCENE_CALL(MpmGatherSolution(&model->solver, model->solver.x));
  CheckTouch(model);
  SCENE_CALL(VecDestroy(&v));
  SCENE_CALL(SceneDestroy(&model));
}

START_TEST(plane)
{
  for (PetscInt shape = 0; shape < MPM_SHAPE_COUNT; shape++) Compare(2, shape, (PetscBool)(shape % 2), "");
}
END_TEST

START_TEST(space)
{
  for (PetscInt shape = 0; shape < MPM_SHAPE_COUNT; shape++)
    Compare(3, shape, (PetscBool)(shape % 2), shape % 2 ? "" : one_axis);
  Compare(3, MPM_SHAPE_GIMP, PETSC_FALSE, moments);
}
END_TEST

/* Quarter turns about the axes, in parts: their order counts, and nothing is lost. */
START_TEST(turns)
{
  const MpmFreedom   freedom   = {.size = 1.};
  const MpmRigidBody body      = {.freedom = &freedom, .dim = 3};
  MpmPlacement       placement = {.turn = {1., 0., 0., 0.}};
  PetscReal          Q[3][3];

  for (PetscInt axis = 0; axis < 2; axis++) {
    for (PetscInt part = 0; part < 9; part++) { /* 10 degrees each */
      PetscReal         values[6] = {0.};
      MpmRigidIncrement q;

      values[3 + axis] = 2. * PetscTanReal(PETSC_PI / 36.);
      MpmRigidIncrementMake(&body, values, &q);
      MpmRigidMove(&q, &placement);
    }
  }
  /* about x: y to z; then about y: z to x */
  MpmRigidRotation(placement.turn, Q);
  for (PetscInt a = 0; a < 3; a++) {
    const PetscReal y[3] = {1., 0., 0.}, z[3] = {0., -1., 0.};

    ck_assert_double_eq_tol((double)Q[a][1], (double)y[a], 1e-15);
    ck_assert_double_eq_tol((double)Q[a][2], (double)z[a], 1e-15);
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {plane, space, turns};

  return UnitRun(&argc, &argv, "rigid_body", sizeof(tests) / sizeof(tests[0]), tests);
}
