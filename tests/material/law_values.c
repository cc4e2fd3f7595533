/* Laws against numbers: closed forms and published values at single points. */
#include "laws.h"
#include "../checks.h"
#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

static void ExpectNear(const char *what, double got, double expected, double tolerance)
{
  ck_assert_msg(fabs(got - expected) <= tolerance, "%s: %.12g, expected %.12g within %.1e", what, got, expected,
                tolerance);
}

static Point ElasticPoint(const char *name, double E, double nu)
{
  Point point;

  RandomSeed(0);
  PointCreate(LawFind(name), 0, &point);
  PointSet(&point, "E", E);
  PointSet(&point, "nu", nu);
  for (size_t p = 0; p < point.law->info[PLAIN].parameter_count; ++p)
    if (point.law->info[PLAIN].parameters[p].kind == MPM_WORD)
      point.parameter[p] = point.law->info[PLAIN].parameters[p].fallback;
  return point;
}

static void InPlane(double xx, double xy, double yx, double yy, double *A)
{
  Identity(A);
  A[0]       = xx;
  A[1]       = xy;
  A[DIM]     = yx;
  A[DIM + 1] = yy;
}

/* Five equal steps of a simple shear to 0.5. A transposed displacement gradient would exchange tau_xx and tau_yy. */
START_TEST(test_hencky_simple_shear)
{
  Point  point = ElasticPoint("hencky", 12000., 0.2);
  double dF[DIM2], tau[SYM];

  InPlane(1., 0.1, 0., 1., dF);
  for (int step = 0; step < 5; ++step) ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  ExpectNear("tau_xx", tau[0], 600.194329, 1e-6);
  ExpectNear("tau_yy", tau[1], -600.194329, 1e-6);
  ExpectNear("tau_zz", tau[2], 0., 1e-10);
  ExpectNear("tau_xy", tau[3], 2400.777317, 1e-6);
}
END_TEST

/* The stress turns with the body: by +45 degrees here; a transposed gradient turns it backwards, which 90 degrees
   would not show. */
START_TEST(test_hencky_stretch_and_rotation)
{
  const double degrees[5] = {10., 10., 10., 10., 5.};
  Point        point      = ElasticPoint("hencky", 12000., 0.2);
  double       dF[DIM2], tau[SYM];

  InPlane(1.1, 0., 0., 1., dF);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  for (int step = 0; step < 5; ++step) {
    const double angle = degrees[step] * PI / 180.;

    InPlane(cos(angle), -sin(angle), sin(angle), cos(angle), dF);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  }
  ExpectNear("tau_xx", tau[0], 794.2515, 5e-5);
  ExpectNear("tau_yy", tau[1], 794.2515, 5e-5);
  ExpectNear("tau_xy", tau[3], 476.5509, 5e-5);
  ExpectNear("tau_zz", tau[2], 12000. / 3.6 * log(1.1), 1e-9);
}
END_TEST

/* Simple shear: tau_xx = mu gamma^2, tau_xy = mu gamma; stretch: mu (a^2 - 1) + lambda ln a */
START_TEST(test_neo_hookean)
{
  const double mu = 5000., lambda = 12000. / 3.6;
  Point        point = ElasticPoint("neo_hookean", 12000., 0.2);
  double       dF[DIM2], tau[SYM];

  InPlane(1., 0.5, 0., 1., dF);
  ck_assert_int_eq(PointEvaluate(&point, PLAIN, dF, tau, NULL), 0);
  ExpectNear("tau_xx", tau[0], mu * 0.25, 1e-9);
  ExpectNear("tau_yy", tau[1], 0., 1e-9);
  ExpectNear("tau_xy", tau[3], mu * 0.5, 1e-9);
  InPlane(1.2, 0., 0., 1., dF);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  ExpectNear("tau_xx", tau[0], mu * 0.44 + lambda * log(1.2), 1e-9);
  ExpectNear("tau_zz", tau[2], lambda * log(1.2), 1e-9);
}
END_TEST

