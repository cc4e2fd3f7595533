/*
  Elimination of followers from the Jacobian: E^T K E, entry by entry, of what a rank has summed.

  A follower's row and column go to its masters. At a node with a frame the master's unknowns are components in the
  frame, and its part is turned.
*/
#include "space/space.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/sparsity_impl.h"

/* A node to which a row or column of another goes, and by how much component c there counts in its unknown r. */
typedef struct {
  PetscInt        node;
  PetscReal       factor[MPM_MAX_BLOCK]; /* of each component */
  const MpmFrame *frame;
} Target;

/* The k-th target of a node: 0 is itself, for components that do not follow. PETSC_FALSE where nothing goes there. */
static PetscBool TargetOf(const MpmPattern *pattern, const MpmSpace *space, PetscInt node, PetscInt k, Target *target)
{
  const MpmConstraints *constraints = pattern->constraints;
  const MpmExtension   *extension   = &space->extension;
  const PetscInt        f = extension->of[node], bs = pattern->block, at = f < 0 ? 0 : extension->offset[f] + k - 1;
  PetscBool             any = PETSC_FALSE;

  target->node  = k ? extension->master[at] : node;
  target->frame = k ? MpmConstraintsFrame(constraints, target->node) : NULL;
  for (PetscInt c = 0; c < bs; c++) {
    const PetscBool follows = (PetscBool)(constraints->condition[node * bs + c] == MPM_FOLLOWS);

    target->factor[c] = k ? (follows ? extension->weight[at] : 0.) : (follows ? 0. : 1.);
    if (target->factor[c] != 0.) any = PETSC_TRUE;
  }
  return any;
}

static PetscInt TargetCount(const MpmSpace *space, PetscInt node)
{
  const PetscInt f = space->extension.of[node];

  return f < 0 ? 1 : 1 + space->extension.offset[f + 1] - space->extension.offset[f];
}

/* By how much component c counts in the target's unknown r. */
static inline PetscReal Part(const Target *target, PetscInt dim, PetscInt r, PetscInt c)
{
  if (target->frame && r < dim && c < dim) return target->factor[c] * target->frame->axis[r][c];
  return r == c ? target->factor[c] : 0.;
}

/* Adds a block to the entry of two targets. */
static void AddBlock(MpmPattern *pattern, const MpmSpace *space, const Target *row, const Target *column,
                     const PetscReal block[])
{
  const MpmConstraints *constraints = pattern->constraints;
  const PetscInt        bs = pattern->block, dim = space->dim;
  const PetscInt        width = (pattern->row[row->node + 1] - pattern->row[row->node]) * bs;
  PetscReal *to = pattern->value[row->node] + MpmPatternPosition(pattern, space, row->node, column->node) * bs;

  for (PetscInt r = 0; r < bs; r++) {
    if (!MpmConstraintsFree(constraints, row->node * bs + r)) continue;
    for (PetscInt q = 0; q < bs; q++) {
      PetscReal sum = 0.;

      if (!MpmConstraintsFree(constraints, column->node * bs + q)) continue;
      if (!row->frame && !column->frame) {
        to[r * width + q] += row->factor[r] * column->factor[q] * block[r * bs + q];
        continue;
      }
      for (PetscInt c = 0; c < bs; c++)
        for (PetscInt d = 0; d < bs; d++) sum += Part(row, dim, r, c) * block[c * bs + d] * Part(column, dim, q, d);
      to[r * width + q] += sum;
    }
  }
}

/* Moves the entry of a pair of nodes to their targets. */
static void Move(MpmPattern *pattern, const MpmSpace *space, PetscInt i, PetscInt j)
{
  const PetscInt bs = pattern->block, width = (pattern->row[i + 1] - pattern->row[i]) * bs;
  const PetscInt rows = TargetCount(space, i), columns = TargetCount(space, j);
  PetscReal     *from = pattern->value[i] + MpmPatternPosition(pattern, space, i, j) * bs;
  PetscReal      block[MPM_MAX_BLOCK * MPM_MAX_BLOCK];
  Target         row, column;
  PetscBool      any = PETSC_FALSE;

  for (PetscInt k = 0; k < bs * bs; k++) {
    block[k] = from[k / bs * width + k % bs];
    if (block[k] != 0.) any = PETSC_TRUE;
    from[k / bs * width + k % bs] = 0.;
  }
  for (PetscInt q = 0; any && q < columns; q++) {
    if (!TargetOf(pattern, space, j, q, &column)) continue;
    for (PetscInt r = 0; r < rows; r++)
      if (TargetOf(pattern, space, i, r, &row)) AddBlock(pattern, space, &row, &column, block);
  }
}

/* A pair that a follower makes; the transposed pair is the other's where that one follows too. */
static void MovePair(MpmPattern *pattern, const MpmSpace *space, PetscInt follower, PetscInt other)
{
  Move(pattern, space, follower, other);
  if (space->extension.of[other] < 0) Move(pattern, space, other, follower);
}

void MpmPatternEliminate(MpmPattern *pattern, const MpmSpace *space)
{
  const MpmExtension *extension = &space->extension;

  for (PetscInt f = 0; f < extension->count; f++) {
    const PetscInt s = extension->follower[f];

    for (PetscInt w = 0; w < pattern->window; w++)
      if (pattern->slot[s * pattern->window + w] >= 0)
        MovePair(pattern, space, s, pattern->neighbour[s * pattern->window + w]);
    for (PetscInt k = pattern->far.start[s]; k < pattern->far.start[s + 1]; k++)
      MovePair(pattern, space, s, pattern->far.column[k]);
  }
}
