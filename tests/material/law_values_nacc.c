/* NACC against numbers: returns at both tips and to the ellipse, what hardens and softens, strength that lags. */
#include "laws.h"
#include "../checks.h"
#include <math.h>
#include <string.h>

TCase *NaccCase(void);

static void Expect(const char *what, double got, double expected, double tolerance)
{
  ck_assert_msg(fabs(got - expected) <= tolerance, "%s: %.12g, expected %.12g within %.1e", what, got, expected,
                tolerance);
}

static Point Snow(double alpha_0)
{
  Point point;

  RandomSeed(0);
  PointCreate(LawFind("nacc"), 0, &point);
  PointSet(&point, "E", 3e6);
  PointSet(&point, "nu", 0.3);
  PointSet(&point, "M", 2.36);
  PointSet(&point, "beta", 0.5);
  PointSet(&point, "xi", 30.);
  PointSet(&point, "alpha_0", alpha_0);
  return point;
}

static double *Volume(Point *point)
{
  return &point->state[LawState(point->law, "plastic_volume_strain")];
}

/* Elastic stretches along x, y, z, returned */
static void Return(Point *point, const double *stretch, double *tau)
{
  double I[DIM2];

  Identity(I);
  memset(point->state, 0, SYM * sizeof(double));
  for (int a = 0; a < 3; ++a) point->state[a] = stretch[a] * stretch[a];
  ck_assert_int_eq(PointStep(point, I, tau), 0);
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

/* Stretches after the return by an independent program, p_0 = 30025.72 Pa; digits as printed */
START_TEST(test_nacc_values)
{
  const double trial[3][3]    = {{1.02, 1.01, 1.}, {0.96, 0.95, 0.97}, {1.01, 0.995, 0.992}};
  const double expected[3][3] = {{1.0019917704, 1.0019917704, 1.0019917704},
                                 {0.9959559037, 0.9959559037, 0.9959559037},
                                 {1.0096883155, 0.9951153763, 0.9922015386}};
  const double alpha[3]       = {0.02338359, -0.11081761, -0.00040236};

  for (int k = 0; k < 3; ++k) {
    for (int turn = 0; turn < 3; ++turn) {
      Point  point = Snow(-4e-4);
      double stretch[3], tau[SYM];

      for (int a = 0; a < 3; ++a) stretch[(a + turn) % 3] = trial[k][a];
      Return(&point, stretch, tau);
      for (int a = 0; a < 3; ++a) Expect("stretch", sqrt(point.state[(a + turn) % 3]), expected[k][a], 5.0001e-11);
      Expect("alpha", -4e-4 + *Volume(&point), alpha[k], 5.0001e-9);
    }
  }
}
END_TEST

/* Strong snow far from its shape at rest: the shear modulus is the mean of those of the three planes. */
START_TEST(test_nacc_shear_modulus)
{
  Point        point = Snow(-0.3);
  double       I[DIM2], tau[SYM], dtau[SYM * DIM2], sum = 0.;
  const double b[] = {1.1, 1.4, 0.7};

  if (DIM == 2) return;
  Identity(I);
  memcpy(point.state, b, sizeof b);
  ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, I, tau, dtau), 0);
  for (int i = 0; i < DIM; ++i)
    for (int j = i + 1; j < DIM; ++j)
      sum += 0.5 * (dtau[SymAt(i, j) * DIM2 + i * DIM + j] + dtau[SymAt(i, j) * DIM2 + j * DIM + i]);
  Expect("shear modulus", PointShearModulus(&point, 0), sum / 3., 1e-13 * sum);
  ck_assert_double_gt(fabs(sum / 3. - PointShearModulus(&point, 1)), 0.01 * sum);
}
END_TEST

