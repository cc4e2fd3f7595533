/*
  The Jacobian: point by point, by colours and densely it is one matrix. Differences and the residual's Taylor expansion
  confirm it; so do actions without a matrix and PETSc's own colouring. Every scene has moved once before, so that F,
  history and domains are those of a deformed body.

  Ranks: 1 2
*/
#include "contact/contact.h"
#include "assembly/terms.h"
#include "scene.h"
#include "assembly/sparsity.h"

/* Any others will do: of steps of 0.03 to 0.05 cells and eight seeds, all 40 pairs tried have passed. */
#define SEED  0
#define CELLS 0.04 /* of the steps' random displacements */

static const char *const scene_2d =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2 -mpm_grid_cells 6,5 -mpm_body_b_region box "
  "-mpm_body_b_lower 0.5,0.4 -mpm_body_b_upper 2.5,1.6 ";
static const char *const scene_3d =
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 2,2,1.2 -mpm_grid_cells 4,4,3 -mpm_body_b_region box "
  "-mpm_body_b_lower 0.5,0.5,0.4 -mpm_body_b_upper 1.5,1.5,0.8 -mpm_body_b_points_per_cell 2,1,2 ";
/* a floor that takes part of the body with it, and a smooth side */
static const char *const held_2d =
  "-mpm_bcs floor,side -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0.4 -mpm_bc_floor_upper 3,0.4 "
  "-mpm_bc_floor_components x,y -mpm_bc_floor_value 0.01,-0.006 -mpm_bc_side_region box "
  "-mpm_bc_side_lower 0.5,0 -mpm_bc_side_upper 0.5,2 -mpm_bc_side_components x ";
static const char *const held_3d =
  "-mpm_bcs floor,side -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0,0.4 -mpm_bc_floor_upper 2,2,0.4 "
  "-mpm_bc_floor_components x,y,z -mpm_bc_floor_value 0.01,-0.006,0.004 -mpm_bc_side_region box "
  "-mpm_bc_side_lower 0.5,0,0 -mpm_bc_side_upper 0.5,2,2 -mpm_bc_side_components x ";

/* rollers at an angle: nodes with one, with two that are not at right angles, and with one and a component; and a
   motion that meets them */
static const char *const inclined_2d =
  "-mpm_bcs floor,side,edge -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0.4 -mpm_bc_floor_upper 3,0.4 "
  "-mpm_bc_floor_normal -0.3,2 -mpm_bc_floor_value 0.01 -mpm_bc_side_region box -mpm_bc_side_lower 0.5,0 "
  "-mpm_bc_side_upper 0.5,2 -mpm_bc_side_components x -mpm_bc_side_value 0.004 -mpm_bc_edge_region box "
  "-mpm_bc_edge_lower 2.5,0 -mpm_bc_edge_upper 2.5,2 -mpm_bc_edge_normal 1,0.4 "
  "-mpm_motions lift -mpm_motion_lift_body b -mpm_motion_lift_region box -mpm_motion_lift_lower 1.8,1.3 "
  "-mpm_motion_lift_upper 2.5,1.6 -mpm_motion_lift_components y -mpm_motion_lift_value 0.01 ";
static const char *const inclined_3d =
  "-mpm_bcs floor,side,edge -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0,0.4 -mpm_bc_floor_upper 2,2,0.4 "
  "-mpm_bc_floor_normal 0.3,-0.2,1 -mpm_bc_floor_value 0.01 -mpm_bc_side_region box -mpm_bc_side_lower 0.5,0,0 "
  "-mpm_bc_side_upper 0.5,2,2 -mpm_bc_side_components x -mpm_bc_edge_region box -mpm_bc_edge_lower 0,0.5,0 "
  "-mpm_bc_edge_upper 2,0.5,2 -mpm_bc_edge_normal 0.1,1,0.4 "
  "-mpm_motions lift -mpm_motion_lift_body b -mpm_motion_lift_region box -mpm_motion_lift_lower 1.2,0.5,0.4 "
  "-mpm_motion_lift_upper 1.5,1,0.8 -mpm_motion_lift_components y -mpm_motion_lift_value 0.01 ";

