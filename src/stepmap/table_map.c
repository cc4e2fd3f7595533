/*
  The points' part of a step's pull, with derivatives of their kernels from a table: L as in points_map.c.
*/
#include "stepmap/point_table.h"

/*
  Factors of each basis function b of the group's node i in the derivative of L by the point's weights: dL/dH u_i - q
  lam_i, and xbar . u_i for the weight.
*/
static void FindFactors(const MpmStepMap *map, PetscInt p, const MpmPointVector *end, const PetscReal by_input[],
                        MpmPointWork *work, PetscReal *factor[])
{
  const PetscInt dim = end->dim, n = work->known.n;

  MpmBasisZero(&work->slope, dim, n);
  for (PetscInt b = 0; b <= dim; b++) factor[b] = work->slope.basis[b];
  for (PetscInt k = 0; k < work->known.inputs; k++) {
    const PetscInt   c = KnownComponent(work->known, map->sum->layout, k) * n;
    const PetscReal *u = &work->u[c], *lam = &work->other[c];
    PetscReal       *to = factor[KnownBasis(work->known, map->sum->layout, k)];

    for (PetscInt i = 0; i < n; i++) to[i] += by_input[k] * u[i] - work->flux[k] * lam[i];
  }
  for (PetscInt a = 0; a < dim; a++)
    for (PetscInt i = 0; i < n; i++) factor[0][i] += end->x[p * dim + a] * work->u[a * n + i];
}

PetscErrorCode MpmTablePullWeights(const MpmStepMap *map, const MpmGroup *group, PetscInt p, const MpmPointVector *end,
                                   const PetscReal by_input[], MpmPointVector *start, MpmPointWork *work)
{
  const PetscInt dim = start->dim;
  PetscReal      by_length[MPM_MAX_DIM], *factor[1 + MPM_MAX_DIM];

  PetscFunctionBeginUser;
  PetscCall(MpmPointSlopesFind(map->rules, map->sum->points, group, p, &work->slopes));
  FindFactors(map, p, end, by_input, work, factor);
  for (PetscInt a = 0; a < dim; a++) {
    start->x[p * dim + a] += end->x[p * dim + a] + MpmPointSlopesSum(&work->slopes, group, MPM_BY_PLACE, a, factor);
    by_length[a] = work->slopes.domain ? MpmPointSlopesSum(&work->slopes, group, MPM_BY_LENGTH, a, factor) : 0.;
  }
  MpmPointSlopesPull(&work->slopes, start->F_size, by_length, &start->x[p * dim], &start->F[p * start->F_size], NULL);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTablePullSolution(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                    PetscReal u[])
{
  const MpmSum   *sum   = map->sum;
  const MpmSpace *space = sum->space;
  const PetscInt  packs = MpmPointTableInputPacks(map->table);
  MpmPointWork    work;

  PetscFunctionBeginUser;
  if (sum->layout->means) PetscFunctionReturn(MpmTableCellsPullSolution(map, end, lam, u));
  PetscCall(MpmPointWorkCreate(map, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, lam, &work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s], n = work.known.n;
      PetscReal      by_input[MPM_MAX_INPUTS + MPM_PACK];
      MpmKernelPoint point;

      MpmPointEnter(map, p, PETSC_TRUE, &work, &point);
      PetscCall(MpmPointTableFill(map, p, &point, end, &work));
      MpmPointTableTotals(map, p, packs, NULL, &work, by_input);
      MpmSumAddFlux(work.known, sum->layout, &work.basis, by_input, work.force);
      for (PetscInt a = 0; a < end->dim; a++)
        MpmBasisAddForce(&work.basis, n, end->x[p * end->dim + a], &work.force[a * n]);
    }
    MpmSumScatter(work.known, sum, group, work.force, u);
  }
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmTablePullStart(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                 MpmPointVector *start, PetscReal gradient[])
{
  const MpmPointTable *table = map->table;
  const MpmSpace      *space = map->sum->space;
  MpmPointWork         work;

  PetscFunctionBeginUser;
  if (map->sum->layout->means) PetscFunctionReturn(MpmTableCellsPullStart(map, end, lam, start, gradient));
  PetscCall(MpmPointWorkCreate(map, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, lam, &work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s];
      MpmKernelPoint point;

      MpmPointEnter(map, p, PETSC_TRUE, &work, &point);
      MpmPointTableTotals(map, p, MpmPointTablePacks(map, p), NULL, &work, table->totals);
      MpmPointTableAdd(map, p, table->totals, start, gradient);
      PetscCall(PetscArraycpy(work.flux, MpmPointTableFlux(table, p), table->inputs));
      PetscCall(MpmTablePullWeights(map, group, p, end, table->totals, start, &work));
    }
  }
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}
