#pragma once
/*
  Parts of the sparsity that sparsity.c, pattern_blocks.c, pattern_matrix.c, far_entries.c and followers.c share.
*/
#include "space/space.h"
#include "assembly/sparsity.h"

/* The slot of a local node in the window of another, or NULL where it has none. */
PetscInt *MpmPatternSlot(const MpmPattern *pattern, const MpmSpace *space, PetscInt row, PetscInt column);
/* Where a local node stands in the row of another one that it is coupled with. */
PetscInt MpmPatternPosition(const MpmPattern *pattern, const MpmSpace *space, PetscInt row, PetscInt column);
/* Lists the entries of extra nodes, of coupled boxes and of masters, by row; `neighbour`: as in MpmPattern. */
PetscErrorCode MpmPatternMarkFar(MpmPattern *pattern, const MpmSpace *space, const PetscInt neighbour[]);
/* A block of n local nodes, -1 for holes, stored [i][c][c'][j], and the products a b^T + b c^T of vectors [i][c]. */
void MpmElementActNodes(const MpmElementAction *action, PetscInt bs, PetscInt n, const PetscInt nodes[],
                        const PetscReal element[]);
void MpmElementActPair(const MpmElementAction *action, PetscInt bs, PetscInt n, const PetscInt nodes[],
                       const PetscReal a[], const PetscReal b[], const PetscReal c[]);
/* How many of them a row has. */
static inline PetscInt MpmPatternFarCount(const MpmPattern *pattern, PetscInt row)
{
  return pattern->far.start ? pattern->far.start[row + 1] - pattern->far.start[row] : 0;
}
/* Brings rows and columns of followers to those that they follow (followers.c): E^T K E of this rank's part. */
void MpmPatternEliminate(MpmPattern *pattern, const MpmSpace *space);
/*
  Offsets in the window of a group's nodes, relative to its first node: the entry (i, j) stands at center + offset[j] -
  offset[i].
*/
static inline PetscInt MpmPatternOffsets(const MpmPattern *pattern, const MpmGroup *group, PetscInt offset[])
{
  const PetscInt side = 2 * pattern->reach + 1;
  PetscInt       n    = 0;

  for (PetscInt k = 0; k < group->count[2]; k++)
    for (PetscInt j = 0; j < group->count[1]; j++)
      for (PetscInt i = 0; i < group->count[0]; i++) offset[n++] = (k * side + j) * side + i;
  return (pattern->window - 1) / 2;
}
