/*
  Parts of the material: two blocks that share a face and their nodes' places move as each does alone, with every shape.
  Boxes of different parts that a term couples have their entries in the Jacobian, whichever ranks they are on.

  Ranks: 1 2 3
*/
#include "space/rules.h"
#include "problem/discretization.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "scene.h"

static const char *const scene_2d =
  "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 3,1.5 -mpm_grid_cells 12,6 -mpm_bcs base -mpm_bc_base_region box "
  "-mpm_bc_base_lower 0,0 -mpm_bc_base_upper 3,0 -mpm_bc_base_components x,y -mpm_load_g_value 6,-10 ";
static const char *const scene_3d =
  "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 3,1.5,1 -mpm_grid_cells 6,3,3 -mpm_bcs base -mpm_bc_base_region "
  "box -mpm_bc_base_lower 0,0,0 -mpm_bc_base_upper 3,0,1 -mpm_bc_base_components x,y,z -mpm_load_g_value 6,-10,3 ";
static const char *const blocks_2d[] = {"-mpm_body_a_region box -mpm_body_a_lower 0.75,0 -mpm_body_a_upper 1.5,0.9 ",
                                        "-mpm_body_b_region box -mpm_body_b_lower 1.5,0 -mpm_body_b_upper 2.25,0.9 "};
static const char *const blocks_3d[] = {
  "-mpm_body_a_region box -mpm_body_a_lower 0.5,0,0.2 -mpm_body_a_upper 1.5,1,0.8 ",
  "-mpm_body_b_region box -mpm_body_b_lower 1.5,0,0.2 -mpm_body_b_upper 2.5,1,0.8 "};
/* too soft for the bodies to affect one another */
static const char *const contact = "-mpm_contacts ab -mpm_contact_ab_bodies a,b -mpm_contact_ab_penalty 1e-13 ";

typedef struct {
  PetscInt    dim, shape;
  PetscBool   fbar;
  const char *bodies, *more; /* "a", "b" or "a,b" */
} Case;

