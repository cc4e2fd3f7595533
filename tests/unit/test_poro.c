/*
  The kernels of saturated ground at one point, with and without F-bar: derived parameters, permeability by the volume,
  one an axis, storage from the step's start and its first sub-step, derivatives against differences, symmetry.
*/
#include "options/options.h"
#include "point/layout.h"
#include "point/material.h"
#include "point/registry.h"
#include "unit.h"

#include <math.h>
#include <stdio.h>

/* Places among the physics' values: of the material, then of the scene */
enum { POROSITY, MOBILITY, CONDUCTIVITY = MOBILITY + 3, LAW = CONDUCTIVITY + 3, DENSITY, VISCOSITY, MODULUS, PPP };

static const MpmOptions block    = {MPI_COMM_WORLD, "mpm_", NULL};
static const char      *kinds[2] = {"poro", "poro_fbar"};

static const char *const elastic =
  "-mpm_material_a_type neo_hookean -mpm_material_a_E 2.5 -mpm_material_a_nu 0.25 "; /* lambda = mu = 1 */

static MpmPhysics Physics(const char *name)
{
  MpmPhysics physics;
  PetscBool  found;

  UNIT_CALL(MpmPhysicsCreate(name, &physics, &found));
  ck_assert(found);
  return physics;
}

/* A material with what the physics takes of it, under a gravity of 9.81 m/s2 */
static void Ground(PetscInt dim, const char *law, const char *rest, MpmMaterial *ground)
{
  const MpmPhysics physics = Physics("poro");

  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsInsertString(NULL, law));
  UNIT_CALL(PetscOptionsInsertString(NULL, rest));
  UNIT_CALL(MpmMaterialCreate(&block, "a", dim, NULL, ground));
  UNIT_CALL(MpmMaterialReadPhysics(&block, &physics, dim, NULL, ground));
  UNIT_CALL(MpmMaterialPrepare(&physics, dim, 9.81, ground));
}

static double Random(double lower, double upper)
{
  return lower + (upper - lower) * ((double)rand() / RAND_MAX);
}

/* A point in the middle of its life, and room for what it is told */
typedef struct {
  MpmKernelPoint      point;
  MpmKernelStage      stage;
  const MpmKernelSet *set;
  PetscInt            dim;
  int                 inputs; /* the mean's apart */
  double F_n[9], F_1[9], value_n, value_1, deviation_n, deviation_1, own_n[4], own[4], gravity[3], F[9], stress[6],
    state_n[16], state[16];
} Place;

static void Take(const MpmMaterial *ground, PetscInt dim, const MpmPhysics *physics, double strain, Place *at)
{
  MpmKernelPoint *point = &at->point;

  memset(at, 0, sizeof(*at));
  at->dim    = dim;
  at->set    = &physics->kernels[dim];
  at->inputs = (int)(dim * dim + dim + 2);
  for (PetscInt k = 0; k < dim * dim; k++) {
    at->F_n[k] = (k % (dim + 1) == 0) + strain * Random(-1., 1.);
    at->F_1[k] = (k % (dim + 1) == 0) + strain * Random(-1., 1.);
  }
  at->value_n     = Random(-1., 1.);
  at->value_1     = Random(-1., 1.);
  at->deviation_n = Random(-1., 1.);
  at->deviation_1 = Random(-1., 1.);
  at->own_n[0]    = ground->physics_parameter[POROSITY];
  for (PetscInt a = 0; a < dim; a++) at->gravity[a] = Random(-1., 1.);
  MpmMaterialStateAtRest(ground, dim, at->state_n);
  *point = (MpmKernelPoint){.material.parameter = ground->parameter,
                            .physics_parameter  = ground->physics_parameter,
                            .state_n            = at->state_n,
                            .F_n                = at->F_n,
                            .value_n            = &at->value_n,
                            .deviation_n        = &at->deviation_n,
                            .gravity            = at->gravity,
                            .material.info      = &ground->info,
                            .own_n              = at->own_n,
                            .volume0            = 0.7,
                            .dt                 = 0.3,
                            .material.traits    = ground->info.traits,
                            .material.law       = ground->law,
                            .material.table     = ground->table};
  at->stage =
    (MpmKernelStage){.F = at->F_1, .value = &at->value_1, .deviation = &at->deviation_1, .theta = 0.4, .span = 0.3};
}

