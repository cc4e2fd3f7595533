/*
  The points' part of a step's derivatives where means are by shares of the points' domains (points/spread_mean.c).

  With K_q = sum_i lam_i grad w_i, tau_q = dm_q . K_q and M_c = sum_q f_qc V_q tau_q/V_c the points' part of L is

    sum_p [ bars . (F'_p, z'_p) - q_p . K_p - F_p M_bar_p ] ,   M_bar_p = sum_c f_pc M_c .

  A_p, the derivative of a summand by m_bar_p, and F_p give a_c = sum_p f_pc A_p and g_c = sum_p f_pc F_p, and with
  these the derivatives by all that the means depend on,

    by m_q      V_q sum_c f_qc a_c/V_c             by tau_q  - V_q sum_c f_qc g_c/V_c
    by V_q      sum_c f_qc d_qc                    d_qc = (a_c (m_q - m_c) - g_c (tau_q - M_c))/V_c
    by f_qc     V_q d_qc + A_q m_c - F_q M_c

  Shares f depend on the place and the half-lengths of the domain, V on F of the step's start.
*/
#include "grid/grid.h"
#include "points/spread_mean.h"
#include "stepmap/point_work.h"

/* One point: its mean and derivatives, also along the direction; volume; flux of the mean. */
typedef struct {
  PetscReal m[2], dm[2][MPM_MAX_INPUTS], volume[2], flux[2][MPM_MAX_INPUTS], along, by_mean;
} SpreadPoint;

/* Points by their places in the order, and sums of the cells by their lower nodes. */
typedef struct {
  SpreadPoint *at;
  PetscReal   *sums; /* of the first pass, SUMS a cell */
  PetscReal   *flux; /* of the second, two a cell: g and its change, or a */
} Spread;
enum { VOLUME, DVOLUME, MOMENT, DMOMENT, SUMS, ALONG = DVOLUME }; /* ALONG: M_c, of a pull, which has no changes */

static PetscErrorCode SpreadCreate(const MpmStepMap *map, Spread *spread)
{
  const PetscInt local = map->sum->space->local;

  PetscFunctionBeginUser;
  PetscCall(PetscMalloc1((map->sum->space->point_count + 1), &spread->at));
  PetscCall(PetscCalloc2((local * SUMS + 1), &spread->sums, (local * 2 + 1), &spread->flux));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SpreadDestroy(Spread *spread)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(spread->at));
  PetscCall(PetscFree2(spread->sums, spread->flux));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* A point's own m and volume, with their changes along a direction. */
