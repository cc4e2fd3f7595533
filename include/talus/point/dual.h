#pragma once
/*
  Scalar: the number type of the pointwise kernels.

  With MPM_DIRECTIONS == 0 a Scalar is a double. Otherwise it is a dual number a + sum_k a_k e_k with e_j e_k = 0,
  which carries the derivatives of everything computed from it in MPM_DIRECTIONS directions at once (forward-mode
  automatic differentiation, Griewank and Walther 2008, doi:10.1137/1.9780898717761). The number of directions is known
  at compile time, so the loops over them are vectorised.

  Real is the type of numbers that do not depend on the step's increment: parameters, history and deformation gradient
  at the step's start, and numbers derived from them. A Real is a plain double, but for one instance of every law that
  differentiates by them, MPM_SENSITIVITY: there Real and Scalar are one type (real.h). The operators + - * / work on it
  in either case, functions are RealSqrt(), RealSin(), ..., and branches must test RealValue().

  Only code between #if and #endif, and dual_number.h, knows how a Scalar is stored; all else is built on
  ScalarChain() and ScalarChain2(), the chain rule for one and two arguments. Branches must test ScalarValue(): a dual
  number follows the branch that its value takes.
*/
#include <math.h>
#include "dense.h"
#include "real.h"

/* The type NUMBER of dual_number.h and dual_functions.h, and the names of its functions */
#define NUMBER_JOIN2(type, name) type##name
#define NUMBER_JOIN(type, name)  NUMBER_JOIN2(type, name)
#define NUMBER_(name)            NUMBER_JOIN(NUMBER, name)

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
  return RealDirection(a, k);
}

MPM_FN Scalar ScalarConstant(Real value)
{
  return value;
}

MPM_FN Scalar ScalarSeed(double value, int direction)
{
  double directions[REAL_DIRECTIONS] = {0.};

  directions[direction] = 1.;
  return RealLoad(value, directions, REAL_DIRECTIONS);
}

MPM_FN Scalar ScalarChain(Scalar a, double f, double fa)
{
  return RealChain(a, f, fa);
}

MPM_FN Scalar ScalarChain2(Scalar a, Scalar b, double f, double fa, double fb)
{
  return RealChain2(a, b, f, fa, fb);
}

MPM_FN Scalar ScalarAdd(Scalar a, Scalar b)
{
  return a + b;
}

MPM_FN Scalar ScalarSub(Scalar a, Scalar b)
{
  return a - b;
}

/* Not a * b: where the value of a complex number is 0, the square of the step would stand in its place. */
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
  *sum = RealChain2(*sum, *a, RealValue(*sum), 1., alpha);
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

#define NUMBER            Scalar
#define NUMBER_DIRECTIONS MPM_DIRECTIONS
#include "dual_number.h"
#undef NUMBER_DIRECTIONS
#undef NUMBER

/* Value of a Scalar as kept for the next step: history. */
MPM_FN Real ScalarReal(Scalar a)
{
  return ScalarValue(a);
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

#define NUMBER Scalar
#include "dual_functions.h"
#undef NUMBER

/* ---- numbers with directions of the law's own choosing ---- */

/*
  Dual: four directions in every form, for functions of at most four numbers of a law, its inputs: principal values,
  invariants, unknowns. The inputs are seeded, DualSeed(ScalarValue(input), k); ScalarFromDual() makes a result a
  function of the inputs as Scalars, by the chain rule. This method is cheaper than carrying all directions of dF along.
  Derivatives by the inputs are numbers, and values are equal in all forms.

  Parameters and history come in as Reals. In the instance that differentiates by them more directions are theirs.
*/
#define MPM_DUAL_INPUTS 4
#if defined(MPM_SENSITIVITY)
#define MPM_DUAL_DIRECTIONS (MPM_DUAL_INPUTS + REAL_DIRECTIONS)
#else
#define MPM_DUAL_DIRECTIONS MPM_DUAL_INPUTS
#endif
#define NUMBER            Dual
#define NUMBER_DIRECTIONS MPM_DUAL_DIRECTIONS
#include "dual_number.h"
#undef NUMBER_DIRECTIONS
#include "dual_functions.h"
#undef NUMBER

/* The value, with its derivative by parameters and history alone */
MPM_FN Real DualReal(Dual a)
{
#if defined(MPM_SENSITIVITY)
  double direction[REAL_DIRECTIONS];

  for (int k = 0; k < REAL_DIRECTIONS; ++k) direction[k] = DualDirection(a, MPM_DUAL_INPUTS + k);
  return RealLoad(DualValue(a), direction, REAL_DIRECTIONS);
#else
  return DualValue(a);
#endif
}

/* A result as a function of the `count` inputs that directions 0, 1, .. of it belong to */
MPM_FN Scalar ScalarFromDual(Dual a, int count, const Scalar input[])
{
  Scalar c = ScalarConstant(DualReal(a));

  for (int k = 0; k < count; ++k) ScalarAddDirections(&c, DualDirection(a, k), &input[k]);
  return c;
}
