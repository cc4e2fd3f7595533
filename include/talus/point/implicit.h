#pragma once
/*
  The local problem of a law: up to three unknowns x with r(x; inputs) = 0, at one point. Included by files in
  materials/ that have one.

  r is written once, in Dual numbers (dual.h), as an ImplicitResidual: inputs and unknowns in, as many residuals as
  unknowns out; non-zero where it cannot be evaluated. `problem` has its other data: the point with its parameters and
  history, or a struct of the law's. Inputs are Duals with directions 0, 1, .. of the law's choosing, principal values
  or invariants, seeded; they carry no more directions than there are inputs.

  Newton's method finds the values of x in plain doubles, the unknowns taking the directions of the inputs; parameters
  are constants. The derivatives follow by one step from there, x - J^{-1} r with r in the inputs' directions. This step
  leaves the values alone and is exact, for by the implicit function theorem dx = -J^{-1} (dr/d input) d input. Every
  form has these derivatives, and equal values.

  The answer must not depend on where the iteration starts: the stress would not be a smooth function of the step. Where
  r has several roots, the bracket or the start has to single one out, without a jump.

  Convergence: relative to x, 1e-12 or the limit by rounding. Non-zero results mean that there is no answer.
*/
#include "law.h"

#define IMPLICIT_UNKNOWNS 3
#define IMPLICIT_INPUTS   16
#define IMPLICIT_LIMIT    60
/* A Newton step this small, relative to x, is the last: its square is beyond rounding. */
#define IMPLICIT_LAST_STEP 1e-9

typedef int (*ImplicitResidual)(const void *problem, const Dual input[], const Dual x[], Dual r[]);

typedef struct {
  ImplicitResidual residual;
  const void      *problem;
  const Dual      *input; /* arguments of x */
  int              inputs, unknowns;
  double           scale; /* a size of x below which nothing matters, as eps times it does not */
} Implicit;

/* Whether a step from x is below what the iteration has to resolve */
MPM_FN int ImplicitIsSmall(const Implicit *implicit, double step, double x)
{
  return fabs(step) <= IMPLICIT_LAST_STEP * fabs(x) + 4. * DBL_EPSILON * implicit->scale;
}

/* r and J = dr/dx at x, plain; J is filled up to 3 x 3 by the identity. Non-zero where r is not a number. */
MPM_FN int ImplicitEvaluate(const Implicit *implicit, const double x[], double r[], double J[9])
{
  const int n = implicit->unknowns;
  Dual      input[IMPLICIT_INPUTS], unknown[IMPLICIT_UNKNOWNS] = {DualConstant(0.)}, residual[IMPLICIT_UNKNOWNS];
  int       failed = 0, k = 0;

  do input[k] = DualConstant(DualValue(implicit->input[k]));
  while (++k < implicit->inputs);
  for (int i = 0; i < n; ++i) unknown[i] = DualSeed(x[i], i);
  if (implicit->residual(implicit->problem, input, unknown, residual)) return 1;
  for (k = 0; k < 9; ++k) J[k] = k % 4 == 0 ? 1. : 0.;
  for (int i = 0; i < n; ++i) {
    r[i] = DualValue(residual[i]);
    failed |= !(fabs(r[i]) <= DBL_MAX);
    for (int j = 0; j < n; ++j) J[3 * i + j] = DualDirection(residual[i], j);
  }
  return failed;
}

/* step = -J^{-1} r by cofactors; non-zero where J is singular */
MPM_FN int ImplicitStep(int n, const double J[9], const double r[], double step[])
{
  double       cofactor[9];
  const double det = MpmCofactors(9, J, cofactor);

  for (int i = 0; i < n; ++i) {
    step[i] = 0.;
    for (int j = 0; j < n; ++j) step[i] -= cofactor[3 * j + i] * r[j];
    step[i] /= det;
  }
  return !(fabs(det) >= DBL_MIN);
}

/*
  r at x with the derivatives that the inputs carry, and J. Where there are directions enough the unknowns take the next
  ones, `first` and on, and one evaluation gives both; otherwise `first` is negative.
*/
MPM_FN int ImplicitDifferentiate(const Implicit *implicit, const double value[], Dual r[], double J[9], int *first)
{
  const int n = implicit->unknowns, fits = implicit->inputs + n <= MPM_DUAL_INPUTS;
  double    plain[IMPLICIT_UNKNOWNS];
  Dual      x[IMPLICIT_UNKNOWNS] = {DualConstant(0.)};

  *first = fits ? implicit->inputs : -1;
  for (int i = 0; i < n; ++i) x[i] = fits ? DualSeed(value[i], *first + i) : DualConstant(value[i]);
  if (!fits && ImplicitEvaluate(implicit, value, plain, J)) return 1;
  if (implicit->residual(implicit->problem, implicit->input, x, r)) return 1;
  for (int k = 0; k < 9 && fits; ++k) J[k] = k % 4 == 0 ? 1. : 0.;
  for (int i = 0; i < n && fits; ++i)
    for (int j = 0; j < n; ++j) J[3 * i + j] = DualDirection(r[i], *first + j);
  return 0;
}

