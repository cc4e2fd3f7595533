/* dual.h, tensor.h and implicit.h: arithmetic against closed forms, isotropic functions against each other, identities
   and differences. */
#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DIM  MPM_DIM
#define DIM2 (MPM_DIM * MPM_DIM)
#define SYM  (MPM_DIM == 2 ? 4 : 6)

#define JOIN3(name, dim, directions) name##_##dim##d_##directions
#define JOIN2(name, dim, directions) JOIN3(name, dim, directions)
#define PLAIN(name)                  JOIN2(name, MPM_DIM, 0)
#define ONE(name)                    JOIN2(name, MPM_DIM, 1)
#if MPM_DIM == 2
#define ALL(name) JOIN2(name, 2, 4)
#else
#define ALL(name) JOIN2(name, 3, 9)
#endif

#define DECLARE(AT) \
  int    AT(TestSymFunction)(int which, const double *A, double *f, double *df); \
  int    AT(TestStretchDiagonal)(const double *F, double *diagonal); \
  int    AT(TestStretchDiagonalQuick)(const double *F, double *diagonal); \
  double AT(TestPrincipalValues)(const double *A, double w[3]); \
  double AT(TestAlgebra)(const double *A, const double *B, double *product, double *inverse, double *stress); \
  double AT(TestScalar)(int which, double x, double *derivative); \
  int    AT(TestImplicit)(int which, const double *in, double from, double to, double *x, double *dx);
DECLARE(PLAIN)
DECLARE(ONE)
DECLARE(ALL)

enum { LOG, EXP, SQRT, BY_PRINCIPAL_VALUES, DIRECT };

static unsigned long long random_state;

static double Uniform(double lower, double upper)
{
  random_state = random_state * 6364136223846793005ULL + 1442695040888963407ULL;
  return lower + (upper - lower) * (double)(random_state >> 11) * 0x1p-53;
}

static int SymAt(int i, int j)
{
  static const int at[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

  return at[i][j];
}

static void ExpectNear(const char *what, int n, const double *got, const double *expected, double tolerance)
{
  for (int i = 0; i < n; ++i)
    ck_assert_msg(fabs(got[i] - expected[i]) <= tolerance, "%s, entry %d: %.17g, expected %.17g within %.1e", what, i,
                  got[i], expected[i], tolerance);
}

/* R: one rotation about each axis (in plane strain about z), 3 x 3 */
static void Rotation(double R[9])
{
  for (int i = 0; i < 9; ++i) R[i] = i % 4 == 0;
  for (int axis = 0; axis < (DIM == 2 ? 1 : 3); ++axis) {
    const int    p = axis, q = (axis + 1) % 3;
    const double angle = Uniform(-3., 3.), c = cos(angle), s = sin(angle);

    for (int j = 0; j < 3; ++j) {
      const double rp = R[3 * p + j], rq = R[3 * q + j];

      R[3 * p + j] = c * rp - s * rq;
      R[3 * q + j] = s * rp + c * rq;
    }
  }
}

/* R diag(w) R^T */
static void FromPrincipal(const double R[9], const double w[3], double *A)
{
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      if (SymAt(i, j) >= SYM) continue;
      A[SymAt(i, j)] = 0.;
      for (int a = 0; a < 3; ++a) A[SymAt(i, j)] += R[3 * i + a] * w[a] * R[3 * j + a];
    }
  }
}

static double Apply(int which, double x)
{
  return which == LOG ? log(x) : which == EXP ? exp(x) : sqrt(x);
}

static double Slope(int which, double x)
{
  return which == LOG ? 1. / x : which == EXP ? exp(x) : 0.5 / sqrt(x);
}