static void AtRest(Place *at)
{
  for (PetscInt k = 0; k < at->dim * at->dim; k++) at->F_n[k] = k % (at->dim + 1) == 0;
  at->value_n = at->deviation_n = at->gravity[0] = at->gravity[1] = at->gravity[2] = 0.;
}

static void Residual(const Place *at, const double input[], double flux[])
{
  ck_assert_int_eq(at->set->residual(&at->point, input, flux), 0);
}

/* ---- what the scene says ---- */

START_TEST(numbers)
{
  MpmMaterial ground;

  Ground(3, elastic, "-mpm_material_a_porosity 0.3 -mpm_material_a_permeability 1e-12 -mpm_water_viscosity 2e-3",
         &ground);
  ck_assert_double_eq(ground.physics_parameter[POROSITY], 0.3);
  for (int a = 0; a < 3; a++) ck_assert_double_eq_tol(ground.physics_parameter[MOBILITY + a], 5e-10, 1e-25);
  ck_assert_double_eq(ground.physics_parameter[LAW], 0.);
  ck_assert_double_eq(ground.physics_parameter[DENSITY], 1000.);
  ck_assert_double_eq(ground.physics_parameter[PPP], 1.);
  ck_assert(1. / ground.physics_parameter[MODULUS] == 0.);
  UNIT_CALL(MpmMaterialDestroy(&ground));

  /* m = k/mu = K/(rho g), an axis each */
  Ground(2, elastic,
         "-mpm_material_a_porosity 0.3 -mpm_material_a_conductivity 1e-5,3e-6 -mpm_water_density 1020 "
         "-mpm_water_viscosity 7",
         &ground);
  ck_assert_double_eq_tol(ground.physics_parameter[MOBILITY], 1e-5 / (1020. * 9.81), 1e-24);
  ck_assert_double_eq_tol(ground.physics_parameter[MOBILITY + 1], 3e-6 / (1020. * 9.81), 1e-24);
  UNIT_CALL(MpmMaterialDestroy(&ground));

  /* n = 1 - 1/v */
  Ground(2,
         "-mpm_material_a_type modified_cam_clay -mpm_material_a_kappa 0.02 -mpm_material_a_lambda 0.1 "
         "-mpm_material_a_M 1.2 "
         "-mpm_material_a_G 4e6 -mpm_material_a_ocr 1.5 -mpm_material_a_specific_volume 2.5 "
         "-mpm_material_a_reference_pressure 1e5 ",
         "-mpm_material_a_permeability 1e-12 -mpm_material_a_permeability_law kozeny_carman", &ground);
  ck_assert_double_eq_tol(ground.physics_parameter[POROSITY], 0.6, 1e-15);
  ck_assert_double_eq(ground.physics_parameter[LAW], 1.);
  UNIT_CALL(MpmMaterialDestroy(&ground));
}
END_TEST

/* ---- how water flows ---- */

/* Flow along an axis by a pressure gradient of 1 along it, at uniaxial strain of stretch J, over that without strain */
static double Factor(const MpmMaterial *ground, PetscInt dim, PetscInt axis, double J)
{
  const MpmPhysics physics               = Physics("poro");
  double           input[MPM_MAX_INPUTS] = {0.}, flux[MPM_MAX_INPUTS];
  Place            at;

  Take(ground, dim, &physics, 0., &at);
  AtRest(&at);
  input[axis * (dim + 1)]     = J - 1.;
  input[dim * dim + 1 + axis] = 1.;
  Residual(&at, input, flux);
  /* -dt V_0 J m/J^2 */
  return -flux[dim * dim + 1 + axis] * J /
         (at.point.dt * at.point.volume0 * ground->physics_parameter[MOBILITY + axis]);
}

