/*
  Paraboloid: a body above s = rho^2/(2 R), s the height above its tip and rho the distance from its axis, which is the
  last one of the grid.

  The nearest place of the surface to (rho_0, s_0) has the greatest root of rho^3/(2 R^2) + (1 - s_0/R) rho = rho_0. The
  distance's second derivative is kappa/(1 + kappa d) in each of the surface's principal directions.
*/
#include <math.h>
#include "talus/contact.h"

enum { TIP, RADIUS };

static const MpmParameter parameters[] = {
  {MPM_NUMBER, "tip", "m", 0., 1, -1e30, 1e30, 0, "height of its lowest place", NULL, 0., NULL},
  {MPM_NUMBER, "radius", "m", 0., 1, 0., 1e30, 1, "R, of curvature at the tip", NULL, 0., NULL}};

/* rho of the nearest place: from above Newton's method goes down to the greatest root. */
static double Nearest(double R, double from, double height)
{
  const double c   = 1. - height / R;
  double       rho = cbrt(2. * R * R * from) + R * sqrt(2. * fmax(-c, 0.)), last = INFINITY;

  while (rho < last) {
    last = rho;
    rho -= (rho * (rho * rho / (2. * R * R) + c) - from) / (1.5 * rho * rho / (R * R) + c + (rho == 0. && c == 0.));
  }
  return last;
}

static void Distance(const MpmContactBody *body, const PetscReal x[], MpmContactDistance *seen)
{
  const PetscInt dim = body->dim;
  const double   R = body->parameter[RADIUS], height = x[dim - 1] - body->parameter[TIP];
  const double   from = dim > 2 ? hypot(x[0], x[1]) : fabs(x[0]);
  const double   rho = Nearest(R, from, height), slope = rho / R, length = hypot(1., slope);
  const double   kappa[2] = {1. / (R * length * length * length), 1. / (R * length)};
  double         away[3] = {0., 0., 0.}, along[2][3] = {{0.}};

  away[0] = 1.;
  for (PetscInt a = 0; from > 0. && a < dim - 1; a++) away[a] = x[a] / from;
  seen->distance = (slope * (from - rho) - (height - rho * rho / (2. * R))) / length;
  for (PetscInt a = 0; a < dim - 1; a++) {
    seen->normal[a] = slope / length * away[a];
    along[0][a]     = away[a] / length;
  }
  seen->normal[dim - 1] = -1. / length;
  along[0][dim - 1]     = slope / length;
  along[1][0]           = -away[1];
  along[1][1]           = away[0];
  for (PetscInt k = 0; k < dim - 1; k++)
    for (PetscInt a = 0; a < dim; a++)
      for (PetscInt b = 0; b < dim; b++)
        seen->second[a][b] += kappa[k] / (1. + kappa[k] * seen->distance) * along[k][a] * along[k][b];
}

static void Middle(const MpmContactBody *body, PetscReal middle[3], PetscReal *size)
{
  for (PetscInt a = 0; a < body->dim; a++) middle[a] = a == body->dim - 1 ? body->parameter[TIP] : 0.;
  *size = body->parameter[RADIUS];
}

const MpmContactBodyType MpmContactBodyType_paraboloid = {.name            = "paraboloid",
                                                          .summary         = "a paraboloid, tip down",
                                                          .parameter_count = sizeof(parameters) / sizeof(parameters[0]),
                                                          .parameters      = parameters,
                                                          .distance        = Distance,
                                                          .middle          = Middle};
