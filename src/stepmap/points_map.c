/*
  The points' part of a step's derivatives.

  With H = sum_i u_i grad w_i of a point's inputs and K = sum_i lam_i grad w_i, a kernel's flux q(H, F, z, p), and F'
  and z' of the step's end, a point's part of L is

    L = xbar . (x + sum_i w_i u_i) + Fbar : F' + zbar . z' - q . K

  w and grad w depend on the place x and the half-lengths l(x, F) of the domain (space/point_slopes.h), all else on H,
  F, the history z and parameters p through the kernel's sensitivity form.

  Where the physics has means over cells m_bar_p = sum_c f_pc m_c (stepmap/step_means.h), tau_q = dm_q . K_q and M_c
  their means by volume, L has also - F_p M_bar_p, with F_p the flux conjugate to m_bar_p. A_p, the derivative of a
  point's part by m_bar_p, and F_p give a_c = sum_p f_pc A_p and g_c = sum_p f_pc F_p, and with these the derivatives by
  all that the means depend on,

    by m_q      V_q sum_c f_qc a_c/V_c             by tau_q  - V_q sum_c f_qc g_c/V_c
    by V_q      sum_c f_qc d_qc                    d_qc = (a_c (m_q - m_c) - g_c (tau_q - M_c))/V_c
    by f_qc     V_q d_qc + A_q m_c - F_q M_c

  Shares f depend on the place and the half-lengths of the domain, V on F of the step's start.
*/
#include "particles/points.h"
#include "stepmap/point_table.h"
#include "stepmap/step_means.h"