START_TEST(permeability_laws)
{
  /* lambda = 10, mu = 15; J of the end of a consolidation and what is left there of m: (lambda + 2 mu) J/M(J) */
  const char *const rubber = "-mpm_material_a_type neo_hookean -mpm_material_a_E 36 -mpm_material_a_nu 0.2 ";
  const double      J      = 0.792064218209;

  for (PetscInt dim = 2; dim <= 3; dim++) {
    MpmMaterial ground;

    Ground(dim, rubber, "-mpm_material_a_porosity 0.5 -mpm_material_a_permeability 1", &ground);
    ck_assert_double_eq_tol(Factor(&ground, dim, 1, J), 1., 1e-14);
    UNIT_CALL(MpmMaterialDestroy(&ground));
    Ground(dim, rubber,
           "-mpm_material_a_porosity 0.5 -mpm_material_a_permeability 1 -mpm_material_a_permeability_law uzuoka_borja",
           &ground);
    ck_assert_double_eq_tol(Factor(&ground, dim, dim - 1, J), 0.5409821612, 1e-10);
    ck_assert_double_eq_tol(Factor(&ground, dim, 0, 1.), 1., 1e-14);
    UNIT_CALL(MpmMaterialDestroy(&ground));
    /* (n/n_0)^3 ((1 - n_0)/(1 - n))^2, n = 1 - (1 - n_0)/J */
    Ground(dim, rubber,
           "-mpm_material_a_porosity 0.4 -mpm_material_a_permeability 1 -mpm_material_a_permeability_law kozeny_carman",
           &ground);
    for (double j = 0.7; j < 1.4; j += 0.2) {
      const double n = 1. - 0.6 / j;

      ck_assert_double_eq_tol(Factor(&ground, dim, 0, j), pow(n / 0.4, 3.) * pow(0.6 / (1. - n), 2.), 1e-14);
    }
    UNIT_CALL(MpmMaterialDestroy(&ground));
  }
}
END_TEST

/* A permeability an axis: each drives water along its own; gravity counts as a gradient of density times gravity. */
START_TEST(axes_and_gravity)
{
  const MpmPhysics physics = Physics("poro");

  for (PetscInt dim = 2; dim <= 3; dim++) {
    const char *const each = dim == 2 ? "-mpm_material_a_porosity 0.5 -mpm_water_density 3 -mpm_water_viscosity 2 "
                                        "-mpm_material_a_permeability 1,4"
                                      : "-mpm_material_a_porosity 0.5 -mpm_water_density 3 -mpm_water_viscosity 2 "
                                        "-mpm_material_a_permeability 1,4,9";
    double            input[MPM_MAX_INPUTS] = {0.}, flux[MPM_MAX_INPUTS];
    MpmMaterial       ground;
    Place             at;

    Ground(dim, elastic, each, &ground);
    Take(&ground, dim, &physics, 0., &at);
    AtRest(&at);
    at.point.end.F = at.F, at.point.end.stress = at.stress, at.point.end.own = at.own, at.point.end.state = at.state;
    for (PetscInt a = 0; a < dim; a++) {
      at.gravity[a]            = (double)a - 0.5;
      input[dim * dim + 1 + a] = 1. + (double)a;
    }
    Residual(&at, input, flux);
    for (PetscInt a = 0; a < dim; a++) {
      const double slope = 1. + (double)a - 3. * ((double)a - 0.5), m = (double)((a + 1) * (a + 1)) / 2.;

      ck_assert_double_eq_tol(flux[dim * dim + 1 + a], -0.3 * 0.7 * m * slope, 1e-14);
      ck_assert_double_eq_tol(at.own[1 + a], -m * slope, 1e-14);
    }
    ck_assert_double_eq_tol(at.own[0], 0.5, 1e-15);
    UNIT_CALL(MpmMaterialDestroy(&ground));
  }
}
END_TEST

/* ---- what it keeps ---- */

/* The flux of p is -V_0 (zeta - zeta_n), or of the second sub-step -V_0 (zeta - zeta_n - theta (zeta_1 - zeta_n));
   that of the deviation likewise, times c/(2 mu). */