/* surfaces of every type that have come into the body, and that hold it; with a roller at an angle */
static const char *const touching_2d =
  "-mpm_bcs edge -mpm_bc_edge_region box -mpm_bc_edge_lower 2.5,0 -mpm_bc_edge_upper 2.5,2 -mpm_bc_edge_normal 1,0.4 "
  "-mpm_boundaries floor,disc,wedge -mpm_boundary_floor_type plane -mpm_boundary_floor_point 0.5,0.4 "
  "-mpm_boundary_floor_normal -0.02,1 -mpm_boundary_floor_motion 0.03,0.1 -mpm_boundary_floor_ramp 0:1 "
  "-mpm_boundary_floor_friction stick -mpm_boundary_floor_points_region box -mpm_boundary_floor_points_lower 0.5,0.4 "
  "-mpm_boundary_floor_points_upper 1.5,1.6 -mpm_boundary_disc_type sphere -mpm_boundary_disc_center 1.5,1 "
  "-mpm_boundary_disc_radius 1.17 -mpm_boundary_disc_side inside -mpm_boundary_disc_motion 0.2,0 "
  "-mpm_boundary_disc_growth -0.04 "
  "-mpm_boundary_wedge_type polygon -mpm_boundary_wedge_vertices 0.5,1.6,1,1.6,0.75,1.9 "
  "-mpm_boundary_wedge_contact bilateral -mpm_boundary_wedge_motion 0.02,-0.05 ";
/* with friction along them: Coulomb's, adhesion, both */
static const char *const rubbing_2d = "-mpm_boundary_disc_friction 0.3 -mpm_boundary_wedge_friction 15deg "
                                      "-mpm_boundary_wedge_adhesion 1e4 ";
static const char *const rubbing_3d = "-mpm_boundary_ball_friction 0.3 -mpm_boundary_rod_friction 15deg "
                                      "-mpm_boundary_rod_adhesion 1e4 ";
/* fixed, with stresses on all faces and a traction on one side, which follow the body */
#define LOADED_BODY \
  "-mpm_surfaces skin,top -mpm_surface_skin_body b -mpm_surface_skin_side all -mpm_surface_skin_normal -4e5 " \
  "-mpm_surface_top_body b "
static const char *const loaded_2d = LOADED_BODY "-mpm_surface_top_side +y -mpm_surface_top_traction 2e5,-6e5 ";
static const char *const loaded_3d = LOADED_BODY "-mpm_surface_top_side +z -mpm_surface_top_traction 2e5,-1e5,-6e5 ";
static const char *const touching_3d =
  "-mpm_bcs edge -mpm_bc_edge_region box -mpm_bc_edge_lower 0,0.5,0 -mpm_bc_edge_upper 2,0.5,2 "
  "-mpm_bc_edge_normal 0.1,1,0.4 -mpm_boundaries floor,ball,rod -mpm_boundary_floor_type plane "
  "-mpm_boundary_floor_point 0.5,0.5,0.4 -mpm_boundary_floor_normal -0.02,0.01,1 -mpm_boundary_floor_motion 0.03,0,0.1 "
  "-mpm_boundary_floor_ramp 0:1 -mpm_boundary_floor_friction stick -mpm_boundary_floor_points_region box "
  "-mpm_boundary_floor_points_lower 0.5,0.8,0.4 -mpm_boundary_floor_points_upper 1,1.5,0.8 "
  "-mpm_boundary_ball_type sphere -mpm_boundary_ball_center 1,1,1.8 -mpm_boundary_ball_radius 1 "
  "-mpm_boundary_ball_motion 0,0,-0.2 -mpm_boundary_ball_growth 0.04 -mpm_boundary_rod_type cylinder "
  "-mpm_boundary_rod_point 1.9,1,1 "
  "-mpm_boundary_rod_axis 0,1,0.2 -mpm_boundary_rod_radius 0.5 -mpm_boundary_rod_contact bilateral "
  "-mpm_boundary_rod_motion -0.1,0,0 -mpm_boundary_rod_growth 0.02 ";

typedef struct {
  const char *name, *parameters;
  PetscBool   plastic;
} Law;

