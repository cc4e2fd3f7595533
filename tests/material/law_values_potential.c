/*
  Laws against their potentials: P = tau F^{-T} is the derivative of psi by F, here by differences in extended precision,
  of formulas in principal logarithmic stretches that share nothing with the laws.
*/
#include "laws.h"
#include "../checks.h"
#include <math.h>
#include <string.h>

TCase *PotentialCase(void);

/* psi at principal logarithmic stretches e */
typedef long double (*Potential)(const Point *point, const long double e[3]);

static long double Value(const Point *point, const char *name)
{
  return (long double)point->parameter[LawParameter(point->law, name)];
}

/* ---- logarithmic stretches in extended precision ---- */

/* One rotation of Jacobi's method that makes A_pq 0 */
static void Rotate(long double A[3][3], int p, int q)
{
  long double theta, t, c, s, before[3][3];

  if (A[p][q] == 0.L) return;
  theta = (A[q][q] - A[p][p]) / (2.L * A[p][q]);
  t     = (theta < 0.L ? -1.L : 1.L) / (fabsl(theta) + sqrtl(theta * theta + 1.L));
  c     = 1.L / sqrtl(t * t + 1.L);
  s     = t * c;
  memcpy(before, A, sizeof before);
  for (int k = 0; k < 3; ++k) {
    A[k][p] = c * before[k][p] - s * before[k][q];
    A[k][q] = s * before[k][p] + c * before[k][q];
  }
  memcpy(before, A, sizeof before);
  for (int k = 0; k < 3; ++k) {
    A[p][k] = c * before[p][k] - s * before[q][k];
    A[q][k] = s * before[p][k] + c * before[q][k];
  }
}

static void LogStretches(const long double *F, long double e[3])
{
  long double A[3][3] = {{0.L}};

  A[2][2] = 1.L;
  for (int i = 0; i < DIM; ++i) {
    for (int j = 0; j < DIM; ++j) {
      A[i][j] = 0.L;
      for (int k = 0; k < DIM; ++k) A[i][j] += F[i * DIM + k] * F[j * DIM + k];
    }
  }
  for (int sweep = 0; sweep < 10; ++sweep)
    for (int p = 0; p < 3; ++p) Rotate(A, p, (p + 1) % 3);
  for (int a = 0; a < 3; ++a) e[a] = 0.5L * logl(A[a][a]);
}

static long double Trace(const long double e[3])
{
  return e[0] + e[1] + e[2];
}

/* |dev e| */
static long double Deviation(const long double e[3])
{
  const long double mean = Trace(e) / 3.L;

  return sqrtl((e[0] - mean) * (e[0] - mean) + (e[1] - mean) * (e[1] - mean) + (e[2] - mean) * (e[2] - mean));
}

/* ---- potentials ---- */

static long double Shear(const Point *point)
{
  return Value(point, "E") / (2.L * (1.L + Value(point, "nu")));
}

static long double Bulk(const Point *point)
{
  return Value(point, "E") / (3.L * (1.L - 2.L * Value(point, "nu")));
}

/* Hencky's up to |dev e| = R/(2 mu), then growing linearly and, with hardening, quadratically */
static long double PlasticPotential(const Point *point, const long double e[3])
{
  const long double mu = Shear(point), R = sqrtl(2.L / 3.L) * Value(point, "yield_stress"), yield = R / (2.L * mu);
  const long double hard = 2.L / 3.L * Value(point, "hardening"), size = Deviation(e), over = size - yield;
  const long double volume = 0.5L * Bulk(point) * Trace(e) * Trace(e);

  if (over <= 0.L) return volume + mu * size * size;
  return volume + mu * yield * yield + R * over + 0.5L * (2.L * mu * hard / (2.L * mu + hard)) * over * over;
}