static PetscErrorCode TakeMean(const MpmStepMap *map, PetscInt p, const MpmKernelPoint *point,
                               const MpmKernelDirection *direction, const MpmPointWork *work, SpreadPoint *at)
{
  const MpmPoints *points = map->sum->points;
  PetscReal        cofactor[MPM_F_MAX];

  PetscFunctionBeginUser;
  PetscCheck(!map->sum->layout->kernel->mean_sensitivity(point, work->input, direction, at->m, at->dm[0], at->dm[1]),
             PETSC_COMM_SELF, PETSC_ERR_FP, "a point has no mean at the solution of its step");
  at->volume[0] = points->volume0[p] * MpmCofactors(points->F_size, MpmPointF(points, p), cofactor);
  at->volume[1] = 0.;
  for (PetscInt k = 0; direction->F_n && k < points->F_size; k++)
    at->volume[1] += points->volume0[p] * cofactor[k] * direction->F_n[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- shares ---- */

/* Parts of a point's domain by axis and cell, and their derivatives by place, 1/m, and half-length, 1/cell. */
typedef struct {
  PetscInt  count[MPM_MAX_DIM];
  PetscReal part[MPM_MAX_DIM][MPM_MAX_WIDTH], slope[MPM_MAX_DIM][MPM_MAX_WIDTH][MPM_BY_COUNT];
} Parts;

static void FindParts(const MpmStepMap *map, PetscInt p, Parts *parts)
{
  const MpmSpread *spread = map->sum->space->cells.spread;
  const MpmGrid   *grid   = map->sum->grid;
  const PetscInt   dim    = map->sum->space->dim;

  parts->count[2]   = 1;
  parts->part[2][0] = 1.;
  for (PetscInt a = 0; a < dim; a++) {
    const PetscInt  k = p * dim + a, low = spread->first[k], high = low + spread->count[k] - 1;
    const PetscReal xi = (map->sum->points->x[k] - grid->lower[a]) / grid->h[a], half = map->sum->space->shapes.half[k];

    parts->count[a] = spread->count[k];
    for (PetscInt c = low; c <= high; c++) {
      parts->part[a][c - low] = MpmShapePart(c, low, high, xi, half, parts->slope[a][c - low]);
      parts->slope[a][c - low][MPM_BY_PLACE] /= grid->h[a];
    }
  }
}

/* The derivative of share k by place or half-length on one axis. */
static PetscReal ShareSlope(const Parts *parts, PetscInt dim, PetscInt k, PetscInt axis, MpmSlopeKind kind)
{
  PetscReal product = 1.;

  for (PetscInt a = 0; a < dim; a++) {
    const PetscInt c = k % parts->count[a];

    k /= parts->count[a];
    product *= a == axis ? parts->slope[a][c][kind] : parts->part[a][c];
  }
  return product;
}

/* Changes of a point's shares; its weights have been differentiated. */
static void SharesAlong(const MpmStepMap *map, PetscInt p, PetscInt count, const MpmPointVector *start,
                        const MpmPointWork *work, PetscReal change[])
{
  const PetscInt   dim = map->sum->space->dim;
  const PetscReal *dx  = &start->x[p * start->dim];
  PetscReal        half[MPM_MAX_DIM];
  Parts            parts;

  FindParts(map, p, &parts);
  MpmPointSlopesAlong(&work->slopes, start->F_size, dx, &start->F[p * start->F_size],
                      MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p), half);
  for (PetscInt k = 0; k < count; k++) {
    change[k] = 0.;
    for (PetscInt a = 0; a < dim; a++)
      change[k] +=
        ShareSlope(&parts, dim, k, a, MPM_BY_PLACE) * dx[a] + ShareSlope(&parts, dim, k, a, MPM_BY_LENGTH) * half[a];
  }
}

/* ---- along ---- */

/* One point under way: as the kernel takes it, a direction, its cells, and the change of its shares. */
typedef struct {
  MpmKernelPoint     point;
  MpmKernelDirection direction;
  PetscReal          dinput[MPM_MAX_INPUTS]; /* of the direction, that of the mean last */
  MpmSpreadCells     cells;
  PetscReal          change[MPM_SPREAD_MOST];
  SpreadPoint       *at;
} Entered;

/* The point, and the change of its inputs but the mean. */
static PetscErrorCode EnterAlong(const MpmStepMap *map, const MpmGroup *group, PetscInt p,
                                 const MpmStepDirection *direction, MpmPointWork *work, Entered *at)
{
  const MpmPointVector    *start     = direction->start;
  const MpmSceneParameter *parameter = direction->parameter < 0 ? NULL : &map->parameters->at[direction->parameter];

  PetscFunctionBeginUser;
  MpmPointEnter(map, p, (PetscBool)(direction->du != NULL), work, &at->point);
  PetscCall(MpmPointWeightsAlong(map, group, p, start, work));
  MpmSumInputs(work->known, map->sum->layout, work->u, &work->slope, at->dinput);
  for (PetscInt k = 0; direction->du && k < work->known.inputs; k++) at->dinput[k] += work->other_input[k];
  at->dinput[work->known.inputs] = 0.;
  at->direction                  = (MpmKernelDirection){
                     .input = at->dinput, .state_n = &start->state[p * start->state_size], .F_n = &start->F[p * start->F_size]};
  if (parameter && MpmPointHasParameter(map, parameter, p)) {
    MpmPointSetDirection(map, parameter, 1., work);
    at->direction.parameter = work->parameter;
  }
  if (direction->ground && MpmPointGroundEnter(map, direction->ground, p, work))
    at->direction.parameter = work->parameter;
  MpmSpreadFindCells(map->sum->space, group, p, &at->cells);
  SharesAlong(map, p, at->cells.count, start, work, at->change);
  PetscFunctionReturn(PETSC_SUCCESS);
}

static void LeaveAlong(const MpmStepMap *map, const MpmStepDirection *direction, MpmPointWork *work)
{
  if (direction->parameter >= 0 && map->parameters->at[direction->parameter].kind == MPM_OF_LAW)
    MpmPointSetDirection(map, &map->parameters->at[direction->parameter], 0., work);
  if (direction->ground) MpmPointGroundForget(map, direction->ground, work);
}

/* First pass: volumes and moments of the cells. */
static PetscErrorCode MeansAlong(const MpmStepMap *map, PetscInt p, const MpmPointVector *start, Entered *entered,
                                 const MpmPointWork *work, Spread *spread)
{
  SpreadPoint *at = entered->at;

  PetscFunctionBeginUser;
  PetscCall(TakeMean(map, p, &entered->point, &entered->direction, work, at));
  at->volume[1] += at->volume[0] * MpmPointNumber(start, MPM_VECTOR_VOLUME, p);
  for (PetscInt k = 0; k < entered->cells.count; k++) {
    const PetscReal f = entered->cells.share[k], df = entered->change[k];
    const PetscReal volume = f * at->volume[0], change = df * at->volume[0] + f * at->volume[1];
    PetscReal      *sums = &spread->sums[entered->cells.node[k] * SUMS];

    sums[VOLUME] += volume;
    sums[DVOLUME] += change;
    sums[MOMENT] += volume * at->m[0];
    sums[DMOMENT] += change * at->m[0] + volume * at->m[1];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Second pass: fluxes and the step's end; moments have become means. */
static PetscErrorCode FluxesAlong(const MpmStepMap *map, PetscInt p, const MpmStepDirection *direction,
                                  Entered *entered, MpmPointWork *work, Spread *spread, MpmPointVector *end)
{
  const PetscInt N  = work->known.inputs;
  SpreadPoint   *at = entered->at;

  PetscFunctionBeginUser;
  work->input[N] = 0.;
  for (PetscInt k = 0; k < entered->cells.count; k++) {
    const PetscReal *sums = &spread->sums[entered->cells.node[k] * SUMS];

    work->input[N] += entered->cells.share[k] * sums[MOMENT];
    entered->dinput[N] += entered->change[k] * sums[MOMENT] + entered->cells.share[k] * sums[DMOMENT];
  }
  PetscCall(MpmPointDifferentiate(map, &entered->point, &entered->direction, work));
  MpmPointVolumeAlong(direction->start, p, work);
  PetscCall(PetscArraycpy(at->flux[0], work->flux, N + 1));
  PetscCall(PetscArraycpy(at->flux[1], work->dflux, N + 1));
  for (PetscInt k = 0; k < entered->cells.count; k++) {
    PetscReal *flux = &spread->flux[entered->cells.node[k] * 2];

    flux[0] += entered->cells.share[k] * work->flux[N];
    flux[1] += entered->change[k] * work->flux[N] + entered->cells.share[k] * work->dflux[N];
  }
  if (end) MpmPointEndAlong(map, p, direction, work, end);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Third pass: forces, with the means' part V f g/V_c dm of the fluxes; g has become g/V_c. */
static void ForcesAlong(const MpmStepMap *map, const Entered *entered, const Spread *spread, MpmPointWork *work)
{
  const SpreadPoint *at   = entered->at;
  PetscReal          mean = 0., change = 0.; /* sum f g/V_c */

  for (PetscInt k = 0; k < entered->cells.count; k++) {
    const PetscReal *flux = &spread->flux[entered->cells.node[k] * 2];

    mean += entered->cells.share[k] * flux[0];
    change += entered->change[k] * flux[0] + entered->cells.share[k] * flux[1];
  }
  for (PetscInt k = 0; k < work->known.inputs; k++) {
    work->flux[k]  = at->flux[0][k] + at->volume[0] * mean * at->dm[0][k];
    work->dflux[k] = at->flux[1][k] + (at->volume[1] * mean + at->volume[0] * change) * at->dm[0][k] +
                     at->volume[0] * mean * at->dm[1][k];
  }
  MpmSumAddFlux(work->known, map->sum->layout, &work->slope, work->flux, work->force);
  MpmSumAddFlux(work->known, map->sum->layout, &work->basis, work->dflux, work->force);
}

/* Passes over all points. */
enum { MEANS, FLUXES, FORCES };

static PetscErrorCode PassAlong(const MpmStepMap *map, const MpmStepDirection *direction, int pass, Spread *spread,
                                PetscReal residual[], MpmPointVector *end)
{
  const MpmSpace *space = map->sum->space;
  MpmPointWork    work;
  Entered         entered;

  PetscFunctionBeginUser;
  PetscCall(MpmPointWorkCreate(map, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, direction->du, &work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s];

      PetscCall(EnterAlong(map, group, p, direction, &work, &entered));
      entered.at = &spread->at[s];
      if (pass == MEANS) PetscCall(MeansAlong(map, p, direction->start, &entered, &work, spread));
      else if (pass == FLUXES) PetscCall(FluxesAlong(map, p, direction, &entered, &work, spread, end));
      else ForcesAlong(map, &entered, spread, &work);
      LeaveAlong(map, direction, &work);
    }
    if (pass == FORCES) MpmSumScatter(work.known, map->sum, group, work.force, residual);
  }
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmSpreadAlong(const MpmStepMap *map, const MpmStepDirection *direction, PetscReal residual[],
                              MpmPointVector *end)
{
  const MpmSpace *space = map->sum->space;
  Spread          spread;

  PetscFunctionBeginUser;
  PetscCall(SpreadCreate(map, &spread));
  PetscCall(PassAlong(map, direction, MEANS, &spread, NULL, NULL));
  PetscCall(MpmSpreadSum(space, SUMS, spread.sums));
  for (PetscInt i = 0; i < space->local; i++) {
    PetscReal *sums = &spread.sums[i * SUMS];

    if (!(sums[VOLUME] > 0.)) continue;
    sums[MOMENT] /= sums[VOLUME];
    sums[DMOMENT] = (sums[DMOMENT] - sums[MOMENT] * sums[DVOLUME]) / sums[VOLUME];
  }
  PetscCall(PassAlong(map, direction, FLUXES, &spread, NULL, end));
  PetscCall(MpmSpreadSum(space, 2, spread.flux));
  for (PetscInt i = 0; i < space->local; i++) {
    const PetscReal *sums = &spread.sums[i * SUMS];
    PetscReal       *flux = &spread.flux[i * 2];

    if (!(sums[VOLUME] > 0.)) continue;
    flux[0] /= sums[VOLUME];
    flux[1] = (flux[1] - flux[0] * sums[DVOLUME]) / sums[VOLUME];
  }
  PetscCall(PassAlong(map, direction, FORCES, &spread, residual, NULL));
  PetscCall(SpreadDestroy(&spread));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- pull ---- */

/* Sums over the cells of a point's domain, of numbers with so many a cell. */
static PetscReal Average(const MpmSpreadCells *cells, PetscInt stride, const PetscReal values[])
{
  PetscReal sum = 0.;

  for (PetscInt k = 0; k < cells->count; k++) sum += cells->share[k] * values[cells->node[k] * stride];
  return sum;
}

/* First pass: volumes, and moments of m and tau; second: A and F, and their sums a and g. */
static PetscErrorCode PassPull(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[], int pass,
                               Spread *spread)
{
  const MpmSpace *space                = map->sum->space;
  const PetscInt  N                    = map->sum->layout->input.count;
  PetscReal       unit[MPM_MAX_INPUTS] = {0.};
  MpmPointWork    work;
  MpmSpreadCells  cells;

  PetscFunctionBeginUser;
  unit[N] = 1.;
  PetscCall(MpmPointWorkCreate(map, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    MpmPointWorkGather(map, &space->groups[g], lam, &work);
    for (PetscInt s = space->groups[g].point_begin; s < space->groups[g].point_end; s++) {
      SpreadPoint   *at = &spread->at[s];
      MpmKernelPoint point;

      MpmPointEnter(map, space->order[s], PETSC_TRUE, &work, &point);
      MpmSpreadFindCells(space, &space->groups[g], space->order[s], &cells);
      if (pass == MEANS) {
        PetscCall(TakeMean(map, space->order[s], &point, &(MpmKernelDirection){0}, &work, at));
        at->along = 0.;
        for (PetscInt k = 0; k < N; k++) at->along += at->dm[0][k] * work.other_input[k];
        for (PetscInt k = 0; k < cells.count; k++) {
          PetscReal      *sums   = &spread->sums[cells.node[k] * SUMS];
          const PetscReal volume = cells.share[k] * at->volume[0];

          sums[VOLUME] += volume;
          sums[MOMENT] += volume * at->m[0];
          sums[ALONG] += volume * at->along;
        }
        continue;
      }
      work.input[N] = Average(&cells, SUMS, &spread->sums[MOMENT]);
      PetscCall(MpmPointDifferentiate(map, &point, &(MpmKernelDirection){.input = unit}, &work));
      PetscCall(PetscArraycpy(at->flux[0], work.flux, N + 1));
      at->by_mean = MpmPointContract(map, space->order[s], end, &work) -
                    work.dflux[N] * Average(&cells, SUMS, &spread->sums[ALONG]);
      for (PetscInt k = 0; k < cells.count; k++) {
        spread->flux[cells.node[k] * 2] += cells.share[k] * work.flux[N];
        spread->flux[cells.node[k] * 2 + 1] += cells.share[k] * at->by_mean;
      }
    }
  }
  PetscCall(MpmPointWorkDestroy(&work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* m_c and M_c into the sums, and g_c/V_c and a_c/V_c. */
static PetscErrorCode SumPull(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[], Spread *spread)
{
  const MpmSpace *space = map->sum->space;

  PetscFunctionBeginUser;
  PetscCall(PassPull(map, end, lam, MEANS, spread));
  PetscCall(MpmSpreadSum(space, SUMS, spread->sums));
  for (PetscInt i = 0; i < space->local; i++) {
    PetscReal *sums = &spread->sums[i * SUMS];

    if (!(sums[VOLUME] > 0.)) continue;
    sums[MOMENT] /= sums[VOLUME];
    sums[ALONG] /= sums[VOLUME];
  }
  PetscCall(PassPull(map, end, lam, FLUXES, spread));
  PetscCall(MpmSpreadSum(space, 2, spread->flux));
  for (PetscInt i = 0; i < space->local; i++)
    for (PetscInt k = 0; k < 2 && spread->sums[i * SUMS + VOLUME] > 0.; k++)
      spread->flux[i * 2 + k] /= spread->sums[i * SUMS + VOLUME];
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The point's means as dL takes them. */
static MpmMeanPull MeanPull(const Spread *spread, const SpreadPoint *at, const MpmSpreadCells *cells)
{
  return (MpmMeanPull){at->volume[0], Average(cells, 2, &spread->flux[1]), Average(cells, 2, spread->flux),
                       Average(cells, SUMS, &spread->sums[ALONG])};
}

PetscErrorCode MpmSpreadPullSolution(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                     PetscReal u[])
{
  const MpmSpace *space = map->sum->space;
  MpmPointWork    work;
  MpmSpreadCells  cells;
  Spread          spread;

  PetscFunctionBeginUser;
  PetscCall(SpreadCreate(map, &spread));
  PetscCall(SumPull(map, end, lam, &spread));
  PetscCall(MpmPointWorkCreate(map, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, lam, &work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const PetscInt p = space->order[s], n = work.known.n;
      PetscReal      by_input[MPM_MAX_INPUTS];
      MpmKernelPoint point;

      MpmPointEnter(map, p, PETSC_TRUE, &work, &point);
      MpmSpreadFindCells(space, group, p, &cells);
      const MpmMeanPull mean = MeanPull(&spread, &spread.at[s], &cells);

      work.input[work.known.inputs] = Average(&cells, SUMS, &spread.sums[MOMENT]);
      PetscCall(MpmPointPullInputs(map, p, &point, &(MpmPointPull){end, &mean}, by_input, &work));
      MpmSumAddFlux(work.known, map->sum->layout, &work.basis, by_input, work.force);
      for (PetscInt a = 0; a < end->dim; a++)
        MpmBasisAddForce(&work.basis, n, end->x[p * end->dim + a], &work.force[a * n]);
    }
    MpmSumScatter(work.known, map->sum, group, work.force, u);
  }
  PetscCall(MpmPointWorkDestroy(&work));
  PetscCall(SpreadDestroy(&spread));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* dL by a point's volume and shares: into F_n, and the place and half-lengths; its weights have been differentiated. */
static void PullShares(const MpmStepMap *map, PetscInt p, const SpreadPoint *at, const MpmSpreadCells *cells,
                       const Spread *spread, const MpmPointWork *work, MpmPointVector *start)
{
  const MpmPoints *points = map->sum->points;
  const PetscInt   dim = map->sum->space->dim, N  = work->known.inputs;
  PetscReal        cofactor[MPM_F_MAX], by_volume = 0., half[MPM_MAX_DIM] = {0., 0., 0.};
  Parts            parts;

  FindParts(map, p, &parts);
  for (PetscInt k = 0; k < cells->count; k++) {
    const PetscReal *sums = &spread->sums[cells->node[k] * SUMS], *flux = &spread->flux[cells->node[k] * 2];
    const PetscReal  d  = flux[1] * (at->m[0] - sums[MOMENT]) - flux[0] * (at->along - sums[ALONG]);
    const PetscReal  by = at->volume[0] * d + at->by_mean * sums[MOMENT] - at->flux[0][N] * sums[ALONG];

    by_volume += cells->share[k] * d;
    for (PetscInt a = 0; a < dim; a++) {
      start->x[p * dim + a] += by * ShareSlope(&parts, dim, k, a, MPM_BY_PLACE);
      half[a] += by * ShareSlope(&parts, dim, k, a, MPM_BY_LENGTH);
    }
  }
  MpmPointSlopesPull(&work->slopes, start->F_size, half, &start->x[p * dim], &start->F[p * start->F_size],
                     MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p));
  if (start->size[MPM_VECTOR_VOLUME]) start->at[MPM_VECTOR_VOLUME][p] += by_volume * at->volume[0];
  (void)MpmCofactors(points->F_size, MpmPointF(points, p), cofactor);
  for (PetscInt k = 0; k < points->F_size; k++)
    start->F[p * points->F_size + k] += by_volume * points->volume0[p] * cofactor[k];
}

PetscErrorCode MpmSpreadPullStart(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                  MpmPointVector *start, PetscReal gradient[])
{
  const MpmSpace *space = map->sum->space;
  MpmPointWork    work;
  MpmSpreadCells  cells;
  Spread          spread;

  PetscFunctionBeginUser;
  PetscCall(SpreadCreate(map, &spread));
  PetscCall(SumPull(map, end, lam, &spread));
  PetscCall(MpmPointWorkCreate(map, &work));
  for (PetscInt g = 0; g < space->group_count; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(map, group, lam, &work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) {
      const SpreadPoint *at = &spread.at[s];
      const PetscInt     p = space->order[s], N = work.known.inputs;
      PetscReal          by_input[MPM_MAX_INPUTS];
      MpmKernelPoint     point;

      MpmPointEnter(map, p, PETSC_TRUE, &work, &point);
      MpmSpreadFindCells(space, group, p, &cells);
      const MpmMeanPull  mean = MeanPull(&spread, at, &cells);
      const MpmPointPull pull = {end, &mean};

      work.input[N] = Average(&cells, SUMS, &spread.sums[MOMENT]);
      PetscCall(MpmPointPullInputs(map, p, &point, &pull, by_input, &work));
      PetscCall(MpmPointPullKernel(map, p, &point, &pull, start, gradient, &work));
      MpmPointPullVolume(at->flux[0], p, &work, start);
      if (start->size[MPM_VECTOR_VOLUME]) start->at[MPM_VECTOR_VOLUME][p] -= at->flux[0][N] * mean.along;
      for (PetscInt k = 0; k < N; k++) work.flux[k] = at->flux[0][k] + mean.share * mean.flux * at->dm[0][k];
      PetscCall(MpmPointPullWeights(map, group, p, end, by_input, start, &work));
      PullShares(map, p, at, &cells, &spread, &work, start);
    }
  }
  PetscCall(MpmPointWorkDestroy(&work));
  PetscCall(SpreadDestroy(&spread));
  PetscFunctionReturn(PETSC_SUCCESS);
}
