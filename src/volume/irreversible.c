/*
  Irreversibility of a field with a rate, as damage, by bounds at the nodes: with d_i the unknown of node i and d_i,n
  its value at the step's start,

    d_i >= d_i,n ,   by the energy  1/2 k_i <d_i,n - d_i>^2 ,   <x> = max(x, 0)

  with k_i the stiffness of the field's own value in a cell, the part of the ghost penalty's factor that grows with
  the cell (MpmPhysics.ghost), over a tolerance. Shape functions that are nowhere negative then let the value of no
  material point fall either.

  Bounds at the points instead are more than there are unknowns. Those of a node's points then become active in turn:
  50 to 150 Newton iterations a step, where bounds at nodes take 3 to 4 (examples/slot_crack). As one bound an unknown
  they are an obstacle problem of a matrix close to an M-matrix, for which a semismooth Newton method, an active set of
  primal and dual variables, converges in a few iterations (Hintermueller, Ito, Kunisch 2003,
  doi:10.1137/S1052623401383558).

  Points carry the field: d_i,n follows from their values v_p and gradients as the start of the step does
  (point_to_node.c), and then, for coefficients of splines are no values at nodes, by Richardson's iteration

    d_i,n += sum_p w_p (v_p - sum_j phi_j(x_p) d_j,n) / sum_p w_p ,   w_p = phi_i(x_p) V_p

  whose fixed point has the points' values on average. Without it each step would widen the field a little. Points that
  have dissipated nothing have a value from the start alone, which need not be one of the grid's: it is no bound here.
  Points with that value have a bound of their own (physics/damage.c). Both would act at once, each or none by
  rounding, and Newton's iterations would not end: v_p of such points is less by the tolerance.
*/
#include <string.h>
#include "point/layout.h"
#include "point/material.h"
#include "grid/grid.h"
#include "particles/points.h"
#include "space/space.h"
#include "space/sum.h"
#include "assembly/sparsity.h"
#include "volume/irreversible.h"

#define SWEEPS 4 /* of Richardson's iteration */

static PetscErrorCode Reset(MpmHeldField *held)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(held->least, held->stiffness));
  held->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Place of a number of the scene among the values of a material, or -1. */
static PetscInt Place(const MpmPhysics *physics, const char name[])
{
  const MpmCommonParameter *common = physics->common;
  PetscInt                  place  = 0;

  for (int k = 0; k < physics->parameter_count; k++) place += MpmParameterPlaces(&physics->parameters[k]);
  for (int k = 0; k < physics->common_count; k++)
    if (!strcmp(common[k].parameter.name, name)) return place + k;
  return -1;
}

/* Place of a state among those of the physics' own, or -1. */
static PetscInt StatePlace(const MpmPhysics *physics, PetscInt dim, const char name[])
{
  const MpmStateVariable *states = physics->states;
  PetscInt                place  = 0;

  for (int s = 0; s < physics->state_count; s++) {
    if (!strcmp(states[s].name, name)) return place;
    place += MpmStateComponents(&states[s], dim);
  }
  return -1;
}

