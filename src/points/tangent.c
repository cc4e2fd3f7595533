/*
  The Jacobian, point by point: the kernel on duals that are seeded with the point's inputs gives the point's D, and the
  element block of a group is the sum of B^T D B over its points. Where the physics has a mean, each cell adds the
  products of a few vectors over all of its nodes.
*/
#include "assembly/terms.h"
#include "points/element_group.h"
#include "points/point_terms.h"

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmSpace *space = sum->space;
  const PetscInt  most = PetscPowInt(space->width, space->dim), bs = sum->block;
  Target          to = {.residual = residual};
  MpmWorkspace    work;

  PetscFunctionBeginUser;
  (void)ctx;
  if (space->cells.spread) PetscFunctionReturn(MpmSpreadTangent(sum, u, pattern, residual, failed));
  PetscCall(MpmWorkspaceCreate(sum, &work));
  PetscCall(MpmCouplingCreate(sum, &to.coupling));
  PetscCall(PetscMalloc2((most * most * bs * bs), &to.element, (most * bs * sum->layout->input.count), &to.rows));
  for (PetscInt unit = 0; unit < MpmUnitCount(sum); unit++) {
    const MpmCell groups = MpmUnitGroups(sum, unit);

    PetscCall(MpmCouplingBegin(sum, &groups, u, &to.coupling, failed));
    if (sum->layout->means && *failed) break;
    for (PetscInt g = groups.group_begin; g < groups.group_end; g++) {
      const MpmGroup *group = &space->groups[g];

      PetscCall(MpmElementGroup(sum, group, u, &work, &to, failed));
      PetscCall(MpmCouplingAddGroup(sum, group, &to.coupling));
      MpmPatternAddBlock(pattern, space, group, to.element);
    }
    if (sum->layout->means) {
      MpmCouplingEnd(sum, &groups, &to.coupling);
      for (PetscInt i = 0; i < to.coupling.modes; i++) {
        const MpmModeCoupling mode = to.coupling.mode[i];

        MpmPatternAddPair(pattern, space, &space->groups[groups.box], mode.flux_by_mean, mode.mean_by_u, mode.f_by_u);
      }
    }
  }
  PetscCall(PetscFree2(to.element, to.rows));
  PetscCall(MpmCouplingDestroy(&to.coupling));
  PetscCall(PetscFree(work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermPoints    = {.name     = "points",
                                  .points   = MpmPointsTrial,
                                  .residual = MpmPointsResidual,
                                  .tangent  = Tangent,
                                  .diagonal = MpmPointsDiagonal};
const MpmTerm MpmTermCellMeans = {.name     = "points with cell means",
                                  .points   = MpmCellsTrial,
                                  .boxes    = MpmCellsBoxes,
                                  .residual = MpmCellsResidual,
                                  .tangent  = Tangent,
                                  .diagonal = MpmPointsDiagonal};
