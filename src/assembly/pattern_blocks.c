/*
  Element blocks into the rows of the pattern: those of boxes, of any coupled nodes, and products of vectors.
*/
#include "space/space.h"
#include "bc/bc.h"
#include "assembly/sparsity.h"
#include "assembly/sparsity_impl.h"

/* MpmPatternAddBlock() entry by entry. */
static void AddBlockWithHoles(MpmPattern *pattern, const PetscInt nodes[], const MpmGroup *group,
                              const PetscInt offset[], PetscInt center, const PetscReal element[])
{
  const MpmConstraints *constraints = pattern->constraints;
  const PetscInt        n = group->node_count, bs = pattern->block;

  for (PetscInt k = 0; k < n * bs * bs; k++) {
    const PetscInt i = k / (bs * bs), c = k / bs % bs, d = k % bs;

    if (nodes[i] < 0 || !MpmConstraintsCounts(constraints, nodes[i] * bs + c)) continue;
    const PetscInt *slot  = &pattern->slot[nodes[i] * pattern->window + center - offset[i]];
    const PetscInt  width = (pattern->row[nodes[i] + 1] - pattern->row[nodes[i]]) * bs;

    for (PetscInt j = 0; j < n; j++) {
      if (nodes[j] < 0 || !MpmConstraintsCounts(constraints, nodes[j] * bs + d)) continue;
      pattern->value[nodes[i]][c * width + slot[offset[j]] * bs + d] += element[k * n + j];
    }
  }
}

void MpmPatternAddBlock(MpmPattern *pattern, const MpmSpace *space, const MpmGroup *group, PetscReal element[])
{
  const MpmConstraints *constraints = pattern->constraints;
  const PetscInt        n = group->node_count, bs = pattern->block;
  const PetscInt       *nodes = &space->group_nodes[group->node_offset];
  PetscInt              offset[MPM_MAX_WIDTH * MPM_MAX_WIDTH * MPM_MAX_WIDTH];

  if (pattern->action) {
    MpmElementActNodes(pattern->action, bs, n, nodes, element);
    return;
  }
  const PetscInt center = MpmPatternOffsets(pattern, group, offset);

  MpmFramesRotateElement(constraints, bs, n, nodes, element);
  if (group->holes) {
    AddBlockWithHoles(pattern, nodes, group, offset, center, element);
    return;
  }
  if (constraints->any) {
    for (PetscInt i = 0; i < n; i++) {
      for (PetscInt c = 0; c < bs; c++) {
        if (MpmConstraintsCounts(constraints, nodes[i] * bs + c)) continue;
        for (PetscInt k = 0; k < n * bs; k++) {
          element[(i * bs + c) * bs * n + k] = 0.; /* the row of (i, c) */
          element[(k * bs + c) * n + i]      = 0.; /* its column */
        }
      }
    }
  }
  for (PetscInt i = 0; i < n; i++) {
    const PetscInt *slot  = &pattern->slot[nodes[i] * pattern->window + center - offset[i]];
    const PetscInt  width = (pattern->row[nodes[i] + 1] - pattern->row[nodes[i]]) * bs;
    PetscInt        place[MPM_MAX_WIDTH * MPM_MAX_WIDTH * MPM_MAX_WIDTH];

    for (PetscInt j = 0; j < n; j++) place[j] = slot[offset[j]] * bs;
    for (PetscInt k = 0; k < bs * bs; k++) {
      PetscReal *restrict row = pattern->value[nodes[i]] + k / bs * width + k % bs;
      const PetscReal *value  = &element[(i * bs * bs + k) * n];

      for (PetscInt j = 0; j < n; j++) row[place[j]] += value[j];
    }
  }
}

void MpmPatternAddNodes(MpmPattern *pattern, const MpmSpace *space, PetscInt n, const PetscInt nodes[],
                        PetscReal element[])
{
  const MpmConstraints *constraints = pattern->constraints;
  const PetscInt        bs          = pattern->block;

  if (pattern->action) {
    MpmElementActNodes(pattern->action, bs, n, nodes, element);
    return;
  }
  MpmFramesRotateElement(constraints, bs, n, nodes, element);
  for (PetscInt i = 0; i < n; i++) {
    if (nodes[i] < 0) continue;
    const PetscInt width = (pattern->row[nodes[i] + 1] - pattern->row[nodes[i]]) * bs;

    for (PetscInt j = 0; j < n; j++) {
      if (nodes[j] < 0) continue;
      PetscReal *block = pattern->value[nodes[i]] + MpmPatternPosition(pattern, space, nodes[i], nodes[j]) * bs;

      for (PetscInt k = 0; k < bs * bs; k++) {
        const PetscInt c = k / bs, d = k % bs;

        if (MpmConstraintsCounts(constraints, nodes[i] * bs + c) &&
            MpmConstraintsCounts(constraints, nodes[j] * bs + d))
          block[c * width + d] += element[((i * bs + c) * bs + d) * n + j];
      }
    }
  }
}

