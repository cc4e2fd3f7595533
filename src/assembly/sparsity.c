/*
  The Jacobian's sparsity and the values on their way into the matrix.

  A row's columns lie in a window of (2w - 1)^dim nodes around it, w being the most nodes that a point touches on an
  axis: a table over that window gives the place of any entry without a search. Extra nodes and coupled boxes have
  entries outside, in lists by row (far_entries.c). Rows whose columns all belong to this rank are written directly into
  PETSc's AIJ storage. Others are kept in a buffer: owned ones are copied, rows of ghosts go to their owners through the
  matrix's stash. Matrices of other types than PETSc's own on the host (those of GPUs, hypre's) get all rows, ghosts'
  too, as one list of coordinates and values.
*/
#include "space/space.h"
#include "bc/bc.h"
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
  PetscCall(PetscFree(pattern->far_start));
  PetscCall(PetscFree2(pattern->far_column, pattern->far_slot));
  PetscCall(PetscFree(pattern->value));
  PetscCall(PetscFree(pattern->buffer));
  PetscCall(PetscFree(*handle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Offsets in the window of a group's nodes, relative to its first node: the entry (i, j) stands at center + offset[j] -
  offset[i].
*/
static PetscInt WindowOffsets(const MpmPattern *pattern, const MpmGroup *group, PetscInt offset[])
{
  const PetscInt side = 2 * pattern->reach + 1;
  PetscInt       n    = 0;

  for (PetscInt k = 0; k < group->count[2]; k++)
    for (PetscInt j = 0; j < group->count[1]; j++)
      for (PetscInt i = 0; i < group->count[0]; i++) offset[n++] = (k * side + j) * side + i;
  return (pattern->window - 1) / 2;
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

/* Marks the entries that this rank's groups touch: slot 0 where there is one, -1 elsewhere. */
static PetscErrorCode MarkEntries(MpmPattern *pattern, const MpmSpace *space)
{
  PetscInt *offset;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((pattern->local * pattern->window), &pattern->slot));
  for (PetscInt i = 0; i < pattern->local * pattern->window; i++) pattern->slot[i] = -1;
  for (PetscInt i = 0; i < pattern->owned; i++) pattern->slot[i * pattern->window + (pattern->window - 1) / 2] = 0;
  PetscCall(PetscMalloc1(PetscPowInt(space->reach + 1, space->dim), &offset));
  for (PetscInt g = 0; g < space->box_count; g++) {
    const MpmGroup *group  = &space->groups[g];
    const PetscInt *nodes  = &space->group_nodes[group->node_offset];
    const PetscInt  center = WindowOffsets(pattern, group, offset);

    for (PetscInt i = 0; i < group->node_count; i++) {
      PetscInt *slot = &pattern->slot[nodes[i] * pattern->window + center - offset[i]];

      for (PetscInt j = 0; nodes[i] >= 0 && j < group->node_count; j++)
        if (nodes[j] >= 0) slot[offset[j]] = 0;
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
  PetscCall(PetscMalloc1(PetscPowInt(space->reach + 1, space->dim), &offset));
  for (PetscInt g = 0; g < space->box_count; g++) {
    const MpmGroup *group  = &space->groups[g];
    const PetscInt *nodes  = &space->group_nodes[group->node_offset];
    const PetscInt  center = WindowOffsets(pattern, group, offset);

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
    column[count]  = space->global[found->neighbour[begin + w]];
    place[count++] = &pattern->slot[begin + w];
  }
  for (PetscInt k = 0; k < MpmPatternFarCount(pattern, row); k++) {
    const PetscInt at = pattern->far_start[row] + k;

    column[count]  = space->global[pattern->far_column[at]];
    place[count++] = &pattern->far_slot[at];
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
  PetscCall(PetscSFGetGraph(space->sf, NULL, &leaves, NULL, &remote));
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
  if (pattern->far_start) capacity += pattern->far_start[pattern->local];
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
  pattern->reach  = space->reach;
  pattern->window = PetscPowInt(2 * pattern->reach + 1, space->dim);
  pattern->local  = space->local;
  pattern->owned  = space->owned;
  PetscCall(MarkEntries(pattern, space));
  PetscCall(FindNeighbours(pattern, space, &found));
  PetscCall(MpmPatternMarkFar(pattern, space, found.neighbour));
  if (space->sf) {
    PetscCall(ExchangeGhostRows(pattern, space, comm, &found, &received));
    PetscCall(SortForeign(pattern, &received, &foreign));
  }
  PetscCall(ListColumns(pattern, space, &found, space->sf ? &foreign : NULL));
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

/* True where values are passed as coordinates: not for types on the host that take blocks of values, or lend their
   arrays. */
static PetscErrorCode TakesCoordinates(Mat mat, PetscBool *takes)
{
  PetscBool host;

  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompareAny((PetscObject)mat, &host, MATSEQAIJ, MATMPIAIJ, MATSEQBAIJ, MATMPIBAIJ,
                                      MATSEQSBAIJ, MATMPISBAIJ, MATSEQDENSE, MATMPIDENSE, MATSEQAIJMKL, MATMPIAIJMKL,
                                      MATSEQAIJPERM, MATMPIAIJPERM, MATSEQAIJSELL, MATMPIAIJSELL, ""));
  *takes = (PetscBool)!host;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Row and column of every value of the buffer when it holds all rows. */
static PetscErrorCode ListCoordinates(const MpmPattern *pattern, const MpmSpace *space, Mat mat)
{
  const PetscInt bs    = pattern->block;
  PetscCount     count = (PetscCount)pattern->row[pattern->local] * bs * bs, fill = 0;
  PetscInt      *i, *j;
  PetscBool      has;
  Mat            diagonal;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc2((size_t)count, &i, (size_t)count, &j));
  for (PetscInt node = 0; node < pattern->local; node++) {
    for (PetscInt c = 0; c < bs; c++) {
      for (PetscInt k = pattern->row[node] * bs; k < pattern->row[node + 1] * bs; k++) {
        i[fill]   = space->global[node] * bs + c;
        j[fill++] = pattern->column[k / bs] * bs + k % bs;
      }
    }
  }
  PetscCall(MatSetPreallocationCOO(mat, count, i, j));
  PetscCall(PetscFree2(i, j));
  PetscCall(MatHasOperation(mat, MATOP_GET_DIAGONAL_BLOCK, &has));
  if (has) { /* MPIAIJ makes that matrix again and forgets its blocks, which point-block preconditioners need */
    PetscCall(MatGetDiagonalBlock(mat, &diagonal));
    PetscCall(MatSetBlockSize(diagonal, bs));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPatternCreateMat(MpmPattern *pattern, const MpmSpace *space, MPI_Comm comm, MatType type, Mat *mat)
{
  const PetscInt bs = pattern->block, rows = pattern->owned * bs;
  PetscInt      *i, *j, fill = 0;

  PetscFunctionBeginUser;
  PetscCall(MatCreate(comm, mat));
  PetscCall(MatSetSizes(*mat, rows, rows, space->global_count * bs, space->global_count * bs));
  PetscCall(MatSetBlockSize(*mat, bs));
  PetscCall(MatSetType(*mat, type));
  PetscCall(MatSetFromOptions(*mat));
  PetscCall(TakesCoordinates(*mat, &pattern->coordinates));
  if (pattern->coordinates) {
    PetscCall(ListCoordinates(pattern, space, *mat));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1((rows + 1), &i));
  PetscCall(PetscMalloc1((pattern->row[pattern->owned] * bs * bs), &j));
  i[0] = 0;
  for (PetscInt node = 0; node < pattern->owned; node++) {
    for (PetscInt c = 0; c < bs; c++) {
      for (PetscInt k = pattern->row[node]; k < pattern->row[node + 1]; k++)
        for (PetscInt d = 0; d < bs; d++) j[fill++] = pattern->column[k] * bs + d;
      i[node * bs + c + 1] = fill;
    }
  }
  /* only the routine of the matrix's own type acts */
  PetscCall(MatSeqAIJSetPreallocationCSR(*mat, i, j, NULL));
  PetscCall(MatMPIAIJSetPreallocationCSR(*mat, i, j, NULL));
  PetscCall(MatSeqBAIJSetPreallocationCSR(*mat, bs, pattern->row, pattern->column, NULL));
  PetscCall(MatMPIBAIJSetPreallocationCSR(*mat, bs, pattern->row, pattern->column, NULL));
  PetscCall(MatSetUp(*mat));
  PetscCall(PetscFree(i));
  PetscCall(PetscFree(j));
  PetscCall(MatSetOption(*mat, MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* AddBlock() entry by entry. */
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
  const PetscInt center = WindowOffsets(pattern, group, offset);

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
  const PetscInt center = WindowOffsets(pattern, box, offset);

  MpmFramesRotateVector(constraints, bs, n, nodes, a);
  MpmFramesRotateVector(constraints, bs, n, nodes, b);
  MpmFramesRotateVector(constraints, bs, n, nodes, c);
  for (PetscInt k = 0; constraints->any && k < n * bs; k++)
    if (nodes[k / bs] >= 0 && !MpmConstraintsCounts(constraints, nodes[k / bs] * bs + k % bs)) a[k] = b[k] = c[k] = 0.;
  for (PetscInt i = 0; i < n; i++) {
    if (nodes[i] < 0) continue;
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

/* True where all columns of an owned row are this rank's own; columns stand in ascending order. */
static PetscBool IsInside(const MpmPattern *pattern, const MpmSpace *space, PetscInt row)
{
  const PetscInt begin = space->global_begin, end = begin + space->owned;

  if (row >= pattern->owned) return PETSC_FALSE;
  return (PetscBool)(pattern->column[pattern->row[row]] >= begin && pattern->column[pattern->row[row + 1] - 1] < end);
}

/* The part of a (MPI)AIJ matrix with this rank's columns, or NULL for other types. */
static PetscErrorCode OwnPart(Mat mat, PetscBool coordinates, Mat *own, Mat *other)
{
  PetscBool seqaij, mpiaij;

  PetscFunctionBeginUser;
  PetscCall(PetscObjectBaseTypeCompare((PetscObject)mat, MATSEQAIJ, &seqaij));
  PetscCall(PetscObjectBaseTypeCompare((PetscObject)mat, MATMPIAIJ, &mpiaij));
  *own = *other = NULL;
  if (coordinates) PetscFunctionReturn(PETSC_SUCCESS);
  if (seqaij) *own = mat;
  else if (mpiaij) PetscCall(MatMPIAIJGetSeqAIJ(mat, own, other, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPatternBegin(MpmPattern *pattern, const MpmSpace *space, const MpmConstraints *constraints, Mat mat)
{
  const PetscInt bs   = pattern->block;
  PetscInt64     size = 0, at = 0;
  Mat            own, other;

  PetscFunctionBeginUser;
  PetscCall(OwnPart(mat, pattern->coordinates, &own, &other));
  if (!pattern->coordinates) PetscCall(MatZeroEntries(mat));
  pattern->constraints = constraints;
  pattern->array       = NULL;
  if (own) PetscCall(MatSeqAIJGetArray(own, &pattern->array));
  for (PetscInt pass = 0; pass < 2; pass++) {
    at = size = 0;
    for (PetscInt i = 0; i < pattern->local; i++) {
      const PetscInt64 values = (PetscInt64)(pattern->row[i + 1] - pattern->row[i]) * bs * bs;
      const PetscBool  inside = (PetscBool)(own && IsInside(pattern, space, i));

      if (pass) pattern->value[i] = inside ? pattern->array + at : pattern->buffer + size;
      if (!inside) size += values;
      if (inside) at += values;
      else if (own && i < pattern->owned) { /* part of it stands in the own part too */
        for (PetscInt k = pattern->row[i]; k < pattern->row[i + 1]; k++) {
          const PetscInt column = pattern->column[k] - space->global_begin;

          if (column >= 0 && column < space->owned) at += bs * bs;
        }
      }
    }
    if (!pass && size > pattern->buffer_size) {
      PetscCall(PetscFree(pattern->buffer));
      PetscCall(PetscMalloc1(size, &pattern->buffer));
      pattern->buffer_size = size;
    }
  }
  PetscCall(PetscArrayzero(pattern->buffer, size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Copies the owned rows of the buffer to where they stand in the two parts of an MPIAIJ matrix. */
static PetscErrorCode CopyBuffer(const MpmPattern *pattern, const MpmSpace *space, Mat other)
{
  const PetscInt bs = pattern->block, begin = space->global_begin, end = begin + space->owned;
  PetscScalar   *to_a = pattern->array, *b = NULL, *to_b;

  PetscFunctionBeginUser;
  if (other) PetscCall(MatSeqAIJGetArrayWrite(other, &b));
  to_b = b;
  for (PetscInt i = 0; i < pattern->owned; i++) {
    const PetscInt  *column = &pattern->column[pattern->row[i]], count = pattern->row[i + 1] - pattern->row[i];
    const PetscReal *value = pattern->value[i];
    PetscInt         lower = 0, upper = count;

    if (IsInside(pattern, space, i)) {
      to_a += (PetscInt64)count * bs * bs;
      continue;
    }
    while (lower < count && column[lower] < begin) lower++;
    while (upper > lower && column[upper - 1] >= end) upper--;
    for (PetscInt c = 0; c < bs; c++, value += count * bs) {
      PetscCall(PetscArraycpy(to_a, value + lower * bs, (upper - lower) * bs));
      PetscCall(PetscArraycpy(to_b, value, lower * bs));
      PetscCall(PetscArraycpy(to_b + lower * bs, value + upper * bs, (count - upper) * bs));
      to_a += (upper - lower) * bs;
      to_b += (count - upper + lower) * bs;
    }
  }
  if (other) PetscCall(MatSeqAIJRestoreArrayWrite(other, &b));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds rows [first, last) through MatSetValues. */
static PetscErrorCode AddRows(const MpmPattern *pattern, const MpmSpace *space, PetscInt first, PetscInt last, Mat mat)
{
  const PetscInt bs = pattern->block;
  PetscInt      *columns, widest = 0;

  PetscFunctionBeginUser;
  for (PetscInt i = first; i < last; i++) widest = PetscMax(widest, pattern->row[i + 1] - pattern->row[i]);
  PetscCall(PetscMalloc1((widest * bs), &columns));
  for (PetscInt i = first; i < last; i++) {
    const PetscInt count = pattern->row[i + 1] - pattern->row[i];
    PetscInt       rows[MPM_MAX_BLOCK];

    for (PetscInt c = 0; c < bs; c++) rows[c] = space->global[i] * bs + c;
    for (PetscInt k = 0; k < count * bs; k++) columns[k] = pattern->column[pattern->row[i] + k / bs] * bs + k % bs;
    PetscCall(MatSetValues(mat, bs, rows, count * bs, columns, pattern->value[i], ADD_VALUES));
  }
  PetscCall(PetscFree(columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The diagonal of owned constrained rows. */
static void SetConstrainedDiagonal(MpmPattern *pattern, const MpmConstraints *constraints)
{
  const PetscInt bs = pattern->block;

  for (PetscInt k = 0; constraints->any && k < pattern->owned * bs; k++) {
    const PetscInt i = k / bs, c = k % bs, count = pattern->row[i + 1] - pattern->row[i];

    if (MpmConstraintsFree(constraints, k)) continue;
    pattern->value[i][(c * count + pattern->slot[i * pattern->window + (pattern->window - 1) / 2]) * bs + c] =
      constraints->diagonal;
  }
}

PetscErrorCode MpmPatternEnd(MpmPattern *pattern, const MpmSpace *space, Mat mat)
{
  Mat own, other;

  PetscFunctionBeginUser;
  MpmPatternEliminate(pattern, space);
  for (PetscInt i = 0; i < pattern->local && pattern->constraints->scaled; i++)
    MpmUnitsTimesRows(pattern->constraints, pattern->row[i + 1] - pattern->row[i], pattern->value[i]);
  SetConstrainedDiagonal(pattern, pattern->constraints);
  PetscCall(OwnPart(mat, pattern->coordinates, &own, &other));
  if (own) {
    PetscCall(CopyBuffer(pattern, space, other));
    PetscCall(MatSeqAIJRestoreArray(own, &pattern->array));
  }
  if (pattern->coordinates) {
    PetscCall(MatSetValuesCOO(mat, pattern->buffer, INSERT_VALUES));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(AddRows(pattern, space, own ? pattern->owned : 0, pattern->local, mat));
  PetscCall(MatAssemblyBegin(mat, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(mat, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}