/* (f(a) - f(b))/(a - b) in long double, by the mean of f' (Gauss, 3 points) where the difference would lose digits */
static double Divided(int which, double a, double b)
{
  const double gauss = sqrt(0.6) * 0.5 * (a - b), middle = 0.5 * (a + b);

  if (fabs(a - b) < 2e-3 * fabs(a + b))
    return (5. * Slope(which, middle - gauss) + 8. * Slope(which, middle) + 5. * Slope(which, middle + gauss)) / 18.;
  if (which == LOG) return (double)((logl(a) - logl(b)) / ((long double)a - b));
  if (which == EXP) return (double)((expl(a) - expl(b)) / ((long double)a - b));
  return (double)((sqrtl(a) - sqrtl(b)) / ((long double)a - b));
}

/* Value and derivative from known principal values and directions, by the theorem of Daleckii and Krein in index
   notation */
static void Reference(int which, const double R[9], const double w[3], double *f, double *df)
{
  double values[3];

  for (int a = 0; a < 3; ++a) values[a] = Apply(which, w[a]);
  FromPrincipal(R, values, f);
  memset(df, 0, SYM * SYM * sizeof(double));
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) { /* (k, l) and (l, k) both add to the stored component's column */
          if (SymAt(i, j) >= SYM || SymAt(k, l) >= SYM) continue;
          for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
              df[SymAt(i, j) * SYM + SymAt(k, l)] += (a == b ? Slope(which, w[a]) : Divided(which, w[a], w[b])) *
                                                     R[3 * i + a] * R[3 * k + a] * R[3 * l + b] * R[3 * j + b];
        }
      }
    }
  }
}

static void CheckFunction(int which, const double R[9], const double w[3], double tolerance)
{
  double A[SYM], f[SYM], df[SYM * SYM], plain[SYM], one[SYM], one_df[SYM * SYM], expected[SYM], expected_df[SYM * SYM];
  double scale = 1.;

  FromPrincipal(R, w, A);
  Reference(which, R, w, expected, expected_df);
  for (int a = 0; a < 3; ++a) scale = fmax(scale, Apply(which, w[a]));
  ck_assert_int_eq(ALL(TestSymFunction)(which, A, f, df), 0);
  ck_assert_int_eq(ONE(TestSymFunction)(which, A, one, one_df), 0);
  ck_assert_int_eq(PLAIN(TestSymFunction)(which, A, plain, NULL), 0);
  ExpectNear("value", SYM, f, expected, tolerance * scale);
  ExpectNear("derivative", SYM * SYM, df, expected_df, tolerance * scale);
  ExpectNear("plain value", SYM, plain, f, 0.1 * tolerance * scale);
  ExpectNear("derivative by one direction", SYM * SYM, one_df, df, 0.1 * tolerance * scale);
}

/* Principal values that are well apart, equal, or apart by anything in between, turned and not */
START_TEST(test_isotropic_functions)
{
  random_state = 1;
  for (int sample = 0; sample < 400; ++sample) {
    const double gap = sample % 4 == 3 ? 0. : pow(10., Uniform(-17., 0.5)), other = pow(10., Uniform(-17., 0.5));
    const double m    = Uniform(0.5, 2.);
    double       w[3] = {m, m * (1. + gap), m * (1. + (sample % 3 ? other : gap))}, R[9];

    for (int i = 0; i < 9; ++i) R[i] = i % 4 == 0;
    if (sample % 5) Rotation(R);
    CheckFunction(_i, R, w, 1e-14);
  }
}
END_TEST

/* Near the identity the error must be a few roundings of 1, not of something larger; at it there is none. */
START_TEST(test_logarithm_near_identity)
{
  const double one[3] = {1., 1., 1.}, identity[9] = {1., 0., 0., 0., 1., 0., 0., 0., 1.}, zero[SYM] = {0.};
  double       A[SYM], f[SYM], df[SYM * SYM];

  FromPrincipal(identity, one, A);
  ck_assert_int_eq(ALL(TestSymFunction)(LOG, A, f, df), 0);
  ExpectNear("ln I", SYM, f, zero, 0.);
  random_state = 2;
  for (int sample = 0; sample < 100; ++sample) {
    double w[3], R[9];

    Rotation(R);
    for (int a = 0; a < 3; ++a) w[a] = 1. + 1e-12 * Uniform(-1., 1.);
    CheckFunction(LOG, R, w, 3e-15);
  }
}
END_TEST

