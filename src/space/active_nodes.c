/*
  The active nodes: those that points touch. Every rank sends the owners the numbers of the nodes that it touches, the
  owners number these, and the answers make the scatter between owned nodes and ghosts. No array is as large as the
  grid.
*/
#include "grid/grid.h"
#include "space/space.h"

/* A box of nodes with one integer each: those of one part of the material, or there would be one around them all. */
typedef struct {
  PetscInt  dim, lower[MPM_MAX_DIM], upper[MPM_MAX_DIM]; /* upper is exclusive */
  PetscInt *value;
} NodeMap;

static inline PetscInt *MapAt(const NodeMap *map, const PetscInt node[])
{
  PetscInt i = node[map->dim - 1] - map->lower[map->dim - 1];

  for (PetscInt a = map->dim - 2; a >= 0; a--) i = i * (map->upper[a] - map->lower[a]) + node[a] - map->lower[a];
  return &map->value[i];
}

static void MapInclude(NodeMap *map, const PetscInt node[])
{
  for (PetscInt a = 0; a < map->dim; a++) {
    map->lower[a] = PetscMin(map->lower[a], node[a]);
    map->upper[a] = PetscMax(map->upper[a], node[a] + 1);
  }
}

/* The map, among those of all parts, that a node belongs to. */
static inline NodeMap *MapOf(const MpmSpace *space, NodeMap maps[], const PetscInt node[])
{
  return &maps[MpmSpacePart(space, node)];
}

/* The map of a box. */
static inline NodeMap *MapOfBox(const MpmSpace *space, NodeMap maps[], PetscInt box)
{
  const MpmGroup *group = &space->groups[box];

  return box < space->group_count ? &maps[group->part] : MapOf(space, maps, group->first);
}

static PetscInt64 MapSize(const NodeMap *map)
{
  PetscInt64 size = 1;

  for (PetscInt a = 0; a < map->dim; a++) size *= PetscMax(map->upper[a] - map->lower[a], 0);
  return size;
}

