/*
  Values of fields at points, and their derivatives by the field's numbers. A point keeps the value of the place where
  it began.
*/
#include <math.h>
#include "geometry/geometry.h"
#include "ground/ground.h"

MpmGround *MpmGroundsFind(const MpmGrounds *fields, const char material[], const char parameter[])
{
  for (PetscInt f = 0; fields && f < fields->count; f++)
    if (!strcmp(fields->at[f].material, material) && !strcmp(fields->at[f].parameter, parameter)) return &fields->at[f];
  return NULL;
}

/* ---- places ---- */

static PetscInt CellOf(const MpmGround *field, const PetscReal x[])
{
  const MpmGroundGrid *grid = &field->grid;
  PetscInt             k    = 0;

  for (PetscInt a = grid->dim - 1; a >= 0; a--) {
    const PetscReal part = PetscFloorReal((x[a] - grid->lower[a]) / grid->h[a]);

    k = k * grid->cells[a] + (PetscInt)PetscMin(PetscMax(part, 0.), (PetscReal)(grid->cells[a] - 1));
  }
  return field->cell[k];
}

/* The first of the regions that holds a place. */
static PetscInt RegionOf(const MpmGround *field, const PetscReal x[])
{
  for (PetscInt k = 0; k < field->count; k++)
    if (MpmRegionContains(field->region[k], x)) return k;
  return -1;
}

/* By the body that an id is of; ids ascend from body to body. */
static PetscInt NumberOf(const MpmGround *field, PetscInt id)
{
  const MpmGroundBodies *bodies = &field->bodies;
  PetscInt               low = 0, high = bodies->count;

  while (low < high) {
    const PetscInt middle = (low + high) / 2;

    if (id >= bodies->end[middle]) low = middle + 1;
    else high = middle;
  }
  if (low == bodies->count || bodies->of[low] < 0) return -1;
  return bodies->of[low] + PetscMin((id - bodies->first[low]) / bodies->room, bodies->most[low] - 1);
}

PetscInt MpmGroundIndex(const MpmGround *field, const PetscReal x[], PetscInt id)
{
  switch (field->kind) {
  case MPM_GROUND_CELL:
    return CellOf(field, x);
  case MPM_GROUND_REGION:
    return RegionOf(field, x);
  case MPM_GROUND_PILOTS:
    return 0;
  default:
    return NumberOf(field, id);
  }
}

/* ---- values ---- */

PetscReal MpmGroundEvaluate(const MpmGround *field, const PetscReal x[], PetscInt id)
{
  PetscReal value;

  if (field->kind != MPM_GROUND_PILOTS) return field->value[PetscMax(MpmGroundIndex(field, x, id), 0)];
  value = MpmKrigingEvaluate(field->pilots.kriging, field->pilots.coefficient, x);
  return field->pilots.log ? PetscExpReal(value) : value;
}

void MpmGroundBounds(const MpmGround *field, PetscReal *least, PetscReal *most)
{
  *least = *most = field->value[0];
  for (PetscInt k = 1; k < field->count; k++) {
    *least = PetscMin(*least, field->value[k]);
    *most  = PetscMax(*most, field->value[k]);
  }
}

/* ---- derivatives ---- */