PetscErrorCode MpmStateVectorCreate(const MpmSum *sum, const MpmPoints *points, MpmStepConstants constants,
                                    MpmPointVector *vector)
{
  const PetscInt dim = sum->space->dim, rates = sum->layout->rate.count;
  const PetscInt size[MPM_VECTOR_FIELDS] = {[MPM_VECTOR_X]        = dim,
                                            [MPM_VECTOR_F]        = points->F_size,
                                            [MPM_VECTOR_STATE]    = sum->kept.state,
                                            [MPM_VECTOR_VALUE]    = rates,
                                            [MPM_VECTOR_GRADIENT] = rates * dim,
                                            [MPM_VECTOR_OWN]      = sum->kept.own,
                                            [MPM_VECTOR_ORIGIN]   = constants.resets ? dim : 0,
                                            [MPM_VECTOR_VOLUME]   = constants.shapes ? 1 : 0,
                                            [MPM_VECTOR_LENGTH] =
                                              constants.shapes && points->domain.half_length ? dim : 0,
                                            [MPM_VECTOR_MASS] = points->mass ? 1 : 0};

  PetscFunctionBeginUser;
  PetscCall(MpmPointVectorCreate(points, size, vector));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStageVectorCreate(const MpmStepMap *map, const MpmStageNumbers *bars, MpmPointVector *vector)
{
  const PetscInt rates = map->sum->layout->rate.count, count = map->sum->points->count, F = map->sum->points->F_size;
  PetscInt       size[MPM_VECTOR_FIELDS];
  MpmPointVector state = {0};

  PetscFunctionBeginUser;
  PetscCall(MpmStepVectorCreate(map, &state));
  PetscCall(PetscArraycpy(size, state.size, MPM_VECTOR_FIELDS));
  PetscCall(MpmPointVectorDestroy(&state));
  size[MPM_VECTOR_DEVIATION] = rates;
  PetscCall(MpmPointVectorCreate(map->sum->points, size, vector));
  if (!bars) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscArraycpy(vector->F, bars->F, count * F));
  PetscCall(PetscArraycpy(vector->at[MPM_VECTOR_VALUE], bars->value, count * rates));
  PetscCall(PetscArraycpy(vector->at[MPM_VECTOR_DEVIATION], bars->deviation, count * rates));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmStepVectorCreate(const MpmStepMap *map, MpmPointVector *vector)
{
  PetscFunctionBeginUser;
  PetscCall(MpmStateVectorCreate(map->sum, map->sum->points, map->constants, vector));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- visits ---- */

/* A point of a batch, where the physics has means: H and K in the rows, N numbers each. */
typedef struct {
  PetscReal m, volume, along, by_mean;
} MeanPoint;
enum { OF_M, OF_ALONG, BY_VOLUME = 2 }; /* means by volume */
enum { OF_FLUX, OF_MEAN, BY_SUM = 2 };  /* sums of F and A */

/* A pull under way: bars of the step's end; those of its start, or NULL in the first half. */
typedef struct {
  const MpmStepMap     *map;
  const MpmPointVector *end;
  const PetscReal      *lam;
  MpmPointVector       *start;
  PetscReal            *gradient;
  MpmPointWork          work;
  MpmBatch              batch;
  MpmMeans              means;
  MeanPoint            *mean;
  PetscReal            *inputs;
} Pull;

typedef PetscErrorCode (*Visit)(Pull *pull, const MpmGroup *group, PetscInt s);

/* All points of the batch; forces at their nodes are added to `force` unless it is NULL. */
static PetscErrorCode VisitPoints(Pull *pull, Visit visit, PetscReal force[])
{
  const MpmSpace *space = pull->map->sum->space;

  PetscFunctionBeginUser;
  for (PetscInt g = pull->batch.group_begin; g < pull->batch.group_end; g++) {
    const MpmGroup *group = &space->groups[g];

    MpmPointWorkGather(pull->map, group, pull->lam, &pull->work);
    for (PetscInt s = group->point_begin; s < group->point_end; s++) PetscCall((*visit)(pull, group, s));
    if (force) MpmSumScatter(pull->work.known, pull->map->sum, group, pull->work.force, force);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- means ---- */

/* H and K of the s-th point of the order, kept by the first visit. */
static PetscReal *Inputs(const Pull *pull, PetscInt s)
{
  return &pull->inputs[(s - pull->batch.point_begin) * 2 * pull->map->sum->layout->input.count];
}

static PetscErrorCode TakeMean(Pull *pull, const MpmGroup *group, PetscInt s)
{
  const MpmStepMap *map  = pull->map;
  MpmPointWork     *work = &pull->work;
  MeanPoint        *at   = &pull->mean[s - pull->batch.point_begin];
  const PetscInt    p = map->sum->space->order[s], N = work->known.inputs;
  const PetscReal  *m = MpmPointTableMean(map->table, p);
  MpmKernelPoint    point;

  PetscFunctionBeginUser;
  MpmPointEnter(map, p, PETSC_TRUE, work, &point);
  if (!pull->start) PetscCall(MpmPointTableFillMean(map, p, &point, work));
  PetscCall(PetscArraycpy(Inputs(pull, s), work->input, N));
  PetscCall(PetscArraycpy(Inputs(pull, s) + N, work->other_input, N));
  *at = (MeanPoint){.m = m[0], .volume = MpmSpreadVolume(map->sum, p)};
  for (PetscInt k = 0; k < N; k++) at->along += m[1 + k] * work->other_input[k];
  MpmMeansEnter(&pull->means, group, p, NULL);
  MpmMeansAddFirst(&pull->means, &at->volume, (PetscReal[BY_VOLUME]){[OF_M] = at->m, [OF_ALONG] = at->along});
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* F and A of a point; its table is filled in the first half. */
static PetscErrorCode TakeFlux(Pull *pull, const MpmGroup *group, PetscInt s)
{
  const MpmStepMap *map  = pull->map;
  MpmPointWork     *work = &pull->work;
  MeanPoint        *at   = &pull->mean[s - pull->batch.point_begin];
  const PetscInt    p = map->sum->space->order[s], N = work->known.inputs;
  MpmMeanPull       mean = {0};
  PetscReal         totals[MPM_MAX_INPUTS + MPM_PACK];
  MpmKernelPoint    point;

  PetscFunctionBeginUser;
  MpmMeansEnter(&pull->means, group, p, NULL);
  PetscCall(PetscArraycpy(work->other_input, Inputs(pull, s) + N, N));
  if (!pull->start) {
    PetscCall(PetscArraycpy(work->input, Inputs(pull, s), N));
    MpmMeansAt(&pull->means, 0, OF_M, &work->input[N]);
    MpmPointMake(map, p, work, &point);
    PetscCall(MpmPointTableFill(map, p, &point, pull->end, work));
  }
  MpmMeansAt(&pull->means, 0, OF_ALONG, &mean.along);
  MpmPointTableTotals(map, p, MpmPointTableInputPacks(map->table), &mean, work, totals);
  at->by_mean = totals[N];
  MpmMeansAddSecond(&pull->means,
                    (PetscReal[BY_SUM]){[OF_FLUX] = MpmPointTableFlux(map->table, p)[N], [OF_MEAN] = totals[N]});
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode TakeMeans(Pull *pull)
{
  PetscFunctionBeginUser;
  PetscCall(MpmMeansBegin(&pull->means));
  PetscCall(VisitPoints(pull, TakeMean, NULL));
  PetscCall(MpmMeansClose(&pull->means, 0));
  PetscCall(VisitPoints(pull, TakeFlux, NULL));
  PetscCall(MpmMeansClose(&pull->means, 1));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* The point enters, with its K, and the means as dL takes them: NULL without. */
static const MpmMeanPull *EnterMeans(Pull *pull, const MpmGroup *group, PetscInt s, MpmMeanPull *mean)
{
  const PetscInt N = pull->work.known.inputs;

  if (!pull->mean) return NULL;
  for (PetscInt k = 0; k < N; k++) pull->work.other_input[k] = Inputs(pull, s)[N + k];
  MpmMeansEnter(&pull->means, group, pull->map->sum->space->order[s], NULL);
  mean->share = pull->mean[s - pull->batch.point_begin].volume;
  MpmMeansAt(&pull->means, 1, OF_MEAN, &mean->by_mean);
  MpmMeansAt(&pull->means, 1, OF_FLUX, &mean->flux);
  MpmMeansAt(&pull->means, 0, OF_ALONG, &mean->along);
  return mean;
}

/* Adds dL by the point's volume, through its share of the means, and by its shares of cells, by half-lengths too. */
static void PullShares(Pull *pull, PetscInt s, PetscReal half[])
{
  const MpmStepMap *map      = pull->map;
  const MpmPoints  *points   = map->sum->points;
  const MpmMeans   *means    = &pull->means;
  const MeanPoint  *at       = &pull->mean[s - pull->batch.point_begin];
  const PetscInt    p        = map->sum->space->order[s];
  const PetscReal   flux     = MpmPointTableFlux(map->table, p)[pull->work.known.inputs];
  MpmPointVector   *start    = pull->start;
  PetscReal        *by_share = pull->means.by_share, cofactor[MPM_F_MAX], by_volume = 0.;

  for (PetscInt c = 0; c < means->at.count; c++) {
    const PetscReal m = MpmMeansOf(means, c, 0, OF_M), along = MpmMeansOf(means, c, 0, OF_ALONG);
    const PetscReal d =
      MpmMeansOf(means, c, 1, OF_MEAN) * (at->m - m) - MpmMeansOf(means, c, 1, OF_FLUX) * (at->along - along);

    by_volume += means->at.share[c] * d;
    by_share[c] = at->volume * d + at->by_mean * m - flux * along;
  }
  MpmMeansPullShares(means, p, by_share, &start->x[p * start->dim], half);
  if (start->size[MPM_VECTOR_VOLUME]) start->at[MPM_VECTOR_VOLUME][p] += by_volume * at->volume;
  (void)MpmCofactors(points->F_size, MpmPointF(points, p), cofactor);
  for (PetscInt k = 0; k < points->F_size; k++)
    start->F[p * points->F_size + k] += by_volume * points->volume0[p] * cofactor[k];
}

/* ---- solution ---- */

static PetscErrorCode PullSolution(Pull *pull, const MpmGroup *group, PetscInt s)
{
  const MpmStepMap     *map  = pull->map;
  MpmPointWork         *work = &pull->work;
  const MpmPointVector *end  = pull->end;
  const PetscInt        p = map->sum->space->order[s], n = work->known.n;
  PetscReal             by_input[MPM_MAX_INPUTS + MPM_PACK];
  MpmMeanPull           mean;
  MpmKernelPoint        point;

  PetscFunctionBeginUser;
  if (pull->mean) MpmSumBasis(work->known, map->sum->space, p, PETSC_TRUE, &work->basis);
  else {
    MpmPointEnter(map, p, PETSC_TRUE, work, &point);
    PetscCall(MpmPointTableFill(map, p, &point, end, work));
  }
  MpmPointTableTotals(map, p, MpmPointTableInputPacks(map->table), EnterMeans(pull, group, s, &mean), work, by_input);
  MpmSumAddFlux(work->known, map->sum->layout, &work->basis, by_input, work->force);
  for (PetscInt a = 0; a < end->dim; a++)
    MpmBasisAddForce(&work->basis, n, end->x[p * end->dim + a], &work->force[a * n]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- start ---- */

/*
  Factors of each basis function b of the group's node i in the derivative of L by the point's weights: dL/dH u_i - q
  lam_i, and xbar . u_i for the weight.
*/
static void FindFactors(const Pull *pull, PetscInt p, const PetscReal by_input[], PetscReal *factor[])
{
  const MpmPointWork *work   = &pull->work;
  const MpmLayout    *layout = pull->map->sum->layout;
  const PetscInt      dim = pull->end->dim, n = work->known.n;

  for (PetscInt b = 0; b < MPM_BASES; b++) {
    factor[b] = work->slope.basis[b];
    for (PetscInt i = 0; i < n; i++) factor[b][i] = 0.;
  }
  for (PetscInt k = 0; k < work->known.inputs; k++) {
    const PetscInt   c = KnownComponent(work->known, layout, k) * n;
    const PetscReal *u = &work->u[c], *lam = &work->other[c];
    PetscReal       *to = factor[KnownBasis(work->known, layout, k)];

    for (PetscInt i = 0; i < n; i++) to[i] += by_input[k] * u[i] - work->flux[k] * lam[i];
  }
  for (PetscInt i = 0; i < n; i++) factor[0][i] += factor[MPM_DEVIATION(dim)][i];
  for (PetscInt a = 0; a < dim; a++)
    for (PetscInt i = 0; i < n; i++) factor[0][i] += pull->end->x[p * dim + a] * work->u[a * n + i];
}

/* The sum of these factors times the derivatives of the basis functions by an argument; deviations count in the factors
   of the weights, too. */
static PetscReal SumSlopes(MpmPointWork *work, const MpmGroup *group, MpmSlopeKind kind, PetscInt axis,
                           PetscReal *factor[])
{
  const MpmSpace  *space = work->slopes.space;
  PetscReal        sum   = MpmPointSlopesSum(&work->slopes, group, kind, axis, factor);
  PetscReal *const means = work->basis.basis[MPM_DEVIATION(space->dim)];

  if (!space->shapes.at[0].mean) return sum;
  MpmPointSlopesMeans(&work->slopes, group, kind, axis, means);
  for (PetscInt i = 0; i < group->node_count; i++) sum -= means[i] * factor[MPM_DEVIATION(space->dim)][i];
  return sum;
}

/* dL by a point's place and F through its weights and shares: by_input are dL/dH, the whole fluxes in work->flux. */
static PetscErrorCode PullWeights(Pull *pull, const MpmGroup *group, PetscInt s, const PetscReal by_input[])
{
  MpmPointWork   *work  = &pull->work;
  MpmPointVector *start = pull->start;
  const PetscInt  p = pull->map->sum->space->order[s], dim = start->dim;
  PetscReal       half[MPM_MAX_DIM] = {0.}, *factor[MPM_BASES];

  PetscFunctionBeginUser;
  PetscCall(MpmPointSlopesFind(pull->map->rules, pull->map->sum->points, group, p, &work->slopes));
  FindFactors(pull, p, by_input, factor);
  for (PetscInt a = 0; a < dim; a++) {
    start->x[p * dim + a] += pull->end->x[p * dim + a] + SumSlopes(work, group, MPM_BY_PLACE, a, factor);
    if (work->slopes.domain) half[a] = SumSlopes(work, group, MPM_BY_LENGTH, a, factor);
  }
  if (pull->mean) PullShares(pull, s, half);
  MpmPointSlopesPull(&work->slopes, start->F_size, half, &start->x[p * dim], &start->F[p * start->F_size],
                     MpmPointNumbersIf(start, MPM_VECTOR_LENGTH, p));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode PullStart(Pull *pull, const MpmGroup *group, PetscInt s)
{
  const MpmStepMap  *map    = pull->map;
  MpmPointWork      *work   = &pull->work;
  const PetscInt     p      = map->sum->space->order[s];
  const PetscReal   *flux   = MpmPointTableFlux(map->table, p);
  PetscReal         *volume = MpmPointNumbersIf(pull->start, MPM_VECTOR_VOLUME, p), *totals = map->table->totals;
  MpmMeanPull        room;
  const MpmMeanPull *mean;
  MpmKernelPoint     point;

  PetscFunctionBeginUser;
  if (!pull->mean) MpmPointEnter(map, p, PETSC_TRUE, work, &point);
  mean = EnterMeans(pull, group, s, &room);
  MpmPointTableTotals(map, p, MpmPointTablePacks(map, p), mean, work, totals);
  MpmPointTableAdd(map, p, pull->end, work, totals, pull->start, pull->gradient);
  for (PetscInt k = 0; k < work->known.inputs; k++) {
    work->flux[k] = flux[k];
    if (volume) *volume -= flux[k] * work->other_input[k];
    if (mean) work->flux[k] += mean->share * mean->flux * MpmPointTableMean(map->table, p)[1 + k];
  }
  if (volume && mean) *volume -= flux[work->known.inputs] * mean->along;
  PetscCall(PullWeights(pull, group, s, totals));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- all points ---- */

static PetscErrorCode PullPoints(Pull *pull, Visit visit, PetscReal force[])
{
  const MpmStepMap *map   = pull->map;
  const PetscInt    means = map->sum->layout->means, most = means ? MpmBatchMost(map) : 0;

  PetscFunctionBeginUser;
  PetscCall(MpmPointWorkCreate(map, &pull->work));
  if (means) {
    PetscCall(MpmMeansCreate(map, 1, BY_VOLUME, BY_SUM, &pull->means));
    PetscCall(PetscMalloc2((most + 1), &pull->mean, (2 * most * map->sum->layout->input.count + 1), &pull->inputs));
  }
  for (PetscInt b = 0; b < MpmBatchCount(map); b++) {
    pull->batch = MpmBatchAt(map, b);
    if (means) PetscCall(TakeMeans(pull));
    PetscCall(VisitPoints(pull, visit, force));
  }
  if (means) {
    PetscCall(MpmMeansDestroy(&pull->means));
    PetscCall(PetscFree2(pull->mean, pull->inputs));
  }
  PetscCall(MpmPointWorkDestroy(&pull->work));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsPullSolution(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                     PetscReal u[])
{
  Pull pull = {.map = map, .end = end, .lam = lam};

  PetscFunctionBeginUser;
  PetscCall(PullPoints(&pull, PullSolution, u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MpmPointsPullStart(const MpmStepMap *map, const MpmPointVector *end, const PetscReal lam[],
                                  MpmPointVector *start, PetscReal gradient[])
{
  Pull pull = {.map = map, .end = end, .lam = lam, .start = start, .gradient = gradient};

  PetscFunctionBeginUser;
  PetscCall(PullPoints(&pull, PullStart, NULL));
  PetscFunctionReturn(PETSC_SUCCESS);
}
