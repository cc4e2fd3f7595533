/*
  The conditions as they act on a step's unknowns: which are prescribed and to what, what that makes of vectors and
  blocks, and the reactions.

  A reaction is the force of the support on the body, the internal less the external forces at the constrained nodes.
*/
#include "geometry/geometry.h"
#include "point/layout.h"
#include "grid/grid.h"
#include "space/space.h"
#include "bc/bc.h"
#include "bc/body_motion.h"

PetscErrorCode MpmConstraintsReset(MpmConstraints *constraints)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(constraints->condition));
  PetscCall(PetscFree(constraints->value));
  PetscCall(PetscFree(constraints->frame_of));
  PetscCall(PetscFree(constraints->frames));
  constraints->any = constraints->scaled = PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscReal MpmStepFactor(const MpmPrescription *step, PetscInt b, PetscBool increment)
{
  const PetscInt  count  = step->conditions->count;
  const MpmRamp   ramp   = b < count ? step->conditions->at[b].ramp : step->motions->at[b - count].ramp;
  const PetscReal start  = step->acting[b].start;
  const PetscInt  order  = b < count ? (PetscInt)step->conditions->at[b].quantity : 0;
  const PetscReal before = increment && step->time_n > start ? MpmRampIntegral(ramp, step->time_n - start, order) : 0.;

  if (step->rate) return MpmRampIntegral(ramp, step->time - start, order - step->rate);
  return MpmRampIntegral(ramp, step->time - start, order) - before;
}

PetscBool MpmConditionHolds(const MpmPrescription *step, PetscInt b, const PetscReal x[])
{
  return (PetscBool)(step->acting[b].active && !step->conditions->at[b].absorbing &&
                     MpmRegionContains(step->conditions->at[b].region, x));
}

/* By which regions select a node: conditions go with the grid. */
static void NodePosition(const MpmGrid *grid, const MpmSpace *space, PetscInt node, PetscReal x[])
{
  PetscInt at[MPM_MAX_DIM];

  MpmSpaceAt(space, &space->node[node * grid->dim], at);
  MpmGridNodeAtStart(grid, at, x);
}

/* ---- motions ---- */

#define SAME 1e-9 /* of two displacements: tolerance of equal ones by rounding */

/* Motions at a node: prescribed axes, the motion of each, and its increment in the step. */
typedef struct {
  PetscInt  motion[MPM_MAX_DIM]; /* behind the conditions; -1: none */
  PetscReal value[MPM_MAX_DIM];
  PetscInt  contradicts; /* a motion that others contradict, by its place in the list, or -1 */
  PetscBool any;
} NodeMotion;

static PetscBool Differ(PetscReal a, PetscReal b)
{
  return (PetscBool)(PetscAbsReal(a - b) > SAME * PetscMax(PetscAbsReal(a), PetscAbsReal(b)));
}

/* `mark` has a number for each motion, positive where its points touch the node; NULL where none acts. */
static NodeMotion MotionAt(const MpmPrescription *step, const PetscReal *mark)
{
  NodeMotion node = {.motion = {-1, -1, -1}, .contradicts = -1};

  for (PetscInt m = 0; mark && m < step->motions->count; m++) {
    const MpmBodyMotion *motion = &step->motions->at[m];
    const PetscInt       index  = step->conditions->count + m;

    for (PetscInt k = 0; k < motion->component_count && mark[m] > 0.; k++) {
      const PetscInt  c     = motion->component[k];
      const PetscReal value = motion->value[k] * MpmStepFactor(step, index, PETSC_TRUE);

      node.any = PETSC_TRUE;
      if (node.motion[c] >= 0 && Differ(node.value[c], value)) node.contradicts = m;
      node.motion[c] = index;
      node.value[c]  = value;
    }
  }
  return node;
}

/* Notes a motion of the node, behind so many conditions, that contradicts a . u = g. */
static void CheckEquation(NodeMotion *node, PetscInt conditions, PetscInt dim, const PetscReal a[], PetscReal g)
{
  PetscReal along = 0., scale = PetscAbsReal(g);

  for (PetscInt c = 0; c < dim; c++) {
    if (a[c] != 0. && node->motion[c] < 0) return;
    if (a[c] == 0.) continue;
    along += a[c] * node->value[c];
    scale += PetscAbsReal(a[c] * node->value[c]);
  }
  for (PetscInt c = 0; c < dim && PetscAbsReal(along - g) > SAME * scale; c++)
    if (a[c] != 0.) node->contradicts = node->motion[c] - conditions;
}

