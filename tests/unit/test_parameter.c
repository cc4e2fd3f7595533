/*
  Parameters of a law that are tables or data: what is accepted, what is refused and in which words, what the law makes
  of them. Ranks: 1 2
*/
#include "options/options.h"
#include "point/material.h"
#include "point/stress_inversion.h"
#include "point/parameter.h"
#include "unit.h"

#include <stdio.h>

/* Laws of tests/material, from the list of kernel instances */
void MpmMaterialCreate_table_law_2d_sensitivity(MpmLawInfo *info);
void MpmMaterialCreate_data_law_2d_sensitivity(MpmLawInfo *info);

enum { DENSITY, G, TABLE }; /* of both laws */

static const MpmOptions   block = {MPI_COMM_WORLD, "mpm_material_a_", NULL};
static const MpmParameter table = {MPM_TABLE, "curve", "-:Pa", 0., 1, 0., 100., 0, "stress over strain",
                                   NULL,      0.,      NULL};
static const MpmParameter data  = {MPM_DATA, "numbers", "Pa", 0., 0, 0., HUGE_VAL, 1, "moduli", NULL, 0., NULL};

/* Runs with one and with two ranks may go on side by side. */
static const char *FileName(void)
{
  PetscMPIInt size;

  UNIT_CALL(MPI_Comm_size(PETSC_COMM_WORLD, &size));
  return size == 1 ? "test_parameter_1.csv" : "test_parameter_2.csv";
}

