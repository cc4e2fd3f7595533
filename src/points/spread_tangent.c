/*
  The Jacobian as element blocks where means are by shares of the points' domains.

  With b_p the derivatives of point p's fluxes by its mean, o_p those of the mean's flux by the inputs, s_p that by the
  mean, and N_p the point's basis functions, the blocks of the points have for each cell c

    a_c m_c^T + m_c (o_c + sum_d S_cd m_d)^T ,   a_c = sum_p f_pc N_p b_p ,   o_c = sum_p f_pc N_p o_p ,
    m_c = sum_q f_qc V_q N_q dm_q / V_c ,   S_cd = sum_p f_pc f_pd s_p

  beside them. Of these m_c alone must have the points of all ranks: each rank adds what comes from its own a, o and S.
*/
#include "assembly/terms.h"
#include "points/element_group.h"
#include "points/spread_mean.h"

/* Vectors of the cells, by window, block values a node; products of shares by cells within the range. */
typedef struct {
  PetscInt   size[MPM_MAX_DIM], nodes, apart[MPM_MAX_DIM], pairs; /* of a window, and of a range */
  PetscReal *vector[3];                                           /* a, m, o */
  PetscReal *product;                                             /* S */
} Coupled;

static PetscErrorCode CoupledCreate(const MpmSum *sum, Coupled *coupled)
{
  const MpmSpread *spread = sum->space->cells.spread;
  size_t           length, pairs;

  PetscFunctionBeginUser;
  coupled->nodes = coupled->pairs = 1;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
    coupled->size[a]  = spread->lower[a] + spread->upper[a] + 1;
    coupled->apart[a] = 2 * spread->range[a] + 1;
    coupled->nodes *= coupled->size[a];
    coupled->pairs *= coupled->apart[a];
  }
  length = (size_t)sum->space->local * (size_t)(coupled->nodes * sum->block) + 1;
  pairs  = (size_t)sum->space->local * (size_t)coupled->pairs + 1;
  PetscCall(PetscCalloc4(length, &coupled->vector[0], length, &coupled->vector[1], length, &coupled->vector[2], pairs,
                         &coupled->product));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode CoupledDestroy(Coupled *coupled)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree4(coupled->vector[0], coupled->vector[1], coupled->vector[2], coupled->product));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Indices of a place in a box of count nodes. */
static void Unfold(const PetscInt count[], PetscInt place, PetscInt at[])
{
  at[0] = place % count[0];
  at[1] = place / count[0] % count[1];
  at[2] = place / (count[0] * count[1]);
}

static PetscInt Fold(const PetscInt count[], const PetscInt at[])
{
  return (at[2] * count[1] + at[1]) * count[0] + at[0];
}

/* Adds `factor` times a vector at the group's nodes, [c][i], to that of the cell at a place of the group's box. */
static void AddToCell(const MpmSum *sum, const Coupled *coupled, const MpmGroup *group, PetscInt cell, PetscReal factor,
                      const PetscReal part[], PetscReal vector[])
{
  const PetscInt *lower = sum->space->cells.spread->lower, n = group->node_count, bs = sum->block;
  PetscInt        from[MPM_MAX_DIM], at[MPM_MAX_DIM];

  Unfold(group->count, cell, from);
  for (PetscInt i = 0; i < n; i++) {
    Unfold(group->count, i, at);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) at[a] += lower[a] - from[a];
    for (PetscInt c = 0; c < bs; c++) vector[Fold(coupled->size, at) * bs + c] += factor * part[c * n + i];
  }
}

/* The point's part of all vectors and products of its cells; `part` has its own vectors a, m and o. */
static void AddPoint(const MpmSpreadWork *work, const Coupled *coupled, const MpmGroup *group, PetscInt p,
                     const PetscReal *const part[], PetscReal second)
{
  const PetscInt *range = work->sum->space->cells.spread->range, stride = coupled->nodes * work->sum->block;
  const PetscReal volume = MpmSpreadVolume(work->sum, p);
  MpmSpreadCells  cells;

  MpmSpreadFindCells(work->sum->space, group, p, &cells);
  for (PetscInt k = 0; k < cells.count; k++) {
    const PetscInt  i        = cells.node[k];
    const PetscReal factor[] = {cells.share[k], cells.share[k] * volume / work->volume[i], cells.share[k]};
    PetscInt        from[MPM_MAX_DIM], at[MPM_MAX_DIM];

    for (PetscInt v = 0; v < 3; v++)
      AddToCell(work->sum, coupled, group, cells.at[k], factor[v], part[v], &coupled->vector[v][i * stride]);
    Unfold(group->count, cells.at[k], from);
    for (PetscInt l = 0; l < cells.count; l++) {
      Unfold(group->count, cells.at[l], at);
      for (PetscInt a = 0; a < MPM_MAX_DIM; a++) at[a] += range[a] - from[a];
      coupled->product[i * coupled->pairs + Fold(coupled->apart, at)] += cells.share[k] * cells.share[l] * second;
    }
  }
}

