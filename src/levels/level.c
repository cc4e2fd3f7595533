/*
  A level's nodes from those of the next finer one: every fine node names the coarse ones that its value comes from
  (two_scale.h), the owners number them, and the answers make the interpolation. Arrays are as large as the lattice
  around a rank's nodes. A coarse node belongs to the rank that owns its place on the grid.
*/
#include "grid/grid.h"
#include "space/space.h"
#include "bc/bc.h"
#include "levels/level_impl.h"

PetscErrorCode MpmLevelDestroy(MpmLevel *level)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(level->at));
  PetscCall(PetscFree2(level->free, level->held));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmLevelOfSpace(const MpmSpace *space, const MpmConstraints *constraints, const MpmGrid *grid,
                               MpmLevel *level)
{
  const PetscInt bs = constraints->block;

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(level, sizeof(*level)));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    level->ratio[a] = 1;
    level->last[a]  = grid->nodes[a] - 1;
  }
  level->order = grid->order;
  level->local = space->local;
  level->owned = space->owned;
  level->begin = space->number.begin;
  level->count = space->number.count;
  PetscCall(PetscMalloc1((space->local * NUMBERS), &level->at));
  PetscCall(PetscCalloc2(space->local, &level->free, space->local, &level->held));
  for (PetscInt i = 0; i < space->local; i++) {
    const PetscInt *node = &space->node[i * space->dim];

    MpmSpaceAt(space, node, &level->at[i * NUMBERS]);
    level->at[i * NUMBERS + MPM_MAX_DIM] = MpmSpaceIsExtra(space, i) ? NOWHERE : MpmSpacePart(space, node);
    for (PetscInt c = 0; c < bs; c++) {
      const PetscInt condition = constraints->condition[i * bs + c];

      if (condition == MPM_FREE) level->free[i] |= 1 << c;
      if (condition >= 0 || condition == MPM_HELD) level->held[i] |= 1 << c;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- maps ---- */

static void MapClear(Map *map)
{
  for (PetscInt a = 0; a < NUMBERS; a++) {
    map->lower[a] = PETSC_INT_MAX;
    map->size[a]  = 0;
  }
}

/* Widens a map that has no values yet. */
static void MapInclude(Map *map, const PetscInt at[])
{
  for (PetscInt a = 0; a < NUMBERS; a++) {
    const PetscInt end = map->size[a] ? PetscMax(map->lower[a] + map->size[a], at[a] + 1) : at[a] + 1;

    map->lower[a] = PetscMin(map->lower[a], at[a]);
    map->size[a]  = end - map->lower[a];
  }
}

static PetscInt MapSize(const Map *map)
{
  return map->size[0] * map->size[1] * map->size[2] * map->size[3];
}

/* The node of a place in the map's array. */
static void MapNode(const Map *map, PetscInt place, PetscInt at[])
{
  for (PetscInt a = 0; a < NUMBERS; a++) {
    at[a] = map->lower[a] + place % map->size[a];
    place /= map->size[a];
  }
}

/* ---- relations ---- */

/* The relation of axis a at fine node i; entry k of the axis. */
static void FillAxis(const Coarsening *to, PetscInt a, PetscInt i, PetscInt k)
{
  const MpmLevel *fine = to->fine, *coarse = to->coarse;
  const Axis     *axis   = &to->axis[a];
  PetscReal      *weight = &axis->weight[k * MPM_TWO_SCALE_MOST];

  axis->first[k] = axis->same[k] = i;
  axis->count[k]                 = 1;
  weight[0]                      = 1.;
  if (fine->last[a] == coarse->last[a]) return;
  if (fine->order > 1) {
    const MpmElementScale relation = {fine->order, coarse->order, to->step[a], fine->last[a] / fine->order};

    axis->count[k] = MpmElementScaleRow(&relation, i, &axis->first[k], weight);
    axis->same[k]  = axis->count[k] == 1 ? axis->first[k] : -1;
  } else {
    const MpmTwoScale relation = {to->rules->degree, to->step[a], to->rules->edge, fine->last[a], coarse->last[a]};

    axis->count[k] = MpmTwoScaleRow(&relation, i, &axis->first[k], weight);
    axis->same[k]  = i % to->step[a] ? -1 : i / to->step[a];
  }
}

/* Relations of the axes, at the indices of this rank's nodes. */
static PetscErrorCode MakeAxes(Coarsening *to)
{
  const MpmLevel *fine = to->fine;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    Axis    *axis = &to->axis[a];
    PetscInt end  = 0;

    axis->lower = fine->last[a] + 1;
    for (PetscInt i = 0; i < fine->local; i++) {
      if (!HasPlace(fine, i)) continue;
      axis->lower = PetscMin(axis->lower, fine->at[i * NUMBERS + a]);
      end         = PetscMax(end, fine->at[i * NUMBERS + a] + 1);
    }
    axis->lower = PetscMin(axis->lower, end);
    PetscCall(PetscMalloc4((end - axis->lower), &axis->first, (end - axis->lower), &axis->count, (end - axis->lower),
                           &axis->same, ((end - axis->lower) * MPM_TWO_SCALE_MOST), &axis->weight));
    for (PetscInt k = 0; k < end - axis->lower; k++) FillAxis(to, a, axis->lower + k, k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bits of the coarse nodes that this rank's nodes name: what is solved for at any of these, in components by axes. */
static PetscErrorCode NameNodes(Coarsening *to, const MpmConstraints *constraints)
{
  PetscInt at[NUMBERS];

  PetscFunctionBeginUser;
  MapClear(&to->named);
  for (PetscInt i = 0; i < to->fine->local; i++) {
    if (!HasPlace(to->fine, i)) continue;
    const Parents of = ParentsOf(to, i);

    MapInclude(&to->named, of.first);
    (void)ParentAt(&of, of.total - 1, at);
    MapInclude(&to->named, at);
  }
  PetscCall(PetscCalloc1(MapSize(&to->named), &to->named.value));
  for (PetscInt i = 0; i < to->fine->local; i++) {
    if (!HasPlace(to->fine, i)) continue;
    const Parents of   = ParentsOf(to, i);
    PetscInt      bits = to->fine->free[i] | PRESENT;

    if (constraints && MpmConstraintsFrame(constraints, i) && bits > PRESENT) bits |= (1 << HELD) - 1;
    for (PetscInt k = 0; k < of.total; k++) {
      (void)ParentAt(&of, k, at);
      *MapAt(&to->named, at) |= bits;
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- numbers ---- */

static PetscMPIInt OwnerOf(const Coarsening *to, const PetscInt at[])
{
  const MpmLevel *coarse = to->coarse;
  PetscInt        cell[MPM_MAX_DIM];

  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) cell[a] = at[a] * coarse->ratio[a] / coarse->order;
  return MpmGridCellOwner(to->rules->grid, cell);
}

#define ASKED (NUMBERS + 1) /* numbers of a question: node and bits */

/* The named nodes of other ranks. */
static PetscErrorCode ListForeign(const Coarsening *to, MpmLists *lists)
{
  const MpmGrid *grid = to->rules->grid;
  const PetscInt size = MapSize(&to->named);
  PetscInt      *slot, *fill, at[NUMBERS];

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc1(grid->size, &slot));
  for (PetscInt place = 0; place < size && grid->size > 1; place++) {
    MapNode(&to->named, place, at);
    if (to->named.value[place]) slot[OwnerOf(to, at)]++;
  }
  slot[grid->rank] = 0;
  for (PetscMPIInt r = 0; r < grid->size; r++) lists->count += slot[r] > 0;
  PetscCall(PetscMalloc1(lists->count, &lists->rank));
  PetscCall(PetscMalloc1((lists->count + 1), &lists->offset));
  PetscCall(PetscMalloc1(lists->count, &fill));
  lists->offset[0] = 0;
  for (PetscMPIInt r = 0, k = 0; r < grid->size; r++) {
    const PetscInt wanted = slot[r];

    slot[r] = wanted ? k : -1;
    if (!wanted) continue;
    lists->rank[k]       = r;
    lists->offset[k + 1] = lists->offset[k] + wanted * ASKED;
    fill[k]              = lists->offset[k];
    k++;
  }
  PetscCall(PetscMalloc1(lists->offset[lists->count], &lists->data));
  for (PetscInt place = 0; place < size && lists->count; place++) {
    PetscInt k;

    MapNode(&to->named, place, at);
    if (!to->named.value[place] || (k = slot[OwnerOf(to, at)]) < 0) continue;
    for (PetscInt a = 0; a < NUMBERS; a++) lists->data[fill[k]++] = at[a];
    lists->data[fill[k]++] = to->named.value[place];
  }
  PetscCall(PetscFree(fill));
  PetscCall(PetscFree(slot));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Bits of the own nodes, named by any rank. */
static PetscErrorCode CollectOwn(Coarsening *to, const MpmLists *wanted)
{
  const PetscInt size = MapSize(&to->named), end = wanted->offset[wanted->count];
  PetscInt       at[NUMBERS];

  PetscFunctionBeginUser;
  MapClear(&to->own);
  for (PetscInt pass = 0; pass < 2; pass++) {
    if (pass) PetscCall(PetscCalloc1(MapSize(&to->own), &to->own.value));
    for (PetscInt place = 0; place < size; place++) {
      MapNode(&to->named, place, at);
      if (!to->named.value[place] || OwnerOf(to, at) != to->rules->grid->rank) continue;
      if (pass) *MapAt(&to->own, at) |= to->named.value[place];
      else MapInclude(&to->own, at);
    }
    for (PetscInt k = 0; k < end; k += ASKED) {
      if (pass) *MapAt(&to->own, &wanted->data[k]) |= wanted->data[k + NUMBERS];
      else MapInclude(&to->own, &wanted->data[k]);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* An unknown that is prescribed at a fine node is prescribed at the coarse node in its place. */
static void HoldCoarse(const Coarsening *to, const MpmConstraints *constraints)
{
  for (PetscInt i = 0; i < to->fine->owned; i++) {
    PetscInt  at[NUMBERS], held = to->fine->held[i];
    PetscBool coarse = HasPlace(to->fine, i);

    for (PetscInt a = 0; a < MPM_MAX_DIM && coarse; a++) {
      at[a] = to->axis[a].same[to->fine->at[i * NUMBERS + a] - to->axis[a].lower];
      if (at[a] < 0) coarse = PETSC_FALSE;
    }
    at[MPM_MAX_DIM] = to->fine->at[i * NUMBERS + MPM_MAX_DIM];
    if (constraints && MpmConstraintsFrame(constraints, i) && to->fine->free[i]) held = 0;
    if (coarse) *MapAt(&to->own, at) |= held << HELD;
  }
}

/* The coarse level's own nodes; their numbers, counted from one, replace their bits. */
static PetscErrorCode NumberOwn(Coarsening *to)
{
  const MpmLevelRules *rules  = to->rules;
  MpmLevel            *coarse = to->coarse;
  const PetscInt       size   = MapSize(&to->own);
  const PetscBool      last   = (PetscBool)(rules->grid->rank == rules->grid->size - 1);
  PetscInt             node = 0, extra = last ? rules->extra : 0;

  PetscFunctionBeginUser;
  for (PetscInt place = 0; place < size; place++) node += to->own.value[place] != 0;
  coarse->owned = coarse->local = node + extra;
  PetscCallMPI(MPI_Scan(&coarse->owned, &coarse->begin, 1, MPIU_INT, MPI_SUM, rules->comm));
  coarse->begin -= coarse->owned;
  PetscCall(MPIU_Allreduce(&coarse->owned, &coarse->count, 1, MPIU_INT, MPI_SUM, rules->comm));
  PetscCall(PetscCalloc1((coarse->owned * NUMBERS), &coarse->at));
  PetscCall(PetscCalloc2(coarse->owned, &coarse->free, coarse->owned, &coarse->held));
  node = 0;
  for (PetscInt place = 0; place < size; place++) {
    if (!to->own.value[place]) continue;
    MapNode(&to->own, place, &coarse->at[node * NUMBERS]);
    coarse->held[node]   = to->own.value[place] >> HELD & ((1 << HELD) - 1);
    coarse->free[node]   = to->own.value[place] & ((1 << HELD) - 1) & ~coarse->held[node];
    to->own.value[place] = 1 + coarse->begin + node++;
  }
  for (PetscInt k = 0; k < extra; k++) {
    coarse->free[node + k]                         = to->fine->free[to->fine->owned - extra + k];
    coarse->at[(node + k) * NUMBERS + MPM_MAX_DIM] = NOWHERE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Numbers of the named nodes, counted from one. */
static PetscErrorCode NumberNamed(Coarsening *to, const MpmLists *foreign, const MpmLists *wanted)
{
  const PetscInt size   = MapSize(&to->named);
  MpmLists       answer = {.count = wanted->count}, numbers = {0};
  PetscInt       at[NUMBERS];

  PetscFunctionBeginUser;
  for (PetscInt place = 0; place < size; place++) {
    MapNode(&to->named, place, at);
    if (to->named.value[place] && OwnerOf(to, at) == to->rules->grid->rank)
      to->named.value[place] = *MapAt(&to->own, at);
  }
  if (to->rules->grid->size == 1) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscMalloc1(wanted->count, &answer.rank));
  PetscCall(PetscMalloc1((wanted->count + 1), &answer.offset));
  PetscCall(PetscMalloc1(wanted->offset[wanted->count] / ASKED, &answer.data));
  for (PetscInt k = 0; k <= wanted->count; k++) answer.offset[k] = wanted->offset[k] / ASKED;
  PetscCall(PetscArraycpy(answer.rank, wanted->rank, wanted->count));
  for (PetscInt k = 0; k < answer.offset[wanted->count]; k++)
    answer.data[k] = *MapAt(&to->own, &wanted->data[k * ASKED]);
  PetscCall(MpmListsExchange(to->rules->comm, &answer, &numbers));
  for (PetscInt k = 0; k < foreign->count; k++) {
    PetscInt from = 0;

    while (numbers.rank[from] != foreign->rank[k]) from++;
    for (PetscInt i = 0; i < (foreign->offset[k + 1] - foreign->offset[k]) / ASKED; i++)
      *MapAt(&to->named, &foreign->data[foreign->offset[k] + i * ASKED]) = numbers.data[numbers.offset[from] + i];
  }
  PetscCall(MpmListsDestroy(&answer));
  PetscCall(MpmListsDestroy(&numbers));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NumberNodes(Coarsening *to, const MpmConstraints *constraints)
{
  MpmLists foreign = {0}, wanted = {0};

  PetscFunctionBeginUser;
  PetscCall(ListForeign(to, &foreign));
  if (to->rules->grid->size > 1) PetscCall(MpmListsExchange(to->rules->comm, &foreign, &wanted));
  else PetscCall(PetscCalloc1(1, &wanted.offset));
  PetscCall(CollectOwn(to, &wanted));
  HoldCoarse(to, constraints);
  PetscCall(NumberOwn(to));
  PetscCall(NumberNamed(to, &foreign, &wanted));
  PetscCall(MpmListsDestroy(&foreign));
  PetscCall(MpmListsDestroy(&wanted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- the whole ---- */

PetscErrorCode MpmLevelCoarsen(const MpmLevelRules *rules, const MpmLevel *fine, const MpmFinest *finest,
                               PetscInt order, MpmLevel *coarse, Mat *interpolation)
{
  const MpmConstraints *constraints = finest ? finest->constraints : NULL;
  Coarsening            to          = {.rules = rules, .fine = fine, .coarse = coarse};

  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(coarse, sizeof(*coarse)));
  coarse->order = order;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    const PetscInt cells = fine->last[a] / fine->order;

    to.step[a]       = cells > 1 && order == fine->order ? rules->coarsen : 1;
    coarse->ratio[a] = fine->ratio[a] * to.step[a];
    coarse->last[a]  = (cells + to.step[a] - 1) / to.step[a] * order;
  }
  PetscCall(MakeAxes(&to));
  PetscCall(NameNodes(&to, constraints));
  PetscCall(NumberNodes(&to, constraints));
  PetscCall(MpmMakeInterpolation(&to, constraints, interpolation));
  if (finest && finest->rows) PetscCall(MpmMakeLocalRows(&to, finest));
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++)
    PetscCall(PetscFree4(to.axis[a].first, to.axis[a].count, to.axis[a].same, to.axis[a].weight));
  PetscCall(PetscFree(to.named.value));
  PetscCall(PetscFree(to.own.value));
  PetscFunctionReturn(PETSC_SUCCESS);
}