/* exp(ln A) = A and (A^1/2)^2 = A, the derivatives inverse to each other, for principal values over 8 orders of
   magnitude */
START_TEST(test_inverse_functions)
{
  random_state = 3;
  for (int sample = 0; sample < 200; ++sample) {
    double w[3], R[9], A[SYM], f[SYM], df[SYM * SYM], back[SYM], back_df[SYM * SYM], scale;

    Rotation(R);
    for (int a = 0; a < 3; ++a) w[a] = pow(10., sample % 2 ? Uniform(-4., 4.) : Uniform(-0.1, 0.1));
    FromPrincipal(R, w, A);
    scale = fmax(w[0], fmax(w[1], w[2]));
    ck_assert_int_eq(ALL(TestSymFunction)(LOG, A, f, df), 0);
    ck_assert_int_eq(ALL(TestSymFunction)(EXP, f, back, back_df), 0);
    ExpectNear("exp ln A", SYM, back, A, 1e-13 * scale * (1. + fabs(log(scale))));
    if (sample % 2) continue;
    for (int i = 0; i < SYM; ++i) {
      for (int j = 0; j < SYM; ++j) {
        double sum = 0.;

        for (int k = 0; k < SYM; ++k) sum += back_df[i * SYM + k] * df[k * SYM + j];
        ck_assert_double_eq_tol(sum, i == j, 1e-14);
      }
    }
    ck_assert_int_eq(PLAIN(TestSymFunction)(SQRT, A, f, NULL), 0);
    for (int i = 0; i < 3; ++i) {
      double square = i == 2 && DIM == 2 ? f[2] * f[2] : 0.;

      for (int k = 0; k < DIM && i < DIM; ++k) square += f[SymAt(i, k)] * f[SymAt(i, k)];
      ck_assert_double_eq_tol(square, A[i], 1e-14 * scale);
    }
  }
}
END_TEST

START_TEST(test_not_positive_definite)
{
  const double wrong[] = {0., -1e-3, NAN, HUGE_VAL, -HUGE_VAL};

  for (int entry = 0; entry < 3; ++entry) {
    for (int k = 0; k < 5; ++k) {
      double A[SYM] = {1., 1., 1.}, f[SYM], df[SYM * SYM];

      A[entry] = wrong[k];
      for (int which = LOG; which <= SQRT; which += SQRT - LOG) {
        ck_assert_msg(ALL(TestSymFunction)(which, A, f, df), "function %d accepts %g", which, wrong[k]);
        ck_assert_msg(PLAIN(TestSymFunction)(which, A, f, NULL), "function %d accepts %g", which, wrong[k]);
      }
      A[entry] = 1e4;
      ck_assert_msg(ALL(TestSymFunction)(EXP, A, f, df), "exp accepts overflow in %d", entry);
      A[entry] = NAN;
      ck_assert_msg(ALL(TestSymFunction)(EXP, A, f, df), "exp accepts NaN in %d", entry);
      A[0] = A[1] = -1.;
      A[2]        = 1.;
      ck_assert_msg(ALL(TestSymFunction)(LOG, A, f, df), "ln accepts two negative principal values");
      ck_assert_msg(ALL(TestSymFunction)(SQRT, A, f, df), "the root accepts two negative principal values");
      A[0] = A[1] = 1.;
      A[3]        = 2.;
      ck_assert_msg(ALL(TestSymFunction)(LOG, A, f, df), "ln accepts a negative principal value");
    }
  }
}
END_TEST

/* A function by its principal values against the same one without them; strains, of either sign, with principal values
   apart by anything down to rounding, on a large mean too */
