/*
  Set-up of the sum-factorised action: points in batches, their values along the axes, and their tangents.

  Groups with many points fill stacks of their own. Points of small groups, and the last ones of the others, stand side
  by side with those of groups of the same size: every lane but those of a few last batches has a point.
*/
#include "action/factored_impl.h"
#include "point/layout.h"

/* A group's last points take a batch of their own from this many on; fewer go with those of other groups. */
#define OWN (MPM_LANES / 2)
/* Nodes an axis, as a key: sizes up to MPM_MAX_WIDTH */
#define SIDE (MPM_MAX_WIDTH + 1)
#define KEYS (SIDE * SIDE * SIDE)

/* True where the inputs are one value, or one derivative along each axis, of each component. */
static PetscBool TakesValues(const MpmLayout *layout)
{
  return (PetscBool)(layout->input.count == layout->block && !layout->input.basis[0]);
}
static PetscBool TakesGradients(const MpmLayout *layout)
{
  return (PetscBool)(layout->input.count == layout->block * layout->dim && layout->input.basis[0] == 1);
}

PetscBool MpmFactoredServes(const MpmSum *sum)
{
  const MpmLayout *layout = sum->layout;

  return (PetscBool)((layout->block == 1 || layout->block == layout->dim) && layout->field_count == 1 &&
                     !layout->component[0].negative && (TakesValues(layout) || TakesGradients(layout)) &&
                     layout->kinematics != MPM_AXISYMMETRY && !layout->means && sum->space->shapes.count == 1 &&
                     !sum->space->shapes.at[0].cross);
}

/* Points of a group in batches of their own. */
static PetscInt OwnPoints(const MpmGroup *group)
{
  const PetscInt count = group->point_end - group->point_begin, rest = count % MPM_LANES;

  return rest >= OWN && count > MPM_LANES ? count : count - rest;
}

static PetscInt KeyOf(const PetscInt count[])
{
  return (count[2] * SIDE + count[1]) * SIDE + count[0];
}

static PetscInt BatchesOf(PetscInt points)
{
  return (points + MPM_LANES - 1) / MPM_LANES;
}

/* Numbers of stacks and batches; rest[key]: points of groups of a size that are in none of their own. */
static void Count(const MpmSpace *space, MpmFactored *factored, PetscInt rest[])
{
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const PetscInt  own   = OwnPoints(group);

    factored->stack_count += own > 0;
    factored->batch_count += BatchesOf(own);
    rest[KeyOf(group->count)] += group->point_end - group->point_begin - own;
  }
  for (PetscInt key = 0; key < KEYS; key++) {
    factored->stack_count += rest[key] > 0;
    factored->batch_count += BatchesOf(rest[key]);
  }
}

/* Appends a stack; `batch`, `lines`: the next free ones. */
static void Append(MpmFactored *factored, const PetscInt count[], PetscInt batches, PetscInt *stack, PetscInt *batch,
                   size_t *lines)
{
  MpmStack *to = &factored->stack[(*stack)++];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) to->count[a] = count[a];
  to->begin = *batch;
  to->end   = *batch += batches;
  to->lines = *lines;
  for (PetscInt a = 0; a < MPM_MAX_DIM && a < factored->sum->space->dim; a++)
    *lines += (size_t)(2 * batches * count[a]);
}

/* Points to lanes: those of small groups first, by size. rest[key] becomes the next free lane of that size. */
static void Place(const MpmSpace *space, MpmFactored *factored, PetscInt rest[])
{
  PetscInt stack = 0, batch = 0;
  size_t   lines = 0;

  for (PetscInt key = 0; key < KEYS; key++) {
    const PetscInt count[MPM_MAX_DIM] = {key % SIDE, key / SIDE % SIDE, key / (SIDE * SIDE)}, points = rest[key];

    rest[key] = batch * MPM_LANES;
    if (points) Append(factored, count, BatchesOf(points), &stack, &batch, &lines);
  }
  for (PetscInt k = 0; k < factored->batch_count * MPM_LANES; k++) factored->group[k] = -1;
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const PetscInt  own   = OwnPoints(group);
    PetscInt        lane  = batch * MPM_LANES;

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      PetscInt *next = s - group->point_begin < own ? &lane : &rest[KeyOf(group->count)];

      factored->place[s]     = *next;
      factored->group[*next] = g;
      (*next)++;
    }
    if (!own) continue;
    Append(factored, group->count, BatchesOf(own), &stack, &batch, &lines);
    factored->stack[stack - 1].shared = PETSC_TRUE;
  }
}

/* Values along the axes of the points of one stack; lanes without a point keep zeros. */
static void FillLines(MpmFactored *factored, const MpmStack *stack, const PetscInt point[])
{
  const MpmSpace   *space = factored->sum->space;
  const MpmWeights *of    = &space->shapes.at[0];
  Lane             *to    = &factored->lines[stack->lines];

  for (PetscInt batch = stack->begin; batch < stack->end; batch++) {
    for (PetscInt a = 0; a < space->dim; to += 2 * stack->count[a++]) {
      for (PetscInt lane = 0; lane < MPM_LANES; lane++) {
        const PetscInt p = point[batch * MPM_LANES + lane], from = (p * space->dim + a) * space->width;

        for (PetscInt k = 0; p >= 0 && k < stack->count[a]; k++) {
          to[k][lane]                   = of->weight[from + k];
          to[stack->count[a] + k][lane] = of->gradient[from + k];
        }
      }
    }
  }
}