/* Small strain from the total deformation: two steps give what one does. */
START_TEST(test_linear_elastic)
{
  Point  point = ElasticPoint("linear_elastic", 12000., 0.2);
  double dF[DIM2], tau[SYM];

  InPlane(1.1, 0., 0., 1., dF);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  InPlane(1., 0.2, 0., 1.05, dF); /* F = [[1.1, 0.2], [0, 1.05]] */
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  ExpectNear("sigma_xx", tau[0], 12000. / 3.6 * 0.15 + 10000. * 0.1, 1e-9);
  ExpectNear("sigma_yy", tau[1], 12000. / 3.6 * 0.15 + 10000. * 0.05, 1e-9);
  ExpectNear("sigma_zz", tau[2], 12000. / 3.6 * 0.15, 1e-9);
  ExpectNear("sigma_xy", tau[3], 5000. * 0.2, 1e-9);
}
END_TEST

/* p, the deviator, and sqrt(J2) of a stress */
static double SqrtJ2(const double *tau, double *p, double *deviator)
{
  double J2 = 0.;

  *p = (tau[0] + tau[1] + tau[2]) / 3.;
  for (int i = 0; i < SYM; ++i) {
    deviator[i] = tau[i] - (i < 3 ? *p : 0.);
    J2 += (i < 3 ? 0.5 : 1.) * deviator[i] * deviator[i];
  }
  return sqrt(J2);
}

/* Isochoric stretch e^a, e^-a: in perfect plasticity the stress difference is that of plane strain yield, 2
   yield_stress/sqrt 3. */
START_TEST(test_j2_return)
{
  const double mu = 5000., a = 0.02, yield_stress = 30., hardening = 700.;
  Point        point = ElasticPoint("j2", 12000., 0.2);
  double       dF[DIM2], tau[SYM], multiplier;

  InPlane(exp(a), 0., 0., exp(-a), dF);
  PointSet(&point, "yield_stress", yield_stress);
  PointSet(&point, "hardening", 0.);
  ck_assert_int_eq(PointEvaluate(&point, PLAIN, dF, tau, NULL), 0);
  ExpectNear("tau_xx - tau_yy", tau[0] - tau[1], 2. * yield_stress / sqrt(3.), 1e-9);
  PointSet(&point, "hardening", hardening);
  ck_assert_int_eq(PointStep(&point, dF, tau), 0);
  multiplier = (2. * mu * sqrt(2.) * a - sqrt(2. / 3.) * yield_stress) / (2. * mu + 2. * hardening / 3.);
  ExpectNear("tau_xx", tau[0], 2. * mu * (a - multiplier / sqrt(2.)), 1e-9);
  ExpectNear("alpha", point.state[LawState(point.law, "equivalent_plastic_strain")], sqrt(2. / 3.) * multiplier, 1e-14);
  ExpectNear("b_xx", point.state[0], exp(2. * (a - multiplier / sqrt(2.))), 1e-14);
  ExpectNear("det b", point.state[0] * point.state[1] * point.state[2], 1., 1e-14);
}
END_TEST

START_TEST(test_j2_yield_surface)
{
  int on_surface = 0;

  RandomSeed(20);
  for (int sample = 0; sample < 200; ++sample) {
    Point  point;
    double dF[DIM2], tau[SYM], deviator[SYM], p, limit, equivalent;

    PointCreate(LawFind("j2"), sample % 2, &point);
    PointRandomPath(&point, sample % 5, 0.01);
    RandomMatrix(0.005, dF);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    limit = point.parameter[LawParameter(point.law, "yield_stress")] +
            point.parameter[LawParameter(point.law, "hardening")] *
              point.state[LawState(point.law, "equivalent_plastic_strain")];
    equivalent = sqrt(3.) * SqrtJ2(tau, &p, deviator);
    ck_assert_msg(equivalent <= limit + 1e-13 * PointStiffness(&point), "sample %d: %g above %g", sample, equivalent,
                  limit);
    on_surface += equivalent > limit * (1. - 1e-10);
  }
  ck_assert_int_gt(on_surface, 50);
  ck_assert_int_lt(on_surface, 200);
}
END_TEST

/* ---- Drucker-Prager ---- */

enum { COMPRESSION, EXTENSION, PLANE_STRAIN };

static Point DruckerPrager(double E, double nu, double cohesion, double friction, double dilation, int fit)
{
  Point point = ElasticPoint("drucker_prager", E, nu);

  PointSet(&point, "cohesion", cohesion);
  PointSet(&point, "friction", friction);
  PointSet(&point, "dilation", dilation);
  PointSet(&point, "fit", fit);
  PointSet(&point, "volume_correction", 1.);
  return point;
}

