/*
  Foundation: springs between the points and their initial places, which stiffen with their length d = x + u - X,

    e = V_0 (k/2 d.d + h/4 (d.d)^2) ,   d e / d u = V_0 (k + h d.d) d ,   d^2 e / d u^2 = V_0 ((k + h d.d) 1 + 2 h d d^T)
*/
#include "talus/term.h"

enum { STIFFNESS, STIFFENING };

static const MpmParameter parameters[] = {
  {MPM_NUMBER, "stiffness", "N/m4", 0., 1, 0., 1e30, 1, "k, force of a volume by displacement", NULL, 0., NULL},
  {MPM_NUMBER, "stiffening", "N/m6", 0., 0, 0., 1e30, 0, "h, by its cube", NULL, 0., NULL}};

static int Evaluate(const MpmTermElement *element, PetscReal *energy, PetscReal residual[], PetscReal matrix[])
{
  const PetscInt  dim = element->dim;
  const PetscReal k   = element->volume0 * element->parameter[STIFFNESS],
                  h   = element->volume0 * element->parameter[STIFFENING];
  PetscReal d[3], square = 0.;

  for (PetscInt a = 0; a < dim; a++) {
    d[a] = element->x[a] + MpmElementValue(element, a) - element->origin[a];
    square += d[a] * d[a];
  }
  if (energy) *energy += 0.5 * k * square + 0.25 * h * square * square;
  for (PetscInt a = 0; residual && a < dim; a++) MpmElementAddForce(element, a, (k + h * square) * d[a], residual);
  for (PetscInt a = 0; matrix && a < dim; a++)
    for (PetscInt b = 0; b < dim; b++)
      MpmElementAddStiffness(element, a * (dim + 1), b * (dim + 1),
                             (a == b ? k + h * square : 0.) + 2. * h * d[a] * d[b], matrix);
  return 0;
}

const MpmTermType MpmTermType_foundation = {.name            = "foundation",
                                            .summary         = "springs between the points and their initial places",
                                            .parameter_count = sizeof(parameters) / sizeof(parameters[0]),
                                            .parameters      = parameters,
                                            .traits          = MPM_ELEMENT_SYMMETRIC | MPM_ELEMENT_ENERGY,
                                            .evaluate        = Evaluate};