/* A file that rank 0 alone has */
static void WriteFile(const char text[])
{
  PetscMPIInt rank;
  FILE       *file;

  UNIT_CALL(MPI_Barrier(PETSC_COMM_WORLD));
  UNIT_CALL(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  if (rank) return;
  remove(FileName());
  if (!text) return;
  file = fopen(FileName(), "w");
  ck_assert_ptr_nonnull(file);
  fputs(text, file);
  fclose(file);
}

static void ExpectNumbers(const MpmParameter *parameter, const char option[], const char text[], long count, int size,
                          const double expected[])
{
  MpmLawTable got;
  double      value;

  UNIT_CALL(PetscOptionsSetValue(NULL, option, text));
  UNIT_CALL(MpmParameterRead(&block, parameter, &value, &got));
  ck_assert_int_eq(got.count, count);
  for (int k = 0; k < size; k++) ck_assert_double_eq(got.value[k], expected[k]);
  ck_assert_double_eq(value, 0.);
  UNIT_CALL(PetscFree(got.value));
}

START_TEST(accepts)
{
  const double rows[] = {-1., 2., 0.5, 3e1}, numbers[] = {1., 2.5, 3e4, 4., 5.};
  MpmLawTable  got;
  double       value;

  UNIT_CALL(PetscOptionsClear(NULL));
  ExpectNumbers(&table, "-mpm_material_a_curve", "-1:2, 0.5:3e1", 2, 4, rows);
  ExpectNumbers(&table, "-mpm_material_a_curve", "-1:2", 1, 2, rows);
  WriteFile("# strain, stress\n-1,2\n\n0.5 , 3e1 # the last\n");
  ExpectNumbers(&table, "-mpm_material_a_curve", FileName(), 2, 4, rows);
  WriteFile("1 2.5\t3e4\r\n4,5");
  ExpectNumbers(&data, "-mpm_material_a_numbers", FileName(), 5, 5, numbers);
  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(MpmParameterRead(&block, &data, &value, &got));
  ck_assert_int_eq(got.count, 0);
  ck_assert_ptr_null(got.value);
  WriteFile(NULL);
}
END_TEST

static void Refuses(const MpmParameter *parameter, const char text[], const char message[])
{
  char        option[64], expected[256];
  MpmLawTable got;
  double      value;

  snprintf(option, sizeof(option), "-mpm_material_a_%s", parameter->name);
  snprintf(expected, sizeof(expected), "%s %s: %s", option, text, message);
  UNIT_CALL(PetscOptionsSetValue(NULL, option, text));
  UNIT_FAILS(MpmParameterRead(&block, parameter, &value, &got), MPM_ERR_INPUT, expected);
}

START_TEST(refuses)
{
  const char *const pairs = "must be x:y pairs of numbers, separated by commas, or a file of them";
  MpmLawTable       got;
  double            value;

  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_FAILS(MpmParameterRead(&block, &table, &value, &got), MPM_ERR_INPUT,
             "-mpm_material_a_curve is missing: stress over strain (-:Pa), x:y pairs or the name of a file, text");
  Refuses(&table, "1:2,3", pairs);
  Refuses(&table, "1:2,3:x", pairs);
  Refuses(&table, "1:2:3", pairs);
  Refuses(&table, "1:2,1:3", "row 2: x must grow from row to row, 1 follows 1");
  Refuses(&table, "1:2,3:101", "row 2: 101 must lie in [0, 100]");
  Refuses(&table, "nowhere.csv", "cannot be read: No such file or directory");
  Refuses(&table, "/", "cannot be read: Is a directory");
  WriteFile("strain,stress\n1,2\n");
  Refuses(&table, FileName(), "line 1: 'strain' is not a number");
  WriteFile("1,2\n3\n");
  Refuses(&table, FileName(), "line 2: a row has two numbers, x and y; this one has 1");
  WriteFile("# nothing\n");
  Refuses(&table, FileName(), "holds no numbers");
  WriteFile("1 2\n3 0");
  Refuses(&data, FileName(), "number 4: 0 must be > 0");
  WriteFile("1 2\n3 nan");
  Refuses(&data, FileName(), "line 2: 'nan' is not a number");
  WriteFile(NULL);
}
END_TEST

/* Kirchhoff stress and its derivative of a law at rest that is stretched by dF */
static void Ask(const MpmLawInfo *info, const MpmLawTable tables[], const MpmLawTable direction[], double stretch,
                double tau[4], double dtau[4])
{
  const double         parameter[4] = {0., 1e3, 0., 0.}, identity[4] = {1., 0., 0., 1.};
  const double         state[5] = {1., 1., 1., 0., 0.}, dF[4] = {stretch, 0., 0., stretch};
  const MpmLawInput    input = {parameter, tables, state, identity, dF, 1., 0, 0};
  const MpmLawInput    along = {NULL, direction, NULL, NULL, NULL, 0., 0, 0};
  const MpmLawOutput   value = {tau, NULL}, derivative = {dtau, NULL};
  const MpmSensitivity sensitivity = (MpmSensitivity)info->law;

  ck_assert_int_eq(sensitivity(&input, &along, &value, &derivative), 0);
}

/* Pressures at and between the rows of a table that was read, and by its numbers */
START_TEST(law_with_a_table)
{
  static const struct {
    double theta, pressure, by[6]; /* by the numbers of the table */
  } cases[]            = {{-0.5, 0., {0., 1., 0., 0., 0., 0.}},
                          {0.01, 5., {-250., 0.5, -250., 0.5, 0., 0.}},
                          {0.03, 15., {0., 0., -375., 0.75, -125., 0.25}},
                          {0.2, 30., {0., 0., 0., 0., 0., 1.}}};
  const double yield[] = {0., 1e6};
  MpmParameter pressure;
  MpmLawInfo   info;
  MpmLawTable  tables[4] = {{0, NULL}, {0, NULL}, {0, NULL}, {1, yield}};
  double       tau[4], dtau[4], value, unit[6];

  MpmMaterialCreate_table_law_2d_sensitivity(&info);
  pressure = info.parameters[TABLE];
  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsSetValue(NULL, "-mpm_material_a_pressure", "0:0,0.02:10,0.06:30"));
  UNIT_CALL(MpmParameterRead(&block, &pressure, &value, &tables[TABLE]));
  for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
    for (int k = 0; k < 6; k++) {
      const MpmLawTable direction[4] = {{0, NULL}, {0, NULL}, {3, unit}, {0, NULL}};

      for (int l = 0; l < 6; l++) unit[l] = k == l;
      Ask(&info, tables, direction, exp(0.5 * cases[i].theta), tau, dtau);
      ck_assert_double_eq_tol((tau[0] + tau[1] + tau[2]) / 3., cases[i].pressure, 1e-12);
      ck_assert_double_eq_tol((dtau[0] + dtau[1] + dtau[2]) / 3., cases[i].by[k], 1e-10);
    }
  }
  UNIT_CALL(PetscFree(tables[TABLE].value));
}
END_TEST

