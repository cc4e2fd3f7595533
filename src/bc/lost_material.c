/*
  Conditions that lose the material which they move.

  Nodes do not move with the material: a body that a condition pushes may leave the nodes of the condition. The
  remainder at them, or other material that takes its place, resists less and less. Therefore the volume at the nodes of
  a condition is watched, sum_p V_p sum_i w_ip, of the body with the largest such volume as the condition began to move
  in the stage. Volume that passes from one condition to another one that moves, too, is not lost. A condition without
  material may wait for it.
*/
#include "base/rows.h"
#include "geometry/geometry.h"
#include "grid/grid.h"
#include "particles/body.h"
#include "particles/points.h"
#include "space/basis.h"
#include "space/space.h"
#include "space/sum.h"
#include "bc/bc.h"

#define LOST 0.1 /* of the volume: with less a condition has lost its material */

PetscBool MpmConditionMoves(const MpmCondition *bc, PetscInt dim)
{
  if (bc->absorbing) return PETSC_FALSE;
  for (PetscInt k = 0; k < bc->component_count && !bc->inclined; k++)
    if (bc->component[k] < PetscMin(dim, bc->motion) && bc->value[k] != 0.) return PETSC_TRUE;
  return (PetscBool)(bc->inclined && bc->value[0] != 0.);
}

/* Adds the local nodes of condition b to those marked; `owned` of its nodes are this rank's own. */
static void MarkNodes(const MpmPrescription *step, PetscInt b, const MpmSum *sum, PetscBool mark[], PetscInt *owned)
{
  const MpmSpace *space = sum->space;

  *owned = 0;
  for (PetscInt i = 0; i < space->local; i++) {
    PetscInt  at[MPM_MAX_DIM];
    PetscReal x[MPM_MAX_DIM];

    if (MpmSpaceIsExtra(space, i)) continue;
    MpmSpaceAt(space, &space->node[i * space->dim], at);
    MpmGridNodeAtStart(sum->grid, at, x);
    if (!MpmConditionHolds(step, b, x)) continue;
    mark[i] = PETSC_TRUE;
    *owned += i < space->owned;
  }
}

/* Volume of each body at the marked nodes of a group; ids[2*k] and ids[2*k + 1] are the first id of body k and the one
   past its last. */
static void AddGroup(const MpmSum *sum, const MpmGroup *group, const PetscBool mark[], PetscInt bodies,
                     const PetscInt ids[], MpmBasis *basis, PetscReal volume[])
{
  const PetscInt *nodes = &sum->space->group_nodes[group->node_offset];
  PetscBool       any   = PETSC_FALSE;

  for (PetscInt i = 0; i < group->node_count; i++) any = (PetscBool)(any || (nodes[i] >= 0 && mark[nodes[i]]));
  for (PetscInt s = group->point_begin; s < group->point_end && any; s++) {
    const PetscInt p = sum->space->order[s];
    PetscReal      weight;

    MpmSpaceEvaluate(sum->space, group, p, basis);
    weight = MpmBasisMarked(sum->space, group, basis, mark);
    for (PetscInt k = 0; k < bodies; k++)
      if (sum->points->id[p] >= ids[2 * k] && sum->points->id[p] < ids[2 * k + 1])
        volume[k] += weight * sum->points->volume0[p];
  }
}

