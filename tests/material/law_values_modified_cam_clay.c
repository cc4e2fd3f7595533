/*
  Modified Cam-Clay against numbers: the undrained path in closed form, the equations of the step, critical state, what
  history follows from a stress. Pressures here are positive in compression, kPa.
*/
#include "laws.h"
#include "../checks.h"
#include <math.h>
#include <string.h>

TCase *CamClayCase(void);

#define M_CRITICAL 1.2
#define KAPPA      0.02
#define LAMBDA     0.1
#define G_SHEAR    4e3
#define P_START    100.

static double Parameter(const Point *point, const char *name)
{
  return point->parameter[LawParameter(point->law, name)];
}

static double *Size(Point *point)
{
  return &point->state[LawState(point->law, "preconsolidation")];
}

/* The clay of the constants above; neither ocr, pop nor preconsolidation is given */
static Point Clay(void)
{
  const struct {
    const char *name;
    double      value;
  } values[] = {{"kappa", KAPPA},        {"lambda", LAMBDA},
                {"M", M_CRITICAL},       {"G", G_SHEAR},
                {"pressure_min", 1.},    {"reference_pressure", 250.},
                {"ocr", HUGE_VAL},       {"preconsolidation", HUGE_VAL},
                {"specific_volume", 2.}, {"pop", HUGE_VAL}};
  Point point;

  RandomSeed(0);
  PointCreate(LawFind("modified_cam_clay"), 0, &point);
  for (size_t k = 0; k < sizeof values / sizeof values[0]; ++k) PointSet(&point, values[k].name, values[k].value);
  return point;
}

/* History from principal stresses along x, y, z; the law's status */
static int SetStress(Point *point, double x, double y, double z)
{
  const double stress[SYM] = {x, y, z};
  MpmLawTable  table[MAX_PARAMETERS];

  PointInput(point, NULL, table);
  return point->law->info[PLAIN].history(point->parameter, table, stress, point->state);
}

static void Invariants(const double *tau, double *p, double *q)
{
  double square = 0.;

  *p = -(tau[0] + tau[1] + tau[2]) / 3.;
  for (int i = 0; i < SYM; ++i) {
    const double s = tau[i] + (i < 3 ? *p : 0.);

    square += (i < 3 ? 1.5 : 3.) * s * s;
  }
  *q = sqrt(square);
}

static void Expect(const char *what, double got, double expected, double tolerance)
{
  ck_assert_msg(fabs(got - expected) <= tolerance, "%s: %.12g, expected %.12g within %.1e", what, got, expected,
                tolerance);
}

static void Diagonal(double x, double y, double *dF)
{
  Identity(dF);
  dF[0]       = x;
  dF[DIM + 1] = y;
}

/* Pure shear of constant volume to eps_q, in steps; p and q at the end */
static Point Shear(double eps_q, int steps, double *p, double *q)
{
  const double a     = 0.5 * sqrt(3.) * eps_q / steps;
  Point        point = Clay();
  double       dF[DIM2], tau[SYM];

  ck_assert_int_eq(SetStress(&point, -P_START, -P_START, -P_START), 0);
  Diagonal(exp(-a), exp(a), dF);
  for (int step = 0; step < steps; ++step) {
    double eta;

    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    Invariants(tau, p, q);
    eta = *q / *p;
    Expect("p of the undrained path", *p / P_START,
           pow(M_CRITICAL * M_CRITICAL / (M_CRITICAL * M_CRITICAL + eta * eta), 1. - KAPPA / LAMBDA), 1e-12);
    Expect("f", *q * *q / (M_CRITICAL * M_CRITICAL) + *p * (*p - *Size(&point)), 0., 1e-9 * P_START * P_START);
  }
  return point;
}