START_TEST(law_with_data)
{
  const double theta = 0.1, unit[] = {0., 0., 1.};
  MpmLawInfo   info;
  MpmLawTable  tables[3] = {{0, NULL}, {0, NULL}, {0, NULL}}, direction[3] = {{0, NULL}, {0, NULL}, {3, unit}};
  double       tau[4], dtau[4], value;

  MpmMaterialCreate_data_law_2d_sensitivity(&info);
  UNIT_CALL(PetscOptionsClear(NULL));
  WriteFile("100\n20\n3\n");
  UNIT_CALL(PetscOptionsSetValue(NULL, "-mpm_material_a_coefficients", FileName()));
  UNIT_CALL(MpmParameterRead(&block, &info.parameters[TABLE], &value, &tables[TABLE]));
  Ask(&info, tables, direction, exp(0.5 * theta), tau, dtau);
  ck_assert_double_eq_tol((tau[0] + tau[1] + tau[2]) / 3., 100. * theta + 20. * theta * theta + 3e-3, 1e-12);
  ck_assert_double_eq_tol((dtau[0] + dtau[1] + dtau[2]) / 3., 1e-3, 1e-14);
  UNIT_CALL(PetscFree(tables[TABLE].value));
  WriteFile(NULL);
}
END_TEST

/* A material of a scene has its law in all forms, and its stiffness at a state. */
START_TEST(material)
{
  const double      identity[4] = {1., 0., 0., 1.}, stretched[4] = {2., 0., 0., 1.}, modulus[16] = {0., 1.};
  const MpmLawInput input = {NULL, NULL, NULL, identity, stretched, 1., 0, 0},
                    along = {modulus, NULL, NULL, NULL, NULL, 0., 0, 0};
  double             tau[4], dtau[4];
  const MpmLawOutput value = {tau, NULL}, derivative = {dtau, NULL};
  MpmMaterial        rubber;

  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsInsertString(NULL, "-mpm_material_a_type neo_hookean -mpm_material_a_E 10 "
                                           "-mpm_material_a_nu 0.25"));
  UNIT_CALL(MpmMaterialCreate(&block, "a", 2, NULL, &rubber));
  ck_assert_double_eq(rubber.moduli.stiffness, 12.);
  ck_assert_double_eq(MpmMaterialStiffness(&rubber, NULL, NULL, NULL), 12.);
  ck_assert_double_eq(MpmMaterialStiffness(&rubber, NULL, NULL, stretched), 4. + 2. * 4. * 4.);
  ck_assert_int_eq(MpmMaterialSensitivity(&rubber, &input, &along, &value, &derivative), 0);
  ck_assert_double_eq_tol(tau[0], 4. * 3. + 4. * log(2.), 1e-14);
  ck_assert_double_eq_tol(dtau[0], tau[0] / 10., 1e-15);
  UNIT_CALL(MpmMaterialDestroy(&rubber));
}
END_TEST

/* A law whose symmetry is a matter of its parameters, and of whose parameters some have others' values as default */
START_TEST(material_symmetric_by_parameters)
{
  static const struct {
    const char *options;
    PetscBool   symmetric;
  } cases[] = {{"", PETSC_FALSE},
               {"-mpm_material_a_dilation 30", PETSC_TRUE},
               {"-mpm_material_a_dilation 30 -mpm_material_a_softening_strain 0.1", PETSC_TRUE},
               {"-mpm_material_a_dilation 30 -mpm_material_a_softening_strain 0.1 -mpm_material_a_cohesion_residual 3",
                PETSC_FALSE}};

  for (size_t k = 0; k < sizeof(cases) / sizeof(cases[0]); k++) {
    MpmMaterial sand;
    PetscInt    friction = 0, residual = 0;

    UNIT_CALL(PetscOptionsClear(NULL));
    UNIT_CALL(PetscOptionsInsertString(NULL, "-mpm_material_a_type mohr_coulomb -mpm_material_a_E 10 "
                                             "-mpm_material_a_nu 0.25 -mpm_material_a_cohesion 5 "
                                             "-mpm_material_a_friction 30"));
    UNIT_CALL(PetscOptionsInsertString(NULL, cases[k].options));
    UNIT_CALL(MpmMaterialCreate(&block, "a", 2, NULL, &sand));
    ck_assert_int_eq((sand.info.traits & MPM_LAW_SYMMETRIC) != 0, cases[k].symmetric);
    ck_assert(sand.info.traits & MPM_LAW_PLASTIC);
    while (strcmp(sand.info.parameters[friction].name, "friction")) friction++;
    while (strcmp(sand.info.parameters[residual].name, "friction_residual")) residual++;
    ck_assert_double_eq(sand.parameter[friction], 30.);
    ck_assert_double_eq(sand.parameter[residual], 30.);
    UNIT_CALL(MpmMaterialDestroy(&sand));
  }
}
END_TEST