/* Yield strains are about 1e-3, increments several per cent. */
static const Law laws[] = {
  {"linear_elastic", "", PETSC_FALSE},
  {"hencky", "", PETSC_FALSE},
  {"neo_hookean", "", PETSC_FALSE},
  {"j2", "-mpm_material_m_yield_stress 1e3 -mpm_material_m_hardening 2e4 ", PETSC_TRUE},
  {"drucker_prager", "-mpm_material_m_cohesion 1e3 -mpm_material_m_friction 30 -mpm_material_m_dilation 10 ",
   PETSC_TRUE},
  {"mohr_coulomb", "-mpm_material_m_cohesion 1e3 -mpm_material_m_friction 30 -mpm_material_m_dilation 30 ", PETSC_TRUE},
};

/* A body without conditions; fixed; fixed with F-bar; fixed along normals, with F-bar in 3D; touching boundaries; with
   loads on faces. */
enum { FREE, HELD, HELD_FBAR, INCLINED, TOUCHING, RUBBING, LOADED, VARIANTS };
static const char *const variant_names[] = {"free",     "held",    "held, F-bar", "held along normals",
                                            "touching", "rubbing", "loaded"};

/* a disc, a ball, whose facets stand on its surface: pushed and rubbed by a plane, and by a round boundary to which it
   sticks */
static const char *const round_2d =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2 -mpm_grid_cells 6,5 -mpm_body_b_region sphere -mpm_body_b_center "
  "1.5,1 -mpm_body_b_radius 0.6 -mpm_boundaries floor,side "
  "-mpm_boundary_floor_type plane -mpm_boundary_floor_point 1.5,0.4 -mpm_boundary_floor_normal -0.1,1 "
  "-mpm_boundary_floor_motion 0.05,0.2 -mpm_boundary_floor_ramp 0:1 -mpm_boundary_floor_friction 0.3 "
  "-mpm_boundary_side_type sphere -mpm_boundary_side_center 0.5,1 -mpm_boundary_side_radius 0.42 "
  "-mpm_boundary_side_motion 0.1,0.04 -mpm_boundary_side_friction stick ";
static const char *const round_3d =
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 2,2,1.2 -mpm_grid_cells 4,4,3 -mpm_body_b_region sphere "
  "-mpm_body_b_center 1,1,0.6 -mpm_body_b_radius 0.45 -mpm_boundaries floor,side "
  "-mpm_boundary_floor_type plane -mpm_boundary_floor_point 1,1,0.15 -mpm_boundary_floor_normal -0.1,0,1 "
  "-mpm_boundary_floor_motion 0.05,0,0.2 -mpm_boundary_floor_ramp 0:1 -mpm_boundary_floor_friction 0.3 "
  "-mpm_boundary_side_type sphere -mpm_boundary_side_center 0.1,1,0.6 -mpm_boundary_side_radius 0.47 "
  "-mpm_boundary_side_motion 0.1,0.04,0 -mpm_boundary_side_friction stick ";

static const char *edge    = "linear"; /* how splines end */
static const char *rounded = "";       /* a scene in place of the ones above */
static const char *means   = "true";   /* those of F-bar */

static PetscErrorCode Create(PetscInt dim, const char *shape, const Law *law, PetscInt held, MpmModel *model)
{
  const PetscBool   fbar            = (PetscBool)(held == HELD_FBAR || (held == INCLINED && dim == 3));
  const char *const conditions_2d[] = {"", held_2d, held_2d, inclined_2d, touching_2d, touching_2d, held_2d};
  const char *const conditions_3d[] = {"", held_3d, held_3d, inclined_3d, touching_3d, touching_3d, held_3d};
  char              options[4096];

  PetscFunctionBeginUser;
  /* half of the scenes have the ghost penalty, where there is one; those with normals have smoothed strains */
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "%s%s%s%s-mpm_shape %s -mpm_materials m -mpm_material_m_type %s -mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 "
    "-mpm_bodies b -mpm_body_b_material m -mpm_time_step 0.25 -pc_type jacobi -mpm_shape_edge %s%s%s%s%s",
    *rounded   ? rounded
    : dim == 2 ? scene_2d
               : scene_3d,
    dim == 2 ? conditions_2d[held] : conditions_3d[held],
    held == RUBBING  ? dim == 2 ? rubbing_2d : rubbing_3d
    : held == LOADED ? dim == 2 ? loaded_2d : loaded_3d
                     : "",
    law->parameters, shape, law->name, edge, held ? " -mpm_stabilization_ghost 0.05" : " -mpm_stabilization_ghost off",
    held == INCLINED ? " -mpm_stabilization_smooth 0.6" : "",
    fbar ? " -mpm_stabilization_fbar " : " -mpm_stabilization_fbar false", fbar ? means : ""));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The share of points whose elastic left Cauchy-Green tensor is no longer F F^T. */