START_TEST(test_isotropic_by_principal_values)
{
  random_state = 6;
  for (int sample = 0; sample < 1000; ++sample) {
    const double gap = sample % 4 == 3 ? 0. : pow(10., Uniform(-17., -0.5)), other = pow(10., Uniform(-17., -0.5));
    const double m = sample % 3 ? Uniform(-0.5, 0.5) : 0., z = m + (sample % 2 ? other : gap);
    const double w[3] = {m, m + gap, z};
    double       R[9], A[SYM], values[3], f[2][SYM], df[2][SYM * SYM], one[SYM], one_df[SYM * SYM], plain[SYM];

    for (int i = 0; i < 9; ++i) R[i] = i % 4 == 0;
    if (sample % 5) Rotation(R);
    FromPrincipal(R, w, A);
    for (int k = 0; k < 2; ++k) ck_assert_int_eq(ALL(TestSymFunction)(BY_PRINCIPAL_VALUES + k, A, f[k], df[k]), 0);
    ck_assert_int_eq(ONE(TestSymFunction)(BY_PRINCIPAL_VALUES, A, one, one_df), 0);
    ck_assert_int_eq(PLAIN(TestSymFunction)(BY_PRINCIPAL_VALUES, A, plain, NULL), 0);
    ExpectNear("value", SYM, f[0], f[1], 1e-14);
    ExpectNear("derivative", SYM * SYM, df[0], df[1], 2e-10);
    ExpectNear("plain value", SYM, plain, f[0], 1e-15);
    ExpectNear("value with one direction", SYM, one, f[0], 1e-15);
    ExpectNear("derivative by one direction", SYM * SYM, one_df, df[0], 1e-14);
    ck_assert_double_le(PLAIN(TestPrincipalValues)(A, values), DIM == 2 ? 1e-15 : 1e-7);
    ck_assert(values[0] >= values[1] && values[1] >= values[2]);
  }
}
END_TEST

/* By a series or by principal axes, on either side of where the one ends, the stretch is the same. */
START_TEST(test_stretch_diagonal_quick)
{
  double F[DIM2], expected[DIM], diagonal[DIM];

  random_state = 5;
  for (int sample = 0; sample < 200; ++sample) {
    const double size = pow(10., -0.05 * sample);

    for (int i = 0; i < DIM2; ++i) F[i] = 1.7 * ((i % (DIM + 1) == 0) + size * Uniform(-0.5, 0.5));
    ck_assert_int_eq(PLAIN(TestStretchDiagonal)(F, expected), 0);
    ck_assert_int_eq(PLAIN(TestStretchDiagonalQuick)(F, diagonal), 0);
    ExpectNear("quick", DIM, diagonal, expected, 4e-15);
  }
  for (int i = 0; i < DIM; ++i) F[i] = 0.;
  ck_assert(PLAIN(TestStretchDiagonalQuick)(F, diagonal));
  F[0] = NAN;
  ck_assert(PLAIN(TestStretchDiagonalQuick)(F, diagonal));
}
END_TEST

/* U of a simple shear, and of a rotated stretch */
START_TEST(test_stretch_diagonal)
{
  const double expected[3] = {0.9701425, 1.0914103, 1.};
  double       F[DIM2], diagonal[DIM];

  for (int i = 0; i < DIM2; ++i) F[i] = i % (DIM + 1) == 0;
  F[1] = 0.5;
  ck_assert_int_eq(PLAIN(TestStretchDiagonal)(F, diagonal), 0);
  ExpectNear("simple shear", DIM, diagonal, expected, 5e-8);
  random_state = 4;
  for (int sample = 0; sample < 20; ++sample) {
    const double w[3] = {1.3, 0.6, sample % 2 ? 0.6 : 2.};
    double       R[9], V[9], U[SYM];

    Rotation(R);
    Rotation(V);
    FromPrincipal(V, w, U);
    for (int i = 0; i < DIM; ++i) {
      for (int j = 0; j < DIM; ++j) {
        F[i * DIM + j] = 0.;
        for (int k = 0; k < DIM; ++k) F[i * DIM + j] += R[3 * i + k] * U[SymAt(k, j)];
      }
    }
    ck_assert_int_eq(ALL(TestStretchDiagonal)(F, diagonal), 0);
    ExpectNear("R U", DIM, diagonal, U, 1e-14);
  }
  for (int i = 0; i < DIM; ++i) F[i] = 0.;
  ck_assert(PLAIN(TestStretchDiagonal)(F, diagonal));
  F[0] = NAN;
  ck_assert(PLAIN(TestStretchDiagonal)(F, diagonal));
}
END_TEST

