/*
  Velocities that turn with the bed, of -mpm_curvature path and pressure. A point that has gone from a place where the
  bed has the normal n to one where it has n' turns with it, about the line in which both planes meet:

    V' = V - (n'.V)/(1 + n.n') (n + n') ,   V = (v, v.s)

  V is the velocity along the bed, whose length stays to rounding, over bends and over kinks. In short steps this is
  dv/dt = -cos^2 grad Z (v.H v), H the second derivatives of the bed. Slopes are differences of the bed over a cell, a
  function of the place alone: of a point that comes back to a slope nothing is left.

  Source: Goldstein, Poole and Safko (2002), Classical mechanics, 3rd ed., section 4.7 (rotation formula).
*/
#include "grid/grid.h"
#include "point/material.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/sum.h"
#include "terrain/dam_force.h"

/* The unit normal of the bed at a place, upwards. */
static void Normal(const MpmSum *sum, const MpmBed *bed, const PetscReal x[], PetscReal n[3])
{
  PetscReal length = 1.;

  for (PetscInt a = 0; a < 2; a++) {
    const PetscReal half  = 0.5 * sum->grid->h[a];
    PetscReal       at[2] = {x[0], x[1]}, z[2];

    for (PetscInt k = 0; k < 2; k++) {
      at[a] = PetscClipInterval(x[a] + (k ? half : -half), sum->grid->lower[a], sum->grid->upper[a]);
      z[k]  = MpmBedHeight(bed, at);
    }
    n[a] = -(z[1] - z[0]) / (2. * half);
    length += n[a] * n[a];
  }
  n[2] = 1.;
  for (PetscInt a = 0; a < 3; a++) n[a] /= PetscSqrtReal(length);
}

void MpmBedTurn(const MpmBedFlow *flow, const MpmSum *sum)
{
  const MpmBed    *bed    = flow->bed;
  const MpmPoints *points = sum->points;

  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal *x = &points->x[p * 2];
    PetscReal       *v = &points->motion.velocity[p * 2], from[2], before[3], after[3], across, apart;

    for (PetscInt a = 0; a < 2; a++) from[a] = x[a] - sum->step.dt * v[a];
    Normal(sum, bed, from, before);
    Normal(sum, bed, x, after);
    across = v[0] * after[0] + v[1] * after[1] - (v[0] * before[0] + v[1] * before[1]) / before[2] * after[2];
    apart  = 1. + before[0] * after[0] + before[1] * after[1] + before[2] * after[2];
    for (PetscInt a = 0; a < 2; a++) v[a] -= across / apart * (before[a] + after[a]);
    if (flow->on_bed.dams && across != 0.) {
      const PetscReal way = MpmPointMass(points, sum->materials, p) * across / apart;
      PetscReal       impulse[3];

      for (PetscInt a = 0; a < 3; a++) impulse[a] = way * (before[a] + after[a]);
      MpmDamsTurn(flow, sum, p, impulse);
    }
  }
}