START_TEST(storage)
{
  const MpmPhysics physics = Physics("poro");

  for (int k = 0; k < 16; k++) {
    const PetscInt dim = 2 + k % 2;
    double         input[MPM_MAX_INPUTS], flux[MPM_MAX_INPUTS], zeta[3], c = 1.7, modulus = 5., mu = 1.;
    MpmMaterial    ground;
    Place          at;

    Ground(
      dim, k % 4 < 2 ? elastic : "-mpm_material_a_type linear_elastic -mpm_material_a_E 2.5 -mpm_material_a_nu 0.25 ",
      k % 8 < 4
        ? "-mpm_material_a_porosity 0.5 -mpm_material_a_permeability 1 -mpm_water_modulus 5 -mpm_stabilization_ppp 1.7"
        : "-mpm_material_a_porosity 0.5 -mpm_material_a_permeability 1 -mpm_stabilization_ppp 1.7",
      &ground);
    if (k % 8 >= 4) modulus = HUGE_VAL;
    Take(&ground, dim, &physics, 0.1, &at);
    if (k >= 8) at.point.stage = &at.stage;
    for (int i = 0; i < at.inputs; i++) input[i] = 0.1 * Random(-1., 1.);
    {
      const double  p[3]  = {at.value_n, at.value_1, input[dim * dim]};
      const int     small = k % 4 >= 2;
      double        F[9], dF[9], grains = small ? 0.5 : 0., J[3];
      const double *all[3] = {at.F_n, at.F_1, F};

      for (PetscInt i = 0; i < dim * dim; i++) dF[i] = input[i] + (i % (dim + 1) == 0);
      for (PetscInt i = 0; i < dim; i++)
        for (PetscInt j = 0; j < dim; j++) {
          F[i * dim + j] = 0.;
          for (PetscInt l = 0; l < dim; l++) F[i * dim + j] += dF[i * dim + l] * at.F_n[l * dim + j];
        }
      for (int s = 0; s < 3; s++) {
        J[s] = small ? 1. : MpmDeterminant((int)(dim * dim), all[s]);
        for (PetscInt a = 0; small && a < dim; a++) J[s] += all[s][a * (dim + 1)] - 1.;
      }
      /* the porosity that the point has is that of the step's start */
      grains = 0.5 * J[0];
      for (int s = 0; s < 3; s++)
        zeta[s] =
          small ? J[s] - 1. + (1. - grains) * p[s] / modulus : (J[s] - grains) * (1. + p[s] / modulus) - (1. - grains);
      if (!small) { /* the elastic shear modulus of the step's start */
        mu = dim == 2 ? 1. / 3. : 0.;
        for (PetscInt i = 0; i < dim * dim; i++) mu += at.F_n[i] * at.F_n[i] / 3.;
      }
    }
    Residual(&at, input, flux);
    if (k < 8) {
      ck_assert_double_eq_tol(flux[dim * dim], -0.7 * (zeta[2] - zeta[0]), 1e-14);
      ck_assert_double_eq_tol(flux[at.inputs - 1], -0.7 * c / (2. * mu) * (input[at.inputs - 1] - at.deviation_n),
                              1e-14);
    } else {
      ck_assert_double_eq_tol(flux[dim * dim], -0.7 * (zeta[2] - zeta[0] - 0.4 * (zeta[1] - zeta[0])), 1e-14);
      ck_assert_double_eq_tol(flux[at.inputs - 1],
                              -0.7 * c / (2. * mu) *
                                (input[at.inputs - 1] - at.deviation_n - 0.4 * (at.deviation_1 - at.deviation_n)),
                              1e-14);
    }
    UNIT_CALL(MpmMaterialDestroy(&ground));
  }
}
END_TEST

/* ---- derivatives ---- */