/* Stretches x, y by dF on a point whose elastic stretch along z is z */
static void StretchFrom(Point *point, double x, double y, double z, double *tau)
{
  double dF[DIM2];

  point->state[LawState(point->law, "elastic_left_cauchy_green") + 2] = z * z;
  InPlane(x, 0., 0., y, dF);
  ck_assert_int_eq(PointStep(point, dF, tau), 0);
}

/* Principal stretches after the return, computed independently from the equations of Klar et al. (2016), nu = 0.3, 30
   degrees, c = 0 */
START_TEST(test_drucker_prager_principal)
{
  Point  point = DruckerPrager(1e6, 0.3, 0., 30., 0., COMPRESSION);
  double tau[SYM];
  int    v;

  v = LawState(point.law, "volume_correction");
  StretchFrom(&point, 1.02, 1.01, 0.98, tau);
  for (int i = 0; i < 3; ++i) ExpectNear("stretch at the apex", sqrt(point.state[i]), 1., 1e-15);
  ExpectNear("volume correction", point.state[v], 0.0095502508, 1e-10);
  ExpectNear("stress at the apex", MaxNorm(SYM, tau), 0., 0.);
  PointReset(&point);
  StretchFrom(&point, 0.9, 1.05, 0.98, tau);
  ExpectNear("stretch x", sqrt(point.state[0]), 0.9184033256, 1e-10);
  ExpectNear("stretch y", sqrt(point.state[1]), 1.0303675573, 1e-10);
  ExpectNear("stretch z", sqrt(point.state[2]), 0.9786609524, 1e-10);
  ExpectNear("volume correction", point.state[v], 0., 0.);
}
END_TEST

/* The projection of principal stretches by Klar et al. (2016), with the volume correction of Tampubolon et al. (2017) in
   v: cohesionless, without dilation. The correction ends where the point leaves the apex. */
static void ProjectSand(double lambda, double mu, double degrees, double *stretch, double *v)
{
  const double s = sin(degrees * PI / 180.), alpha = sqrt(2. / 3.) * 2. * s / (3. - s);
  double       e[3], trace = 0., norm = 0., excess;

  for (int i = 0; i < 3; ++i) trace += e[i] = log(stretch[i]) + *v / 3.;
  for (int i = 0; i < 3; ++i) norm += (e[i] - trace / 3.) * (e[i] - trace / 3.);
  norm   = sqrt(norm);
  excess = norm + (3. * lambda + 2. * mu) / (2. * mu) * trace * alpha;
  if (trace > 0.) {
    *v = trace;
    for (int i = 0; i < 3; ++i) stretch[i] = 1.;
    return;
  }
  *v = 0.;
  for (int i = 0; i < 3; ++i) stretch[i] = exp(e[i] - fmax(excess, 0.) * (e[i] - trace / 3.) / norm);
}

/* Steps that open and close a point: elastic, on the cone and at the apex in turn */
START_TEST(test_drucker_prager_projection)
{
  const double mu = 1e6 / 2.6, lambda = 0.3e6 / (1.3 * 0.4);
  int          apex = 0, closed = 0;

  RandomSeed(21);
  for (int path = 0; path < 100; ++path) {
    const double degrees    = RandomUniform(5., 60.);
    Point        point      = DruckerPrager(1e6, 0.3, 0., degrees, 0., COMPRESSION);
    const int    at         = LawState(point.law, "volume_correction");
    double       stretch[3] = {1., 1., 1.}, v = 0.;

    RandomSeed(1000 + (unsigned)path);
    for (int step = 0; step < 10; ++step) {
      double dF[DIM2] = {0.}, tau[SYM], before = v;

      for (int a = 0; a < DIM; ++a) stretch[a] *= dF[a * (DIM + 1)] = exp(RandomUniform(-0.03, 0.03));
      ProjectSand(lambda, mu, degrees, stretch, &v);
      ck_assert_int_eq(PointStep(&point, dF, tau), 0);
      for (int a = 0; a < 3; ++a) ExpectNear("stretch", sqrt(point.state[a]), stretch[a], 1e-13);
      ExpectNear("volume correction", point.state[at], v, 1e-13);
      apex += v > 0.;
      closed += v == 0. && before > 0.;
    }
  }
  ck_assert_int_gt(apex, 100);
  ck_assert_int_gt(closed, 30);
}
END_TEST