/* The vectors of all cells: a and o of this rank's points, m of all. */
static PetscErrorCode FindVectors(const MpmSpreadWork *work, const Coupled *coupled)
{
  const MpmSum  *sum = work->sum;
  const PetscInt N = sum->layout->input.count, size = MpmTangentSize(sum->layout);
  const PetscInt room = PetscPowInt(sum->space->width, sum->space->dim) * sum->block;
  PetscReal     *part[3];

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc3(room, &part[0], room, &part[1], room, &part[2]));
  for (PetscInt g = 0; g < sum->space->group_count; g++) {
    const MpmGroup *group = &sum->space->groups[g];
    const MpmKnown  known = KnownGeneral(sum->layout, group);

    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const MpmTangent tangent = MpmTangentAt(N, &work->tangent[s * size]);

      MpmSumBasis(known, sum->space, sum->space->order[s], work->work.weights, &work->work.basis);
      for (PetscInt v = 0; v < 3; v++) PetscCall(PetscArrayzero(part[v], known.n * known.block));
      MpmSumAddFlux(known, sum->layout, &work->work.basis, tangent.by_mean, part[0]);
      MpmSumAddFlux(known, sum->layout, &work->work.basis, tangent.dm, part[1]);
      MpmSumAddFlux(known, sum->layout, &work->work.basis, tangent.of_mean, part[2]);
      AddPoint(work, coupled, group, sum->space->order[s], (const PetscReal *const *)part, tangent.second[0]);
    }
  }
  PetscCall(MpmSpreadSum(sum->space, coupled->nodes * sum->block, coupled->vector[1]));
  PetscCall(PetscFree3(part[0], part[1], part[2]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Adds `factor` times a vector of a window to one of the wider box, whose cell stands `apart` from the window's. */
static void AddToBox(const MpmSum *sum, const Coupled *coupled, const MpmGroup *box, const PetscInt apart[],
                     PetscReal factor, const PetscReal vector[], PetscReal to[])
{
  const PetscInt *range = sum->space->cells.spread->range, bs = sum->block;
  PetscInt        at[MPM_MAX_DIM];

  for (PetscInt w = 0; w < coupled->nodes; w++) {
    Unfold(coupled->size, w, at);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) at[a] += range[a] + apart[a];
    for (PetscInt c = 0; c < bs; c++) to[Fold(box->count, at) * bs + c] += factor * vector[w * bs + c];
  }
}

/* The products of one cell: `to` has room for three vectors of a box. */
static PetscErrorCode AddProducts(const MpmSum *sum, const Coupled *coupled, const MpmGroup *box, PetscReal *const to[],
                                  MpmPattern *pattern)
{
  const MpmSpread *spread = sum->space->cells.spread;
  const PetscInt  *nodes = &sum->space->group_nodes[box->node_offset], stride = coupled->nodes * sum->block;
  PetscInt         center[MPM_MAX_DIM], apart[MPM_MAX_DIM]                    = {0, 0, 0}, cell;

  PetscFunctionBeginUser;
  for (PetscInt a = 0; a < MPM_MAX_DIM; a++) center[a] = spread->lower[a] + spread->range[a];
  cell = nodes[Fold(box->count, center)];
  for (PetscInt v = 0; v < 3; v++) {
    PetscCall(PetscArrayzero(to[v], box->node_count * sum->block));
    AddToBox(sum, coupled, box, apart, 1., &coupled->vector[v][cell * stride], to[v]);
  }
  for (PetscInt k = 0; k < coupled->pairs; k++) {
    const PetscReal product = coupled->product[cell * coupled->pairs + k];
    PetscInt        at[MPM_MAX_DIM];

    if (product == 0.) continue;
    Unfold(coupled->apart, k, apart);
    for (PetscInt a = 0; a < MPM_MAX_DIM; a++) {
      apart[a] -= spread->range[a];
      at[a] = center[a] + apart[a];
    }
    AddToBox(sum, coupled, box, apart, product, &coupled->vector[1][nodes[Fold(box->count, at)] * stride], to[2]);
  }
  MpmPatternAddPair(pattern, sum->space, box, to[0], to[1], to[2]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode AddCells(const MpmSpreadWork *work, MpmPattern *pattern)
{
  const MpmSum    *sum    = work->sum;
  const MpmSpread *spread = sum->space->cells.spread;
  Coupled          coupled;
  PetscInt         room = 1;
  PetscReal       *to[3];

  PetscFunctionBeginUser;
  PetscCall(CoupledCreate(sum, &coupled));
  PetscCall(FindVectors(work, &coupled));
  for (PetscInt b = 0; b < spread->box_count; b++)
    room = PetscMax(room, sum->space->groups[spread->box_begin + b].node_count * sum->block);
  PetscCall(PetscMalloc3(room, &to[0], room, &to[1], room, &to[2]));
  for (PetscInt b = 0; b < spread->box_count; b++)
    PetscCall(AddProducts(sum, &coupled, &sum->space->groups[spread->box_begin + b], to, pattern));
  PetscCall(PetscFree3(to[0], to[1], to[2]));
  PetscCall(CoupledDestroy(&coupled));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpreadTangent(const MpmSum *sum, const PetscReal u[], MpmPattern *pattern, PetscReal residual[],
                                PetscInt *failed)
{
  const MpmSpace *space = sum->space;
  const PetscInt  most = PetscPowInt(space->width, space->dim), bs = sum->block;
  MpmSpreadWork   spread;
  Target          to = {.residual = residual, .coupling.spread = &spread};

  PetscFunctionBeginUser;
  PetscCall(MpmSpreadWorkCreate(sum, PETSC_TRUE, &spread));
  PetscCall(MpmSpreadEvaluate(&spread, u, NULL, failed));
  PetscCall(PetscMalloc2((most * most * bs * bs), &to.element, (most * bs * sum->layout->input.count), &to.rows));
  for (PetscInt g = 0; g < space->group_count; g++) {
    PetscCall(MpmElementGroup(sum, &space->groups[g], u, &spread.work, &to, failed));
    MpmPatternAddBlock(pattern, space, &space->groups[g], to.element);
  }
  PetscCall(AddCells(&spread, pattern));
  PetscCall(PetscFree2(to.element, to.rows));
  PetscCall(MpmSpreadWorkDestroy(&spread));
  PetscFunctionReturn(PETSC_SUCCESS);
}
