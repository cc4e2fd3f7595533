#pragma once
/*
  Geometry of a surface as seen from a point of the material.
*/
#include "base/base.h"

/* Distance from a surface, positive where the material is, its gradient and its second derivative. */
typedef struct {
  PetscReal distance, normal[MPM_MAX_DIM], second[MPM_MAX_DIM][MPM_MAX_DIM];
} MpmSurface;

/*
  Distance from a point or, with `along`, a line in direction of this unit vector, less a radius; r stands at right
  angles to the line. At the centre, which is as far from every side, one is chosen, and the second derivative is 0.
*/
void MpmSurfaceRound(PetscInt dim, const PetscReal r[], PetscReal radius, const PetscReal *along, MpmSurface *surface);
/* The other side: all signs change. */
void MpmSurfaceFlip(PetscInt dim, MpmSurface *surface);