/* A A^{-1} = I, (A A^T) B^{-T} B^T = A A^T; along dA = A these are of degree 1, -1, 2 in A, det A of degree DIM. */
START_TEST(test_algebra)
{
  random_state = 5;
  for (int sample = 0; sample < 20; ++sample) {
    const double degree[3] = {1., -1., 2.};
    double       A[DIM2], B[DIM2], value[3][DIM2], derivative[3][DIM2], det;

    for (int i = 0; i < DIM2; ++i) A[i] = (i % (DIM + 1) == 0) + 0.3 * Uniform(-1., 1.);
    for (int i = 0; i < DIM2; ++i) B[i] = (i % (DIM + 1) == 0) + 0.3 * Uniform(-1., 1.);
    det = PLAIN(TestAlgebra)(A, B, value[0], value[1], value[2]);
    for (int i = 0; i < DIM; ++i) {
      for (int j = 0; j < DIM; ++j) {
        double product = 0., unit = 0., push = 0., b = 0.;

        for (int k = 0; k < DIM; ++k) {
          product += A[i * DIM + k] * B[k * DIM + j];
          unit += A[i * DIM + k] * value[1][k * DIM + j];
          push += value[2][i * DIM + k] * B[j * DIM + k];
          b += A[i * DIM + k] * A[j * DIM + k];
        }
        ck_assert_double_eq_tol(value[0][i * DIM + j], product, 1e-14);
        ck_assert_double_eq_tol(unit, i == j, 1e-14);
        ck_assert_double_eq_tol(push, b, 1e-14);
      }
    }
    ck_assert_double_eq_tol(ONE(TestAlgebra)(A, B, derivative[0], derivative[1], derivative[2]), DIM * det, 1e-14);
    for (int t = 0; t < 3; ++t)
      for (int i = 0; i < DIM2; ++i) ck_assert_double_eq_tol(derivative[t][i], degree[t] * value[t][i], 3e-14);
    ck_assert_double_eq_tol(ALL(TestAlgebra)(A, B, derivative[0], derivative[1], derivative[2]), DIM * det, 1e-14);
    for (int t = 0; t < 3; ++t)
      for (int i = 0; i < DIM2; ++i) ck_assert_double_eq_tol(derivative[t][i], degree[t] * value[t][i], 3e-14);
  }
}
END_TEST

START_TEST(test_scalar)
{
  const double x    = 0.7;
  const double f[]  = {x * x + 3. * x, (x - 1.) / (x + 2.), exp(0.5 * x), 2.5 * log(x), -log(1. + x * x), x * x - x};
  const double fx[] = {2. * x + 3., 3. / ((x + 2.) * (x + 2.)), 0.5 * exp(0.5 * x),
                       2.5 / x,     -2. * x / (1. + x * x),     2. * x - 1.};

  for (int which = 0; which < 6; ++which) {
    double derivative;

    ck_assert_double_eq_tol(PLAIN(TestScalar)(which, x, &derivative), f[which], 1e-15);
    ck_assert_double_eq_tol(ONE(TestScalar)(which, x, &derivative), f[which], 1e-15);
    ck_assert_double_eq_tol(derivative, fx[which], 2e-15);
    ck_assert_double_eq_tol(ALL(TestScalar)(which, x, &derivative), f[which], 1e-15);
    ck_assert_double_eq_tol(derivative, fx[which], 2e-15);
  }
}
END_TEST