/* The path in the p-q plane is exact in steps of any length, the strain that belongs to it is met at first order. */
START_TEST(test_undrained)
{
  const double strain[3] = {0.01, 0.02, 0.05}, expected[3] = {58.51635, 65.95305, 68.70557};
  double       p, q;

  for (int k = 0; k < 3; ++k) {
    double error[3];

    for (int level = 0; level < 3; ++level) {
      Shear(strain[k], 100 << level, &p, &q);
      error[level] = q - expected[k];
    }
    ck_assert_double_le(fabs(error[2]), 3e-3 * expected[k]);
    /* of first order; at 5 per cent the path is near its end, where the error goes */
    if (k < 2)
      for (int level = 0; level < 2; ++level) Expect("ratio of errors", error[level] / error[level + 1], 2., 0.1);
  }
  Shear(0.1, 10, &p, &q);
  Shear(0.1, 1000, &p, &q);
}
END_TEST

/* Much shear leads to q = M p, p_c = 2 p, where flow keeps the volume. */
START_TEST(test_critical_state)
{
  double p, q, tau[SYM], dF[DIM2];
  Point  point = Shear(0.5, 50, &p, &q);

  Expect("q/p", q / p, M_CRITICAL, 1e-12);
  Expect("p_c/p", *Size(&point) / p, 2., 1e-12);
  Expect("p", p / P_START, pow(0.5, 1. - KAPPA / LAMBDA), 1e-12);
  *Size(&point) *= 1. - 1e-15; /* at it, before or behind */
  Diagonal(exp(-0.01), exp(0.01), dF);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  Invariants(tau, &p, &q);
  Expect("q/p", q / p, M_CRITICAL, 1e-12);
}
END_TEST

/* A step from within to the top of the ellipse: neither p nor p_c changes. */
START_TEST(test_isochoric_flow)
{
  Point  point = Clay();
  double dF[DIM2], tau[SYM], p, q;

  PointSet(&point, "ocr", 2.);
  ck_assert_int_eq(SetStress(&point, -P_START, -P_START, -P_START), 0);
  Expect("p_c", *Size(&point), 2. * P_START, 1e-12);
  Diagonal(exp(-0.05), exp(0.05), dF);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  Invariants(tau, &p, &q);
  Expect("p", p, P_START, 1e-10);
  Expect("q", q, M_CRITICAL * P_START, 1e-10);
  Expect("p_c", *Size(&point), 2. * P_START, 1e-10);
}
END_TEST

/* Isotropic compression along both lines in ln v - ln p, in one step each: of slope lambda, and back of slope kappa */
START_TEST(test_isotropic_lines)
{
  Point        point  = Clay();
  const double strain = 0.06;
  double       dF[DIM2], tau[SYM], p, q;

  ck_assert_int_eq(SetStress(&point, -P_START, -P_START, -P_START), 0);
  Identity(dF);
  for (int a = 0; a < DIM; ++a) dF[a * DIM + a] = exp(-strain / 3.);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  Invariants(tau, &p, &q);
  Expect("p", p, P_START * exp(strain / LAMBDA), 1e-10);
  Expect("p_c", *Size(&point), p, 1e-10);
  Expect("v", point.state[LawState(point.law, "specific_volume")], 2. * exp(-strain), 1e-14);
  for (int a = 0; a < DIM; ++a) dF[a * DIM + a] = exp(0.02 / 3.);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  Invariants(tau, &p, &q);
  Expect("p", p, P_START * exp(strain / LAMBDA - 0.02 / KAPPA), 1e-10);
  Expect("p_c", *Size(&point), P_START * exp(strain / LAMBDA), 1e-10);
}
END_TEST