/* A principal stress of mean p on the Mohr-Coulomb surface, where each fit must meet it */
static void MohrCoulombPoint(int fit, double c, double phi, double p, double *stress)
{
  const double s = sin(phi), k = 2. * c * cos(phi);

  if (fit == PLANE_STRAIN) {
    /* The point at which associated flow of the cone has no zz component: s_zz = -(2/3) eta sqrt(J2) */
    const double eta = sqrt(3.) * s / sqrt(3. + s * s), xi = sqrt(3.) * cos(phi) / sqrt(3. + s * s);
    const double J = xi * c - eta * p, zz = -2. / 3. * eta * J, r = J * sqrt(1. - eta * eta / 3.);

    stress[0] = p - 0.5 * zz + r;
    stress[1] = p - 0.5 * zz - r;
    stress[2] = p + zz;
  } else {
    /* largest - smallest + (largest + smallest) sin phi = 2 c cos phi with two equal ones: p + d, p + d, p - 2 d or p
       - d, p - d, p + 2 d */
    const double d = (k - 2. * p * s) / (fit == COMPRESSION ? 3. - s : 3. + s), sign = fit == COMPRESSION ? 1. : -1.;

    stress[0] = p + sign * d;
    stress[1] = p - sign * 2. * d;
    stress[2] = p + sign * d;
  }
  ck_assert_double_eq_tol(fabs(stress[0] - stress[1]) + (stress[0] + stress[1]) * s, k, 1e-9 * fabs(p));
}

/* The cone passes through Mohr-Coulomb's surface where its fit says: just inside it is elastic, and from outside,
   dilation 0, it returns there. */
START_TEST(test_drucker_prager_fit)
{
  const double c = 3e3, phi = 0.5, p = -2e4;
  Point        point = DruckerPrager(1e7, 0.25, c, phi * 180. / PI, 0., _i);
  double       surface[3], moved[3], tau[SYM], I[DIM2];

  Identity(I);
  MohrCoulombPoint(_i, c, phi, p, surface);
  for (int k = 0; k < 2; ++k) {
    for (int i = 0; i < 3; ++i) moved[i] = p + (k ? 1.2 : 1. - 1e-9) * (surface[i] - p);
    PointSetPrincipal(&point, moved);
    ck_assert_int_eq(PointEvaluate(&point, PLAIN, I, tau, NULL), 0);
    for (int i = 0; i < 3; ++i) ExpectNear(k ? "from outside" : "inside", tau[i], k ? surface[i] : moved[i], 1e-6);
  }
}
END_TEST

/* Dilation: plastic volume gained is eta_bar times the multiplier, so p falls by K eta_bar/(mu) of what sqrt(J2)
   loses. */
START_TEST(test_drucker_prager_dilation)
{
  const double s = sin(PI / 18.), eta_bar = 6. * s / (sqrt(3.) * (3. - s));
  const double K = 1e7 / 1.5, mu = 4e6, stress[3] = {-3e4, -1e4, -2e4};
  Point        point = DruckerPrager(1e7, 0.25, 0., 20., 10., COMPRESSION);
  double       tau[SYM], deviator[SYM], I[DIM2], p, J2, trial[SYM] = {-3e4, -1e4, -2e4}, p_trial, J2_trial;

  Identity(I);
  PointSetPrincipal(&point, stress);
  ck_assert_int_eq(PointEvaluate(&point, PLAIN, I, tau, NULL), 0);
  J2_trial = SqrtJ2(trial, &p_trial, deviator);
  J2       = SqrtJ2(tau, &p, deviator);
  ck_assert_double_gt(J2_trial - J2, 100.);
  ExpectNear("pressure gained", p_trial - p, K * eta_bar / mu * (J2_trial - J2), 1e-7);
}
END_TEST

static double ConeExcess(const Point *point, const double *tau, double *scale)
{
  const double phi = point->parameter[LawParameter(point->law, "friction")] * PI / 180.;
  const double c   = point->parameter[LawParameter(point->law, "cohesion")];
  const double fit = point->parameter[LawParameter(point->law, "fit")];
  const double s = sin(phi), d = sqrt(3.) * (fit == COMPRESSION ? 3. - s : 3. + s);
  const double eta = fit == PLANE_STRAIN ? sqrt(3.) * s / sqrt(3. + s * s) : 6. * s / d;
  const double xi  = fit == PLANE_STRAIN ? sqrt(3.) * cos(phi) / sqrt(3. + s * s) : 6. * cos(phi) / d;
  double       deviator[SYM], p;
  const double J = SqrtJ2(tau, &p, deviator);

  *scale = fabs(J) + fabs(p);
  return J + eta * p - xi * c;
}

