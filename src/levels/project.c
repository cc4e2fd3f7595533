/*
  P^T K P, element by element: a block of the fine nodes of a box, with the rows of these in the interpolation, becomes
  one of the coarse nodes that they come from.
*/
#include "space/space.h"
#include "levels/project.h"

struct MpmProjection {
  const MpmLocalRows *rows;
  Mat                 mat;
  PetscErrorCode      error;        /* of a block */
  PetscInt            count, *node; /* coarse nodes of the present box */
  PetscInt           *place;        /* of each entry of the box's rows among them */
  PetscReal          *half, *block; /* K P and P^T K P */
  PetscReal          *share;        /* of the entries, and where each node's begin */
  PetscInt           *begin;
  PetscInt            room[5]; /* of node and place, half, block, share, begin */
};

static PetscErrorCode Enlarge(PetscInt wanted, PetscInt *room, size_t size, void *array)
{
  PetscFunctionBeginUser;
  if (wanted <= *room) PetscFunctionReturn(PETSC_SUCCESS);
  *room = 2 * wanted;
  PetscCall(PetscRealloc((size_t)*room * size, (void **)array));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The coarse nodes of a box's nodes, and where its rows' entries are among them. */
static PetscErrorCode FindNodes(MpmProjection *to, PetscInt n, const PetscInt nodes[])
{
  const MpmLocalRows *rows    = to->rows;
  PetscInt            entries = 0, room = to->room[0];

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++)
    if (nodes[i] >= 0) entries += rows->begin[nodes[i] + 1] - rows->begin[nodes[i]];
  PetscCall(Enlarge(entries, &room, sizeof(*to->node), &to->node));
  PetscCall(Enlarge(entries, &to->room[0], sizeof(*to->place), &to->place));
  to->count = 0;
  for (PetscInt i = 0, at = 0; i < n; i++) {
    for (PetscInt e = nodes[i] < 0 ? 0 : rows->begin[nodes[i]]; nodes[i] >= 0 && e < rows->begin[nodes[i] + 1]; e++) {
      PetscInt k = 0;

      while (k < to->count && to->node[k] != rows->node[e]) k++;
      if (k == to->count) to->node[to->count++] = rows->node[e];
      to->place[at++] = k;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* half[(i c)][(m d)] = sum over j, e of K[(i c)][(j e)] P[(j e)][(m d)] */
static void TimesRows(MpmProjection *to, PetscInt n, const PetscInt nodes[], const PetscReal element[])
{
  const MpmLocalRows *rows = to->rows;
  const PetscInt      bs = rows->block, width = to->count * bs;

  for (PetscInt row = 0; row < n * bs; row++) {
    PetscReal *half = &to->half[row * width];

    for (PetscInt k = 0; k < width; k++) half[k] = 0.;
    if (nodes[row / bs] < 0) continue;
    for (PetscInt j = 0, at = 0; j < n; j++) {
      for (PetscInt e = nodes[j] < 0 ? 0 : rows->begin[nodes[j]]; nodes[j] >= 0 && e < rows->begin[nodes[j] + 1];
           e++, at++) {
        const PetscReal *share = &rows->share[e * bs * bs];
        PetscReal       *sum   = &half[to->place[at] * bs];

        for (PetscInt c = 0; c < bs; c++)
          for (PetscInt d = 0; d < bs; d++) sum[d] += element[(row * bs + c) * n + j] * share[c * bs + d];
      }
    }
  }
}

/* block[(m d)][k] = sum over i, c of P[(i c)][(m d)] half[(i c)][k] */
static void RowsTimes(MpmProjection *to, PetscInt n, const PetscInt nodes[])
{
  const MpmLocalRows *rows = to->rows;
  const PetscInt      bs = rows->block, width = to->count * bs;

  for (PetscInt k = 0; k < width * width; k++) to->block[k] = 0.;
  for (PetscInt i = 0, at = 0; i < n; i++) {
    for (PetscInt e = nodes[i] < 0 ? 0 : rows->begin[nodes[i]]; nodes[i] >= 0 && e < rows->begin[nodes[i] + 1];
         e++, at++) {
      for (PetscInt cd = 0; cd < bs * bs; cd++) {
        const PetscReal share = rows->share[e * bs * bs + cd], *half = &to->half[(i * bs + cd / bs) * width];
        PetscReal      *sum = &to->block[(to->place[at] * bs + cd % bs) * width];

        for (PetscInt k = 0; share != 0. && k < width; k++) sum[k] += share * half[k];
      }
    }
  }
}

/* `element` NULL: zeros, for the sparsity. */
static PetscErrorCode Add(MpmProjection *to, PetscInt n, const PetscInt nodes[], const PetscReal element[])
{
  const PetscInt bs = to->rows->block;

  PetscFunctionBeginUser;
  PetscCall(FindNodes(to, n, nodes));
  PetscCall(Enlarge(n * bs * to->count * bs, &to->room[1], sizeof(*to->half), &to->half));
  PetscCall(Enlarge(to->count * bs * to->count * bs, &to->room[2], sizeof(*to->block), &to->block));
  if (element) {
    TimesRows(to, n, nodes, element);
    RowsTimes(to, n, nodes);
  } else PetscCall(PetscArrayzero(to->block, to->count * bs * to->count * bs));
  PetscCall(MatSetValuesBlocked(to->mat, to->count, to->node, to->count, to->node, to->block, ADD_VALUES));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmProjectionTake(void *projection, PetscInt n, const PetscInt nodes[], const PetscReal element[])
{
  MpmProjection *to = (MpmProjection *)projection;

  if (!to->error) to->error = Add(to, n, nodes, element);
}

/* A box as MpmCoarse.box() describes it. */
static PetscErrorCode DescribeBox(void *projection, PetscInt n, const PetscInt nodes[], MpmCoarseBox *box)
{
  MpmProjection      *to   = (MpmProjection *)projection;
  const MpmLocalRows *rows = to->rows;
  const PetscInt      bs = rows->block, size = bs * bs;
  PetscInt            entries = 0;

  PetscFunctionBeginUser;
  PetscCall(FindNodes(to, n, nodes));
  PetscCall(Enlarge(n + 1, &to->room[4], sizeof(*to->begin), &to->begin));
  to->begin[0] = 0;
  for (PetscInt i = 0; i < n; i++) to->begin[i + 1] = to->begin[i] + rows->begin[nodes[i] + 1] - rows->begin[nodes[i]];
  PetscCall(Enlarge(to->begin[n] * size, &to->room[3], sizeof(*to->share), &to->share));
  for (PetscInt i = 0; i < n; entries = to->begin[++i])
    PetscCall(PetscArraycpy(&to->share[entries * size], &rows->share[rows->begin[nodes[i]] * size],
                            (to->begin[i + 1] - entries) * size));
  *box = (MpmCoarseBox){.count = to->count, .begin = to->begin, .place = to->place, .share = to->share};
  for (PetscInt k = 0; k < to->begin[n] * size; k++)
    if (to->share[k] != 0. && k % size / bs != k % bs) box->turned = PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddBox(void *projection, const PetscReal block[])
{
  const MpmProjection *to = (const MpmProjection *)projection;

  return MatSetValuesBlocked(to->mat, to->count, to->node, to->count, to->node, block, ADD_VALUES);
}

MpmCoarse MpmProjectionCoarse(MpmProjection *projection)
{
  return (MpmCoarse){.ctx = projection, .box = DescribeBox, .add = AddBox};
}

/* Zeros for all nodes that are coupled: those of a box, of a box with extra nodes, and of two boxes. */
static PetscErrorCode AddZeros(MpmProjection *to, const MpmSpace *space)
{
  PetscInt *nodes, most = 0;

  PetscFunctionBeginUser;
  for (PetscInt g = 0; g < space->boxes.count; g++) {
    most = PetscMax(most, space->groups[g].node_count);
    PetscCall(Add(to, space->groups[g].node_count, &space->group_nodes[space->groups[g].node_offset], NULL));
  }
  PetscCall(PetscMalloc1((2 * most + space->extra.count), &nodes));
  for (PetscInt k = 0; k < space->extra.link_count; k++) {
    const MpmLink *link = &space->extra.link[k];
    const PetscInt n    = link->box < 0 ? 0 : space->groups[link->box].node_count;

    if (n) PetscCall(PetscArraycpy(nodes, &space->group_nodes[space->groups[link->box].node_offset], n));
    for (PetscInt e = 0; e < link->count; e++) nodes[n + e] = space->extra.begin + link->first + e;
    PetscCall(Add(to, n + link->count, nodes, NULL));
  }
  for (PetscInt k = 0; k < space->parts.couple_count; k++) {
    PetscInt n = 0;

    for (PetscInt side = 0; side < 2; side++) {
      const MpmGroup *box = &space->groups[space->parts.couple[k].box[side]];

      PetscCall(PetscArraycpy(&nodes[n], &space->group_nodes[box->node_offset], box->node_count));
      n += box->node_count;
    }
    PetscCall(Add(to, n, nodes, NULL));
  }
  PetscCall(PetscFree(nodes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmProjectionCreate(const MpmLocalRows *rows, const MpmSpace *space, MPI_Comm comm,
                                   const PetscInt nodes[2], MpmProjection **projection, Mat *mat)
{
  const PetscInt bs = rows->block, own = nodes[0] * bs, all = nodes[1] * bs;
  Mat            room;
  PetscInt       begin;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(projection));
  (*projection)->rows = rows;
  PetscCall(MatCreate(comm, &room));
  PetscCall(MatSetSizes(room, own, own, all, all));
  PetscCall(MatSetBlockSize(room, bs));
  PetscCall(MatSetType(room, MATPREALLOCATOR));
  PetscCall(MatSetUp(room));
  (*projection)->mat = room;
  PetscCall(AddZeros(*projection, space));
  PetscCall(MatGetOwnershipRange(room, &begin, NULL));
  for (PetscInt k = 0; k < own; k++) PetscCall(MatSetValue(room, begin + k, begin + k, 0., ADD_VALUES));
  PetscCall(MatAssemblyBegin(room, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(room, MAT_FINAL_ASSEMBLY));
  PetscCall(MatCreate(comm, mat));
  PetscCall(MatSetSizes(*mat, own, own, all, all));
  PetscCall(MatSetBlockSize(*mat, bs));
  PetscCall(MatSetType(*mat, MATAIJ));
  PetscCall(MatPreallocatorPreallocate(room, PETSC_TRUE, *mat));
  PetscCall(MatDestroy(&room));
  (*projection)->mat = *mat;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmProjectionEnd(MpmProjection *projection)
{
  PetscFunctionBeginUser;
  PetscCall(projection->error);
  PetscCall(MatAssemblyBegin(projection->mat, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(projection->mat, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmProjectionDestroy(MpmProjection **projection)
{
  PetscFunctionBeginUser;
  if (!*projection) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*projection)->node));
  PetscCall(PetscFree((*projection)->place));
  PetscCall(PetscFree((*projection)->half));
  PetscCall(PetscFree((*projection)->block));
  PetscCall(PetscFree((*projection)->share));
  PetscCall(PetscFree((*projection)->begin));
  PetscCall(PetscFree(*projection));
  PetscFunctionReturn(PETSC_SUCCESS);
}
