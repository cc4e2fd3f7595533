/*
  Nor-Sand against numbers: drained triaxial tests, the equations of a step written out, the tip of the yield surface, its
  limit N = 0, continuity and Taylor's remainder.
*/
#include "laws.h"
#include "../checks.h"
#include <math.h>
#include <string.h>

TCase *NorSandCase(void);

/* A sand with typical parameters; pressures in Pa */
static Point NorSand(double N, double v, double image)
{
  const struct {
    const char *name;
    double      value;
  } values[] = {{"kappa", 0.01},
                {"G", 20e6},
                {"M", 1.2},
                {"N", N},
                {"beta", 0.9},
                {"lambda", 0.02},
                {"v_c0", 1.9},
                {"h", 100.},
                {"specific_volume", v},
                {"image_pressure", image},
                {"preconsolidation", HUGE_VAL},
                {"ocr", HUGE_VAL},
                {"pop", HUGE_VAL},
                {"reference_pressure", 100e3}};
  Point point;

  RandomSeed(0);
  PointCreate(LawFind("nor_sand"), 0, &point);
  for (size_t k = 0; k < sizeof values / sizeof values[0]; ++k) PointSet(&point, values[k].name, values[k].value);
  return point;
}

static double Get(const Point *point, const char *parameter)
{
  return point->parameter[LawParameter(point->law, parameter)];
}

static double Image(const Point *point)
{
  const double image = point->state[LawState(point->law, "image_pressure")];

  return image > 0. ? image : Get(point, "image_pressure");
}

/* p/p_i at the tip */
static double Tip(double N)
{
  return N > 0. ? pow(1. - N, -(1. - N) / N) : exp(1.);
}

/* p and q of a stress */
static void Invariants(const double *tau, double *p, double *q)
{
  double sum = 0.;

  *p = (tau[0] + tau[1] + tau[2]) / 3.;
  for (int i = 0; i < SYM; ++i) sum += (i < 3 ? 1. : 2.) * (tau[i] - (i < 3 ? *p : 0.)) * (tau[i] - (i < 3 ? *p : 0.));
  *q = sqrt(1.5 * sum);
}

/* eta, p and p_i in the literature's sign */
static double StressRatio(const Point *point, double p, double p_i)
{
  const double M = Get(point, "M"), N = Get(point, "N");

  return N > 0. ? M / N * (1. - (1. - N) * pow(p / p_i, N / (1. - N))) : M * (1. + log(p_i / p));
}

/* ---- drained triaxial tests ---- */

#if MPM_DIM == 3
/* One step of axial (yy) logarithmic strain under the lateral Kirchhoff stress `held`; `lateral` is the strain's guess and
   answer. Returns Newton's iterations. */
static int TriaxialStep(Point *point, double axial, double held, double *lateral, double *tau)
{
  double x = 0.;

  for (int iteration = 0; iteration < 20; ++iteration) {
    const double diagonal[3] = {exp(x), exp(axial), exp(x)};
    double       dF[DIM2], dtau[SYM * DIM2], r;

    Identity(dF);
    for (int a = 0; a < 3; ++a) dF[4 * a] = diagonal[a];
    ck_assert_int_eq(PointEvaluate(point, ALL_DIRECTIONS, dF, tau, dtau), 0);
    r = tau[0] - held;
    if (fabs(r) <= 1e-11 * fabs(held)) {
      *lateral += x;
      ck_assert_int_eq(PointStep(point, dF, tau), 0);
      return iteration;
    }
    x -= r / ((dtau[0] + dtau[8]) * exp(x));
  }
  return 20;
}

