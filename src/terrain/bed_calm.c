/*
  Stability of affine velocities (APIC) of columns. Nodes take C_p (x_i - x_p), but C_p was found where the second
  moment of the point's weights was another: oscillations from node to node, which the pressure of the depth drives,
  gain energy on the way and grow within some thousand steps. Affine velocities are therefore drawn to the mean of their
  neighbours', as by a viscosity of the depth's own waves that acts on oscillations alone:

    C_p <- C_p + k (Cbar_p - C_p) ,   k = min(sqrt(g h) dt/dx, 1)

  Cbar is interpolated from the points' means at the nodes. Linear fields of velocity stay, a smooth one changes by the
  order of dx^2, and what is opposite from node to node is gone.
*/
#include "talus/point/basal.h"
#include "point/material.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"

#define CALM 1. /* part of the difference that is gone in the time in which a wave crosses a cell */

/* Means of a row of the affine velocities, two numbers a point. */
static PetscErrorCode FindMean(const MpmSum *sum, PetscInt row, PetscReal nodal[], PetscReal mean[])
{
  const MpmPointValues values = {.components = 2, .stride = 4, .value = &sum->points->motion.affine[(PetscInt)2 * row]};

  PetscFunctionBeginUser;
  PetscCall(MpmProjectToNodes(sum, &values, nodal));
  PetscCall(MpmSpaceToGhosts(sum->space, 2, nodal));
  PetscCall(MpmDisplacementsAtPoints(sum, nodal, mean));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmBedCalm(void *ctx, const MpmSum *sum, const PetscReal u[], MpmParticles *particles)
{
  const MpmPoints *points = sum->points;
  const PetscReal  by     = CALM * sum->step.dt / PetscMin(sum->cell[0], sum->cell[1]);
  PetscReal       *nodal, *mean[2];

  (void)ctx, (void)u, (void)particles;
  PetscFunctionBeginUser;
  if (!points->motion.affine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
    PetscCalloc3((2 * sum->space->local), &nodal, (2 * points->count), &mean[0], (2 * points->count), &mean[1]));
  for (PetscInt row = 0; row < 2; row++) PetscCall(FindMean(sum, row, nodal, mean[row]));
  for (PetscInt p = 0; p < points->count; p++) {
    const PetscReal g = sum->materials[points->material[p]].parameter[MPM_BASAL_GRAVITY];
    PetscReal      *C = &points->motion.affine[p * 4], part;

    part = PetscMin(by * PetscSqrtReal(g * points->state[p * sum->kept.state]), 1.);
    for (PetscInt k = 0; k < 4; k++) C[k] += part * (mean[k / 2][2 * p + k % 2] - C[k]);
  }
  PetscCall(PetscFree3(nodal, mean[0], mean[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}
