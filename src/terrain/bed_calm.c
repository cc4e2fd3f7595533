/*
  Stability of affine velocities (APIC) of columns. Nodes take C_p (x_i - x_p), but C_p was found where the second
  moment of the point's weights was another: oscillations from node to node, which the pressure of the depth drives,
  gain energy on the way and grow within some thousand steps. Where a base contracts its affine velocity therefore
  fades, as by a viscosity of the depth's own waves:

    C_p <- (1 - k) C_p ,   k = min(2 sqrt(g h) dt/dx, 1)   where tr C_p < 0

  Constant and linear fields of velocity keep their values at the nodes, and so does all that expands.
*/
#include "talus/point/basal.h"
#include "point/material.h"
#include "particles/points.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"

#define FADE 2. /* of an affine velocity in the time in which a wave crosses a cell */

PetscErrorCode MpmBedCalm(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  const MpmPoints *points = sum->points;
  const PetscReal  by     = FADE * sum->step.dt / PetscMin(sum->cell[0], sum->cell[1]);

  (void)ctx, (void)u, (void)particles;
  PetscFunctionBeginUser;
  if (!points->motion.affine) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal g = sum->materials[points->material[p]].parameter[MPM_BASAL_GRAVITY];
    PetscReal      *C = &points->motion.affine[p * 4], left;

    if (C[0] + C[3] >= 0.) continue;
    left = 1. - PetscMin(by * PetscSqrtReal(g * points->state[p * sum->kept.state]), 1.);
    for (PetscInt k = 0; k < 4; k++) C[k] *= left;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
