#pragma once
/*
  Laws that solve their local problem twice, for the benchmark alone: what they take longer is what it costs. Put before
  a law's file by the compiler's -include.
*/
#include "talus/point/implicit.h"

/* What is thrown away must not be left out. */
MPM_FN void LocalUse(int unknowns, const Dual x[])
{
  volatile double used = 0.;

  for (int i = 0; i < unknowns; ++i) {
    used += DualValue(x[i]);
    for (int k = 0; k < MPM_DUAL_DIRECTIONS; ++k) used += DualDirection(x[i], k);
  }
}

MPM_FN int LocalFind(const Implicit *implicit, double lower, double upper, double start, double *x)
{
  double first;
  Dual   use;

  if (ImplicitFind(implicit, lower, upper, start, &first)) return 1;
  use = DualConstant(first);
  LocalUse(1, &use);
  return ImplicitFind(implicit, lower, upper, start, x);
}

MPM_FN int LocalBracket(const Implicit *implicit, double lower, double upper, double start, Dual *x)
{
  Dual first;

  if (ImplicitBracket(implicit, lower, upper, start, &first)) return 1;
  LocalUse(1, &first);
  return ImplicitBracket(implicit, lower, upper, start, x);
}

MPM_FN int LocalSystem(const Implicit *implicit, const double start[], Dual x[])
{
  Dual first[IMPLICIT_UNKNOWNS];

  if (ImplicitSystem(implicit, start, first)) return 1;
  LocalUse(implicit->unknowns, first);
  return ImplicitSystem(implicit, start, x);
}

#define ImplicitFind    LocalFind
#define ImplicitBracket LocalBracket
#define ImplicitSystem  LocalSystem