/* Vectors on lines of the cache, with zeros. */
static PetscErrorCode AllocateLanes(MpmFactored *factored, size_t count, void *lanes)
{
  const size_t bytes = PetscMax(count, 1) * sizeof(Lane);
  void        *made  = aligned_alloc(sizeof(Lane), bytes);

  PetscFunctionBeginUser;
  PetscCheck(made, PETSC_COMM_SELF, PETSC_ERR_MEM, "no %zu bytes for the tangents of the points", bytes);
  memset(made, 0, bytes);
  *(void **)lanes = made;
  factored->bytes += bytes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode FillAllLines(MpmFactored *factored)
{
  const MpmSpace *space = factored->sum->space;
  size_t          count = 0;
  PetscInt       *point;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < factored->stack_count; k++) {
    const MpmStack *stack = &factored->stack[k];

    for (PetscInt a = 0; a < space->dim; a++) count += (size_t)(2 * (stack->end - stack->begin) * stack->count[a]);
  }
  PetscCall(AllocateLanes(factored, count, &factored->lines));
  PetscCall(PetscMalloc1((factored->batch_count * MPM_LANES), &point));
  for (PetscInt k = 0; k < factored->batch_count * MPM_LANES; k++) point[k] = -1;
  for (PetscInt s = 0; s < space->point_count; s++) point[factored->place[s]] = space->order[s];
  for (PetscInt k = 0; k < factored->stack_count; k++) FillLines(factored, &factored->stack[k], point);
  PetscCall(PetscFree(point));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFactoredCreate(const MpmSum *sum, PetscBool half, PetscBool single, MpmFactored **factored)
{
  const MpmSpace *space = sum->space;
  const PetscInt  N = sum->layout->input.count, bs = sum->block;
  PetscInt       *rest, most                       = 1;
  MpmFactored    *made;

  PetscFunctionBeginUser;
  PetscCall(PetscNew(&made));
  made->sum      = sum;
  made->half     = half;
  made->single   = single;
  made->gradient = TakesGradients(sum->layout);
  made->block    = bs;
  made->inputs   = N;
  made->size     = half ? N * (N + 1) / 2 : N * N;
  PetscCall(PetscCalloc1(KEYS, &rest));
  Count(space, made, rest);
  PetscCall(PetscCalloc1(made->stack_count, &made->stack));
  PetscCall(PetscMalloc1((made->batch_count * MPM_LANES), &made->group));
  PetscCall(PetscMalloc1(space->point_count, &made->place));
  Place(space, made, rest);
  PetscCall(PetscFree(rest));
  PetscCall(FillAllLines(made));
  PetscCall(
    AllocateLanes(made, ((size_t)made->batch_count * (size_t)made->size + single) / (single ? 2 : 1), &made->tangent));
  for (PetscInt k = 0; k < made->stack_count; k++) {
    const PetscInt *count = made->stack[k].count;

    most = PetscMax(most, count[0] * count[1] * count[2]);
  }
  PetscCall(AllocateLanes(made, (size_t)(most * (bs + bs * bs) + MPM_LANES), &made->work));
  made->bytes += (size_t)(made->batch_count * MPM_LANES + space->point_count) * sizeof(PetscInt);
  *factored = made;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmFactoredDestroy(MpmFactored **factored)
{
  PetscFunctionBeginUser;
  if (!*factored) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscFree((*factored)->stack));
  PetscCall(PetscFree((*factored)->group));
  PetscCall(PetscFree((*factored)->place));
  free((*factored)->lines);
  free((*factored)->tangent);
  free((*factored)->work);
  PetscCall(PetscFree(*factored));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Share of the largest entry by which the triangles of a symmetric tangent may differ: rounding. */
#define ASYMMETRY 1e-13

/* Number k of all lanes. */
static void Keep(MpmFactored *factored, PetscInt k, PetscReal value)
{
  if (factored->single) ((float *)factored->tangent)[k] = (float)value;
  else ((PetscReal *)factored->tangent)[k] = value;
}

PetscBool MpmFactoredSetTangent(MpmFactored *factored, PetscInt s, const PetscReal D[])
{
  const PetscInt N = factored->inputs, at = factored->place[s];
  const PetscInt first   = at / MPM_LANES * factored->size * MPM_LANES + at % MPM_LANES;
  PetscReal      largest = 0., difference = 0.;
  PetscInt       m = 0;

  if (!factored->half) {
    for (; m < N * N; m++) Keep(factored, first + m * MPM_LANES, D[m]);
    return PETSC_TRUE;
  }
  for (PetscInt k = 0; k < N; k++) {
    for (PetscInt l = k; l < N; l++, m++) {
      Keep(factored, first + m * MPM_LANES, 0.5 * (D[k * N + l] + D[l * N + k]));
      largest    = PetscMax(largest, PetscAbsReal(D[k * N + l]));
      difference = PetscMax(difference, PetscAbsReal(D[k * N + l] - D[l * N + k]));
    }
  }
  return (PetscBool)(difference <= ASYMMETRY * largest);
}

size_t MpmFactoredBytes(const MpmFactored *factored)
{
  return factored->bytes;
}
