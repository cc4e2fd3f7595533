/*
  Plain double access to tensor.h and implicit.h of one instance, so that one test program can hold several. The build
  compiles this file once per instance, as it does the materials.
*/
#include "talus/point/implicit.h"

typedef int (*MPM_INSTANCE(SymFunction))(const Sym *A, Sym *result);

int    MPM_INSTANCE(TestSymFunction)(int which, const double *A, double *f, double *df);
int    MPM_INSTANCE(TestStretchDiagonal)(const double *F, double *diagonal);
int    MPM_INSTANCE(TestStretchDiagonalQuick)(const double *F, double *diagonal);
double MPM_INSTANCE(TestPrincipalValues)(const double *A, double w[3]);
double MPM_INSTANCE(TestAlgebra)(const double *A, const double *B, double *product, double *inverse, double *stress);
double MPM_INSTANCE(TestScalar)(int which, double x, double *derivative);
int    MPM_INSTANCE(TestImplicit)(int which, const double *in, double from, double to, double *x, double *dx);

/* exp(A) tr(A)^2, by principal values and without: the derivatives of the former are not symmetric */
static int IsotropicProduct(const Sym *A, Sym *result)
{
  SymPrincipal principal;
  Dual         w[3], trace;

  if (SymPrincipalCreate(A, &principal)) return 1;
  for (int a = 0; a < 3; ++a) w[a] = DualSeed(principal.value[a], a);
  trace = DualAdd(DualAdd(w[0], w[1]), w[2]);
  for (int a = 0; a < 3; ++a) w[a] = DualMul(DualExp(w[a]), DualSquare(trace));
  *result = SymIsotropic(A, &principal, w);
  return 0;
}

static int DirectProduct(const Sym *A, Sym *result)
{
  if (SymExp(A, result)) return 1;
  *result = SymScale(ScalarSquare(SymTrace(A)), result);
  return 0;
}

/* which: 0 SymLog, 1 SymExp, 2 SymSqrt, 3 IsotropicProduct, 4 DirectProduct; df, MPM_SYM x MPM_SYM row-major, by each
   stored component of A, where the instance has directions */
int MPM_INSTANCE(TestSymFunction)(int which, const double *A, double *f, double *df)
{
  const MPM_INSTANCE(SymFunction) functions[] = {SymLog, SymExp, SymSqrt, IsotropicProduct, DirectProduct};
  const int width                             = MPM_DIRECTIONS > 0 ? MPM_DIRECTIONS : MPM_SYM;

  for (int first = 0; first < MPM_SYM; first += width) {
    Sym argument = SymLoad(A), result;

    for (int k = 0; k < width && first + k < MPM_SYM && MPM_DIRECTIONS > 0; ++k)
      argument.a[first + k] = ScalarSeed(A[first + k], k);
    if (functions[which](&argument, &result)) return 1;
    SymStore(f, &result);
    for (int k = 0; k < width && first + k < MPM_SYM && MPM_DIRECTIONS > 0; ++k)
      for (int i = 0; i < MPM_SYM; ++i) df[i * MPM_SYM + first + k] = ScalarDirection(result.a[i], k);
  }
  return 0;
}

/* Principal values without axes; their error against those with axes, over |A| */
double MPM_INSTANCE(TestPrincipalValues)(const double *A, double w[3])
{
  const Sym    argument = SymLoad(A);
  SymPrincipal principal;
  double       error = 0.;

  SymPrincipalValues(&argument, w);
  if (SymPrincipalCreate(&argument, &principal)) return HUGE_VAL;
  for (int a = 0; a < 3; ++a) error = fmax(error, fabs(w[a] - principal.value[a]));
  return error / SymNormValue(&argument);
}

int MPM_INSTANCE(TestStretchDiagonal)(const double *F, double *diagonal)
{
  return TensorStretchDiagonal(F, diagonal);
}

int MPM_INSTANCE(TestStretchDiagonalQuick)(const double *F, double *diagonal)
{
  return TensorStretchDiagonalQuick(F, diagonal);
}

/* A B, A^{-1}, (A A^T) B^{-T} in plane; returns det A. With directions, their derivatives along dA = A, dB = 0 replace
   the values. */