static PetscErrorCode MapAllocate(NodeMap *map)
{
  const PetscInt64 size = MapSize(map);

  PetscFunctionBeginUser;
  PetscCheck(size < PETSC_INT_MAX, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "the points of one rank span %" PetscInt64_FMT " nodes", size);
  PetscCall(PetscMalloc1(size, &map->value));
  for (PetscInt64 i = 0; i < size; i++) map->value[i] = -1;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Goes through the rows of a group's nodes along x: `row` is their places in the map. */
#define FOR_GROUP_ROWS(map, group, row) \
  for (PetscInt k_ = 0, x_ = (map)->upper[0] - (map)->lower[0], y_ = (map)->upper[1] - (map)->lower[1]; \
       k_ < (group)->count[2]; k_++) \
    for (PetscInt j_ = ((row) = MapAt(map, (group)->first) + k_ * y_ * x_, 0); j_ < (group)->count[1]; \
         j_++, (row) += x_)

/* Marks the nodes that this rank's points touch, in a map for each part. */
static PetscErrorCode MarkTouched(const MpmSpace *space, NodeMap maps[])
{
  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < space->parts.count; k++) {
    maps[k].dim = space->dim;
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      maps[k].lower[a] = PETSC_INT_MAX;
      maps[k].upper[a] = 0;
    }
  }
  for (PetscInt g = 0; g < space->boxes.count; g++) {
    const MpmGroup *group = &space->groups[g];
    NodeMap        *map   = MapOfBox(space, maps, g);
    PetscInt        last[MPM_MAX_DIM];

    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) last[a] = group->first[a] + group->count[a] - 1;
    MapInclude(map, group->first);
    MapInclude(map, last);
  }
  for (PetscInt k = 0; k < space->parts.count; k++) PetscCall(MapAllocate(&maps[k]));
  for (PetscInt g = 0; g < space->boxes.count; g++) {
    const MpmGroup *group = &space->groups[g];
    const NodeMap  *map   = MapOfBox(space, maps, g);
    PetscInt       *row;

    if (group->holes) continue;
    FOR_GROUP_ROWS(map, group, row) for (PetscInt i = 0; i < group->count[0]; i++) row[i] = 0;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

#define FOR_MAP_NODES(map, node) \
  for (node[2] = (map)->dim > 2 ? (map)->lower[2] : 0; node[2] < ((map)->dim > 2 ? (map)->upper[2] : 1); node[2]++) \
    for (node[1] = (map)->lower[1]; node[1] < (map)->upper[1]; node[1]++) \
      for (node[0] = (map)->lower[0]; node[0] < (map)->upper[0]; node[0]++)

/* Copies of a node that belong to other parts have its owner. */
static PetscMPIInt Owner(const MpmSpace *space, const MpmGrid *grid, const PetscInt node[])
{
  PetscInt at[MPM_MAX_DIM];

  MpmSpaceAt(space, node, at);
  return MpmGridNodeOwner(grid, at);
}

/* The touched nodes of other ranks, as lists of lattice indices, `dim` integers a node. */
static PetscErrorCode ListForeign(const MpmSpace *space, const MpmGrid *grid, const NodeMap maps[], MpmLists *lists)
{
  PetscInt *slot, node[MPM_MAX_DIM], *fill;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->size, &slot));
  for (PetscInt part = 0; part < space->parts.count; part++) FOR_MAP_NODES(&maps[part], node)
  if (*MapAt(&maps[part], node) >= 0) slot[Owner(space, grid, node)]++;
  slot[grid->rank] = 0;
  for (PetscMPIInt r = 0; r < grid->size; r++) lists->count += slot[r] > 0;
  PetscCall(PetscMalloc1(lists->count, &lists->rank));
  PetscCall(PetscMalloc1((lists->count + 1), &lists->offset));
  PetscCall(PetscMalloc1(lists->count, &fill));
  lists->offset[0] = 0;
  for (PetscMPIInt r = 0, k = 0; r < grid->size; r++) {
    if (!slot[r]) {
      slot[r] = -1;
      continue;
    }
    lists->rank[k]       = r;
    lists->offset[k + 1] = lists->offset[k] + slot[r] * grid->dim;
    fill[k]              = lists->offset[k];
    slot[r]              = k++;
  }
  PetscCall(PetscMalloc1(lists->offset[lists->count], &lists->data));
  for (PetscInt part = 0; part < space->parts.count; part++) {
    FOR_MAP_NODES(&maps[part], node)
    {
      PetscInt k;

      if (*MapAt(&maps[part], node) < 0) continue;
      k = slot[Owner(space, grid, node)];
      for (PetscInt a = 0; k >= 0 && a < grid->dim; a++) lists->data[fill[k]++] = node[a];
    }
  }
  PetscCall(PetscFree(fill));
  PetscCall(PetscFree(slot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The extra nodes' local and global numbers. */
static void NumberExtra(MpmSpace *space, PetscInt begin)
{
  space->extra.begin = begin;
  for (PetscInt k = 0; k < space->extra.count; k++) {
    for (PetscInt a = 0; a < space->dim; a++) space->node[(begin + k) * space->dim + a] = 0;
    space->number.global[begin + k] = space->number.count - space->extra.count + k;
  }
}

/* Leaves in the maps the own nodes among those touched by any rank. On one rank that is all that there is. */
static PetscErrorCode KeepOwned(const MpmSpace *space, const MpmGrid *grid, const MpmLists *wanted, NodeMap maps[])
{
  const PetscInt dim = space->dim, end = wanted->offset[wanted->count];
  PetscInt       node[MPM_MAX_DIM] = {0, 0, 0};
  NodeMap       *old;

  PetscFunctionBeginUser;
  if (grid->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(space->parts.count, &old));
  PetscCall(PetscArraycpy(old, maps, space->parts.count));
  for (PetscInt k = 0; k < end; k += dim) MapInclude(MapOf(space, maps, &wanted->data[k]), &wanted->data[k]);
  for (PetscInt part = 0; part < space->parts.count; part++) PetscCall(MapAllocate(&maps[part]));
  for (PetscInt k = 0; k < end; k += dim) *MapAt(MapOf(space, maps, &wanted->data[k]), &wanted->data[k]) = 0;
  for (PetscInt part = 0; part < space->parts.count; part++) {
    FOR_MAP_NODES(&old[part], node)
    {
      if (*MapAt(&old[part], node) >= 0 && Owner(space, grid, node) == grid->rank) *MapAt(&maps[part], node) = 0;
    }
    PetscCall(PetscFree(old[part].value));
  }
  PetscCall(PetscFree(old));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Lists the owned nodes that any rank touches, in lattice order, and gives them their local numbers in the maps. */
static PetscErrorCode NumberOwned(MpmSpace *space, const MpmGrid *grid, const MpmLists *wanted, PetscInt ghosts,
                                  NodeMap maps[])
{
  const PetscInt  dim               = space->dim;
  const PetscBool last              = (PetscBool)(grid->rank == grid->size - 1);
  PetscInt        node[MPM_MAX_DIM] = {0, 0, 0};

  PetscFunctionBeginUser;
  PetscCall(KeepOwned(space, grid, wanted, maps));
  space->owned = 0;
  for (PetscInt part = 0; part < space->parts.count; part++) {
    const PetscInt64 size = MapSize(&maps[part]);

    for (PetscInt64 i = 0; i < size; i++) space->owned += maps[part].value[i] == 0;
  }
  space->local = space->owned + ghosts + space->extra.count;
  if (last) space->owned += space->extra.count;
  PetscCall(PetscMalloc2((space->local * dim), &space->node, space->local, &space->number.global));
  PetscCallMPI(MPI_Scan(&space->owned, &space->number.begin, 1, MPIU_INT, MPI_SUM, grid->comm));
  space->number.begin -= space->owned;
  PetscCall(MPIU_Allreduce(&space->owned, &space->number.count, 1, MPIU_INT, MPI_SUM, grid->comm));
  space->owned = 0;
  for (PetscInt part = 0; part < space->parts.count; part++) {
    PetscInt *number = maps[part].value;

    FOR_MAP_NODES(&maps[part], node)
    {
      PetscInt *at = number++;

      if (*at < 0) continue;
      *at = space->owned++;
      for (PetscInt a = 0; a < dim; a++) space->node[*at * dim + a] = node[a];
      space->number.global[*at] = space->number.begin + *at;
    }
  }
  NumberExtra(space, last ? space->owned : space->local - space->extra.count);
  if (last) space->owned += space->extra.count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Answers every question, in its order, with the number of this rank's first node and the local number here. */
static PetscErrorCode AnswerNumbers(const MpmSpace *space, const MpmLists *wanted, NodeMap maps[], MpmLists *answer)
{
  const PetscInt dim = space->dim;

  PetscFunctionBeginUser;
  answer->count = wanted->count;
  PetscCall(PetscMalloc1(answer->count, &answer->rank));
  PetscCall(PetscMalloc1((answer->count + 1), &answer->offset));
  PetscCall(PetscMalloc1((wanted->offset[wanted->count] / dim + wanted->count), &answer->data));
  answer->offset[0] = 0;
  for (PetscInt k = 0; k < wanted->count; k++) {
    PetscInt fill = answer->offset[k];

    answer->rank[k]      = wanted->rank[k];
    answer->data[fill++] = space->number.begin;
    for (PetscInt i = wanted->offset[k]; i < wanted->offset[k + 1]; i += dim)
      answer->data[fill++] = *MapAt(MapOf(space, maps, &wanted->data[i]), &wanted->data[i]);
    answer->offset[k + 1] = fill;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Extra nodes are ghosts of the last rank as its other nodes are, and behind them. */
static PetscErrorCode ScatterExtra(const MpmSpace *space, const MpmGrid *grid, PetscInt leaf[], PetscSFNode remote[])
{
  const PetscInt ghosts = space->local - space->owned, count = space->extra.count;
  PetscInt       owned = space->owned;

  PetscFunctionBeginUser;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(&owned, 1, MPIU_INT, grid->size - 1, grid->comm));
  for (PetscInt k = 0; k < count && grid->rank < grid->size - 1; k++) {
    const PetscInt ghost = ghosts - count + k;

    leaf[ghost]   = space->owned + ghost;
    remote[ghost] = (PetscSFNode){.rank = grid->size - 1, .index = owned - count + k};
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers the ghosts after the owned nodes, learns their owners' numbers, and builds the scatter. */
static PetscErrorCode NumberGhosts(MpmSpace *space, const MpmGrid *grid, const MpmLists *foreign,
                                   const MpmLists *wanted, NodeMap maps[])
{
  const PetscInt dim = space->dim, ghosts = space->local - space->owned;
  MpmLists       answer = {0}, numbers = {0};
  PetscInt      *leaf;
  PetscSFNode   *remote;

  PetscFunctionBeginUser;
  if (grid->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(AnswerNumbers(space, wanted, maps, &answer));
  PetscCall(MpmListsExchange(grid->comm, &answer, &numbers));
  PetscCall(PetscMalloc1(ghosts, &leaf));
  PetscCall(PetscMalloc1(ghosts, &remote));
  for (PetscInt k = 0, ghost = 0; k < foreign->count; k++) {
    PetscInt from = 0;

    while (numbers.rank[from] != foreign->rank[k]) from++;
    for (PetscInt i = foreign->offset[k], j = numbers.offset[from] + 1; i < foreign->offset[k + 1];
         i += dim, j++, ghost++) {
      const PetscInt local = space->owned + ghost;

      *MapAt(MapOf(space, maps, &foreign->data[i]), &foreign->data[i]) = local;
      PetscCall(PetscArraycpy(&space->node[local * dim], &foreign->data[i], dim));
      space->number.global[local] = numbers.data[numbers.offset[from]] + numbers.data[j];
      leaf[ghost]                 = local;
      remote[ghost].rank          = foreign->rank[k];
      remote[ghost].index         = numbers.data[j];
    }
  }
  PetscCall(ScatterExtra(space, grid, leaf, remote));
  PetscCall(PetscSFCreate(grid->comm, &space->number.sf));
  PetscCall(
    PetscSFSetGraph(space->number.sf, space->owned, ghosts, leaf, PETSC_OWN_POINTER, remote, PETSC_OWN_POINTER));
  PetscCall(PetscSFSetUp(space->number.sf));
  PetscCall(MpmListsDestroy(&answer));
  PetscCall(MpmListsDestroy(&numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceNumberNodes(MpmSpace *space, const MpmGrid *grid)
{
  NodeMap *maps;
  MpmLists foreign = {0}, wanted = {0};
  PetscInt total = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(space->parts.count, &maps));
  PetscCall(MarkTouched(space, maps));
  if (grid->size > 1) {
    PetscCall(ListForeign(space, grid, maps, &foreign));
    PetscCall(MpmListsExchange(grid->comm, &foreign, &wanted));
  } else PetscCall(PetscCalloc1(1, &wanted.offset));
  PetscCall(NumberOwned(space, grid, &wanted, foreign.count ? foreign.offset[foreign.count] / grid->dim : 0, maps));
  PetscCall(NumberGhosts(space, grid, &foreign, &wanted, maps));
  for (PetscInt g = 0; g < space->boxes.count; g++) total += space->groups[g].node_count;
  PetscCall(PetscMalloc1(total, &space->group_nodes));
  for (PetscInt g = 0, fill = 0; g < space->boxes.count; g++) {
    const MpmGroup *group = &space->groups[g];
    const NodeMap  *map   = MapOfBox(space, maps, g);
    PetscInt       *row;

    FOR_GROUP_ROWS(map, group, row) for (PetscInt i = 0; i < group->count[0]; i++) space->group_nodes[fill++] = row[i];
  }
  PetscCall(MpmListsDestroy(&foreign));
  PetscCall(MpmListsDestroy(&wanted));
  for (PetscInt k = 0; k < space->parts.count; k++) PetscCall(PetscFree(maps[k].value));
  PetscCall(PetscFree(maps));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One MPI unit holds the values of a node; PETSc does not sum contiguous types of one. */
static PetscErrorCode BlockUnit(PetscInt block, MPI_Datatype *unit)
{
  PetscFunctionBeginUser;
  *unit = MPIU_REAL;
  if (block == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Type_contiguous((PetscMPIInt)block, MPIU_REAL, unit));
  PetscCallMPI(MPI_Type_commit(unit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceToGhosts(const MpmSpace *space, PetscInt block, PetscReal local[])
{
  MPI_Datatype unit;

  PetscFunctionBeginUser;
  if (!space->number.sf) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(BlockUnit(block, &unit));
  PetscCall(PetscSFBcastBegin(space->number.sf, unit, local, local, MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(space->number.sf, unit, local, local, MPI_REPLACE));
  if (block > 1) PetscCallMPI(MPI_Type_free(&unit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceAddToOwners(const MpmSpace *space, PetscInt block, PetscReal local[])
{
  MPI_Datatype unit;

  PetscFunctionBeginUser;
  if (!space->number.sf) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(BlockUnit(block, &unit));
  PetscCall(PetscSFReduceBegin(space->number.sf, unit, local, local, MPIU_SUM));
  PetscCall(PetscSFReduceEnd(space->number.sf, unit, local, local, MPIU_SUM));
  if (block > 1) PetscCallMPI(MPI_Type_free(&unit));
  PetscFunctionReturn(PETSC_SUCCESS);
}
