/*
  Mohr-Coulomb against numbers: published returns, a closest-point projection by brute force, Taylor's remainder in every
  region, softening in closed form.
*/
#include "laws.h"
#include "../checks.h"
#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

TCase *MohrCoulombCase(void);

/* Associated or not; without tension cut-off where that is infinite, and without softening */
static Point MohrCoulomb(double E, double nu, double c, double phi, double psi, double tension)
{
  const struct {
    const char *name;
    double      value;
  } values[] = {{"E", E},
                {"nu", nu},
                {"cohesion", c},
                {"friction", phi},
                {"dilation", psi},
                {"tension", tension},
                {"cohesion_residual", c},
                {"friction_residual", phi},
                {"dilation_residual", psi},
                {"softening_strain", HUGE_VAL}};
  Point point;

  RandomSeed(0);
  PointCreate(LawFind("mohr_coulomb"), 0, &point);
  for (size_t k = 0; k < sizeof values / sizeof values[0]; ++k) PointSet(&point, values[k].name, values[k].value);
  return point;
}

/* Principal stresses along x, y, z that the trial ones return to */
static void Return(Point *point, const double *trial, double *tau)
{
  double I[DIM2];

  Identity(I);
  PointSetPrincipal(point, trial);
  if (PointStep(point, I, tau)) ck_abort_msg("no answer");
}

/*
  Returns in kPa. The first five follow from de Souza Neto, Peric and Owen (2008), doi:10.1002/9780470694626, section 8.2,
  by hand; all have been computed by an independent program. Their last digit is rounded.
*/
START_TEST(test_mohr_coulomb_values)
{
  const struct {
    double E, nu, c, phi, psi, trial[3], expected[3], tolerance;
  } cases[] = {{20e3, 0.4, 0., 20., 0., {-50., -100., -300.}, {-111.39698247, -111.39698247, -227.20603506}, 6e-9},
               {20e3, 0.4, 0., 20., 0., {-100., -100., -300.}, {-123.77442497, -123.77442497, -252.45115006}, 6e-9},
               {20e3, 0.4, 0., 20., 0., {-50., -290., -300.}, {-126.00376126, -256.99811937, -256.99811937}, 6e-9},
               {20e3, 0.4, 0., 20., 0., {10., -5., -20.}, {-3.28989928, -5., -6.71010072}, 6e-9},
               {20e3, 0.4, 0., 20., 0., {5., 3., 2.}, {0., 0., 0.}, 1e-12},
               {30e3, 0.25, 5., 35., 8., {-20., -60., -400.}, {-89.525321676, -89.525321676, -349.573686346}, 6e-10},
               {30e3, 0.25, 5., 35., 8., {-60., -380., -420.}, {-102.160458484, -384.589994273, -396.199518606}, 6e-10},
               {30e3, 0.25, 5., 35., 8., {12., -300., -310.}, {-72.245124381, -285.806780392, -285.806780392}, 6e-10},
               {30e3, 0.25, 5., 35., 8., {30., 28., 20.}, {7.140740034, 7.140740034, 7.140740034}, 6e-10}};

  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    for (int turn = 0; turn < 3; ++turn) { /* which of them is along which axis does not matter */
      Point  point = MohrCoulomb(cases[k].E, cases[k].nu, cases[k].c, cases[k].phi, cases[k].psi, HUGE_VAL);
      double trial[3], tau[SYM];

      for (int a = 0; a < 3; ++a) trial[(a + turn) % 3] = cases[k].trial[a];
      Return(&point, trial, tau);
      for (int a = 0; a < 3; ++a)
        ck_assert_msg(fabs(tau[(a + turn) % 3] - cases[k].expected[a]) <= cases[k].tolerance,
                      "case %d: stress %d is %.10f, expected %.10f", (int)k, a, tau[(a + turn) % 3],
                      cases[k].expected[a]);
    }
  }
}
END_TEST

/* ---- the closest point by brute force ---- */

enum { WALLS = 9 };

/* n . t <= h, not in any order of principal values: six of Mohr-Coulomb, three of tension */
typedef struct {
  double n[WALLS][3], h[WALLS];
  int    count;
} Polyhedron;

static Polyhedron PolyhedronOf(const Point *point)
{
  const double c       = point->parameter[LawParameter(point->law, "cohesion")];
  const double phi     = point->parameter[LawParameter(point->law, "friction")] * PI / 180.;
  const double tension = point->parameter[LawParameter(point->law, "tension")];
  Polyhedron   set     = {{{0.}}, {0.}, 0};

  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (i == j) continue;
      set.n[set.count][i] = 1. + sin(phi);
      set.n[set.count][j] = sin(phi) - 1.;
      set.h[set.count++]  = 2. * c * cos(phi);
    }
  }
  for (int i = 0; i < 3 && isfinite(tension); ++i) {
    set.n[set.count][i] = 1.;
    set.h[set.count++]  = tension;
  }
  return set;
}