PetscErrorCode MpmGroundDirect(const MpmGround *field, const PetscReal change[], PetscReal direction[])
{
  PetscReal *z;

  PetscFunctionBeginUser;
  if (field->kind != MPM_GROUND_PILOTS) {
    PetscCall(PetscArraycpy(direction, change, field->count));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1(field->count, &z));
  for (PetscInt k = 0; k < field->count; k++) z[k] = field->pilots.log ? change[k] / field->value[k] : change[k];
  PetscCall(MpmKrigingFit(field->pilots.kriging, z, direction));
  PetscCall(PetscFree(z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The derivative of a point's value by that of its interpolation. */
static PetscReal Slope(const MpmGround *field, const PetscReal x[], PetscInt id)
{
  return field->pilots.log ? MpmGroundEvaluate(field, x, id) : 1.;
}

PetscReal MpmGroundAlong(const MpmGround *field, const PetscReal direction[], const PetscReal x[], PetscInt id)
{
  PetscInt k;

  if (field->kind == MPM_GROUND_PILOTS)
    return Slope(field, x, id) * MpmKrigingEvaluate(field->pilots.kriging, direction, x);
  k = MpmGroundIndex(field, x, id);
  return k < 0 ? 0. : direction[k];
}

void MpmGroundAdd(const MpmGround *field, const PetscReal x[], PetscInt id, PetscReal by, PetscReal sums[])
{
  PetscInt k;

  if (field->kind == MPM_GROUND_PILOTS) {
    MpmKrigingAdd(field->pilots.kriging, x, Slope(field, x, id) * by, sums);
    return;
  }
  k = MpmGroundIndex(field, x, id);
  if (k >= 0) sums[k] += by;
}

PetscErrorCode MpmGroundPull(const MpmGround *field, const PetscReal sums[], PetscReal gradient[])
{
  PetscReal *z;

  PetscFunctionBeginUser;
  if (field->kind != MPM_GROUND_PILOTS) {
    for (PetscInt k = 0; k < field->count; k++) gradient[k] += sums[k];
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscMalloc1(field->count, &z));
  PetscCall(MpmKrigingPull(field->pilots.kriging, sums, z));
  for (PetscInt k = 0; k < field->count; k++) gradient[k] += field->pilots.log ? z[k] / field->value[k] : z[k];
  PetscCall(PetscFree(z));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- life ---- */

static PetscErrorCode BodiesDestroy(MpmGroundBodies *bodies)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(bodies->first, bodies->end, bodies->of, bodies->most));
  bodies->count = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* First value of a body, -1 where it has none, and how many it has; `before` counts values of earlier bodies. */
static PetscInt FindBody(const MpmGroundOwners *owners, PetscInt b, PetscInt before, const MpmGround *field)
{
  if (field->kind == MPM_GROUND_POINT) return owners->own[b] ? before : -1;
  for (PetscInt k = 0; k < field->count; k++)
    if (!strcmp(field->names[k], owners->names[b])) return k;
  return -1;
}

PetscErrorCode MpmGroundSetBodies(const MpmGroundOwners *owners, MpmGround *field)
{
  MpmGroundBodies *bodies = &field->bodies;
  PetscInt         points = 0;

  PetscFunctionBeginUser;
  if (field->kind != MPM_GROUND_BODY && field->kind != MPM_GROUND_POINT) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(BodiesDestroy(bodies));
  bodies->count = owners->count;
  bodies->room  = owners->room;
  PetscCall(PetscMalloc4(owners->count, &bodies->first, owners->count, &bodies->end, owners->count, &bodies->of,
                         owners->count, &bodies->most));
  for (PetscInt b = 0; b < owners->count; b++) {
    bodies->first[b] = owners->first[b];
    bodies->end[b]   = owners->end[b];
    bodies->of[b]    = FindBody(owners, b, points, field);
    bodies->most[b]  = field->kind == MPM_GROUND_POINT ? owners->points[b] : 1;
    if (owners->own[b]) points += owners->points[b];
    MpmCheckInput(bodies->of[b] >= 0 || !owners->own[b],
                  "-mpm_field_%s_by body: has no value of body %s, of material %s", field->name, owners->names[b],
                  field->material);
  }
  for (PetscInt k = 0; field->kind == MPM_GROUND_BODY && k < field->count; k++) {
    PetscBool found = PETSC_FALSE;

    for (PetscInt b = 0; b < owners->count; b++) found = (PetscBool)(found || bodies->of[b] == k);
    for (PetscInt j = 0; j < k; j++)
      MpmCheckInput(strcmp(field->names[j], field->names[k]), "-mpm_field_%s_by body: has body %s twice", field->name,
                    field->names[k]);
    MpmCheckInput(found, "-mpm_field_%s_by body: there is no body %s", field->name, field->names[k]);
  }
  MpmCheckInput(field->kind == MPM_GROUND_BODY || points == field->count,
                "-mpm_field_%s_by point: has %" PetscInt_FMT " values, must have %" PetscInt_FMT
                ", one for each point of material %s at the start",
                field->name, field->count, points, field->material);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode DestroyOne(MpmGround *field)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(field->material));
  PetscCall(PetscFree(field->value));
  PetscCall(PetscFree(field->at));
  PetscCall(PetscFree(field->cell));
  PetscCall(PetscFree(field->pilots.coefficient));
  for (PetscInt k = 0; field->region && k < field->count; k++) PetscCall(MpmRegionDestroy(&field->region[k]));
  PetscCall(PetscFree(field->region));
  PetscCall(MpmNamesDestroy(field->count, &field->names));
  PetscCall(MpmKrigingDestroy(&field->pilots.kriging));
  PetscCall(BodiesDestroy(&field->bodies));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmGroundsDestroy(MpmGrounds **fields)
{
  PetscFunctionBeginUser;
  if (!*fields) PetscFunctionReturn(PETSC_SUCCESS);
  for (PetscInt f = 0; f < (*fields)->count; f++) PetscCall(DestroyOne(&(*fields)->at[f]));
  PetscCall(PetscFree((*fields)->at));
  PetscCall(MpmNamesDestroy((*fields)->count, &(*fields)->names));
  PetscCall(PetscFree(*fields));
  PetscFunctionReturn(PETSC_SUCCESS);
}
