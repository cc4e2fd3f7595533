/*
  A physics of two fields through the interface of the solid's: layout, Jacobians, and a run. toy_kernel.c is its
  kernel.

  Ranks: 1 2
*/
#include "scene.h"

void MpmKernelCreate_toy_2d_0(MpmKernelSet *set);
void MpmKernelCreate_toy_2d_1(MpmKernelSet *set);
void MpmKernelCreate_toy_2d_7(MpmKernelSet *set);
void MpmKernelCreate_toy_3d_0(MpmKernelSet *set);
void MpmKernelCreate_toy_3d_1(MpmKernelSet *set);
void MpmKernelCreate_toy_3d_13(MpmKernelSet *set);

static MpmField fields[] = {
  {.name = "displacement", .gradient = 1, .increment = 1, .near_null = MPM_NEAR_NULL_RIGID},
  {.name = "concentration", .components = 1, .value = 1, .gradient = 1, .rate = 1, .symbol = "c"},
};

/* Shapes of the scalar's own: the degree (0: the scene's) and how far its nodes stand apart. */
static const struct {
  int degree, spacing;
} own[] = {{0, 0}, {1, 1}, {2, 1}, {3, 1}, {1, 2}, {2, 2}};
#define OWN_COUNT ((PetscInt)(sizeof(own) / sizeof(own[0])))

static void SetOwn(PetscInt k)
{
  fields[1].degree  = own[k].degree;
  fields[1].spacing = own[k].spacing;
}

#define DIFFUSIVITY 0.5
#define COUPLING    3.
static const MpmParameter parameters[] = {
  {MPM_NUMBER, "diffusivity", "m2/s", DIFFUSIVITY, 0, 0., HUGE_VAL, 0, "how fast the scalar spreads", NULL, 0., NULL},
  {MPM_NUMBER, "coupling", "-", COUPLING, 0, -HUGE_VAL, HUGE_VAL, 0, "what the scalar does to the solid", NULL, 0.,
   NULL},
};

static MpmPhysics Toy(void)
{
  MpmPhysics toy = {.name            = "toy",
                    .summary         = "a solid through which a scalar diffuses",
                    .field_count     = 2,
                    .fields          = fields,
                    .parameter_count = 2,
                    .parameters      = parameters};

  MpmKernelCreate_toy_2d_0(&toy.kernels[2]);
  MpmKernelCreate_toy_2d_1(&toy.kernels[2]);
  MpmKernelCreate_toy_2d_7(&toy.kernels[2]);
  MpmKernelCreate_toy_3d_0(&toy.kernels[3]);
  MpmKernelCreate_toy_3d_1(&toy.kernels[3]);
  MpmKernelCreate_toy_3d_13(&toy.kernels[3]);
  return toy;
}

START_TEST(layout)
{
  MpmPhysics toy = Toy();

  for (PetscInt dim = 2; dim <= 3; dim++) {
    MpmLayout plan;

    UNIT_CALL(MpmLayoutCreate(&toy, dim, &plan));
    ck_assert_int_eq((int)plan.block, dim == 2 ? 3 : 4);
    ck_assert_int_eq((int)plan.input.count, dim == 2 ? 7 : 13);
    ck_assert_int_eq((int)plan.rate.count, 1);
    ck_assert_int_eq((int)plan.rate.component[0], (int)dim);
    ck_assert(!plan.traits.solid);
    for (PetscInt c = 0; c < dim; c++) {
      ck_assert(plan.component[c].increment);
      ck_assert_str_eq(plan.component[c].name, ((const char *const[]){"x", "y", "z"})[c]);
    }
    ck_assert(!plan.component[dim].increment);
    ck_assert_str_eq(plan.component[dim].name, "concentration");
    /* the gradient of each displacement, then the scalar and its gradient */
    for (PetscInt k = 0; k < plan.input.count; k++) {
      const PetscInt scalar = k - dim * dim;

      ck_assert_int_eq((int)plan.input.component[k], scalar < 0 ? (int)(k / dim) : (int)dim);
      ck_assert_int_eq((int)plan.input.basis[k], scalar < 0 ? (int)(1 + k % dim) : (int)scalar);
    }
    for (PetscInt c = 0; c <= plan.block; c++) {
      ck_assert_int_eq((int)plan.input.by_component.first[c], c <= dim ? (int)(c * dim) : (int)plan.input.count);
    }
    ck_assert(MpmLayoutUsesValues(&plan));
  }
}
END_TEST

