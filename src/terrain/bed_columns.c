/*
  State of columns after a displacement u of the nodes. The kernel and law of columns (physics/depth_averaged.c,
  point/column_law.c) have these numbers, too: with dF = I + sum_i u_i grad w_ip,

    F = dF F_n ,   h = h_n/det dF ,   no stress.
*/
#include "particles/points.h"
#include "space/lanes.h"
#include "space/space.h"
#include "space/sum.h"
#include "terrain/bed_flow.h"

/* A group's points; counts those whose base has turned inside out. */
MPM_INLINE PetscErrorCode Update(const MpmKnown known, const MpmSum *sum, const MpmGroup *group, const PetscReal u[],
                                 MpmTrial *trial, PetscInt *failed)
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset], kept = sum->kept.state;

  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    const PetscInt   p  = sum->space->order[s];
    const MpmLines   w  = MpmPointLines(2, sum->space, sum->space->shapes.at[0].weight, p, &MpmLineOne);
    const MpmLines   g  = MpmPointLines(2, sum->space, sum->space->shapes.at[0].gradient, p, &MpmLineZero);
    const PetscReal *F  = &sum->points->F[p * 4];
    PetscReal       *to = &trial->F[p * 4], det;
    MpmTwo           x = {0., 0.}, y = {0., 0.};

    MpmSumFetch(known, sum, s);
    MpmFetch(sum->points->state, MpmSumAhead(sum, s), kept);
    for (PetscInt j = 0; j < known.count[1]; j++) {
      MpmTwo along = {0., 0.}, row = {0., 0.};

      for (PetscInt k = 0; k < known.count[0]; k++) {
        const MpmTwo value = *(const MpmTwo *)&u[nodes[j * known.count[0] + k] * 2];

        row += value * w.along[0][k];
        along += value * g.along[0][k];
      }
      x += along * w.along[1][j];
      y += row * g.along[1][j];
    }
    det = (1. + x[0]) * (1. + y[1]) - x[1] * y[0];
    if (!(det > 0. && det <= PETSC_MAX_REAL)) {
      (*failed)++;
      continue;
    }
    for (PetscInt b = 0; b < 2; b++) {
      to[b]     = (1. + x[0]) * F[b] + y[0] * F[2 + b];
      to[2 + b] = x[1] * F[b] + (1. + y[1]) * F[2 + b];
    }
    for (PetscInt k = 0; k < 4; k++) trial->stress[p * 4 + k] = 0.;
    for (PetscInt k = 1; k < kept; k++) trial->state[p * kept + k] = sum->points->state[p * kept + k];
    trial->state[p * kept] = sum->points->state[p * kept] / det;
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmBedUpdateColumns(const MpmSum *sum, const PetscReal u[], MpmTrial *trial, PetscInt *failed)
{
  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    MPM_DISPATCH(sum->layout, &sum->space->groups[g], Update, sum, &sum->space->groups[g], u, trial, failed);
  PetscFunctionReturn(PETSC_SUCCESS);
}