static double PolyhedronExcess(const Polyhedron *set, const double *t)
{
  double largest = -HUGE_VAL;

  for (int w = 0; w < set->count; ++w)
    largest = fmax(largest, set->n[w][0] * t[0] + set->n[w][1] * t[1] + set->n[w][2] * t[2] - set->h[w]);
  return largest;
}

/* The point on `count` walls closest to the trial one: C^-1 (t - trial) + sum_i m_i n_i = 0, n_i . t = h_i */
static void ProjectOnWalls(const Polyhedron *set, double E, double nu, const int *wall, int count, const double *trial,
                           double *t)
{
  const int n = 3 + count;
  double    A[36], b[6] = {0.};

  memset(A, 0, sizeof A);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      A[i * n + j] = (i == j ? 1. : -nu);
      b[i] += A[i * n + j] * trial[j];
    }
    for (int k = 0; k < count; ++k) A[i * n + 3 + k] = A[(3 + k) * n + i] = set->n[wall[k]][i];
  }
  for (int k = 0; k < count; ++k) b[3 + k] = set->h[wall[k]];
  (void)E; /* of no influence on the closest point */
  Solve(n, A, b);
  memcpy(t, b, 3 * sizeof *t);
}

/* The closest of the admissible points among the projections on all faces, edges and corners */
static void ClosestPoint(const Polyhedron *set, double E, double nu, const double *trial, double *closest)
{
  const double size  = fabs(trial[0]) + fabs(trial[1]) + fabs(trial[2]) + set->h[0];
  double       least = HUGE_VAL;

  for (int i = 0; i < set->count; ++i) {
    for (int j = i; j < set->count; ++j) {
      for (int k = j; k < set->count; ++k) {
        const int wall[3] = {i, j, k}, count = j == i ? 1 : k == j ? 2 : 3;
        double    t[3], distance             = 0.;

        if (j == i && k > j) continue; /* a pair is i < j = k */
        ProjectOnWalls(set, E, nu, wall, count, trial, t);
        if (!(PolyhedronExcess(set, t) <= 1e-12 * size)) continue;
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) distance += (a == b ? 1. : -nu) * (t[a] - trial[a]) * (t[b] - trial[b]);
        if (!(distance < least)) continue;
        least = distance;
        memcpy(closest, t, 3 * sizeof *t);
      }
    }
  }
  if (!(least < HUGE_VAL)) ck_abort_msg("no admissible point");
}

/* A trial stress of the order of the strength or well above, with neighbours and equals among its values */
static void RandomTrial(double c, double phi, double *trial)
{
  const double p = (c + 1e-3) / tan(phi) * RandomUniform(-8., 4.), size = fabs(p) + c;

  for (int a = 0; a < 3; ++a) trial[a] = p + size * RandomUniform(-1., 1.) * RandomUniform(0., 2.);
  if (RandomUniform(0., 1.) < 0.1) trial[1] = trial[0];
  if (RandomUniform(0., 1.) < 0.1) trial[2] = trial[1] * (1. + pow(10., RandomUniform(-16., -6.)));
}

/* Associated flow, with and without tension cut-off: the law's return is the closest point of the polyhedron. */
START_TEST(test_mohr_coulomb_projection)
{
  int outside = 0;

  RandomSeed(30 + (unsigned)_i);
  for (int sample = 0; sample < 10000; ++sample) {
    const double   nu = RandomUniform(-0.2, 0.48), phi = RandomUniform(2., 60.), c = RandomUniform(0., 20.);
    const double   t     = _i ? RandomUniform(0., 1.) * c / tan(phi * PI / 180.) : HUGE_VAL;
    const unsigned again = 1000 + (unsigned)sample;
    Point          point = MohrCoulomb(30e3, nu, c, phi, phi, t);
    Polyhedron     set;
    double         trial[3], tau[SYM], closest[3], size;

    RandomSeed(again + 100000 * (unsigned)_i);
    RandomTrial(c, phi * PI / 180., trial);
    set  = PolyhedronOf(&point);
    size = MaxNorm(3, trial) + c;
    memcpy(closest, trial, sizeof trial);
    if (PolyhedronExcess(&set, trial) > 0.) {
      ClosestPoint(&set, 30e3, nu, trial, closest);
      ++outside;
    }
    Return(&point, trial, tau);
    if (!(MaxDifference(3, tau, closest) <= 1e-10 * size + 1e-15 * 30e3)) /* asserting takes time */
      ck_abort_msg("sample %d: (%.12g, %.12g, %.12g) returns to (%.12g, %.12g, %.12g), the closest point is (%.12g, "
                   "%.12g, %.12g)",
                   sample, trial[0], trial[1], trial[2], tau[0], tau[1], tau[2], closest[0], closest[1], closest[2]);
  }
  ck_assert_int_gt(outside, 4000);
}
END_TEST

