/* newtonian against closed forms: pressure by volume, viscous stress by rate, tension, an initial pressure. */
#include "laws.h"
#include "../checks.h"
#include <math.h>

TCase *NewtonianCase(void);

#define BULK 2e6

static void Expect(const char *what, double got, double expected, double tolerance)
{
  ck_assert_msg(fabs(got - expected) <= tolerance, "%s: %.12g, expected %.12g within %.1e", what, got, expected,
                tolerance);
}

static Point Fluid(int linear)
{
  Point point;

  RandomSeed(0);
  PointCreate(LawFind("newtonian"), 0, &point);
  PointSet(&point, "density", 1000.);
  PointSet(&point, "bulk_modulus", BULK);
  PointSet(&point, "sound_speed", HUGE_VAL);
  PointSet(&point, "equation", linear);
  PointSet(&point, "gamma", 7.);
  PointSet(&point, "viscosity", 0.);
  PointSet(&point, "pressure_min", 0.);
  return point;
}

/* One step by the volume ratio dj */
static double Squeeze(Point *point, double dj)
{
  double dF[DIM2], tau[SYM];

  Identity(dF);
  for (int i = 0; i < DIM; ++i) dF[i * (DIM + 1)] = pow(dj, 1. / DIM);
  ck_assert_int_eq(PointStep(point, dF, tau), 0);
  for (int i = 1; i < 3; ++i) Expect("tau_ii", tau[i], tau[0], 0.);
  return -tau[0];
}

/* p of both equations over j; that of a sound speed */
START_TEST(test_pressure)
{
  for (int linear = 0; linear < 2; ++linear) {
    for (int speed = 0; speed < 2; ++speed) {
      const double gamma = linear ? 1. : 7.;
      Point        point = Fluid(linear);
      double       j     = 1.;

      PointSet(&point, "bulk_modulus", speed ? HUGE_VAL : BULK);
      PointSet(&point, "sound_speed", speed ? sqrt(BULK / 1000.) : HUGE_VAL);
      for (int k = 0; k < 5; ++k) {
        j *= 0.97;
        Expect("J p", Squeeze(&point, 0.97), j * BULK / gamma * (pow(j, -gamma) - 1.), 1e-8);
        Expect("density times c^2", PointStiffnessAt(&point), j * BULK * pow(j, -gamma), 1e-8);
      }
    }
  }
}
END_TEST

/* sigma_xy = mu times the rate of shear, with an error of second order in the step; dev d of a stretch; nothing with dt = 0 */
START_TEST(test_viscosity)
{
  const double mu = 3., rate = 2.;
  double       error[2];

  for (int k = 0; k < 2; ++k) {
    Point       point = Fluid(0);
    double      dF[DIM2], tau[SYM];
    MpmLawTable table[MAX_PARAMETERS];
    MpmLawInput input = PointInput(&point, dF, table);

    PointSet(&point, "viscosity", mu);
    Identity(dF);
    input.dt = 0.01 / (1 << k);
    dF[1]    = rate * input.dt;
    ck_assert_int_eq(point.law->tangent[PLAIN](&point.law->info[PLAIN], &input, NULL, tau, NULL), 0);
    error[k] = fabs(tau[3] / (mu * rate) - 1.);
    ck_assert_double_le(error[k], 1e-4);
    dF[1]       = 0.;
    dF[DIM + 1] = exp(-rate * input.dt); /* compressed: p > 0 on top */
    ck_assert_int_eq(point.law->tangent[PLAIN](&point.law->info[PLAIN], &input, NULL, tau, NULL), 0);
    Expect("tau_xx - tau_yy", tau[0] - tau[1], 2. * mu * rate, 1e-8);
    Expect("tau_xx - tau_zz", tau[0] - tau[2], 0., 1e-8);
    input.dt = 0.;
    ck_assert_int_eq(point.law->tangent[PLAIN](&point.law->info[PLAIN], &input, NULL, tau, NULL), 0);
    Expect("tau_xx - tau_yy without time", tau[0] - tau[1], 0., 0.);
  }
  Expect("order", log2(error[0] / error[1]), 2., 0.01);
}
END_TEST

/* Pulled apart the fluid keeps pressure_min; it bears pressure again once the gap has closed. */
START_TEST(test_tension)
{
  const double least[] = {0., -5e3, -HUGE_VAL};

  for (int k = 0; k < 3; ++k) {
    Point point = Fluid(1);

    PointSet(&point, "pressure_min", least[k]);
    Expect("J p, pulled", Squeeze(&point, 1.25), fmax(1.25 * least[k], BULK * (1. - 1.25)), 1e-8);
    Expect("J p, still open", Squeeze(&point, 0.9), fmax(1.125 * least[k], BULK * (1. - 1.125)), 1e-8);
    Expect("J p, closed", Squeeze(&point, 0.99 / 1.125), BULK * (1. - 0.99), 1e-8);
  }
}
END_TEST

/* An initial pressure is that of the volume ratio; a tension that no volume has is refused. */
START_TEST(test_initial_pressure)
{
  for (int linear = 0; linear < 2; ++linear) {
    Point       point       = Fluid(linear);
    double      stress[SYM] = {-30e3, -40e3, -50e3, 7e3}, gamma = linear ? 1. : 7., j;
    MpmLawTable table[MAX_PARAMETERS];

    PointInput(&point, NULL, table);
    ck_assert_int_eq(point.law->info[PLAIN].history(point.parameter, table, stress, point.state), 0);
    Expect("p", Squeeze(&point, 1.), 40e3, 1e-7);
    Expect("volume ratio", point.state[0], pow(1. + gamma * 40e3 / BULK, -1. / gamma), 1e-14);
    j = 0.99 * point.state[0];
    Expect("J p", Squeeze(&point, 0.99), 0.99 * BULK / gamma * (pow(j, -gamma) - 1.), 1e-7);
    for (int i = 0; i < 3; ++i) stress[i] = 1.01 * BULK / gamma;
    ck_assert_int_ne(point.law->info[PLAIN].history(point.parameter, table, stress, point.state), 0);
  }
}
END_TEST

TCase *NewtonianCase(void)
{
  TCase             *tcase   = tcase_create("Newtonian fluid");
  const TTest *const tests[] = {test_pressure, test_viscosity, test_tension, test_initial_pressure};

  for (size_t t = 0; t < sizeof tests / sizeof tests[0]; ++t) tcase_add_test(tcase, tests[t]);
  return tcase;
}