/* Below pressure_min the pressure goes on along its tangent, through zero. */
START_TEST(test_linear_elasticity)
{
  Point  point = Clay();
  double dF[DIM2], tau[SYM], dtau[2][SYM * DIM2], p, q;

  PointSet(&point, "preconsolidation", 500.);
  ck_assert_int_eq(SetStress(&point, -1., -1., -1.), 0); /* pressure_min */
  for (int side = 0; side < 2; ++side) {
    Diagonal(side ? 1. + 1e-13 : 1. - 1e-13, 1., dF);
    ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, dF, tau, dtau[side]), 0);
    Invariants(tau, &p, &q);
    Expect("p_min", p, 1., 1e-10);
  }
  Expect("change of the slope", MaxDifference(SYM * DIM2, dtau[0], dtau[1]), 0., 1e-8);
  Diagonal(exp(0.5 * KAPPA), 1., dF); /* half way to no pressure, and no q beyond the yield surface */
  PointSet(&point, "M", 1e3);
  ck_assert_int_eq(PointEvaluate(&point, PLAIN, dF, tau, NULL), 0);
  Invariants(tau, &p, &q);
  Expect("half", p, 0.5, 1e-12);
}
END_TEST

/* History from a stress on the yield surface: elastic, but for any load outwards. */
START_TEST(test_history)
{
  Point  point = Clay();
  double dF[DIM2], tau[SYM], p, q, before;

  ck_assert_int_eq(SetStress(&point, -80., -200., -90.), 0);
  Identity(dF);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  Invariants(tau, &p, &q);
  Expect("xx", tau[0], -80., 1e-10);
  Expect("yy", tau[1], -200., 1e-10);
  before = p + q * q / (M_CRITICAL * M_CRITICAL * p);
  Expect("p_c", *Size(&point), before, 1e-10);
  Diagonal(1., 1. - 1e-5, dF);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  ck_assert_double_gt(*Size(&point), before * (1. + 1e-6));
  Identity(dF);

  point = Clay();
  PointSet(&point, "ocr", 1.5);
  ck_assert_int_eq(SetStress(&point, -80., -200., -90.), 0);
  Expect("p_c", *Size(&point), 1.5 * before, 1e-10);
  ck_assert_int_eq(SetStress(&point, -10., -10., -10.), 0);
  Expect("p_c of the scene", *Size(&point), 1.5 * before, 1e-10);

  point = Clay();
  PointSet(&point, "pop", 25.);
  ck_assert_int_eq(SetStress(&point, -80., -200., -90.), 0);
  Expect("p_c", *Size(&point), before + 25., 1e-10);

  point = Clay();
  ck_assert_int_ne(SetStress(&point, 0., 0., 0.), 0);
  ck_assert_int_ne(SetStress(&point, 1., 2., 3.), 0);
  PointSet(&point, "preconsolidation", 30.);
  ck_assert_int_eq(SetStress(&point, 0., 0., 0.), 0);
  ck_assert_int_eq(SetStress(&point, -80., -200., -90.), 0);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  Invariants(tau, &p, &q);
  Expect("f", q * q / (M_CRITICAL * M_CRITICAL) + p * (p - *Size(&point)), 0., 1e-8);
  ck_assert_double_gt(*Size(&point), 30.);
}
END_TEST

/* The ratio of ground at rest: Jaky's, by the overconsolidation that ocr, pop or a preconsolidation makes */
START_TEST(test_ratio_at_rest)
{
  const double sine = 3. * M_CRITICAL / (6. + M_CRITICAL), weight = 90.;
  const double p = weight * (3. - 2. * sine) / 3., q = sine * weight;
  const double size = p + q * q / (M_CRITICAL * M_CRITICAL * p);
  const struct {
    const char *name;
    double      value, ocr;
  } cases[] = {{"ocr", 1., 1.},
               {"ocr", 3., 3.},
               {"pop", 0., 1.},
               {"pop", 40., 1. + 40. / size},
               {"preconsolidation", 2. * size, 2.},
               {"preconsolidation", 0.5 * size, 1.}};
  MpmLawTable table[MAX_PARAMETERS];

  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    Point point = Clay();

    PointSet(&point, cases[k].name, cases[k].value);
    PointInput(&point, NULL, table);
    Expect("ratio", point.law->info[PLAIN].k0(point.parameter, table, point.state, weight),
           (1. - sine) * pow(cases[k].ocr, sine), 1e-14);
  }
}
END_TEST