static long double NeoHookeanPotential(const Point *point, const long double e[3])
{
  const int         quadratic = Value(point, "volumetric") > 0.5L, isochoric = Value(point, "shear") > 0.5L;
  const long double mu = Shear(point), k = Bulk(point), ln = Trace(e), J = expl(ln);
  const long double U  = quadratic ? 0.25L * (J * J - 1.L - 2.L * ln) : 0.5L * ln * ln;
  long double       I1 = 0.L;

  for (int a = 0; a < 3; ++a) I1 += expl(2.L * e[a]);
  if (isochoric) return 0.5L * mu * (powl(J, -2.L / 3.L) * I1 - 3.L) + k * U;
  return 0.5L * mu * (I1 - 3.L) - mu * ln + (k - 2.L / 3.L * mu) * U;
}

static const double *Terms(const Point *point)
{
  return point->data[LawParameter(point->law, "terms")];
}

static long double OgdenPotential(const Point *point, const long double e[3])
{
  const long double ln = Trace(e), J = expl(ln), nu = Value(point, "nu");
  long double       psi = 0.L, mu = 0.L, k = Value(point, "bulk_modulus");

  for (int i = 0; i < MAX_DATA / 2; ++i) {
    const long double alpha = (long double)Terms(point)[2 * i], m = (long double)Terms(point)[2 * i + 1];

    mu += 0.5L * alpha * m;
    for (int a = 0; a < 3; ++a) psi += m / alpha * (powl(powl(J, -1.L / 3.L) * expl(e[a]), alpha) - 1.L);
  }
  if (isinf((double)k)) k = 2.L * mu * (1.L + nu) / (3.L * (1.L - 2.L * nu));
  return psi + 0.25L * k * (J * J - 1.L - 2.L * ln);
}

/* ---- the comparison ---- */

/* d psi/dF_c by central differences with h, h/2, h/4, twice extrapolated */
static long double Slope(const Point *point, Potential potential, const double *F, int c, long double h)
{
  long double D[3];

  for (int level = 0; level < 3; ++level) {
    long double moved[DIM2], e[3], step = ldexpl(h, -level);

    for (int i = 0; i < DIM2; ++i) moved[i] = (long double)F[i];
    moved[c] += step;
    LogStretches(moved, e);
    D[level] = potential(point, e);
    moved[c] -= 2.L * step;
    LogStretches(moved, e);
    D[level] = (D[level] - potential(point, e)) / (2.L * step);
  }
  D[0] = (4.L * D[1] - D[0]) / 3.L;
  D[1] = (4.L * D[2] - D[1]) / 3.L;
  return (16.L * D[1] - D[0]) / 15.L;
}

/* The largest of tau - (d psi/dF) F^T, relative to the largest of tau; h is small against |dev e| */
static double Mismatch(const Point *point, Potential potential, const double *F, long double h)
{
  double tau[SYM], P[DIM2], size, apart = 0.;

  ck_assert_int_eq(PointEvaluate(point, PLAIN, F, tau, NULL), 0);
  size = MaxNorm(SYM, tau);
  for (int c = 0; c < DIM2; ++c) P[c] = (double)Slope(point, potential, F, c, h);
  for (int i = 0; i < DIM; ++i) {
    for (int j = 0; j < DIM; ++j) {
      double sum = 0.;

      for (int k = 0; k < DIM; ++k) sum += P[i * DIM + k] * F[j * DIM + k];
      apart = fmax(apart, fabs(sum - tau[SymAt(i, j)]));
    }
  }
  return apart / size;
}

static long double DeviationOf(const double *F)
{
  long double values[DIM2], e[3];

  for (int i = 0; i < DIM2; ++i) values[i] = (long double)F[i];
  LogStretches(values, e);
  return Deviation(e);
}

enum { SAMPLES = 200 };

