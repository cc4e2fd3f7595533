/*
  Ghost penalty: a cure for nodes that the material hardly touches.

  Cells that a point's domain touches are material cells; one with a face neighbour in the grid that is none is an edge
  cell. On every face F between two material cells, one of them at least an edge cell, the step's increment u gets the
  energy

    (gamma/2) (E_s/h_n) Int_F |u_- - 2 u_0 + u_+|^2 dA

  where u_-, u_0, u_+ are the nodes before, on and behind the face along its normal n, with cell size h_n, and the
  integral along the face uses the linear mass matrix, h/6 [2 1; 1 2] an axis: the jump of the normal derivative of the
  grid's piecewise linear field, times h. E_s is the constrained modulus of the stiffest material beside the face. The
  badly supported node is tied to the linear extension of its neighbours, whatever sliver touches it, and the energy
  vanishes for any linear field. Being on increments, it puts no lasting force on the material.

  A face is a group of nodes, 3 along the normal and 2 on the other axes, without points: numbering and sparsity treat it
  like one.

  Sources: Burman (2010), doi:10.1016/j.crma.2010.10.006; for the material point method Coombs (2023),
  doi:10.1016/j.cma.2022.115736.
*/
#include "sum.h"

/* The material cells around this rank's nodes: 0 where there is none, or the number of the stiffest material plus one. */
typedef struct {
  PetscInt  dim, lower[MPM_MAX_DIM], size[MPM_MAX_DIM];
  PetscInt *mark;
} CellMap;

static PetscInt *CellAt(const CellMap *map, const PetscInt cell[])
{
  PetscInt i = 0;

  for (PetscInt a = map->dim - 1; a >= 0; a--) {
    const PetscInt k = cell[a] - map->lower[a];

    if (k < 0 || k >= map->size[a]) return NULL;
    i = i * map->size[a] + k;
  }
  return &map->mark[i];
}

static PetscBool IsMaterial(const CellMap *map, const PetscInt cell[])
{
  const PetscInt *mark = CellAt(map, cell);

  return (PetscBool)(mark && *mark);
}

static PetscBool IsEdge(const CellMap *map, const MpmGrid *grid, const PetscInt cell[])
{
  PetscInt next[MPM_MAX_DIM] = {cell[0], cell[1], cell[2]};

  for (PetscInt a = 0; a < map->dim; a++) {
    for (PetscInt side = -1; side <= 1; side += 2) {
      next[a] = cell[a] + side;
      if (next[a] >= 0 && next[a] < grid->cells[a] && !IsMaterial(map, next)) return PETSC_TRUE;
    }
    next[a] = cell[a];
  }
  return PETSC_FALSE;
}

/* Takes over a mark where it is stiffer. */
static void Mark(const CellMap *map, const MpmMaterial materials[], const PetscInt cell[], PetscInt material)
{
  PetscInt *mark = CellAt(map, cell);

  if (mark && (!*mark || materials[*mark - 1].stiffness < materials[material].stiffness)) *mark = material + 1;
}

#define FOR_BOX(lower, count, at) \
  for (at[2] = (lower)[2]; at[2] < (lower)[2] + (count)[2]; at[2]++) \
    for (at[1] = (lower)[1]; at[1] < (lower)[1] + (count)[1]; at[1]++) \
      for (at[0] = (lower)[0]; at[0] < (lower)[0] + (count)[0]; at[0]++)

/* The cells of a group: between its nodes. */
static void GroupCells(const MpmGroup *group, PetscInt dim, PetscInt lower[], PetscInt count[])
{
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    lower[a] = group->first[a];
    count[a] = a < dim ? PetscMax(group->count[a] - 1, 1) : 1;
  }
}

/* Marks the cells of this rank's points, in a map that reaches `margin` cells further. */
static PetscErrorCode MarkOwnPoints(const MpmSpace *space, const MpmMaterial materials[], const MpmPoints *points,
                                    PetscInt margin, CellMap *map)
{
  PetscInt upper[MPM_MAX_DIM] = {0, 0, 0}, lower[MPM_MAX_DIM], count[MPM_MAX_DIM], cell[MPM_MAX_DIM], total = 1;

  PetscFunctionBeginUser;
  map->dim = space->dim;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) map->lower[a] = PETSC_INT_MAX;
  for (PetscInt g = 0; g < space->group_count; g++) {
    GroupCells(&space->groups[g], space->dim, lower, count);
    for (PetscInt a = 0; a < space->dim; a++) {
      map->lower[a] = PetscMin(map->lower[a], lower[a] - margin);
      upper[a]      = PetscMax(upper[a], lower[a] + count[a] + margin);
    }
  }
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    if (a >= space->dim) map->lower[a] = 0;
    map->size[a] = a >= space->dim ? 1 : space->group_count ? upper[a] - map->lower[a] : 0;
    total *= map->size[a];
  }
  PetscCall(PetscCalloc1(total, &map->mark));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    GroupCells(group, space->dim, lower, count);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt material = points->material[space->order[s]];

      if (s > group->point_begin && material == points->material[space->order[s - 1]]) continue;
      FOR_BOX(lower, count, cell) Mark(map, materials, cell, material);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The ranks that own a cell within two of this one: `rank` has room for grid->size. */
