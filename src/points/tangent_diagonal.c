/*
  The diagonal blocks of the points' Jacobian.
*/
#include "space/element_block.h"
#include "points/point_tangent.h"

static void CouplingAddToDiagonal(const MpmSum *sum, const MpmCell *cell, const MpmModeCoupling mode,
                                  PetscReal blocks[])
{
  const MpmGroup *box   = &sum->space->groups[cell->box];
  const PetscInt  bs    = sum->block;
  const PetscInt *nodes = &sum->space->group_nodes[box->node_offset];

  for (PetscInt i = 0; i < box->node_count; i++) {
    const PetscReal *a = &mode.flux_by_mean[i * bs], *b = &mode.mean_by_u[i * bs], *f = &mode.f_by_u[i * bs];

    for (PetscInt c = 0; nodes[i] >= 0 && c < bs; c++)
      for (PetscInt d = 0; d < bs; d++) blocks[(nodes[i] * bs + c) * bs + d] += a[c] * b[d] + b[c] * f[d];
  }
}

/* The diagonal blocks of one group's nodes. */
MPM_INLINE PetscErrorCode DiagonalGroup(const MpmKnown known, const MpmSum *sum, const MpmGroup *group,
                                        const PetscReal u[], MpmWorkspace *work, Target *to, PetscInt *failed)
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];

  MpmSumGather(known, sum, group, u, work->values);
  for (PetscInt s = group->point_begin; s < group->point_end; s++) {
    Point at;

    if (!PointTangent(known, sum, s, work, &to->coupling, &at)) {
      (*failed)++;
      continue;
    }
    MpmSumAddDiagonal(known, sum->layout, &at.basis, at.tangent, nodes, to->blocks);
  }
  return PETSC_SUCCESS;
}

PetscErrorCode MpmPointsDiagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                                 PetscInt *failed)
{
  const MpmSpace *space = sum->space;
  Target          to    = {.blocks = blocks};
  MpmWorkspace    work;

  PetscFunctionBeginUser;
  (void)ctx;
  if (space->cells.spread) {
    const MpmElementAction action  = {.blocks = blocks};
    MpmPattern             pattern = {.block = sum->block, .dim = space->dim, .action = &action};

    PetscFunctionReturn(MpmSpreadTangent(sum, u, &pattern, NULL, failed));
  }
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(MpmCouplingCreate(sum, &to.coupling));
  for (PetscInt unit = 0; unit < MpmUnitCount(sum); unit++) {
    const MpmCell groups = MpmUnitGroups(sum, unit);

    PetscCall(MpmCouplingBegin(sum, &groups, u, &to.coupling, failed));
    if (sum->layout->means && *failed) break;
    for (PetscInt g = groups.group_begin; g < groups.group_end; g++) {
      const MpmGroup *group = &space->groups[g];

      MPM_DISPATCH(sum->layout, group, DiagonalGroup, sum, group, u, &work, &to, failed);
      PetscCall(MpmCouplingAddGroup(sum, group, &to.coupling));
    }
    if (sum->layout->means) {
      MpmCouplingEnd(sum, &groups, &to.coupling);
      for (PetscInt i = 0; i < to.coupling.modes; i++) CouplingAddToDiagonal(sum, &groups, to.coupling.mode[i], blocks);
    }
  }
  PetscCall(MpmCouplingDestroy(&to.coupling));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}
