/* jaumann_elastic against closed forms: rotation, stretch, simple shear, closed cycles, the return to Mohr-Coulomb's planes. */
#include "laws.h"
#include "../checks.h"
#include <math.h>
#include <string.h>

TCase *JaumannCase(void);

#define LAMBDA 15e6
#define MU     10e6 /* E = 26e6, nu = 0.3 */

static void Expect(const char *what, double got, double expected, double tolerance)
{
  ck_assert_msg(fabs(got - expected) <= tolerance, "%s: %.12g, expected %.12g within %.1e", what, got, expected,
                tolerance);
}

static Point Elastic(void)
{
  Point point;

  RandomSeed(0);
  PointCreate(LawFind("jaumann_elastic"), 0, &point);
  PointSet(&point, "E", 26e6);
  PointSet(&point, "nu", 0.3);
  PointSet(&point, "cohesion", HUGE_VAL);
  PointSet(&point, "friction", 0.);
  PointSet(&point, "dilation", 0.);
  PointSet(&point, "tension", HUGE_VAL);
  return point;
}

static double *Stress(Point *point)
{
  return &point->state[LawState(point->law, "cauchy_stress")];
}

/* The step that takes the point to F: shear in the plane of x and y over a stretch along y */
static void StepTo(Point *point, double gamma, double stretch, double *tau)
{
  double dF[DIM2], F[DIM2], A[DIM2], column[DIM];

  Identity(F);
  F[1]       = gamma;
  F[DIM + 1] = stretch;
  for (int i = 0; i < DIM; ++i) { /* dF F_n = F: row i of dF */
    for (int j = 0; j < DIM; ++j) {
      column[j] = F[i * DIM + j];
      for (int k = 0; k < DIM; ++k) A[j * DIM + k] = point->F[k * DIM + j];
    }
    Solve(DIM, A, column);
    memcpy(&dF[i * DIM], column, sizeof column);
  }
  ck_assert_int_eq(PointStep(point, dF, tau), 0);
}

/* A stress turns with the body, in steps of any size. */
START_TEST(test_rotation)
{
  RandomSeed(30);
  for (int sample = 0; sample < 20; ++sample) {
    Point  point = Elastic();
    double R[DIM2], tau[SYM], start[SYM], expected[SYM];

    for (int i = 0; i < SYM; ++i) Stress(&point)[i] = start[i] = 1e6 * RandomUniform(-1., 1.);
    for (int step = 0; step < 3; ++step) {
      RandomRotation(R);
      SymRotate(R, start, expected);
      ck_assert_int_eq(PointStep(&point, R, tau), 0);
      ck_assert_double_le(MaxDifference(SYM, tau, expected), 1e-8);
      memcpy(start, expected, sizeof start);
    }
  }
}
END_TEST

/* Without turning axes one step is exact: sigma = C ln V over what was there, and tau = J sigma. */
START_TEST(test_stretch)
{
  for (int steps = 1; steps < 4; ++steps) {
    const double start = -2e6, x = log(1.4), y = log(0.8), J = 1.4 * 0.8;
    Point        point = Elastic();
    double       dF[DIM2], tau[SYM];

    Stress(&point)[0] = start;
    for (int k = 0; k < steps; ++k) {
      Identity(dF);
      dF[0]       = exp(x / steps);
      dF[DIM + 1] = exp(y / steps);
      ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    }
    Expect("tau_xx", tau[0], J * (start + LAMBDA * (x + y) + 2. * MU * x), 1e-7);
    Expect("tau_yy", tau[1], J * (LAMBDA * (x + y) + 2. * MU * y), 1e-7);
    Expect("tau_zz", tau[2], J * LAMBDA * (x + y), 1e-7);
    Expect("tau_xy", tau[3], 0., 1e-7);
  }
}
END_TEST

/* tau_xy = mu sin(gamma), tau_xx = -tau_yy = mu (1 - cos(gamma)), of second order in the step */
START_TEST(test_simple_shear)
{
  const double gamma = 2.5;
  double       error[3];

  for (int k = 0; k < 3; ++k) {
    const int steps = 25 << k;
    Point     point = Elastic();
    double    tau[SYM], expected[SYM] = {0.};

    for (int n = 1; n <= steps; ++n) StepTo(&point, gamma * n / steps, 1., tau);
    expected[0] = MU * (1. - cos(gamma));
    expected[1] = -expected[0];
    expected[3] = MU * sin(gamma);
    error[k]    = MaxDifference(SYM, tau, expected) / MU;
  }
  ck_assert_double_le(error[2], 1e-3);
  for (int k = 0; k < 2; ++k) Expect("order", log2(error[k] / error[k + 1]), 2., 0.05);
}
END_TEST