static PetscInt RanksAround(const MpmGrid *grid, const PetscInt cell[], PetscMPIInt rank[])
{
  PetscInt lower[MPM_MAX_DIM] = {0, 0, 0}, count[MPM_MAX_DIM] = {1, 1, 1}, proc[MPM_MAX_DIM], ranks = 0;

  for (PetscInt a = 0; a < grid->dim; a++) {
    const PetscInt last  = grid->window_nodes[a] - 1;
    const PetscInt below = cell[a] - 2 - grid->window_lower[a], above = cell[a] + 2 - grid->window_lower[a];

    lower[a] = grid->proc_of[a][PetscMin(PetscMax(below, 0), last)];
    count[a] = grid->proc_of[a][PetscMin(PetscMax(above, 0), last)] - lower[a] + 1;
  }
  FOR_BOX(lower, count, proc)
  rank[ranks++] = (PetscMPIInt)((proc[2] * grid->procs[1] + proc[1]) * grid->procs[0] + proc[0]);
  return ranks;
}

/* Tells every rank the marks of cells that it owns or that lie within two cells of its own. */
static PetscErrorCode ExchangeMarks(const MpmGrid *grid, const MpmMaterial materials[], CellMap *map)
{
  MpmLists     sent = {0}, received = {0};
  PetscMPIInt *around;
  PetscInt    *length, *slot, *fill, cell[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1(grid->size, &around));
  PetscCall(PetscCalloc1(grid->size, &length));
  PetscCall(PetscMalloc2(grid->size, &slot, grid->size, &fill));
  for (PetscInt pass = 0; pass < 2; pass++) {
    FOR_BOX(map->lower, map->size, cell)
    {
      const PetscInt mark = *CellAt(map, cell), ranks = mark ? RanksAround(grid, cell, around) : 0;

      for (PetscInt r = 0; r < ranks; r++) {
        if (around[r] == grid->rank) continue;
        if (!pass) length[around[r]] += grid->dim + 1;
        else {
          PetscInt *to = &sent.data[fill[slot[around[r]]]];

          for (PetscInt a = 0; a < grid->dim; a++) to[a] = cell[a];
          to[grid->dim] = mark - 1;
          fill[slot[around[r]]] += grid->dim + 1;
        }
      }
    }
    if (pass) break;
    for (PetscMPIInt r = 0; r < grid->size; r++) sent.count += length[r] > 0;
    PetscCall(PetscMalloc1(sent.count, &sent.rank));
    PetscCall(PetscMalloc1((sent.count + 1), &sent.offset));
    sent.offset[0] = 0;
    for (PetscMPIInt r = 0, k = 0; r < grid->size; r++) {
      if (!length[r]) continue;
      sent.rank[k]       = r;
      slot[r]            = k;
      fill[k]            = sent.offset[k];
      sent.offset[k + 1] = sent.offset[k] + length[r];
      k++;
    }
    PetscCall(PetscMalloc1(sent.offset[sent.count], &sent.data));
  }
  PetscCall(MpmListsExchange(grid->comm, &sent, &received));
  for (PetscInt k = 0; k < received.offset[received.count]; k += grid->dim + 1) {
    PetscInt at[MPM_MAX_DIM] = {0, 0, 0};

    for (PetscInt a = 0; a < grid->dim; a++) at[a] = received.data[k + a];
    Mark(map, materials, at, received.data[k + grid->dim]);
  }
  PetscCall(MpmListsDestroy(&sent));
  PetscCall(MpmListsDestroy(&received));
  PetscCall(PetscFree(around));
  PetscCall(PetscFree(length));
  PetscCall(PetscFree2(slot, fill));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Appends the faces whose lower cell this rank owns; counts them where `faces` is NULL. */
static PetscInt ListFaces(const CellMap *map, const MpmGrid *grid, const MpmMaterial materials[], MpmGroup faces[],
                          PetscReal stiffness[])
{
  PetscInt cell[MPM_MAX_DIM], count = 0;

  FOR_BOX(map->lower, map->size, cell)
  {
    if (!IsMaterial(map, cell) || MpmGridNodeOwner(grid, cell) != grid->rank) continue;
    for (PetscInt axis = 0; axis < map->dim; axis++) {
      PetscInt next[MPM_MAX_DIM] = {cell[0], cell[1], cell[2]};

      next[axis]++;
      if (!IsMaterial(map, next) || !(IsEdge(map, grid, cell) || IsEdge(map, grid, next))) continue;
      if (faces) {
        MpmGroup *face = &faces[count];

        face->node_count = 1;
        for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
          face->first[a] = cell[a];
          face->count[a] = a >= map->dim ? 1 : a == axis ? 3 : 2;
          face->node_count *= face->count[a];
        }
        face->point_begin = face->point_end = 0;
        stiffness[count] =
          PetscMax(materials[*CellAt(map, cell) - 1].stiffness, materials[*CellAt(map, next) - 1].stiffness);
      }
      count++;
    }
  }
  return count;
}

