/*
  A number with derivatives in NUMBER_DIRECTIONS directions: the type NUMBER and its arithmetic, NUMBER_(Add) and so on.
  Included by dual.h once for each such type; no include guard.

  Derivatives are kept in lanes of four where the machine has registers for that: gcc leaves arrays of plain doubles in
  memory, which makes the same source about twice as slow. The lanes behind the last direction hold numbers that nobody
  reads. aligned(8): a number may lie wherever a double may.
*/
#if defined(__AVX__) && defined(__GNUC__) && !defined(__CUDACC__) && NUMBER_DIRECTIONS > 2
#define NUMBER_LANE 4
typedef double NUMBER_(Lane) __attribute__((vector_size(8 * NUMBER_LANE), aligned(8)));
#else
#define NUMBER_LANE 1
typedef double NUMBER_(Lane);
#endif
#define NUMBER_LANES ((NUMBER_DIRECTIONS + NUMBER_LANE - 1) / NUMBER_LANE)

#if defined(__GNUC__) && !defined(__CUDACC__)
#define NUMBER_FOR_LANES(k) _Pragma("GCC unroll 8") for (int k = 0; k < NUMBER_LANES; ++k)
#else
#define NUMBER_FOR_LANES(k) for (int k = 0; k < NUMBER_LANES; ++k)
#endif

typedef struct {
  NUMBER_(Lane) d[NUMBER_LANES]; /* derivatives */
  NUMBER_(Lane) v;               /* value, in all lanes: it multiplies derivatives */
} NUMBER;

/* One number in all lanes. */
MPM_FN NUMBER_(Lane) NUMBER_(Splat)(double value)
{
#if NUMBER_LANE == 1
  return value;
#else
  const NUMBER_(Lane) lane = {value, value, value, value};

  return lane;
#endif
}

MPM_FN double NUMBER_(Value)(NUMBER a)
{
#if NUMBER_LANE == 1
  return a.v;
#else
  return a.v[0];
#endif
}

/* The derivative in direction k. */
MPM_FN double NUMBER_(Direction)(NUMBER a, int k)
{
#if NUMBER_LANE == 1
  return a.d[k];
#else
  return a.d[k / NUMBER_LANE][k % NUMBER_LANE];
#endif
}

/* A number independent of the directions; where Reals have derivatives of their own, these are the last directions. */
MPM_FN NUMBER NUMBER_(Constant)(Real value)
{
  const NUMBER_(Lane) zero = {0.};
  NUMBER c;

  c.v                        = NUMBER_(Splat)(RealValue(value));
  NUMBER_FOR_LANES(k) c.d[k] = zero;
#if defined(MPM_SENSITIVITY)
  for (int k = 0; k < REAL_DIRECTIONS; ++k) {
    const int at = NUMBER_DIRECTIONS - REAL_DIRECTIONS + k;

#if NUMBER_LANE == 1
    c.d[at] = RealDirection(value, k);
#else
    c.d[at / NUMBER_LANE][at % NUMBER_LANE] = RealDirection(value, k);
#endif
  }
#endif
  return c;
}

/* An independent variable: derivative 1 in the given direction. */
MPM_FN NUMBER NUMBER_(Seed)(double value, int direction)
{
  NUMBER c = NUMBER_(Constant)(value);

#if NUMBER_LANE == 1
  c.d[direction] = 1.;
#else
  c.d[direction / NUMBER_LANE][direction % NUMBER_LANE] = 1.;
#endif
  return c;
}

/* f(a), given f and its derivative fa at the value of a. */
MPM_FN NUMBER NUMBER_(Chain)(NUMBER a, double f, double fa)
{
  NUMBER c;

  c.v                        = NUMBER_(Splat)(f);
  NUMBER_FOR_LANES(k) c.d[k] = fa * a.d[k];
  return c;
}

/* f(a, b), given f and its derivatives fa, fb at the values of a and b. */
MPM_FN NUMBER NUMBER_(Chain2)(NUMBER a, NUMBER b, double f, double fa, double fb)
{
  NUMBER c;

  c.v                        = NUMBER_(Splat)(f);
  NUMBER_FOR_LANES(k) c.d[k] = fa * a.d[k] + fb * b.d[k];
  return c;
}

/* sum += alpha a */
MPM_FN void NUMBER_(AddScaled)(NUMBER *sum, double alpha, const NUMBER *a)
{
  sum->v += alpha * a->v;
  NUMBER_FOR_LANES(k) sum->d[k] += alpha * a->d[k];
}

/* sum += a b */
MPM_FN void NUMBER_(AddProduct)(NUMBER *sum, const NUMBER *a, const NUMBER *b)
{
  const NUMBER_(Lane) av = a->v, bv = b->v;

  sum->v += av * bv;
  NUMBER_FOR_LANES(k) sum->d[k] += bv * a->d[k] + av * b->d[k];
}

/* Adds alpha times the derivatives of a to those of sum, whose value stays. */
MPM_FN void NUMBER_(AddDirections)(NUMBER *sum, double alpha, const NUMBER *a)
{
  NUMBER_FOR_LANES(k) sum->d[k] += alpha * a->d[k];
}

MPM_FN NUMBER NUMBER_(Add)(NUMBER a, NUMBER b)
{
  a.v += b.v;
  NUMBER_FOR_LANES(k) a.d[k] += b.d[k];
  return a;
}

MPM_FN NUMBER NUMBER_(Sub)(NUMBER a, NUMBER b)
{
  a.v -= b.v;
  NUMBER_FOR_LANES(k) a.d[k] -= b.d[k];
  return a;
}

MPM_FN NUMBER NUMBER_(Mul)(NUMBER a, NUMBER b)
{
  NUMBER c;

  c.v                        = a.v * b.v;
  NUMBER_FOR_LANES(k) c.d[k] = b.v * a.d[k] + a.v * b.d[k];
  return c;
}

/* alpha a */
MPM_FN NUMBER NUMBER_(Scale)(Real alpha, NUMBER a)
{
#if defined(MPM_SENSITIVITY)
  return NUMBER_(Mul)(NUMBER_(Constant)(alpha), a);
#else
  a.v                                                   = alpha * a.v;
  NUMBER_FOR_LANES(k) a.d[k]                            = alpha * a.d[k];
  return a;
#endif
}

MPM_FN NUMBER NUMBER_(Square)(NUMBER a)
{
  const NUMBER_(Lane) twice = a.v + a.v;

  a.v                        = a.v * a.v;
  NUMBER_FOR_LANES(k) a.d[k] = twice * a.d[k];
  return a;
}

#undef NUMBER_LANE
#undef NUMBER_LANES
#undef NUMBER_FOR_LANES