/* One step from the virgin state, perfect plasticity (0) and linear hardening (1), elastic and far into plastic flow */
START_TEST(test_j2_potential)
{
  int elastic = 0, plastic = 0;

  RandomSeed(60 + (unsigned)_i);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point       point;
    double      F[DIM2], apart;
    long double size, yield, h;

    PointCreate(LawFind("j2"), 0, &point);
    if (!_i) PointSet(&point, "hardening", 0.);
    RandomMatrix(pow(10., RandomUniform(-4., -0.7)), F);
    size  = DeviationOf(F);
    yield = sqrtl(2.L / 3.L) * Value(&point, "yield_stress") / (2.L * Shear(&point));
    h     = 0.01L * size;
    if (fabsl(size - yield) < 4.L * h) continue; /* a kink of the stress between the differences */
    elastic += size < yield;
    plastic += size > yield;
    apart = Mismatch(&point, PlasticPotential, F, h);
    ck_assert_msg(apart <= 1e-10, "sample %d, strain %Lg, yield at %Lg: apart by %g", sample, size, yield, apart);
  }
  ck_assert_int_gt(elastic, 10);
  ck_assert_int_gt(plastic, 80);
}
END_TEST

/* Ten steps along fixed axes that grow in proportion end with the stress of one step, and with the potential's. */
START_TEST(test_j2_monotone)
{
  RandomSeed(62 + (unsigned)_i);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    const double size = pow(10., RandomUniform(-2., -0.7));
    double       R[DIM2], part[DIM2] = {0.}, dF[DIM2] = {0.}, F[DIM2], tau[SYM], whole[SYM];
    Point        point;

    PointCreate(LawFind("j2"), 0, &point);
    if (!_i) PointSet(&point, "hardening", 0.);
    RandomRotation(R);
    Identity(F);
    for (int a = 0; a < DIM; ++a) part[a * (DIM + 1)] = exp(0.1 * size * RandomUniform(-1., 1.));
    for (int i = 0; i < DIM; ++i)
      for (int j = 0; j < DIM; ++j)
        for (int a = 0; a < DIM; ++a) dF[i * DIM + j] += R[i * DIM + a] * part[a * (DIM + 1)] * R[j * DIM + a];
    for (int step = 0; step < 10; ++step) {
      double next[DIM2];

      Multiply(dF, F, next);
      memcpy(F, next, sizeof F);
    }
    ck_assert_int_eq(PointEvaluate(&point, PLAIN, F, whole, NULL), 0);
    for (int step = 0; step < 10; ++step) ck_assert_int_eq(PointStep(&point, dF, tau), 0);
    ck_assert_double_le(MaxDifference(SYM, tau, whole), 1e-10 * MaxNorm(SYM, whole));
  }
}
END_TEST

/* Both words of `volumetric`, both of `shear` */
START_TEST(test_neo_hookean_potential)
{
  RandomSeed(64 + (unsigned)_i);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point  point;
    double F[DIM2], apart;

    PointCreate(LawFind("neo_hookean"), 0, &point);
    PointSet(&point, "volumetric", _i % 2);
    PointSet(&point, "shear", _i / 2);
    RandomMatrix(pow(10., RandomUniform(-2., -0.4)), F);
    if (!(DeviationOf(F) < 3.L)) continue;
    apart = Mismatch(&point, NeoHookeanPotential, F, 2e-4L);
    ck_assert_msg(apart <= 1e-10, "sample %d: apart by %g", sample, apart);
  }
}
END_TEST

static void SetTerms(Point *point, int count, const double terms[][2])
{
  double *data = point->data[LawParameter(point->law, "terms")];

  for (int i = 0; i < MAX_DATA / 2; ++i) {
    data[2 * i]     = i < count ? terms[i][0] : terms[count - 1][0] + 1. + i;
    data[2 * i + 1] = i < count ? terms[i][1] : 0.;
  }
}

/* Poisson's ratio (0) or a bulk modulus (1); Ogden's three terms, or two at random */
START_TEST(test_ogden_potential)
{
  RandomSeed(68 + (unsigned)_i);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    const double ogden[3][2] = {{-2., -10e3}, {1.3, 630e3}, {5., 1200.}};
    const double two[2][2]   = {{RandomUniform(-4., -0.5), -pow(10., RandomUniform(4., 6.))},
                                {RandomUniform(0.5, 4.), pow(10., RandomUniform(4., 6.))}};
    Point        point;
    double       F[DIM2], apart;

    PointCreate(LawFind("ogden"), 0, &point);
    if (_i) PointSet(&point, "nu", 0.5);
    PointSet(&point, "bulk_modulus", _i ? RandomUniform(0.1e6, 50e6) : HUGE_VAL);
    if (sample % 2) SetTerms(&point, 3, ogden);
    else SetTerms(&point, 2, two);
    RandomMatrix(pow(10., RandomUniform(-2., -0.4)), F);
    if (!(DeviationOf(F) < 3.L)) continue;
    apart = Mismatch(&point, OgdenPotential, F, 2e-4L);
    ck_assert_msg(apart <= 1e-10, "sample %d: apart by %g", sample, apart);
  }
}
END_TEST