PetscErrorCode MpmHeldFieldCreate(const MpmPhysics *physics, PetscInt dim, MpmHeldField **held)
{
  const PetscInt irreversible = Place(physics, "irreversible"), tolerance = Place(physics, "tolerance");
  const PetscInt dissipated = StatePlace(physics, dim, "fracture_energy");

  PetscFunctionBeginUser;
  *held = NULL;
  if (irreversible < 0 || tolerance < 0 || dissipated < 0 || !physics->ghost) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscNew(held));
  (*held)->irreversible = irreversible;
  (*held)->tolerance    = tolerance;
  (*held)->dissipated   = dissipated;
  (*held)->start        = StatePlace(physics, dim, "damage_start");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmHeldFieldDestroy(MpmHeldField **held)
{
  PetscFunctionBeginUser;
  if (*held) PetscCall(Reset(*held));
  PetscCall(PetscFree(*held));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Component of the field among the unknowns of a node. */
static PetscInt Component(const MpmSum *sum)
{
  return sum->layout->rate.component[0];
}

/* Stiffness of a point's spring, by its volume. */
static PetscReal Hold(const MpmHeldField *held, const MpmSum *sum, PetscInt p)
{
  const MpmMaterial       *material = &sum->materials[sum->points->material[p]];
  const PetscReal         *value = material->physics_parameter, h = sum->cell[0];
  const MpmPhysicsMaterial of = MpmMaterialForPhysics(material, NULL, sum->layout->dim);

  if (value[held->irreversible] != 0.) return 0.;
  return (sum->layout->ghost(&of, value, 1., h) - sum->layout->ghost(&of, value, 1., 0.)) / (h * h) /
         value[held->tolerance];
}

/* Stiffness of the springs, from the points' own. Collective; `any`: a point has one, on any rank. */
static PetscErrorCode FindStiffness(MpmHeldField *held, const MpmSum *sum, const MpmPointValues *values,
                                    PetscReal hold[], PetscBool *any)
{
  PetscReal volume = MpmGridTurn(sum->grid, sum->grid->upper[0]), most = 0.;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < sum->space->dim; a++) volume *= sum->cell[a];
  for (PetscInt p = 0; p < sum->points->count; p++) {
    hold[p] = volume * Hold(held, sum, p);
    most    = PetscMax(most, hold[p]);
  }
  PetscCall(MPIU_Allreduce(MPI_IN_PLACE, &most, 1, MPIU_REAL, MPI_MAX, sum->grid->comm));
  *any = (PetscBool)(most > 0.);
  if (*any) PetscCall(MpmProjectToNodes(sum, &(MpmPointValues){values->shape, 1, 1, hold, NULL, 0}, held->stiffness));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* One sweep; `room` of the points. */
static PetscErrorCode Sharpen(const MpmSum *sum, const MpmPointValues *values, PetscReal least[], PetscReal room[])
{
  const PetscInt bs = sum->block, owned = sum->space->owned, c = Component(sum);
  PetscReal     *local, *change;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2((sum->space->local * bs), &local, owned, &change));
  for (PetscInt i = 0; i < owned; i++) local[i * bs + c] = least[i];
  PetscCall(MpmSpaceToGhosts(sum->space, bs, local));
  PetscCall(MpmRatesAtPoints(sum, local, room));
  for (PetscInt p = 0; p < sum->points->count; p++) room[p] = values->value[p] - room[p];
  PetscCall(MpmProjectToNodes(sum, &(MpmPointValues){values->shape, 1, 1, room, NULL, 0}, change));
  for (PetscInt i = 0; i < owned; i++) least[i] += change[i];
  PetscCall(PetscFree2(local, change));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Values of the points, and behind them their gradients. */
static void TakeValues(const MpmHeldField *held, const MpmSum *sum, PetscReal value[])
{
  const MpmPoints *points = sum->points;
  const PetscInt   dim = sum->space->dim, count = points->count;

  for (PetscInt p = 0; p < count; p++) {
    const PetscReal *own    = &points->physics.own[p * sum->kept.own];
    const PetscReal *number = sum->materials[points->material[p]].physics_parameter, v = points->physics.value[p];
    const PetscBool  counts    = (PetscBool)(own[held->dissipated] > 0.);
    const PetscBool  own_bound = (PetscBool)(held->start >= 0 && v > 0. && v <= own[held->start]);

    value[p] = !counts ? 0. : own_bound ? v - number[held->tolerance] : v;
    for (PetscInt a = 0; a < dim; a++)
      value[count + p * dim + a] = counts ? points->physics.value_gradient[p * dim + a] : 0.;
  }
}

static PetscErrorCode Prepare(void *ctx, const MpmTermStep *step)
{
  MpmHeldField  *held = (MpmHeldField *)ctx;
  const MpmSum  *sum  = step->sum;
  const PetscInt dim = sum->space->dim, count = sum->points->count;
  PetscReal     *room, *value;
  PetscBool      any;

  PetscFunctionBeginUser;
  PetscCall(Reset(held));
  PetscCall(PetscMalloc2(sum->space->owned, &held->least, sum->space->owned, &held->stiffness));
  PetscCall(PetscMalloc2(count, &room, (count * (dim + 1)), &value));
  const MpmPointValues values = {sum->layout->component[Component(sum)].shape, 1, 1, value, value + count, dim};

  PetscCall(FindStiffness(held, sum, &values, room, &any));
  if (any) {
    held->count = sum->space->owned;
    TakeValues(held, sum, value);
    PetscCall(MpmProjectToNodes(sum, &values, held->least));
    for (PetscInt k = 0; k < SWEEPS; k++) PetscCall(Sharpen(sum, &values, held->least, room));
  }
  PetscCall(PetscFree2(room, value));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscBool IsIdle(const void *ctx)
{
  return (PetscBool) !((const MpmHeldField *)ctx)->count;
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  const MpmHeldField *held = (const MpmHeldField *)ctx;
  const PetscInt      bs = sum->block, c = Component(sum);

  PetscFunctionBeginUser;
  (void)failed;
  for (PetscInt i = 0; i < held->count; i++)
    residual[i * bs + c] += held->stiffness[i] * PetscMin(u[i * bs + c] - held->least[i], 0.);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  const MpmHeldField *held = (const MpmHeldField *)ctx;
  const PetscInt      bs = sum->block, c = Component(sum);
  PetscReal           element[MPM_MAX_BLOCK * MPM_MAX_BLOCK];

  PetscFunctionBeginUser;
  if (residual) PetscCall(Residual(ctx, sum, u, residual, failed));
  for (PetscInt i = 0; i < held->count; i++) {
    if (u[i * bs + c] >= held->least[i]) continue;
    PetscCall(PetscArrayzero(element, bs * bs));
    element[c * bs + c] = held->stiffness[i];
    MpmPatternAddNodes(pattern, sum->space, 1, &i, element);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermIrreversible = {
  .name = "irreversible field", .idle = IsIdle, .prepare = Prepare, .residual = Residual, .tangent = Tangent};