/*
  Loose and dense Brasted sand after 1 % axial strain in 50 steps: q and p_i, kPa, and the volume lost, %, of an independent
  program. The last digit is rounded.
*/
START_TEST(test_nor_sand_triaxial)
{
  const struct {
    double h, v, p0, K0, p_c, q, volume, image;
  } sands[]           = {{70., 1.75, 390e3, 0.45, 715e3, 475.572338, 0.3195571, 380.91568},
                         {120., 1.57, 425e3, 0.38, 1150e3, 831.824500, -0.1818168, 673.44795}};
  const double s      = 3. * (1. - sands[_i].K0) / (1. + 2. * sands[_i].K0);
  const double radial = -(3. - s) / 3. * sands[_i].p0, start[6] = {radial, -(3. + 2. * s) / 3. * sands[_i].p0, radial};
  Point        point   = NorSand(0.4, sands[_i].v * exp(-0.0015), HUGE_VAL);
  double       lateral = 0., tau[SYM], p, q;
  MpmLawTable  table[MAX_PARAMETERS];

  PointSet(&point, "kappa", 0.0015);
  PointSet(&point, "G", 45e6);
  PointSet(&point, "M", 1.27);
  PointSet(&point, "beta", 1.);
  PointSet(&point, "v_c0", 1.8911);
  PointSet(&point, "h", sands[_i].h);
  PointSet(&point, "preconsolidation", sands[_i].p_c);
  PointSet(&point, "reference_pressure", sands[_i].p0);
  PointInput(&point, NULL, table);
  ck_assert_int_eq(point.law->info[PLAIN].history(point.parameter, table, start, point.state), 0);
  for (int step = 0; step < 50; ++step) ck_assert_int_le(TriaxialStep(&point, -2e-4, radial, &lateral, tau), 6);
  Invariants(tau, &p, &q);
  ck_assert_double_eq_tol(q / 1e3, sands[_i].q, 1e-6);
  ck_assert_double_eq_tol(100. * (0.01 - 2. * lateral), sands[_i].volume, 1e-7);
  ck_assert_double_eq_tol(Image(&point) / 1e3, sands[_i].image, 1e-5);
}
END_TEST
#endif

/* ---- a step ---- */

/* Elastic strain invariants of a stress: e_v and e_s */
static void ElasticStrain(const Point *point, const double *tau, double *e_v, double *e_s)
{
  double p, q;

  Invariants(tau, &p, &q);
  *e_v = -Get(point, "kappa") * log(-p / Get(point, "reference_pressure"));
  *e_s = q / (3. * Get(point, "G"));
}

/* The trial stress: that of the same elasticity whose yield surface is out of reach */
static void Trial(const Point *point, const double *dF, double *tau)
{
  Point elastic = *point;

  elastic.state[LawState(point->law, "image_pressure")] = 1e300;
  PointSet(&elastic, "lambda", 0.);
  PointSet(&elastic, "N", 0.4);
  PointSet(&elastic, "M", 1e9);
  ck_assert_int_eq(PointEvaluate(&elastic, PLAIN, dF, tau, NULL), 0);
}

enum { INSIDE, ON_SURFACE, AT_TIP, PLACES };

/* The equations of the end of a step, as the literature writes them; where it ended */
static int CheckStep(const Point *before, const Point *after, const double *dF, const double *tau, int sample)
{
  const double M = Get(before, "M"), N = Get(before, "N"), beta = Get(before, "beta");
  const double p_n = -Image(before), p_i = -Image(after), v = after->state[LawState(after->law, "specific_volume")];
  const double psi = v - Get(before, "v_c0") + Get(before, "lambda") * log(-p_i / 1e3);
  double       trial[SYM], p, q, e_v, e_s, v_trial, s_trial, eta, limit, dg, slope, r[4];

  Trial(before, dF, trial);
  ElasticStrain(before, trial, &v_trial, &s_trial);
  ElasticStrain(before, tau, &e_v, &e_s);
  Invariants(tau, &p, &q);
  if (q < 1e-9 * -p) q = 0.;
  eta   = StressRatio(before, p, p_i);
  slope = (eta - M) / (1. - N);
  limit = N > 0. ? p * pow(1. + 3.5 * N * psi / (beta * M), (N - 1.) / N) : p * exp(-3.5 * psi / (beta * M));
  if (p_i == p_n) {
    ck_assert_msg(q + eta * p <= 1e-9 * fabs(p), "sample %d: f = %g, p = %g", sample, q + eta * p, p);
    ck_assert_double_eq_tol(s_trial, e_s, 1e-14);
    return INSIDE;
  }
  dg   = q > 0. ? s_trial - e_s : (v_trial - e_v) / (beta * slope);
  r[0] = e_v - v_trial + dg * beta * slope;
  r[1] = q > 0. ? 0. : fmax(s_trial - dg, 0.);
  r[2] = (q + eta * p) / fabs(p);
  r[3] = (p_i - p_n - Get(before, "h") * (limit - p_i) * dg) / fabs(p_i);
  for (int k = 0; k < 4; ++k)
    ck_assert_msg(fabs(r[k]) <= (k < 2    ? 1e-13
                                 : k == 2 ? 1e-12
                                          : 1e-10),
                  "sample %d: residual %d is %g", sample, k, r[k]);
  return q > 0. ? ON_SURFACE : AT_TIP;
}

