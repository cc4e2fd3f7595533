/*
  Derivatives of the deviations at a step's start, of a physics with a rate.

  Nodes take the mean of the points' fields (space/point_to_node.c),

    u_i = sum_p w_pi f_pi / W_i ,   f_pi = v_p + g_p . (x_i - x_p) ,   w_pi = |phi_pi| V_p ,   W_i = sum_p w_pi ,

  and points the deviation d_p = sum_i D_pi u_i, D the weights less their means over the cell. With q_i = sum_p D_pi
  dbar_p / W_i the derivatives of sum_p dbar_p d_p are

    by u_i: W_i q_i ,   v_p: sum_i q_i w_pi ,   g_p: sum_i q_i w_pi (x_i - x_p) ,   w_pi: q_i (f_pi - u_i) ,
    D_pi: dbar_p u_i ,  x_p: -g_p sum_i q_i w_pi beside that by the weights.
*/
#include "grid/grid.h"
#include "space/point_loop.h"
#include "stepmap/point_work.h"
#include "watermap/water_map.h"

/* One point at its group's nodes. */
typedef struct {
  MpmPointWork work;
  PetscReal   *arm;            /* [a*n + i], from the point to the nodes, m */
  PetscReal   *value, *weight; /* f and w */
  PetscReal   *change[2];      /* of phi and D along a direction */
} Visit;

/* At the local nodes. */
typedef struct {
  PetscReal *u, *W;
} Nodes;