double MPM_INSTANCE(TestAlgebra)(const double *A, const double *B, double *product, double *inverse, double *stress)
{
  const int    n = MPM_TENSOR;
  Tensor       a = TensorFromArray(A), b = TensorFromArray(B), c[3];
  Sym          symmetric;
  Scalar       det;
  double      *out[3] = {product, inverse, stress};
  const Scalar scale  = ScalarSeed(1., 0);

  a         = TensorScale(scale, &a);
  symmetric = SymLeftCauchyGreen(&a);
  c[0]      = TensorMul(&a, &b);
  c[1]      = TensorInverse(&a);
  c[2]      = SymTimesInverseTranspose(&symmetric, &b, 1.);
  det       = TensorDet(&a);
  for (int t = 0; t < 3; ++t)
    for (int i = 0; i < n; ++i) out[t][i] = MPM_DIRECTIONS > 0 ? ScalarDirection(c[t].a[i], 0) : ScalarValue(c[t].a[i]);
  return MPM_DIRECTIONS > 0 ? ScalarDirection(det, 0) : ScalarValue(det);
}

/* f(x) by the arithmetic of dual.h, and f'(x) where the instance has directions */
double MPM_INSTANCE(TestScalar)(int which, double x, double *derivative)
{
  const Scalar a = ScalarSeed(x, 0), one = ScalarConstant(1.);
  Scalar       f = a;

  switch (which) {
  case 0:
    f = ScalarAdd(ScalarMul(a, a), ScalarScale(3., a));
    break; /* x^2 + 3 x */
  case 1:
    f = ScalarDiv(ScalarSub(a, one), ScalarShift(a, 2.));
    break; /* (x - 1)/(x + 2) */
  case 2:
    f = ScalarSqrt(ScalarExp(a));
    break; /* e^(x/2) */
  case 3:
    f = ScalarLog(ScalarPow(a, 2.5));
    break; /* 2.5 ln x */
  case 4:
    f = ScalarNeg(ScalarLog1p(ScalarSquare(a)));
    break; /* -ln(1 + x^2) */
  default:
    ScalarAddProduct(&f, &a, &a);
    ScalarAddScaled(&f, -2., &a);
    break; /* x^2 - x */
  }
  *derivative = ScalarDirection(f, 0);
  return ScalarValue(f);
}

/* x + a x^3 - b */
static int Cubic(const void *problem, const Dual input[], const Dual x[], Dual r[])
{
  (void)problem;
  r[0] = DualSub(DualAdd(x[0], DualMul(input[0], DualMul(x[0], DualSquare(x[0])))), input[1]);
  return 0;
}

/* x^3 + x + y/2 - a, y - b x, z + c e^z - x; no answer where z is above 6 */
static int Three(const void *problem, const Dual input[], const Dual x[], Dual r[])
{
  const Dual cubic = DualMul(x[0], DualShift(DualSquare(x[0]), 1.));

  r[0] = DualSub(DualAdd(cubic, DualScale(0.5, x[1])), input[0]);
  r[1] = DualSub(x[1], DualMul(input[1], x[0]));
  r[2] = DualSub(DualAdd(x[2], DualScale(*(const double *)problem, DualExp(x[2]))), x[0]);
  return DualValue(x[2]) > 6.;
}

/*
  which: 0 the root of Cubic() between `from` and `to`, 1 the roots of Three() from (from, from, from), problem `to`. x
  holds them; dx, 3 x 2, their derivatives by the inputs, through Scalars where the instance has directions. Non-zero
  where there are none.
*/
int MPM_INSTANCE(TestImplicit)(int which, const double *in, double from, double to, double *x, double *dx)
{
  const double   start[3] = {from, from, from};
  const int      n        = which ? 3 : 1;
  const Dual     input[2] = {DualSeed(in[0], 0), DualSeed(in[1], 1)};
  const Implicit implicit = {which ? Three : Cubic, &to, input, 2, n, 1.};
  Dual           root[3];

  if (which ? ImplicitSystem(&implicit, start, root) : ImplicitBracket(&implicit, from, to, from, root)) return 1;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < 2; ++k) {
      const Scalar scalar[2] = {k == 0 ? ScalarSeed(in[0], 0) : ScalarConstant(in[0]),
                                k == 1 ? ScalarSeed(in[1], 0) : ScalarConstant(in[1])};
      const Scalar result = ScalarFromDual(root[i], 2, scalar);

      x[i]          = ScalarValue(result);
      dx[2 * i + k] = ScalarDirection(result, 0);
    }
  }
  return 0;
}
