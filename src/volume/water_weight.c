/*
  The weight of the water that points have taken up with their volume since the start,

    f_i = sum_p phi_i rho_w (J - 1) V_0 g

  beside the load of gravity, which uses the points' initial mass. J is det F of the step's end by the point's own
  increment, 1 + tr(F - I) at small strain; the mean over a cell, F-bar's, gives the cell an equal weight. The
  derivative of a point is of rank one: a row phi_i g_a and a column d J / d u_j,b.
*/
#include "point/material.h"
#include "space/point_loop.h"
#include "assembly/sparsity.h"
#include "assembly/terms.h"
#include "volume/volume.h"

/* A point: row[a*n + i] and column[b*n + j] of the derivative, and the water's volume J - 1, factor of the row. */
typedef struct {
  PetscReal *row, *column, taken;
} Rank;

PetscReal MpmWaterVolume(const MpmSum *sum, PetscInt p, const PetscReal dF[], PetscReal by[], PetscReal by_F[])
{
  const PetscInt   dim = sum->space->dim, size = sum->points->F_size, hoop = size > dim * dim ? 1 : 0;
  const PetscReal *F_n = MpmPointF(sum->points, p);
  PetscReal        det, J = 1. - (PetscReal)(dim + hoop);

  if (sum->materials[sum->points->material[p]].info.traits & MPM_LAW_SMALL_STRAIN) {
    for (PetscInt k = 0; k < dim * dim; k++) {
      by[k] = F_n[k % dim * dim + k / dim];
      J += by[k] * dF[k];
      if (by_F) by_F[k % dim * dim + k / dim] = dF[k];
    }
    if (hoop && by_F) by_F[size - 1] = dF[size - 1];
    if (hoop) by[size - 1] = F_n[size - 1];
    return hoop ? J + by[size - 1] * dF[size - 1] : J;
  }
  det = MpmDeterminant(size, F_n);
  J   = MpmCofactors(size, dF, by);
  if (by_F) (void)MpmCofactors(size, F_n, by_F);
  for (PetscInt k = 0; k < size; k++) {
    by[k] *= det;
    if (by_F) by_F[k] *= J;
  }
  return det * J;
}

static void Evaluate(const MpmSum *sum, PetscInt p, PetscInt n, const MpmBasis *basis, const PetscReal values[],
                     Rank *rank)
{
  const MpmMaterial *material = &sum->materials[sum->points->material[p]];
  const PetscInt     dim      = sum->space->dim;
  const PetscReal    scale    = -material->physics_parameter[sum->layout->own.taken_up] * sum->points->volume0[p];
  const PetscBool    hoop     = (PetscBool)(sum->points->F_size > dim * dim);
  PetscReal          dF[MPM_MAX_DIM * MPM_MAX_DIM], by[MPM_MAX_DIM * MPM_MAX_DIM];

  for (PetscInt k = 0; k < dim * dim; k++)
    dF[k] = (k / dim == k % dim ? 1. : 0.) + MpmBasisDerivative(basis, n, k % dim, &values[k / dim * n]);
  if (hoop) dF[dim * dim] = 1. + MpmBasisHoop(basis, n, values);
  rank->taken = MpmWaterVolume(sum, p, dF, by, NULL) - 1.;
  for (PetscInt k = 0; k < dim * n; k++) rank->row[k] = rank->column[k] = 0.;
  for (PetscInt a = 0; a < dim; a++) {
    MpmBasisAddForce(basis, n, scale * sum->step.gravity[a], &rank->row[a * n]);
    for (PetscInt b = 0; b < dim; b++) MpmBasisAddFlux(basis, n, b, by[a * dim + b], &rank->column[a * n]);
  }
  if (hoop) MpmBasisAddHoop(basis, n, by[dim * dim], rank->column);
}

/* Results for the points, all optional: their forces, element blocks, diagonal blocks, or the action on du. */
typedef struct {
  PetscReal       *residual, *blocks, *y;
  const PetscReal *du;
  MpmPattern      *pattern;
} Wanted;

/* The sums of a group, and room for them. */
typedef struct {
  MpmWorkspace work;
  PetscReal   *element, *direction;
  Rank         rank;
} Room;

