/*
  Lateral friction of columns with the flow about them, of -mpm_terrain_viscosity: what of a point's velocity is not
  that of the flow in its cells, dv, falls by implicit steps of

    d(dv)/dt = -K |dv| dv / sqrt(A) ,   K the option, A the area of the point's base along the bed.

  The drag is K/2 rho |dv|^2 on the side 2 h sqrt(A) of the column. With FLIP dv is the point's velocity less the
  interpolated one of the nodes. APIC has it as affine velocity C, whose mean square in a cell is
  |dv|^2 = sum_ab C_ab^2 h_b^2/6, the mean second moment of linear functions. Momentum stays but for rounding with APIC.
  The result depends on the number of points, by A, as it does there. The kinetic energy of dv is dissipated.

  Source: AvaFrame, theory of com1DFA, artificial viscosity of SAMOS (docs.avaframe.org, subgridMixingFactor, 100).
*/
#include "point/material.h"
#include "particles/point_mass.h"
#include "particles/points.h"
#include "space/lanes.h"
#include "space/space.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"

/* Part of dv that is left after the step. */
static PetscReal Left(const MpmBedFlow *flow, PetscInt p, PetscReal square, PetscReal dt)
{
  const MpmOnBed *at   = &flow->point[p];
  const PetscReal area = at->area / PetscSqrtReal(MpmBedCosine2(flow->bed, at->slope));

  return 1. / (1. + flow->bed->viscosity * dt * PetscSqrtReal(square / area));
}

/* The points of a group, towards the velocities of the nodes; FLIP. Adds to the kinetic energy that is lost. */
MPM_INLINE PetscErrorCode ToNodes(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                  const MpmBedFlow *flow, const Slim velocity[], PetscReal *lost)
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt  p    = sum->space->order[s];
    const PetscReal mass = MpmPointMass(sum->points, sum->materials, p);
    PetscReal      *v    = &sum->points->motion.velocity[p * 2], left;
    const Slim      mean = MpmSlimInterpolate(known, sum, p, NULL, nodes, velocity, NULL);

    left = Left(flow, p, PetscSqr(v[0] - mean[0]) + PetscSqr(v[1] - mean[1]), sum->step.dt);
    for (PetscInt a = 0; a < 2; a++) {
      const PetscReal to = mean[a] + left * (v[a] - mean[a]);

      *lost += 0.5 * mass * (v[a] - to) * (v[a] + to);
      v[a] = to;
    }
  }
  return PETSC_SUCCESS;
}

/* The affine velocities of a group's points. Adds to the kinetic energy that is lost. */
MPM_INLINE PetscErrorCode Affine(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, const MpmBedFlow *flow,
                                 PetscReal *lost)
{
  PetscInt first[MPM_MAX_DIM];

  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt  p    = sum->space->order[s];
    const PetscReal mass = MpmPointMass(sum->points, sum->materials, p);
    PetscReal      *C = &sum->points->motion.affine[p * 4], square = 0., energy = 0., left;
    MpmStencil      at;

    MpmStencilPlace(known, sum, first, p, &at);
    for (PetscInt k = 0; k < 4; k++) {
      square += PetscSqr(C[k] * sum->grid->h[k % 2]) / 6.;
      energy += 0.5 * mass * PetscSqr(C[k]) * at.second[k % 2];
    }
    left = Left(flow, p, square, sum->step.dt);
    *lost += energy * (1. - left * left);
    for (PetscInt k = 0; k < 4; k++) C[k] *= left;
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmBedMix(const MpmBedFlow *flow, const MpmSum *sum, const PetscReal u[])
{
  const MpmSpace *space    = sum->space;
  const PetscBool affine   = (PetscBool)(sum->points->motion.affine != NULL);
  PetscReal       lost     = 0.;
  Slim           *velocity = NULL;

  PetscFunctionBeginUser;
  if (!affine) PetscCall(PetscMalloc1(space->local, &velocity));
  for (PetscInt i = 0; i < space->local && !affine; i++) velocity[i] = MpmSlimLoad(2, &u[i * 2]) / sum->step.dt;
  for (PetscInt g = 0; g < space->group_count; g++) {
    if (affine) MPM_DISPATCH(sum->layout, &space->groups[g], Affine, sum, &space->groups[g], flow, &lost);
    else MPM_DISPATCH(sum->layout, &space->groups[g], ToNodes, sum, &space->groups[g], flow, velocity, &lost);
  }
  PetscCall(PetscFree(velocity));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &lost, 1, MPIU_REAL, MPIU_SUM, sum->grid->comm));
  *flow->mixed.dissipated += lost;
  if (flow->mixed.apart) *flow->mixed.apart += lost;
  PetscFunctionReturn(PETSC_SUCCESS);
}
