#pragma once
/*
  Scalar: the number type of the pointwise kernels.

  With MPM_DIRECTIONS == 0 a Scalar is a double. Otherwise it is a dual number a + sum_k a_k e_k with e_j e_k = 0,
  which carries the derivatives of everything computed from it in MPM_DIRECTIONS directions at once (forward-mode
  automatic differentiation, Griewank and Walther 2008, doi:10.1137/1.9780898717761). The number of directions is known
  at compile time, so the loops over them are vectorised.

  Real is the type of what does not depend on the step's increment: parameters, history and deformation gradient at the
  step's start, and what follows from them. It is a plain double, but for one instance of every law that differentiates
  by them, MPM_SENSITIVITY: there Real and Scalar are one type, real.h says which. The operators + - * / work on it in
  either case, functions are RealSqrt(), RealSin(), ..., and branches must test RealValue().

  Only what stands between #if and #endif knows how a Scalar is stored; all else is built on ScalarChain() and
  ScalarChain2(), the chain rule for one and two arguments. Branches must test ScalarValue(): a dual number follows the
  branch that its value takes.
*/
#include <math.h>
#include "dense.h"
#include "real.h"

#if !defined(MPM_DIRECTIONS)
#error "MPM_DIRECTIONS is not set"
#endif

#if defined(MPM_SENSITIVITY)

typedef Real Scalar;

MPM_FN double ScalarValue(Scalar a)
{
  return RealValue(a);
}

MPM_FN Real ScalarReal(Scalar a)
{
  return a;
}

MPM_FN double ScalarDirection(Scalar a, int k)
{
  (void)k;
  return RealDirection(a);
}

MPM_FN Scalar ScalarConstant(Real value)
{
  return value;
}

MPM_FN Scalar ScalarSeed(double value, int direction)
{
  (void)direction;
  return RealAlong(value, 1.);
}

MPM_FN Scalar ScalarChain(Scalar a, double f, double fa)
{
  return RealChain(a, f, fa);
}

MPM_FN Scalar ScalarChain2(Scalar a, Scalar b, double f, double fa, double fb)
{
  return RealAlong(f, fa * RealDirection(a) + fb * RealDirection(b));
}

MPM_FN Scalar ScalarAdd(Scalar a, Scalar b)
{
  return a + b;
}

MPM_FN Scalar ScalarSub(Scalar a, Scalar b)
{
  return a - b;
}

/* Not a * b: where a value is 0, the square of the step would stand in its place. */
MPM_FN Scalar ScalarMul(Scalar a, Scalar b)
{
  return ScalarChain2(a, b, ScalarValue(a) * ScalarValue(b), ScalarValue(b), ScalarValue(a));
}

/* alpha a */
MPM_FN Scalar ScalarScale(Real alpha, Scalar a)
{
  return ScalarMul(alpha, a);
}

MPM_FN Scalar ScalarSquare(Scalar a)
{
  return ScalarMul(a, a);
}

/* sum += alpha a */
MPM_FN void ScalarAddScaled(Scalar *sum, Real alpha, const Scalar *a)
{
  *sum += ScalarMul(alpha, *a);
}

/* sum += a b */
MPM_FN void ScalarAddProduct(Scalar *sum, const Scalar *a, const Scalar *b)
{
  *sum += ScalarMul(*a, *b);
}

/* Adds alpha times the derivatives of a to those of sum, whose value stays. */
MPM_FN void ScalarAddDirections(Scalar *sum, double alpha, const Scalar *a)
{
  *sum = RealAlong(RealValue(*sum), RealDirection(*sum) + alpha * RealDirection(*a));
}

#elif MPM_DIRECTIONS == 0

typedef double Scalar;

MPM_FN double ScalarValue(Scalar a)
{
  return a;
}

MPM_FN Real ScalarReal(Scalar a)
{
  return a;
}

MPM_FN double ScalarDirection(Scalar a, int k)
{
  (void)a;
  (void)k;
  return 0.;
}

MPM_FN Scalar ScalarConstant(double value)
{
  return value;
}

MPM_FN Scalar ScalarSeed(double value, int direction)
{
  (void)direction;
  return value;
}

MPM_FN Scalar ScalarChain(Scalar a, double f, double fa)
{
  (void)a;
  (void)fa;
  return f;
}