/* ---- Ogden ---- */

/*
  One term of exponent 2 is the neo-Hookean solid of isochoric shear and quadratic volume: the stress to rounding, the
  tangent to what rounding leaves of (y_a - y_b)/(w_a - w_b).
*/
START_TEST(test_ogden_is_neo_hookean)
{
  RandomSeed(70);
  for (int sample = 0; sample < SAMPLES; ++sample) {
    Point  rubber, solid;
    double F[DIM2], tau[2][SYM], dtau[2][SYM * DIM2], mu, size, term[1][2];

    PointCreate(LawFind("neo_hookean"), 0, &solid);
    PointSet(&solid, "volumetric", 1.);
    PointSet(&solid, "shear", 1.);
    mu = (double)Shear(&solid);
    PointCreate(LawFind("ogden"), 0, &rubber);
    term[0][0] = 2.;
    term[0][1] = mu;
    SetTerms(&rubber, 1, term);
    PointSet(&rubber, "bulk_modulus", HUGE_VAL);
    PointSet(&rubber, "nu", (double)Value(&solid, "nu"));
    if (sample % 4) RandomMatrix(pow(10., RandomUniform(-6., -0.5)), F);
    else Identity(F);
    if (sample % 8 == 4) F[0] = F[DIM + 1] = 1.3; /* two equal stretches */
    ck_assert_int_eq(PointEvaluate(&rubber, ALL_DIRECTIONS, F, tau[0], dtau[0]), 0);
    ck_assert_int_eq(PointEvaluate(&solid, ALL_DIRECTIONS, F, tau[1], dtau[1]), 0);
    size = (double)Bulk(&solid) + MaxNorm(SYM * DIM2, dtau[1]);
    ck_assert_double_le(MaxDifference(SYM, tau[0], tau[1]), 4e-15 * size);
    ck_assert_double_le(MaxDifference(SYM * DIM2, dtau[0], dtau[1]), 1e-10 * size);
    memcpy(rubber.F, F, sizeof F);
    memcpy(solid.F, F, sizeof F);
    ck_assert_double_eq_tol(PointShearModulus(&rubber, 0), PointShearModulus(&solid, 0), 1e-14 * size);
    if (sample % 8 == 4 && DIM == 3) /* J^(-2/3) tr(b)/3 */
      ck_assert_double_eq_tol(PointShearModulus(&solid, 0), mu * (2. * 1.69 + 1.) / (3. * pow(1.69, 2. / 3.)),
                              1e-14 * size);
  }
}
END_TEST

/* The three terms that Ogden fitted to Treloar's rubber, at stretches 1.4, 0.9 and (in 3D) 0.9 by the printed formula */
START_TEST(test_ogden_values)
{
  const double terms[3][2] = {{-2., -10e3}, {1.3, 630e3}, {5., 1200.}}, k = 5e6;
  const double lambda[3] = {1.4, 0.9, DIM == 2 ? 1. : 0.9}, J = 1.4 * 0.9 * lambda[2];
  Point        point;
  double       F[DIM2] = {0.}, tau[SYM], expected[3];

  RandomSeed(72);
  PointCreate(LawFind("ogden"), 0, &point);
  SetTerms(&point, 3, terms);
  PointSet(&point, "nu", 0.5);
  PointSet(&point, "bulk_modulus", k);
  for (int a = 0; a < DIM; ++a) F[a * (DIM + 1)] = lambda[a];
  for (int a = 0; a < 3; ++a) {
    expected[a] = 0.5 * k * (J * J - 1.);
    for (int i = 0; i < 3; ++i) {
      double sum = 0.;

      for (int b = 0; b < 3; ++b) sum += pow(lambda[b] / cbrt(J), terms[i][0]) / 3.;
      expected[a] += terms[i][1] * (pow(lambda[a] / cbrt(J), terms[i][0]) - sum);
    }
  }
  ck_assert_int_eq(PointEvaluate(&point, PLAIN, F, tau, NULL), 0);
  ck_assert_double_le(MaxDifference(3, tau, expected), 1e-8);
  ck_assert_double_eq(tau[3], 0.);
}
END_TEST