/* q of the trial state, by a law of the same shear modulus that has no such bound */
static double TrialShear(const Point *point, const double *dF)
{
  Point  elastic;
  double tau[SYM], p, q;

  memset(&elastic, 0, sizeof elastic);
  elastic.law = LawFind("j2");
  PointReset(&elastic);
  PointSet(&elastic, "E", 2. * Parameter(point, "G"));
  PointSet(&elastic, "yield_stress", 1e300);
  memcpy(elastic.state, point->state, SYM * sizeof(double));
  ck_assert_int_eq(PointEvaluate(&elastic, PLAIN, dF, tau, NULL), 0);
  Invariants(tau, &p, &q);
  return q;
}

/* v = g (2 p - p_c), q = q_trial/(1 + 6 G g/M^2), f = 0, on both sides of critical state and at both tips */
START_TEST(test_step)
{
  int elastic = 0, wet = 0, dry = 0;

  RandomSeed(30);
  for (int sample = 0; sample < 6000; ++sample) {
    Point  point;
    double dF[DIM2], tau[SYM], p, q, trial, before, size, v, M2, f, D, g;

    PointCreate(LawFind("modified_cam_clay"), sample % 2, &point);
    PointRandomPath(&point, 1 + sample % 4, 0.01);
    RandomMatrix(sample % 3 ? 0.005 : 0.05, dF);
    before = *Size(&point);
    trial  = TrialShear(&point, dF);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    Invariants(tau, &p, &q);
    size = *Size(&point);
    M2   = Parameter(&point, "M") * Parameter(&point, "M");
    v    = (Parameter(&point, "lambda") - Parameter(&point, "kappa")) * log(size / before);
    f    = q * q / M2 + p * (p - size);
    ck_assert_msg(f <= 1e-9 * size * size, "sample %d: f %g", sample, f / (size * size));
    ck_assert_double_ge(p, -1e-12 * PointStiffness(&point));
    if (v == 0.) {
      ++elastic;
      continue;
    }
    ck_assert_double_ge(f, -1e-9 * size * size);
    D = 2. * p - size;
    g = M2 / (6. * Parameter(&point, "G")) * (trial / q - 1.);
    if (D > 0.) ++wet;
    else ++dry;
    ck_assert_msg(fabs(v - g * D) <= 1e-9 * fabs(v) + 1e-12, "sample %d: v %.15g, g D %.15g", sample, v, g * D);
  }
  ck_assert_int_gt(elastic, 40);
  ck_assert_int_gt(wet, 40);
  ck_assert_int_gt(dry, 40);
}
END_TEST

/* Along fixed principal axes d tau_a/d(ln dF_b) is symmetric where a step has a potential: here up to the step's size. */
START_TEST(test_asymmetry)
{
  double asymmetry[2];

  for (int level = 0; level < 2; ++level) {
    const double a     = level ? 1e-4 : 1e-3;
    Point        point = Clay();
    double       dF[DIM2], tau[SYM], dtau[SYM * DIM2];

    ck_assert_int_eq(SetStress(&point, -80., -150., -90.), 0);
    Diagonal(exp(0.5 * a), exp(-a), dF);
    ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, dF, tau, dtau), 0);
    asymmetry[level] = fabs(dtau[DIM + 1] * dF[DIM + 1] - dtau[DIM2] * dF[0]) / PointStiffnessAt(&point);
  }
  ck_assert_double_gt(asymmetry[0], 1e-3);
  Expect("ratio of asymmetries", asymmetry[0] / asymmetry[1], 10., 2.);
}
END_TEST

TCase *CamClayCase(void)
{
  TCase             *tcase   = tcase_create("Modified Cam-Clay");
  const TTest *const tests[] = {test_undrained, test_critical_state, test_isochoric_flow, test_linear_elasticity,
                                test_history,   test_step,           test_asymmetry,      test_ratio_at_rest};

  for (size_t t = 0; t < sizeof tests / sizeof tests[0]; ++t) tcase_add_test(tcase, tests[t]);
  if (DIM == 3) tcase_add_test(tcase, test_isotropic_lines); /* needs a strain across the plane */
  return tcase;
}