/* N = 0 in every third sample; from where random paths lead */
START_TEST(test_nor_sand_step)
{
  int count[PLACES] = {0};

  RandomSeed(70);
  for (int sample = 0; sample < 3000; ++sample) {
    const unsigned seed = 100 + (unsigned)sample;
    Point          point =
      NorSand(sample % 3 ? 0.1 * (sample % 7) + 0.05 : 0., 1.5 + 0.01 * (sample % 61), 60e3 + 1e3 * (sample % 97));
    Point     after;
    double    dF[DIM2], tau[SYM], v;
    const int volume = LawState(point.law, "specific_volume");

    RandomSeed(seed);
    PointRandomPath(&point, sample % 4, 0.003);
    if (!(point.state[volume] > 0.)) PointRandomPath(&point, 1, 1e-5);
    v     = point.state[volume];
    after = point;
    RandomMatrix(sample % 5 ? 0.004 : 4e-4, dF);
    if (sample % 11 == 0) {
      Identity(dF);
      for (int a = 0; a < DIM; ++a) dF[a * (DIM + 1)] = 0.99 + 1e-4 * a;
    }
    ck_assert_int_eq(PointStep(&after, dF, tau), 0);
    ++count[CheckStep(&point, &after, dF, tau, sample)];
    {
      const double det = DIM == 2 ? dF[0] * dF[3] - dF[1] * dF[2]
                                  : dF[0] * (dF[4] * dF[8] - dF[5] * dF[7]) - dF[1] * (dF[3] * dF[8] - dF[5] * dF[6]) +
                                      dF[2] * (dF[3] * dF[7] - dF[4] * dF[6]);

      ck_assert_double_eq_tol(after.state[volume], v * det, 1e-14);
    }
  }
  for (int place = 0; place < PLACES; ++place) ck_assert_int_gt(count[place], DIM == 2 && place == AT_TIP ? 5 : 100);
}
END_TEST

/* Isotropic compression yields at the preconsolidation, keeps p/p_i, and p_i grows. In plane strain there is none. */
START_TEST(test_nor_sand_isotropic)
{
  for (int k = 0; k < 3 && DIM == 3; ++k) {
    const double N = 0.2 * k, little = 1. - 1e-4;
    Point        point = NorSand(N, 1.9, HUGE_VAL);
    double       dF[DIM2], tau[SYM], p, q, before = 100e3;

    PointSet(&point, "preconsolidation", 250e3);
    Identity(dF);
    for (int a = 0; a < DIM; ++a) dF[a * (DIM + 1)] = little;
    for (int step = 0; step < 60; ++step) {
      ck_assert_int_eq(PointStep(&point, dF, tau), 0);
      Invariants(tau, &p, &q);
      ck_assert_double_le(q, 1e-9 * -p);
      ck_assert_double_gt(-p, before);
      before = -p;
      if (-p <= 250e3) ck_assert_double_eq_tol(Image(&point), 250e3 / Tip(N), 1e-8 * 250e3);
      else ck_assert_double_eq_tol(-p / Image(&point), Tip(N), 1e-12);
    }
    ck_assert_double_gt(Image(&point), 1.01 * 250e3 / Tip(N));
  }
}
END_TEST