MPM_FN Scalar ScalarChain2(Scalar a, Scalar b, double f, double fa, double fb)
{
  (void)a;
  (void)b;
  (void)fa;
  (void)fb;
  return f;
}

MPM_FN void ScalarAddScaled(Scalar *sum, double alpha, const Scalar *a)
{
  *sum += alpha * *a;
}

MPM_FN void ScalarAddProduct(Scalar *sum, const Scalar *a, const Scalar *b)
{
  *sum += *a * *b;
}

MPM_FN void ScalarAddDirections(Scalar *sum, double alpha, const Scalar *a)
{
  (void)sum;
  (void)alpha;
  (void)a;
}

#else

/*
  Derivatives are kept in lanes of four where the machine has registers for that: gcc leaves arrays of plain doubles in
  memory, which makes the same source about twice as slow. The lanes behind the last direction hold numbers that nobody
  reads. aligned(8): a Scalar may lie wherever a double may.
*/
#if defined(__AVX__) && defined(__GNUC__) && !defined(__CUDACC__) && MPM_DIRECTIONS > 2
#define MPM_LANE 4
typedef double ScalarLane __attribute__((vector_size(8 * MPM_LANE), aligned(8)));
#else
#define MPM_LANE 1
typedef double ScalarLane;
#endif
#define MPM_LANES ((MPM_DIRECTIONS + MPM_LANE - 1) / MPM_LANE)

#if defined(__GNUC__) && !defined(__CUDACC__)
#define MPM_FOR_LANES(k) _Pragma("GCC unroll 8") for (int k = 0; k < MPM_LANES; ++k)
#else
#define MPM_FOR_LANES(k) for (int k = 0; k < MPM_LANES; ++k)
#endif

typedef struct {
  ScalarLane d[MPM_LANES]; /* derivatives */
  ScalarLane v;            /* value, in all lanes: it multiplies derivatives */
} Scalar;

/* The same number in all lanes. */
MPM_FN ScalarLane ScalarSplat(double value)
{
#if MPM_LANE == 1
  return value;
#else
  const ScalarLane lane = {value, value, value, value};

  return lane;
#endif
}

MPM_FN double ScalarValue(Scalar a)
{
#if MPM_LANE == 1
  return a.v;
#else
  return a.v[0];
#endif
}

/* What is kept of a Scalar for the next step: history. */
MPM_FN Real ScalarReal(Scalar a)
{
  return ScalarValue(a);
}

/* The derivative in direction k. */
MPM_FN double ScalarDirection(Scalar a, int k)
{
#if MPM_LANE == 1
  return a.d[k];
#else
  return a.d[k / MPM_LANE][k % MPM_LANE];
#endif
}

MPM_FN Scalar ScalarConstant(double value)
{
  const ScalarLane zero = {0.};
  Scalar           c;

  c.v                     = ScalarSplat(value);
  MPM_FOR_LANES(k) c.d[k] = zero;
  return c;
}

/* An independent variable: derivative 1 in the given direction. */
MPM_FN Scalar ScalarSeed(double value, int direction)
{
  Scalar c       = ScalarConstant(value);

#if MPM_LANE == 1
  c.d[direction] = 1.;
#else
  c.d[direction / MPM_LANE][direction % MPM_LANE] = 1.;
#endif
  return c;
}

/* f(a), given f and its derivative fa at the value of a. */
MPM_FN Scalar ScalarChain(Scalar a, double f, double fa)
{
  Scalar c;

  c.v                     = ScalarSplat(f);
  MPM_FOR_LANES(k) c.d[k] = fa * a.d[k];
  return c;
}

/* f(a, b), given f and its derivatives fa, fb at the values of a and b. */
MPM_FN Scalar ScalarChain2(Scalar a, Scalar b, double f, double fa, double fb)
{
  Scalar c;

  c.v                     = ScalarSplat(f);
  MPM_FOR_LANES(k) c.d[k] = fa * a.d[k] + fb * b.d[k];
  return c;
}

/* sum += alpha a */
MPM_FN void ScalarAddScaled(Scalar *sum, double alpha, const Scalar *a)
{
  sum->v += alpha * a->v;
  MPM_FOR_LANES(k) sum->d[k] += alpha * a->d[k];
}