/* row += left * b + right * c; `count` is a constant where it pays */
static inline __attribute__((always_inline)) void AddTwo(PetscInt count, PetscReal left, const PetscReal *restrict b,
                                                         PetscReal right, const PetscReal *restrict c,
                                                         PetscReal *restrict row)
{
  for (PetscInt k = 0; k < count; k++) row[k] += left * b[k] + right * c[k];
}

/* Two vectors at rows, left and right, and the two that they multiply along a run of columns. */
typedef struct {
  const PetscReal *left, *b, *right, *c;
} Pair;

/* Rows of a node: the columns of `length` box nodes that stand side by side from `place` on. */
static void AddPairRun(const PetscInt bs, PetscReal *row, PetscInt width, PetscInt length, const Pair pair)
{
  for (PetscInt r = 0; r < bs; r++, row += width) {
    switch (length * bs) { /* three and four nodes, the usual shapes' on an axis */
    case 6:
      AddTwo(6, pair.left[r], pair.b, pair.right[r], pair.c, row);
      break;
    case 8:
      AddTwo(8, pair.left[r], pair.b, pair.right[r], pair.c, row);
      break;
    case 9:
      AddTwo(9, pair.left[r], pair.b, pair.right[r], pair.c, row);
      break;
    case 12:
      AddTwo(12, pair.left[r], pair.b, pair.right[r], pair.c, row);
      break;
    default:
      AddTwo(length * bs, pair.left[r], pair.b, pair.right[r], pair.c, row);
      break;
    }
  }
}

/* True where a node has no rows: those in a box's margin have no places for all columns. */
static PetscBool IsZero(PetscInt bs, const PetscReal left[], const PetscReal right[])
{
  for (PetscInt r = 0; r < bs; r++)
    if (left[r] != 0. || right[r] != 0.) return PETSC_FALSE;
  return PETSC_TRUE;
}

void MpmPatternAddPair(MpmPattern *pattern, const MpmSpace *space, const MpmGroup *box, PetscReal a[], PetscReal b[],
                       PetscReal c[])
{
  const MpmConstraints *constraints = pattern->constraints;
  const PetscInt        n = box->node_count, bs = pattern->block;
  const PetscInt       *nodes = &space->group_nodes[box->node_offset];
  PetscInt              offset[MPM_MAX_WIDTH * MPM_MAX_WIDTH * MPM_MAX_WIDTH], end;

  if (pattern->action) {
    MpmElementActPair(pattern->action, bs, n, nodes, a, b, c);
    return;
  }
  const PetscInt center = MpmPatternOffsets(pattern, box, offset);

  MpmFramesRotateVector(constraints, bs, n, nodes, a);
  MpmFramesRotateVector(constraints, bs, n, nodes, b);
  MpmFramesRotateVector(constraints, bs, n, nodes, c);
  for (PetscInt k = 0; constraints->any && k < n * bs; k++)
    if (nodes[k / bs] >= 0 && !MpmConstraintsCounts(constraints, nodes[k / bs] * bs + k % bs)) a[k] = b[k] = c[k] = 0.;
  for (PetscInt i = 0; i < n; i++) {
    if (nodes[i] < 0 || IsZero(bs, &a[i * bs], &b[i * bs])) continue;
    const PetscInt *slot  = &pattern->slot[nodes[i] * pattern->window + center - offset[i]];
    const PetscInt  width = (pattern->row[nodes[i] + 1] - pattern->row[nodes[i]]) * bs;

    for (PetscInt j = 0; j < n; j = end) {
      const PetscInt line = (j / box->count[0] + 1) * box->count[0]; /* its end */

      end = j + 1;
      if (nodes[j] < 0) continue;
      while (end < line && nodes[end] >= 0 && slot[offset[end]] == slot[offset[end - 1]] + 1) end++;
      AddPairRun(bs, pattern->value[nodes[i]] + slot[offset[j]] * bs, width, end - j,
                 (Pair){&a[i * bs], &b[j * bs], &b[i * bs], &c[j * bs]});
    }
  }
}