START_TEST(test_drucker_prager_yield_surface)
{
  int inside = 0, on_cone = 0, at_apex = 0;

  RandomSeed(21);
  for (int sample = 0; sample < 300; ++sample) {
    Point  point;
    double dF[DIM2], tau[SYM], deviator[SYM], scale, p, excess, tolerance;

    PointCreate(LawFind("drucker_prager"), sample % 2, &point);
    PointRandomPath(&point, sample % 5, 0.01);
    RandomMatrix(0.005, dF);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    excess    = ConeExcess(&point, tau, &scale);
    tolerance = 1e-13 * PointStiffness(&point);
    ck_assert_msg(excess <= tolerance, "sample %d: yield function %g", sample, excess);
    if (excess < -tolerance) ++inside;
    else if (SqrtJ2(tau, &p, deviator) > 10. * tolerance) ++on_cone;
    else ++at_apex;
  }
  ck_assert_int_gt(inside, 20);
  ck_assert_int_gt(on_cone, 20);
  ck_assert_int_gt(at_apex, 20);
}
END_TEST

/*
  Opening by 2 ln 1.02 and closing again: with the correction the pressure comes back when the volume does, with d = 3
  in plane strain too; without it as soon as closing begins.
*/
START_TEST(test_drucker_prager_volume_correction)
{
  const double K = 1e7 / 1.5;
  Point        point;
  double       tau[SYM], deviator[SYM], dF[DIM2], p;

  for (int correction = 0; correction < 2; ++correction) {
    point = DruckerPrager(1e7, 0.25, 0., 30., 0., COMPRESSION);
    PointSet(&point, "volume_correction", correction);
    InPlane(1.02, 0., 0., 1.02, dF);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    ExpectNear("correction", point.state[SYM], correction ? 2. * log(1.02) : 0., 1e-14);
    InPlane(1.01 / 1.02, 0., 0., 1.01 / 1.02, dF);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    SqrtJ2(tau, &p, deviator);
    ExpectNear("half closed", p, correction ? 0. : K * 2. * log(1.01 / 1.02), 1e-7);
    ExpectNear("correction", point.state[SYM], correction ? 2. * log(1.01) : 0., 1e-14);
    InPlane(0.99 / 1.01, 0., 0., 0.99 / 1.01, dF);
    ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    SqrtJ2(tau, &p, deviator);
    ExpectNear("compressed", p, K * 2. * log(correction ? 0.99 : 0.99 / 1.02), 1e-7);
    ExpectNear("correction", point.state[SYM], 0., 0.);
  }
}
END_TEST

TCase *CamClayCase(void);
TCase *MohrCoulombCase(void);
TCase *NaccCase(void);
TCase *PotentialCase(void);
TCase *WaveCase(void);
TCase *NorSandCase(void);
TCase *JaumannCase(void);
TCase *NewtonianCase(void);
Suite *LawValuesSuite(void);

Suite *LawValuesSuite(void)
{
  Suite             *suite   = suite_create("values of laws");
  TCase             *tcase   = tcase_create("single points");
  const TTest *const tests[] = {test_hencky_simple_shear,
                                test_hencky_stretch_and_rotation,
                                test_neo_hookean,
                                test_linear_elastic,
                                test_j2_return,
                                test_j2_yield_surface,
                                test_drucker_prager_principal,
                                test_drucker_prager_projection,
                                test_drucker_prager_dilation,
                                test_drucker_prager_yield_surface,
                                test_drucker_prager_volume_correction};

  for (size_t t = 0; t < sizeof tests / sizeof tests[0]; ++t) tcase_add_test(tcase, tests[t]);
  tcase_add_loop_test(tcase, test_drucker_prager_fit, COMPRESSION, PLANE_STRAIN + 1);
  suite_add_tcase(suite, tcase);
  suite_add_tcase(suite, CamClayCase());
  suite_add_tcase(suite, MohrCoulombCase());
  suite_add_tcase(suite, NaccCase());
  suite_add_tcase(suite, PotentialCase());
  suite_add_tcase(suite, WaveCase());
  suite_add_tcase(suite, NorSandCase());
  suite_add_tcase(suite, JaumannCase());
  suite_add_tcase(suite, NewtonianCase());
  return suite;
}