static PetscErrorCode PlasticShare(MpmModel model, PetscReal *share)
{
  const PetscInt dim     = model->disc.dim;
  PetscInt       plastic = 0;
  MpmPoints      points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; points.state && p < points.count; p++) {
    const PetscReal *F = &points.F[p * dim * dim], *b = &points.state[p * model->state.particles->state_size];
    PetscReal        away = 0.;

    for (PetscInt a = 0; a < dim; a++) {
      PetscReal total = 0.;

      for (PetscInt c = 0; c < dim; c++) total += F[a * dim + c] * F[a * dim + c];
      away = PetscMax(away, PetscAbsReal(total - b[a]));
    }
    plastic += away > 1e-4;
  }
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &plastic, 1, MPIU_INT, MPI_SUM, model->comm));
  *share = (PetscReal)plastic / (PetscReal)model->state.particles->total;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Amplitude(MpmModel model, PetscReal cells, PetscReal amplitude[])
{
  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < model->disc.dim; a++) amplitude[a] = cells * model->disc.h[a];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Laws that yield, their apex and boundaries that only push have kinks, where the residual has no derivative: a
  difference across one cannot judge a Jacobian. Where strains are hardly longer than those at yield, central
  differences are not exact enough. The residual alone shows whether a place is `smooth`: along random directions v, r(x
  + eps v) - 2 r(x) + r(x - eps v) falls by 4 whenever eps is halved, from steps on that are longer than any that
  derivatives are compared with, and (r(x + eps v) - r(x - eps v))/(2 eps) hardly changes.
*/
#define SMOOTH_DIRECTIONS 3
#define SMOOTH_ORDER      0.02 /* how far from 2 */
#define SMOOTH_CHANGE     5e-6 /* of the derivative, from one step to the next */