PetscErrorCode MpmGhostFaces(MpmSpace *space, const MpmGrid *grid, const MpmMaterial materials[],
                             const MpmPoints *points)
{
  CellMap   map;
  MpmGroup *faces;

  PetscFunctionBeginUser;
  PetscCall(MarkOwnPoints(space, materials, points, grid->size > 1 ? 3 : 0, &map));
  if (grid->size > 1) PetscCall(ExchangeMarks(grid, materials, &map));
  space->face_count = ListFaces(&map, grid, materials, NULL, NULL);
  PetscCall(MpmSpaceAppendBoxes(space, space->face_count, &faces));
  PetscCall(PetscMalloc1(space->face_count, &space->face_stiffness));
  (void)ListFaces(&map, grid, materials, faces, space->face_stiffness);
  PetscCall(PetscFree(map.mark));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscInt MpmGhostMatrix(const MpmSpace *space, const MpmGrid *grid, PetscReal factor, PetscInt face, PetscReal matrix[])
{
  const MpmGroup *group = &space->groups[space->group_count + face];
  const PetscInt  n     = group->node_count;

  for (PetscInt i = 0; i < n; i++) {
    for (PetscInt j = 0; j < n; j++) {
      PetscInt  p = i, q = j;
      PetscReal value = factor * space->face_stiffness[face];

      for (PetscInt a = 0; a < space->dim; a++) {
        const PetscInt k = p % group->count[a], l = q % group->count[a];

        if (group->count[a] == 3) value *= (k == 1 ? -2. : 1.) * (l == 1 ? -2. : 1.) / grid->h[a];
        else value *= grid->h[a] / (k == l ? 3. : 6.);
        p /= group->count[a];
        q /= group->count[a];
      }
      matrix[i * n + j] = value;
    }
  }
  return n;
}

PetscErrorCode MpmGhostResidual(const MpmSum *sum, const PetscReal u[], PetscReal residual[])
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->layout->block, dim = space->dim;
  PetscReal       matrix[MPM_GHOST_NODES * MPM_GHOST_NODES];

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < space->face_count; f++) {
    const PetscInt  n     = MpmGhostMatrix(space, sum->grid, sum->ghost, f, matrix);
    const PetscInt *nodes = &space->group_nodes[space->groups[space->group_count + f].node_offset];

    for (PetscInt i = 0; i < n; i++)
      for (PetscInt j = 0; j < n; j++)
        for (PetscInt c = 0; c < dim; c++) residual[nodes[i] * bs + c] += matrix[i * n + j] * u[nodes[j] * bs + c];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGhostDiagonal(const MpmSum *sum, PetscReal blocks[])
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->layout->block, dim = space->dim;
  PetscReal       matrix[MPM_GHOST_NODES * MPM_GHOST_NODES];

  PetscFunctionBeginUser;
  for (PetscInt f = 0; f < space->face_count; f++) {
    const PetscInt  n     = MpmGhostMatrix(space, sum->grid, sum->ghost, f, matrix);
    const PetscInt *nodes = &space->group_nodes[space->groups[space->group_count + f].node_offset];

    for (PetscInt i = 0; i < n; i++)
      for (PetscInt c = 0; c < dim; c++) blocks[(nodes[i] * bs + c) * bs + c] += matrix[i * n + i];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGhostJacobian(const MpmSum *sum, MpmPattern *pattern)
{
  const MpmSpace *space = sum->space;
  const PetscInt  bs = sum->layout->block, dim = space->dim;
  PetscReal       matrix[MPM_GHOST_NODES * MPM_GHOST_NODES], *element;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((MPM_GHOST_NODES * MPM_GHOST_NODES * bs * bs), &element));
  for (PetscInt f = 0; f < space->face_count; f++) {
    const PetscInt n = MpmGhostMatrix(space, sum->grid, sum->ghost, f, matrix);

    PetscCall(PetscArrayzero(element, n * n * bs * bs));
    for (PetscInt i = 0; i < n; i++)
      for (PetscInt c = 0; c < dim; c++)
        for (PetscInt j = 0; j < n; j++) element[((i * bs + c) * bs + c) * n + j] = matrix[i * n + j];
    MpmPatternAddBlock(pattern, space, &space->groups[space->group_count + f], sum->constraints, element);
  }
  PetscCall(PetscFree(element));
  PetscFunctionReturn(PETSC_SUCCESS);
}