/* Along a leg of a path of shear and stretch less 1, with the work over the initial volume by the mean stress of each step */
static double Leg(Point *point, int steps, const double from[2], const double to[2])
{
  double work = 0.;

  for (int n = 1; n <= steps; ++n) {
    const double gamma = point->F[1], stretch = point->F[DIM + 1];
    double       before[SYM], tau[SYM];

    for (int i = 0; i < SYM; ++i) before[i] = stretch * Stress(point)[i];
    StepTo(point, from[0] + (to[0] - from[0]) * n / steps, 1. + from[1] + (to[1] - from[1]) * n / steps, tau);
    /* grad v has d gamma/stretch at xy and d stretch/stretch at yy */
    work += 0.5 * (before[1] + tau[1]) * log(point->F[DIM + 1] / stretch);
    work += (before[3] + tau[3]) * (point->F[1] - gamma) / (point->F[DIM + 1] + stretch);
  }
  return work;
}

/* The cycle of the docstring, with its numbers */
START_TEST(test_closed_cycle)
{
  const double size[] = {0.01, 0.1}, left[] = {0.98, 0.85}, taken[] = {0.98, 0.93};

  for (int k = 0; k < 2; ++k) {
    const double g = size[k], unit = 0.5 * MU * g * g * g, path[5][2] = {{0., 0.}, {0., g}, {g, g}, {g, 0.}, {0., 0.}};
    Point        point = Elastic();
    double       work  = 0.;

    for (int leg = 0; leg < 4; ++leg) work += Leg(&point, 400, path[leg], path[leg + 1]);
    ck_assert_msg(work >= taken[k] * unit && work <= unit, "work %g of mu g^3/2", work / unit);
    for (int i = 0; i < SYM; ++i) {
      const double share = Stress(&point)[i] / unit, sign = i == 1 ? 1. : i == 0 || i == 3 ? -1. : 0.;

      ck_assert_msg(sign != 0. ? sign * share >= left[k] && sign * share <= 1. : fabs(share) < 1e-4,
                    "stress %d is %g of mu g^3/2", i, share);
    }
  }
}
END_TEST

/* There and back on the same way, in the same steps: nothing is left. */
START_TEST(test_there_and_back)
{
  Point  point = Elastic();
  double tau[SYM];

  for (int n = 1; n <= 40; ++n) {
    const double way = n <= 20 ? 0.05 * n : 0.05 * (40 - n);

    StepTo(&point, way, 1. + 0.3 * way * way, tau);
  }
  ck_assert_double_le(MaxNorm(SYM, tau), 1e-12 * MU);
}
END_TEST

/* One step from rest has the stress of mohr_coulomb, as the Cauchy stress. */
START_TEST(test_return)
{
  int flows = 0;

  RandomSeed(31);
  for (int sample = 0; sample < 400; ++sample) {
    const char *const names[] = {"E", "nu", "cohesion", "friction", "dilation", "tension"};
    Point             one, other;
    double            dF[DIM2], tau[SYM], expected[SYM], J;

    PointCreate(LawFind("mohr_coulomb"), 0, &other);
    for (int k = 0; k < 3; ++k) {
      const char *const left[] = {"cohesion_residual", "friction_residual", "dilation_residual"};

      PointSet(&other, left[k], other.parameter[LawParameter(other.law, names[2 + k])]);
    }
    PointSet(&other, "softening_strain", HUGE_VAL);
    one = Elastic();
    for (int k = 0; k < 6; ++k) PointSet(&one, names[k], other.parameter[LawParameter(other.law, names[k])]);
    RandomMatrix(0.01, dF);
    J = Determinant(dF);
    ck_assert_int_eq(PointStep(&one, dF, tau), 0);
    ck_assert_int_eq(PointStep(&other, dF, expected), 0);
    for (int i = 0; i < SYM; ++i) expected[i] *= J;
    ck_assert_double_le(MaxDifference(SYM, tau, expected), 1e-13 * PointStiffness(&one));
    Expect("equivalent plastic strain", one.state[LawState(one.law, "equivalent_plastic_strain")],
           other.state[LawState(other.law, "equivalent_plastic_strain")], 1e-14);
    flows += one.state[LawState(one.law, "equivalent_plastic_strain")] > 0.;
  }
  ck_assert_int_gt(flows, 200);
}
END_TEST