/*
  Flow that is not associated: the return is admissible and follows the trial stress without a jump, along lines through
  all regions, with and without tension cut-off and softening.
*/
START_TEST(test_mohr_coulomb_continuity)
{
  enum { LINES = 300 / FEWER, POINTS = 400 };

  for (int line = 0; line < LINES; ++line) {
    double from[3], to[3], before[SYM] = {0.}, trial[3], tau[SYM], phi, c, step;
    Point  start;

    RandomSeed(40 + (unsigned)line);
    phi = RandomUniform(2., 60.);
    c   = RandomUniform(1., 20.);
    {
      const double psi = line % 3 ? RandomUniform(0., phi) : 0.,
                   cut = RandomUniform(0.1, 1.) * c / tan(phi * PI / 180.);
      const double nu  = RandomUniform(-0.2, 0.45);

      start = MohrCoulomb(30e3, nu, c, phi, psi, _i & 1 ? cut : HUGE_VAL);
    }
    RandomSeed(10000 + (unsigned)line);
    if (_i & 2) {
      PointSet(&start, "cohesion_residual", 0.5 * c);
      PointSet(&start, "softening_strain", 0.02);
    }
    RandomTrial(c, phi * PI / 180., from);
    RandomTrial(c, phi * PI / 180., to);
    step = MaxDifference(3, to, from) / POINTS;
    for (int k = 0; k <= POINTS; ++k) {
      Point            point = start;
      const Polyhedron set   = PolyhedronOf(&point);

      for (int a = 0; a < 3; ++a) trial[a] = from[a] + (to[a] - from[a]) * k / POINTS;
      Return(&point, trial, tau);
      if (!(_i & 2) && !(PolyhedronExcess(&set, tau) <= 1e-10 * (MaxNorm(3, trial) + c)))
        ck_abort_msg("line %d, point %d: %g outside", line, k, PolyhedronExcess(&set, tau));
      if (k && !(MaxDifference(3, tau, before) <= 25. * step))
        ck_abort_msg("line %d, point %d, phi %g: (%.9g, %.9g, %.9g) -> (%.9g, %.9g, %.9g) after (%.9g, %.9g, %.9g)",
                     line, k, phi, trial[0], trial[1], trial[2], tau[0], tau[1], tau[2], before[0], before[1],
                     before[2]);
      memcpy(before, tau, sizeof tau);
    }
  }
}
END_TEST

/* ---- Taylor's remainder ---- */

/* Order 2 in every region, also where trial values coincide exactly or nearly; with softening too */
START_TEST(test_mohr_coulomb_taylor)
{
  /* kPa; c 10, phi 30, psi 10: the apex is at 17.3. In the second half a tension of 10 cuts it off. */
  static const double trials[][3] = {{-20., -150., -400.},
                                     {-20., -60., -400.},
                                     {-60., -380., -420.},
                                     {12., -300., -310.},
                                     {-60., -60., -400.},
                                     {10., -300., -300.},
                                     {-60., -60.00000001, -400.},
                                     {60., 58., 50.},
                                     {60., 60., 60.},
                                     {60., 60., 50.},
                                     {14., 2., 0.},
                                     {14., 2., 2.},
                                     {14., 13., 2.},
                                     {14., 14., 2.},
                                     {25., 3., 0.},
                                     {40., 5., 4.},
                                     {40., 5., 5.},
                                     {20., 19.5, -10.},
                                     {30., 30., -10.},
                                     {30., 28., 26.},
                                     {30., 30., 30.},
                                     {40., -20., -60.},
                                     {60., -52., -54.},
                                     {60., 58., -60.},
                                     {60., 60., -60.}};

  for (int k = 0; k < (int)(sizeof trials / sizeof trials[0]); ++k) {
    for (int soft = 0; soft < 2; ++soft) {
      Point  point = MohrCoulomb(30e3, 0.25, 10., 30., 10., k < 10 ? HUGE_VAL : 10.);
      double I[DIM2], R[DIM2], V[DIM2], h = 1e-6, r[2], size = PointStiffness(&point);

      if (soft) {
        PointSet(&point, "cohesion_residual", 4.);
        PointSet(&point, "friction_residual", 20.);
        PointSet(&point, "dilation_residual", 2.);
        PointSet(&point, "softening_strain", 0.1);
      }
      RandomSeed(50 + (unsigned)k);
      Identity(I);
      RandomRotation(R);
      PointSetPrincipal(&point, trials[k]);
      SymRotate(R, point.state, point.state);
      for (int i = 0; i < DIM2; ++i) V[i] = RandomUniform(-1., 1.);
      r[0] = TaylorRemainder(&point, I, V, h);
      r[1] = TaylorRemainder(&point, I, V, 0.5 * h);
      /* down to what rounding makes of the stress */
      ck_assert_msg(r[1] <= 2e-15 * size || log2(r[0] / r[1]) > 1.95, "trial %d%s: remainders %g and %g", k,
                    soft ? ", softening" : "", r[0], r[1]);
      ck_assert_msg(r[0] <= 1e-8 * size, "trial %d%s: remainder %g at %g", k, soft ? ", softening" : "", r[0], h);
    }
  }
}
END_TEST

