/*
  Laws and solids with axial symmetry are those of 3D whose F has no shear out of the plane: stress, history, fluxes and
  their derivatives, of every law. Ranks: 1
*/
#include "options/options.h"
#include "point/material.h"
#include "point/registry.h"
#include "unit.h"

static const MpmOptions block = {MPI_COMM_WORLD, "mpm_material_a_", NULL};

/* Components of F and of a symmetric tensor among those of 3D */
static const PetscInt plane[5] = {0, 1, 3, 4, 8}, sym[4] = {0, 1, 2, 3};

#define E_NU "-mpm_material_a_E 1e6 -mpm_material_a_nu 0.3 "
static const char *const laws[] = {
  "linear_elastic " E_NU,
  "hencky " E_NU,
  "neo_hookean " E_NU,
  "ogden -mpm_material_a_terms -2:-1e5,2:3e5 -mpm_material_a_bulk_modulus 1e6",
  "jaumann_elastic " E_NU "-mpm_material_a_cohesion 2e3 -mpm_material_a_friction 25",
  "newtonian -mpm_material_a_bulk_modulus 1e6 -mpm_material_a_viscosity 10",
  "j2 " E_NU "-mpm_material_a_yield_stress 5e3 -mpm_material_a_hardening 1e4",
  "mohr_coulomb " E_NU "-mpm_material_a_cohesion 2e3 -mpm_material_a_friction 30 -mpm_material_a_dilation 10",
  "drucker_prager " E_NU "-mpm_material_a_cohesion 2e3 -mpm_material_a_friction 30",
  "modified_cam_clay -mpm_material_a_kappa 0.02 -mpm_material_a_lambda 0.1 -mpm_material_a_M 1.2 -mpm_material_a_G 4e6 "
  "-mpm_material_a_reference_pressure 100e3 -mpm_material_a_preconsolidation 200e3",
  "nacc " E_NU "-mpm_material_a_M 1.5 -mpm_material_a_beta 0.1 -mpm_material_a_xi 3 -mpm_material_a_alpha_0 -0.01",
  "nor_sand -mpm_material_a_kappa 0.01 -mpm_material_a_lambda 0.02 -mpm_material_a_M 1.2 -mpm_material_a_N 0.3 "
  "-mpm_material_a_G 20e6 -mpm_material_a_v_c0 1.9 -mpm_material_a_h 100 -mpm_material_a_specific_volume 1.7 "
  "-mpm_material_a_reference_pressure 100e3 "
  "-mpm_material_a_preconsolidation 300e3"};

/* Reproducible numbers in [-1, 1] */
static double Number(unsigned *seed)
{
  *seed = *seed * 1664525u + 1013904223u;
  return 2. * (double)(*seed >> 8) / (double)(1u << 24) - 1.;
}

/* One kinematics: a kernel, its material, and the answer at a point */
typedef struct {
  MpmMaterial  material;
  MpmKernelSet kernel;
  double       F_n[9], input[10], F[9], stress[6], flux[10], tangent[100 + 31], state_n[64], state[64];
} Side;

static void SideCreate(const char *physics_name, int kinematics, Side *side)
{
  MpmPhysics physics;
  PetscBool  found;

  memset(side, 0, sizeof(*side));
  UNIT_CALL(MpmMaterialCreate(&block, "a", kinematics, NULL, &side->material));
  UNIT_CALL(MpmPhysicsCreate(physics_name, &physics, &found));
  ck_assert(found);
  side->kernel = physics.kernels[kinematics];
  MpmMaterialStateAtRest(&side->material, MpmKinematicsDim(kinematics), side->state_n);
}

/* Stress, history and tangent of a step */
static int Answer(Side *side)
{
  MpmKernelPoint point  = {.material.parameter = side->material.parameter,
                           .state_n            = side->state_n,
                           .F_n                = side->F_n,
                           .material.info      = &side->material.info,
                           .volume0            = 2.,
                           .dt                 = 0.1,
                           .material.traits    = side->material.info.traits,
                           .material.law       = side->material.law,
                           .material.table     = side->material.table};
  int            failed = side->kernel.tangent(&point, side->input, side->flux, side->tangent);

  point.end.state  = side->state;
  point.end.F      = side->F;
  point.end.stress = side->stress;
  return failed + side->kernel.residual(&point, side->input, side->flux);
}

static const char *law; /* under test */

