/*
  Student's distribution of t with n degrees of freedom. Its tail is an incomplete beta function,

    P(|T| > t) = I_x(n/2, 1/2) ,   x = n/(n + t^2) ,

  by the continued fraction of Abramowitz and Stegun (1964), 26.5.8 and 26.7.1.
*/
#include <math.h>
#include "inverse/student.h"

#define TERMS 500
#define TINY  1e-300

/* The continued fraction of I_x(a, b), x < (a + 1)/(a + b + 2), evaluated from its end. */
static PetscReal Fraction(PetscReal a, PetscReal b, PetscReal x)
{
  PetscReal value = 1.;

  for (PetscInt k = TERMS; k > 0; k--) {
    const PetscReal m = (PetscReal)(k / 2);
    const PetscReal d = k % 2 ? -(a + m) * (a + b + m) * x / ((a + 2. * m) * (a + 2. * m + 1.))
                              : m * (b - m) * x / ((a + 2. * m - 1.) * (a + 2. * m));

    value = 1. + d / (PetscAbsReal(value) > TINY ? value : TINY);
  }
  return 1. / value;
}

static PetscReal Beta(PetscReal a, PetscReal b, PetscReal x)
{
  PetscReal front;

  if (x <= 0. || x >= 1.) return x <= 0. ? 0. : 1.;
  front = PetscExpReal(lgamma(a + b) - lgamma(a) - lgamma(b) + a * PetscLogReal(x) + b * PetscLogReal(1. - x));
  if (x < (a + 1.) / (a + b + 2.)) return front * Fraction(a, b, x) / a;
  return 1. - front * Fraction(b, a, 1. - x) / b;
}

PetscReal MpmStudentQuantile(PetscReal probability, PetscInt degrees)
{
  const PetscReal n = (PetscReal)degrees, tail = 2. * (1. - probability);
  PetscReal       low = 0., high = 1.;

  while (Beta(0.5 * n, 0.5, n / (n + high * high)) > tail && high < 1e8) high *= 2.;
  for (PetscInt i = 0; i < 200; i++) {
    const PetscReal middle = 0.5 * (low + high);

    if (Beta(0.5 * n, 0.5, n / (n + middle * middle)) > tail) low = middle;
    else high = middle;
  }
  return 0.5 * (low + high);
}