/* A law that gives its history from a stress meets all six components, and says where its return has moved one. */
START_TEST(initial_stress_by_history)
{
  const PetscReal wanted[2][4] = {{-3., -6., -4., 1.}, {-3., -60., -4., 0.}};
  MpmMaterial     sand;
  MpmInitial      initial;

  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsInsertString(NULL, "-mpm_material_a_type mohr_coulomb -mpm_material_a_E 1000 "
                                           "-mpm_material_a_nu 0.25 -mpm_material_a_cohesion 1 "
                                           "-mpm_material_a_friction 30"));
  UNIT_CALL(MpmMaterialCreate(&block, "a", 2, NULL, &sand));
  UNIT_CALL(MpmInitialCreate(&sand, 2, &initial));
  ck_assert(initial.stateful && initial.history);
  for (int k = 0; k < 2; k++) {
    const PetscReal identity[4] = {1., 0., 0., 1.};
    PetscReal       stress[4], F[4], state_n[5], state[5];

    for (int c = 0; c < 4; c++) stress[c] = wanted[k][c];
    MpmMaterialStateAtRest(&sand, 2, state_n);
    ck_assert_int_eq(MpmInitialFind(&initial, state_n, stress, F, state, NULL), k);
    for (int c = 0; c < 4; c++) {
      ck_assert_double_eq(F[c], identity[c]);
      if (!k) ck_assert_double_eq_tol(stress[c], wanted[k][c], 1e-12);
    }
    if (k) ck_assert_double_eq_tol(stress[0] - stress[1] + 0.5 * (stress[0] + stress[1]), sqrt(3.), 1e-11);
  }
  UNIT_CALL(MpmMaterialDestroy(&sand));
}
END_TEST

/* Wave speeds at rest, stretched, and under stress, whose compression counts alone; a fluid's viscosity */
START_TEST(wave_speed)
{
  const PetscReal stretched[4] = {2., 0., 0., 1.}, plane[4] = {-2., 5., -1., 3.},
                  solid[6] = {-1., 2., -1., 1., 3., -4.};
  MpmMaterial rubber, water;

  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsInsertString(NULL, "-mpm_material_a_type neo_hookean -mpm_material_a_E 10 "
                                           "-mpm_material_a_nu 0.25 -mpm_material_a_density 3"));
  UNIT_CALL(MpmMaterialCreate(&block, "a", 2, NULL, &rubber));
  ck_assert_double_eq_tol(MpmMaterialWaveSpeed(&rubber, NULL, 2, NULL, NULL, NULL), sqrt(12. / 3.), 1e-14);
  ck_assert_double_eq_tol(MpmMaterialWaveSpeed(&rubber, NULL, 2, NULL, stretched, NULL), sqrt(36. / 3.), 1e-14);
  ck_assert_double_eq_tol(MpmMaterialWaveSpeed(&rubber, NULL, 2, NULL, NULL, plane), sqrt((12. + 2. + 3.) / 3.), 1e-14);
  ck_assert_double_eq_tol(MpmMaterialWaveSpeed(&rubber, NULL, 2, NULL, stretched, plane), sqrt((36. + 2. * 5.) / 3.),
                          1e-14);
  ck_assert_double_eq_tol(MpmMaterialWaveSpeed(&rubber, NULL, 3, NULL, NULL, solid), sqrt((12. + 1. + 3. + 4.) / 3.),
                          1e-14);
  ck_assert_double_eq(MpmMaterialViscosity(&rubber, NULL), 0.);
  rubber.density = 0.;
  ck_assert(isinf(MpmMaterialWaveSpeed(&rubber, NULL, 2, NULL, NULL, NULL)));
  UNIT_CALL(MpmMaterialDestroy(&rubber));
  UNIT_CALL(PetscOptionsClear(NULL));
  UNIT_CALL(PetscOptionsInsertString(NULL, "-mpm_material_a_type newtonian -mpm_material_a_sound_speed 20 "
                                           "-mpm_material_a_viscosity 6 -mpm_material_a_density 3"));
  UNIT_CALL(MpmMaterialCreate(&block, "a", 2, NULL, &water));
  ck_assert_double_eq_tol(MpmMaterialWaveSpeed(&water, NULL, 2, NULL, NULL, NULL), 20., 1e-13);
  ck_assert_double_eq_tol(MpmMaterialViscosity(&water, NULL), 8., 1e-14);
  UNIT_CALL(MpmMaterialDestroy(&water));
}
END_TEST

int main(int argc, char **argv)
{
  const TTest *const tests[] = {accepts,
                                refuses,
                                law_with_a_table,
                                law_with_data,
                                material,
                                material_symmetric_by_parameters,
                                initial_stress_by_history,
                                wave_speed};

  return UnitRun(&argc, &argv, "parameters of laws", sizeof(tests) / sizeof(tests[0]), tests);
}