static void Close(double a, double b, double scale)
{
  ck_assert_msg(fabs(a - b) <= 1e-9 * scale, "%s: %g and %g differ, scale %g", law, a, b, scale);
}

static void CompareHistory(const Side *axial, const Side *space)
{
  const double *a = axial->state, *b = space->state;

  for (size_t v = 0; v < axial->material.info.state_count; v++) {
    const PetscInt n = MpmStateComponents(&axial->material.info.states[v], 2),
                   m = MpmStateComponents(&axial->material.info.states[v], 3);

    for (PetscInt c = 0; c < n; c++) Close(a[c], b[n > 1 ? sym[c] : c], 1e-3 + fabs(a[c]));
    a += n;
    b += m;
  }
}

static void Compare(const Side *axial, const Side *space, int means)
{
  const int N = axial->kernel.inputs - means, M = space->kernel.inputs - means;
  double    largest = 0., steepest = 0.;

  for (int k = 0; k < M; k++) largest = fmax(largest, fabs(space->flux[k]));
  for (int c = 0; c < 6; c++) largest = fmax(largest, fabs(space->stress[c]));
  for (int k = 0; k < M * M; k++) steepest = fmax(steepest, fabs(space->tangent[k]));
  for (int c = 0; c < 4; c++) Close(axial->stress[c], space->stress[sym[c]], largest);
  for (int k = 0; k < 5; k++) Close(axial->F[k], space->F[plane[k]], 1.);
  for (int k = 0; k < N; k++) {
    Close(axial->flux[k], space->flux[plane[k]], largest);
    for (int l = 0; l < N; l++) Close(axial->tangent[k * N + l], space->tangent[plane[k] * M + plane[l]], steepest);
  }
  if (means) Close(axial->flux[N], space->flux[M], largest);
  CompareHistory(axial, space);
}

/* Steps from a deformed state, elastic and plastic */
static void Follow(const char *physics, int means)
{
  unsigned seed = 1;
  Side     axial, space;

  SideCreate(physics, MPM_AXISYMMETRY, &axial);
  SideCreate(physics, MPM_SPATIAL, &space);
  for (int k = 0; k < 9; k++) space.F_n[k] = k % 4 ? 0. : 1.;
  for (int step = 0; step < 6; step++) {
    const double size = step < 2 ? 1e-4 : 5e-3;
    int          failed;

    memset(space.input, 0, sizeof(space.input));
    for (int k = 0; k < 5; k++) {
      axial.input[k] = space.input[plane[k]] = size * (Number(&seed) - (plane[k] % 4 ? 0. : 0.5));
      axial.F_n[k]                           = space.F_n[plane[k]];
    }
    if (means) axial.input[5] = space.input[9] = 1. - size;
    failed = Answer(&axial);
    ck_assert_int_eq(failed, Answer(&space));
    ck_assert(step || !failed);
    if (failed) break;
    Compare(&axial, &space, means);
    memcpy(axial.state_n, axial.state, sizeof(axial.state));
    memcpy(space.state_n, space.state, sizeof(space.state));
    memcpy(space.F_n, space.F, sizeof(space.F));
  }
  UNIT_CALL(MpmMaterialDestroy(&axial.material));
  UNIT_CALL(MpmMaterialDestroy(&space.material));
}

START_TEST(every_law)
{
  for (size_t k = 0; k < PETSC_STATIC_ARRAY_LENGTH(laws); k++) {
    char text[1024];

    UNIT_CALL(PetscOptionsClear(NULL));
    UNIT_CALL(PetscSNPrintf(text, sizeof(text), "-mpm_material_a_density 1000 -mpm_material_a_type %s", laws[k]));
    UNIT_CALL(PetscOptionsInsertString(NULL, text));
    law = laws[k];
    Follow("solid", 0);
    Follow("solid_fbar", 1);
  }
}
END_TEST

/* Sizes and names of each kinematics */
START_TEST(kinds)
{
  ck_assert_int_eq(MpmKinematicsDim(MPM_AXISYMMETRY), 2);
  ck_assert_int_eq(MpmKinematicsF(MPM_PLANE_STRAIN), 4);
  ck_assert_int_eq(MpmKinematicsF(MPM_AXISYMMETRY), 5);
  ck_assert_int_eq(MpmKinematicsF(MPM_SPATIAL), 9);
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {every_law, kinds};

  return UnitRun(&argc, &argv, "axial symmetry", sizeof(tests) / sizeof(tests[0]), tests);
}