/* The formulas for N > 0 go over into that for N = 0. */
START_TEST(test_nor_sand_small_N)
{
  const double small[] = {1e-12, 1e-8, 1e-5};
  double       tau[4][SYM], tangent[4][SYM * DIM2], dF[DIM2];

  RandomSeed(72);
  RandomMatrix(0.005, dF);
  for (int k = 0; k < 4; ++k) {
    Point point = NorSand(k < 3 ? small[k] : 0., 1.6, 80e3);

    ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, dF, tau[k], tangent[k]), 0);
  }
  for (int k = 0; k < 3; ++k) {
    ck_assert_double_le(MaxDifference(SYM, tau[k], tau[3]), (1e-11 + 10. * small[k]) * MaxNorm(SYM, tau[3]));
    ck_assert_double_le(MaxDifference(SYM * DIM2, tangent[k], tangent[3]),
                        (1e-11 + 100. * small[k]) * MaxNorm(SYM * DIM2, tangent[3]));
  }
}
END_TEST

/* A long way from one deformation to another, through all places: the stress follows without a jump, and without a
   refusal. ln p and q/p are what is compared, for p spans orders of magnitude. */
START_TEST(test_nor_sand_continuity)
{
  enum { LINES = FEWER > 1 ? 12 : 60, POINTS = 2000 };

  for (int line = 0; line < LINES; ++line) {
    double from[DIM2], to[DIM2], before[2] = {0.}, size = 0.;
    Point  point = NorSand(line % 4 ? 0.15 * (line % 4) : 0., 1.4 + 0.1 * (line % 7), 60e3);

    RandomSeed(7000 + (unsigned)line);
    PointRandomPath(&point, line % 3, 0.01);
    RandomMatrix(0.06, from);
    RandomMatrix(0.06, to);
    for (int k = 0; k <= POINTS; ++k) {
      double dF[DIM2], tau[SYM], p, q, now[2];

      for (int i = 0; i < DIM2; ++i) dF[i] = from[i] + (to[i] - from[i]) * k / POINTS;
      ck_assert_int_eq(PointEvaluate(&point, PLAIN, dF, tau, NULL), 0);
      Invariants(tau, &p, &q);
      now[0] = log(-p);
      now[1] = -q / p;
      if (k) size = fmax(size, MaxDifference(2, now, before));
      memcpy(before, now, sizeof before);
    }
    ck_assert_msg(size <= 1. / POINTS / Get(&point, "kappa"), "line %d: a jump of %g", line, size);
  }
}
END_TEST

/* Order 2 in elasticity, on the surface on both sides of the critical state, at the tip, and where the pressure vanishes */
START_TEST(test_nor_sand_taylor)
{
  const double strains[][3] = {{-1e-4, -2e-4, 1e-4},     {0.003, -0.006, 0.002}, {0.001, -0.02, -0.003},
                               {-0.01, -0.011, -0.0105}, {-0.01, -0.01, -0.01},  {0.03, 0.02, 0.01},
                               {0.06, -0.01, 0.06}};

  for (size_t k = 0; k < sizeof strains / sizeof strains[0]; ++k) {
    for (int curved = 0; curved < 2; ++curved) {
      Point  point = NorSand(curved ? 0.4 : 0., 1.7, 70e3);
      double dF[DIM2], R[DIM2], V[DIM2], turned[DIM2], r[2];

      RandomSeed(75 + (unsigned)k);
      Identity(dF);
      for (int a = 0; a < DIM; ++a) dF[a * (DIM + 1)] += strains[k][a];
      RandomRotation(R);
      Multiply(R, dF, turned);
      for (int i = 0; i < DIM2; ++i) V[i] = RandomUniform(-1., 1.);
      r[0] = TaylorRemainder(&point, turned, V, 1e-6);
      r[1] = TaylorRemainder(&point, turned, V, 5e-7);
      ck_assert_msg(r[1] <= 2e-15 * PointStiffnessAround(&point, turned) || log2(r[0] / r[1]) > 1.95,
                    "strain %d, N %g: remainders %g and %g", (int)k, curved ? 0.4 : 0., r[0], r[1]);
    }
  }
}
END_TEST