/* Bases of a shape stand side by side; fields that ask for the same share it. */
START_TEST(layout_shapes)
{
  for (PetscInt k = 0; k < OWN_COUNT; k++) {
    const PetscInt shape = k ? 1 : 0;
    MpmPhysics     toy   = Toy();
    MpmLayout      plan;

    SetOwn(k);
    UNIT_CALL(MpmLayoutCreate(&toy, 2, &plan));
    ck_assert_int_eq((int)plan.shape_count, (int)(1 + shape));
    for (PetscInt c = 0; c < 3; c++) ck_assert_int_eq((int)plan.component[c].shape, c < 2 ? 0 : (int)shape);
    for (PetscInt i = 4; i < 7; i++) ck_assert_int_eq((int)plan.input.basis[i], (int)(shape * MPM_BASES + i - 4));
    ck_assert(MpmLayoutUsesValues(&plan));
  }
  SetOwn(0);
}
END_TEST

/* A kernel of another number of inputs than the fields have; shapes that there are not. */
START_TEST(layout_refuses)
{
  MpmPhysics toy = Toy();
  MpmLayout  plan;

  fields[1].degree = 4;
  UNIT_FAILS(MpmLayoutCreate(&toy, 2, &plan), PETSC_ERR_SUP,
             "physics toy, field concentration: degree 4 must be 0 to 3, spacing 0 at least 0");
  SetOwn(0);
  fields[0].degree = 2;
  UNIT_FAILS(MpmLayoutCreate(&toy, 2, &plan), PETSC_ERR_SUP,
             "physics toy, field displacement: the first field has the scene's shape");
  fields[0].degree = 0;
  toy.field_count  = 1;
  UNIT_FAILS(MpmLayoutCreate(&toy, 2, &plan), PETSC_ERR_PLIB, "physics toy: kernel with 7 inputs, fields with 4");
}
END_TEST

/* ---- the Jacobian ---- */