/* The values x with their derivatives by what the inputs carry, parameters and history */
MPM_FN int ImplicitDerive(const Implicit *implicit, const double value[], Dual x[])
{
  const int n = implicit->unknowns;
  double    J[9], cofactor[9], det;
  int       first;
  Dual      r[IMPLICIT_UNKNOWNS];

  for (int i = 0; i < n; ++i) x[i] = DualConstant(value[i]);
  if (MPM_DIRECTIONS == 0) return 0;
  if (ImplicitDifferentiate(implicit, value, r, J, &first)) return 1;
  det = MpmCofactors(9, J, cofactor);
  for (int i = 0; i < n; ++i) {
    if (first >= 0) x[i] = DualSeed(value[i], first + i); /* the later sum removes that direction again */
    for (int j = 0; j < n; ++j) DualAddDirections(&x[i], -cofactor[3 * j + i] / det, &r[j]);
  }
  return !(fabs(det) >= DBL_MIN);
}

/*
  ImplicitFind - the value of one unknown between lower and upper, with r < 0 below the root and r > 0 above it

  Newton's method from `start`, bisection where it leaves the bracket or halves too little. r is not evaluated at the
  bracket's ends: that it changes sign between them is for the law to know.
*/
MPM_FN int ImplicitFind(const Implicit *implicit, double lower, double upper, double start, double *x)
{
  double at = fmin(fmax(start, lower), upper), before = 2. * (upper - lower), last = before;

  for (int iteration = 0; iteration < IMPLICIT_LIMIT; ++iteration) {
    double r, J[9], next, step;

    if (ImplicitEvaluate(implicit, &at, &r, J)) return 1;
    *x = at;
    if (r == 0.) return 0;
    if (r < 0.) lower = at;
    else upper = at;
    step = -r / J[0];
    next = at + step;
    if (ImplicitIsSmall(implicit, step, at)) {
      *x = fmin(fmax(next, lower), upper);
      return 0;
    }
    if (!(next > lower && next < upper) || fabs(step) > 0.5 * before) next = 0.5 * (lower + upper);
    if (next == lower || next == upper) return 0; /* neighbouring numbers */
    before = last;
    last   = fabs(next - at);
    at     = next;
  }
  return 1;
}

/* ImplicitBracket - the same with its derivatives */
MPM_FN int ImplicitBracket(const Implicit *implicit, double lower, double upper, double start, Dual *x)
{
  double value;

  return ImplicitFind(implicit, lower, upper, start, &value) || ImplicitDerive(implicit, &value, x);
}

/* The largest of |r| */
MPM_FN double ImplicitNorm(int n, const double r[])
{
  double largest = 0.;

  for (int i = 0; i < n; ++i) largest = fmax(largest, fabs(r[i]));
  return largest;
}

/*
  ImplicitSystem - up to three unknowns by Newton's method with a line search on the largest residual, from `start`

  The residuals should be of one size, about 1 where x is wrong by its own size.
*/
MPM_FN int ImplicitSystem(const Implicit *implicit, const double start[], Dual x[])
{
  const int n                     = implicit->unknowns;
  double    at[IMPLICIT_UNKNOWNS] = {0.}, r[IMPLICIT_UNKNOWNS], step[IMPLICIT_UNKNOWNS], J[9];

  for (int i = 0; i < n; ++i) at[i] = start[i];
  if (ImplicitEvaluate(implicit, at, r, J)) return 1;
  for (int iteration = 0; iteration < IMPLICIT_LIMIT; ++iteration) {
    const double norm = ImplicitNorm(n, r);
    double       part = 1., tried[IMPLICIT_UNKNOWNS] = {0.};
    int          small = 1, worse = 1;

    if (norm == 0.) return ImplicitDerive(implicit, at, x);
    if (ImplicitStep(n, J, r, step)) return 1;
    for (int i = 0; i < n; ++i) small &= ImplicitIsSmall(implicit, step[i], at[i]);
    for (int halving = 0; halving < 40 && worse && !small; ++halving, part *= 0.5) {
      for (int i = 0; i < n; ++i) tried[i] = at[i] + part * step[i];
      worse = ImplicitEvaluate(implicit, tried, r, J) || !(ImplicitNorm(n, r) <= (1. - 1e-4 * part) * norm);
    }
    if (small) {
      for (int i = 0; i < n; ++i) at[i] += step[i];
      return ImplicitDerive(implicit, at, x);
    }
    if (worse) return norm <= 1e-12 ? ImplicitDerive(implicit, at, x) : 1;
    for (int i = 0; i < n; ++i) at[i] = tried[i];
  }
  return 1;
}