/* Motions take the nodes that have no frame. */
static void PrescribeMotions(MpmConstraints *constraints, const MpmPrescription *step, const PetscReal marks[],
                             const MpmSpace *space, PetscInt *contradicts)
{
  for (PetscInt i = 0; i < space->local; i++) {
    const NodeMotion node = MotionAt(step, &marks[i * step->motions->count]);

    *contradicts = PetscMax(*contradicts, node.contradicts);
    if (!node.any || (constraints->frame_of && constraints->frame_of[i] >= 0)) continue;
    constraints->any = PETSC_TRUE;
    for (PetscInt c = 0; c < constraints->dim; c++) {
      const PetscInt k = i * constraints->block + c;

      if (node.motion[c] < 0) continue;
      if (!MpmConstraintsFree(constraints, k) && Differ(constraints->value[k], node.value[c]))
        *contradicts = PetscMax(*contradicts, node.motion[c] - step->conditions->count);
      constraints->condition[k] = node.motion[c];
      constraints->value[k]     = node.value[c];
    }
  }
}

/* ---- frames ---- */

/* The frame of a node from the motions and all conditions that hold it; among these the last one counts first. */
static void MakeFrame(const MpmPrescription *step, const PetscReal x[], PetscInt dim, NodeMotion *node, MpmFrame *frame)
{
  for (PetscInt c = 0; c < dim; c++) {
    PetscReal axis[MPM_MAX_DIM] = {0., 0., 0.};

    axis[c] = 1.;
    if (node->motion[c] >= 0) MpmFrameAdd(frame, dim, axis, node->value[c], node->motion[c]);
  }
  for (PetscInt b = step->conditions->count - 1; b >= 0; b--) {
    const MpmCondition *bc     = &step->conditions->at[b];
    const PetscReal     factor = MpmStepFactor(step, b, PETSC_TRUE);

    if (!MpmConditionHolds(step, b, x)) continue;
    if (bc->inclined) {
      CheckEquation(node, step->conditions->count, dim, bc->normal, bc->value[0] * factor);
      MpmFrameAdd(frame, dim, bc->normal, bc->value[0] * factor, b);
      continue;
    }
    for (PetscInt k = 0; k < bc->component_count; k++) {
      PetscReal axis[MPM_MAX_DIM] = {0., 0., 0.};

      if (bc->component[k] >= dim) continue;
      axis[bc->component[k]] = 1.;
      CheckEquation(node, step->conditions->count, dim, axis, bc->value[k] * factor);
      MpmFrameAdd(frame, dim, axis, bc->value[k] * factor, b);
    }
  }
  MpmFrameComplete(frame, dim);
}