static PetscErrorCode CreateBlock(MPI_Comm comm, PetscInt dim, const char *shape, PetscBool held, MpmModel *model)
{
  const MpmPhysics toy = Toy();
  char             options[4096];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "%s%s-mpm_shape %s -mpm_materials m -mpm_material_m_type neo_hookean -mpm_material_m_E 10 -mpm_material_m_nu 0.3 "
    "-mpm_bodies b -mpm_body_b_material m -mpm_body_b_region box -mpm_time_step 0.1 -mpm_time_end 0.4",
    dim == 2
      ? "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,2.4 -mpm_grid_cells 6,6 -mpm_body_b_lower 0.5,0.4 "
        "-mpm_body_b_upper 2.5,1.6 "
      : "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 2,2,1.6 -mpm_grid_cells 4,4,4 -mpm_body_b_lower 0.5,0.5,0.4 "
        "-mpm_body_b_upper 1.5,1.5,0.8 ",
    !held ? ""
    : dim == 2
      ? "-mpm_bcs floor,top -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0.4 -mpm_bc_floor_upper 3,0.4 "
        "-mpm_bc_floor_components x,y,concentration -mpm_bc_floor_value 0,0,0.7 -mpm_bc_floor_ramp 0:0,0.4:1 "
        "-mpm_bc_top_region box -mpm_bc_top_lower 0,1.6 -mpm_bc_top_upper 3,2 -mpm_bc_top_components x,y "
        "-mpm_bc_top_value 0.1,0.2 "
        "-mpm_bc_top_ramp 0:0,0.4:1 "
      : "-mpm_bcs floor,top -mpm_bc_floor_region box -mpm_bc_floor_lower 0,0,0.4 -mpm_bc_floor_upper 2,2,0.4 "
        "-mpm_bc_floor_components x,y,z,concentration -mpm_bc_floor_value 0,0,0,0.7 -mpm_bc_floor_ramp 0:0,0.4:1 "
        "-mpm_bc_top_region box -mpm_bc_top_lower 0,0,0.8 -mpm_bc_top_upper 2,2,1.2 -mpm_bc_top_components x,z "
        "-mpm_bc_top_value 0.1,0.1 -mpm_bc_top_ramp 0:0,0.4:1 ",
    shape));
  PetscCall(SceneCreate(comm, &toy, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A lattice of nodes some cells apart must fit the grid. */
START_TEST(lattice_refuses)
{
  MpmModel model;

  fields[1].spacing = 4;
  UNIT_FAILS(CreateBlock(PETSC_COMM_SELF, 2, "gimp", PETSC_FALSE, &model), PETSC_ERR_USER_INPUT,
             "-mpm_grid_cells 6: the nodes of concentration stand 4 cells apart on axis x, must be a multiple of 4");
  SetOwn(0);
}
END_TEST

/* Action of one field's values on the other's rows: 1-norms of the Jacobian's off-diagonal blocks by their action on
   ones. */
static PetscErrorCode Coupling(MpmModel model, Mat J, PetscInt seed, PetscReal *on_scalar, PetscReal *on_solid)
{
  const PetscInt bs = model->disc.block;
  Vec            v, Jv;
  PetscScalar   *values;

  PetscFunctionBeginUser;
  PetscCall(VecDuplicate(model->solver.x, &v));
  PetscCall(VecDuplicate(model->solver.x, &Jv));
  for (PetscInt from = 0; from < 2; from++) { /* 0: the solid acts, 1: the scalar */
    PetscReal  amplitude[MPM_MAX_BLOCK], sum = 0.;
    PetscReal *result = from ? on_solid : on_scalar;

    for (PetscInt c = 0; c < bs; c++) amplitude[c] = (c == bs - 1) == from ? 1. : 0.;
    PetscCall(SceneFill(model, seed, amplitude, PETSC_TRUE, v));
    PetscCall(MatMult(J, v, Jv));
    PetscCall(VecGetArray(Jv, &values));
    for (PetscInt k = 0; k < model->disc.space->owned * bs; k++)
      if ((k % bs == bs - 1) != from) sum += PetscAbsScalar(values[k]);
    PetscCall(VecRestoreArray(Jv, &values));
    PetscCall(MPIU_Allreduce(&sum, result, 1, MPIU_REAL, MPIU_SUM, model->comm));
  }
  PetscCall(VecDestroy(&v));
  PetscCall(VecDestroy(&Jv));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Look(MpmModel model, SceneVerdict *verdict, PetscReal *on_scalar, PetscReal *on_solid)
{
  const PetscInt dim = model->disc.dim;
  PetscReal      amplitude[MPM_MAX_BLOCK];
  Vec            v;
  Mat            J;

  PetscFunctionBeginUser;
  for (PetscInt c = 0; c <= dim; c++) amplitude[c] = c < dim ? 0.04 * model->disc.h[c] : 1.;
  PetscCall(SceneBegin(model, 0.1));
  PetscCall(SceneFill(model, 1, amplitude, PETSC_FALSE, model->solver.x));
  PetscCall(SceneCommit(model, model->solver.x));
  PetscCall(SceneBegin(model, 0.1));
  PetscCall(SceneFill(model, 2, amplitude, PETSC_FALSE, model->solver.x));
  PetscCall(VecDuplicate(model->solver.x, &v));
  PetscCall(SceneFill(model, 3, amplitude, PETSC_TRUE, v));
  PetscCall(SceneCompare(model, model->solver.x, v, verdict));
  PetscCall(SceneJacobian(model, MPM_JACOBIAN_LOCAL, model->solver.x, &J));
  PetscCall(Coupling(model, J, 4, on_scalar, on_solid));
  PetscCall(MatDestroy(&J));
  PetscCall(VecDestroy(&v));
  PetscFunctionReturn(PETSC_SUCCESS);
}

START_TEST(jacobians)
{
  /* all shapes with the scalar in the same, then each of the scalar's own with one of them */
  for (PetscInt k = 0; k < 4 * (MPM_SHAPE_COUNT + OWN_COUNT - 1); k++) {
    const PetscInt dim = 2 + k % 2, held = (k / 2) % 2, shape = k / 4 % MPM_SHAPE_COUNT,
                   degree = PetscMax(k / 4 - MPM_SHAPE_COUNT + 1, 0);
    MpmModel     model;
    SceneVerdict verdict;
    PetscReal    on_scalar, on_solid;
    char         name[100];

    if (UnitFew() && held != (k + k / 4) % 2) continue;
    SetOwn(degree);
    fields[1].scale = k / 4 % 2 ? MPM_SCALE_STRESS : MPM_SCALE_LENGTH; /* the solver's unit is 1, or not */
    SCENE_CALL(CreateBlock(PETSC_COMM_WORLD, dim, MpmShapeTypes[shape], (PetscBool)held, &model));
    SCENE_CALL(Look(model, &verdict, &on_scalar, &on_solid));
    snprintf(name, sizeof(name), "%dD %s, scalar of degree %d, spacing %d, %s", (int)dim, MpmShapeTypes[shape],
             own[degree].degree, own[degree].spacing, held ? "held" : "free");
    ck_assert_msg(on_scalar > 1e-3 && on_solid > 1e-3, "%s: the fields do not act on each other", name);
    ck_assert_msg(verdict.coloring <= 1e-14, "%s: local and coloured Jacobian differ by %g", name,
                  (double)verdict.coloring);
    ck_assert_msg(verdict.dense <= 1e-14, "%s: local and dense Jacobian differ by %g", name, (double)verdict.dense);
    ck_assert_msg(verdict.fd <= 1e-7, "%s: local and finite-difference Jacobian differ by %g", name,
                  (double)verdict.fd);
    ck_assert_msg(verdict.slope >= 1.95, "%s: the Taylor remainder has order %g", name, (double)verdict.slope);
    SCENE_CALL(SceneDestroy(&model));
  }
  fields[1].scale = MPM_SCALE_LENGTH;
}
END_TEST

/* ---- diffusion ---- */

#define CELLS 20
#define DT    0.002
#define STEPS 50

/* A strip of unit length that does not move; `conditions` holds the scalar. */
static PetscErrorCode CreateStrip(const char *conditions, MpmModel *model)
{
  const MpmPhysics toy = Toy();
  char             options[4096];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 1,0.1 -mpm_grid_cells %d,2 -mpm_shape linear -mpm_materials m "
    "-mpm_material_m_type neo_hookean -mpm_material_m_E 10 -mpm_material_m_nu 0.3 -mpm_bodies b -mpm_body_b_material m "
    "-mpm_body_b_region all -mpm_bc_still_region all -mpm_bc_still_components x,y -mpm_bc_left_region box "
    "-mpm_bc_left_lower 0,0 -mpm_bc_left_upper 0,0.1 -mpm_bc_left_components concentration -mpm_time_step %g "
    "-mpm_time_end %g %s",
    CELLS, DT, DT * STEPS, conditions));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, &toy, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The discrete mode: sin(pi x) at the nodes, linear between them. */
static PetscReal Mode(PetscReal x)
{
  const PetscReal h = 1. / CELLS;
  const PetscReal i = PetscFloorReal(x / h), at = x / h - i;

  return (1. - at) * PetscSinReal(PETSC_PI * i * h) + at * PetscSinReal(PETSC_PI * (i + 1.) * h);
}

/* The points' values at the start: the mode, or one value everywhere. */
static PetscErrorCode Start(MpmModel model, PetscBool mode)
{
  MpmPoints points;

  PetscFunctionBeginUser;
  PetscCall(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) points.physics.value[p] = mode ? Mode(points.x[2 * p]) : 0.7;
  PetscCall(MpmParticlesRestoreArrays(model->state.particles, &points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Newton starts from what the points hold: where nothing has to change there is no iteration. */
static void RunUniform(PetscInt k)
{
  MpmModel  model;
  MpmPoints points;
  PetscReal worst = 0.;

  SetOwn(k);
  SCENE_CALL(CreateStrip("-mpm_bcs still,left -mpm_bc_left_value 0.7", &model));
  SCENE_CALL(Start(model, PETSC_FALSE));
  SCENE_CALL(SceneRun(model));
  SCENE_CALL(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) worst = PetscMax(worst, PetscAbsReal(points.physics.value[p] - 0.7));
  SCENE_CALL(MpmParticlesRestoreArrays(model->state.particles, &points));
  ck_assert_msg(SceneAll((PetscBool)(worst <= 1e-13)), "degree %d: the value is wrong by %g", own[k].degree,
                (double)worst);
  ck_assert_int_eq((int)model->solver.iterations.newton_total, 0);
  SCENE_CALL(SceneDestroy(&model));
  SetOwn(0);
}

START_TEST(uniform)
{
  for (PetscInt k = 0; k < OWN_COUNT; k++) RunUniform(k);
}
END_TEST

/*
  With c = 0 at both ends the mode decays without changing its shape. Implicit Euler reduces it by 1/(1 + rate dt) a
  step, where on linear elements with points at a quarter and three quarters of the cell

    rate = D (2 - 2 cos kh)/h^2 / (5/8 + 3/8 cos kh) ,  k = pi,

  which is D pi^2 but for terms of order h^2. Known to rounding, so nothing may be lost between points and nodes.
*/
START_TEST(decay)
{
  const PetscReal h = 1. / CELLS, cosine = PetscCosReal(PETSC_PI * h);
  const PetscReal rate   = DIFFUSIVITY * (2. - 2. * cosine) / (h * h) / (0.625 + 0.375 * cosine);
  const PetscReal factor = PetscPowReal(1. + rate * DT, -STEPS);
  MpmModel        model;
  MpmPoints       points;
  PetscReal       worst = 0., moved = 0.;

  SCENE_CALL(
    CreateStrip("-mpm_bcs still,left,right -mpm_bc_right_region box -mpm_bc_right_lower 1,0 -mpm_bc_right_upper 1,0.1 "
                "-mpm_bc_right_components concentration",
                &model));
  SCENE_CALL(Start(model, PETSC_TRUE));
  SCENE_CALL(SceneRun(model));
  SCENE_CALL(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    worst = PetscMax(worst, PetscAbsReal(points.physics.value[p] - factor * Mode(points.x[2 * p])));
    moved = PetscMax(moved, PetscAbsReal(points.x[2 * p] - points.x0[2 * p]));
  }
  SCENE_CALL(MpmParticlesRestoreArrays(model->state.particles, &points));
  ck_assert_msg(PetscAbsReal(rate / (DIFFUSIVITY * PETSC_PI * PETSC_PI) - 1.) < 0.01, "the discrete rate is %g",
                (double)rate);
  ck_assert_msg(SceneAll((PetscBool)(worst <= 1e-9)), "the mode is wrong by %g", (double)worst);
  ck_assert_msg(SceneAll((PetscBool)(moved == 0.)), "a point has moved by %g", (double)moved);
  SCENE_CALL(SceneDestroy(&model));
}
END_TEST

/* c = 1 at x = 0, no flux at x = 1: 1 - sum_n 4/((2n+1) pi) sin((2n+1) pi x/2) exp(-((2n+1) pi/2)^2 D t) */
static PetscReal Inflow(PetscReal x, PetscReal time)
{
  PetscReal c = 1.;

  for (PetscInt n = 0; n < 200; n++) {
    const PetscReal k = (PetscReal)(2 * n + 1) * PETSC_PI / 2.;

    c -= 2. / k * PetscSinReal(k * x) * PetscExpReal(-k * k * DIFFUSIVITY * time);
  }
  return c;
}

static void RunInflow(PetscInt k)
{
  MpmModel  model;
  MpmPoints points;
  PetscReal worst = 0., content[2] = {0., 0.}, flow;

  SetOwn(k);
  SCENE_CALL(CreateStrip("-mpm_bcs still,left -mpm_bc_left_value 1", &model));
  SCENE_CALL(SceneRun(model));
  SCENE_CALL(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) {
    worst = PetscMax(worst, PetscAbsReal(points.physics.value[p] - Inflow(points.x[2 * p], model->state.time)));
    content[0] += points.volume0[p] * points.physics.value[p];
  }
  SCENE_CALL(MpmParticlesRestoreArrays(model->state.particles, &points));
  ck_assert_msg(SceneAll((PetscBool)(worst <= 0.01)), "degree %d, spacing %d: away from the series by %g",
                own[k].degree, own[k].spacing, (double)worst);
  /* one more step: what enters through the constrained nodes is what the points gain */
  model->state.period.end = model->state.dt.nominal;
  model->state.time       = 0.;
  SCENE_CALL(SceneRun(model));
  SCENE_CALL(MpmParticlesGetArrays(model->state.particles, &points));
  for (PetscInt p = 0; p < points.count; p++) content[1] += points.volume0[p] * points.physics.value[p];
  SCENE_CALL(MpmParticlesRestoreArrays(model->state.particles, &points));
  SCENE_CALL(MPI_Allreduce(MPI_IN_PLACE, content, 2, MPIU_REAL, MPI_SUM, PETSC_COMM_WORLD));
  flow = model->disc.nodal.reaction[1 * model->disc.block + 2];
  /* 21 x 3 nodes, on the lattice of spacing 2 11 x 2 of them */
  ck_assert_int_eq((int)model->disc.space->number.unknowns, 2 * 63 + (own[k].spacing > 1 ? 22 : 63));
  ck_assert_double_gt(flow, 0.05);
  ck_assert_double_eq_tol(flow, (content[1] - content[0]) / DT, 1e-9 * flow / DT);
  SCENE_CALL(SceneDestroy(&model));
  SetOwn(0);
}

START_TEST(inflow)
{
  for (PetscInt k = 0; k < OWN_COUNT; k++) RunInflow(k);
}
END_TEST

/* ---- on several ranks ---- */

/* Four steps in which the body is stretched and sheared while the scalar enters: the same on these ranks as on one. */
START_TEST(ranks_agree)
{
  for (PetscInt k = 0; k < 6; k++) {
    const PetscInt dim = 2 + k % 2;
    MpmModel       model, alone;
    PetscReal      moved = 0., value = 0.;

    SetOwn(k / 2);
    SCENE_CALL(CreateBlock(PETSC_COMM_WORLD, dim, "gimp", PETSC_TRUE, &model));
    SCENE_CALL(SceneRun(model));
    SCENE_CALL(CreateBlock(PETSC_COMM_SELF, dim, "gimp", PETSC_TRUE, &alone));
    SCENE_CALL(SceneRun(alone));
    SCENE_CALL(SceneFieldDifference(alone, model, dim, "position", "position0", &moved));
    SCENE_CALL(SceneFieldDifference(alone, model, 1, "value", NULL, &value));
    ck_assert_msg(SceneAll((PetscBool)(moved <= 1e-9)), "%dD: positions differ by %g", (int)dim, (double)moved);
    ck_assert_msg(SceneAll((PetscBool)(value <= 1e-9)), "%dD: values differ by %g", (int)dim, (double)value);
    ck_assert_int_eq((int)model->solver.iterations.newton_total, (int)alone->solver.iterations.newton_total);
    ck_assert_int_le((int)model->solver.iterations.newton_total, 24);
    SCENE_CALL(MpmModelDestroy(&alone));
    SCENE_CALL(SceneDestroy(&model));
  }
  SetOwn(0);
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {layout,  layout_shapes, layout_refuses, lattice_refuses, jacobians,
                                uniform, decay,         inflow,         ranks_agree};

  return UnitRun(&argc, &argv, "fields", sizeof(tests) / sizeof(tests[0]), tests);
}