/*
  Without friction and dilation: t1 - t3 = 2 c(kappa), kappa = (2/sqrt 3) g with plastic strains g, 0, -g, and g follows
  from (t1 - t3)_trial - 4 mu g = 2 c(kappa). Then at the residual strength.
*/
START_TEST(test_mohr_coulomb_softening)
{
  const double mu = 12e3, c = 20., rest = 5., limit = 0.01, trial[3] = {60., 5., -40.};
  const double slope = 2. / sqrt(3.) * (rest - c) / limit, g = (100. - 2. * c) / (4. * mu + 2. * slope);
  Point        point = MohrCoulomb(30e3, 0.25, c, 0., 0., HUGE_VAL);
  double       tau[SYM];
  int          kappa = LawState(point.law, "equivalent_plastic_strain");

  PointSet(&point, "cohesion_residual", rest);
  PointSet(&point, "softening_strain", limit);
  Return(&point, trial, tau);
  ck_assert_double_eq_tol(point.state[kappa], 2. / sqrt(3.) * g, 1e-15);
  ck_assert_double_eq_tol(tau[0] - tau[2], 2. * (c + slope * g), 1e-11);
  ck_assert_double_eq_tol(tau[0] + tau[1] + tau[2], 25., 1e-11);
  ck_assert_double_eq_tol(tau[1], 5., 1e-11);
  for (int k = 0; k < 12; ++k) Return(&point, trial, tau);
  ck_assert_double_gt(point.state[kappa], limit);
  ck_assert_double_eq_tol(tau[0] - tau[2], 2. * rest, 1e-11);
}
END_TEST

/* What parameters are refused, and in which terms */
START_TEST(test_mohr_coulomb_check)
{
  const struct {
    const char *name;
    double      value, upper;
  } wrong[] = {{"dilation", 31., 30.},         {"tension", 17.4, 10. * sqrt(3.)}, {"cohesion_residual", 11., 10.},
               {"cohesion_residual", 9., 10.}, {"friction_residual", 29., 30.},   {"dilation_residual", 9., 10.}};

  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
    Point             point = MohrCoulomb(30e3, 0.25, 10., 30., 10., HUGE_VAL);
    const MpmLawInfo *info  = &point.law->info[PLAIN];
    MpmLawFault       fault;

    ck_assert_int_eq(info->check(point.parameter, NULL, &fault), 1);
    PointSet(&point, wrong[k].name, wrong[k].value);
    ck_assert_int_eq(info->check(point.parameter, NULL, &fault), 0);
    ck_assert_int_eq(fault.parameter, LawParameter(point.law, wrong[k].name));
    ck_assert_double_eq_tol(fault.upper, wrong[k].upper, 1e-10);
  }
}
END_TEST

TCase *MohrCoulombCase(void)
{
  TCase *tcase = tcase_create("Mohr-Coulomb");

  tcase_add_test(tcase, test_mohr_coulomb_values);
  tcase_add_loop_test(tcase, test_mohr_coulomb_projection, 0, 2);
  tcase_add_loop_test(tcase, test_mohr_coulomb_continuity, 0, 4);
  tcase_add_test(tcase, test_mohr_coulomb_taylor);
  tcase_add_test(tcase, test_mohr_coulomb_softening);
  tcase_add_test(tcase, test_mohr_coulomb_check);
  return tcase;
}
