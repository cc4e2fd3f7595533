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
#include "space/lanes.h"
#include "space/space.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"

#define CALM 1. /* part of the difference that is gone in the time in which a wave crosses a cell */

/* sums_i += w_i V C of a group's points */
MPM_INLINE PetscErrorCode ToNodes(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, Slim *restrict sums)
{
  const MpmPoints *points = sum->points;
  const PetscInt  *nodes  = &sum->space->group_nodes[group->node_offset];

  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt p = sum->space->order[s], ahead = MpmSumAhead(sum, s);

    MpmSpaceFetch(known, sum->space, ahead);
    MpmFetch(points->motion.affine, ahead, SLIM);
    MpmFetch(points->volume0, ahead, 1);
    MpmSlimAdd(known, sum, p, *(const Slim *)&points->motion.affine[p * SLIM] * points->volume0[p], nodes, sums);
  }
  return PETSC_SUCCESS;
}

/* Draws the affine velocities of a group's points to the means at its nodes, by `rate` times sqrt(g h). */
MPM_INLINE PetscErrorCode ToPoints(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, PetscReal rate,
                                   const Slim mean[])
{
  const MpmPoints *points = sum->points;
  const PetscInt  *nodes  = &sum->space->group_nodes[group->node_offset];

  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt  p = sum->space->order[s], ahead = MpmSumAhead(sum, s);
    const PetscReal g    = sum->materials[points->material[p]].parameter[MPM_BASAL_GRAVITY];
    const PetscReal part = PetscMin(rate * PetscSqrtReal(g * points->state[p * sum->kept.state]), 1.);
    Slim           *C    = (Slim *)&points->motion.affine[p * SLIM];

    MpmSpaceFetch(known, sum->space, ahead);
    MpmFetch(points->motion.affine, ahead, SLIM);
    MpmFetch(points->state, ahead, sum->kept.state);
    *C += (MpmSlimInterpolate(known, sum, p, NULL, nodes, mean, NULL) - *C) * part;
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmBedCalm(const MpmBedFlow *flow, const MpmSum *sum)
{
  const MpmSpace *space = sum->space;
  const PetscReal rate  = CALM * sum->step.dt / PetscMin(sum->cell[0], sum->cell[1]);
  Slim           *mean;

  PetscFunctionBeginUser;
  if (!sum->points->motion.affine) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1(space->local, &mean));
  for (PetscInt g = 0; g < space->group_count; g++)
    MPM_DISPATCH(sum->layout, &space->groups[g], ToNodes, sum, &space->groups[g], mean);
  PetscCall(MpmSpaceAddToOwners(space, SLIM, (PetscReal *)mean));
  for (PetscInt i = 0; i < space->owned; i++) {
    const PetscReal volume = flow->sums[i * MPM_BED_SUMS + MPM_BED_VOLUME];

    mean[i] *= volume > 0. ? 1. / volume : 0.;
  }
  PetscCall(MpmSpaceToGhosts(space, SLIM, (PetscReal *)mean));
  for (PetscInt g = 0; g < space->group_count; g++)
    MPM_DISPATCH(sum->layout, &space->groups[g], ToPoints, sum, &space->groups[g], rate, mean);
  PetscCall(PetscFree(mean));
  PetscFunctionReturn(PETSC_SUCCESS);
}
