/*
  Round surfaces and their other sides.
*/
#include "geometry/surface.h"

/* The unit vector along the coordinate axis most nearly at right angles to the line, made orthogonal to it. */
static void ChooseAcross(PetscInt dim, const PetscReal *along, PetscReal normal[])
{
  PetscInt  least = 0;
  PetscReal square;

  for (PetscInt a = 1; along && a < dim; a++)
    if (PetscAbsReal(along[a]) < PetscAbsReal(along[least])) least = a;
  for (PetscInt a = 0; a < dim; a++) normal[a] = a == least ? 1. : 0.;
  if (!along || along[least] == 0.) return;
  square = 1. - PetscSqr(along[least]);
  for (PetscInt a = 0; a < dim; a++) normal[a] = (normal[a] - along[least] * along[a]) / PetscSqrtReal(square);
}

/* The second derivative is (I - n n^T - a a^T)/|r|, a the direction of a line. */
void MpmSurfaceRound(PetscInt dim, const PetscReal r[], PetscReal radius, const PetscReal *along, MpmSurface *surface)
{
  PetscReal length = 0.;

  for (PetscInt a = 0; a < dim; a++) length += r[a] * r[a];
  length            = PetscSqrtReal(length);
  surface->distance = length - radius;
  if (length == 0.) {
    ChooseAcross(dim, along, surface->normal);
    return;
  }
  for (PetscInt a = 0; a < dim; a++) surface->normal[a] = r[a] / length;
  for (PetscInt a = 0; a < dim; a++) {
    for (PetscInt b = 0; b < dim; b++) {
      PetscReal projection = (a == b ? 1. : 0.) - surface->normal[a] * surface->normal[b];

      if (along) projection -= along[a] * along[b];
      surface->second[a][b] = projection / length;
    }
  }
}

void MpmSurfaceFlip(PetscInt dim, MpmSurface *surface)
{
  surface->distance = -surface->distance;
  for (PetscInt a = 0; a < dim; a++) {
    surface->normal[a] = -surface->normal[a];
    for (PetscInt b = 0; b < dim; b++) surface->second[a][b] = -surface->second[a][b];
  }
}
