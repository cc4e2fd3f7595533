/*
  Rigid rotation of a body under stress, by 360 degrees in 12 steps: grid lines pass through it at every angle. The
  nodes are given the rotation's displacement, which every shape function reproduces, so that a step's deformation is
  the rotation itself. With an objective law and a sound update, after every step F = Q F_0, sigma = Q sigma_0 Q^T and x
  = c + Q (x_0 - c), with Q the rotation so far; after the last one everything is where it was.

  A small-strain law is not objective and is left out.

  Ranks: 1 2
*/
#include "scene.h"

#define STEPS 12
#define BOUND 1e-10

static const char *const scene[] = {
  [2] = "-mpm_dim 2 -mpm_grid_lower 0,0 -mpm_grid_upper 4,4 -mpm_grid_cells 8,8 -mpm_body_b_region box "
        "-mpm_body_b_lower 1,1.5 -mpm_body_b_upper 3,2.5 ",
  [3] = "-mpm_dim 3 -mpm_grid_lower 0,0,0 -mpm_grid_upper 4,4,4 -mpm_grid_cells 8,8,8 -mpm_body_b_region box "
        "-mpm_body_b_lower 1,1.5,1.5 -mpm_body_b_upper 3,2.5,2.5 ",
};
static const PetscReal center[MPM_MAX_DIM] = {2.05, 1.95, 2.1}; /* of rotation: no node, no point */

typedef struct {
  const char *name, *parameters;
} Law;

/* The strains before the rotation are some per cent, beyond the yield strains of the last two. */
static const Law laws[] = {
  {"hencky", ""},
  {"neo_hookean", ""},
  {"j2", "-mpm_material_m_yield_stress 1e4 -mpm_material_m_hardening 2e4 "},
  {"drucker_prager", "-mpm_material_m_cohesion 1e4 -mpm_material_m_friction 30 -mpm_material_m_dilation 10 "},
};

/* Rotation by an angle: in the plane, or about a skew axis. Rodrigues: Q = cos I + sin [n] + (1 - cos) n (x) n. */
static void Rotation(PetscInt dim, PetscReal angle, PetscReal Q[])
{
  const PetscReal s = PetscSinReal(angle), c = PetscCosReal(angle), length = PetscSqrtReal(14.);
  const PetscReal n[]    = {1. / length, 2. / length, 3. / length};
  const PetscReal skew[] = {0., -n[2], n[1], n[2], 0., -n[0], -n[1], n[0], 0.};

  if (dim == 2) {
    Q[0] = Q[3] = c;
    Q[1]        = -s;
    Q[2]        = s;
    return;
  }
  for (PetscInt a = 0; a < 3; a++)
    for (PetscInt b = 0; b < 3; b++) Q[a * 3 + b] = (a == b ? c : 0.) + s * skew[a * 3 + b] + (1. - c) * n[a] * n[b];
}

/* Values of the points, by id. */
typedef struct {
  PetscReal *x, *F, *stress;
} State;