static PetscErrorCode IsSmoothAlong(MpmModel model, Vec x, Vec v, PetscBool *smooth)
{
  Vec       r[3], at, slope;
  PetscReal last = 0., norm, change, size;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(x, &at));
  PetscCall(VecDuplicate(x, &slope));
  for (PetscInt k = 0; k < 3; k++) PetscCall(VecDuplicate(x, &r[k]));
  PetscCall(SNESComputeFunction(model->solver.snes, x, r[0]));
  for (int k = SCENE_TAYLOR_LONGEST; k <= SCENE_TAYLOR_SHORTEST && *smooth; k++) {
    const PetscReal eps = 1. / (PetscReal)(1 << k);

    for (PetscInt side = 1; side <= 2; side++) {
      PetscCall(VecWAXPY(at, side == 1 ? eps : -eps, v, x));
      PetscCall(SNESComputeFunction(model->solver.snes, at, r[side]));
    }
    PetscCall(VecWAXPY(at, -1., r[2], r[1]));
    PetscCall(VecScale(at, 0.5 / eps));
    PetscCall(VecAXPBYPCZ(r[1], 1., -2., 1., r[2], r[0]));
    PetscCall(VecNorm(r[1], NORM_2, &norm));
    if (last > 0.) {
      PetscCall(VecAXPY(slope, -1., at));
      PetscCall(VecNorm(slope, NORM_2, &change));
      PetscCall(VecNorm(at, NORM_2, &size));
      *smooth = (PetscBool)(PetscAbsReal(PetscLog2Real(last / norm) - 2.) <= SMOOTH_ORDER);
      if (k == SCENE_TAYLOR_LONGEST + 1 && change > SMOOTH_CHANGE * size) *smooth = PETSC_FALSE;
    }
    PetscCall(VecCopy(at, slope));
    last = norm;
  }
  PetscCall(VecDestroy(&at));
  PetscCall(VecDestroy(&slope));
  for (PetscInt k = 0; k < 3; k++) PetscCall(VecDestroy(&r[k]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The first of the places that random numbers give, from `seed` on, that is smooth; and the direction v from there. */
static PetscErrorCode FindSmooth(MpmModel model, PetscInt seed, Vec x, Vec v)
{
  const PetscInt tries = 50;
  PetscReal      amplitude[MPM_MAX_DIM];
  PetscBool      smooth = PETSC_FALSE;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < tries && !smooth; k++) {
    const PetscInt first = seed + k * (SMOOTH_DIRECTIONS + 1);

    PetscCall(Amplitude(model, CELLS, amplitude));
    PetscCall(SceneFill(model, first, amplitude, PETSC_FALSE, x));
    PetscCall(Amplitude(model, 0.02, amplitude));
    smooth = PETSC_TRUE;
    for (PetscInt d = SMOOTH_DIRECTIONS; d > 0 && smooth; d--) {
      PetscCall(SceneFill(model, first + d, amplitude, PETSC_TRUE, v));
      if (!(model->scene.materials->at[0].info.traits & MPM_LAW_SMALL_STRAIN))
        PetscCall(IsSmoothAlong(model, x, v, &smooth));
    }
  }
  ck_assert_msg(smooth, "no place without a kink in %d tries", (int)tries);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Random steps are committed, one for laws that do not yield, others until half of the points have; then the Jacobians
  of another step are compared. `domain` > 0: half-length of all domains between, in cells.
*/
static PetscErrorCode Look(MpmModel model, const Law *law, PetscReal domain, PetscReal *plastic, SceneVerdict *verdict)
{
  PetscReal amplitude[MPM_MAX_DIM];
  Vec       v;

  PetscFunctionBeginUser;
  *plastic = 0.;
  for (PetscInt k = 0; k < 5 && (k == 0 || (law->plastic && *plastic < 0.5)); k++) {
    PetscCall(SceneBegin(model, 0.25));
    PetscCall(Amplitude(model, CELLS, amplitude));
    PetscCall(SceneFill(model, 1 + 1000 * SEED + 500 * k, amplitude, PETSC_FALSE, model->solver.x));
    PetscCall(SceneCommit(model, model->solver.x));
    PetscCall(PlasticShare(model, plastic));
  }
  if (domain > 0.) {
    MpmPoints points;

    PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
    for (PetscInt k = 0; k < points.count * model->disc.dim; k++)
      points.domain.half_length[k] = domain * model->disc.h[k % model->disc.dim];
    PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  }
  PetscCall(SceneBegin(model, 0.25));
  PetscCall(VecDuplicate(model->solver.x, &v));
  PetscCall(FindSmooth(model, 2 + 1000 * SEED, model->solver.x, v));
  PetscCall(SceneCompare(model, model->solver.x, v, verdict));
  PetscCall(VecDestroy(&v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Check(MpmModel model, const Law *law, PetscInt held, PetscReal plastic, const SceneVerdict *verdict)
{
  const unsigned traits = model->scene.materials->at[0].info.traits;
  char           name[200];

  snprintf(name, sizeof(name), "%dD %s %s %s", (int)model->disc.dim, MpmShapeTypes[model->scene.shape.type], law->name,
           variant_names[held]);
  ck_assert_msg(verdict->norm > 0., "%s: the Jacobian is empty", name);
  ck_assert_msg(verdict->coloring <= 1e-14, "%s: local and coloured Jacobian differ by %g", name,
                (double)verdict->coloring);
  ck_assert_msg(verdict->dense <= 1e-14, "%s: local and dense Jacobian differ by %g", name, (double)verdict->dense);
  ck_assert_msg(verdict->fd <= 1e-7, "%s: local and finite-difference Jacobian differ by %g", name,
                (double)verdict->fd);
  /* the point-by-point Jacobian leaves out the columns of constrained unknowns */
  ck_assert_msg(held || UNIT_SANITIZED || (verdict->petsc > 0. && verdict->petsc <= 1e-4),
                "%s: local Jacobian and PETSc's colouring and differences differ by %g", name, (double)verdict->petsc);
  for (int k = 0; k < 2; k++) {
    ck_assert_msg(verdict->action[k] <= 1e-13, "%s: local Jacobian and action %s tangents differ by %g", name,
                  k ? "without" : "with", (double)verdict->action[k]);
  }
  ck_assert_msg(verdict->diagonal <= 1e-13, "%s: diagonals differ by %g", name, (double)verdict->diagonal);
  /* blocks of a yielding law may be singular */
  ck_assert_msg(law->plastic || verdict->blocks <= 1e-8, "%s: inverted diagonal blocks are wrong by %g", name,
                (double)verdict->blocks);
  if (traits & MPM_LAW_SYMMETRIC && held < RUBBING)
    ck_assert_msg(verdict->asymmetry <= 1e-13, "%s: unsymmetric by %g", name, (double)verdict->asymmetry);
  if (traits & MPM_LAW_SMALL_STRAIN)
    ck_assert_msg(verdict->remainder <= 1e-10, "%s: not linear, by %g", name, (double)verdict->remainder);
  else ck_assert_msg(verdict->slope >= 1.95, "%s: the Taylor remainder has order %g", name, (double)verdict->slope);
  if (law->plastic) ck_assert_msg(plastic >= 0.5, "%s: only %g of the points have yielded", name, (double)plastic);
}

/* All boundaries have pushed in the step that was committed. */
static void CheckTouch(MpmModel model)
{
  for (PetscInt b = 0; b < model->scene.boundaries->count; b++) {
    SCENE_CALL(MpmTermsCommit(model->disc.terms, model->disc.sum, model->disc.nodal.u, model->state.particles));
    ck_assert_msg(model->disc.context.contacts->depth[b] > 0.01 * model->disc.h[0], "boundary %s has a depth of %g",
                  model->scene.boundaries->names[b], (double)model->disc.context.contacts->depth[b]);
  }
}

static void CheckAll(PetscInt dim)
{
  for (PetscInt shape = 0; shape < MPM_SHAPE_COUNT; shape++) {
    for (size_t l = 0; l < PETSC_STATIC_ARRAY_LENGTH(laws); l++) {
      for (PetscInt held = 0; held < VARIANTS; held++) {
        MpmModel     model;
        SceneVerdict verdict;
        PetscReal    plastic;

        /* other laws would tell nothing new of conditions; and surfaces that are round, or only push, are not linear */
        if (held >= INCLINED && l != 2 && l != 4) continue;
        /* any two of shape, law and variant meet; under the sanitizers shape and variant, with one law */
        if (UNIT_SANITIZED && held < INCLINED && (shape + (PetscInt)l + held) % 6) continue;
        if (UnitFew() && (held < INCLINED ? (shape + (PetscInt)l + held) % 3 : (shape + (PetscInt)l / 2 + held) % 2))
          continue;
        SCENE_CALL(Create(dim, MpmShapeTypes[shape], &laws[l], held, &model));
        SCENE_CALL(Look(model, &laws[l], 0., &plastic, &verdict));
        ck_assert_int_eq(model->disc.constraints->any || !held || held >= TOUCHING,
                         1); /* its one edge may be on one rank */
        ck_assert_int_eq(model->disc.constraints->frame_of != NULL, held >= INCLINED && held != LOADED);
        if (held == TOUCHING || held == RUBBING) CheckTouch(model);
        ck_assert_int_eq((int)model->disc.layout->means, held == HELD_FBAR || (held == INCLINED && dim == 3));
        Check(model, &laws[l], held, plastic, &verdict);
        SCENE_CALL(SceneDestroy(&model));
      }
    }
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

/* Edges of the grid, and the walls that the conditions make, at which splines keep all their polynomials. */
START_TEST(open_edges)
{
  static const PetscInt variants[] = {FREE, HELD_FBAR};

  edge = "open";
  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (PetscInt shape = MPM_SHAPE_BSPLINE2; shape < MPM_SHAPE_COUNT; shape++) {
      for (PetscInt v = 0; v < 2; v++) {
        const Law   *law = &laws[v ? 3 : 1];
        MpmModel     model;
        SceneVerdict verdict;
        PetscReal    plastic;

        SCENE_CALL(Create(dim, MpmShapeTypes[shape], law, variants[v], &model));
        ck_assert_int_eq(model->scene.shape.edge, MPM_EDGE_OPEN);
        SCENE_CALL(Look(model, law, 0., &plastic, &verdict));
        Check(model, law, variants[v], plastic, &verdict);
        SCENE_CALL(SceneDestroy(&model));
      }
    }
  }
  edge = "linear";
}
END_TEST

/* Domains of more than two cells: points touch more nodes, and the colours' block grows with them. */
START_TEST(long_domains)
{
  static const char *const shapes[] = {"gimp", "gimp_bspline2"};
  const PetscReal          half     = 1.3;

  for (PetscInt dim = 2; dim <= 3; dim++) {
    for (PetscInt s = 0; s < 2; s++) {
      MpmModel     model;
      SceneVerdict verdict;
      PetscReal    plastic;

      SCENE_CALL(Create(dim, shapes[s], &laws[2], s == 0 ? HELD : FREE, &model));
      SCENE_CALL(Look(model, &laws[2], dim == 2 ? half : 0.7, &plastic, &verdict));
      ck_assert_int_ge((int)model->disc.space->width, dim == 2 ? 5 : 4);
      ck_assert_int_eq((int)model->disc.matrix.pattern->reach, (int)model->disc.space->width - 1);
      Check(model, &laws[2], s == 0 ? HELD : FREE, plastic, &verdict);
      SCENE_CALL(SceneDestroy(&model));
    }
  }
}
END_TEST

/* F-bar by shares of domains: of half a cell, and so long that points of three or four cells have a mean. */
START_TEST(spread_means)
{
  static const char *const shapes[]   = {"gimp", "gimp_bspline2"};
  static const PetscInt    variants[] = {HELD_FBAR, INCLINED};

  means = "spread";
  for (PetscInt k = 0; k < 16; k++) {
    const PetscInt  dim = 2 + k % 2, held = variants[k / 8];
    const Law      *law  = &laws[k / 8 ? 2 : 2 * (k / 4 % 2) + (k / 2 % 2) + 1];
    const PetscReal half = k / 4 % 2 ? dim == 2 ? 1.2 : 0.6 : 0.;
    MpmModel        model;
    SceneVerdict    verdict;
    PetscReal       plastic;

    if ((k / 8 && dim == 2) || (UnitFew() && k % 3)) continue;
    SCENE_CALL(Create(dim, shapes[k / 2 % 2], law, held, &model));
    SCENE_CALL(Look(model, law, half, &plastic, &verdict));
    ck_assert_int_eq((int)model->disc.layout->means, 1);
    ck_assert(model->disc.space->cells.spread != NULL);
    Check(model, law, held, plastic, &verdict);
    SCENE_CALL(SceneDestroy(&model));
  }
  means = "true";
}
END_TEST

START_TEST(round_bodies)
{
  static const char *const shapes[] = {"gimp", "bspline2"};

  for (PetscInt dim = 2; dim <= 3; dim++) {
    rounded = dim == 2 ? round_2d : round_3d;
    for (PetscInt s = 0; s < 2; s++) {
      MpmModel     model;
      SceneVerdict verdict;
      PetscReal    plastic;

      SCENE_CALL(Create(dim, shapes[s], &laws[2], FREE, &model));
      SCENE_CALL(Look(model, &laws[2], 0., &plastic, &verdict));
      CheckTouch(model);
      Check(model, &laws[2], RUBBING, plastic, &verdict);
      SCENE_CALL(SceneDestroy(&model));
    }
  }
  rounded = "";
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {plane, space, open_edges, long_domains, spread_means, round_bodies};

  return UnitRun(&argc, &argv, "jacobian", sizeof(tests) / sizeof(tests[0]), tests);
}
