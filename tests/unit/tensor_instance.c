/*
  Plain double access to tensor.h of one instance, so that one test program can hold several. The build compiles this
  file once per instance, as it does the materials.
*/
#include "talus/point/law.h"

typedef int (*MPM_INSTANCE(SymFunction))(const Sym *A, Sym *result);

int    MPM_INSTANCE(TestSymFunction)(int which, const double *A, double *f, double *df);
int    MPM_INSTANCE(TestStretchDiagonal)(const double *F, double *diagonal);
double MPM_INSTANCE(TestAlgebra)(const double *A, const double *B, double *product, double *inverse, double *stress);
double MPM_INSTANCE(TestScalar)(int which, double x, double *derivative);

/* which: 0 SymLog, 1 SymExp, 2 SymSqrt; df, MPM_SYM x MPM_SYM row-major, by each stored component of A, where the
   instance has directions */
int MPM_INSTANCE(TestSymFunction)(int which, const double *A, double *f, double *df)
{
  const MPM_INSTANCE(SymFunction) functions[] = {SymLog, SymExp, SymSqrt};
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

int MPM_INSTANCE(TestStretchDiagonal)(const double *F, double *diagonal)
{
  return TensorStretchDiagonal(F, diagonal);
}

/* A B, A^{-1}, (A A^T) B^{-T} in plane; returns det A. With directions, their derivatives along dA = A, dB = 0 replace
   the values. */
double MPM_INSTANCE(TestAlgebra)(const double *A, const double *B, double *product, double *inverse, double *stress)
{
  const int    n = MPM_DIM * MPM_DIM;
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