static void AddPoint(const MpmKnown known, const MpmGroup *group, const MpmSum *sum, const Wanted *wanted, Room *room)
{
  const PetscInt   n = known.n, bs = known.block, size = known.dim * n;
  const PetscReal *row = room->rank.row, *column = room->rank.column;
  const PetscInt  *nodes = &sum->space->group_nodes[group->node_offset];
  PetscReal        along = wanted->du ? 0. : room->rank.taken;

  for (PetscInt k = 0; wanted->du && k < size; k++) along += column[k] * room->direction[k];
  for (PetscInt k = 0; (wanted->du || wanted->residual) && k < size; k++) room->work.force[k] += along * row[k];
  for (PetscInt k = 0; wanted->pattern && k < size; k++)
    for (PetscInt l = 0; l < size; l++)
      room->element[((k % n * bs + k / n) * bs + l / n) * n + l % n] += row[k] * column[l];
  for (PetscInt k = 0; wanted->blocks && k < size; k++)
    for (PetscInt b = 0; b < known.dim; b++)
      wanted->blocks[(nodes[k % n] * bs + k / n) * bs + b] += row[k] * column[b * n + k % n];
}

static PetscErrorCode SumPoints(const MpmSum *sum, const PetscReal u[], const Wanted *wanted)
{
  const PetscInt most = PetscPowInt(sum->space->width, sum->space->dim), bs = sum->block;
  Room           room;

  PetscFunctionBeginUser;
  PetscCall(MpmWorkspaceCreate(sum, &room.work));
  PetscCall(PetscMalloc4((most * most * bs * bs), &room.element, (most * bs), &room.direction, (most * bs),
                         &room.rank.row, (most * bs), &room.rank.column));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    const MpmKnown  known = KnownGeneral(sum->layout, group);

    MpmSumGather(known, sum, group, u, room.work.values);
    if (wanted->du) MpmSumGather(known, sum, group, wanted->du, room.direction);
    PetscCall(PetscArrayzero(room.work.force, known.n * bs));
    if (wanted->pattern) PetscCall(PetscArrayzero(room.element, known.n * known.n * bs * bs));
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = sum->space->order[s];

      MpmSumBasis(known, sum->space, p, PETSC_TRUE, &room.work.basis);
      Evaluate(sum, p, known.n, &room.work.basis, room.work.values, &room.rank);
      AddPoint(known, group, sum, wanted, &room);
    }
    if (wanted->pattern) MpmPatternAddBlock(wanted->pattern, sum->space, group, room.element);
    if (wanted->residual) MpmSumScatter(known, sum, group, room.work.force, wanted->residual);
    if (wanted->y) MpmSumScatter(known, sum, group, room.work.force, wanted->y);
  }
  PetscCall(PetscFree4(room.element, room.direction, room.rank.row, room.rank.column));
  PetscCall(PetscFree(room.work.storage));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Nothing weighs anything without gravity. */
static PetscBool IsWeightless(const MpmSum *sum)
{
  for (PetscInt a = 0; a < sum->space->dim; a++)
    if (sum->step.gravity[a] != 0.) return PETSC_FALSE;
  return PETSC_TRUE;
}

static PetscErrorCode Residual(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal residual[],
                               PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)ctx, (void)failed;
  if (!IsWeightless(sum)) PetscCall(SumPoints(sum, u, &(Wanted){.residual = residual}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Tangent(const void *ctx, const MpmSum *sum, const PetscReal u[], MpmPattern *pattern,
                              PetscReal residual[], PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)ctx, (void)failed;
  if (!IsWeightless(sum)) PetscCall(SumPoints(sum, u, &(Wanted){.residual = residual, .pattern = pattern}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Apply(const void *ctx, const MpmSum *sum, const PetscReal u[], const PetscReal du[],
                            PetscReal y[])
{
  PetscFunctionBeginUser;
  (void)ctx;
  if (!IsWeightless(sum)) PetscCall(SumPoints(sum, u, &(Wanted){.du = du, .y = y}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode Diagonal(const void *ctx, const MpmSum *sum, const PetscReal u[], PetscReal blocks[],
                               PetscInt *failed)
{
  PetscFunctionBeginUser;
  (void)ctx, (void)failed;
  if (!IsWeightless(sum)) PetscCall(SumPoints(sum, u, &(Wanted){.blocks = blocks}));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const MpmTerm MpmTermWaterWeight = {
  .name = "weight of water", .residual = Residual, .tangent = Tangent, .apply = Apply, .diagonal = Diagonal};