/* The volume that the marked nodes hold of each of so many bodies, over all ranks. */
static PetscErrorCode FindVolumes(const MpmSum *sum, const PetscBool mark[], PetscInt bodies, const PetscInt ids[],
                                  PetscReal volume[])
{
  MpmBasis basis;

  PetscFunctionBeginUser;
  PetscCall(MpmBasisCreate(sum->space, &basis));
  PetscCall(PetscArrayzero(volume, bodies));
  for (PetscInt g = 0; g < sum->space->group_count; g++)
    AddGroup(sum, &sum->space->groups[g], mark, bodies, ids, &basis, volume);
  PetscCall(MpmBasisDestroy(&basis));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, volume, (PetscMPIInt)bodies, MPIU_REAL, MPIU_SUM, sum->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The body with most volume at the marked nodes, and that volume; all points where a restarted run has no bodies. */
static PetscErrorCode BeginMoving(const MpmSum *sum, const PetscBool mark[], const MpmBodies *bodies, MpmActing *acting)
{
  PetscInt  *ids, most = 0;
  PetscReal *volume;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((2 * bodies->count + 2), &ids, (bodies->count + 1), &volume));
  for (PetscInt k = 0; k < bodies->count; k++) MpmBodyGetIds(bodies->at[k], &ids[2 * k], &ids[2 * k + 1]);
  ids[2 * bodies->count]     = 0;
  ids[2 * bodies->count + 1] = PETSC_INT_MAX;
  PetscCall(FindVolumes(sum, mark, bodies->count + 1, ids, volume));
  for (PetscInt k = 1; k < bodies->count; k++)
    if (volume[k] > volume[most]) most = k;
  if (!(volume[most] > 0.)) most = bodies->count;
  acting->first  = ids[2 * most];
  acting->end    = ids[2 * most + 1];
  acting->volume = volume[most];
  PetscCall(PetscFree2(ids, volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The conditions that move the material in the step; returns how many there are. */
static PetscInt ListMoving(const MpmPrescription *step, PetscInt dim, PetscInt moving[])
{
  PetscInt count = 0;

  for (PetscInt b = 0; b < step->conditions->count; b++) {
    if (!step->acting[b].active || !MpmConditionMoves(&step->conditions->at[b], dim)) continue;
    if (MpmStepFactor(step, b, PETSC_TRUE) != 0.) moving[count++] = b;
  }
  return count;
}

/* Which bodies the conditions begin to move that have not moved in the stage. */
static PetscErrorCode BeginAll(const MpmPrescription *step, MpmActing *acting, const MpmBodies *bodies,
                               const MpmSum *sum, PetscInt count, const PetscInt moving[], const PetscInt nodes[])
{
  PetscBool *mark;
  PetscInt   owned;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(sum->space->local, &mark));
  for (PetscInt k = 0; k < count; k++) {
    if (!nodes[k] || acting[moving[k]].volume > 0.) continue;
    for (PetscInt i = 0; i < sum->space->local; i++) mark[i] = PETSC_FALSE;
    MarkNodes(step, moving[k], sum, mark, &owned);
    PetscCall(BeginMoving(sum, mark, bodies, &acting[moving[k]]));
  }
  PetscCall(PetscFree(mark));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConditionsFindLost(const MpmPrescription *step, MpmActing *acting, const MpmBodies *bodies,
                                     const MpmSum *sum, PetscInt *lost, PetscReal *left)
{
  const PetscInt most = step->conditions->count;
  PetscInt       count, held = 0, *moving, *nodes, *ids;
  PetscReal     *volume;
  PetscBool     *mark = NULL;

  PetscFunctionBeginUser;
  *lost = -1;
  *left = 0.;
  PetscCall(PetscMalloc4(most, &moving, most, &nodes, (2 * most), &ids, most, &volume));
  count = ListMoving(step, sum->space->dim, moving);
  if (count) {
    PetscCall(PetscCalloc1(sum->space->local, &mark));
    for (PetscInt k = 0; k < count; k++) MarkNodes(step, moving[k], sum, mark, &nodes[k]);
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, nodes, (PetscMPIInt)count, MPIU_INT, MPI_SUM, sum->grid->comm));
    PetscCall(BeginAll(step, acting, bodies, sum, count, moving, nodes));
  }
  for (PetscInt k = 0; k < count; k++) {
    held += nodes[k];
    ids[2 * k]     = acting[moving[k]].first;
    ids[2 * k + 1] = acting[moving[k]].end;
  }
  if (count && !held) *lost = moving[0];
  if (held) PetscCall(FindVolumes(sum, mark, count, ids, volume));
  for (PetscInt k = 0; held && k < count && *lost < 0; k++) {
    if (volume[k] >= LOST * acting[moving[k]].volume) continue;
    *lost = moving[k];
    *left = volume[k] / acting[moving[k]].volume;
  }
  PetscCall(PetscFree(mark));
  PetscCall(PetscFree4(moving, nodes, ids, volume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmConditionsAddRows(const MpmConditions *conditions, MpmActing acting[], MpmRows *rows)
{
  PetscFunctionBeginUser;
  for (PetscInt b = 0; b < conditions->count; b++) {
    const MpmRow row[] = {
      {"first", MPM_ROW_INT, MPM_ROW_STATE, &acting[b].first, 0, 0},
      {"end", MPM_ROW_INT, MPM_ROW_STATE, &acting[b].end, 0, 0},
      {"volume", MPM_ROW_REAL, MPM_ROW_STATE, &acting[b].volume, 0, 0},
      {"force_x", MPM_ROW_REAL, MPM_ROW_STATE, &acting[b].force[0], 0, 0},
      {"force_y", MPM_ROW_REAL, MPM_ROW_STATE, &acting[b].force[1], 0, 0},
      {"force_z", MPM_ROW_REAL, MPM_ROW_STATE, &acting[b].force[2], 0, 0},
    };
    char *head = NULL;

    PetscCall(MpmTextAppend(&head, "condition_%s_", conditions->names[b]));
    PetscCall(MpmRowsAdd(rows, head, PETSC_STATIC_ARRAY_LENGTH(row), row));
    PetscCall(PetscFree(head));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
