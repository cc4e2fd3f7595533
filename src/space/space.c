/*
  The step's discrete space: shape weights of every point, and groups of points that touch the same nodes.

  Grouping is what makes assembly cheap: nodal values are gathered, and element blocks scattered, once a group instead
  of once a point, and no point pays for more nodes than it touches.
*/
#include "base/outcome.h"
#include "grid/grid.h"
#include "space/point_loop.h"
#include "space/rules.h"

static PetscErrorCode SpreadDestroy(MpmSpread **spread)
{
  PetscFunctionBeginUser;
  if (*spread) PetscCall(PetscFree3((*spread)->first, (*spread)->count, (*spread)->part));
  PetscCall(PetscFree(*spread));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceReset(MpmSpace *space)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(space->touched.first, space->touched.count));
  for (PetscInt k = 0; k < space->shapes.count; k++) {
    PetscCall(PetscFree3(space->shapes.at[k].weight, space->shapes.at[k].gradient, space->shapes.at[k].mean));
    PetscCall(PetscFree2(space->shapes.at[k].cross, space->shapes.at[k].slope));
    PetscCall(PetscFree(space->shapes.at[k].hoop));
  }
  PetscCall(PetscFree(space->shapes.half));
  PetscCall(PetscFree(space->extension.follower));
  PetscCall(PetscFree(space->extension.offset));
  PetscCall(PetscFree(space->extension.master));
  PetscCall(PetscFree(space->extension.weight));
  PetscCall(PetscFree(space->extension.of));
  PetscCall(PetscFree(space->shapes.support));
  PetscCall(PetscFree(space->order));
  PetscCall(PetscFree(space->groups));
  PetscCall(PetscFree(space->boxes.faces.face));
  PetscCall(PetscFree(space->boxes.faces.matrix));
  PetscCall(PetscFree(space->cells.at));
  PetscCall(PetscFree(space->cells.share));
  PetscCall(PetscFree(space->cells.mode));
  PetscCall(SpreadDestroy(&space->cells.spread));
  PetscCall(PetscFree(space->group_nodes));
  PetscCall(PetscFree(space->extra.free));
  PetscCall(PetscFree(space->extra.link));
  PetscCall(PetscFree(space->parts.couple));
  PetscCall(PetscFree2(space->node, space->number.global));
  PetscCall(PetscSFDestroy(&space->number.sf));
  PetscCall(PetscMemzero(space, sizeof(*space)));
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

/* The boxes of nodes that points touch, dim values a point; and the keys of the points' order. */
typedef struct {
  PetscInt  *first, *count;
  PetscInt  *cell_key, *shape_key;
  PetscInt64 cells, shapes; /* keys are below them */
} Boxes;