static PetscErrorCode Create(const Case *the, MpmModel *model)
{
  const char *const *blocks = the->dim == 2 ? blocks_2d : blocks_3d;
  const PetscBool a = (PetscBool)(the->bodies[0] == 'a'), b = (PetscBool)(the->bodies[strlen(the->bodies) - 1] == 'b');
  char            options[4096];

  PetscFunctionBeginUser;
  PetscCall(PetscSNPrintf(
    options, sizeof(options),
    "%s%s%s%s%s%s%s-mpm_bodies %s -mpm_shape %s -mpm_materials soft,hard -mpm_material_hard_type hencky "
    "-mpm_material_hard_E 4e5 -mpm_material_hard_nu 0.3 -mpm_material_hard_density 1000 -mpm_material_soft_type hencky "
    "-mpm_material_soft_E 2e5 -mpm_material_soft_nu 0.4 -mpm_material_soft_density 1200 -mpm_loads g -mpm_load_g_type "
    "gravity -mpm_time_end 1 -mpm_time_step 0.5 -mpm_stabilization_ghost 0.05 -mpm_stabilization_fbar %s "
    "-snes_rtol 1e-12 -snes_stol 0 -mpm_shape_edge %s",
    the->dim == 2 ? scene_2d : scene_3d, a ? blocks[0] : "", b ? blocks[1] : "", a ? "-mpm_body_a_material soft " : "",
    b ? "-mpm_body_b_material hard " : "", a && b ? contact : "", the->more, the->bodies, MpmShapeTypes[the->shape],
    the->fbar ? "true" : "false", the->fbar && the->shape > MPM_SHAPE_GIMP ? "open" : "linear"));
  PetscCall(SceneCreate(PETSC_COMM_WORLD, NULL, options, model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- side by side ---- */

/* The blocks' points come in the order of the bodies, so that the second one's have the ids behind the first one's. */
static void CompareField(const char *name, MpmModel both, MpmModel alone[2], const char *field, PetscInt components)
{
  PetscReal     *of_both, *of_one, most = 0., off = 0.;
  const PetscInt first[2] = {0, (PetscInt)alone[0]->state.particles->total * components};

  SCENE_CALL(SceneById(both, components, field, &of_both));
  for (PetscInt k = 0; k < 2; k++) {
    SCENE_CALL(SceneById(alone[k], components, field, &of_one));
    for (PetscInt i = 0; i < (PetscInt)alone[k]->state.particles->total * components; i++) {
      most = PetscMax(most, PetscAbsReal(of_one[i]));
      off  = PetscMax(off, PetscAbsReal(of_one[i] - of_both[first[k] + i]));
    }
    SCENE_CALL(PetscFree(of_one));
  }
  SCENE_CALL(PetscFree(of_both));
  ck_assert_msg(off <= 1e-9 * most, "%s: %s is off by %g of %g", name, field, (double)off, (double)most);
}

static void Compare(PetscInt dim, PetscInt shape, PetscBool fbar, const char *more)
{
  const char *const bodies[] = {"a", "b", "a,b"};
  MpmModel          model[3];
  char              name[200];

  snprintf(name, sizeof(name), "%dD %s%s %s", (int)dim, MpmShapeTypes[shape], fbar ? " F-bar" : "", more);
  for (PetscInt k = 0; k < 3; k++) {
    const Case the = {dim, shape, fbar, bodies[k], more};

    SCENE_CALL(Create(&the, &model[k]));
    SCENE_CALL(SceneRun(model[k]));
  }
  ck_assert_int_eq(model[2]->disc.material.parts, 2);
  ck_assert_int_eq(model[0]->disc.material.parts, 1);
  ck_assert_int_eq(MpmParticlesHaveField(model[0]->state.particles, "part"), PETSC_FALSE);
  CompareField(name, model[2], model, "position", dim);
  CompareField(name, model[2], model, "stress", dim == 2 ? 4 : 6);
  for (PetscInt k = 0; k < 3; k++) SCENE_CALL(MpmModelDestroy(&model[k]));
  SCENE_CALL(PetscOptionsClear(NULL));
}

START_TEST(flat)
{
  for (PetscInt shape = 0; shape < MPM_SHAPE_COUNT; shape++) Compare(2, shape, (PetscBool)(shape % 2), "");
  Compare(2, MPM_SHAPE_GIMP, PETSC_FALSE, "-mpm_solver amg -ksp_rtol 1e-12 ");
}
END_TEST

START_TEST(solid)
{
  for (PetscInt shape = 0; shape < MPM_SHAPE_COUNT; shape++) Compare(3, shape, (PetscBool)(shape % 2 == 0), "");
}
END_TEST

/* ---- coupled ---- */

/*
  Springs between all nodes of a box of one part and one of the other, on the lowest rank: the residual is stiffness
  times (u_i - mean of the others).
*/
#define STIFFNESS 3e5
typedef struct {
  PetscInt dim, box[2];
} Springs;

/* At the face where the blocks meet, and one beside it that lies outside the window of the first. */
static PetscErrorCode SpringBoxes(void *ctx, const MpmRules *rules, const MpmPoints *points, MpmSpace *space)
{
  Springs  *springs = (Springs *)ctx;
  MpmGroup *boxes;

  PetscFunctionBeginUser;
  (void)points;
  if (rules->grid->rank) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt k = 0; k < 2; k++) springs->box[k] = space->boxes.count + k;
  PetscCall(MpmSpaceAppendBoxes(space, 2, &boxes));
  for (PetscInt k = 0; k < 2; k++) {
    MpmGroup *box = &boxes[k];

    box->node_count = 1;
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      box->first[a] = a < springs->dim ? (a ? 1 : rules->grid->cells[0] / 2 - 1 + 2 * k) : 0;
      box->count[a] = a < springs->dim ? 2 - k * (a == 0) : 1;
      box->node_count *= box->count[a];
    }
    box->first[springs->dim - 1] += k ? 0 : space->parts.stride;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpringLink(void *ctx, MpmSpace *space)
{
  const Springs *springs = (const Springs *)ctx;

  PetscFunctionBeginUser;
  if (springs->box[0] >= 0) PetscCall(MpmSpaceCouple(space, springs->box[0], springs->box[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The nodes of both boxes, n of them; 0 on ranks without them. */
static PetscInt SpringNodes(const Springs *springs, const MpmSpace *space, PetscInt nodes[])
{
  PetscInt n = 0;

  for (PetscInt k = 0; k < 2 && springs->box[0] >= 0; k++) {
    const MpmGroup *box = &space->groups[springs->box[k]];

    for (PetscInt i = 0; i < box->node_count; i++) nodes[n++] = space->group_nodes[box->node_offset + i];
  }
  return n;
}

static PetscErrorCode SpringApply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                                  PetscReal y[])
{
  PetscInt       nodes[32];
  const PetscInt n = SpringNodes((const Springs *)ctx, sum->space, nodes), bs = sum->block;

  PetscFunctionBeginUser;
  (void)u;
  for (PetscInt k = 0; k < n * bs; k++) {
    PetscReal mean = 0.;

    for (PetscInt j = 0; j < n; j++) mean += du[nodes[j] * bs + k % bs] / (PetscReal)n;
    y[nodes[k / bs] * bs + k % bs] += STIFFNESS * (du[nodes[k / bs] * bs + k % bs] - mean);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpringResidual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                                     PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)failed;
  PetscCall(SpringApply(ctx, sum, u, u, residual));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpringTangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                                    PetscReal residual[], PetscInt *failed)
{
  PetscInt       nodes[32];
  const PetscInt n = SpringNodes((const Springs *)ctx, sum->space, nodes), bs = sum->block;
  PetscReal     *element;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((n * n * bs * bs), &element));
  for (PetscInt i = 0; i < n; i++)
    for (PetscInt c = 0; c < bs; c++)
      for (PetscInt j = 0; j < n; j++)
        element[((i * bs + c) * bs + c) * n + j] = STIFFNESS * ((i == j ? 1. : 0.) - 1. / (PetscReal)n);
  MpmPatternAddNodes(pattern, sum->space, n, nodes, element);
  PetscCall(PetscFree(element));
  if (residual) PetscCall(SpringResidual(ctx, sum, u, residual, failed));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpringDiagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                                     PetscInt *failed)
{
  PetscInt       nodes[32];
  const PetscInt n = SpringNodes((const Springs *)ctx, sum->space, nodes), bs = sum->block;

  PetscFunctionBeginUser;
  (void)u;
  (void)failed;
  for (PetscInt k = 0; k < n * bs; k++)
    blocks[(nodes[k / bs] * bs + k % bs) * bs + k % bs] += STIFFNESS * (1. - 1. / (PetscReal)n);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static const MpmTerm spring_term = {.name     = "springs",
                                    .boxes    = SpringBoxes,
                                    .link     = SpringLink,
                                    .residual = SpringResidual,
                                    .tangent  = SpringTangent,
                                    .apply    = SpringApply,
                                    .diagonal = SpringDiagonal};

/* The largest force on the first part as the other one moves by one, by the matrix. */
static PetscReal Coupling(MpmModel model)
{
  const MpmSpace *space = model->disc.space;
  const PetscInt  bs    = model->disc.block;
  Mat             local;
  Vec             moved, force;
  PetscScalar    *values;
  PetscReal       most;

  SCENE_CALL(SceneJacobian(model, MPM_JACOBIAN_LOCAL, model->solver.x, &local));
  SCENE_CALL(VecDuplicate(model->solver.x, &moved));
  SCENE_CALL(VecDuplicate(model->solver.x, &force));
  for (PetscInt pass = 0; pass < 2; pass++) {
    SCENE_CALL(VecGetArray(pass ? force : moved, &values));
    for (PetscInt k = 0; k < space->owned * bs; k++)
      values[k] = (pass ? values[k] : 1.) * (PetscReal)(MpmSpacePart(space, &space->node[k / bs * space->dim]) != pass);
    SCENE_CALL(VecRestoreArray(pass ? force : moved, &values));
    if (!pass) SCENE_CALL(MatMult(local, moved, force));
  }
  SCENE_CALL(VecNorm(force, NORM_INFINITY, &most));
  SCENE_CALL(VecDestroy(&moved));
  SCENE_CALL(VecDestroy(&force));
  SCENE_CALL(MatDestroy(&local));
  return most;
}

static void Couple(PetscInt dim, PetscInt shape)
{
  const Case      the          = {dim, shape, (PetscBool)(shape % 2), "a,b", "-pc_type jacobi "};
  const PetscReal amplitude[3] = {0.004, 0.004, 0.004};
  Springs         springs      = {dim, {-1, -1}};
  MpmModel        model;
  SceneVerdict    verdict;
  Vec             v;

  SCENE_CALL(Create(&the, &model));
  SCENE_CALL(MpmTermsAdd(&model->disc.terms, &spring_term, &springs));
  SCENE_CALL(SceneBegin(model, 0.5));
  SCENE_CALL(VecDuplicate(model->solver.x, &v));
  SCENE_CALL(SceneFill(model, 3, amplitude, PETSC_FALSE, model->solver.x));
  SCENE_CALL(SceneFill(model, 4, amplitude, PETSC_TRUE, v));
  SCENE_CALL(SceneCompare(model, model->solver.x, v, &verdict));
  ck_assert_msg(verdict.coloring <= 1e-14, "local and coloured Jacobian differ by %g", (double)verdict.coloring);
  ck_assert_msg(verdict.dense <= 1e-14, "local and dense Jacobian differ by %g", (double)verdict.dense);
  ck_assert_msg(verdict.fd <= 1e-7, "local and finite-difference Jacobian differ by %g", (double)verdict.fd);
  ck_assert_msg(verdict.action[0] <= 1e-13, "local Jacobian and action differ by %g", (double)verdict.action[0]);
  ck_assert_msg(verdict.diagonal <= 1e-13, "diagonals differ by %g", (double)verdict.diagonal);
  ck_assert_msg(verdict.asymmetry <= 1e-13, "unsymmetric by %g", (double)verdict.asymmetry);
  ck_assert_msg(verdict.slope >= 1.95, "the Taylor remainder has order %g", (double)verdict.slope);
  ck_assert_msg(Coupling(model) > 0.3 * STIFFNESS, "the parts are not coupled");
  SCENE_CALL(VecDestroy(&v));
  SCENE_CALL(SceneDestroy(&model));
}

START_TEST(coupled)
{
  Couple(2, MPM_SHAPE_LINEAR);
  Couple(2, MPM_SHAPE_GIMP);
  Couple(3, MPM_SHAPE_BSPLINE2);
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {flat, solid, coupled};

  return UnitRun(&argc, &argv, "parts", sizeof(tests) / sizeof(tests[0]), tests);
}