/* What parameters are refused, and in which terms */
START_TEST(test_nor_sand_check)
{
  Point             point = NorSand(0.4, 1.7, 100e3);
  const MpmLawInfo *info  = &point.law->info[PLAIN];
  MpmLawFault       fault;

  ck_assert_int_eq(info->check(point.parameter, NULL, &fault), 1);
  PointSet(&point, "preconsolidation", 215e3);
  ck_assert_int_eq(info->check(point.parameter, NULL, &fault), 0);
  ck_assert_int_eq(fault.parameter, LawParameter(point.law, "preconsolidation"));
  PointSet(&point, "image_pressure", HUGE_VAL);
  ck_assert_int_eq(info->check(point.parameter, NULL, &fault), 1);
  PointSet(&point, "preconsolidation", HUGE_VAL);
  ck_assert_int_eq(info->check(point.parameter, NULL, &fault), 0);
  ck_assert_int_lt(fault.parameter, 0);
}
END_TEST

/*
  Image pressure from a stress: with ocr = 1 or pop = 0 the stress is on the yield surface; ocr multiplies the surface's size
  and pop adds to that at its tip. The ratio of ground at rest goes with the same overconsolidation.
*/
START_TEST(test_nor_sand_overconsolidation)
{
  const double stress[SYM] = {-80e3, -200e3, -90e3}, pop = 70e3, sine = 3. * 1.2 / 7.2;
  const double N = _i ? 0.4 : 0., tip = Tip(N), eta_jaky = 3. * sine / (3. - 2. * sine);
  double       p, q, image[2];
  MpmLawTable  table[MAX_PARAMETERS];

  Invariants(stress, &p, &q);
  for (int excess = 0; excess < 2; ++excess) {
    const char *name                                                              = excess ? "pop" : "ocr";
    Point       point                                                             = NorSand(N, 1.7, HUGE_VAL);
    int (*history)(const double *, const MpmLawTable *, const double *, double *) = point.law->info[PLAIN].history;

    PointInput(&point, NULL, table);
    for (int larger = 0; larger < 2; ++larger) {
      PointReset(&point);
      PointSet(&point, name, excess ? larger * pop : 1. + larger);
      ck_assert_int_eq(history(point.parameter, table, stress, point.state), 0);
      image[larger] = Image(&point);
    }
    ck_assert_double_eq_tol((q + StressRatio(&point, p, -image[0]) * p) / q, 0., 1e-13);
    ck_assert_double_eq_tol(image[1] / (excess ? image[0] + pop / tip : 2. * image[0]), 1., 1e-14);
    if (N > 0.) { /* q/p above M/N, which no surface has */
      const double steep[SYM] = {20e3, -900e3, 20e3};

      PointReset(&point);
      ck_assert_int_ne(history(point.parameter, table, steep, point.state), 0);
    }
    /* at rest under 90 kPa: the size through Jaky's stress is `size` */
    {
      const double weight = 90e3, pressure = weight * (3. - 2. * sine) / 3.;
      const double ratio = N > 0. ? pow((1. - eta_jaky * N / 1.2) / (1. - N), (1. - N) / N) : exp(1. - eta_jaky / 1.2);
      const double size = tip * pressure / ratio, ocr = excess ? 1. + pop / size : 2.;

      ck_assert_double_eq_tol(point.law->info[PLAIN].k0(point.parameter, table, NULL, weight),
                              (1. - sine) * pow(ocr, sine), 1e-13);
    }
  }
}
END_TEST

TCase *NorSandCase(void)
{
  TCase *tcase = tcase_create("Nor-Sand");

#if MPM_DIM == 3
  tcase_add_loop_test(tcase, test_nor_sand_triaxial, 0, 2);
#endif
  tcase_add_test(tcase, test_nor_sand_step);
  tcase_add_test(tcase, test_nor_sand_isotropic);
  tcase_add_test(tcase, test_nor_sand_small_N);
  tcase_add_test(tcase, test_nor_sand_continuity);
  tcase_add_test(tcase, test_nor_sand_taylor);
  tcase_add_loop_test(tcase, test_nor_sand_overconsolidation, 0, 2);
  tcase_add_test(tcase, test_nor_sand_check);
  return tcase;
}