/* The root is that of the equation, its derivatives those of the closed form, in all forms alike; from bad starts. */
START_TEST(test_implicit_bracket)
{
  random_state = 7;
  for (int sample = 0; sample < 200; ++sample) {
    const double root = (sample % 2 ? 1. : -1.) * pow(10., Uniform(-6., 2.)), a = pow(10., Uniform(-3., 3.));
    const double in[2] = {a, root * (1. + a * root * root)}, slope = 1. + 3. * a * root * root;
    double       x[3], one, dx[2], expected[2];

    expected[0] = -root * root * root / slope;
    expected[1] = 1. / slope;
    ck_assert_int_eq(ALL(TestImplicit)(0, in, -1e3, 2e3, x, dx), 0);
    ck_assert_double_eq_tol(x[0], root, 1e-13 * fabs(root) + 1e-15);
    ExpectNear("derivative of the root", 2, dx, expected, 1e-12 * fmax(1., fabs(expected[0])));
    one = x[0];
    ck_assert_int_eq(PLAIN(TestImplicit)(0, in, -1e3, 2e3, x, dx), 0);
    ck_assert_double_eq_tol(x[0], one, 1e-15 * fabs(one));
  }
}
END_TEST

/* From starts far off, with steps into the forbidden; derivatives from the equations */
START_TEST(test_implicit_system)
{
  random_state = 8;
  for (int sample = 0; sample < 200; ++sample) {
    const double b = Uniform(-1., 3.), c = Uniform(0.1, 3.), z = Uniform(-3., 3.), x0 = z + c * exp(z);
    const double in[2] = {x0 * x0 * x0 + x0 + 0.5 * b * x0, b}, slope = 3. * x0 * x0 + 1. + 0.5 * b;
    double       x[3], dx[6], expected[3] = {x0, b * x0, z}, expected_dx[6];

    for (int k = 0; k < 2; ++k) {
      expected_dx[k]     = (k ? -0.5 * x0 : 1.) / slope;
      expected_dx[2 + k] = b * expected_dx[k] + (k ? x0 : 0.);
      expected_dx[4 + k] = expected_dx[k] / (1. + c * exp(z));
    }
    ck_assert_int_eq(ONE(TestImplicit)(1, in, Uniform(-20., 6.), c, x, dx), 0);
    ExpectNear("roots", 3, x, expected, 1e-12 * (1. + fabs(x0)));
    ExpectNear("derivatives of the roots", 6, dx, expected_dx, 1e-11 * (1. + fabs(x0)));
  }
  {
    const double nowhere[2] = {NAN, 1.}, beyond[2] = {1e9, 1.};
    double       x[3], dx[6];

    ck_assert_msg(ONE(TestImplicit)(1, nowhere, 1., 1., x, dx) != 0, "NaN is accepted");
    ck_assert_msg(ONE(TestImplicit)(1, beyond, 1., 1., x, dx) != 0, "a root where r is none");
  }
}
END_TEST

int main(void)
{
  Suite   *suite  = suite_create(DIM == 2 ? "tensors in plane strain" : "tensors in 3D");
  TCase   *tcase  = tcase_create("tensor");
  SRunner *runner = srunner_create(suite);
  int      failed;

  tcase_add_loop_test(tcase, test_isotropic_functions, LOG, SQRT + 1);
  tcase_add_test(tcase, test_logarithm_near_identity);
  tcase_add_test(tcase, test_inverse_functions);
  tcase_add_test(tcase, test_not_positive_definite);
  tcase_add_test(tcase, test_isotropic_by_principal_values);
  tcase_add_test(tcase, test_stretch_diagonal);
  tcase_add_test(tcase, test_stretch_diagonal_quick);
  tcase_add_test(tcase, test_algebra);
  tcase_add_test(tcase, test_scalar);
  tcase_add_test(tcase, test_implicit_bracket);
  tcase_add_test(tcase, test_implicit_system);
  suite_add_tcase(suite, tcase);
  srunner_set_fork_status(runner, CK_NOFORK);
  srunner_run_all(runner, CK_NORMAL);
  failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