/* The frames of this step's nodes, and their conditions. */
static PetscErrorCode SetUpFrames(MpmConstraints *constraints, const MpmPrescription *step, const PetscReal *marks,
                                  const MpmGrid *grid, const MpmSpace *space, PetscInt *contradicts)
{
  const PetscInt bs    = constraints->block;
  PetscInt       count = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(space->local, &constraints->frame_of));
  for (PetscInt i = 0; i < space->local; i++) {
    PetscReal x[MPM_MAX_DIM];

    constraints->frame_of[i] = -1;
    if (MpmSpaceIsExtra(space, i)) continue;
    NodePosition(grid, space, i, x);
    for (PetscInt b = 0; b < step->conditions->count && constraints->frame_of[i] < 0; b++)
      if (step->conditions->at[b].inclined && MpmConditionHolds(step, b, x)) constraints->frame_of[i] = count++;
  }
  PetscCall(PetscCalloc1(count, &constraints->frames));
  for (PetscInt i = 0; i < space->local; i++) {
    PetscReal x[MPM_MAX_DIM];

    if (constraints->frame_of[i] < 0) continue;
    MpmFrame  *frame = &constraints->frames[constraints->frame_of[i]];
    NodeMotion node  = MotionAt(step, marks ? &marks[i * step->motions->count] : NULL);

    NodePosition(grid, space, i, x);
    MakeFrame(step, x, grid->dim, &node, frame);
    *contradicts = PetscMax(*contradicts, node.contradicts);
    for (PetscInt r = 0; r < grid->dim; r++) {
      constraints->condition[i * bs + r] = r < frame->constrained ? frame->condition[r] : MPM_FREE;
      constraints->value[i * bs + r]     = r < frame->constrained ? frame->value[r] : 0.;
    }
    constraints->any = PETSC_TRUE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Unknowns of fields whose shape does not reach the node. */
static void LeaveOutUnsupported(MpmConstraints *constraints, const MpmLayout *layout, const MpmSpace *space)
{
  for (PetscInt k = 0; space->shapes.support && k < space->local * layout->block; k++) {
    if (space->shapes.support[k / layout->block] & 1 << layout->component[k % layout->block].shape) continue;
    constraints->condition[k] = MPM_UNSUPPORTED;
    constraints->value[k]     = 0.;
    constraints->any          = PETSC_TRUE;
  }
}

/* Extra nodes have the unknowns that their terms give them. */
static void LeaveOutUnused(MpmConstraints *constraints, PetscInt bs, const MpmSpace *space)
{
  for (PetscInt k = 0; k < space->extra.count * bs; k++) {
    const PetscInt unknown = space->extra.begin * bs + k;

    constraints->value[unknown] = 0.;
    if (space->extra.free[k / bs] >> k % bs & 1) constraints->condition[unknown] = MPM_FREE;
    else {
      constraints->condition[unknown] = MPM_UNSUPPORTED;
      constraints->any                = PETSC_TRUE;
    }
  }
}

/* The components that condition b prescribes at the nodes in its region. */
static PetscErrorCode PrescribeComponents(MpmConstraints *constraints, const MpmPrescription *step, PetscInt b,
                                          const MpmGrid *grid, const MpmLayout *layout, const MpmSpace *space)
{
  const MpmCondition *bc = &step->conditions->at[b];
  const PetscInt      bs = layout->block;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < space->local; i++) {
    PetscReal x[MPM_MAX_DIM], here[MPM_MAX_BLOCK];

    if (MpmSpaceIsExtra(space, i)) continue;
    NodePosition(grid, space, i, x);
    if (!MpmConditionHolds(step, b, x)) continue;
    if (bc->field.function) PetscCall((*bc->field.function)(grid->dim, x, here, bc->field.ctx));
    for (PetscInt k = 0; k < bc->component_count; k++) {
      const PetscInt  c     = bc->component[k];
      const PetscReal value = bc->field.function ? here[k] : bc->value[k];

      constraints->condition[i * bs + c] = b;
      constraints->value[i * bs + c]     = value * MpmStepFactor(step, b, layout->component[c].increment);
      constraints->any                   = PETSC_TRUE;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Unit of a component's values, over h, where a node's typical stiffness is K h^(dim - 2); to a power of 2. */
static PetscReal Unit(MpmScale scale, PetscReal stiffness, PetscReal h, PetscInt dim)
{
  const PetscReal K = scale == MPM_SCALE_STRESS ? stiffness / PetscPowRealInt(h, dim - 2) : 1.;

  if (scale == MPM_SCALE_LENGTH || !(K > 0.)) return 1.;
  return PetscPowReal(2., PetscFloorReal(PetscLog2Real(K / h) + 0.5));
}

/* On the axis of symmetry nothing moves along the radius. */
static void HoldAxis(MpmConstraints *constraints, const MpmGrid *grid, const MpmSpace *space)
{
  for (PetscInt i = 0; grid->axial && grid->lower[0] == 0. && i < space->local; i++) {
    const PetscInt unknown = i * constraints->block;

    if (space->node[i * grid->dim] || MpmSpaceIsExtra(space, i) || MpmConstraintsFrame(constraints, i)) continue;
    if (!MpmConstraintsFree(constraints, unknown)) continue;
    constraints->condition[unknown] = MPM_HELD;
    constraints->value[unknown]     = 0.;
    constraints->any                = PETSC_TRUE;
  }
}

PetscErrorCode MpmConstraintsSetUp(MpmConstraints *constraints, const MpmPrescription *step, const MpmGrid *grid,
                                   const MpmLayout *layout, const MpmSpace *space, PetscInt *contradicts)
{
  const PetscInt bs       = layout->block;
  PetscBool      inclined = PETSC_FALSE;
  PetscReal     *marks;

  PetscFunctionBeginUser;
  *contradicts = -1;
  PetscCall(MpmConstraintsReset(constraints));
  constraints->dim      = grid->dim;
  constraints->block    = bs;
  constraints->diagonal = step->diagonal;
  for (PetscInt c = 0; c < bs; c++) {
    constraints->unit[c] =
      Unit(layout->component[c].scale, step->diagonal / MpmGridTurn(grid, grid->upper[0]), grid->h[0], grid->dim);
    if (constraints->unit[c] != 1.) constraints->scaled = PETSC_TRUE;
  }
  PetscCall(PetscMalloc1((space->local * bs), &constraints->condition));
  PetscCall(PetscCalloc1((space->local * bs), &constraints->value));
  for (PetscInt k = 0; k < space->local * bs; k++) constraints->condition[k] = MPM_FREE;
  for (PetscInt b = 0; b < step->conditions->count; b++) {
    if (!step->acting[b].active) continue;
    if (step->conditions->at[b].inclined) inclined = PETSC_TRUE;
    else PetscCall(PrescribeComponents(constraints, step, b, grid, layout, space));
  }
  PetscCall(
    MpmBodyMotionsTouch(step->motions, &step->acting[step->conditions->count], grid, space, step->particles, &marks));
  if (inclined) PetscCall(SetUpFrames(constraints, step, marks, grid, space, contradicts));
  if (marks) PrescribeMotions(constraints, step, marks, space, contradicts);
  HoldAxis(constraints, grid, space);
  LeaveOutUnsupported(constraints, layout, space);
  LeaveOutUnused(constraints, bs, space);
  MpmUnitsOver(constraints, space->local * bs, constraints->value);
  if (!marks) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(marks));
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, contradicts, 1, MPIU_INT, MPI_MAX, grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmConstraintsFollow(MpmConstraints *constraints, const MpmLayout *layout, const MpmSpace *space)
{
  const PetscInt bs = constraints->block;

  for (PetscInt f = 0; f < space->extension.count; f++) {
    const PetscInt node = space->extension.follower[f];

    if (MpmConstraintsFrame(constraints, node)) continue;
    for (PetscInt c = 0; c < bs; c++) {
      if (layout->component[c].shape || !MpmConstraintsFree(constraints, node * bs + c)) continue;
      constraints->condition[node * bs + c] = MPM_FOLLOWS;
      constraints->value[node * bs + c]     = 0.;
      constraints->any                      = PETSC_TRUE;
    }
  }
}

void MpmConstraintsExtend(const MpmConstraints *constraints, const MpmSpace *space, PetscReal values[])
{
  const MpmExtension *extension = &space->extension;
  const PetscInt      bs        = constraints->block;

  for (PetscInt f = 0; f < extension->count; f++) {
    for (PetscInt c = 0; c < bs; c++) {
      const PetscInt at  = extension->follower[f] * bs + c;
      PetscReal      sum = 0.;

      if (constraints->condition[at] != MPM_FOLLOWS) continue;
      for (PetscInt k = extension->offset[f]; k < extension->offset[f + 1]; k++)
        sum += extension->weight[k] * values[extension->master[k] * bs + c];
      values[at] = sum;
    }
  }
}

void MpmConstraintsGather(const MpmConstraints *constraints, const MpmSpace *space, PetscReal forces[])
{
  const MpmExtension *extension = &space->extension;
  const PetscInt      bs        = constraints->block;

  for (PetscInt f = 0; f < extension->count; f++) {
    for (PetscInt c = 0; c < bs; c++) {
      const PetscInt at = extension->follower[f] * bs + c;

      if (constraints->condition[at] != MPM_FOLLOWS) continue;
      for (PetscInt k = extension->offset[f]; k < extension->offset[f + 1]; k++)
        forces[extension->master[k] * bs + c] += extension->weight[k] * forces[at];
      forces[at] = 0.;
    }
  }
}

void MpmConstraintsHold(MpmConstraints *constraints, PetscInt unknown, PetscReal value)
{
  constraints->condition[unknown] = MPM_HELD;
  constraints->value[unknown]     = value / constraints->unit[unknown % constraints->block];
  constraints->any                = PETSC_TRUE;
}

void MpmUnitsTimes(const MpmConstraints *constraints, PetscInt count, PetscReal values[])
{
  if (!constraints->scaled) return;
  for (PetscInt k = 0; k < count; k++) values[k] *= constraints->unit[k % constraints->block];
}

void MpmUnitsOver(const MpmConstraints *constraints, PetscInt count, PetscReal values[])
{
  if (!constraints->scaled) return;
  for (PetscInt k = 0; k < count; k++) values[k] /= constraints->unit[k % constraints->block];
}

void MpmUnitsTimesRows(const MpmConstraints *constraints, PetscInt width, PetscReal rows[])
{
  const PetscInt bs = constraints->block;

  for (PetscInt c = 0; c < bs && constraints->scaled; c++)
    for (PetscInt k = 0; k < width * bs; k++)
      rows[c * width * bs + k] *= constraints->unit[c] * constraints->unit[k % bs];
}

void MpmConstraintsPrescribe(const MpmConstraints *constraints, PetscInt count, PetscScalar x[])
{
  for (PetscInt k = 0; k < count; k++)
    if (!MpmConstraintsFree(constraints, k)) x[k] = constraints->value[k];
}

void MpmConstraintsZero(const MpmConstraints *constraints, PetscInt count, PetscScalar x[])
{
  for (PetscInt k = 0; k < count; k++)
    if (!MpmConstraintsFree(constraints, k)) x[k] = 0.;
}

void MpmConstraintsMultiply(const MpmConstraints *constraints, PetscInt count, const PetscScalar x[], PetscScalar y[])
{
  for (PetscInt k = 0; k < count; k++)
    if (!MpmConstraintsFree(constraints, k)) y[k] = constraints->diagonal * x[k];
}

void MpmConstraintsResidual(const MpmConstraints *constraints, PetscInt count, const PetscScalar x[],
                            PetscScalar residual[])
{
  for (PetscInt k = 0; k < count; k++)
    if (!MpmConstraintsFree(constraints, k)) residual[k] = constraints->diagonal * (x[k] - constraints->value[k]);
}

void MpmConstraintsBlocks(const MpmConstraints *constraints, PetscInt nodes, PetscReal blocks[])
{
  const PetscInt bs = constraints->block;

  for (PetscInt k = 0; k < nodes * bs; k++) {
    PetscReal *block = &blocks[k / bs * bs * bs];

    if (MpmConstraintsFree(constraints, k)) continue;
    for (PetscInt c = 0; c < bs; c++) block[(k % bs) * bs + c] = block[c * bs + k % bs] = 0.;
    block[(k % bs) * (bs + 1)] = constraints->diagonal;
  }
}

/* A node with a frame: each equation a_r . u = g_r has its own force, along a_r. */
static void AddFrameReactions(const MpmFrame *frame, PetscInt dim, PetscInt block, const PetscReal force[],
                              PetscReal reaction[])
{
  PetscReal amount[MPM_MAX_DIM];

  MpmFrameForces(frame, dim, force, amount);
  for (PetscInt r = 0; r < frame->constrained; r++) {
    for (PetscInt c = 0; c < dim; c++) {
      PetscReal a = 0.;

      for (PetscInt k = 0; k <= r; k++) a += frame->factor[r][k] * frame->axis[k][c];
      reaction[frame->condition[r] * block + c] += amount[r] * a;
    }
  }
}

void MpmConstraintsAddReactions(const MpmConstraints *constraints, PetscInt block, PetscInt owned,
                                const PetscReal residual[], PetscReal reaction[])
{
  for (PetscInt k = 0; k < owned * block; k++) {
    const MpmFrame *frame = MpmConstraintsFrame(constraints, k / block);

    if (frame && k % block == 0) AddFrameReactions(frame, constraints->dim, block, &residual[k], reaction);
    if (frame && k % block < constraints->dim) continue;
    if (constraints->condition[k] >= 0) reaction[constraints->condition[k] * block + k % block] += residual[k];
  }
}
