/*
  Earth pressure along the bed over that of a fluid, of a material with internal friction phi on a bed with friction
  delta:

    K = 2 (1 -+ sqrt(1 - cos^2 phi (1 + tan^2 delta)))/cos^2 phi - 1

  with - (active) where the base stretches and + (passive) where it shortens at the rate 0.2 sqrt(g/h) or more, linear
  between: passive pressure needs some strain, and oscillations of the velocity have none. tan delta = tau/N of the law
  of the bed at rest; the root is at least 0. K is that of both directions in the plane.

  Source: Savage and Hutter (1989), J. Fluid Mech. 199, 177-215, doi:10.1017/S0022112089000340, equation 2.21.
*/
#include "talus/point/basal.h"
#include "point/material.h"
#include "particles/points.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"

#define FULL 0.2 /* rate of shortening from which on the pressure is passive, over sqrt(g/h) */

PetscReal MpmBedEarthPressure(const MpmSum *sum, PetscInt p, PetscReal depth, PetscReal cosine2)
{
  const MpmPoints   *points   = sum->points;
  const MpmMaterial *material = &sum->materials[points->material[p]];
  const PetscReal   *number = material->parameter, phi = number[MPM_BASAL_INTERNAL];
  const PetscReal    weight  = number[MPM_BASAL_DENSITY] * number[MPM_BASAL_GRAVITY] * depth * cosine2;
  const PetscReal   *C       = points->motion.affine ? &points->motion.affine[p * 4] : NULL;
  const PetscReal    stretch = C ? C[0] + C[3] : 0.;
  PetscReal          square, tangent, root, passive;

  if (phi > 90. || stretch == 0.) return 1.;
  square  = PetscSqr(PetscCosReal(phi * (PETSC_PI / 180.)));
  tangent = material->basal->resistance(
              number, &(MpmBasalPoint){.depth = depth * PetscSqrtReal(cosine2), .pressure = weight, .speed = 0.}) /
            weight;
  root    = PetscSqrtReal(PetscMax(1. - square * (1. + tangent * tangent), 0.));
  passive = PetscClipInterval(-stretch / (FULL * PetscSqrtReal(number[MPM_BASAL_GRAVITY] / depth)), 0., 1.);
  return 2. * (1. + (2. * passive - 1.) * root) / square - 1.;
}