/* At rest Hooke's law, with the shear modulus of all terms, of either sign */
START_TEST(test_ogden_at_rest)
{
  const double terms[3][2] = {{-2., -10e3}, {1.3, 630e3}, {5., 1200.}}, mu = 0.5 * (20e3 + 819e3 + 6e3), nu = 0.4;
  Point        point;
  double       I[DIM2], tau[SYM], dtau[SYM * DIM2];

  RandomSeed(73);
  PointCreate(LawFind("ogden"), 0, &point);
  SetTerms(&point, 3, terms);
  PointSet(&point, "nu", nu);
  PointSet(&point, "bulk_modulus", HUGE_VAL);
  Identity(I);
  ck_assert_int_eq(PointEvaluate(&point, ALL_DIRECTIONS, I, tau, dtau), 0);
  ck_assert_double_eq(MaxNorm(SYM, tau), 0.);
  for (int c = 0; c < DIM2; ++c) {
    double H[DIM2] = {0.}, hooke[SYM], column[SYM];

    H[c] = 1.;
    Hooke(2. * mu * (1. + nu), nu, H, hooke);
    for (int i = 0; i < SYM; ++i) column[i] = dtau[i * DIM2 + c];
    ck_assert_double_le(MaxDifference(SYM, column, hooke), 1e-14 * PointStiffness(&point));
  }
}
END_TEST

/* What is refused, and with which parameter named; -1: none */
START_TEST(test_ogden_check)
{
  const struct {
    double      alpha, mu, nu, bulk;
    const char *named;
  } cases[] = {{2., 1e5, 0.4, HUGE_VAL, NULL}, {2., 1e5, 0.5, 1e7, NULL},     {0., 1e5, 0.4, HUGE_VAL, ""},
               {2., -1e5, 0.4, HUGE_VAL, ""},  {-2., 1e5, 0.4, HUGE_VAL, ""}, {2., 1e5, 0.5, HUGE_VAL, "nu"},
               {2., 1e5, -1., HUGE_VAL, "nu"}, {2., 1e5, 0.4, 1e7, "nu"}};

  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    const double terms[1][2] = {{cases[k].alpha, cases[k].mu}};
    MpmLawTable  table[MAX_PARAMETERS];
    MpmLawFault  fault;
    Point        point;

    RandomSeed(74);
    PointCreate(LawFind("ogden"), 0, &point);
    SetTerms(&point, 1, terms);
    PointSet(&point, "nu", cases[k].nu);
    PointSet(&point, "bulk_modulus", cases[k].bulk);
    PointInput(&point, NULL, table);
    ck_assert_int_eq(point.law->info[PLAIN].check(point.parameter, table, &fault), cases[k].named == NULL);
    if (cases[k].named) ck_assert_int_eq(fault.parameter, LawParameter(point.law, cases[k].named));
  }
}
END_TEST

TCase *PotentialCase(void)
{
  TCase *tcase = tcase_create("potentials");

  tcase_add_loop_test(tcase, test_j2_potential, 0, 2);
  tcase_add_loop_test(tcase, test_j2_monotone, 0, 2);
  tcase_add_loop_test(tcase, test_neo_hookean_potential, 0, 4);
  tcase_add_loop_test(tcase, test_ogden_potential, 0, 2);
  tcase_add_test(tcase, test_ogden_is_neo_hookean);
  tcase_add_test(tcase, test_ogden_values);
  tcase_add_test(tcase, test_ogden_at_rest);
  tcase_add_test(tcase, test_ogden_check);
  return tcase;
}
