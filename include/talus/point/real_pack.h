#pragma once
/*
  Real with derivatives in REAL_DIRECTIONS directions, in C++: a value and its derivatives, forward-mode automatic
  differentiation as in dual_number.h, with + - * / as operators. Included by real.h.
*/
#define REAL_DIRECTIONS 8

#if defined(__AVX512F__) && defined(__GNUC__) && !defined(__CUDACC__)
#define REAL_LANE 8
typedef double RealLane __attribute__((vector_size(8 * REAL_LANE), aligned(8)));
#elif defined(__AVX__) && defined(__GNUC__) && !defined(__CUDACC__)
#define REAL_LANE 4
typedef double RealLane __attribute__((vector_size(8 * REAL_LANE), aligned(8)));
#else
#define REAL_LANE 1
typedef double RealLane;
#endif
#define REAL_LANES (REAL_DIRECTIONS / REAL_LANE)

#if defined(__GNUC__) && !defined(__CUDACC__)
#define REAL_FOR_LANES(k) _Pragma("GCC unroll 8") for (int k = 0; k < REAL_LANES; ++k)
#else
#define REAL_FOR_LANES(k) for (int k = 0; k < REAL_LANES; ++k)
#endif

struct Real {
  RealLane d[REAL_LANES]; /* derivatives */
  double   v;             /* value */

  Real() = default;
  Real(double value) : v(value)
  {
    const RealLane zero = RealLane();

    REAL_FOR_LANES(k) d[k] = zero;
  }
};

MPM_FN double RealValue(const Real &a)
{
  return a.v;
}

/* The derivative in direction k. */
MPM_FN double RealDirection(const Real &a, int k)
{
#if REAL_LANE == 1
  return a.d[k];
#else
  return a.d[k / REAL_LANE][k % REAL_LANE];
#endif
}

/* A value with its derivatives in the first `width` directions. */
MPM_FN Real RealLoad(double value, const double *direction, int width)
{
  double padded[REAL_DIRECTIONS];
  Real   a;

  if (width < REAL_DIRECTIONS) {
    for (int k = 0; k < REAL_DIRECTIONS; ++k) padded[k] = k < width ? direction[k] : 0.;
    direction = padded;
  }
  a.v = value;
  __builtin_memcpy(a.d, direction, sizeof(a.d));
  return a;
}

/* The derivatives of a in the first `width` directions. */
MPM_FN void RealStore(const Real &a, double *direction, int width)
{
  if (width == REAL_DIRECTIONS) __builtin_memcpy(direction, a.d, sizeof(a.d));
  else
    for (int k = 0; k < width; ++k) direction[k] = RealDirection(a, k);
}

/* f(a), given f and its derivative fa at the value of a. */
MPM_FN Real RealChain(const Real &a, double f, double fa)
{
  Real c;

  c.v                      = f;
  REAL_FOR_LANES(k) c.d[k] = fa * a.d[k];
  return c;
}

/* f(a, b), given f and its derivatives fa, fb at the values of a and b. */
MPM_FN Real RealChain2(const Real &a, const Real &b, double f, double fa, double fb)
{
  Real c;

  c.v                      = f;
  REAL_FOR_LANES(k) c.d[k] = fa * a.d[k] + fb * b.d[k];
  return c;
}

/* Whether a is 0, with its derivatives: only then may it be left out. */
MPM_FN int RealVanishes(const Real &a)
{
  int vanishes = a.v == 0.;

  for (int k = 0; k < REAL_DIRECTIONS; ++k) vanishes &= RealDirection(a, k) == 0.;
  return vanishes;
}

MPM_FN Real operator+(Real a, const Real &b)
{
  a.v += b.v;
  REAL_FOR_LANES(k) a.d[k] += b.d[k];
  return a;
}

MPM_FN Real operator+(Real a, double b)
{
  a.v += b;
  return a;
}

MPM_FN Real operator+(double a, Real b)
{
  b.v += a;
  return b;
}

MPM_FN Real operator-(Real a, const Real &b)
{
  a.v -= b.v;
  REAL_FOR_LANES(k) a.d[k] -= b.d[k];
  return a;
}

MPM_FN Real operator-(Real a, double b)
{
  a.v -= b;
  return a;
}

MPM_FN Real operator-(double a, const Real &b)
{
  return RealChain(b, a - b.v, -1.);
}

MPM_FN Real operator-(const Real &a)
{
  return RealChain(a, -a.v, -1.);
}

MPM_FN Real operator+(const Real &a)
{
  return a;
}

MPM_FN Real operator*(const Real &a, const Real &b)
{
  return RealChain2(a, b, a.v * b.v, b.v, a.v);
}

MPM_FN Real operator*(const Real &a, double b)
{
  return RealChain(a, a.v * b, b);
}

MPM_FN Real operator*(double a, const Real &b)
{
  return RealChain(b, a * b.v, a);
}

MPM_FN Real operator/(const Real &a, const Real &b)
{
  const double f = a.v / b.v, inverse = 1. / b.v;

  return RealChain2(a, b, f, inverse, -f * inverse);
}

MPM_FN Real operator/(const Real &a, double b)
{
  return RealChain(a, a.v / b, 1. / b);
}

MPM_FN Real operator/(double a, const Real &b)
{
  const double f = a / b.v;

  return RealChain(b, f, -f / b.v);
}

template <typename Number> static inline Real &operator+=(Real &a, const Number &b)
{
  return a = a + b;
}

template <typename Number> static inline Real &operator-=(Real &a, const Number &b)
{
  return a = a - b;
}

template <typename Number> static inline Real &operator*=(Real &a, const Number &b)
{
  return a = a * b;
}

template <typename Number> static inline Real &operator/=(Real &a, const Number &b)
{
  return a = a / b;
}