static PetscErrorCode GetState(MpmModel model, State *state)
{
  const PetscInt dim = model->disc.dim;

  PetscFunctionBeginUser;
  PetscCall(SceneById(model, dim, "position", &state->x));
  PetscCall(SceneById(model, dim * dim, "F", &state->F));
  PetscCall(SceneById(model, model->state.particles->stress_size, "stress", &state->stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FreeState(State *state)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(state->x));
  PetscCall(PetscFree(state->F));
  PetscCall(PetscFree(state->stress));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Component ab of a stored stress: xx, yy, zz, xy (, yz, xz). */
static PetscReal Component(const PetscReal stress[], PetscInt a, PetscInt b)
{
  static const PetscInt place[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

  return stress[place[a][b]];
}

/* Deviations of the points' values. */
typedef struct {
  PetscReal position; /* m */
  PetscReal F;
  PetscReal stress; /* relative to the largest component */
} Error;

static void Compare(MpmModel model, const PetscReal Q[], const State *start, const State *now, Error *error)
{
  const PetscInt dim = model->disc.dim, size = model->state.particles->stress_size;
  PetscReal      most = 0.;

  *error = (Error){0., 0., 0.};
  for (PetscInt p = 0; p < (PetscInt)model->state.particles->total; p++) {
    const PetscReal *x0 = &start->x[p * dim], *F0 = &start->F[p * dim * dim], *s0 = &start->stress[p * size];
    const PetscReal *F = &now->F[p * dim * dim], *s = &now->stress[p * size];

    for (PetscInt k = 0; k < size; k++) most = PetscMax(most, PetscAbsReal(s0[k]));
    for (PetscInt a = 0; a < dim; a++) {
      PetscReal x = center[a];

      for (PetscInt b = 0; b < dim; b++) {
        PetscReal rotated_F = 0., rotated_stress = 0.;

        x += Q[a * dim + b] * (x0[b] - center[b]);
        for (PetscInt c = 0; c < dim; c++) {
          rotated_F += Q[a * dim + c] * F0[c * dim + b];
          for (PetscInt d = 0; d < dim; d++) rotated_stress += Q[a * dim + c] * Component(s0, c, d) * Q[b * dim + d];
        }
        error->F      = PetscMax(error->F, PetscAbsReal(F[a * dim + b] - rotated_F));
        error->stress = PetscMax(error->stress, PetscAbsReal(Component(s, a, b) - rotated_stress));
      }
      error->position = PetscMax(error->position, PetscAbsReal(now->x[p * dim + a] - x));
    }
    if (dim == 2) error->stress = PetscMax(error->stress, PetscAbsReal(s[2] - s0[2]));
  }
  error->stress = most > 0. ? error->stress / most : PETSC_MAX_REAL;
}

/* The nodal displacement (Q - I) (x - c). */
static PetscErrorCode Rotate(MpmModel model, const PetscReal Q[])
{
  const PetscInt dim = model->disc.dim, bs = model->disc.block;
  PetscScalar   *values;

  PetscFunctionBeginUser;
  PetscCall(SceneBegin(model, 1.));
  PetscCall(VecGetArrayWrite(model->solver.x, &values));
  for (PetscInt i = 0; i < model->disc.space->owned; i++) {
    PetscReal arm[MPM_MAX_DIM];

    for (PetscInt a = 0; a < dim; a++)
      arm[a] =
        model->disc.grid->lower[a] + model->disc.h[a] * (PetscReal)model->disc.space->node[i * dim + a] - center[a];
    for (PetscInt a = 0; a < dim; a++) {
      values[i * bs + a] = -arm[a];
      for (PetscInt b = 0; b < dim; b++) values[i * bs + a] += Q[a * dim + b] * arm[b];
    }
  }
  PetscCall(VecRestoreArrayWrite(model->solver.x, &values));
  PetscCall(SceneCommit(model, model->solver.x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A random step that strains every point in its own way, then the turns. */
static void Turn(PetscInt dim, PetscInt shape, const Law *law)
{
  const PetscReal step = 2. * PETSC_PI / STEPS;
  PetscReal       amplitude[MPM_MAX_DIM], once[MPM_MAX_DIM * MPM_MAX_DIM], Q[MPM_MAX_DIM * MPM_MAX_DIM];
  char            options[2048], name[100];
  State           start, now;
  MpmModel        model;
  Error           error;

  snprintf(options, sizeof(options),
           "%s%s-mpm_shape %s -mpm_materials m -mpm_material_m_type %s -mpm_material_m_E 1e6 -mpm_material_m_nu 0.3 "
           "-mpm_bodies b -mpm_body_b_material m -mpm_time_step 1 -mpm_time_end %d",
           scene[dim], law->parameters, MpmShapeTypes[shape], law->name, STEPS + 1);
  SCENE_CALL(SceneCreate(PETSC_COMM_WORLD, NULL, options, &model));
  SCENE_CALL(SceneBegin(model, 1.));
  for (PetscInt a = 0; a < dim; a++) amplitude[a] = 0.05 * model->disc.h[a];
  SCENE_CALL(SceneFill(model, 1, amplitude, PETSC_FALSE, model->solver.x));
  SCENE_CALL(SceneCommit(model, model->solver.x));
  SCENE_CALL(GetState(model, &start));
  Rotation(dim, step, once);
  for (int k = 1; k <= STEPS; k++) {
    SCENE_CALL(Rotate(model, once));
    SCENE_CALL(GetState(model, &now));
    Rotation(dim, k == STEPS ? 0. : k * step, Q);
    Compare(model, Q, &start, &now, &error);
    snprintf(name, sizeof(name), "%dD %s %s, turn %d", (int)dim, MpmShapeTypes[shape], law->name, k);
    ck_assert_msg(error.position <= BOUND, "%s: points are off by %g m", name, (double)error.position);
    ck_assert_msg(error.F <= BOUND, "%s: F is off by %g", name, (double)error.F);
    ck_assert_msg(error.stress <= BOUND, "%s: stress is off by %g of the largest", name, (double)error.stress);
    SCENE_CALL(FreeState(&now));
  }
  SCENE_CALL(FreeState(&start));
  SCENE_CALL(SceneDestroy(&model));
}

static void TurnAll(PetscInt dim)
{
  for (PetscInt shape = 0; shape < MPM_SHAPE_COUNT; shape++)
    for (size_t l = 0; l < PETSC_STATIC_ARRAY_LENGTH(laws); l++) Turn(dim, shape, &laws[l]);
}

START_TEST(plane)
{
  TurnAll(2);
}
END_TEST

START_TEST(space)
{
  TurnAll(3);
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {plane, space};

  return UnitRun(&argc, &argv, "rotation", sizeof(tests) / sizeof(tests[0]), tests);
}