/* p of the tips; strength follows a step later, from the volume lost or gained. */
START_TEST(test_nacc_tips)
{
  const double K = 2.5e6, p_0 = K * (1e-5 + sinh(30. * 4e-4)), wide[3] = {1.02, 1.02, 1.02},
               dense[3] = {0.98, 0.98, 0.98};
  Point  point          = Snow(-4e-4);
  double tau[SYM], p, q, I[DIM2];

  Identity(I);
  Return(&point, dense, tau);
  Invariants(tau, &p, &q);
  Expect("p of the cap", p, p_0, 1e-9 * p_0);
  Expect("q of the cap", q, 0., 1e-9 * p_0);
  Return(&point, dense, tau); /* denser now, and stronger */
  Invariants(tau, &p, &q);
  Expect("p within", p, 0.5 * K * (1. - pow(0.98, 6.)), 1e-9 * K);
  point = Snow(-4e-4);
  Return(&point, wide, tau);
  Invariants(tau, &p, &q);
  Expect("p in tension", p, -0.5 * p_0, 1e-9 * p_0);
  ck_assert_int_eq(PointStep(&point, I, tau), 0);
  Invariants(tau, &p, &q);
  Expect("p in tension a step later", p, -0.5 * 1e-5 * K, 1e-9 * p_0);
}
END_TEST

/* Stress on the ellipse but for what J changes; softening on the side of tension, hardening on that of compression; at
   the centre neither. A point of strength 1e-6 of the usual one does the same, in proportion. */
START_TEST(test_nacc_ellipse)
{
  const double shift[3] = {-1e-3, 0., 1e-3};

  for (int unit = 0; unit < 2; ++unit) {
    for (int k = 0; k < 3; ++k) {
      Point        point = Snow(-4e-4);
      const double E = unit ? 3. : 3e6, K = E / 1.2, p_0 = K * (1e-5 + sinh(30. * 4e-4));
      const double centre = 0.25 * p_0, J = sqrt(1. - 2. * centre / K) * exp(shift[k]), g = 0.02;
      const double stretch[3] = {cbrt(J) * exp(g), cbrt(J), cbrt(J) * exp(-g)};
      double       tau[SYM], p, q, y;

      PointSet(&point, "E", E);
      Return(&point, stretch, tau);
      Invariants(tau, &p, &q);
      y = 2. * q * q + 2.36 * 2.36 * (p + 0.5 * p_0) * (p - p_0);
      ck_assert_double_le(fabs(y), 0.3 * p_0 * p_0);
      if (k == 1) Expect("v", *Volume(&point), 0., 1e-12);
      else ck_assert_double_gt(*Volume(&point) * shift[k], 0.);
    }
  }
}
END_TEST

/* Random steps that reach the ellipse: the deviator is that of y = 0 at the trial p and J. */
START_TEST(test_nacc_yield)
{
  const Point virgin = Snow(0.);
  int         flows = 0, within = 0;

  RandomSeed(31);
  for (int sample = 0; sample < 2000; ++sample) {
    Point  point = virgin;
    double stretch[3], tau[SYM], mean = 0., J = 1., square = 0., p_0, p, y;

    for (int a = 0; a < 3; ++a) {
      stretch[a] = exp(RandomUniform(-0.02, 0.02));
      J *= stretch[a];
    }
    PointSet(&point, "alpha_0", -RandomUniform(1e-4, 2e-3));
    p_0 = 2.5e6 * (1e-5 + sinh(-30. * point.parameter[LawParameter(point.law, "alpha_0")]));
    p   = 1.25e6 * (1. - J * J);
    if (p > p_0 || p < -0.5 * p_0) continue;
    Return(&point, stretch, tau);
    for (int a = 0; a < 3; ++a) mean += point.state[a] / 3.;
    for (int a = 0; a < 3; ++a) square += (point.state[a] - mean) * (point.state[a] - mean);
    square *= pow(3e6 / 2.6, 2.) * pow(J, -4. / 3.);
    y = 1.5 * 2. * square + 2.36 * 2.36 * (p + 0.5 * p_0) * (p - p_0);
    ck_assert_msg(y <= 1e-9 * p_0 * p_0, "sample %d: y %g", sample, y / (p_0 * p_0));
    if (y > -1e-9 * p_0 * p_0) ++flows;
    else ++within;
  }
  ck_assert_int_gt(flows, 100);
  ck_assert_int_gt(within, 100);
}
END_TEST

TCase *NaccCase(void)
{
  TCase             *tcase   = tcase_create("NACC");
  const TTest *const tests[] = {test_nacc_values, test_nacc_shear_modulus, test_nacc_tips, test_nacc_ellipse,
                                test_nacc_yield};

  for (size_t t = 0; t < sizeof tests / sizeof tests[0]; ++t) tcase_add_test(tcase, tests[t]);
  return tcase;
}