/* Biaxial compression at constant volume in 50 steps, J = 1.1 from the start: the Cauchy stress keeps to the strength, and the volume
   of plastic flow is sin(psi) of its shear. */
START_TEST(test_flow)
{
  const double degree = 3.14159265358979323846 / 180., sine = sin(30. * degree), dilation = sin(10. * degree);
  Point        point = Elastic();
  double       dF[DIM2], tau[SYM], sigma[SYM], pressure, volume, share;

  PointSet(&point, "cohesion", 5e3);
  PointSet(&point, "friction", 30.);
  PointSet(&point, "dilation", 10.);
  point.F[0] = 1.1;
  for (int i = 0; i < 3; ++i) Stress(&point)[i] = -100e3;
  for (int n = 0; n < 50; ++n) {
    Identity(dF);
    dF[0]       = exp(1e-3);
    dF[DIM + 1] = exp(-1e-3);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  }
  for (int i = 0; i < SYM; ++i) sigma[i] = tau[i] / 1.1;
  Expect("f", sigma[0] - sigma[1] + (sigma[0] + sigma[1]) * sine - 2. * 5e3 * cos(30. * degree), 0., 1e-6);
  /* plastic volume strain is minus the elastic one; flow along 1 + sin(psi) and -(1 - sin(psi)) */
  pressure = (sigma[0] + sigma[1] + sigma[2]) / 3. + 100e3;
  volume   = -pressure / (LAMBDA + 2. / 3. * MU);
  share    = 2. * dilation / sqrt(2. / 3. * (2. + 2. * dilation * dilation));
  Expect("volume", volume, share * point.state[LawState(point.law, "equivalent_plastic_strain")], 1e-13);
  ck_assert_double_gt(volume, 1e-3);
}
END_TEST

/* A step that changes the volume by exp(volume) in the plane of x and y; the mean of the stress afterwards, J = 1 at the path's start */
static double Mean(Point *point, double volume)
{
  double dF[DIM2], tau[SYM];

  Identity(dF);
  dF[0] = dF[DIM + 1] = exp(0.5 * volume);
  ck_assert_int_eq(PointStep(point, dF, tau), 0);
  return (tau[0] + tau[1] + tau[2]) / (3. * Determinant(point->F));
}

/* What has opened closes before it bears, all of it or a part; without `closing` the point bears at once. */
START_TEST(test_closing)
{
  const double bulk = LAMBDA + 2. / 3. * MU, part[] = {0., 0.5, 1.};

  for (int k = 0; k < 3; ++k) {
    Point   point   = Elastic();
    double  opening = part[k] > 0. ? 4e-3 : 0., dF[DIM2], V[DIM2];
    double *open    = &point.state[LawState(point.law, "opening")];

    PointSet(&point, "cohesion", 0.);
    PointSet(&point, "friction", 20.);
    PointSet(&point, "closing", part[k]);
    Expect("drawn", Mean(&point, 4e-3), 0., 1e-8);
    Expect("opening", *open, opening, 1e-15);
    Expect("pressed", Mean(&point, -1e-3), -bulk * (1. - part[k]) * 1e-3, 1e-8);
    opening -= part[k] * 1e-3;
    Expect("opening", *open, opening, 1e-15);
    /* the tangent, where only a part closes and where all of it does */
    for (int far = 0; far < 2; ++far) {
      RandomMatrix(2e-4, dF);
      dF[0] -= far ? 0.02 : 0.003;
      RandomMatrix(1., V);
      ck_assert_double_le(TaylorRemainder(&point, dF, V, 1e-6), 1e-9 * PointStiffness(&point));
    }
    Expect("closed", Mean(&point, -9e-3), -bulk * ((1. - part[k]) * 1e-3 + 9e-3 - opening), 1e-7);
    Expect("opening", *open, 0., 1e-15);
    Expect("there", Mean(&point, 6e-3 + (part[k] > 0. ? 0. : 4e-3)), 0., 1e-7);
  }
}
END_TEST

TCase *JaumannCase(void)
{
  TCase             *tcase   = tcase_create("Jaumann's rate");
  const TTest *const tests[] = {test_rotation,       test_stretch, test_simple_shear, test_closed_cycle,
                                test_there_and_back, test_return,  test_flow,         test_closing};

  for (size_t t = 0; t < sizeof tests / sizeof tests[0]; ++t) tcase_add_test(tcase, tests[t]);
  return tcase;
}