/* sum += a b */
MPM_FN void ScalarAddProduct(Scalar *sum, const Scalar *a, const Scalar *b)
{
  const ScalarLane av = a->v, bv = b->v;

  sum->v += av * bv;
  MPM_FOR_LANES(k) sum->d[k] += bv * a->d[k] + av * b->d[k];
}

/* Adds alpha times the derivatives of a to those of sum, whose value stays. */
MPM_FN void ScalarAddDirections(Scalar *sum, double alpha, const Scalar *a)
{
  MPM_FOR_LANES(k) sum->d[k] += alpha * a->d[k];
}

MPM_FN Scalar ScalarAdd(Scalar a, Scalar b)
{
  a.v += b.v;
  MPM_FOR_LANES(k) a.d[k] += b.d[k];
  return a;
}

MPM_FN Scalar ScalarSub(Scalar a, Scalar b)
{
  a.v -= b.v;
  MPM_FOR_LANES(k) a.d[k] -= b.d[k];
  return a;
}

MPM_FN Scalar ScalarMul(Scalar a, Scalar b)
{
  Scalar c;

  c.v                     = a.v * b.v;
  MPM_FOR_LANES(k) c.d[k] = b.v * a.d[k] + a.v * b.d[k];
  return c;
}

/* alpha a */
MPM_FN Scalar ScalarScale(double alpha, Scalar a)
{
  a.v                     = alpha * a.v;
  MPM_FOR_LANES(k) a.d[k] = alpha * a.d[k];
  return a;
}

MPM_FN Scalar ScalarSquare(Scalar a)
{
  const ScalarLane twice = a.v + a.v;

  a.v                     = a.v * a.v;
  MPM_FOR_LANES(k) a.d[k] = twice * a.d[k];
  return a;
}

#endif

#if MPM_DIRECTIONS == 0
MPM_FN Scalar ScalarAdd(Scalar a, Scalar b)
{
  return a + b;
}

MPM_FN Scalar ScalarSub(Scalar a, Scalar b)
{
  return a - b;
}

MPM_FN Scalar ScalarMul(Scalar a, Scalar b)
{
  return a * b;
}

/* alpha a */
MPM_FN Scalar ScalarScale(double alpha, Scalar a)
{
  return alpha * a;
}

MPM_FN Scalar ScalarSquare(Scalar a)
{
  return a * a;
}
#endif

MPM_FN Scalar ScalarDiv(Scalar a, Scalar b)
{
  const double inverse = 1. / ScalarValue(b), f = ScalarValue(a) * inverse; /* one division: they are slow */

  return ScalarChain2(a, b, f, inverse, -f * inverse);
}

/* a + beta */
MPM_FN Scalar ScalarShift(Scalar a, Real beta)
{
#if defined(MPM_SENSITIVITY)
  return a + beta;
#else
  return ScalarChain(a, ScalarValue(a) + beta, 1.);
#endif
}

MPM_FN Scalar ScalarNeg(Scalar a)
{
  return ScalarChain(a, -ScalarValue(a), -1.);
}

/* Has no derivative at 0: test the value first. */
MPM_FN Scalar ScalarSqrt(Scalar a)
{
  const double f = sqrt(ScalarValue(a));

  return ScalarChain(a, f, 0.5 / f);
}

/* The logarithm of one, which plane strain asks for at every point, costs nothing. */
MPM_FN Scalar ScalarLog(Scalar a)
{
  if (ScalarValue(a) == 1.) return ScalarChain(a, 0., 1.);
  return ScalarChain(a, log(ScalarValue(a)), 1. / ScalarValue(a));
}

/* ln(1 + a) without cancellation at small a */
MPM_FN Scalar ScalarLog1p(Scalar a)
{
  return ScalarChain(a, log1p(ScalarValue(a)), 1. / (1. + ScalarValue(a)));
}

MPM_FN Scalar ScalarExp(Scalar a)
{
  const double f = exp(ScalarValue(a));

  return ScalarChain(a, f, f);
}

/* a^p for an exponent that does not depend on the increment, and a > 0 */
MPM_FN Scalar ScalarPow(Scalar a, Real exponent)
{
#if defined(MPM_SENSITIVITY)
  return RealPow(a, exponent);
#else
  const double f = pow(ScalarValue(a), exponent);

  return ScalarChain(a, f, exponent * f / ScalarValue(a));
#endif
}
