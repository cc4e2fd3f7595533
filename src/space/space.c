/*
  The step's discrete space: shape weights of every point, and groups of points that touch the same nodes.

  Grouping is what makes assembly cheap: nodal values are gathered, and element blocks scattered, once a group instead
  of once a point, and no point pays for more nodes than it touches.
*/
#include "space/point_loop.h"

PetscErrorCode MpmSpaceReset(MpmSpace *space)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(space->first, space->count));
  PetscCall(PetscFree2(space->weight, space->gradient));
  PetscCall(PetscFree(space->order));
  PetscCall(PetscFree(space->groups));
  PetscCall(PetscFree(space->faces));
  PetscCall(PetscFree(space->cells));
  PetscCall(PetscFree(space->share));
  PetscCall(PetscFree(space->group_nodes));
  PetscCall(PetscFree2(space->node, space->global));
  PetscCall(PetscSFDestroy(&space->sf));
  PetscCall(PetscMemzero(space, sizeof(*space)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Does a wall stand beside this point, that is, does the point project into the wall's extent? */
static PetscBool WallFaces(const MpmWall *wall, PetscInt dim, const PetscReal x[])
{
  for (PetscInt a = 0; a < dim; a++) {
    if (a != wall->axis && (x[a] < wall->lower[a] || x[a] > wall->upper[a])) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}

void MpmSpaceEdges(const MpmRules *rules, const PetscReal x[], PetscInt lower[], PetscInt upper[])
{
  const MpmGrid *grid  = rules->grid;
  const MpmWall *walls = rules->walls;

  for (PetscInt a = 0; a < grid->dim; a++) {
    lower[a] = 0;
    upper[a] = grid->nodes[a] - 1;
  }
  for (PetscInt w = 0; w < rules->wall_count; w++) {
    const PetscInt  a  = walls[w].axis;
    const PetscReal xi = (x[a] - grid->lower[a]) / grid->h[a];

    if (walls[w].side > 0) {
      if (xi >= (PetscReal)walls[w].node && walls[w].node > lower[a] && WallFaces(&walls[w], grid->dim, x))
        lower[a] = walls[w].node;
    } else {
      if (xi <= (PetscReal)walls[w].node && walls[w].node < upper[a] && WallFaces(&walls[w], grid->dim, x))
        upper[a] = walls[w].node;
    }
  }
}

PetscBool MpmSpaceHalfLengths(const MpmRules *rules, const MpmPoints *points, PetscInt p, PetscReal half[])
{
  const MpmGrid   *grid = rules->grid;
  const PetscInt   dim  = grid->dim;
  const PetscReal *x    = &points->x[p * dim];
  PetscInt         lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];
  PetscReal        U[MPM_MAX_DIM] = {1., 1., 1.};
  const PetscBool  good           = (PetscBool)!rules->stretch(&points->F[p * dim * dim], U);

  MpmSpaceEdges(rules, x, lower, upper);
  for (PetscInt a = 0; a < dim; a++) {
    const PetscReal xi = (x[a] - grid->lower[a]) / grid->h[a];
    PetscReal       l  = points->half_length[p * dim + a] * U[a] / grid->h[a];

    l       = PetscMin(l, PetscMin(xi - (PetscReal)lower[a], (PetscReal)upper[a] - xi));
    half[a] = PetscMax(l, 0.);
  }
  return good;
}

/* Those of all points, and the longest: infinite when a point has no stretch. */
static void HalfLengths(const MpmRules *rules, const MpmPoints *points, PetscReal half[], PetscReal *longest)
{
  const PetscInt dim = rules->grid->dim;

  *longest = 0.;
  for (PetscInt p = 0; p < points->count; p++) {
    if (!MpmSpaceHalfLengths(rules, points, p, &half[p * dim])) *longest = PETSC_INFINITY;
    for (PetscInt a = 0; a < dim; a++) *longest = PetscMax(*longest, half[p * dim + a]);
  }
}

/* Weights and gradients of all points, axis by axis. */
static PetscErrorCode EvaluateShapes(MpmSpace *space, const MpmRules *rules, const MpmPoints *points, const char **why)
{
  const MpmGrid *grid = rules->grid;
  const PetscInt dim  = grid->dim;
  PetscReal     *half = NULL, longest = 0.;

  PetscFunctionBeginUser;
  space->dim         = dim;
  space->point_count = points->count;
  if (MpmShapeHasDomain(rules->shape)) {
    PetscCall(PetscMalloc1((points->count * dim), &half));
    HalfLengths(rules, points, half, &longest);
    /* the Jacobian's window, and with it the colours, must be the same on all ranks */
    PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &longest, 1, MPIU_REAL, MPIU_MAX, grid->comm));
  }
  if (!(longest < MPM_MAX_WIDTH)) *why = "a point has no stretch, or its domain spans too many cells";
  else if ((space->width = MpmShapeWidth(rules->shape, longest)) > MPM_MAX_WIDTH)
    *why = "a point's domain spans too many cells";
  if (*why) {
    PetscCall(PetscFree(half));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc2((points->count * dim), &space->first, (points->count * dim), &space->count));
  PetscCall(PetscMalloc2((points->count * dim * space->width), &space->weight, (points->count * dim * space->width),
                         &space->gradient));
  for (PetscInt p = 0; p < points->count; p++) {
    PetscInt lower[MPM_MAX_DIM], upper[MPM_MAX_DIM];

    MpmSpaceEdges(rules, &points->x[p * dim], lower, upper);
    for (PetscInt a = 0; a < dim; a++) {
      const PetscInt  k  = p * dim + a;
      const PetscReal xi = (points->x[k] - grid->lower[a]) / grid->h[a];
      MpmShapeLine line  = {.weight = &space->weight[k * space->width], .gradient = &space->gradient[k * space->width]};

      MpmShapeEvaluate(rules->shape, rules->edge, xi, half ? half[k] : 0., lower[a], upper[a], &line);
      for (PetscInt i = 0; i < line.count; i++) line.gradient[i] /= grid->h[a];
      space->first[k] = line.first;
      space->count[k] = line.count;
    }
  }
  PetscCall(PetscFree(half));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One stable pass of a counting sort: order_out lists the entries of order_in by ascending key. */
static PetscErrorCode CountingSort(PetscInt count, const PetscInt key[], PetscInt64 keys, const PetscInt order_in[],
                                   PetscInt order_out[])
{
  PetscInt *start;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((keys + 1), &start));
  for (PetscInt i = 0; i < count; i++) start[key[i] + 1]++;
  for (PetscInt64 k = 0; k < keys; k++) start[k + 1] += start[k];
  for (PetscInt i = 0; i < count; i++) {
    const PetscInt p = order_in ? order_in[i] : i;

    order_out[start[key[p]]++] = p;
  }
  PetscCall(PetscFree(start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*
  Orders the points by first node, then by the shape of their node box, and marks off the groups. With a mean the points
  of a cell, by their centres, stand side by side: the first node follows from the cell and a place of `width` beside it.
*/
static PetscErrorCode MakeGroups(MpmSpace *space, const MpmRules *rules, const MpmPoints *points)
{
  const PetscInt n = space->point_count, dim = space->dim;
  PetscInt       lower[MPM_MAX_DIM] = {PETSC_INT_MAX, PETSC_INT_MAX, PETSC_INT_MAX}, upper[MPM_MAX_DIM] = {0, 0, 0};
  PetscInt64     cells = 1, shapes = 1;
  PetscInt      *cell_key, *shape_key, *order, groups = 0;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < n * dim; k++) {
    lower[k % dim] = PetscMin(lower[k % dim], space->first[k]);
    upper[k % dim] = PetscMax(upper[k % dim], space->first[k] + (rules->mean ? space->width : 0));
  }
  for (PetscInt a = 0; n && a < dim; a++) {
    cells *= upper[a] - lower[a] + 1;
    shapes *= space->width * (rules->mean ? space->width : 1);
  }
  PetscCheck(cells < PETSC_INT_MAX, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "the points of one rank span %" PetscInt64_FMT " cells", cells);
  PetscCall(PetscMalloc3(n, &cell_key, n, &shape_key, n, &order));
  PetscCall(PetscMalloc1(n, &space->order));
  for (PetscInt p = 0; p < n; p++) {
    PetscInt home[MPM_MAX_DIM];

    cell_key[p] = shape_key[p] = 0;
    if (rules->mean) MpmGridFindCell(rules->grid, &points->x[p * dim], home);
    for (PetscInt a = dim - 1; a >= 0; a--) {
      const PetscInt first = space->first[p * dim + a], place = rules->mean ? home[a] : first;

      cell_key[p]  = cell_key[p] * (upper[a] - lower[a] + 1) + place - lower[a];
      shape_key[p] = shape_key[p] * space->width + space->count[p * dim + a] - 1;
      if (rules->mean) shape_key[p] = shape_key[p] * space->width + place - first;
    }
  }
  PetscCall(CountingSort(n, shape_key, shapes, NULL, order));
  PetscCall(CountingSort(n, cell_key, cells, order, space->order));
#define NEW_GROUP(i) \
  (!(i) || cell_key[space->order[i]] != cell_key[space->order[(i)-1]] || \
   shape_key[space->order[i]] != shape_key[space->order[(i)-1]])
  for (PetscInt i = 0; i < n; i++) groups += NEW_GROUP(i);
  PetscCall(PetscCalloc1(groups, &space->groups));
  space->group_count = groups;
  for (PetscInt i = 0, g = -1, cell = -1; i < n; i++) {
    if (NEW_GROUP(i)) {
      MpmGroup *group = &space->groups[++g];

      group->node_count = 1;
      for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
        group->first[a] = a < dim ? space->first[space->order[i] * dim + a] : 0;
        group->count[a] = a < dim ? space->count[space->order[i] * dim + a] : 1;
        group->node_count *= group->count[a];
      }
      group->point_begin = i;
      group->cell        = cell += !i || cell_key[space->order[i]] != cell_key[space->order[i - 1]];
    }
    space->groups[g].point_end = i + 1;
  }
#undef NEW_GROUP
  PetscCall(PetscFree3(cell_key, shape_key, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where each box's nodes will stand, and how far a box reaches. */
static PetscErrorCode FinishBoxes(MpmSpace *space, MPI_Comm comm)
{
  PetscInt offset = 0;

  PetscFunctionBeginUser;
  space->reach = PetscMax(space->width - 1, 1);
  for (PetscInt g = 0; g < space->box_count; g++) {
    MpmGroup *box = &space->groups[g];

    for (PetscInt a = 0; a < space->dim; a++) space->reach = PetscMax(space->reach, box->count[a] - 1);
    box->node_offset = offset;
    offset += box->node_count;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &space->reach, 1, MPIU_INT, MPI_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceAppendBoxes(MpmSpace *space, PetscInt count, MpmGroup **boxes)
{
  MpmGroup *groups;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((space->box_count + count), &groups));
  PetscCall(PetscArraycpy(groups, space->groups, space->box_count));
  PetscCall(PetscFree(space->groups));
  space->groups = groups;
  *boxes        = &groups[space->box_count];
  space->box_count += count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceBegin(MpmSpace *space, const MpmRules *rules, const MpmPoints *points, const char **why)
{
  PetscFunctionBeginUser;
  *why = NULL;
  PetscCall(MpmSpaceReset(space));
  PetscCall(EvaluateShapes(space, rules, points, why));
  if (*why) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MakeGroups(space, rules, points));
  space->box_count = space->group_count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceEnd(MpmSpace *space, const MpmRules *rules)
{
  PetscFunctionBeginUser;
  PetscCall(FinishBoxes(space, rules->grid->comm));
  PetscCall(MpmSpaceNumberNodes(space, rules->grid));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void MpmSpaceEvaluate(const MpmSpace *space, const MpmGroup *group, PetscInt point, MpmBasis *basis)
{
  const PetscInt *count = group->count;
  const MpmKnown  known = {.dim = space->dim, .count = {count[0], count[1], count[2]}, .n = group->node_count};

  MpmSumBasis(known, space, point, PETSC_TRUE, basis);
}