/* All fluxes by all inputs, those of and by the mean last */
static void Tangent(const Place *at, const double input[], double flux[], double full[])
{
  const int N = at->inputs, size = at->set->inputs;
  double    row[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

  ck_assert_int_eq(at->set->tangent(&at->point, input, flux, row), 0);
  for (int k = 0; k < size; k++) {
    for (int l = 0; l < size; l++) {
      if (k < N && l < N) full[k * size + l] = row[k * N + l];
      else if (l == N) full[k * size + l] = k < N ? row[N * N + k] : row[N * (N + 2)];
      else full[k * size + l] = row[N * (N + 1) + l];
    }
  }
}

static int kinks;

static void CheckForms(const Place *at, const double input[], const char *what)
{
  const int    size = at->set->inputs;
  const double h    = 2e-4;
  double       flux[3][MPM_MAX_INPUTS], full[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

  Tangent(at, input, flux[2], full);
  Residual(at, input, flux[0]);
  for (int k = 0; k < size; k++) ck_assert_double_eq_tol(flux[2][k], flux[0][k], 2e-15);
  for (int l = 0; l < size; l++) {
    double along[MPM_MAX_INPUTS] = {0.}, slope[MPM_MAX_INPUTS], differences[3][MPM_MAX_INPUTS];

    along[l] = 1.;
    ck_assert_int_eq(at->set->direction(&at->point, input, along, flux[0], slope), 0);
    for (int level = 0; level < 3; level++) {
      const double step = h / (1 << level);
      double       moved[MPM_MAX_INPUTS];

      for (int side = 0; side < 2; side++) {
        memcpy(moved, input, sizeof(moved));
        moved[l] += side ? -step : step;
        Residual(at, moved, flux[side]);
      }
      for (int k = 0; k < size; k++) differences[level][k] = (flux[0][k] - flux[1][k]) / (2. * step);
    }
    for (int k = 0; k < size; k++) { /* two extrapolations of Richardson's */
      const double once[2] = {(4. * differences[1][k] - differences[0][k]) / 3.,
                              (4. * differences[2][k] - differences[1][k]) / 3.};
      const double best    = (16. * once[1] - once[0]) / 15.;

      ck_assert_msg(fabs(full[k * size + l] - slope[k]) <= 1e-14, "%s: forms of d %d/d %d differ by %g", what, k, l,
                    full[k * size + l] - slope[k]);
      if (fabs(once[1] - once[0]) > 1e-6) { /* a kink between them: the point just yields */
        kinks++;
        continue;
      }
      ck_assert_msg(fabs(full[k * size + l] - best) <= 1e-9, "%s: d %d/d %d is %g, by differences %g", what, k, l,
                    full[k * size + l], best);
    }
  }
}

/* m and its derivatives by the kernel's inputs */
static void CheckMean(const Place *at, const double input[], const char *what)
{
  const int    N = at->inputs;
  const double h = 1e-5;
  double       m[2], dm[2][MPM_MAX_INPUTS], slope[MPM_MAX_INPUTS], ddm[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

  ck_assert_int_eq(at->set->mean_tangent(&at->point, input, &m[0], slope, ddm), 0);
  for (int l = 0; l < N; l++) {
    for (int side = 0; side < 2; side++) {
      double moved[MPM_MAX_INPUTS];

      memcpy(moved, input, sizeof(moved));
      moved[l] += side ? -h : h;
      ck_assert_int_eq(at->set->mean(&at->point, moved, &m[side], dm[side], NULL), 0);
    }
    ck_assert_msg(fabs((m[0] - m[1]) / (2. * h) - slope[l]) <= 1e-9, "%s: d m/d %d", what, l);
    for (int k = 0; k < N; k++)
      ck_assert_msg(fabs((dm[0][k] - dm[1][k]) / (2. * h) - ddm[k * N + l]) <= 1e-9, "%s: d2 m/d %d d %d", what, k, l);
  }
}

static double Asymmetry(const Place *at, const double input[])
{
  const int size  = at->set->inputs;
  double    worst = 0., flux[MPM_MAX_INPUTS], full[MPM_MAX_INPUTS * MPM_MAX_INPUTS];

  Tangent(at, input, flux, full);
  for (int k = 0; k < size * size; k++) worst = fmax(worst, fabs(full[k] - full[k % size * size + k / size]));
  return worst;
}

static const char *const laws[] = {"-mpm_material_a_type neo_hookean ", "-mpm_material_a_type linear_elastic ",
                                   "-mpm_material_a_type hencky ",
                                   "-mpm_material_a_type j2 -mpm_material_a_yield_stress 0.03 "};
static const char *const permeabilities[] = {"constant", "kozeny_carman", "uzuoka_borja"};

/*
  Forms against each other and differences. The Jacobian is symmetric at small strain, where water flows by the initial
  shape, and at large strain where nothing flows and water is incompressible.
*/
START_TEST(derivatives)
{
  for (int k = 0; k < 2 * 2 * 4 * 3 * 2; k++) {
    const PetscInt   dim     = 2 + k % 2;
    const MpmPhysics physics = Physics(kinds[k / 2 % 2]);
    const int        law = k / 4 % 4, permeability = k / 16 % 3;
    char             rest[400], what[400];
    double           input[MPM_MAX_INPUTS] = {0.};
    MpmMaterial      ground;
    Place            at;

    snprintf(
      rest, sizeof(rest),
      "-mpm_material_a_E 2.5 -mpm_material_a_nu 0.25 -mpm_material_a_porosity 0.45 -mpm_material_a_permeability %s "
      "-mpm_material_a_permeability_law %s -mpm_water_density 0.8 -mpm_water_viscosity 0.6 %s",
      dim == 2 ? "0.3,0.7" : "0.3,0.7,0.2", permeabilities[permeability], k % 5 ? "" : "-mpm_water_modulus 3");
    Ground(dim, laws[law], rest, &ground);
    Take(&ground, dim, &physics, 0.05, &at);
    if (k >= 48) at.point.stage = &at.stage;
    for (int i = 0; i < at.inputs; i++) input[i] = (i < dim * dim ? 0.05 : 1.) * Random(-1., 1.);
    if (at.set->mean) input[at.inputs] = Random(0.9, 1.1);
    snprintf(what, sizeof(what), "%s %dD, %s, %s", physics.name, (int)dim, laws[law], permeabilities[permeability]);
    CheckForms(&at, input, what);
    if (at.set->mean) CheckMean(&at, input, what);
    if (law != 1) at.point.dt = 0.;
    if (law == 1 ? permeability == 0 : k % 5 > 0) {
      const double asymmetry = Asymmetry(&at, input);

      ck_assert_msg(asymmetry <= (law == 3 ? 1e-13 : 3e-15), "%s: asymmetry %g", what, asymmetry);
    }
    UNIT_CALL(MpmMaterialDestroy(&ground));
  }
  ck_assert_int_le(kinks, 20);
}
END_TEST

/* With F-bar a mean that is the point's own volume change makes the kernel without: all fluxes but that of the mean,
   which goes to the gradients. */
START_TEST(mean_of_one)
{
  for (int k = 0; k < 8; k++) {
    const PetscInt   dim   = 2 + k % 2;
    const MpmPhysics plain = Physics("poro"), averaged = Physics("poro_fbar");
    double           input[MPM_MAX_INPUTS] = {0.}, flux[2][MPM_MAX_INPUTS], m, dm[MPM_MAX_INPUTS];
    MpmMaterial      ground;
    Place            at;

    Ground(
      dim, laws[k / 2 % 2],
      "-mpm_material_a_E 2.5 -mpm_material_a_nu 0.25 -mpm_material_a_porosity 0.45 -mpm_material_a_permeability 0.3 "
      "-mpm_material_a_permeability_law kozeny_carman -mpm_water_density 0.8 -mpm_water_viscosity 0.6",
      &ground);
    Take(&ground, dim, &averaged, 0.05, &at);
    for (int i = 0; i < at.inputs; i++) input[i] = (i < dim * dim ? 0.05 : 1.) * Random(-1., 1.);
    ck_assert_int_eq(at.set->mean(&at.point, input, &m, dm, NULL), 0);
    input[at.inputs] = m;
    Residual(&at, input, flux[0]);
    at.set = &plain.kernels[dim];
    Residual(&at, input, flux[1]);
    for (int i = 0; i < at.inputs; i++)
      ck_assert_double_eq_tol(flux[0][i] + flux[0][at.inputs] * dm[i], flux[1][i], 1e-14);
    UNIT_CALL(MpmMaterialDestroy(&ground));
  }
}
END_TEST

/* Ground without pores has no answer where permeability depends on them. */
START_TEST(no_answer)
{
  for (int k = 0; k < 2; k++) {
    const MpmPhysics physics               = Physics(kinds[k]);
    double           input[MPM_MAX_INPUTS] = {-0.5, 0., 0., -0.2}, flux[MPM_MAX_INPUTS];
    MpmMaterial      ground;
    Place            at;

    Ground(2, elastic,
           "-mpm_material_a_porosity 0.4 -mpm_material_a_permeability 1 -mpm_material_a_permeability_law kozeny_carman",
           &ground);
    Take(&ground, 2, &physics, 0., &at);
    AtRest(&at);
    input[at.inputs] = 0.4;
    ck_assert_int_ne(at.set->residual(&at.point, input, flux), 0);
    input[0] = 0., input[3] = 0., input[at.inputs] = 1.;
    ck_assert_int_eq(at.set->residual(&at.point, input, flux), 0);
    UNIT_CALL(MpmMaterialDestroy(&ground));
  }
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {numbers,     permeability_laws, axes_and_gravity, storage,
                                derivatives, mean_of_one,       no_answer};

  return UnitRun(&argc, &argv, "saturated ground", sizeof(tests) / sizeof(tests[0]), tests);
}
