/*
  The Jacobian's sparsity.

  A row's columns lie in a window of (2w - 1)^dim nodes around it, w being the most nodes that a point touches on an
  axis: a table over that window gives the place of any entry without a search. Extra nodes and coupled boxes have
  entries outside, in lists by row (far_entries.c). The values go into the matrix by pattern_matrix.c.
*/
#include "space/space.h"
#include "assembly/sparsity.h"
#include "assembly/sparsity_impl.h"

PetscErrorCode MpmPatternDestroy(MpmPattern **handle)
{
  MpmPattern *pattern = *handle;

  PetscFunctionBeginUser;
  if (!pattern) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree(pattern->row));
  PetscCall(PetscFree(pattern->column));
  PetscCall(PetscFree(pattern->slot));
  PetscCall(PetscFree(pattern->neighbour));
  PetscCall(PetscFree(pattern->far.start));
  PetscCall(PetscFree2(pattern->far.column, pattern->far.slot));
  PetscCall(PetscFree(pattern->value));
  PetscCall(PetscFree(pattern->buffer));
  PetscCall(PetscFree(*handle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt *MpmPatternSlot(const MpmPattern *pattern, const MpmSpace *space, PetscInt row, PetscInt column)
{
  const PetscInt dim = pattern->dim, side = 2 * pattern->reach + 1;
  PetscInt       at = (pattern->window - 1) / 2, stride = 1;

  if (MpmSpaceIsExtra(space, row) || MpmSpaceIsExtra(space, column)) return NULL;
  for (PetscInt a = 0; a < dim; a++, stride *= side) {
    const PetscInt apart = space->node[column * dim + a] - space->node[row * dim + a];

    if (PetscAbsInt(apart) > pattern->reach) return NULL;
    at += stride * apart;
  }
  return pattern->slot[row * pattern->window + at] < 0 ? NULL : &pattern->slot[row * pattern->window + at];
}

/* True where a box's node lies in its margin. */
static PetscBool IsInMargin(const MpmGroup *group, PetscInt i)
{
  const PetscInt *count              = group->count;
  const PetscInt  place[MPM_MAX_DIM] = {i % count[0], i / count[0] % count[1], i / (count[0] * count[1])};

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
    if (place[a] < group->margin[a] || place[a] >= count[a] - group->margin[a]) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Marks the entries that this rank's groups touch: slot 0 where there is one, -1 elsewhere. */
static PetscErrorCode MarkEntries(MpmPattern *pattern, const MpmSpace *space)
{
  PetscInt *offset;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((pattern->local * pattern->window), &pattern->slot));
  for (PetscInt i = 0; i < pattern->local * pattern->window; i++) pattern->slot[i] = -1;
  for (PetscInt i = 0; i < pattern->owned; i++) pattern->slot[i * pattern->window + (pattern->window - 1) / 2] = 0;
  PetscCall(PetscMalloc1(PetscPowInt(space->boxes.reach + 1, space->dim), &offset));
  for (PetscInt g = 0; g < space->boxes.count; g++) {
    const MpmGroup *group  = &space->groups[g];
    const PetscInt *nodes  = &space->group_nodes[group->node_offset];
    const PetscInt  center = MpmPatternOffsets(pattern, group, offset);

    for (PetscInt i = 0; i < group->node_count; i++) {
      PetscInt *slot = &pattern->slot[nodes[i] * pattern->window + center - offset[i]];

      const PetscBool outer = (PetscBool)(group->margin[0] && IsInMargin(group, i));

      for (PetscInt j = 0; nodes[i] >= 0 && j < group->node_count; j++)
        if (nodes[j] >= 0 && !(outer && IsInMargin(group, j))) slot[offset[j]] = 0;
    }
  }
  PetscCall(PetscFree(offset));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Finds the local number of the node at a window position of a row: the group nodes know it, so it is looked up through
  them.
*/
typedef struct {
  PetscInt *neighbour; /* like slot: local node numbers */
} Neighbours;

static PetscErrorCode FindNeighbours(const MpmPattern *pattern, const MpmSpace *space, Neighbours *found)
{
  PetscInt *offset;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((pattern->local * pattern->window), &found->neighbour));
  for (PetscInt i = 0; i < pattern->owned; i++) found->neighbour[i * pattern->window + (pattern->window - 1) / 2] = i;
  PetscCall(PetscMalloc1(PetscPowInt(space->boxes.reach + 1, space->dim), &offset));
  for (PetscInt g = 0; g < space->boxes.count; g++) {
    const MpmGroup *group  = &space->groups[g];
    const PetscInt *nodes  = &space->group_nodes[group->node_offset];
    const PetscInt  center = MpmPatternOffsets(pattern, group, offset);

    for (PetscInt i = 0; i < group->node_count; i++) {
      PetscInt *neighbour = &found->neighbour[nodes[i] * pattern->window + center - offset[i]];

      for (PetscInt j = 0; nodes[i] >= 0 && j < group->node_count; j++)
        if (nodes[j] >= 0) neighbour[offset[j]] = nodes[j];
    }
  }
  PetscCall(PetscFree(offset));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  The columns of a row as global numbers, in no order, some twice; `place`: where the position of each is kept; returns
  their count.
*/
static PetscInt RowColumns(const MpmPattern *pattern, const MpmSpace *space, const Neighbours *found, PetscInt row,
                           PetscInt column[], PetscInt *place[])
{
  const PetscInt begin = row * pattern->window;
  PetscInt       count = 0;

  for (PetscInt w = 0; w < pattern->window; w++) {
    if (pattern->slot[begin + w] < 0) continue;
    column[count]  = space->number.global[found->neighbour[begin + w]];
    place[count++] = &pattern->slot[begin + w];
  }
  for (PetscInt k = 0; k < MpmPatternFarCount(pattern, row); k++) {
    const PetscInt at = pattern->far.start[row] + k;

    column[count]  = space->number.global[pattern->far.column[at]];
    place[count++] = &pattern->far.slot[at];
  }
  return count;
}

/* No row of this rank has more entries. */
static PetscInt LongestRow(const MpmPattern *pattern)
{
  PetscInt most = 0;

  for (PetscInt i = 0; i < pattern->local; i++) most = PetscMax(most, MpmPatternFarCount(pattern, i));
  return pattern->window + most;
}

/* This rank's entries in ghost rows, sent to their owners: for each row the owner's number of it, the count, and the
   columns. */
static PetscErrorCode ExchangeGhostRows(const MpmPattern *pattern, const MpmSpace *space, MPI_Comm comm,
                                        const Neighbours *found, MpmLists *received)
{
  MpmLists           sent = {0};
  PetscInt           leaves, size = 0, fill = 0, **unused;
  const PetscInt     ghost = space->owned; /* the first leaf: PETSc keeps no list of leaves that begin at 0 */
  const PetscSFNode *remote;

  PetscFunctionBeginUser;
  PetscCall(PetscSFGetGraph(space->number.sf, NULL, &leaves, NULL, &remote));
  PetscCall(PetscMalloc1(leaves, &sent.rank));
  PetscCall(PetscMalloc1((leaves + 1), &sent.offset));
  for (PetscInt k = 0; k < leaves; k++) size += pattern->window + 2 + MpmPatternFarCount(pattern, ghost + k);
  PetscCall(PetscMalloc1(size, &sent.data));
  PetscCall(PetscMalloc1(LongestRow(pattern), &unused));
  /* ghosts of one owner stand side by side */
  for (PetscInt k = 0; k < leaves; k++) {
    if (!k || remote[k].rank != remote[k - 1].rank) {
      sent.offset[sent.count] = fill;
      sent.rank[sent.count++] = (PetscMPIInt)remote[k].rank;
    }
    sent.data[fill]     = remote[k].index;
    sent.data[fill + 1] = RowColumns(pattern, space, found, ghost + k, &sent.data[fill + 2], unused);
    fill += 2 + sent.data[fill + 1];
  }
  sent.offset[sent.count] = fill;
  PetscCall(PetscFree(unused));
  PetscCall(MpmListsExchange(comm, &sent, received));
  PetscCall(MpmListsDestroy(&sent));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where the columns of each owned row that came from other ranks stand in the received lists. */
typedef struct {
  PetscInt *start; /* owned + 1 */
  PetscInt *column;
} Foreign;

static PetscErrorCode SortForeign(const MpmPattern *pattern, const MpmLists *received, Foreign *foreign)
{
  const PetscInt end = received->count ? received->offset[received->count] : 0;
  PetscInt      *fill;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((pattern->owned + 1), &foreign->start));
  PetscCall(PetscMalloc1(end, &foreign->column));
  PetscCall(PetscMalloc1(pattern->owned, &fill));
  for (PetscInt k = 0; k < end; k += 2 + received->data[k + 1])
    foreign->start[received->data[k] + 1] += received->data[k + 1];
  for (PetscInt i = 0; i < pattern->owned; i++) {
    fill[i] = foreign->start[i];
    foreign->start[i + 1] += foreign->start[i];
  }
  for (PetscInt k = 0; k < end; k += 2 + received->data[k + 1]) {
    for (PetscInt j = 0; j < received->data[k + 1]; j++)
      foreign->column[fill[received->data[k]]++] = received->data[k + 2 + j];
  }
  PetscCall(PetscFree(fill));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists each row's columns in ascending order and puts their positions into the slots. */
static PetscErrorCode ListColumns(MpmPattern *pattern, const MpmSpace *space, const Neighbours *found,
                                  const Foreign *foreign)
{
  PetscInt capacity = 0, fill = 0, *own, **place;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < pattern->local * pattern->window; i++) capacity += pattern->slot[i] == 0;
  if (pattern->far.start) capacity += pattern->far.start[pattern->local];
  if (foreign) capacity += foreign->start[pattern->owned];
  PetscCall(PetscMalloc1((pattern->local + 1), &pattern->row));
  PetscCall(PetscMalloc1(capacity, &pattern->column));
  PetscCall(PetscMalloc2(LongestRow(pattern), &own, LongestRow(pattern), &place));
  for (PetscInt i = 0; i < pattern->local; i++) {
    const PetscInt mine   = RowColumns(pattern, space, found, i, own, place);
    PetscInt      *column = &pattern->column[fill], count = mine;

    pattern->row[i] = fill;
    PetscCall(PetscArraycpy(column, own, mine));
    if (foreign && i < pattern->owned) {
      for (PetscInt k = foreign->start[i]; k < foreign->start[i + 1]; k++) column[count++] = foreign->column[k];
    }
    PetscCall(PetscSortRemoveDupsInt(&count, column));
    for (PetscInt k = 0; k < mine; k++) PetscCall(PetscFindInt(own[k], count, column, place[k]));
    fill += count;
  }
  PetscCall(PetscFree2(own, place));
  pattern->row[pattern->local] = fill;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPatternSetUp(MpmPattern **handle, const MpmSpace *space, MPI_Comm comm, PetscInt block,
                               PetscBool *changed)
{
  MpmPattern *old      = *handle, *pattern;
  Neighbours  found    = {NULL};
  MpmLists    received = {0};
  Foreign     foreign  = {NULL, NULL};

  PetscFunctionBeginUser;
  PetscCall(PetscNew(handle));
  pattern         = *handle;
  pattern->block  = block;
  pattern->dim    = space->dim;
  pattern->reach  = space->boxes.reach;
  pattern->window = PetscPowInt(2 * pattern->reach + 1, space->dim);
  pattern->local  = space->local;
  pattern->owned  = space->owned;
  PetscCall(MarkEntries(pattern, space));
  PetscCall(FindNeighbours(pattern, space, &found));
  PetscCall(MpmPatternMarkFar(pattern, space, found.neighbour));
  if (space->number.sf) {
    PetscCall(ExchangeGhostRows(pattern, space, comm, &found, &received));
    PetscCall(SortForeign(pattern, &received, &foreign));
  }
  PetscCall(ListColumns(pattern, space, &found, space->number.sf ? &foreign : NULL));
  PetscCall(PetscMalloc1(pattern->local, &pattern->value));
  if (space->extension.count) pattern->neighbour = found.neighbour;
  else PetscCall(PetscFree(found.neighbour));
  PetscCall(PetscFree(foreign.start));
  PetscCall(PetscFree(foreign.column));
  PetscCall(MpmListsDestroy(&received));

  /* equal rows and columns on every rank: the matrix and its symbolic factorisation stay; coordinates have ghosts'
     rows, too */

  if (old) pattern->coordinates = old->coordinates;
  const PetscInt count = pattern->coordinates ? pattern->local : pattern->owned;
  *changed =
    (PetscBool)(!old || old->owned != pattern->owned || old->local < count || old->row[count] != pattern->row[count]);
  if (!*changed) {
    PetscBool rows, columns;

    PetscCall(PetscArraycmp(old->row, pattern->row, count + 1, &rows));
    PetscCall(PetscArraycmp(old->column, pattern->column, pattern->row[count], &columns));
    *changed = (PetscBool) !(rows && columns);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, changed, 1, MPM_MPI_BOOL, MPI_LOR, comm));
  PetscCall(MpmPatternDestroy(&old));
  PetscFunctionReturn(PETSC_SUCCESS);
}
