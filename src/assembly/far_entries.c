/*
  Far entries of the Jacobian's sparsity: those of extra nodes, coupled boxes and masters of followers, in lists by row.
*/
#include "space/space.h"
#include "assembly/sparsity.h"
#include "assembly/sparsity_impl.h"

/* Where far entries go: counted in fill[row], or put at fill[row] in column. */
typedef struct {
  const MpmPattern *pattern;
  const MpmSpace   *space;
  PetscInt         *fill, *column;
} Far;

/* The node, or those that it follows and itself: its number of targets. */
static PetscInt Targets(const MpmSpace *space, const PetscInt *node, const PetscInt **masters)
{
  const MpmExtension *extension = &space->extension;
  const PetscInt      f         = extension->of ? extension->of[*node] : -1;

  *masters = f < 0 ? NULL : &extension->master[extension->offset[f]];
  return 1 + (f < 0 ? 0 : extension->offset[f + 1] - extension->offset[f]);
}

/* Entries of a coupled pair of nodes: those of their masters, too. */
static void AddFarPair(const Far *far, PetscInt row, PetscInt column, PetscBool outside)
{
  const PetscInt *rows, *columns, row_count = Targets(far->space, &row, &rows);
  const PetscInt  column_count = Targets(far->space, &column, &columns);

  for (PetscInt i = 0; i < row_count; i++) {
    const PetscInt k = i ? rows[i - 1] : row;

    for (PetscInt j = 0; j < column_count; j++) {
      const PetscInt l = j ? columns[j - 1] : column;

      if (outside && MpmPatternSlot(far->pattern, far->space, k, l)) continue;
      if (far->column) far->column[far->fill[k]] = l;
      far->fill[k]++;
    }
  }
}

/* Adds the columns to the rows of as many nodes. */
static void AddFar(const Far *far, PetscInt rows, const PetscInt row[], PetscInt columns, const PetscInt node[])
{
  for (PetscInt i = 0; i < rows; i++)
    for (PetscInt j = 0; row[i] >= 0 && j < columns; j++)
      if (node[j] >= 0) AddFarPair(far, row[i], node[j], PETSC_FALSE);
}

/* Entries that followers' masters have beside those of boxes. */
static void AddFollowers(const Far *far, const PetscInt neighbour[])
{
  const MpmExtension *extension = &far->space->extension;
  const PetscInt      window    = far->pattern->window;

  for (PetscInt f = 0; f < extension->count; f++) {
    const PetscInt s = extension->follower[f];

    for (PetscInt w = 0; w < window; w++) {
      if (far->pattern->slot[s * window + w] < 0) continue;
      const PetscInt j = neighbour[s * window + w];

      AddFarPair(far, s, j, PETSC_TRUE);
      if (extension->of[j] < 0) AddFarPair(far, j, s, PETSC_TRUE);
    }
  }
}

/* All entries of links and couples, in no order, some more than once. */
static void AddAllFar(const Far *far, const PetscInt neighbour[])
{
  const MpmSpace      *space = far->space;
  const MpmExtraNodes *extra = &space->extra;

  for (PetscInt k = 0; k < extra->link_count; k++) {
    const MpmLink  *link  = &extra->link[k];
    const MpmGroup *box   = link->box < 0 ? NULL : &space->groups[link->box];
    const PetscInt *nodes = box ? &space->group_nodes[box->node_offset] : NULL;

    for (PetscInt e = 0; e < link->count; e++) {
      const PetscInt one = extra->begin + link->first + e;

      for (PetscInt o = 0; o < link->count; o++) {
        const PetscInt other = extra->begin + link->first + o;

        AddFar(far, 1, &one, 1, &other);
      }
      if (!box) continue;
      AddFar(far, 1, &one, box->node_count, nodes);
      AddFar(far, box->node_count, nodes, 1, &one);
    }
  }
  for (PetscInt k = 0; k < space->parts.couple_count; k++) {
    for (PetscInt side = 0; side < 2; side++) {
      const MpmGroup *one   = &space->groups[space->parts.couple[k].box[side]];
      const MpmGroup *other = &space->groups[space->parts.couple[k].box[1 - side]];

      AddFar(far, one->node_count, &space->group_nodes[one->node_offset], other->node_count,
             &space->group_nodes[other->node_offset]);
    }
  }
  AddFollowers(far, neighbour);
}

PetscErrorCode MpmPatternMarkFar(MpmPattern *pattern, const MpmSpace *space, const PetscInt neighbour[])
{
  Far       far = {.pattern = pattern, .space = space};
  PetscInt *start, *fill, end = 0;

  PetscFunctionBeginUser;
  if (!space->extra.link_count && !space->parts.couple_count && !space->extension.count)
    PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((pattern->local + 1), &pattern->far.start));
  PetscCall(PetscCalloc1(pattern->local, &fill));
  start    = pattern->far.start;
  far.fill = fill;
  AddAllFar(&far, neighbour);
  for (PetscInt i = 0; i < pattern->local; i++) {
    start[i + 1] = start[i] + fill[i];
    fill[i]      = start[i];
  }
  PetscCall(PetscMalloc2(start[pattern->local], &pattern->far.column, start[pattern->local], &pattern->far.slot));
  far.column = pattern->far.column;
  AddAllFar(&far, neighbour);
  for (PetscInt i = 0; i < pattern->local; i++) { /* each once; rows move up */
    PetscInt count = start[i + 1] - start[i], *column = &pattern->far.column[start[i]];

    if (count > 1) PetscCall(PetscSortRemoveDupsInt(&count, column));
    for (PetscInt k = 0; k < count; k++) pattern->far.column[end + k] = column[k];
    start[i] = end;
    end += count;
  }
  start[pattern->local] = end;
  PetscCall(PetscFree(fill));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmPatternPosition(const MpmPattern *pattern, const MpmSpace *space, PetscInt row, PetscInt column)
{
  const PetscInt  far  = pattern->far.start ? pattern->far.start[row] : 0;
  const PetscInt *slot = MpmPatternSlot(pattern, space, row, column);
  PetscInt        low = 0, high = MpmPatternFarCount(pattern, row);

  if (slot) return *slot;
  while (high - low > 1) {
    const PetscInt middle = (low + high) / 2;

    if (pattern->far.column[far + middle] <= column) low = middle;
    else high = middle;
  }
  return pattern->far.slot[far + low];
}