static PetscErrorCode VisitCreate(const MpmStepMap *map, Visit *visit)
{
  const PetscInt n = PetscPowInt(map->sum->space->width, map->sum->space->dim);

  PetscFunctionBeginUser;
  PetscCall(MpmPointWorkCreate(map, &visit->work));
  PetscCall(PetscMalloc5(n * MPM_MAX_DIM, &visit->arm, n, &visit->value, n, &visit->weight, n, &visit->change[0], n,
                         &visit->change[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode VisitDestroy(Visit *visit)
{
  PetscFunctionBeginUser;
  PetscCall(MpmPointWorkDestroy(&visit->work));
  PetscCall(PetscFree5(visit->arm, visit->value, visit->weight, visit->change[0], visit->change[1]));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void Enter(const MpmStepMap *map, const MpmGroup *group, PetscInt p, Visit *visit)
{
  const MpmSum    *sum      = map->sum;
  const MpmPoints *points   = sum->points;
  const PetscInt   n        = group->node_count;
  const PetscReal *gradient = &points->physics.value_gradient[p * sum->space->dim];
  PetscInt         first[MPM_MAX_DIM];

  MpmSumBasis(visit->work.known, sum->space, p, PETSC_TRUE, &visit->work.basis);
  MpmSpaceGroupAt(sum->space, group, first);
  for (PetscInt i = 0; i < n; i++) {
    PetscInt k = i;

    visit->value[i]  = points->physics.value[p];
    visit->weight[i] = PetscAbsReal(visit->work.basis.basis[0][i]) * points->volume0[p];
    for (PetscInt a = 0; a < sum->space->dim; k /= group->count[a], a++) {
      const PetscInt at = first[a] + k % group->count[a];

      visit->arm[a * n + i] = MpmGridNodeAt(sum->grid, a, at) - points->x[p * sum->space->dim + a];
      visit->value[i] += gradient[a] * visit->arm[a * n + i];
    }
  }
}

/* Nodal values, those of ghosts too; NodesDestroy() frees them. */
static PetscErrorCode NodesCreate(const MpmStepMap *map, Visit *visit, Nodes *nodes)
{
  const MpmSpace *space = map->sum->space;

  PetscFunctionBeginUser;
  PetscCall(PetscCalloc2(space->local + 1, &nodes->u, space->local + 1, &nodes->W));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];
    const PetscInt *node  = &space->group_nodes[group->node_offset];

    MpmPointWorkGather(map, group, NULL, &visit->work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      Enter(map, group, space->order[s], visit);
      for (PetscInt i = 0; i < group->node_count; i++) {
        nodes->u[node[i]] += visit->weight[i] * visit->value[i];
        nodes->W[node[i]] += visit->weight[i];
      }
    }
  }
  PetscCall(MpmSpaceAddToOwners(space, 1, nodes->u));
  PetscCall(MpmSpaceAddToOwners(space, 1, nodes->W));
  for (PetscInt i = 0; i < space->owned; i++) nodes->u[i] = nodes->W[i] > 0. ? nodes->u[i] / nodes->W[i] : 0.;
  PetscCall(MpmSpaceToGhosts(space, 1, nodes->u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode NodesDestroy(Nodes *nodes)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree2(nodes->u, nodes->W));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A rank's part of sums at the nodes becomes the means, those of ghosts too. */
static PetscErrorCode Divide(const MpmSpace *space, const Nodes *nodes, PetscReal sums[])
{
  PetscFunctionBeginUser;
  PetscCall(MpmSpaceAddToOwners(space, 1, sums));
  for (PetscInt i = 0; i < space->owned; i++) sums[i] = nodes->W[i] > 0. ? sums[i] / nodes->W[i] : 0.;
  PetscCall(MpmSpaceToGhosts(space, 1, sums));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscReal Sign(PetscReal value)
{
  return value < 0. ? -1. : 1.;
}

/* ---- along ---- */

/* The change of the point's weights. */
static PetscErrorCode WeightsAlong(const MpmStepMap *map, const MpmGroup *group, PetscInt p,
                                   const MpmPointVector *start, Visit *visit)
{
  const PetscInt   dim = start->dim, n = group->node_count, b[2] = {0, MPM_DEVIATION(dim)};
  const PetscReal *dx     = &start->x[p * dim];
  MpmPointSlopes  *slopes = &visit->work.slopes;
  PetscReal        half[MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(MpmPointSlopesFind(map->rules, map->sum->points, group, p, slopes));
  MpmPointSlopesAlong(slopes, start->F_size, dx, &start->F[p * start->F_size],
                      MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p), half);
  for (int c = 0; c < 2; c++) PetscCall(PetscArrayzero(visit->change[c], n));
  for (PetscInt k = 0; k < MPM_BY_COUNT * dim; k++) {
    const PetscReal change = k < dim ? dx[k] : half[k - dim];

    if (change == 0.) continue;
    MpmPointSlopesBasis(slopes, group, (MpmSlopeKind)(k / dim), k % dim, &visit->work.slope);
    for (int c = 0; c < 2; c++)
      for (PetscInt i = 0; i < n; i++) visit->change[c][i] += change * MpmBasisAt(&visit->work.slope, b[c], i);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* W du of the point's nodes, added. */
static void AddChange(const MpmStepMap *map, const MpmGroup *group, PetscInt p, const MpmPointVector *start,
                      const Nodes *nodes, const Visit *visit, PetscReal sums[])
{
  const PetscInt   dim = map->sum->space->dim, n = group->node_count;
  const PetscInt  *node     = &map->sum->space->group_nodes[group->node_offset];
  const PetscReal *gradient = &map->sum->points->physics.value_gradient[p * dim];
  const PetscReal  volume = map->sum->points->volume0[p], relative = MpmPointNumber(start, MPM_VECTOR_VOLUME, p);

  for (PetscInt i = 0; i < n; i++) {
    const PetscReal dw =
      Sign(visit->work.basis.basis[0][i]) * volume * visit->change[0][i] + relative * visit->weight[i];
    PetscReal df = *MpmPointNumbers(start, MPM_VECTOR_VALUE, p);

    for (PetscInt a = 0; a < dim; a++)
      df +=
        MpmPointNumbers(start, MPM_VECTOR_GRADIENT, p)[a] * visit->arm[a * n + i] - gradient[a] * start->x[p * dim + a];
    sums[node[i]] += dw * (visit->value[i] - nodes->u[node[i]]) + visit->weight[i] * df;
  }
}

PetscErrorCode MpmDeviationsAlong(const MpmStepMap *map, const MpmPointVector *start, PetscReal deviation[])
{
  const MpmSpace *space = map->sum->space;
  const PetscInt  D     = MPM_DEVIATION(space->dim);
  PetscReal      *du;
  Nodes           nodes;
  Visit           visit;

  PetscFunctionBeginUser;
  PetscCall(VisitCreate(map, &visit));
  PetscCall(NodesCreate(map, &visit, &nodes));
  PetscCall(PetscCalloc1(space->local + 1, &du));
  for (int pass = 0; pass < 2; pass++) {
    for (PetscInt g = 0; g < space->group_count; g++) {
      const MpmGroup *group = &space->groups[g];
      const PetscInt *node  = &space->group_nodes[group->node_offset];

      MpmPointWorkGather(map, group, NULL, &visit.work);
      for (PetscInt s = group->point_begin; s < group->point_end; s++) {
        const PetscInt p = space->order[s];

        Enter(map, group, p, &visit);
        PetscCall(WeightsAlong(map, group, p, start, &visit));
        if (!pass) AddChange(map, group, p, start, &nodes, &visit, du);
        else deviation[p] = 0.;
        for (PetscInt i = 0; pass && i < group->node_count; i++)
          deviation[p] += visit.change[1][i] * nodes.u[node[i]] + visit.work.basis.basis[D][i] * du[node[i]];
      }
    }
    if (!pass) PetscCall(Divide(space, &nodes, du));
  }
  PetscCall(PetscFree(du));
  PetscCall(NodesDestroy(&nodes));
  PetscCall(VisitDestroy(&visit));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pull ---- */

/* Of a point: dbar, and q at the local nodes. */
typedef struct {
  PetscReal        deviation;
  const PetscReal *q;
} Bars;

/* The derivative by an argument of the point's weights, whose derivatives stand in visit->work.slope. */
static PetscReal ByArgument(const MpmStepMap *map, const MpmGroup *group, PetscInt p, const Bars *bars,
                            const Nodes *nodes, const Visit *visit)
{
  const PetscInt *node = &map->sum->space->group_nodes[group->node_offset];
  const PetscInt  D    = MPM_DEVIATION(map->sum->space->dim);
  PetscReal       sum  = 0.;

  for (PetscInt i = 0; i < group->node_count; i++)
    sum += bars->q[node[i]] * (visit->value[i] - nodes->u[node[i]]) * Sign(visit->work.basis.basis[0][i]) *
             map->sum->points->volume0[p] * visit->work.slope.basis[0][i] +
           bars->deviation * nodes->u[node[i]] * visit->work.slope.basis[D][i];
  return sum;
}

static PetscErrorCode PullPoint(const MpmStepMap *map, const MpmGroup *group, PetscInt p, const Bars *bars,
                                const Nodes *nodes, Visit *visit, MpmPointVector *start)
{
  const PetscInt   dim = start->dim, n = group->node_count;
  const PetscInt  *node     = &map->sum->space->group_nodes[group->node_offset];
  const PetscReal *gradient = &map->sum->points->physics.value_gradient[p * dim];
  PetscReal        by_length[MPM_MAX_DIM];
  MpmPointSlopes  *slopes = &visit->work.slopes;

  PetscFunctionBeginUser;
  for (PetscInt i = 0; i < n; i++) {
    const PetscReal f = bars->q[node[i]] * visit->weight[i];

    *MpmPointNumbers(start, MPM_VECTOR_VALUE, p) += f;
    for (PetscInt a = 0; a < dim; a++) {
      MpmPointNumbers(start, MPM_VECTOR_GRADIENT, p)[a] += f * visit->arm[a * n + i];
      start->x[p * dim + a] -= f * gradient[a];
    }
    if (start->size[MPM_VECTOR_VOLUME]) start->at[MPM_VECTOR_VOLUME][p] += f * (visit->value[i] - nodes->u[node[i]]);
  }
  PetscCall(MpmPointSlopesFind(map->rules, map->sum->points, group, p, slopes));
  for (PetscInt a = 0; a < dim; a++) {
    MpmPointSlopesBasis(slopes, group, MPM_BY_PLACE, a, &visit->work.slope);
    start->x[p * dim + a] += ByArgument(map, group, p, bars, nodes, visit);
    MpmPointSlopesBasis(slopes, group, MPM_BY_LENGTH, a, &visit->work.slope);
    by_length[a] = ByArgument(map, group, p, bars, nodes, visit);
  }
  MpmPointSlopesPull(slopes, start->F_size, by_length, &start->x[p * dim], &start->F[p * start->F_size],
                     MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmDeviationsPull(const MpmStepMap *map, const PetscReal deviation[], MpmPointVector *start)
{
  const MpmSpace *space = map->sum->space;
  const PetscInt  D     = MPM_DEVIATION(space->dim);
  PetscReal      *q;
  Nodes           nodes;
  Visit           visit;

  PetscFunctionBeginUser;
  PetscCall(VisitCreate(map, &visit));
  PetscCall(NodesCreate(map, &visit, &nodes));
  PetscCall(PetscCalloc1(space->local + 1, &q));
  for (int pass = 0; pass < 2; pass++) {
    for (PetscInt g = 0; g < space->group_count; g++) {
      const MpmGroup *group = &space->groups[g];
      const PetscInt *node  = &space->group_nodes[group->node_offset];

      MpmPointWorkGather(map, group, NULL, &visit.work);
      for (PetscInt s = group->point_begin; s < group->point_end; s++) {
        const PetscInt p    = space->order[s];
        const Bars     bars = {deviation[p], q};

        Enter(map, group, p, &visit);
        for (PetscInt i = 0; !pass && i < group->node_count; i++)
          q[node[i]] += visit.work.basis.basis[D][i] * deviation[p];
        if (pass) PetscCall(PullPoint(map, group, p, &bars, &nodes, &visit, start));
      }
    }
    if (!pass) PetscCall(Divide(space, &nodes, q));
  }
  PetscCall(PetscFree(q));
  PetscCall(NodesDestroy(&nodes));
  PetscCall(VisitDestroy(&visit));
  PetscFunctionReturn(PETSC_SUCCESS);
}