/*
  Two keys a point. The first is by the first node or, with a mean, by the cell of its centre, part after part, since
  the first node follows from the cell and a place of `width` beside it. The second is by the shape of the box; with
  more than one shape also by the place of the nodes touched with the scene's shape.
*/
MPM_INLINE PetscErrorCode MakeKeys(const PetscInt dim, const MpmSpace *space, const MpmRules *rules,
                                   const MpmPoints *points, Boxes *boxes)
{
  const PetscInt  n = space->point_count, width = space->width;
  const PetscBool many               = (PetscBool)(space->shapes.count > 1);
  const PetscBool cells              = (PetscBool)(rules->means == MPM_MEANS_CELL);
  const PetscInt *part               = space->parts.stride ? points->domain.part : NULL;
  PetscInt        lower[MPM_MAX_DIM] = {PETSC_INT_MAX, PETSC_INT_MAX, PETSC_INT_MAX}, upper[MPM_MAX_DIM] = {0, 0, 0};

  PetscFunctionBeginUser;
  boxes->cells  = space->parts.count;
  boxes->shapes = 1;
  for (PetscInt p = 0; p < n; p++) {
    for (PetscInt a = 0; a < dim; a++) {
      lower[a] = PetscMin(lower[a], boxes->first[p * dim + a]);
      upper[a] = PetscMax(upper[a], boxes->first[p * dim + a]);
    }
  }
  for (PetscInt a = 0; n && a < dim; a++) {
    upper[a] += cells ? width : 0;
    boxes->cells *= upper[a] - lower[a] + 1;
    boxes->shapes *= width * (cells ? width : 1) * (many ? width * width : 1);
  }
  PetscCheck(boxes->cells < PETSC_INT_MAX && boxes->shapes < PETSC_INT_MAX, PETSC_COMM_SELF, PETSC_ERR_ARG_OUTOFRANGE,
             "the points of one rank span %" PetscInt64_FMT " cells", boxes->cells);
  for (PetscInt p = 0; p < n; p++) {
    PetscInt home[MPM_MAX_DIM], cell = part ? part[p] : 0, shape = 0;

    if (cells) MpmGridFindCell(rules->grid, &points->x[p * dim], home);
    for (PetscInt a = dim - 1; a >= 0; a--) {
      const PetscInt k = p * dim + a, first = boxes->first[k];
      const PetscInt place = cells ? home[a] * rules->grid->order : first;

      cell  = cell * (upper[a] - lower[a] + 1) + place - lower[a];
      shape = shape * width + boxes->count[k] - 1;
      if (cells) shape = shape * width + place - first;
      if (many) shape = (shape * width + space->touched.first[k] - first) * width + space->touched.count[k] - 1;
    }
    boxes->cell_key[p]  = cell;
    boxes->shape_key[p] = shape;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Orders the points by their keys and marks off the groups; with a mean the points of a cell stand side by side. */
static PetscErrorCode MakeGroups(MpmSpace *space, const MpmRules *rules, const MpmPoints *points, Boxes *boxes)
{
  const PetscInt n = space->point_count, dim = space->dim;
  PetscInt      *order, groups               = 0;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(n, &boxes->cell_key, n, &boxes->shape_key, n, &order));
  PetscCall(PetscMalloc1(n, &space->order));
  PetscCall(MPM_BY_DIM(dim, MakeKeys, space, rules, points, boxes));
  PetscCall(CountingSort(n, boxes->shape_key, boxes->shapes, NULL, order));
  PetscCall(CountingSort(n, boxes->cell_key, boxes->cells, order, space->order));
#define SAME(key, i) (boxes->key[space->order[i]] == boxes->key[space->order[(i)-1]])
#define NEW_GROUP(i) (!(i) || !SAME(cell_key, i) || !SAME(shape_key, i))
  for (PetscInt i = 0; i < n; i++) groups += NEW_GROUP(i);
  PetscCall(PetscCalloc1(groups, &space->groups));
  space->group_count = groups;
  for (PetscInt i = 0, g = -1, cell = -1; i < n; i++) {
    if (NEW_GROUP(i)) {
      MpmGroup *group = &space->groups[++g];

      group->node_count = 1;
      for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
        group->first[a] = a < dim ? boxes->first[space->order[i] * dim + a] : 0;
        group->count[a] = a < dim ? boxes->count[space->order[i] * dim + a] : 1;
        group->node_count *= group->count[a];
      }
      group->part = space->parts.stride ? points->domain.part[space->order[i]] : 0;
      group->first[dim - 1] += space->parts.stride * group->part;
      group->point_begin = i;
      group->cell        = cell += !i || !SAME(cell_key, i);
    }
    space->groups[g].point_end = i + 1;
  }
#undef NEW_GROUP
#undef SAME
  PetscCall(PetscFree3(boxes->cell_key, boxes->shape_key, order));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Where each box's nodes will stand, and how far a box reaches. */
static PetscErrorCode FinishBoxes(MpmSpace *space, MPI_Comm comm)
{
  PetscInt offset = 0;

  PetscFunctionBeginUser;
  space->boxes.reach = PetscMax(space->width - 1, 1);
  for (PetscInt g = 0; g < space->boxes.count; g++) {
    MpmGroup *box = &space->groups[g];

    for (PetscInt a = 0; a < space->dim; a++) space->boxes.reach = PetscMax(space->boxes.reach, box->count[a] - 1);
    box->node_offset = offset;
    offset += box->node_count;
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &space->boxes.reach, 1, MPIU_INT, MPI_MAX, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceAppendBoxes(MpmSpace *space, PetscInt count, MpmGroup **boxes)
{
  MpmGroup *groups;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1((space->boxes.count + count), &groups));
  PetscCall(PetscArraycpy(groups, space->groups, space->boxes.count));
  PetscCall(PetscFree(space->groups));
  space->groups = groups;
  *boxes        = &groups[space->boxes.count];
  space->boxes.count += count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceAppendNodes(MpmSpace *space, PetscInt count, const PetscInt free[], PetscInt *first)
{
  MpmExtraNodes *extra = &space->extra;

  PetscFunctionBeginUser;
  *first = extra->count;
  PetscCall(PetscRealloc((size_t)(extra->count + count) * sizeof(*free), &extra->free));
  PetscCall(PetscArraycpy(&extra->free[extra->count], free, count));
  extra->count += count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceCouple(MpmSpace *space, PetscInt one, PetscInt other)
{
  PetscFunctionBeginUser;
  if (space->parts.couple_count == space->parts.couple_capacity) {
    space->parts.couple_capacity = 2 * space->parts.couple_capacity + 64;
    PetscCall(PetscRealloc((size_t)space->parts.couple_capacity * sizeof(MpmCouple), &space->parts.couple));
  }
  space->parts.couple[space->parts.couple_count++] = (MpmCouple){{one, other}};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceLink(MpmSpace *space, PetscInt box, PetscInt first, PetscInt count)
{
  MpmExtraNodes *extra = &space->extra;

  PetscFunctionBeginUser;
  if (extra->link_count == extra->link_capacity) {
    extra->link_capacity = 2 * extra->link_capacity + 64;
    PetscCall(PetscRealloc((size_t)extra->link_capacity * sizeof(MpmLink), &extra->link));
  }
  extra->link[extra->link_count++] = (MpmLink){box, first, count};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceBegin(MpmSpace *space, const MpmRules *rules, const MpmPoints *points, MpmOutcome *outcome)
{
  Boxes boxes = {0};

  PetscFunctionBeginUser;
  MpmOutcomeClear(outcome);
  PetscCall(MpmSpaceReset(space));
  PetscCall(MpmSpaceEvaluateShapes(space, rules, points, &boxes.first, &boxes.count, outcome));
  if (outcome->code) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MakeGroups(space, rules, points, &boxes));
  if (boxes.first != space->touched.first) PetscCall(PetscFree2(boxes.first, boxes.count));
  space->boxes.count = space->group_count;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Moves a point's shapes to another point's place. */
static PetscErrorCode MoveWeights(MpmSpace *space, PetscInt from, PetscInt to)
{
  const PetscInt size = space->dim * space->width;

  PetscFunctionBeginUser;
  PetscCall(
    PetscArraymove(&space->touched.first[to * space->dim], &space->touched.first[from * space->dim], space->dim));
  PetscCall(
    PetscArraymove(&space->touched.count[to * space->dim], &space->touched.count[from * space->dim], space->dim));
  if (space->shapes.at[0].hoop) space->shapes.at[0].hoop[to] = space->shapes.at[0].hoop[from];
  for (PetscInt k = 0; k < space->shapes.count; k++) {
    PetscReal *const of[] = {space->shapes.at[k].weight, space->shapes.at[k].gradient};

    for (size_t i = 0; i < PETSC_STATIC_ARRAY_LENGTH(of); i++)
      PetscCall(PetscArraymove(&of[i][to * size], &of[i][from * size], size));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceRemovePoints(MpmSpace *space, PetscInt count, const PetscInt removed[])
{
  PetscInt *was, *now, kept = 0; /* whose place it was; where a point stands now, -1: nowhere */

  PetscFunctionBeginUser;
  if (!count) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc2(space->point_count, &was, space->point_count, &now));
  for (PetscInt p = 0; p < space->point_count; p++) was[p] = now[p] = p;
  for (PetscInt k = count - 1; k >= 0; k--) {
    const PetscInt last = --space->point_count, p = removed[k];

    PetscCall(MoveWeights(space, last, p));
    now[was[last]] = p;
    now[p]         = -1; /* none has come to its place before */
    was[p]         = was[last];
  }
  for (PetscInt g = 0; g < space->group_count; g++) {
    const PetscInt begin = kept;

    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++)
      if (now[space->order[s]] >= 0) space->order[kept++] = now[space->order[s]];
    space->groups[g].point_begin = begin;
    space->groups[g].point_end   = kept;
  }
  PetscCall(PetscFree2(was, now));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds a bit's worth to the nodes that a point touches with a shape. */
static void MarkTouched(const MpmSpace *space, const MpmGroup *group, PetscInt shape, PetscInt p, PetscReal touched[])
{
  const PetscInt    W = space->width, dim = space->dim, *count = group->count;
  const MpmWeights *values = &space->shapes.at[shape];

  for (PetscInt i = 0; i < group->node_count; i++) {
    const PetscInt at[MPM_MAX_DIM] = {i % count[0], i / count[0] % count[1], i / (count[0] * count[1])};
    PetscBool      touches         = PETSC_TRUE;

    for (PetscInt a = 0; a < dim; a++) {
      const PetscInt k = (p * dim + a) * W + at[a];

      if (values->weight[k] == 0. && values->gradient[k] == 0.) touches = PETSC_FALSE;
    }
    if (touches) touched[space->group_nodes[group->node_offset + i] * space->shapes.count + shape] = 1.;
  }
}

/* With more shapes than one: which of them reach each local node, from the points of any rank. */
static PetscErrorCode FindSupport(MpmSpace *space, const MpmRules *rules)
{
  const MpmLayout *layout = rules->layout;
  PetscReal       *touched;

  PetscFunctionBeginUser;
  space->number.unknowns = (space->number.count - space->extra.count) * layout->block;
  if (space->shapes.count == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscCalloc1((space->local * space->shapes.count), &touched));
  for (PetscInt g = 0; g < space->group_count; g++)
    for (PetscInt i = space->groups[g].point_begin; i < space->groups[g].point_end; i++)
      for (PetscInt s = 0; s < space->shapes.count; s++)
        MarkTouched(space, &space->groups[g], s, space->order[i], touched);
  PetscCall(MpmSpaceAddToOwners(space, space->shapes.count, touched));
  PetscCall(MpmSpaceToGhosts(space, space->shapes.count, touched));
  PetscCall(PetscCalloc1(space->local, &space->shapes.support));
  for (PetscInt k = 0; k < space->local * space->shapes.count; k++)
    if (touched[k] > 0.) space->shapes.support[k / space->shapes.count] |= 1 << k % space->shapes.count;
  PetscCall(PetscFree(touched));
  space->number.unknowns = 0;
  for (PetscInt k = 0; k < space->owned * layout->block; k++)
    space->number.unknowns +=
      space->shapes.support[k / layout->block] >> layout->component[k % layout->block].shape & 1;
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &space->number.unknowns, 1, MPIU_INT, MPI_SUM, rules->grid->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpaceEnd(MpmSpace *space, const MpmRules *rules)
{
  PetscFunctionBeginUser;
  PetscCall(FinishBoxes(space, rules->grid->comm));
  PetscCall(MpmSpaceNumberNodes(space, rules->grid));
  PetscCall(FindSupport(space, rules));
  for (PetscInt k = 0; k < space->extra.count; k++)
    for (PetscInt c = 0; c < rules->layout->block; c++) space->number.unknowns += space->extra.free[k] >> c & 1;
  PetscFunctionReturn(PETSC_SUCCESS);
}
